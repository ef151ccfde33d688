/* SPDX-License-Identifier: Apache-2.0 */
/* The picture: decodes what arrives, keeps the newest of each layer and draws what the mode asks
 * for. Nothing older than what is drawn of a layer is drawn again. */
import { $ } from './dom.js';
import { clamp, title } from './format.js';
import { CAPTURE_LAYER, LAYERS, layerSlot, readPicture, wantedLayers } from './protocol.js';

/* Of a picture that fits the window: more take long to refine, and little is seen of them. */
const MOST_PIXELS = 1.2e6;

const NAMES = { neural: 'Neural', traced: 'Path traced', error: 'FLIP error' };

export const layerName = name => NAMES[name] ?? title(name);

export class Stage extends EventTarget {
    #connection;
    #store;
    #session;
    #layers = Object.values(LAYERS).map(() => (
        { bitmap: null, version: 0, frame: 0, picture: null }));
    #leastVersion = 0; /* of buffers: earlier ones show another buffer */
    #buffer = null;
    #canvas = $('picture');
    #context = $('picture').getContext('2d', { alpha: false });
    #frame = $('frame');
    #stage = $('stage');

    constructor(connection, store, session) {
        super();
        this.#connection = connection;
        this.#store = store;
        this.#session = session;
        connection.addEventListener('picture', event => this.#receive(event.detail));
        store.listen(what => {
            if (what.view) this.#viewChanged();
        });
        new ResizeObserver(() => this.resize()).observe(this.#stage);
    }

    /* A server greets: its frames are numbered from the start again. */
    greet() {
        for (const layer of this.#layers) layer.frame = 0;
        this.#viewChanged();
    }

    /* Width and height of the full picture that the view asks for. */
    size() {
        const { hello, view } = this.#store;
        const [w, h] = hello?.size ?? [256, 256];
        const fit = pair => pair.map(n => clamp(Math.round(n), 16, 4096));
        if (Array.isArray(view.size)) return fit(view.size);
        if (view.size === 'half') return fit([w / 2, h / 2]);
        if (view.size === 'double') return fit([w * 2, h * 2]);
        if (view.size === 'scene') return fit([w, h]);
        const ratio = window.devicePixelRatio || 1;
        const room = [this.#stage.clientWidth * ratio, this.#stage.clientHeight * ratio];
        if (view.size === 'window') return fit(room);
        const least = Math.max(16 / w, 16 / h);
        const scale = Math.max(least, Math.min(room[0] / w, room[1] / h,
                                               Math.sqrt(MOST_PIXELS / (w * h))));
        return fit([w * scale, h * scale]);
    }

    /* The layer under a place of the picture, 0 left to 1 right. */
    layerAt(u) {
        const { view } = this.#store;
        if (view.mode === 'split') return u < view.split ? view.left : view.right;
        return view.mode === 'buffer' ? view.buffer : view.mode;
    }

    get rect() {
        return this.#frame.getBoundingClientRect();
    }

    picture(name) {
        return this.#layers[layerSlot(name)].picture;
    }

    #viewChanged() {
        const { view } = this.#store;
        this.#forget();
        if (view.mode === 'buffer' && view.buffer !== this.#buffer) {
            this.#buffer = view.buffer;
            this.#leastVersion = this.#session.version + 1;
        }
        this.resize();
        this.draw();
    }

    #isWanted(slot) {
        return wantedLayers(this.#store.view, true).some(name => layerSlot(name) === slot);
    }

    /* A layer that is not asked for any more grows stale: it must not be seen when it is again. */
    #forget() {
        this.#layers.forEach((layer, slot) => {
            if (this.#isWanted(slot)) return;
            layer.bitmap?.close();
            layer.bitmap = null;
        });
    }

    /* Fits the picture into the stage without changing its shape. */
    resize() {
        const [w, h] = this.size();
        const { clientWidth: cw, clientHeight: ch } = this.#stage;
        if (cw === 0 || ch === 0) return;
        const s = Math.min(cw / w, ch / h);
        this.#frame.style.width = `${Math.round(w * s)}px`;
        this.#frame.style.height = `${Math.round(h * s)}px`;
        if (['fit', 'window'].includes(this.#store.view.size) && this.#store.hello
            && (this.#canvas.width !== w || this.#canvas.height !== h)) this.#session.changed();
    }

    async #receive(data) {
        const picture = readPicture(data);
        if (!picture) return;
        if (picture.layer === CAPTURE_LAYER) {
            this.dispatchEvent(new CustomEvent('file', { detail: picture }));
            return;
        }
        const layer = this.#layers[picture.layer];
        if (layer && this.#isWanted(picture.layer) && !this.#isOld(layer, picture)) {
            try {
                const bitmap = await createImageBitmap(picture.blob);
                /* Decoding takes its time: a newer one may have passed. */
                if (this.#isOld(layer, picture)) bitmap.close();
                else this.#take(layer, picture, bitmap);
            } catch {
                this.dispatchEvent(new CustomEvent('broken', { detail: picture }));
            }
        }
        this.#connection.send({ type: 'ack', frame: picture.frame });
    }

    #isOld(layer, picture) {
        return picture.version < layer.version
            || (picture.version === layer.version && picture.frame < layer.frame)
            || (picture.layer === LAYERS.buffer && picture.version < this.#leastVersion);
    }

    #take(layer, picture, bitmap) {
        const isFirst = picture.version !== layer.version;
        layer.bitmap?.close();
        Object.assign(layer, { bitmap, picture, version: picture.version, frame: picture.frame });
        this.draw();
        const now = performance.now();
        const sent = isFirst ? this.#session.sentAt(picture.version) : undefined;
        const detail = {
            layer: picture.layer,
            version: picture.version,
            frame: picture.frame,
            width: picture.width,
            height: picture.height,
            latency: sent ? now - sent.at : null,
            fromInput: sent?.changedAt ? now - sent.changedAt : null,
        };
        this.dispatchEvent(new CustomEvent('drawn', { detail: { ...detail, picture } }));
        document.dispatchEvent(new CustomEvent('lumenaut:drawn', { detail }));
    }

    /* The layers on the screen: one, or left and right. */
    #shown() {
        const { view } = this.#store;
        if (view.mode === 'split') return [view.left, view.right];
        const name = this.layerAt(0);
        if (name !== 'error') return [name];
        /* While something moves no error map comes: the network's picture shows where we are. */
        const error = this.#layers[LAYERS.error], neural = this.#layers[LAYERS.neural];
        const isBehind = neural.bitmap && neural.version > error.version;
        return [isBehind || !error.bitmap ? 'neural' : 'error'];
    }

    draw() {
        const names = this.#shown();
        const layers = names.map(name => this.#layers[layerSlot(name)]);
        const first = layers.find(layer => layer.bitmap);
        if (!first) return; /* what was there stays until there is something better */
        $('waiting').hidden = true;
        const { fullWidth: w, fullHeight: h } = first.picture;
        if (this.#canvas.width !== w || this.#canvas.height !== h) {
            this.#canvas.width = w;
            this.#canvas.height = h;
        }
        const middle = names.length > 1 ? Math.round(this.#store.view.split * w) : w;
        this.#part(layers[0], 0, middle, h);
        if (layers[1]) this.#part(layers[1], middle, w, h);
        const newest = layers.reduce((a, b) => (b.version > a.version ? b : a));
        Object.assign(this.#canvas.dataset, {
            layer: names[0], version: newest.version, frame: newest.frame,
            width: newest.picture?.width ?? 0, spp: newest.picture?.spp ?? 0 });
        const words = names.map(layerName).join(' beside ');
        const label = `${words} picture, ${w} by ${h} pixels`;
        if (this.#canvas.getAttribute('aria-label') !== label) {
            this.#canvas.setAttribute('aria-label', label);
        }
    }

    /* Draws the columns x0 to x1 of a layer. */
    #part(layer, x0, x1, h) {
        if (x1 <= x0) return;
        const c = this.#context;
        const w = this.#canvas.width;
        const { bitmap } = layer;
        if (!bitmap) return;
        if (x0 === 0 && x1 === w) {
            c.drawImage(bitmap, 0, 0, w, h);
            return;
        }
        c.save();
        c.beginPath();
        c.rect(x0, 0, x1 - x0, h);
        c.clip();
        c.drawImage(bitmap, 0, 0, w, h);
        c.restore();
    }
}
