/* SPDX-License-Identifier: Apache-2.0 */
/* The command line that makes the same picture, and how texts get to the clipboard. */
import { $ } from './dom.js';
import { isDiscrete, quote, short } from './format.js';
import { toast } from './notice.js';

const exact = String; /* as many digits as it takes to read the same number again */

function variableWords(store) {
    const words = [];
    store.variables.forEach((v, i) => {
        if (store.isDefault(i)) return;
        const x = store.values[i];
        const text = isDiscrete(v) ? v.choices[Math.round(x - v.min)] : exact(x);
        words.push('-P', `${v.name}=${text}`);
    });
    return words;
}

function cameraWords(store) {
    const c = store.camera;
    if (!c) return [];
    const point = p => p.map(exact).join(',');
    const words = ['--origin', point(c.origin), '--target', point(c.target), '--up', point(c.up)];
    return [...words, '--fov', exact(c.fov)];
}

function pictureWords(store, size) {
    const words = ['--size', size.join('x')];
    if (store.view.exposure !== 1) words.push('--exposure', exact(store.view.exposure));
    return words;
}

/* Which of the server's commands makes what is shown. */
function commandWords(store) {
    const { commands } = store.hello;
    const { mode, left } = store.view;
    const isTraced = mode === 'traced' || (mode === 'split' && left === 'traced');
    return isTraced ? commands.trace : commands.render ?? commands.trace;
}

export function commandLine(store, size) {
    const words = [...commandWords(store) ?? []];
    if (words.length === 0) return '';
    words.push(...variableWords(store), ...cameraWords(store), ...pictureWords(store, size));
    if (!words.some(word => /^(-o|--output)/.test(word))) words.push('-o', 'picture.png');
    return words.map(quote).join(' ');
}

export function pathCommandLine(store, size) {
    const words = store.hello.commands?.render;
    if (!words) return '';
    const frames = words.map(word => (word === 'picture.png' ? 'frame_%04d.png' : word));
    return [...frames, '--path', 'keys.json', ...pictureWords(store, size)].map(quote).join(' ');
}

/* What the command line cannot say. */
export function commandNote(store) {
    const { mode, buffer, tone, exposure } = store.view;
    const notes = ['Makes this picture without the viewer.'];
    if (tone !== 'srgb') notes.push('PNG files get the sRGB curve, not ACES.');
    if (mode === 'buffer') notes.push(`Add --buffers and -o picture.exr for ${buffer}.`);
    if (mode === 'error') notes.push('For the error map run trace, too, then lumenaut compare.');
    if (exposure !== 1) notes.push(`Exposure ${short(exposure)} is for PNG files only.`);
    return notes.join(' ');
}

/* Pages from other machines without https have no clipboard: a dialog stands in. */
export async function copyText(text, what) {
    try {
        await navigator.clipboard.writeText(text);
        toast(`${what} copied.`);
    } catch {
        $('copy-title').textContent = `${what}: copy with Ctrl+C`;
        $('copy-text').value = text;
        $('copy-dialog').showModal();
        $('copy-text').select();
    }
}
