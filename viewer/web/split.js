/* SPDX-License-Identifier: Apache-2.0 */
/* The divider between two pictures: by pointer and by arrow keys. */
import { $ } from './dom.js';
import { clamp } from './format.js';
import { layerName } from './stage.js';

export function startSplit(store, stage) {
    const handle = $('split-handle');

    /* The server does not see the divider: nothing moves as far as it is concerned. */
    const set = u => store.change({ view: { split: clamp(u, 0, 1) } }, { keep: false });

    handle.addEventListener('pointerdown', event => {
        handle.setPointerCapture(event.pointerId);
        store.begin();
        event.stopPropagation();
    });
    handle.addEventListener('pointermove', event => {
        if (!handle.hasPointerCapture(event.pointerId)) return;
        const r = stage.rect;
        set((event.clientX - r.left) / r.width);
    });
    for (const name of ['pointerup', 'pointercancel']) {
        handle.addEventListener(name, event => {
            handle.releasePointerCapture(event.pointerId);
            store.end();
        });
    }
    handle.addEventListener('keydown', event => {
        const step = { ArrowLeft: -0.01, ArrowDown: -0.01, ArrowRight: 0.01, ArrowUp: 0.01,
                       PageDown: -0.1, PageUp: 0.1 }[event.key];
        const end = { Home: 0, End: 1 }[event.key];
        if (step === undefined && end === undefined) return;
        event.preventDefault();
        event.stopPropagation();
        set(end ?? store.view.split + step * (event.shiftKey ? 5 : 1));
    });
    handle.addEventListener('keyup', () => store.commit());

    function draw() {
        const { mode, split, left, right } = store.view;
        const isSplit = mode === 'split';
        for (const id of ['split-handle', 'split-left', 'split-right']) $(id).hidden = !isSplit;
        if (!isSplit) return;
        const percent = Math.round(split * 100);
        handle.style.left = `${split * 100}%`;
        handle.setAttribute('aria-valuenow', percent);
        handle.setAttribute('aria-valuetext',
                            `${layerName(left)} ${percent} %, ${layerName(right)} the rest`);
        $('split-left').textContent = layerName(left);
        $('split-right').textContent = layerName(right);
    }
    store.listen(what => {
        if (what.view) draw();
    });
    return { draw, swap: () => store.change({
        view: { left: store.view.right, right: store.view.left } }) };
}
