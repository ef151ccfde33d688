/* SPDX-License-Identifier: Apache-2.0 */
/* The camera's tab: whose camera it is, named and kept views, limits and a plan of the scene. */
import { $, h, onceAFrame, svg } from './dom.js';
import { short, title } from './format.js';
import { diagonal, isInside, namedView, worldUp } from './camera.js';
import { normalize, sub } from './vec.js';
import { isCamera } from './store.js';
import { Shelf } from './shelf.js';

const NAMED = ['top', 'front', 'left', 'right', 'back'];
const MAP = 100; /* units of the plan's drawing */

export class CameraPanel {
    #store;
    #navigation;
    #shelf;

    constructor(store, navigation) {
        this.#store = store;
        this.#navigation = navigation;
        const go = camera => store.change({ camera });
        $('views').append(
            h('button', { type: 'button', 'data-view': 'default', onclick: () => go(null) },
              'Default'),
            ...NAMED.map(name => h('button', {
                type: 'button', 'data-view': name,
                onclick: () => go(namedView(name, store.hello)),
            }, title(name))));
        $('camera-reset').addEventListener('click', () => go(null));
        for (const radio of document.querySelectorAll('input[name=drag]')) {
            radio.addEventListener('change', () => { navigation.dragMode = radio.value; });
        }
        const speed = $('fly-speed');
        const drawSpeed = () => {
            navigation.speed = 10 ** speed.valueAsNumber;
            $('fly-speed-now').textContent = `${short(navigation.speed * 100, 2)} %/s`;
            speed.setAttribute('aria-valuetext',
                               `${short(navigation.speed * 100, 2)} percent of the scene a second`);
        };
        speed.addEventListener('input', drawSpeed);
        drawSpeed();
        const setFov = (fov, how) => {
            if (fov > 0) go_(Math.min(170, Math.max(1, fov)), how);
        };
        const go_ = (fov, how) => store.change({ camera: { ...navigation.camera, fov } }, how);
        $('fov').addEventListener('input', () => setFov($('fov').valueAsNumber, { moving: true }));
        $('fov-number').addEventListener('change',
                                         () => setFov($('fov-number').valueAsNumber));
        this.#shelf = new Shelf({
            key: 'views', form: $('view-form'), input: $('view-name'), list: $('saved-views'),
            what: 'view', isSound: isCamera, take: () => navigation.camera, use: go,
        });
        const draw = onceAFrame(() => this.#draw());
        $('panel-camera').addEventListener('shown', draw);
        store.listen(what => {
            if (what.values || what.camera) draw();
        });
    }

    greet() {
        this.#shelf.open(this.#store.hello.scene);
        $('fov-field').hidden = Boolean(this.#store.hello.orthographic);
        this.#draw();
    }

    #draw() {
        const { hello, camera: own } = this.#store;
        if (!hello || $('panel-camera').hidden) return;
        const camera = this.#navigation.camera;
        $('camera-whose').textContent = own
            ? 'Your own camera; the scene keeps its.'
            : "The scene's camera, as the variables say. Move in the picture to take your own.";
        $('camera-reset').setAttribute('aria-disabled', String(own === null));
        if (document.activeElement !== $('fov-number')) {
            $('fov-number').value = short(camera.fov);
        }
        $('fov').value = camera.fov;
        const point = p => p.map(x => short(x, 4)).join(', ');
        const { bounds } = hello;
        const inside = isInside(camera.origin, bounds);
        const facts = [
            ['origin', 'From', point(camera.origin)],
            ['target', 'To', point(camera.target)],
            ['up', 'Up', point(camera.up)],
            ['kind', 'Kind', hello.orthographic ? `Orthographic, ${short(camera.fov, 4)} wide`
                : `Perspective, ${short(camera.fov)}°`],
            ['min', 'Scene from', point(bounds.min)],
            ['max', 'Scene to', point(bounds.max)],
            ['inside', 'Stands', inside ? "within the scene's bounds"
                : "outside the scene's bounds"],
        ];
        $('camera-facts').replaceChildren(...facts.map(([key, name, text]) => h('div', {
            'data-fact': key }, h('dt', null, name), h('dd', null, text))));
        $('camera-map').replaceChildren(this.#map(camera, inside));
    }

    /* Seen from above: the bounds, where the camera stands and where it looks. */
    #map(camera, inside) {
        const { hello } = this.#store;
        const { min, max } = hello.bounds;
        const w = worldUp(hello);
        const up = w.findIndex(x => x !== 0);
        const [i, j] = [0, 1, 2].filter(k => k !== up);
        /* With y up the picture's bottom is +z, with z up it is -y: as seen from the front. */
        const sign = up === 1 ? 1 : -1;
        const at = p => [p[i], sign * p[j]];
        const a = at(min), b = at(max);
        const pad = 0.35 * diagonal(hello);
        const lo = [Math.min(a[0], b[0]) - pad, Math.min(a[1], b[1]) - pad];
        const hi = [Math.max(a[0], b[0]) + pad, Math.max(a[1], b[1]) + pad];
        const s = MAP / Math.max(hi[0] - lo[0], hi[1] - lo[1]);
        const place = p => [(p[0] - lo[0]) * s, (p[1] - lo[1]) * s];
        const width = (hi[0] - lo[0]) * s, height = (hi[1] - lo[1]) * s;
        const corner = place([Math.min(a[0], b[0]), Math.min(a[1], b[1])]);
        const inMap = ([x, y]) => [Math.min(width - 3, Math.max(3, x)),
                                   Math.min(height - 3, Math.max(3, y))];
        const eye = inMap(place(at(camera.origin)));
        const d = at(normalize(sub(camera.target, camera.origin)));
        const angle = Math.atan2(d[1], d[0]);
        const ray = t => [eye[0] + 22 * Math.cos(angle + t), eye[1] + 22 * Math.sin(angle + t)]
            .join(',');
        const half = (hello.orthographic ? 20 : camera.fov) * Math.PI / 360;
        return svg('svg', {
            viewBox: `0 0 ${width} ${height}`, role: 'img', class: 'map',
            'aria-label': `Plan of the scene: the camera stands ${inside ? 'within' : 'outside'} `
                + 'its bounds',
        },
        svg('rect', { class: 'map-bounds', x: corner[0], y: corner[1],
                      width: Math.abs(b[0] - a[0]) * s, height: Math.abs(b[1] - a[1]) * s }),
        /* Straight up or down there is no way to point: a ring. */
        Math.hypot(...d) < 0.05 ? svg('circle', { class: 'map-view', cx: eye[0], cy: eye[1], r: 8 })
            : svg('polygon', { class: 'map-view',
                               points: `${eye[0]},${eye[1]} ${ray(-half)} ${ray(half)}` }),
        svg('circle', { class: 'map-eye', cx: eye[0], cy: eye[1], r: 2.5 }));
    }
}
