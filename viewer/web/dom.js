/* SPDX-License-Identifier: Apache-2.0 */
/* Making elements. Styles are never attributes: the page's policy forbids them. */

const SVG = 'http://www.w3.org/2000/svg';

export const $ = id => document.getElementById(id);

function fill(element, attributes, children) {
    for (const [name, value] of Object.entries(attributes ?? {})) {
        if (typeof value === 'function') element.addEventListener(name.slice(2), value);
        else if (value === true) element.setAttribute(name, '');
        else if (value !== false && value != null) element.setAttribute(name, value);
    }
    element.append(...children.flat().filter(child => child != null));
    return element;
}

/* h('button', {class: 'plain', onclick: f}, 'text', node): functions become listeners. */
export function h(tag, attributes, ...children) {
    return fill(document.createElement(tag), attributes, children);
}

export function svg(tag, attributes, ...children) {
    return fill(document.createElementNS(SVG, tag), attributes, children);
}

/* Strokes on a square of 24. */
const ICONS = {
    mark: 'M12 3a9 9 0 1 0 0 18a9 9 0 0 0 0-18z M12 3v18 M12 8h7.5 M12 12h9 M12 16h7.5',
    undo: 'M4 9h10a6 6 0 0 1 0 12h-3 M8 5l-4 4l4 4',
    redo: 'M20 9H10a6 6 0 0 0 0 12h3 M16 5l4 4l-4 4',
    reset: 'M5 12a7 7 0 1 0 2.5-5.4 M4 4v4.5h4.5',
    lock: 'M6 11h12v9H6z M8.5 11V7.5a3.5 3.5 0 0 1 7 0V11',
    unlock: 'M6 11h12v9H6z M8.5 11V7.5a3.5 3.5 0 0 1 6.6-1.6',
    theme: 'M12 3a9 9 0 1 0 0 18a9 9 0 0 0 0-18z M12 3v18 M12 6.5h6.5 M12 10h8.6 M12 14h8.6 '
        + 'M12 17.5h6.5',
    help: 'M9 9a3 3 0 1 1 4.6 2.5c-1 .7-1.6 1.2-1.6 2.5 M12 17.6v.4',
    dice: 'M4 4h16v16H4z M8.5 8.5v.1 M15.5 8.5v.1 M12 12v.1 M8.5 15.5v.1 M15.5 15.5v.1',
    swap: 'M7 7h13 M17 4l3 3l-3 3 M17 17H4 M7 14l-3 3l3 3',
    play: 'M7 4.5v15l12-7.5z',
    pause: 'M8 5v14 M16 5v14',
    stop: 'M6 6h12v12H6z',
    plus: 'M12 5v14 M5 12h14',
    trash: 'M4 7h16 M9 7V4h6v3 M6.5 7l1 13h9l1-13',
    copy: 'M9 9h11v11H9z M5 15H4V4h11v1',
    link: 'M10 14a4 4 0 0 0 5.7 0l3-3a4 4 0 0 0-5.7-5.7l-1 1 M14 10a4 4 0 0 0-5.7 0l-3 3a4 4 0 0 '
        + '0 5.7 5.7l1-1',
    download: 'M12 4v11 M7 10.5l5 5l5-5 M5 20h14',
    upload: 'M12 16V5 M7 9.5l5-5l5 5 M5 20h14',
    full: 'M4 9V4h5 M15 4h5v5 M20 15v5h-5 M9 20H4v-5',
    go: 'M5 12h14 M13 6l6 6l-6 6',
    replace: 'M4 12a8 8 0 0 1 13.5-5.8L20 8.5 M20 4v4.5h-4.5 M20 12a8 8 0 0 1-13.5 5.8L4 15.5 '
        + 'M4 20v-4.5h4.5',
};

export function icon(name) {
    return svg('svg', { viewBox: '0 0 24 24', class: 'icon', 'aria-hidden': 'true' },
               svg('path', { d: ICONS[name] }));
}

/* A button with an icon only; its label is read aloud and shown as a hint. */
export function iconButton(name, label, attributes, click) {
    return h('button', { type: 'button', class: 'plain', 'aria-label': label, title: label,
                         onclick: click, ...attributes }, icon(name));
}

/* Swaps the icon of a button. */
export function setIcon(button, name) {
    button.querySelector('svg')?.replaceWith(icon(name));
}

/* Buttons of index.html name their icon: data-icon="undo". */
export function placeIcons() {
    for (const e of document.querySelectorAll('[data-icon]')) e.prepend(icon(e.dataset.icon));
}

/* Runs f once in the next animation frame, however often it is asked for; a hidden page has no
 * animation frames, so a timer stands in. */
export function onceAFrame(f) {
    let pending = false;
    const run = () => {
        if (!pending) return;
        pending = false;
        f();
    };
    return () => {
        if (pending) return;
        pending = true;
        if (document.hidden) setTimeout(run, 50);
        else requestAnimationFrame(run);
    };
}

/* Offers a file to the user. */
export function download(blob, name) {
    const url = URL.createObjectURL(blob);
    const a = h('a', { href: url, download: name });
    document.body.append(a);
    a.click();
    a.remove();
    setTimeout(() => URL.revokeObjectURL(url), 60000);
}
