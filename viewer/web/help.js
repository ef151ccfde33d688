/* SPDX-License-Identifier: Apache-2.0 */
/* Keys: one table that the dialog lists and the page obeys. */
import { $, h } from './dom.js';

const LISTS = [
    ['Everywhere', [
        ['?', 'This list'],
        ['Ctrl+Z', 'Undo'],
        ['Ctrl+Shift+Z or Ctrl+Y', 'Redo'],
        ['Tab', 'To the next control'],
    ]],
    ['On the picture', [
        ['Drag, arrow keys', 'Orbit, pan or look around, as chosen under Camera'],
        ['Right drag, Shift+drag, Shift+arrows', 'Pan'],
        ['Middle drag', 'Look around'],
        ['Wheel, pinch, + and -', 'Zoom'],
        ['W A S D', 'Fly forward, left, back, right (Shift: faster)'],
        ['E and Q', 'Fly up and down'],
        ['0', "Back to the scene's camera"],
        ['1 to 5', 'Neural, traced, split, error, buffer'],
        ['X', 'Swap the sides of the split; with the divider at an edge: flip'],
        ['P', 'Pixel readout on and off'],
        ['R', 'Randomise the variables'],
        ['F', 'Full screen'],
    ]],
    ['On the divider', [
        ['Arrow keys', 'Move it (Shift: faster)'],
        ['Home and End', 'To the edges'],
    ]],
    ['On sliders and pads', [
        ['Arrow keys', 'A hundredth of the range (Shift: a thousandth)'],
        ['Page Up and Page Down', 'A tenth of the range'],
        ['Home and End', 'To the ends of the range'],
    ]],
];

const KEY = 'lumenaut.single-keys';

function kept() {
    try {
        return localStorage.getItem(KEY) !== 'off';
    } catch {
        return true;
    }
}

const isText = e => e.matches?.('textarea, select, input:not([type=range], [type=checkbox], '
    + '[type=radio], [type=color])');

/* actions: {undo, redo, navigate, fly, keys: {letter: function}}. */
export function startKeys(actions) {
    $('help-keys').append(...LISTS.map(([title, keys]) => h('section', null,
        h('h3', null, title),
        h('dl', { class: 'keys' }, keys.map(([key, what]) => h('div', null,
            h('dt', null, h('kbd', null, key)), h('dd', null, what)))))));
    const single = $('single-keys');
    single.checked = kept();
    single.addEventListener('change', () => {
        try {
            localStorage.setItem(KEY, single.checked ? 'on' : 'off');
        } catch { /* holds until the page is left */ }
    });
    const open = () => {
        if (!$('help').open) $('help').showModal();
    };
    $('help-open').addEventListener('click', open);

    document.addEventListener('keydown', event => {
        if (event.defaultPrevented || document.querySelector('dialog[open]')) return;
        const key = event.key.toLowerCase();
        if ((event.ctrlKey || event.metaKey) && !event.altKey && (key === 'z' || key === 'y')) {
            /* A text box has an undo of its own. */
            if (event.target.matches?.('input[type=text], textarea')) return;
            event.preventDefault();
            if (key === 'y' || event.shiftKey) actions.redo();
            else actions.undo();
            return;
        }
        if (event.ctrlKey || event.metaKey || event.altKey || isText(event.target)) return;
        if (event.key === '?' && single.checked) {
            event.preventDefault();
            open();
            return;
        }
        /* Letters act on the picture only, so that they never surprise who types elsewhere. */
        const isPicture = event.target === $('stage');
        if (!isPicture) return;
        let isMine = actions.navigate(event);
        if (!isMine && single.checked) {
            isMine = actions.fly(event);
            if (!isMine && Object.hasOwn(actions.keys, key) && !event.repeat) {
                actions.keys[key]();
                isMine = true;
            }
        }
        if (isMine) event.preventDefault();
    });
}
