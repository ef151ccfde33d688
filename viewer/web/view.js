/* SPDX-License-Identifier: Apache-2.0 */
/* What is shown and how: mode, buffer, exposure, tone curve, size, share while moving. */
import { $, h } from './dom.js';
import { fixed, short } from './format.js';
import { holdWhileDown } from './slider.js';
import { PICTURES } from './protocol.js';
import { layerName } from './stage.js';

const radios = name => [...document.querySelectorAll(`input[type=radio][name=${name}]`)];

function fillSelect(select, names) {
    select.replaceChildren(...names.map(name => h('option', { value: name }, layerName(name))));
}

export class View {
    #store;
    #stage;

    constructor(store, stage) {
        this.#store = store;
        this.#stage = stage;
        const set = (view, how) => store.change({ view }, how);
        for (const radio of radios('mode')) {
            radio.addEventListener('change', () => set({ mode: radio.value }));
        }
        for (const radio of radios('tone')) {
            radio.addEventListener('change', () => set({ tone: radio.value }));
        }
        $('buffer').addEventListener('change', () => set({ buffer: $('buffer').value }));
        for (const side of ['left', 'right']) {
            const select = $(`split-${side}-layer`);
            select.addEventListener('change', () => set({ [side]: select.value }));
        }
        $('exposure-stops').addEventListener('input', () => {
            const factor = 2 ** $('exposure-stops').valueAsNumber;
            set({ exposure: Number(factor.toPrecision(4)) }, { moving: true });
        });
        holdWhileDown($('exposure-stops'), store);
        $('exposure').addEventListener('change', () => {
            const x = $('exposure').valueAsNumber;
            if (x > 0) set({ exposure: x });
            this.draw();
        });
        $('size').addEventListener('change', () => {
            const size = $('size').value;
            set({ size: size === 'own' ? stage.size() : size });
        });
        for (const id of ['size-width', 'size-height']) {
            $(id).addEventListener('change', () => {
                const now = stage.size();
                const pair = [$('size-width').valueAsNumber, $('size-height').valueAsNumber];
                set({ size: pair.map((n, k) => (Number.isFinite(n) ? n : now[k])) });
                this.draw();
            });
        }
        for (const id of ['rate', 'least']) {
            $(id).addEventListener('input', () => set({ [id]: $(id).valueAsNumber },
                                                      { keep: false }));
            $(id).addEventListener('change', () => store.commit());
        }
        store.listen(what => {
            if (what.view) this.draw();
        });
        new ResizeObserver(() => this.#drawSize()).observe($('stage'));
    }

    /* A server says what it can show. */
    greet() {
        const { layers } = this.#store.hello;
        const pictures = PICTURES.filter(name => layers.includes(name));
        const buffers = layers.filter(name => !PICTURES.includes(name));
        fillSelect($('buffer'), buffers);
        fillSelect($('split-left-layer'), pictures);
        fillSelect($('split-right-layer'), pictures);
        fillSelect($('capture-layer'), ['', ...pictures.filter(name => name !== 'error')]);
        $('capture-layer').options[0].textContent = 'What is shown';
        const modes = new Set([...pictures, ...(pictures.length > 1 ? ['split'] : []),
                               ...(buffers.length > 0 ? ['buffer'] : [])]);
        for (const radio of radios('mode')) {
            radio.disabled = !modes.has(radio.value);
            radio.parentElement.title = radio.disabled ? 'Not without a model' : '';
        }
        this.draw();
    }

    #drawSize() {
        if (this.#store.hello) $('size-now').textContent = this.#stage.size().join(' × ');
    }

    draw() {
        const { view } = this.#store;
        for (const name of ['mode', 'tone']) {
            for (const radio of radios(name)) radio.checked = radio.value === view[name];
        }
        $('context').dataset.mode = view.mode;
        for (const part of document.querySelectorAll('#context-mode > [data-for]')) {
            part.hidden = part.dataset.for !== view.mode;
        }
        $('buffer').value = view.buffer;
        $('split-left-layer').value = view.left;
        $('split-right-layer').value = view.right;
        const stops = Math.log2(view.exposure);
        if (document.activeElement !== $('exposure')) $('exposure').value = short(view.exposure);
        $('exposure-stops').value = stops;
        const text = `${fixed(stops, 1)} stops, factor ${short(view.exposure)}`;
        $('exposure-stops').setAttribute('aria-valuetext', text);
        const isOwn = Array.isArray(view.size);
        $('size').value = isOwn ? 'own' : view.size;
        $('size-own').hidden = !isOwn;
        const [width, height] = this.#stage.size();
        if (document.activeElement !== $('size-width')) $('size-width').value = width;
        if (document.activeElement !== $('size-height')) $('size-height').value = height;
        $('rate').value = view.rate;
        $('rate-now').textContent = view.rate;
        $('least').value = view.least;
        $('least-now').textContent = `${Math.round(view.least * 100)} %`;
        this.#drawSize();
    }
}
