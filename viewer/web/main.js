/* SPDX-License-Identifier: Apache-2.0 */
/* Puts the page together. */
import { $, onceAFrame, placeIcons } from './dom.js';
import { Store } from './store.js';
import { Connection } from './socket.js';
import { Session } from './session.js';
import { Stage } from './stage.js';
import { startSplit } from './split.js';
import { View } from './view.js';
import { Controls } from './controls.js';
import { Navigation } from './navigate.js';
import { CameraPanel } from './camera_panel.js';
import { Stats } from './stats.js';
import { Readout } from './readout.js';
import { Capture } from './capture.js';
import { Share } from './share.js';
import { Shelf } from './shelf.js';
import { PathEditor } from './path.js';
import { Training } from './training.js';
import { commandLine, commandNote, copyText } from './command.js';
import { toast, watchConnection } from './notice.js';
import { startTabs } from './tabs.js';
import { startKeys } from './help.js';

placeIcons();

const store = new Store();
const connection = new Connection();
const session = new Session(connection, store, () => stage.size());
const stage = new Stage(connection, store, session);
const tabs = startTabs();
const split = startSplit(store, stage);
const view = new View(store, stage);
const controls = new Controls(store);
const navigation = new Navigation(store, session);
const cameraPanel = new CameraPanel(store, navigation);
const readout = new Readout(connection, store, stage);
const share = new Share(store);
const path = new PathEditor(store, stage);
const training = new Training(connection, store, tabs);
const presets = new Shelf({
    key: 'presets', form: $('preset-form'), input: $('preset-name'), list: $('presets'),
    what: 'preset', isSound: thing => typeof thing?.values === 'object',
    take: () => store.save(), use: thing => store.load(thing),
});
new Stats(connection, stage);
new Capture(connection, store, stage);
watchConnection(connection);

/* The server's first words, also after it went away and came back. */
function greet(hello) {
    if (hello.protocol !== 1) {
        toast(`The viewer speaks protocol ${hello.protocol}, this page 1: reload the page.`, true);
        return;
    }
    const isNew = store.start(hello);
    document.title = `${hello.model ?? hello.scene} – Lumenaut`;
    $('program').title = hello.program;
    $('scene-name').textContent = (hello.model ?? hello.scene).split('/').slice(-2).join('/');
    $('scene-name').title = hello.model ? `${hello.model}, scene ${hello.scene}` : hello.scene;
    if (isNew) {
        controls.build();
        presets.open(hello.scene);
        path.greet();
        share.greet();
    }
    view.greet();
    split.draw();
    cameraPanel.greet();
    training.greet();
    stage.greet();
    drawCommand();
    drawHistory();
    session.greet();
    if (hello.notice) toast(hello.notice, true);
}

connection.addEventListener('message', ({ detail: message }) => {
    if (message.type === 'hello') greet(message);
});

const drawCommand = onceAFrame(() => {
    if (!store.hello) return;
    $('command').textContent = commandLine(store, stage.size());
    $('command-note').textContent = commandNote(store);
});

function drawHistory() {
    $('undo').setAttribute('aria-disabled', String(!store.canUndo));
    $('redo').setAttribute('aria-disabled', String(!store.canRedo));
}

store.listen(what => {
    if (what.values || what.camera || what.view) drawCommand();
    if (what.history) drawHistory();
});

$('undo').addEventListener('click', () => store.undo());
$('redo').addEventListener('click', () => store.redo());
$('split-swap').addEventListener('click', () => split.swap());
$('copy-link').addEventListener('click', () => copyText(share.link(), 'Link'));
$('copy-command').addEventListener('click',
                                   () => copyText(commandLine(store, stage.size()),
                                                  'Command line'));

function toggleFullscreen() {
    if (document.fullscreenElement) document.exitFullscreen();
    else $('picture-area').requestFullscreen?.();
}

$('fullscreen').addEventListener('click', toggleFullscreen);

function chooseMode(mode) {
    const radio = document.querySelector(`input[name=mode][value=${mode}]`);
    if (!radio.disabled) store.change({ view: { mode } });
}

startKeys({
    undo: () => store.undo(),
    redo: () => store.redo(),
    navigate: event => navigation.key(event),
    fly: event => navigation.fly(event),
    keys: {
        0: () => store.change({ camera: null }),
        1: () => chooseMode('neural'),
        2: () => chooseMode('traced'),
        3: () => chooseMode('split'),
        4: () => chooseMode('error'),
        5: () => chooseMode('buffer'),
        x: () => split.swap(),
        p: () => readout.toggle(),
        r: () => controls.randomise(),
        f: () => toggleFullscreen(),
    },
});

connection.open();
