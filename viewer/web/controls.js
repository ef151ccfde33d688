/* SPDX-License-Identifier: Apache-2.0 */
/* The controls that the scene's variables ask for: one for each group. */
import { $, h, icon, iconButton, onceAFrame } from './dom.js';
import { isDiscrete, title } from './format.js';
import { fromHex, toHex } from './color.js';
import { announce } from './notice.js';
import { holdWhileDown, makeNumber, makeRange } from './slider.js';
import { layPad, makePad } from './pad.js';

const RADIOS = 4; /* more choices than this become a list */
const MANY = 8; /* controls that are more than these can be searched */

/* Variables of one group and kind belong together; order is that of the scene. An object that both
 * moves and turns makes two controls. */
function groupsOf(variables) {
    const groups = new Map();
    variables.forEach((v, index) => {
        const name = v.group || v.name;
        const key = `${name} ${v.kind}`;
        if (!groups.has(key)) groups.set(key, { key, name, kind: v.kind, indices: [] });
        groups.get(key).indices.push(index);
    });
    return [...groups.values()];
}

/* A lone member says which it is: "Ball x". */
function labelOf({ name, indices }, variables) {
    if (indices.length > 1) return title(name);
    return title(variables[indices[0]].name.replaceAll('.', ' '));
}

const wordsOf = text => text.toLowerCase().split(/[\s_.,]+/).filter(Boolean);
const lastPart = name => title(name.split('.').pop());

export class Controls {
    #store;
    #root = $('controls');
    #updates = [];

    #locked = new Set(); /* keys of groups that randomising leaves alone */
    #groups = [];

    constructor(store) {
        this.#store = store;
        const update = onceAFrame(() => this.#updates.forEach(f => f()));
        store.listen(what => {
            if (what.values) update();
        });
        $('randomise').addEventListener('click', () => this.randomise());
        $('reset-all').addEventListener('click', () => store.resetAll());
        $('find').addEventListener('input', () => this.#find());
    }

    build() {
        this.#updates = [];
        this.#groups = groupsOf(this.#store.variables);
        this.#root.replaceChildren(...this.#groups.map(group => this.#control(group)));
        if (this.#groups.length === 0) {
            this.#root.append(h('p', { class: 'soft' }, 'This scene declares no variables.'));
        }
        $('find').hidden = this.#groups.length <= MANY;
        $('find').value = '';
    }

    /* Shows those that have words which begin with all that are looked for. */
    #find() {
        const wanted = wordsOf($('find').value);
        let n = 0;
        this.#groups.forEach((group, k) => {
            const variables = group.indices.map(i => this.#store.variables[i]);
            const words = wordsOf(variables.map(v => `${v.name} ${v.description}`).join(' '));
            const isFound = wanted.every(start => words.some(word => word.startsWith(start)));
            this.#root.children[k].hidden = !isFound;
            n += isFound;
        });
        announce(`${n} of ${this.#groups.length} controls`);
    }

    randomise() {
        const free = this.#groups.filter(group => !this.#locked.has(group.key));
        this.#store.randomise(free.flatMap(group => group.indices));
    }

