/* SPDX-License-Identifier: Apache-2.0 */
/* Moves the camera by pointer, touch, wheel and keys on the picture. */
import { $ } from './dom.js';
import { basis, cameraOfValues, diagonal, look, move, orbit, pan, worldUp, zoom }
    from './camera.js';
import { add, length, normalize, scale } from './vec.js';

const KEY_TURN = Math.PI / 36;
const KEY_PAN = 0.04;
const FLY = { w: 'forward', s: 'back', a: 'left', d: 'right', e: 'up', q: 'down' };

export class Navigation {
    #store;
    #session;
    #stage = $('stage');
    #pointers = new Map(); /* pointerId -> {x, y} */
    #button = 0;
    #keys = new Set();
    #isFast = false;
    #flying = 0;
    #flownAt = 0;

    dragMode = 'orbit';
    speed = 10 ** -0.6; /* scene diagonals a second */

    constructor(store, session) {
        this.#store = store;
        this.#session = session;
        const s = this.#stage;
        s.addEventListener('pointerdown', event => this.#down(event));
        s.addEventListener('pointermove', event => this.#move(event));
        for (const name of ['pointerup', 'pointercancel']) {
            s.addEventListener(name, event => this.#up(event));
        }
        s.addEventListener('wheel', event => this.#wheel(event), { passive: false });
        s.addEventListener('contextmenu', event => event.preventDefault());
        for (const name of ['keydown', 'keyup']) {
            addEventListener(name, event => { this.#isFast = event.shiftKey; });
        }
        addEventListener('keyup', event => this.#keys.delete(event.key.toLowerCase()));
        addEventListener('blur', () => this.#keys.clear());
        s.addEventListener('blur', () => this.#keys.clear());
    }

    get camera() {
        const { camera, hello, values } = this.#store;
        return camera ?? this.#session.toldCamera() ?? cameraOfValues(hello, values);
    }

    #set(camera) {
        this.#store.change({ camera }, { moving: true });
    }

    #drag(mode, dx, dy, width) {
        const { hello } = this.#store;
        const w = worldUp(hello);
        if (mode === 'pan') this.#set(pan(this.camera, dx / width, dy / width, hello));
        else if (mode === 'look') {
            this.#set(look(this.camera, dx / width * 2, dy / width * 2, w));
        } else this.#set(orbit(this.camera, -dx / width * 5, dy / width * 5, w));
    }

    #down(event) {
        if (!this.#store.hello || event.target.closest('#split-handle, #readout')) return;
        this.#stage.focus({ preventScroll: true });
        this.#stage.setPointerCapture(event.pointerId);
        if (this.#pointers.size === 0) {
            this.#button = event.button;
            this.#store.begin();
        }
        this.#pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
        event.preventDefault();
    }

    #move(event) {
        const last = this.#pointers.get(event.pointerId);
        if (!last) return;
        const now = { x: event.clientX, y: event.clientY };
        const dx = now.x - last.x, dy = now.y - last.y;
        if (dx === 0 && dy === 0) return;
        const width = $('frame').clientWidth || 1;
        if (this.#pointers.size === 1) {
            this.#pointers.set(event.pointerId, now);
            const isPan = this.#button === 2 || event.shiftKey;
            this.#drag(isPan ? 'pan' : this.#button === 1 ? 'look' : this.dragMode, dx, dy,
                       width);
            return;
        }
        /* Two fingers: their middle pans, their distance zooms. */
        const other = [...this.#pointers].find(([id]) => id !== event.pointerId)[1];
        const before = Math.hypot(last.x - other.x, last.y - other.y);
        const after = Math.hypot(now.x - other.x, now.y - other.y);
        this.#pointers.set(event.pointerId, now);
        const { hello } = this.#store;
        let camera = pan(this.camera, dx / 2 / width, dy / 2 / width, hello);
        if (before > 5 && after > 5) camera = zoom(camera, before / after, hello);
        this.#set(camera);
    }

    #up(event) {
        if (!this.#pointers.delete(event.pointerId)) return;
        if (this.#pointers.size === 0) this.#store.end();
    }

    #wheel(event) {
        if (!this.#store.hello) return;
        event.preventDefault();
        /* Lines and pages, as some mice count, in pixels. */
        const unit = [1, 16, 400][event.deltaMode] ?? 1;
        const factor = Math.exp(Math.max(-400, Math.min(400, event.deltaY * unit)) * 0.0015);
        this.#set(zoom(this.camera, factor, this.#store.hello));
    }

    /* A key on the picture: whether it meant something here. */
    key(event) {
        if (!this.#store.hello || event.ctrlKey || event.metaKey || event.altKey) return false;
        const key = event.key.toLowerCase();
        const arrow = { arrowleft: [-1, 0], arrowright: [1, 0], arrowup: [0, -1],
                        arrowdown: [0, 1] }[key];
        if (arrow) {
            const mode = event.shiftKey ? 'pan' : this.dragMode;
            const step = mode === 'pan' ? KEY_PAN : mode === 'look' ? KEY_TURN / 2 : KEY_TURN / 5;
            /* A drag takes hold of the scene, keys of the camera. */
            const sign = mode === 'orbit' ? 1 : -1;
            this.#drag(mode, sign * arrow[0] * step, sign * arrow[1] * step, 1);
            return true;
        }
        if (key === '+' || key === '=' || key === '-') {
            this.#set(zoom(this.camera, key === '-' ? 1.1 : 1 / 1.1, this.#store.hello));
            return true;
        }
        return false;
    }

    /* W A S D Q E: moves while they are held. */
    fly(event) {
        const key = event.key.toLowerCase();
        if (!(key in FLY) || !this.#store.hello) return false;
        this.#keys.add(key);
        if (this.#flying === 0) {
            this.#flownAt = performance.now();
            this.#store.begin();
            this.#flying = requestAnimationFrame(now => this.#flyOn(now));
        }
        return true;
    }

    #flyOn(now) {
        if (this.#keys.size === 0) {
            this.#flying = 0;
            this.#store.end();
            return;
        }
        /* A hidden page stops its frames: no leap afterwards. */
        const dt = Math.min(0.1, Math.max(0.001, (now - this.#flownAt) / 1000));
        this.#flownAt = now;
        const { forward, right } = basis(this.camera);
        const w = worldUp(this.#store.hello);
        const parts = { forward, back: scale(forward, -1), right, left: scale(right, -1), up: w,
                        down: scale(w, -1) };
        let way = [0, 0, 0];
        for (const key of this.#keys) way = add(way, parts[FLY[key]]);
        if (length(way) > 0) {
            const far = this.speed * (this.#isFast ? 3 : 1) * dt * diagonal(this.#store.hello);
            this.#set(move(this.camera, scale(normalize(way), far)));
        }
        this.#flying = requestAnimationFrame(next => this.#flyOn(next));
    }
}
