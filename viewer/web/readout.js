/* SPDX-License-Identifier: Apache-2.0 */
/* What is at a pixel: asked for when the pointer rests on the picture, all the time when switched
 * on, or by numbers. */
import { $, h } from './dom.js';
import { clamp, short } from './format.js';

const REST_MS = 500;
const PAUSE_MS = 100; /* between two questions */
const PATIENCE_MS = 2000; /* an answer that takes longer is lost */

const NAMES = { neural: 'Neural', traced: 'Traced', albedo: 'Albedo', normal: 'Normal',
                position: 'Position', wo: 'To the eye', roughness: 'Roughness', depth: 'Depth',
                shape: 'Shape' };

export class Readout {
    #connection;
    #stage;
    #store;
    #id = 0;
    #isAsking = false; /* a question is under way */
    #askedAt = -Infinity;
    #next = null; /* the pixel to ask for when the answer is there */
    #timer = 0;
    #rest = 0;

    constructor(connection, store, stage) {
        this.#connection = connection;
        this.#store = store;
        this.#stage = stage;
        const element = $('stage');
        element.addEventListener('pointermove', event => this.#hover(event));
        element.addEventListener('pointerleave', () => this.#leave());
        element.addEventListener('pointerdown', () => {
            clearTimeout(this.#rest);
            if (!this.isOn) this.#hide();
        });
        $('readout-on').addEventListener('change', () => {
            if (!this.isOn) this.#hide();
        });
        $('readout-go').addEventListener('click', () => {
            const x = $('readout-x').valueAsNumber, y = $('readout-y').valueAsNumber;
            this.#ask(Number.isFinite(x) ? x : 0, Number.isFinite(y) ? y : 0);
        });
        connection.addEventListener('message', ({ detail: m }) => {
            if (m.type === 'pixel') this.#answer(m);
        });
        connection.addEventListener('lost', () => { this.#isAsking = false; });
    }

    get isOn() {
        return $('readout-on').checked;
    }

    toggle() {
        $('readout-on').click();
    }

    #hover(event) {
        clearTimeout(this.#rest);
        if (event.buttons !== 0 || !this.#store.hello) return;
        const r = this.#stage.rect;
        const u = (event.clientX - r.left) / r.width, v = (event.clientY - r.top) / r.height;
        if (u < 0 || v < 0 || u >= 1 || v >= 1) {
            this.#leave();
            return;
        }
        const [w, height] = this.#stage.size();
        const ask = () => this.#ask(Math.floor(u * w), Math.floor(v * height));
        if (this.isOn) ask();
        else {
            this.#hide();
            this.#rest = setTimeout(ask, REST_MS);
        }
    }

    #leave() {
        clearTimeout(this.#rest);
        this.#next = null;
        if (!this.isOn) this.#hide();
    }

    #hide() {
        $('readout').hidden = true;
    }

    #ask(x, y) {
        const [w, height] = this.#stage.size();
        this.#next = { x: clamp(Math.floor(x), 0, w - 1), y: clamp(Math.floor(y), 0, height - 1) };
        this.#pump();
    }

    /* One question at a time, the newest. */
    #pump() {
        const now = performance.now();
        const isWaiting = this.#isAsking && now - this.#askedAt < PATIENCE_MS;
        if (!this.#next || isWaiting) return;
        clearTimeout(this.#timer);
        const pause = this.#askedAt + PAUSE_MS - now;
        if (pause > 0) {
            this.#timer = setTimeout(() => this.#pump(), pause);
            return;
        }
        this.#id++;
        this.#isAsking = this.#connection.send({ type: 'pixel', id: this.#id, ...this.#next });
        this.#askedAt = now;
        this.#next = null;
    }

    #answer(m) {
        if (m.id !== this.#id) return;
        this.#isAsking = false;
        this.#pump();
        const rows = Object.entries(m.values ?? {}).map(([key, list]) => {
            const numbers = (Array.isArray(list) ? list : [list]).map(x => short(x, 4));
            return h('div', { 'data-value': key }, h('dt', null, NAMES[key] ?? key),
                     h('dd', null, numbers.map(n => h('span', null, n))));
        });
        const out = $('readout');
        out.replaceChildren(h('div', { class: 'where' }, h('dt', null, 'Pixel'),
                              h('dd', null, `${m.x}, ${m.y}`)), ...rows);
        out.hidden = false;
        $('readout-x').value = m.x;
        $('readout-y').value = m.y;
    }
}
