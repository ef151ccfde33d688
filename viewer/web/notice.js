/* SPDX-License-Identifier: Apache-2.0 */
/* Words to the user: the state of the connection, and messages that pass. */
import { $, h } from './dom.js';

const SHOWN_MS = 8000;
const MOST = 4;

export function toast(text, isError = false) {
    const list = $('toasts');
    /* The same again is no news. */
    for (const other of list.children) {
        if (other.dataset.text === text) other.remove();
    }
    while (list.children.length >= MOST) list.firstElementChild.remove();
    const close = h('button', { type: 'button', class: 'plain', 'aria-label': 'Dismiss',
                                onclick: () => note.remove() }, '×');
    const note = h('p', { class: 'toast', 'data-kind': isError ? 'error' : 'note',
                          'data-text': text },
                   h('span', null, isError ? h('strong', null, 'Error: ') : null, text), close);
    list.append(note);
    setTimeout(() => note.remove(), isError ? 2 * SHOWN_MS : SHOWN_MS);
}

/* Words for who listens only: what others see anyway. */
export function announce(text) {
    $('announcer').textContent = text;
}

const SIGNS = { connecting: '…', open: '●', lost: '!' };
const WORDS = { connecting: 'Connecting', open: 'Connected', lost: 'Not connected' };

/* state: connecting, open, lost. */
export function showStatus(state, text = WORDS[state]) {
    const status = $('status');
    if (status.dataset.state === state && $('status-text').textContent === text) return;
    status.dataset.state = state;
    status.title = text;
    $('status-sign').textContent = SIGNS[state];
    $('status-text').textContent = text;
}

export function watchConnection(connection) {
    let countdown = 0;
    $('notice-retry').addEventListener('click', () => connection.retry());

    connection.addEventListener('open', () => {
        clearInterval(countdown);
        showStatus('connecting', 'Greeting');
    });
    connection.addEventListener('message', ({ detail: m }) => {
        if (m.type === 'hello') {
            clearInterval(countdown);
            showStatus('open');
            $('notice').hidden = true;
        }
        if (m.type === 'error') toast(m.message, true);
    });
    connection.addEventListener('lost', ({ detail }) => {
        clearInterval(countdown);
        showStatus('lost');
        $('notice').hidden = false;
        const why = detail.wasOpen ? 'The viewer does not answer.'
            : detail.tries < 3 ? 'The viewer cannot be reached.'
                : 'The viewer cannot be reached. If it asks for a token, open the address that it '
                    + 'printed.';
        const until = performance.now() + detail.wait_ms;
        const say = () => {
            const left = Math.ceil((until - performance.now()) / 1000);
            $('notice-text').textContent = left > 1 ? `${why} Trying again in ${left} s.`
                : `${why} Trying again.`;
        };
        say();
        countdown = setInterval(say, 1000);
    });
}
