/* SPDX-License-Identifier: Apache-2.0 */
/* The training's tab: what it does, how far it is, where in the space of values it learns. */
import { $, h, onceAFrame } from './dom.js';
import { quote, seconds, short } from './format.js';
import { describe, lossPlot, lossTable, statesPlot } from './plots.js';

const MOST_POINTS = 800; /* more are thinned out: the curve keeps its shape */

export class Training {
    #store;
    #tabs;
    #last = null; /* the training message's fields */
    #history = [];
    #states = [];
    #chosen = -1;
    #canTrain = false;
    #isComing = false; /* the training that was asked for: its pictures are wanted */

    constructor(connection, store, tabs) {
        this.#store = store;
        this.#tabs = tabs;
        for (const button of document.querySelectorAll('[data-train]')) {
            button.addEventListener('click', () => {
                if (button.getAttribute('aria-disabled') === 'true') return;
                this.#isComing = Boolean(store.hello.commands.train);
                connection.send({ type: 'train', action: button.dataset.train });
            });
        }
        connection.addEventListener('message', ({ detail: m }) => {
            if (m.type === 'training') this.#take(m);
        });
        $('states-list').addEventListener('change', () => this.#choose(
            $('states-list').selectedIndex, false));
        $('states-list').addEventListener('dblclick', () => this.#go());
        $('states-list').addEventListener('keydown', event => {
            if (event.key === 'Enter') this.#go();
        });
        $('states-go').addEventListener('click', () => this.#go());
        const drawStates = onceAFrame(() => this.#drawPlot());
        store.listen(what => {
            if (what.values) drawStates();
        });
        $('panel-training').addEventListener('shown', () => this.#draw());
    }

    greet() {
        const { can_train: canTrain, training, commands } = this.#store.hello;
        this.#canTrain = Boolean(canTrain);
        this.#last = null;
        this.#history = [];
        this.#states = [];
        if (this.#isComing && this.#store.hello.layers.includes('neural')) {
            this.#store.change({ view: { mode: 'neural' } });
        }
        this.#isComing = false;
        this.#tabs.setPresent('training', this.#canTrain || training !== null);
        $('training-start').hidden = !commands.train;
        $('training-command').textContent = (commands.train ?? []).map(quote).join(' ');
        if (training) this.#take(training);
        else this.#draw();
    }

    #take(m) {
        this.#last = { ...this.#last, ...m };
        const isPoint = p => Array.isArray(p) && p.length === 2 && p.every(Number.isFinite);
        if (Array.isArray(m.history)) this.#history = m.history.filter(isPoint);
        if (isPoint(m.point)) this.#history.push(m.point);
        if (this.#history.length > MOST_POINTS) {
            this.#history = this.#history.filter((_, k) => k % 2 === 0
                || k === this.#history.length - 1);
        }
        if (Array.isArray(m.states)) {
            const n = this.#store.variables.length;
            this.#states = m.states.filter(s => Array.isArray(s) && s.length === n
                && s.every(Number.isFinite));
            this.#drawList();
        }
        this.#draw();
    }

    #choose(k, withList = true) {
        this.#chosen = k;
        if (withList) $('states-list').selectedIndex = k;
        this.#drawPlot();
    }

    #go() {
        const values = this.#states[this.#chosen];
        if (values) this.#store.change({ values: values.map((x, i) => [i, x]) }, { exact: true });
    }

    #draw() {
        const m = this.#last;
        const isRunning = Boolean(m?.running);
        const may = { start: this.#canTrain && !isRunning, pause: this.#canTrain && isRunning,
                      save: this.#canTrain && m !== null, stop: this.#canTrain && m !== null };
        for (const button of document.querySelectorAll('[data-train]')) {
            button.setAttribute('aria-disabled', String(!may[button.dataset.train]));
        }
        const state = m === null ? 'Not started' : isRunning ? 'Running' : 'Paused';
        const text = m?.message ? `${state}: ${m.message}` : state;
        if ($('training-state').textContent !== text) $('training-state').textContent = text;
        const facts = [
            ['step', 'Step', short(m?.step, 9)],
            ['loss', 'Loss', short(m?.loss, 4)],
            ['seconds', 'Time', seconds(m?.seconds)],
            ['configurations', 'Configurations', short(m?.configurations, 9)],
            ['steps_per_s', 'Steps a second', short(m?.steps_per_s, 3)],
        ];
        const share = x => `${Math.round(x * 100)} %`;
        if (m?.acceptance != null) facts.push(['acceptance', 'Accepted', share(m.acceptance)]);
        if (m?.reuse != null) facts.push(['reuse', 'Replayed', share(m.reuse)]);
        $('training-facts').replaceChildren(...facts.map(([key, name, value]) => h('div', null,
            h('dt', null, name), h('dd', { 'data-training': key }, value))));
        const viewing = m?.view_share;
        $('share').value = viewing ?? 0;
        $('share-now').textContent = viewing == null ? '–' : share(viewing);
        if ($('panel-training').hidden) return;
        $('loss-plot').replaceChildren(lossPlot(this.#history));
        $('loss-table').replaceChildren(lossTable(this.#history));
        this.#drawPlot();
    }

    #drawPlot() {
        if ($('panel-training').hidden) return;
        const { variables, values } = this.#store;
        $('states-plot').replaceChildren(statesPlot({
            variables, states: this.#states, current: values, chosen: this.#chosen,
            choose: k => {
                this.#choose(k);
                this.#go();
            },
        }));
    }

    /* New configurations come twice a second: who reads the list must not lose the place. */
    #drawList() {
        const list = $('states-list');
        if (document.activeElement === list && list.options.length > 0
            && this.#states.length === list.options.length) {
            this.#states.forEach((s, k) => {
                list.options[k].textContent = this.#label(s, k);
            });
            return;
        }
        list.replaceChildren(...this.#states.map((s, k) => h('option', { value: k },
                                                             this.#label(s, k))));
        if (this.#chosen >= this.#states.length) this.#chosen = -1;
        list.selectedIndex = this.#chosen;
    }

    #label(values, k) {
        return `${k + 1}: ${describe(this.#store.variables, values)}`;
    }
}
