/* SPDX-License-Identifier: Apache-2.0 */
/* The file of a path: {"lumenaut_path": 1, "fps": 24, "keys": [{time, values, camera}]}. */
import { isCamera } from './store.js';

const VERSION = 1;
const MOST_KEYS = 10000;

export function pathDocument(keys, fps) {
    return {
        lumenaut_path: VERSION,
        fps,
        keys: keys.map(({ time, values, camera }) => ({ time, values, camera })),
    };
}

/* {fps, keys} of a document; throws with a message for people. Values of variables that the scene
 * does not have are left out, those out of range are moved in. */
export function readPath(document, variables) {
    if (document?.lumenaut_path !== VERSION) {
        throw new Error('this is no path of version 1 ("lumenaut_path": 1 is missing)');
    }
    const { keys } = document;
    if (!Array.isArray(keys) || keys.length > MOST_KEYS) throw new Error('"keys" must be a list');
    const fps = document.fps ?? 24;
    if (!(fps >= 1 && fps <= 240)) throw new Error('"fps" must be a number from 1 to 240');
    return { fps, keys: keys.map((key, k) => readKey(key, k, variables))
        .sort((a, b) => a.time - b.time) };
}

function readKey(key, k, variables) {
    const fail = what => { throw new Error(`keys[${k}]: ${what}`); };
    if (!(key?.time >= 0) || !Number.isFinite(key.time)) fail('"time" must be a number from 0');
    const camera = key.camera ?? null;
    if (camera !== null && !isCamera(camera)) {
        fail('"camera" must be null or have origin, target, up and fov');
    }
    const values = {};
    for (const v of variables) {
        const x = key.values?.[v.name];
        if (x === undefined) values[v.name] = v.value;
        else if (!Number.isFinite(x)) fail(`"${v.name}" must be a number`);
        else values[v.name] = Math.min(v.max, Math.max(v.min, x));
    }
    return { time: key.time, values, camera: camera && structuredClone(camera) };
}
