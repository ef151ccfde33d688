/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures as files: asked of the server, which has them in full size and as floats. */
import { $, download } from './dom.js';
import { toast } from './notice.js';

export class Capture {
    #connection;
    #store;
    #stage;
    #id = 0;
    #names = new Map(); /* id -> name, between the message and the file */

    constructor(connection, store, stage) {
        this.#connection = connection;
        this.#store = store;
        this.#stage = stage;
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

    ask(format) {
        const layer = $('capture-layer').value || this.#stage.layerAt(0);
        this.#id++;
        const isSent = this.#connection.send({ type: 'capture', id: this.#id, layer, format });
        if (isSent) toast('The picture is being made.');
        else toast('Not connected: no picture can be saved now.', true);
    }
}
