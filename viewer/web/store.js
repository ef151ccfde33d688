/* SPDX-License-Identifier: Apache-2.0 */
/* What the page shows: values of variables, camera, view; one place that everything reads and
 * changes, with undo. Listeners hear what changed: {values, camera, view, moving, history}. */
import { clamp, decimals, isDiscrete, quantise } from './format.js';
import { diagonal } from './camera.js';

const HISTORY = 200;
const REST_MS = 250; /* this long without a change is rest, even with a finger down */

export const DEFAULT_VIEW = Object.freeze({
    mode: 'neural', /* neural, traced, split, error, buffer */
    buffer: 'albedo',
    left: 'neural', /* of the split */
    right: 'traced',
    split: 0.5,
    exposure: 1,
    tone: 'srgb',
    size: 'fit', /* fit, scene, half, double, window, or [width, height] */
    rate: 15,
    least: 0.25,
});

const isPoint = p => Array.isArray(p) && p.length === 3 && p.every(Number.isFinite);

export function isCamera(c) {
    return c != null && isPoint(c.origin) && isPoint(c.target) && isPoint(c.up)
        && Number.isFinite(c.fov) && c.fov >= 0;
}

/* To a millionth of the scene's size: command lines and links then say exactly what is shown. */
function roundCamera(camera, hello) {
    const digits = decimals(0, diagonal(hello) / 1000);
    const point = p => p.map(x => Number(x.toFixed(digits)));
    return {
        origin: point(camera.origin),
        target: point(camera.target),
        up: camera.up.map(x => Number(x.toFixed(7))),
        fov: Number(camera.fov.toFixed(hello.orthographic ? digits : 4)),
    };
}

/* A kept camera may be of another kind than the scene's. */
function soundCamera(camera, hello) {
    const { fov } = hello.camera;
    const most = hello.orthographic ? 1e12 : 179.9;
    return camera.fov > 0 && camera.fov <= most ? camera : { ...camera, fov };
}

/* A view of which every field is sound: storage, links and files may hold anything. */
export function soundView(view, hello) {
    const v = { ...DEFAULT_VIEW, ...view };
    const has = name => hello.layers.includes(name);
    const pictures = ['neural', 'traced', 'error'].filter(has);
    const buffers = hello.layers.filter(name => !pictures.includes(name));
    const first = pictures[0] ?? 'buffer';
    if (!buffers.includes(v.buffer)) v.buffer = buffers[0] ?? DEFAULT_VIEW.buffer;
    if (!has(v.left)) v.left = first;
    if (!has(v.right)) v.right = pictures.find(name => name !== v.left) ?? first;
    const modes = [...pictures];
    if (pictures.length > 1) modes.push('split');
    if (buffers.length > 0) modes.push('buffer');
    if (!modes.includes(v.mode)) v.mode = first;
    const number = (x, min, max, other) => (Number.isFinite(x) ? clamp(x, min, max) : other);
    v.split = number(v.split, 0, 1, DEFAULT_VIEW.split);
    v.exposure = number(v.exposure, 1e-4, 1e4, DEFAULT_VIEW.exposure);
    v.rate = Math.round(number(v.rate, 1, 60, DEFAULT_VIEW.rate));
    v.least = number(v.least, 0.1, 1, DEFAULT_VIEW.least);
    if (v.tone !== 'aces') v.tone = 'srgb';
    if (Array.isArray(v.size) && v.size.length === 2 && v.size.every(Number.isFinite)) {
        v.size = v.size.map(n => clamp(Math.round(n), 16, 4096));
    } else if (!['fit', 'scene', 'half', 'double', 'window'].includes(v.size)) {
        v.size = DEFAULT_VIEW.size;
    }
    return Object.fromEntries(Object.keys(DEFAULT_VIEW).map(key => [key, v[key]]));
}

export class Store {
    #listeners = [];
    #past = [];
    #future = [];
    #kept = null; /* the snapshot that the next commit is compared with */
    #held = 0;
    #restTimer = 0;

    hello = null;
    variables = [];
    values = [];
    camera = null; /* null: the one that the values give */
    view = { ...DEFAULT_VIEW };
    isMoving = false;

    listen(f) {
        this.#listeners.push(f);
    }

    #tell(what) {
        for (const f of this.#listeners) f(what);
    }

    /* A server's greeting. The same variables as before keep their values: it was a restart.
     * Returns whether the controls must be made anew. */
    start(hello) {
        const variables = hello.variables.map(v => ({
            ...v, choices: v.choices?.length ? v.choices
                : v.kind === 'visible' ? ['off', 'on'] : null }));
        const shape = list => JSON.stringify(list.map(v => [v.name, v.group, v.kind, v.min, v.max,
                                                            v.choices]));
        const isSame = this.hello !== null && shape(variables) === shape(this.variables)
            && hello.scene === this.hello.scene;
        this.hello = hello;
        this.variables = variables;
        if (!isSame) {
            this.values = hello.variables.map(v => v.value);
            this.camera = null;
            this.#past = [];
            this.#future = [];
        }
        this.view = soundView(this.view, hello);
        this.#kept = this.#copy();
        return !isSame;
    }

