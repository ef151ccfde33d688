/* SPDX-License-Identifier: Apache-2.0 */
/* Linear reflectance and the sRGB that screens show (IEC 61966-2-1). */
import { clamp } from './format.js';

export function encode(x) {
    const c = clamp(x, 0, 1);
    return c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055;
}

export function decode(x) {
    return x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4;
}

export function toHex(linear) {
    return `#${linear.map(x => Math.round(encode(x) * 255).toString(16).padStart(2, '0'))
        .join('')}`;
}

export function fromHex(hex) {
    return [1, 3, 5].map(k => decode(parseInt(hex.slice(k, k + 2), 16) / 255));
}
