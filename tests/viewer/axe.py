#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""axe.py LUMENAUT: the viewer's page as axe-core sees it, each tab and mode, light and dark, wide and narrow.

Exit 77 with the reason where Chromium, its driver, Selenium or axe-core (scripts/axe.sh) is missing."""
import os
import pathlib
import sys
import tempfile
import zipfile

from page import CHROMIUM, DRIVER, Page, train
from client import Viewer

ROOT = pathlib.Path(__file__).parents[2]
CHECK = """
const done = arguments[0];
axe.run(document, {resultTypes: ['violations']}).then(
    r => done(r.violations.map(v => ({id: v.id, impact: v.impact, help: v.help,
                                     nodes: v.nodes.map(n => n.html.slice(0, 160))}))),
    e => done([{id: 'axe failed', impact: 'critical', help: String(e), nodes: []}]));
"""


def axe_core():
    """The text of axe.min.js in the wheel, or None."""
    for wheel in (ROOT / "build/axe").glob("*.whl"):
        with zipfile.ZipFile(wheel) as z:
            for name in z.namelist():
                if name.endswith("/axe.min.js"):
                    return z.read(name).decode()
    return None


def check(page, where, faults):
    for v in page.driver.execute_async_script(CHECK):
        if v["impact"] in ("serious", "critical"):
            faults[(v["id"], v["help"])] = (where, v["nodes"][:3])


def visit(url, source, width, is_dark, faults):
    with Page(url, width, 900, is_dark) as page:
        page.driver.set_script_timeout(60)
        page.wait("connected", "document.getElementById('status').dataset.state === 'open'")
        page.settle()
        page.run(source)
        name = f"{width} wide, {'dark' if is_dark else 'light'}"
        for tab in ("scene", "view", "camera", "share", "path", "training"):
            page.run("document.getElementById(`tab-${arguments[0]}`).click()", tab)
            check(page, f"{name}, {tab}", faults)
        for mode in ("traced", "split", "error", "buffer"):
            page.mode(mode)
            page.settle()
            check(page, f"{name}, {mode}", faults)


def main():
    lumenaut = os.path.abspath(sys.argv[1])
    source = axe_core()
    for program in (CHROMIUM, DRIVER):
        if not os.access(program, os.X_OK):
            print(f"no {program}")
            return 77
    if not source:
        print("no axe-core in build/axe: scripts/axe.sh fetches it")
        return 77
    faults = {}
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        train(lumenaut)
        with Viewer(lumenaut, "m.lmn") as viewer:
            visit(viewer.url, source, 1280, False, faults)
            visit(viewer.url, source, 1280, True, faults)
            visit(viewer.url, source, 500, False, faults)
    for what, where in faults.items():
        print(*what, *where, sep="\n    ")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
