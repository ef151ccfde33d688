/* SPDX-License-Identifier: Apache-2.0 */
/* Vectors of three numbers. */

export const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
export const madd = (a, b, s) => [a[0] + b[0] * s, a[1] + b[1] * s, a[2] + b[2] * s];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const length = a => Math.hypot(...a);
export const distance = (a, b) => length(sub(a, b));

export function cross(a, b) {
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

export function normalize(a) {
    const l = length(a);
    return l > 0 ? scale(a, 1 / l) : [0, 0, 0];
}

/* a turned about the unit vector `axis`, counter-clockwise seen against it (Rodrigues). */
export function turn(a, axis, angle) {
    const c = Math.cos(angle), s = Math.sin(angle);
    return add(add(scale(a, c), scale(cross(axis, a), s)), scale(axis, dot(axis, a) * (1 - c)));
}

/* The signed axis that a direction is nearest to. */
export function nearestAxis(a) {
    const sizes = a.map(Math.abs);
    const k = sizes.indexOf(Math.max(...sizes));
    const axis = [0, 0, 0];
    axis[k] = a[k] < 0 ? -1 : 1;
    return axis;
}
