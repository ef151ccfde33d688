/* SPDX-License-Identifier: Apache-2.0 */
/* A slider and a number box for one variable. */
import { h } from './dom.js';
import { clamp, decimals, showValue, unitSign } from './format.js';

/* Steps of the arrow keys: a hundredth of the range, finer with Shift. */
export function keyStep(event, min, max) {
    const step = (max - min) / (event.shiftKey ? 1000 : 100);
    return {
        ArrowLeft: -step, ArrowDown: -step, ArrowRight: step, ArrowUp: step,
        PageUp: 10 * step, PageDown: -10 * step,
    }[event.key];
}

/* A pointer on `element` makes one step of undo of all that changes until it is lifted, wherever
 * that happens. */
export function holdWhileDown(element, store) {
    element.addEventListener('pointerdown', () => {
        store.begin();
        const up = () => {
            removeEventListener('pointerup', up);
            removeEventListener('pointercancel', up);
            store.end();
        };
        addEventListener('pointerup', up);
        addEventListener('pointercancel', up);
    });
}

export function makeNumber(store, index, label) {
    const variable = store.variables[index];
    const { min, max, name } = variable;
    let isEdited = false;
    const element = h('input', {
        type: 'number', min, max, step: 'any', 'data-variable': name, 'aria-label': label,
        inputmode: 'decimal', autocomplete: 'off',
        oninput: () => { isEdited = true; },
        onblur: () => {
            isEdited = false;
            update();
        },
        onchange: () => {
            const x = element.valueAsNumber;
            isEdited = false;
            if (Number.isFinite(x)) store.setValue(index, clamp(x, min, max));
            update();
        },
        onkeydown: event => {
            /* Boxes step by one otherwise, whatever the range. */
            const step = { ArrowUp: 1, ArrowDown: -1 }[event.key];
            if (!step) return;
            event.preventDefault();
            isEdited = false;
            store.setValue(index, store.values[index]
                + step * (max - min) / (event.shiftKey ? 1000 : 100), { moving: true });
        },
    });
    function update() {
        const text = showValue(variable, store.values[index]);
        if (!isEdited && element.value !== text) element.value = text;
    }
    update();
    const sign = unitSign(variable.unit);
    const nodes = h('span', { class: 'value' }, element,
                    sign ? h('span', { class: 'unit' }, sign) : null);
    element.style.width = `${Math.max(5.5, showWidth(variable) + 1.5)}ch`;
    return { element, nodes, update };
}

/* Characters of the longest number, so that boxes do not jump. */
function showWidth({ min, max }) {
    const d = decimals(min, max);
    return Math.max(min.toFixed(d).length, max.toFixed(d).length);
}

export function makeRange(store, index, label) {
    const variable = store.variables[index];
    const { min, max, name } = variable;
    const set = (x, how) => store.setValue(index, x, how);
    const element = h('input', {
        type: 'range', min, max, step: 'any', 'data-variable': name, 'aria-label': label,
        oninput: () => set(element.valueAsNumber, { moving: true }),
        onkeydown: event => {
            const step = keyStep(event, min, max);
            const end = { Home: min, End: max }[event.key];
            if (step === undefined && end === undefined) return;
            event.preventDefault();
            set(end ?? store.values[index] + step, { moving: true });
        },
    });
    holdWhileDown(element, store);
    let shown = NaN;
    function update() {
        const x = store.values[index];
        if (x === shown) return;
        shown = x;
        element.value = x;
        element.setAttribute('aria-valuetext',
                             `${showValue(variable, x)} ${variable.unit ?? ''}`.trim());
    }
    update();
    return { element, update };
}
