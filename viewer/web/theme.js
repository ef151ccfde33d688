/* SPDX-License-Identifier: Apache-2.0 */
/* Light or dark: a classic script in the head, so that a kept choice is there before the first
 * paint. The button cycles: as the system says, light, dark. */
(() => {
    const KEY = 'lumenaut.theme';
    const NAMES = { auto: 'Colours: as the system', light: 'Colours: light',
                    dark: 'Colours: dark' };
    const root = document.documentElement;

    function apply(theme) {
        root.dataset.theme = theme;
        const text = document.getElementById('theme-text');
        if (!text) return;
        text.textContent = NAMES[theme];
        text.parentElement.title = NAMES[theme];
    }

    function kept() {
        try {
            const theme = localStorage.getItem(KEY);
            return Object.hasOwn(NAMES, theme) ? theme : 'auto';
        } catch {
            return 'auto'; /* storage may be forbidden */
        }
    }

    apply(kept());
    addEventListener('DOMContentLoaded', () => {
        apply(kept());
        document.getElementById('theme').addEventListener('click', () => {
            const order = Object.keys(NAMES);
            const next = order[(order.indexOf(root.dataset.theme) + 1) % order.length];
            try { localStorage.setItem(KEY, next); } catch { /* holds until the page is left */ }
            apply(next);
        });
    });
})();
