/* SPDX-License-Identifier: Apache-2.0 */
/* Numbers for people and for command lines. */

/* Decimals that tell a thousandth of a range apart: what sliders set and boxes show. */
export function decimals(min, max) {
    const range = Math.abs(max - min);
    if (!(range > 0)) return 3;
    return Math.min(8, Math.max(0, 3 - Math.floor(Math.log10(range))));
}

export function clamp(x, min, max) {
    return Math.min(max, Math.max(min, x));
}

export function isDiscrete(variable) {
    return Array.isArray(variable.choices) && variable.choices.length > 0;
}

/* The nearest value that a variable can have, rounded to what its box shows. */
export function quantise(variable, x) {
    const { min, max } = variable;
    if (!Number.isFinite(x)) return variable.value;
    if (isDiscrete(variable)) return clamp(Math.round(x), min, max);
    return clamp(Number(x.toFixed(decimals(min, max))), min, max);
}

/* Up to `digits` significant digits without needless zeros. */
export function short(x, digits = 4) {
    if (x == null || !Number.isFinite(x)) return '–';
    return String(Number(x.toPrecision(digits)));
}

export function fixed(x, digits) {
    return x == null || !Number.isFinite(x) ? '–' : x.toFixed(digits);
}

export function showValue(variable, x) {
    if (isDiscrete(variable)) return variable.choices[Math.round(x - variable.min)] ?? String(x);
    return x.toFixed(decimals(variable.min, variable.max));
}

const UNITS = { deg: '°', degrees: '°' };

export function unitSign(unit) {
    return UNITS[unit] ?? unit ?? '';
}

/* chest_turn becomes "Chest turn". */
export function title(name) {
    const words = name.replaceAll('_', ' ');
    return words.charAt(0).toUpperCase() + words.slice(1);
}

export function bytes(n) {
    if (!Number.isFinite(n)) return '–';
    if (n < 1000) return `${Math.round(n)} B`;
    if (n < 1e6) return `${(n / 1e3).toFixed(1)} kB`;
    return `${(n / 1e6).toFixed(2)} MB`;
}

export function seconds(s) {
    if (!Number.isFinite(s)) return '–';
    if (s < 60) return `${s.toFixed(1)} s`;
    const m = Math.floor(s / 60);
    const rest = String(Math.floor(s % 60)).padStart(2, '0');
    return m < 60 ? `${m}:${rest} min` : `${Math.floor(m / 60)} h ${m % 60} min`;
}

/* One word of a POSIX shell's command line. */
export function quote(word) {
    return /^[\w@%+=:,./-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`;
}
