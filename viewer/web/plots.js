/* SPDX-License-Identifier: Apache-2.0 */
/* Drawings of the training: the loss over time, configurations over variables. */
import { h, svg } from './dom.js';
import { isDiscrete, seconds, short, title } from './format.js';

const WIDTH = 360, HEIGHT = 150;
const MARGIN = { left: 40, right: 8, top: 8, bottom: 20 };

/* history: list of [seconds, loss]; the axis of the loss is logarithmic. */
export function lossPlot(history) {
    const points = history.filter(([s, loss]) => s >= 0 && loss > 0);
    if (points.length < 2) return h('p', { class: 'soft' }, 'No curve yet.');
    const { left, right, top, bottom } = MARGIN;
    const logs = points.map(([, loss]) => Math.log10(loss));
    let lo = Math.min(...logs), hi = Math.max(...logs);
    if (hi - lo < 0.1) [lo, hi] = [lo - 0.05, hi + 0.05];
    const end = points.at(-1)[0] || 1;
    const x = s => left + (WIDTH - left - right) * s / end;
    const y = l => top + (HEIGHT - top - bottom) * (hi - l) / (hi - lo);
    const line = points.map(([s], k) => `${x(s).toFixed(1)},${y(logs[k]).toFixed(1)}`).join(' ');
    const ticks = logTicks(lo, hi).map(value => [
        svg('line', { class: 'plot-grid', x1: left, x2: WIDTH - right, y1: y(Math.log10(value)),
                      y2: y(Math.log10(value)) }),
        svg('text', { class: 'plot-text', x: left - 4, y: y(Math.log10(value)) + 3.5,
                      'text-anchor': 'end' }, short(value, 2)),
    ]);
    const [first, last] = [points[0], points.at(-1)];
    return svg('svg', {
        viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: 'img',
        'aria-label': `Loss from ${short(first[1], 3)} to ${short(last[1], 3)} in `
            + `${seconds(last[0])}, logarithmic axis`,
    }, ...ticks.flat(), svg('polyline', { class: 'plot-line', points: line }),
    svg('text', { class: 'plot-text', x: left, y: HEIGHT - 5 }, '0'),
    svg('text', { class: 'plot-text', x: WIDTH - right, y: HEIGHT - 5, 'text-anchor': 'end' },
        seconds(end)));
}

/* Round values between two logarithms: 1, 2, 5 of each decade, fewer when they are many. */
function logTicks(lo, hi) {
    const steps = hi - lo > 2.2 ? [1] : hi - lo > 0.9 ? [1, 3] : [1, 1.5, 2, 3, 5, 7];
    const ticks = [];
    for (let e = Math.floor(lo); e <= Math.ceil(hi); e++) {
        for (const step of steps) {
            const value = step * 10 ** e;
            if (Math.log10(value) >= lo && Math.log10(value) <= hi) ticks.push(value);
        }
    }
    return ticks.length > 0 ? ticks : [10 ** ((lo + hi) / 2)];
}

/* About a dozen lines of the history, for who cannot see the curve. */
export function lossTable(history) {
    const step = Math.max(1, Math.ceil(history.length / 12));
    const rows = history.filter((_, k) => k % step === 0 || k === history.length - 1);
    return h('table', null,
             h('thead', null, h('tr', null, h('th', { scope: 'col' }, 'Time'),
                                h('th', { scope: 'col' }, 'Loss'))),
             h('tbody', null, rows.map(([s, loss]) => h('tr', null, h('td', null, seconds(s)),
                                                        h('td', null, short(loss, 4))))));
}

/* One axis for each variable, one line for each configuration; the newest are strongest.
 * choose(k): a line was clicked. chosen: drawn thicker. */
export function statesPlot({ variables, states, current, chosen, choose }) {
    if (states.length === 0 || variables.length === 0) {
        return h('p', { class: 'soft' }, 'No configurations yet.');
    }
    const n = variables.length;
    const top = 8, bottom = 52, height = 210;
    const left = 34, right = 10;
    const x = i => (n > 1 ? left + (WIDTH - left - right) * i / (n - 1) : WIDTH / 2);
    const y = (i, value) => {
        const { min, max } = variables[i];
        const u = max > min ? Math.min(1, Math.max(0, (value - min) / (max - min))) : 0.5;
        return top + (height - top - bottom) * (1 - u);
    };
    const line = values => values.slice(0, n).map((v, i) => `${x(i).toFixed(1)},`
        + `${y(i, v).toFixed(1)}`).join(' ');
    const skip = Math.ceil(n / 14); /* names must not run into each other */
    const axes = variables.flatMap((v, i) => [
        svg('line', { class: 'plot-axis', x1: x(i), x2: x(i), y1: top, y2: height - bottom }),
        i % skip === 0 ? svg('text', {
            class: 'plot-text', 'text-anchor': 'end',
            transform: `translate(${x(i) + 3} ${height - bottom + 9}) rotate(-40)`,
        }, v.name.length > 11 ? `${v.name.slice(0, 10)}…` : v.name) : null,
    ]);
    const lines = states.map((values, k) => svg('g', { class: 'state', 'data-state': k,
                                                       /* A click may end on what replaced it. */
                                                       onpointerdown: () => choose(k) },
        svg('title', null, describe(variables, values)),
        /* A wide line that is not seen makes the thin one easy to hit. */
        svg('polyline', { class: 'state-hit', points: line(values) }),
        svg('polyline', { class: k === chosen ? 'state-line chosen' : 'state-line',
                          'stroke-opacity': (0.25 + 0.75 * (k + 1) / states.length).toFixed(2),
                          points: line(values) })));
    return svg('svg', {
        viewBox: `0 0 ${WIDTH} ${height}`, role: 'img',
        'aria-label': `${states.length} configurations over ${n} variables; the list below has `
            + 'them as text',
    }, ...axes, ...lines,
    svg('polyline', { class: 'state-current', points: line(current) }));
}

export function describe(variables, values) {
    return variables.map((v, i) => {
        const x = values[i];
        const text = isDiscrete(v) ? v.choices[Math.round(x - v.min)] : short(x, 3);
        return `${title(v.name)} ${text}`;
    }).join(', ');
}
