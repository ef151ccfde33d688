/* SPDX-License-Identifier: Apache-2.0 */
/* The editor of paths: keys in time, scrubbing, playing, files. */
import { $, download, h, iconButton, setIcon } from './dom.js';
import { clamp, fixed, isDiscrete, title } from './format.js';
import { cameraOfValues } from './camera.js';
import { atTime } from './spline.js';
import { pathDocument, readPath } from './path_file.js';
import { copyText, pathCommandLine } from './command.js';
import { readStorage, writeStorage } from './shelf.js';
import { announce, toast } from './notice.js';
import { holdWhileDown } from './slider.js';

const GAP_S = 2; /* between a new key and the last one */

const round = t => Number(t.toFixed(3));

export class PathEditor {
    #store;
    #stage;
    #keys = []; /* {time, values, camera}, sorted by time */
    #time = 0;
    #playing = 0; /* the animation frame asked for, or 0 */

    constructor(store, stage) {
        this.#store = store;
        this.#stage = stage;
        const on = (id, event, f) => $(id).addEventListener(event, f);
        on('key-add', 'click', () => this.#add());
        on('path-play', 'click', () => (this.#playing ? this.#stop() : this.#play()));
        on('path-time', 'input', () => this.#scrub($('path-time').valueAsNumber));
        on('path-time', 'keydown', event => this.#step(event));
        holdWhileDown($('path-time'), store);
        on('path-time-number', 'change', () => this.#scrub($('path-time-number').valueAsNumber));
        on('path-duration', 'change', () => this.#stretch($('path-duration').valueAsNumber));
        on('path-fps', 'change', () => this.#changed());
        on('path-loop', 'change', () => this.#changed());
        on('path-clear', 'click', () => {
            this.#keys = [];
            this.#changed();
        });
        on('path-export', 'click', () => {
            const text = JSON.stringify(pathDocument(this.#closed(), this.#fps), null, 1);
            download(new Blob([`${text}\n`], { type: 'application/json' }), 'keys.json');
        });
        on('path-import', 'click', () => $('path-file').click());
        on('path-file', 'change', () => this.#import());
        on('path-copy', 'click', () => copyText($('path-command').textContent, 'Command line'));
        store.listen(what => {
            if (what.view) this.#drawCommand();
        });
        /* Who takes hold of something else wants that, not the film. */
        for (const event of ['pointerdown', 'keydown', 'wheel']) {
            document.addEventListener(event, ({ target }) => {
                if (this.#playing && !$('panel-path').contains(target)) this.#stop();
            }, { capture: true, passive: true });
        }
    }

    greet() {
        const { scene } = this.#store.hello;
        try {
            const kept = readStorage(`lumenaut.path:${scene}`);
            if (kept) {
                const { fps, keys } = readPath(kept, this.#store.variables);
                $('path-fps').value = fps;
                this.#keys = keys;
            }
        } catch {
            this.#keys = []; /* of another time of this scene */
        }
        this.#draw();
    }

    get #fps() {
        return clamp($('path-fps').valueAsNumber || 24, 1, 240);
    }

    /* Where the last key is; a loop takes one gap more to close. */
    get #end() {
        return this.#closed().at(-1)?.time ?? 0;
    }

    /* The keys that are played and written: a loop ends as it began. */
    #closed() {
        const n = this.#keys.length;
        if (!$('path-loop').checked || n < 2) return this.#keys;
        const [first, last] = [this.#keys[0], this.#keys[n - 1]];
        const gap = (last.time - first.time) / (n - 1);
        return [...this.#keys, { ...first, time: round(last.time + gap) }];
    }

    #changed() {
        this.#keys.sort((a, b) => a.time - b.time);
        writeStorage(`lumenaut.path:${this.#store.hello.scene}`,
                     pathDocument(this.#keys, this.#fps));
        this.#draw();
    }

    #now() {
        const { values, camera } = this.#store.save();
        return { values, camera };
    }

    /* At the time of the slider; where a key is already, behind the last one. */
    #add() {
        let time = round(this.#time);
        if (this.#keys.some(key => Math.abs(key.time - time) < 0.01)) {
            time = round(this.#keys.at(-1).time + GAP_S);
        }
        this.#keys.push({ time, ...this.#now() });
        this.#time = time;
        this.#changed();
        announce(`Key at ${fixed(time, 2)} s.`);
    }

    #show(t, how) {
        const { variables, hello } = this.#store;
        const values = key => variables.map(v => key.values[v.name] ?? v.value);
        const state = atTime(this.#closed(), t, hello,
                             key => cameraOfValues(hello, values(key)));
        if (state) this.#store.load(state, how);
    }

    #scrub(t, how = { moving: true }) {
        if (!Number.isFinite(t)) return;
        this.#time = clamp(t, 0, Math.max(this.#end, this.#longest));
        if (this.#time <= this.#end) this.#show(this.#time, how);
        this.#drawTime();
    }

    /* The slider goes on behind the last key: that is where the next one is put. */
    get #longest() {
        return this.#keys.length === 0 ? 4 : this.#end + GAP_S;
    }

    /* Arrow keys go by frames. */
    #step(event) {
        const n = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1, PageUp: this.#fps,
                    PageDown: -this.#fps }[event.key];
        if (n === undefined) return;
        event.preventDefault();
        this.#scrub(this.#time + n / this.#fps);
    }

    #stretch(duration) {
        const last = this.#keys.at(-1)?.time ?? 0;
        if (duration > 0 && last > 0) {
            for (const key of this.#keys) key.time = round(key.time * duration / last);
        }
        this.#changed();
    }

    #play() {
        if (this.#keys.length < 2) {
            toast('Playing needs two keys at least.');
            return;
        }
        const start = this.#time >= this.#end ? 0 : this.#time;
        const startedAt = performance.now();
        this.#store.begin();
        const next = now => {
            const end = this.#end;
            let t = start + Math.max(0, now - startedAt) / 1000;
            if (t >= end && !$('path-loop').checked) {
                this.#scrub(end);
                this.#stop();
                return;
            }
            if (end > 0) t %= end;
            this.#scrub(t);
            this.#playing = requestAnimationFrame(next);
        };
        this.#playing = requestAnimationFrame(next);
        this.#drawPlay();
    }

    #stop() {
        if (!this.#playing) return;
        cancelAnimationFrame(this.#playing);
        this.#playing = 0;
        this.#store.end();
        this.#drawPlay();
    }

    async #import() {
        const file = $('path-file').files[0];
        $('path-file').value = '';
        if (!file) return;
        try {
            const { fps, keys } = readPath(JSON.parse(await file.text()), this.#store.variables);
            this.#keys = keys;
            $('path-fps').value = fps;
            $('path-loop').checked = false;
            this.#changed();
            toast(`${keys.length} keys from ${file.name}.`);
        } catch (error) {
            toast(`${file.name}: ${error.message}`, true);
        }
    }

    #draw() {
        $('path-keys').replaceChildren(...this.#keys.map((key, k) => this.#row(key, k)));
        $('path-empty').hidden = this.#keys.length > 0;
        const last = this.#keys.at(-1)?.time ?? 0;
        $('path-duration').value = last;
        $('path-time').max = this.#longest;
        this.#time = Math.min(this.#time, this.#longest);
        this.#drawTrack();
        this.#drawTime();
        this.#drawCommand();
    }

    #drawTrack() {
        $('path-track').replaceChildren(...this.#closed().map((key, k) => {
            const mark = h('span', { class: k < this.#keys.length ? 'tick' : 'tick again' });
            mark.style.left = `${100 * key.time / this.#longest}%`;
            return mark;
        }));
    }

    #drawTime() {
        $('path-time').value = this.#time;
        $('path-time').setAttribute('aria-valuetext', `${fixed(this.#time, 2)} seconds`);
        if (document.activeElement !== $('path-time-number')) {
            $('path-time-number').value = fixed(this.#time, 2);
        }
    }

    #drawPlay() {
        const button = $('path-play');
        setIcon(button, this.#playing ? 'stop' : 'play');
        button.querySelector('span').textContent = this.#playing ? 'Stop' : 'Play';
    }

    #drawCommand() {
        if (!this.#store.hello) return;
        const line = pathCommandLine(this.#store, this.#stage.size());
        $('path-command').textContent = line || 'Frames of a path need a model: lumenaut train.';
        $('path-copy').disabled = line === '';
    }

    #row(key, k) {
        const time = h('input', {
            type: 'number', min: '0', step: 'any', value: key.time,
            'aria-label': `Time of key ${k + 1} in seconds`,
            onchange: () => {
                const t = time.valueAsNumber;
                if (Number.isFinite(t) && t >= 0) key.time = round(t);
                this.#changed();
            },
        });
        const act = (name, label, action, f) => iconButton(name, `${label} key ${k + 1}`, {
            'data-action': action }, f);
        return h('li', { 'data-key': k },
                 h('span', { class: 'value' }, time, h('span', { class: 'unit' }, 's')),
                 h('span', { class: 'grow note' }, this.#summary(key, k)),
                 act('go', 'Go to', 'go', () => this.#scrub(key.time, {})),
                 act('replace', 'Replace by what is shown:', 'replace', () => {
                     Object.assign(key, this.#now());
                     this.#changed();
                 }),
                 act('trash', 'Delete', 'delete', () => {
                     this.#keys.splice(k, 1);
                     this.#changed();
                     $('key-add').focus();
                 }));
    }

    /* What a key changes against the one before it. */
    #summary(key, k) {
        const before = this.#keys[k - 1];
        const names = this.#store.variables.filter(v => {
            const old = before ? before.values[v.name] : v.value;
            return Math.abs((old ?? v.value) - key.values[v.name]) > 1e-9 * (v.max - v.min);
        }).map(v => (isDiscrete(v) ? `${title(v.name)} ${v.choices[key.values[v.name] - v.min]}`
            : title(v.name)));
        const words = [];
        if (key.camera) words.push('own camera');
        if (names.length > 0) words.push(names.length > 3 ? `${names.length} variables`
            : names.join(', '));
        return words.join('; ') || (before ? 'as before' : 'defaults');
    }
}
