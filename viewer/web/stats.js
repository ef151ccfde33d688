/* SPDX-License-Identifier: Apache-2.0 */
/* Figures: what the server says about its work, what this page measures of the wire. */
import { $, h } from './dom.js';
import { bytes, fixed, short } from './format.js';

const KEPT = 200; /* latencies that percentiles are taken of */
const WINDOW_MS = 2000;

const ROWS = [
    ['fps', 'Frames a second'],
    ['render', 'Frame'],
    ['buffers', 'Buffers'],
    ['network', 'Network'],
    ['encode', 'Encoding'],
    ['wire', 'Wire'],
    ['latency', 'Latency'],
    ['latency-p50', 'Latency, median'],
    ['latency-p95', 'Latency, 95 %'],
    ['spp', 'Samples, neural'],
    ['traced-spp', 'Samples, traced'],
    ['drawn', 'Drawn'],
    ['version', 'State'],
    ['sessions', 'Pages'],
    ['view-share', 'Processor share'],
];

const percentile = (sorted, p) => sorted[Math.min(sorted.length - 1,
                                                  Math.floor(p * sorted.length))];

export class Stats {
    #cells = {};
    #frames = []; /* {at, size} of the last seconds */
    #latencies = [];
    #last = null;

    constructor(connection, stage) {
        for (const [key, name] of ROWS) {
            this.#cells[key] = h('dd', { 'data-stat': key }, '–');
            $('stats').append(h('div', null, h('dt', null, name), this.#cells[key]));
        }
        stage.addEventListener('drawn', event => this.#drawn(event.detail));
        connection.addEventListener('message', ({ detail: m }) => {
            if (m.type === 'stats') this.#server(m);
            if (m.type === 'metrics') this.#metrics(m);
        });
        setInterval(() => this.#show(), 500);
    }

    #set(key, text) {
        if (this.#cells[key].textContent !== text) this.#cells[key].textContent = text;
    }

    #drawn({ picture, latency }) {
        const now = performance.now();
        this.#frames.push({ at: now, size: picture.size });
        if (latency !== null) {
            this.#latencies.push(latency);
            if (this.#latencies.length > KEPT) this.#latencies.shift();
        }
        this.#last = { picture, latency: latency ?? this.#last?.latency };
    }

    #server(m) {
        const ms = x => (x == null ? '–' : `${fixed(x, 1)} ms`);
        this.#set('render', ms(m.render_ms));
        this.#set('buffers', ms(m.buffers_ms));
        this.#set('network', ms(m.network_ms));
        this.#set('encode', ms(m.encode_ms));
        this.#set('spp', short(m.spp));
        this.#set('traced-spp', short(m.traced_spp));
        this.#set('sessions', short(m.sessions));
        this.#set('view-share', m.view_share == null ? '–'
            : `${Math.round(m.view_share * 100)} %`);
        this.#fps = m.fps;
    }

    #fps = null;

    #metrics(m) {
        const set = (key, text) => {
            document.querySelector(`[data-metric="${key}"]`).textContent = text;
        };
        for (const key of ['flip', 'mape', 'relmse', 'psnr']) set(key, short(m[key]));
        set('psnr', m.psnr == null ? '–' : `${fixed(m.psnr, 2)} dB`);
        set('spp', `${short(m.neural_spp)} : ${short(m.traced_spp)}`);
        $('metrics').dataset.version = m.version;
    }

    #show() {
        const now = performance.now();
        this.#frames = this.#frames.filter(f => now - f.at < WINDOW_MS);
        if (!this.#last) return;
        const { picture, latency } = this.#last;
        const n = this.#frames.length;
        const span = n > 1 ? (this.#frames[n - 1].at - this.#frames[0].at) / 1000 : 0;
        /* The server knows its rate; a page that falls behind knows better. */
        const own = span > 0 ? (n - 1) / span : 0;
        const fps = n === 0 ? 0 : own || this.#fps || 0;
        const flow = this.#frames.reduce((sum, f) => sum + f.size, 0) / (WINDOW_MS / 1000);
        const sorted = this.#latencies.toSorted((a, b) => a - b);
        const ms = x => (x == null ? '–' : `${Math.round(x)} ms`);
        this.#set('fps', n === 0 ? 'at rest' : fixed(fps, 1));
        this.#set('wire', `${bytes(picture.size)} a frame, ${bytes(flow)}/s`);
        this.#set('latency', ms(latency));
        this.#set('latency-p50', ms(percentile(sorted, 0.5)));
        this.#set('latency-p95', ms(percentile(sorted, 0.95)));
        const share = Math.round(100 * picture.width / picture.fullWidth);
        this.#set('drawn', `${picture.width} × ${picture.height}, ${share} %`);
        this.#set('version', String(picture.version));
        const state = n > 0 ? `${fixed(fps, 1)} fps` : picture.isFinished ? 'finished' : 'at rest';
        const words = [state, ms(latency), `${picture.spp} spp`,
                       `${picture.width} × ${picture.height}`];
        const text = words.join(' · ');
        if ($('summary').textContent !== text) $('summary').textContent = text;
    }
}
