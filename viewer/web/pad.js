/* SPDX-License-Identifier: Apache-2.0 */
/* A pad for two variables of a position: one finger moves both. */
import { h } from './dom.js';
import { clamp, showValue, title } from './format.js';
import { basis, worldUp } from './camera.js';
import { add, dot } from './vec.js';
import { holdWhileDown, keyStep } from './slider.js';

const AXES = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };

const axisOf = variable => AXES[variable.name.split('.').pop()];

/* Which members the pad gets and how they lie, so that things move as they do in the picture from
 * where the scene is first seen. Returns {across, along, rest}: {index, isFlipped} each. */
export function layPad(store, indices) {
    const { hello, variables } = store;
    const up = worldUp(hello);
    let members = indices.map(index => ({ index, axis: axisOf(variables[index]) ?? AXES.x }));
    let rest = null;
    if (members.length > 2) {
        rest = members.find(m => Math.abs(dot(m.axis, up)) > 0.5) ?? members[2];
        members = members.filter(m => m !== rest);
    }
    const { forward, right } = basis(hello.camera);
    const sideways = m => Math.abs(dot(m.axis, right));
    members.sort((a, b) => sideways(b) - sideways(a));
    const [across, along] = members;
    across.isFlipped = dot(across.axis, right) < 0;
    /* Up on the pad is away from the camera, or up. */
    along.isFlipped = dot(along.axis, add(forward, up)) < 0;
    return { across, along, rest };
}

export function makePad(store, across, along, label) {
    const vx = store.variables[across.index], vy = store.variables[along.index];
    const share = (v, x, isFlipped) => {
        const u = v.max > v.min ? (x - v.min) / (v.max - v.min) : 0.5;
        return isFlipped ? 1 - u : u;
    };
    const value = (v, u, isFlipped) => v.min
        + (isFlipped ? 1 - clamp(u, 0, 1) : clamp(u, 0, 1)) * (v.max - v.min);
    const member = v => title(v.name.split('.').pop());

    const dot_ = h('span', { class: 'pad-dot' });
    const lineX = h('span', { class: 'pad-line-x' }), lineY = h('span', { class: 'pad-line-y' });
    const element = h('div', {
        class: 'pad', role: 'slider', tabindex: '0', 'aria-label': label,
        'aria-roledescription': 'pad', 'data-pad': `${vx.name} ${vy.name}`,
        'aria-valuemin': vx.min, 'aria-valuemax': vx.max,
        onpointerdown: event => {
            element.setPointerCapture(event.pointerId);
            place(event);
        },
        onpointermove: event => {
            if (element.hasPointerCapture(event.pointerId)) place(event);
        },
        onkeydown: event => {
            const isAcross = event.key === 'ArrowLeft' || event.key === 'ArrowRight';
            const end = event.key === 'Home' || event.key === 'End';
            const v = isAcross ? vx : vy, m = isAcross ? across : along;
            const step = keyStep(event, v.min, v.max);
            if (step === undefined && !end) return;
            event.preventDefault();
            if (end) {
                const name = event.key === 'Home' ? 'min' : 'max';
                set(vx[name], vy[name]);
            } else {
                store.setValue(m.index, store.values[m.index] + (m.isFlipped ? -step : step),
                               { moving: true });
            }
        },
    }, lineX, lineY, dot_,
    h('span', { class: 'pad-name-x', 'aria-hidden': 'true' },
      across.isFlipped ? `← ${member(vx)}` : `${member(vx)} →`),
    h('span', { class: 'pad-name-y', 'aria-hidden': 'true' },
      along.isFlipped ? `${member(vy)} ↓` : `${member(vy)} ↑`));
    holdWhileDown(element, store);

    function set(x, y) {
        store.change({ values: [[across.index, x], [along.index, y]] }, { moving: true });
    }

    function place(event) {
        const r = element.getBoundingClientRect();
        set(value(vx, (event.clientX - r.left) / r.width, across.isFlipped),
            value(vy, 1 - (event.clientY - r.top) / r.height, along.isFlipped));
    }

    let shown = '';
    function update() {
        const x = store.values[across.index], y = store.values[along.index];
        if (shown === `${x} ${y}`) return;
        shown = `${x} ${y}`;
        const left = `${share(vx, x, across.isFlipped) * 100}%`;
        const top = `${(1 - share(vy, y, along.isFlipped)) * 100}%`;
        dot_.style.left = lineX.style.left = left;
        dot_.style.top = lineY.style.top = top;
        element.setAttribute('aria-valuenow', x);
        element.setAttribute('aria-valuetext', `${member(vx)} ${showValue(vx, x)}, `
            + `${member(vy)} ${showValue(vy, y)}`);
    }
    update();
    return { element, update };
}
