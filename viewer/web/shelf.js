/* SPDX-License-Identifier: Apache-2.0 */
/* A list of named things that the browser keeps, one for each scene: presets and views. */
import { h, iconButton } from './dom.js';
import { toast } from './notice.js';

export function readStorage(key) {
    try {
        return JSON.parse(localStorage.getItem(key));
    } catch {
        return null; /* forbidden, or not ours */
    }
}

export function writeStorage(key, value) {
    try {
        localStorage.setItem(key, JSON.stringify(value));
        return true;
    } catch {
        toast('The browser keeps nothing for this page: it is gone when the page is left.', true);
        return false;
    }
}

export class Shelf {
    #options;
    #key = null;
    #items = [];

    /* options: {key, what, form, input, list, take() -> thing, use(thing), isSound(thing)}. */
    constructor(options) {
        this.#options = options;
        options.form.addEventListener('submit', event => {
            event.preventDefault();
            this.#keep(options.input.value.trim());
        });
    }

    open(scene) {
        this.#key = `lumenaut.${this.#options.key}:${scene}`;
        const items = readStorage(this.#key);
        this.#items = Array.isArray(items) ? items.filter(item => typeof item?.name === 'string'
            && this.#options.isSound(item.thing)) : [];
        this.#draw();
    }

    #keep(name) {
        if (!name || this.#key === null) return;
        const { what, take, input } = this.#options;
        const others = this.#items.filter(item => item.name !== name);
        const isNew = others.length === this.#items.length;
        this.#items = [...others, { name, thing: structuredClone(take()) }];
        this.#save();
        input.value = '';
        toast(`${isNew ? 'Kept' : 'Replaced'} the ${what} "${name}".`);
    }

    #save() {
        writeStorage(this.#key, this.#items);
        this.#draw();
    }

    #draw() {
        const { list, what, use } = this.#options;
        list.replaceChildren(...this.#items.map(item => h('li', { 'data-item': item.name },
            h('button', { type: 'button', class: 'grow', 'data-action': 'use',
                          onclick: () => use(item.thing) }, item.name),
            iconButton('trash', `Delete the ${what} ${item.name}`, { 'data-action': 'delete' },
                       () => {
                           this.#items = this.#items.filter(other => other !== item);
                           this.#save();
                           this.#options.input.focus();
                       }))));
        list.hidden = this.#items.length === 0;
    }
}
