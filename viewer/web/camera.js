/* SPDX-License-Identifier: Apache-2.0 */
/* Cameras and how they move: {origin, target, up, fov}, all functions return new ones. Of an
 * orthographic camera `fov` is the width that it sees. */
import { add, cross, distance, dot, length, madd, nearestAxis, normalize, scale, sub, turn }
    from './vec.js';
import { clamp } from './format.js';

const POLE = 0.02; /* radians between the view and straight up or down */

export function diagonal(hello) {
    return distance(hello.bounds.min, hello.bounds.max) || 1;
}

export function middle(hello) {
    return scale(add(hello.bounds.min, hello.bounds.max), 0.5);
}

/* What is up in the scene: cameras that look down have an `up` that leans. */
export function worldUp(hello) {
    return nearestAxis(hello.camera.up);
}

/* The camera that values give, as far as a page can know it: the default one with the members of
 * groups of the kind "camera" in their places. The default target is only a direction; members
 * that are known tell how far along it the real one is. */
export function cameraOfValues(hello, values) {
    const camera = structuredClone(hello.camera);
    const members = [];
    hello.variables.forEach((v, i) => {
        const match = v.kind === 'camera' && /\.(target_)?([xyz])$/.exec(v.name);
        if (!match) return;
        members.push({ index: i, default: v.value, axis: 'xyz'.indexOf(match[2]),
                       part: match[1] ? 'target' : 'origin' });
    });
    const direction = sub(camera.target, camera.origin);
    const known = members.filter(m => m.part === 'target' && Math.abs(direction[m.axis]) > 1e-6)
        .sort((a, b) => Math.abs(direction[b.axis]) - Math.abs(direction[a.axis]))[0];
    if (known) {
        const t = (known.default - camera.origin[known.axis]) / direction[known.axis];
        if (t > 1e-6) camera.target = madd(camera.origin, direction, t);
    }
    for (const m of members) camera[m.part][m.axis] = values[m.index];
    return camera;
}

export function basis(camera) {
    const forward = normalize(sub(camera.target, camera.origin));
    const right = normalize(cross(forward, camera.up));
    return { forward, right, up: cross(right, forward) };
}

/* Azimuth vector (level, of length one) and elevation of a direction. */
function spherical(direction, w, up) {
    const sine = clamp(dot(direction, w), -1, 1);
    let level = madd(direction, w, -sine);
    /* Less than direct() leaves, so that it never meets its own poles. */
    if (length(level) < POLE / 2) {
        /* Straight up or down: what is up in the picture tells where the camera is turned. */
        level = scale(madd(up, w, -dot(up, w)), sine > 0 ? -1 : 1);
    }
    return { level: normalize(level), elevation: Math.asin(sine) };
}

function direct(level, elevation, w) {
    const e = clamp(elevation, -Math.PI / 2 + POLE, Math.PI / 2 - POLE);
    return add(scale(level, Math.cos(e)), scale(w, Math.sin(e)));
}

/* About the target; angles in radians. */
export function orbit(camera, yaw, pitch, w) {
    const d = sub(camera.origin, camera.target);
    const r = length(d);
    const { level, elevation } = spherical(normalize(d), w, camera.up);
    const to = direct(turn(level, w, yaw), elevation + pitch, w);
    return { ...camera, origin: madd(camera.target, to, r), up: [...w] };
}

/* About the origin: the head turns. */
export function look(camera, yaw, pitch, w) {
    const d = sub(camera.target, camera.origin);
    const r = length(d);
    const { level, elevation } = spherical(normalize(d), w, camera.up);
    const to = direct(turn(level, w, yaw), elevation + pitch, w);
    return { ...camera, target: madd(camera.origin, to, r), up: [...w] };
}

export function move(camera, offset) {
    return { ...camera, origin: add(camera.origin, offset), target: add(camera.target, offset) };
}

/* By shares of the picture's width: what is under the pointer stays there. */
export function pan(camera, du, dv, hello) {
    const { right, up } = basis(camera);
    const wide = hello.orthographic ? camera.fov
        : 2 * distance(camera.origin, camera.target) * Math.tan(camera.fov * Math.PI / 360);
    return move(camera, add(scale(right, -du * wide), scale(up, dv * wide)));
}

/* Nearer to the target, or farther; how far away it is changes nothing of an orthographic picture. */
export function zoom(camera, factor, hello) {
    const size = diagonal(hello);
    if (hello.orthographic) {
        return { ...camera, fov: clamp(camera.fov * factor, size * 1e-3, size * 20) };
    }
    const d = sub(camera.origin, camera.target);
    const r = clamp(length(d) * factor, size * 1e-3, size * 20);
    return { ...camera, origin: madd(camera.target, normalize(d), r) };
}

/* Named views of the scene's bounds. */
export function namedView(name, hello) {
    const w = worldUp(hello);
    /* Front is where +z comes from when y is up, and where -y comes from when z is. */
    const front = Math.abs(w[1]) > 0.5 ? [0, 0, 1] : Math.abs(w[2]) > 0.5 ? [0, -1, 0] : [0, 0, 1];
    const right = cross(w, front);
    const from = { front, back: scale(front, -1), right, left: scale(right, -1), top: w }[name];
    const { orthographic, camera: { fov } } = hello;
    const far = orthographic ? 1 : 0.5 / Math.tan(clamp(fov, 5, 120) * Math.PI / 360) + 0.3;
    const target = middle(hello);
    return {
        origin: madd(target, from, diagonal(hello) * far),
        target,
        up: name === 'top' ? scale(front, -1) : w,
        fov: orthographic ? diagonal(hello) * 1.1 : fov,
    };
}

export function isInside(point, bounds) {
    return point.every((x, k) => x >= bounds.min[k] && x <= bounds.max[k]);
}
