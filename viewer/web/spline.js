/* SPDX-License-Identifier: Apache-2.0 */
/* A path between key frames: Catmull-Rom for cameras, straight lines for values. Keys need not be
 * equally far apart in time: tangents are those of the non-uniform cubic Hermite curve,
 * m_i = (p_(i+1) - p_(i-1)) / (t_(i+1) - t_(i-1)), one-sided at the ends. */
import { isDiscrete } from './format.js';
import { normalize } from './vec.js';

/* The key at or before t, and how far t is on the way to the next, 0 to 1. */
function segment(times, t) {
    let i = 0;
    while (i + 2 < times.length && times[i + 1] <= t) i++;
    const span = times[i + 1] - times[i];
    return { i, u: span > 0 ? Math.min(1, Math.max(0, (t - times[i]) / span)) : 1 };
}

function hermite(times, points, i, u) {
    const n = times.length;
    const tangent = k => {
        const a = Math.max(0, k - 1), b = Math.min(n - 1, k + 1);
        return times[b] > times[a] ? (points[b] - points[a]) / (times[b] - times[a]) : 0;
    };
    const span = times[i + 1] - times[i];
    const u2 = u * u, u3 = u2 * u;
    return (2 * u3 - 3 * u2 + 1) * points[i] + (u3 - 2 * u2 + u) * span * tangent(i)
        + (3 * u2 - 2 * u3) * points[i + 1] + (u3 - u2) * span * tangent(i + 1);
}

/* The state at time t of keys {time, values: {name: x}, camera or null}, sorted by time.
 * resolve(key): the camera of a key that has none of its own. Only when no key has one the answer
 * has none. */
export function atTime(keys, t, { variables, orthographic }, resolve) {
    if (keys.length === 0) return null;
    if (keys.length === 1) return { values: keys[0].values, camera: keys[0].camera };
    const times = keys.map(key => key.time);
    const { i, u } = segment(times, t);
    const values = {};
    for (const v of variables) {
        const a = keys[i].values[v.name] ?? v.value, b = keys[i + 1].values[v.name] ?? v.value;
        /* A choice holds until the next key. */
        values[v.name] = isDiscrete(v) ? (u < 1 ? a : b) : a + (b - a) * u;
    }
    if (keys.every(key => key.camera === null)) return { values, camera: null };
    const cameras = keys.map(key => key.camera ?? resolve(key));
    const along = f => hermite(times, cameras.map(f), i, u);
    const point = name => [0, 1, 2].map(k => along(c => c[name][k]));
    const mostFov = orthographic ? 1e12 : 179;
    return {
        values,
        camera: {
            origin: point('origin'),
            target: point('target'),
            up: normalize(point('up')),
            fov: Math.min(mostFov, Math.max(1e-3, along(c => c.fov))),
        },
    };
}
