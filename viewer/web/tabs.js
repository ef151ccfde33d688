/* SPDX-License-Identifier: Apache-2.0 */
/* Tabs of the panel. On a wall the scene's controls have a column of their own beside the rest. */
import { $ } from './dom.js';

const WALL = '(min-width: 1800px)';

export function startTabs() {
    const tabs = [...document.querySelectorAll('[role=tab]')];
    const wall = matchMedia(WALL);
    const panelOf = tab => $(tab.getAttribute('aria-controls'));
    const scene = tabs[0];
    let chosen = scene;

    function draw() {
        const isWall = wall.matches;
        scene.hidden = isWall;
        let shown = chosen;
        if (shown.hidden) shown = tabs.find(tab => !tab.hidden);
        for (const tab of tabs) {
            const isShown = tab === shown;
            tab.setAttribute('aria-selected', String(isShown));
            tab.tabIndex = isShown ? 0 : -1;
            const panel = panelOf(tab);
            const wasHidden = panel.hidden;
            panel.hidden = !isShown && !(isWall && tab === scene);
            /* What draws only what can be seen catches up. */
            if (wasHidden && !panel.hidden) panel.dispatchEvent(new Event('shown'));
        }
        /* A tab panel needs its tab; a column of its own is a plain region. */
        const panel = panelOf(scene);
        panel.setAttribute('role', isWall ? 'region' : 'tabpanel');
        if (isWall) panel.setAttribute('aria-label', 'Scene');
        else panel.removeAttribute('aria-label');
        if (isWall) panel.removeAttribute('aria-labelledby');
        else panel.setAttribute('aria-labelledby', scene.id);
    }

    function choose(tab, withFocus) {
        chosen = tab;
        draw();
        if (withFocus) tab.focus();
    }

    for (const tab of tabs) tab.addEventListener('click', () => choose(tab, false));
    $('tabs').addEventListener('keydown', event => {
        const open = tabs.filter(tab => !tab.hidden);
        const at = open.indexOf(document.activeElement);
        const to = { ArrowLeft: at - 1, ArrowRight: at + 1, Home: 0, End: open.length - 1 }[
            event.key];
        if (at < 0 || to === undefined) return;
        event.preventDefault();
        choose(open[(to + open.length) % open.length], true);
    });
    wall.addEventListener('change', draw);
    draw();
    return {
        show: name => choose($(`tab-${name}`), false),
        setPresent(name, isPresent) {
            $(`tab-${name}`).hidden = !isPresent;
            draw();
        },
    };
}
