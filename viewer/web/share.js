/* SPDX-License-Identifier: Apache-2.0 */
/* The state in the page's address: what differs from the defaults, and nothing else. */
import { DEFAULT_VIEW, isCamera } from './store.js';

const DELAY_MS = 300; /* browsers refuse addresses that change all the time */
const VARIABLE = 'P.'; /* as the command line's -P; keeps names apart from ours */

function cameraText(c) {
    return [...c.origin, ...c.target, ...c.up, c.fov].join(',');
}

function readCamera(text) {
    const n = text.split(',').map(Number);
    const camera = { origin: n.slice(0, 3), target: n.slice(3, 6), up: n.slice(6, 9), fov: n[9] };
    return n.length === 10 && isCamera(camera) ? camera : undefined;
}

export function writeHash(store) {
    const words = new URLSearchParams();
    store.variables.forEach((v, i) => {
        if (!store.isDefault(i)) words.set(VARIABLE + v.name, store.values[i]);
    });
    if (store.camera) words.set('camera', cameraText(store.camera));
    for (const [key, value] of Object.entries(store.view)) {
        if (JSON.stringify(value) === JSON.stringify(DEFAULT_VIEW[key])) continue;
        words.set(key, Array.isArray(value) ? value.join('x') : value);
    }
    return words.toString();
}

/* The whole state that an address stands for: defaults where it says nothing. */
export function readHash(text, store) {
    const words = new URLSearchParams(text);
    const saved = {
        values: Object.fromEntries(store.variables.map(v => [v.name, v.value])),
        camera: null,
        view: { ...DEFAULT_VIEW },
    };
    for (const [key, value] of words) {
        if (key.startsWith(VARIABLE)) {
            const x = Number(value);
            if (Number.isFinite(x)) saved.values[key.slice(VARIABLE.length)] = x;
        } else if (key === 'camera') {
            saved.camera = readCamera(value) ?? null;
        } else if (key === 'size' && /^\d+x\d+$/.test(value)) {
            saved.view.size = value.split('x').map(Number);
        } else if (Object.hasOwn(DEFAULT_VIEW, key)) {
            const isNumber = typeof DEFAULT_VIEW[key] === 'number';
            saved.view[key] = isNumber ? Number(value) : value;
        }
    }
    return saved;
}

export class Share {
    #store;
    #timer = 0;
    #written = null;
    #token = new URLSearchParams(location.hash.slice(1)).get('token');

    constructor(store) {
        this.#store = store;
        store.listen(() => {
            clearTimeout(this.#timer);
            this.#timer = setTimeout(() => this.#write(), DELAY_MS);
        });
        addEventListener('hashchange', () => {
            const hash = location.hash.slice(1);
            if (hash === this.#written || !store.hello) return;
            store.load(readHash(hash, store));
        });
    }

    /* A link that somebody gave: what it says holds from the first picture on. */
    greet() {
        const hash = location.hash.slice(1);
        if (hash && hash !== this.#written) this.#store.load(readHash(hash, this.#store));
    }

    #write() {
        if (!this.#store.hello) return;
        let hash = writeHash(this.#store);
        if (this.#token) hash = `${new URLSearchParams({ token: this.#token })}&${hash}`;
        if (hash === this.#written) return;
        this.#written = hash;
        history.replaceState(null, '', hash ? `#${hash}`
            : location.pathname + location.search);
    }

    link() {
        clearTimeout(this.#timer);
        this.#write();
        return location.href;
    }
}
