/* SPDX-License-Identifier: Apache-2.0 */
/* Sends the state: the newest, at most once in a frame of the screen, with rising versions. */
import { onceAFrame } from './dom.js';
import { stateMessage } from './protocol.js';
import { isCamera } from './store.js';

const REMEMBERED = 512;

export class Session {
    #connection;
    #store;
    #size; /* () => [width, height] of the full picture */
    #greeted = false;
    #changedAt = 0;
    #last = ''; /* what was sent last, but for its version */
    #sent = new Map(); /* version -> {at, changedAt, values} */
    #shown = null; /* {version, camera}: what the server says it looked through */
    #flush = onceAFrame(() => this.#send());

    version = 0;

    constructor(connection, store, size) {
        this.#connection = connection;
        this.#store = store;
        this.#size = size;
        connection.addEventListener('lost', () => { this.#greeted = false; });
        connection.addEventListener('message', ({ detail: m }) => {
            if (m.type === 'stats' && isCamera(m.camera)) this.#shown = m;
        });
        store.listen(what => {
            if (what.values || what.camera || what.view || what.moving) this.changed();
        });
    }

    /* A greeting came: say where we are. */
    greet() {
        this.#greeted = true;
        this.#last = '';
        this.changed();
    }

    changed() {
        if (this.#changedAt === 0) this.#changedAt = performance.now();
        this.#flush();
    }

    /* When a version was sent and when its first change was made; milliseconds of this page. */
    sentAt(version) {
        return this.#sent.get(version);
    }

    /* The camera that the store's values give, where the server has told; else null. */
    toldCamera() {
        const sent = this.#sent.get(this.#shown?.version);
        const isSame = sent?.camera === null
            && sent.values.every((x, i) => x === this.#store.values[i]);
        return isSame ? structuredClone(this.#shown.camera) : null;
    }

    #send() {
        if (!this.#greeted || !this.#connection.isOpen) return;
        const { values, camera, view, isMoving } = this.#store;
        const message = stateMessage(this.version + 1, {
            values, camera, view, isMoving, size: this.#size() });
        /* What the server does not see, like the divider, must not make it start again. */
        const now = JSON.stringify({ ...message, version: 0 });
        if (now === this.#last) {
            this.#changedAt = 0;
            return;
        }
        this.#last = now;
        this.version++;
        this.#connection.send(message);
        this.#sent.set(this.version, { at: performance.now(), changedAt: this.#changedAt,
                                       values: [...values], camera });
        this.#changedAt = 0;
        this.#sent.delete(this.version - REMEMBERED);
        document.dispatchEvent(new CustomEvent('lumenaut:sent',
                                               { detail: { version: this.version } }));
    }
}