    #control(group) {
        const { kind, indices } = group;
        const variables = indices.map(i => this.#store.variables[i]);
        const label = labelOf(group, this.#store.variables);
        const id = `name-${group.indices[0]}`;
        const n = indices.length;
        let parts = null;
        if (n === 1 && isDiscrete(variables[0])) parts = this.#discrete(indices[0], label);
        else if (n === 3 && kind === 'color') parts = this.#color(indices, label);
        else if (n > 1 && n < 4 && kind === 'translate') parts = this.#position(indices, label);
        else if (n === 1) parts = this.#single(indices[0], label);
        else parts = { body: indices.map(i => this.#member(i, label)) };

        const name = h(n === 1 ? 'span' : 'h3', { class: 'name', id }, label);
        const texts = new Set(variables.map(v => v.description).filter(Boolean));
        return h('div', {
            class: 'control', role: 'group', 'aria-labelledby': id,
            'data-group': group.name, 'data-kind': kind,
        }, h('div', { class: 'head' }, name, parts.head, this.#buttons(group, label)),
        parts.body, ...[...texts].map(text => h('p', { class: 'note' }, text)));
    }

    #buttons(group, label) {
        const store = this.#store;
        const reset = iconButton('reset', `Reset ${label}`, {
            'data-action': 'reset', 'data-group': group.name }, () => {
            store.change({ values: group.indices.map(i => [i, store.variables[i].value]) });
        });
        const lock = h('button', {
            type: 'button', class: 'plain', 'aria-pressed': String(this.#locked.has(group.key)),
            'aria-label': `Lock ${label}`, title: `Lock ${label}: not randomised`,
            'data-action': 'lock', 'data-group': group.name,
            onclick: () => {
                if (!this.#locked.delete(group.key)) this.#locked.add(group.key);
                draw();
            },
        });
        const draw = () => {
            const isLocked = this.#locked.has(group.key);
            lock.setAttribute('aria-pressed', String(isLocked));
            lock.replaceChildren(icon(isLocked ? 'lock' : 'unlock'));
        };
        draw();
        this.#updates.push(() => {
            /* Not disabled, which would drop the focus of who has just pressed it. */
            const isDefault = group.indices.every(i => store.isDefault(i));
            reset.setAttribute('aria-disabled', String(isDefault));
        });
        this.#updates.at(-1)();
        return h('span', { class: 'buttons' }, reset, lock);
    }

    #keep(part) {
        this.#updates.push(part.update);
        return part;
    }

    #single(index, label) {
        const number = this.#keep(makeNumber(this.#store, index, `${label}, number`));
        const range = this.#keep(makeRange(this.#store, index, label));
        return { head: number.nodes, body: range.element };
    }

    /* One of several: name, slider and box in a line. */
    #member(index, label, attributes) {
        const part = lastPart(this.#store.variables[index].name);
        const name = `${label} ${part}`;
        const range = this.#keep(makeRange(this.#store, index, name));
        const number = this.#keep(makeNumber(this.#store, index, `${name}, number`));
        return h('div', { class: 'member', ...attributes },
                 h('span', { class: 'member-name', 'aria-hidden': 'true' }, part), range.element,
                 number.nodes);
    }

    #position(indices, label) {
        const { across, along, rest } = layPad(this.#store, indices);
        const pad = this.#keep(makePad(this.#store, across, along, label));
        const boxes = [across, along].map(m => {
            const part = lastPart(this.#store.variables[m.index].name);
            const number = this.#keep(makeNumber(this.#store, m.index, `${label} ${part}, number`));
            return h('label', { class: 'pad-value' }, h('span', null, part), number.nodes);
        });
        const body = [h('div', { class: 'pad-row' }, pad.element,
                        h('div', { class: 'pad-values' }, boxes))];
        if (rest) body.push(this.#member(rest.index, label));
        return { body };
    }

    #color(indices, label) {
        const store = this.#store;
        const values = () => indices.map(i => store.values[i]);
        const picker = h('input', {
            type: 'color', 'data-color': store.variables[indices[0]].group,
            'aria-label': `${label}, colour`,
            oninput: () => {
                const linear = fromHex(picker.value);
                store.change({ values: indices.map((i, k) => [i, linear[k]]) }, { moving: true });
            },
            /* What the ranges did not allow is taken back when the picker closes. */
            onchange: () => { picker.value = toHex(values()); },
        });
        holdWhileDown(picker, store);
        const text = h('span', { class: 'unit hex' });
        const update = () => {
            const hex = toHex(values());
            text.textContent = hex;
            if (picker.value !== hex && document.activeElement !== picker) picker.value = hex;
        };
        this.#updates.push(update);
        update();
        const signs = ['r', 'g', 'b'];
        return {
            head: h('span', { class: 'value' }, picker, text),
            body: indices.map((i, k) => this.#member(i, label, { 'data-channel': signs[k] })),
        };
    }

    #discrete(index, label) {
        const variable = this.#store.variables[index];
        if (variable.kind === 'visible' && variable.choices.length === 2) {
            return { head: this.#toggle(index, label) };
        }
        if (variable.choices.length <= RADIOS && variable.choices.join('').length <= 30) {
            return { body: this.#radios(index, label) };
        }
        return { body: this.#list(index, label) };
    }

    #toggle(index, label) {
        const store = this.#store;
        const variable = store.variables[index];
        const input = h('input', {
            type: 'checkbox', role: 'switch', 'data-variable': variable.name,
            'aria-label': label,
            onchange: () => store.setValue(index, input.checked ? variable.max : variable.min),
        });
        const text = h('span', { 'aria-hidden': 'true' });
        this.#updates.push(() => {
            input.checked = store.values[index] > variable.min;
            text.textContent = variable.choices[Math.round(store.values[index] - variable.min)];
        });
        this.#updates.at(-1)();
        return h('label', { class: 'switch' }, text, input);
    }

    #radios(index, label) {
        const store = this.#store;
        const variable = store.variables[index];
        const inputs = variable.choices.map((choice, k) => h('input', {
            type: 'radio', name: `choice-${variable.name}`, value: choice,
            'data-variable': variable.name, 'data-choice': choice,
            onchange: () => store.setValue(index, variable.min + k),
        }));
        this.#updates.push(() => {
            const k = Math.round(store.values[index] - variable.min);
            inputs.forEach((input, i) => { input.checked = i === k; });
        });
        this.#updates.at(-1)();
        return h('div', { class: 'segments', role: 'radiogroup', 'aria-label': label },
                 inputs.map((input, k) => h('label', null, input,
                                            h('span', null, title(variable.choices[k])))));
    }

    #list(index, label) {
        const store = this.#store;
        const variable = store.variables[index];
        const select = h('select', {
            'data-variable': variable.name, 'aria-label': label,
            onchange: () => store.setValue(index, variable.min + select.selectedIndex),
        }, variable.choices.map(choice => h('option', { value: choice }, title(choice))));
        this.#updates.push(() => {
            select.selectedIndex = Math.round(store.values[index] - variable.min);
        });
        this.#updates.at(-1)();
        return select;
    }
}
