/* SPDX-License-Identifier: Apache-2.0 */
/* The connection: opens itself, comes back by itself after the server went away. */
import { SUBPROTOCOL } from './protocol.js';

const FIRST_WAIT_MS = 300;
const LONGEST_WAIT_MS = 8000;
const SILENCE_MS = 10000; /* an opening that takes longer has failed */

/* The token is in the page's address, as the viewer printed it: ?token=.. or #token=.. */
function findToken() {
    return new URLSearchParams(location.search).get('token')
        ?? new URLSearchParams(location.hash.slice(1)).get('token');
}

function socketAddress(token) {
    const url = new URL('socket', location.href);
    url.protocol = location.protocol === 'https:' ? 'wss:' : 'ws:';
    url.hash = '';
    url.search = token === null ? '' : `?${new URLSearchParams({ token })}`;
    return url.href;
}

/* Events: open, message (detail: object), picture (detail: ArrayBuffer), lost (detail: {wait_ms,
 * tries, wasOpen}). */
export class Connection extends EventTarget {
    #socket = null;
    #tries = 0;
    #timer = 0;
    #token = findToken();
    #wasEverOpen = false;

    constructor() {
        super();
        /* Someone who looks again should not wait for a timer. */
        addEventListener('online', () => this.retry());
        document.addEventListener('visibilitychange', () => {
            if (!document.hidden) this.retry();
        });
        /* A page that is left, kept by the browser and shown again needs a new socket. */
        addEventListener('pageshow', event => {
            if (event.persisted) this.retry();
        });
    }

    get isOpen() {
        return this.#socket?.readyState === WebSocket.OPEN;
    }

    open() {
        clearTimeout(this.#timer);
        const socket = new WebSocket(socketAddress(this.#token), SUBPROTOCOL);
        socket.binaryType = 'arraybuffer';
        this.#socket = socket;
        const watch = setTimeout(() => socket.close(), SILENCE_MS);
        socket.addEventListener('open', () => {
            clearTimeout(watch);
            this.#wasEverOpen = true;
            this.#emit('open');
        });
        socket.addEventListener('message', event => {
            if (socket === this.#socket) this.#receive(event.data);
        });
        socket.addEventListener('close', () => {
            clearTimeout(watch);
            if (socket === this.#socket) this.#wait();
        });
    }

    retry() {
        if (this.#socket && this.#socket.readyState !== WebSocket.CLOSED) return;
        this.open();
    }

    send(message) {
        if (!this.isOpen) return false;
        this.#socket.send(JSON.stringify(message));
        return true;
    }

    #emit(name, detail) {
        this.dispatchEvent(new CustomEvent(name, { detail }));
    }

    #receive(data) {
        if (data instanceof ArrayBuffer) {
            this.#emit('picture', data);
            return;
        }
        let message = null;
        try {
            message = JSON.parse(data);
        } catch {
            return; /* a later server may say what this page does not know */
        }
        /* Only a greeting proves that this is a viewer: waits get longer until then. */
        if (message?.type === 'hello') this.#tries = 0;
        if (typeof message?.type === 'string') this.#emit('message', message);
    }

    #wait() {
        const spread = 0.8 + 0.4 * Math.random(); /* pages do not come back all at once */
        const wait = Math.min(LONGEST_WAIT_MS, FIRST_WAIT_MS * 2 ** this.#tries) * spread;
        this.#tries++;
        this.#timer = setTimeout(() => this.open(), wait);
        this.#emit('lost', { wait_ms: wait, tries: this.#tries, wasOpen: this.#wasEverOpen });
    }
}
