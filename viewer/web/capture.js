/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures as files: asked of the server, which has them in full size and as floats. */
import { $, download } from './dom.js';
import { toast } from './notice.js';

export class Capture {
    #connection;
    #store;
    #id = 0;
    #names = new Map(); /* id -> name, between the message and the file */

    constructor(connection, store, stage) {
        this.#connection = connection;
        this.#store = store;
        for (const format of ['png', 'exr']) {
            $(`capture-${format}`).addEventListener('click', () => this.ask(format));
        }
        connection.addEventListener('message', ({ detail: m }) => {
            if (m.type !== 'capture') return;
            if (m.message) toast(m.message, true);
            else this.#names.set(m.id, m.name);
        });
        connection.addEventListener('lost', () => this.#names.clear());
        stage.addEventListener('file', ({ detail: picture }) => {
            const name = this.#names.get(picture.frame);
            if (name === undefined) return;
            this.#names.delete(picture.frame);
            /* A name, not a path: it comes over the wire. */
            const safe = String(name).split(/[\\/]/).pop() || 'picture';
            download(picture.blob, safe);
            toast(`Saved ${safe}.`);
        });
    }

    #saveScreen(what) {
        $('picture').toBlob(blob => {
            if (!blob) return;
            download(blob, `${what}.png`);
            toast(`Saved ${what}.png.`);
        });
    }

    ask(format) {
        const { mode } = this.#store.view;
        let layer = $('capture-layer').value;
        if (layer === '') {
            /* What the page puts together, or what has no floats, is saved from the screen. */
            const isOne = mode === 'neural' || mode === 'traced';
            if (!isOne && format === 'png') {
                this.#saveScreen(mode === 'buffer' ? this.#store.view.buffer : mode);
                return;
            }
            layer = isOne ? mode : this.#store.hello?.model ? 'neural' : 'traced';
        }
        this.#id++;
        const isSent = this.#connection.send({ type: 'capture', id: this.#id, layer, format });
        if (isSent) toast('The picture is being made.');
        else toast('Not connected: no picture can be saved now.', true);
    }
}