    index(name) {
        return this.variables.findIndex(v => v.name === name);
    }

    isDefault(index) {
        const { min, max, value } = this.variables[index];
        return Math.abs(this.values[index] - value) <= 1e-9 * Math.max(1, max - min);
    }

    /* The one door for changes. patch: {values: [[index, value], ..], camera, view}; moving: more
     * changes follow (a drag), so that the server may draw smaller; keep: false makes no step of
     * undo yet; exact: not rounded to what boxes and command lines show. */
    change(patch, { moving = false, keep = true, exact = false } = {}) {
        for (const [index, value] of patch.values ?? []) {
            const variable = this.variables[index];
            /* Defaults are taken as they are: rounding them would make them changes. */
            const isKept = value === variable.value || (exact && !isDiscrete(variable));
            this.values[index] = isKept ? clamp(value, variable.min, variable.max)
                : quantise(variable, value);
        }
        if ('camera' in patch) {
            const { camera } = patch;
            this.camera = camera && soundCamera(exact ? camera : roundCamera(camera, this.hello),
                                                this.hello);
        }
        if (patch.view) this.view = soundView({ ...this.view, ...patch.view }, this.hello);
        if (moving) this.#touch();
        this.#tell({ values: (patch.values?.length ?? 0) > 0, camera: 'camera' in patch,
                     view: Boolean(patch.view) });
        if (!moving && keep && this.#held === 0) this.commit();
    }

    setValue(index, value, how) {
        this.change({ values: [[index, value]] }, how);
    }

    /* A finger is down: what changes until end() is one step of undo. */
    begin() {
        this.#held++;
    }

    end() {
        this.#held = Math.max(0, this.#held - 1);
        if (this.#held === 0) this.#rest();
    }

    #touch() {
        clearTimeout(this.#restTimer);
        this.#restTimer = setTimeout(() => this.#rest(), REST_MS);
        if (this.isMoving) return;
        this.isMoving = true;
        this.#tell({ moving: true });
    }

    #rest() {
        clearTimeout(this.#restTimer);
        if (this.isMoving) {
            this.isMoving = false;
            this.#tell({ moving: true });
        }
        if (this.#held === 0) this.commit();
    }

    #copy() {
        return structuredClone({ values: this.values, camera: this.camera, view: this.view });
    }

    commit() {
        const now = this.#copy();
        if (JSON.stringify(now) === JSON.stringify(this.#kept)) return;
        this.#past.push(this.#kept);
        if (this.#past.length > HISTORY) this.#past.shift();
        this.#future = [];
        this.#kept = now;
        this.#tell({ history: true });
    }

    #travel(from, to) {
        if (from.length === 0) return;
        to.push(this.#kept);
        this.#kept = from.pop();
        const { values, camera, view } = structuredClone(this.#kept);
        Object.assign(this, { values, camera, view });
        this.#tell({ values: true, camera: true, view: true, history: true });
    }

    undo() {
        this.commit();
        this.#travel(this.#past, this.#future);
    }

    redo() {
        this.#travel(this.#future, this.#past);
    }

    get canUndo() {
        return this.#past.length > 0;
    }

    get canRedo() {
        return this.#future.length > 0;
    }

    /* The state by names, for presets, links and files. */
    save() {
        const values = Object.fromEntries(this.variables.map((v, i) => [v.name, this.values[i]]));
        return structuredClone({ values, camera: this.camera, view: this.view });
    }

    /* What save() gave, in whole or in parts; names that are not here are passed over. */
    load(saved, how) {
        const patch = { values: [] };
        for (const [name, value] of Object.entries(saved.values ?? {})) {
            const index = this.index(name);
            if (index >= 0 && Number.isFinite(value)) patch.values.push([index, value]);
        }
        if (saved.camera === null || isCamera(saved.camera)) {
            patch.camera = structuredClone(saved.camera);
        }
        if (saved.view) patch.view = saved.view;
        this.change(patch, { ...how, exact: true });
    }

    resetAll() {
        this.change({ values: this.variables.map((v, i) => [i, v.value]) });
    }

    /* Draws the variables of these indices. */
    randomise(indices) {
        this.change({ values: indices.map(i => {
            const { min, max } = this.variables[i];
            const u = Math.random();
            return [i, isDiscrete(this.variables[i]) ? min + Math.floor(u * (max - min + 1))
                : min + u * (max - min)];
        }) });
    }
}
