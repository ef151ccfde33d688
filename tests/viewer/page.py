#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""page.py LUMENAUT: the viewer's page in Debian's Chromium, headless, with the real server behind it.

Exit 77 with the reason where Chromium, its driver or Selenium is missing."""
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

from client import Viewer

ROOT = pathlib.Path(__file__).parents[2]
SCENE = str(ROOT / "tests/cli/scenes/box.xml")
VARIABLES = str(ROOT / "tests/viewer/room.variables.json")
CHROMIUM, DRIVER = "/usr/bin/chromium", "/usr/bin/chromedriver"

try:
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys
except ImportError:
    print("no python3-selenium")
    sys.exit(77)

# Remembers what was drawn: versions and a number that stands for the pixels.
WATCH = """
window.drawn = [];
document.addEventListener('lumenaut:drawn', e => {
    const c = document.getElementById('picture');
    const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
    let h = 0;
    for (let i = 0; i < d.length; i += 7) h = (h * 31 + d[i]) | 0;
    window.drawn.push({...e.detail, hash: h});
});
window.sent = 0;
document.addEventListener('lumenaut:sent', e => { window.sent = e.detail.version; });
"""


class Page:
    """The page in a browser of its own."""

    def __init__(self, url, width=1280, height=860, is_dark=False, is_watched=True):
        options = webdriver.ChromeOptions()
        options.binary_location = CHROMIUM
        for word in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                     "--disable-background-networking", "--no-first-run", f"--window-size={width},{height}"):
            options.add_argument(word)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        self.driver = webdriver.Chrome(service=Service(DRIVER), options=options)
        if is_watched:
            self.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": WATCH})
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [
            {"name": "prefers-color-scheme", "value": "dark" if is_dark else "light"}]})
        self.url = url
        self.driver.get(url)

    def __enter__(self):
        return self

    def __exit__(self, *unused):
        self.driver.quit()

    def run(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def find(self, selector):
        return self.driver.find_element(By.CSS_SELECTOR, selector)

    def wait(self, what, script, seconds=30):
        """Until the script's value is true; returns it."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            value = self.run("return " + script)
            if value:
                return value
            time.sleep(0.05)
        raise AssertionError(f"never: {what}")

    def settle(self):
        """The newest state's picture is drawn, and nothing moves; its hash."""
        time.sleep(0.35)  # longer than the page holds "moving" after a key
        self.wait("the newest picture", "window.drawn.length && "
                  "window.drawn[window.drawn.length - 1].version === window.sent")
        return self.run("return window.drawn[window.drawn.length - 1].hash")

    def click(self, selector):
        element = self.find(selector)
        self.run("arguments[0].scrollIntoView({block: 'center'})", element)
        element.click()

    def tab(self, name):
        self.find(f"#tab-{name}").click()

    def mode(self, name):
        self.run("document.querySelector(`input[name=mode][value=${arguments[0]}]`).click()", name)

    def press(self, element, *keys):
        self.run("arguments[0].scrollIntoView({block: 'center'}); arguments[0].focus()", element)
        element.send_keys(*keys)


def check_start(page, viewer):
    page.wait("connected", "document.getElementById('status').dataset.state === 'open'")
    page.settle()
    # As large as it fits, in the scene's shape; then small, so that pictures are soon finished.
    width, height = page.run("const c = document.getElementById('picture'); return [c.width, c.height]")
    assert width > 500 and abs(width / height - 1.5) < 0.01, (width, height)
    page.run("const s = document.getElementById('size'); s.value = 'scene';"
             "s.dispatchEvent(new Event('change', {bubbles: true}))")
    page.settle()
    assert page.find("#status-text").text == "Connected", page.find("#status-text").text
    addresses = set()
    for entry in page.driver.get_log("performance"):
        message = json.loads(entry["message"])["message"]
        if message["method"] == "Network.requestWillBeSent":
            addresses.add(message["params"]["request"]["url"])
    outside = [a for a in addresses if not a.startswith((viewer.url, "data:", "blob:"))]
    assert len(addresses) > 10 and not outside, outside


def check_controls(page):
    """Each kind of control changes the picture, by the keyboard alone."""
    page.tab("scene")
    before = page.settle()
    n = 0
    ranges = page.run("return [...document.querySelectorAll('#controls input[type=range]')]"
                      ".map(e => e.dataset.variable ?? e.getAttribute('aria-label'))")
    assert len(ranges) >= 7, ranges
    for i in range(len(ranges)):
        slider = page.driver.find_elements(By.CSS_SELECTOR, "#controls input[type=range]")[i]
        page.press(slider, Keys.ARROW_LEFT, Keys.ARROW_LEFT, Keys.ARROW_LEFT, Keys.PAGE_DOWN, Keys.PAGE_DOWN)
        after = page.settle()
        assert after != before, f"{ranges[i]} changes nothing"
        before = after
        n += 1
    pad = page.find("#controls [data-pad]")
    for key in (Keys.ARROW_RIGHT, Keys.ARROW_UP):
        page.press(pad, key, key, key, key)
        after = page.settle()
        assert after != before, "the pad changes nothing"
        before = after
    page.press(page.find("#controls [data-variable=turn][type=number]"), Keys.CONTROL, "a", Keys.NULL, "33",
               Keys.ENTER)
    assert page.settle() != before
    before = page.settle()
    page.press(page.find("#controls [data-variable=shown]"), Keys.SPACE)
    assert page.settle() != before, "the switch changes nothing"
    page.press(page.find("#controls [data-variable=shown]"), Keys.SPACE)
    before = page.settle()
    page.press(page.find("#controls [data-variable=cloth]:checked"), Keys.ARROW_RIGHT)
    assert page.settle() != before, "the choice changes nothing"
    before = page.settle()
    page.run("const c = document.querySelector('#controls input[type=color]'); c.value = '#2040c0';"
             "c.dispatchEvent(new Event('input', {bubbles: true}));"
             "c.dispatchEvent(new Event('change', {bubbles: true}));")
    assert page.settle() != before, "the colour changes nothing"
    # Undo to the start, redo, reset: the same picture of the same state.
    page.click("#reset-all")
    start = page.settle()
    page.click("#randomise")
    assert page.settle() != start
    page.click("#undo")
    page.settle()
    page.wait("the picture after undoing", f"window.drawn.some(d => d.version === window.sent && d.hash === {start})")
    return n


def check_modes(page):
    seen = set()
    for mode in ("neural", "traced", "buffer", "split"):
        page.mode(mode)
        page.wait(mode, f"document.querySelector('input[value={mode}]').checked")
        seen.add(page.settle())
    assert len(seen) == 4, seen
    handle = page.find("#split-handle")
    assert handle.get_attribute("role") == "slider"
    before = handle.get_attribute("aria-valuenow")
    page.press(handle, Keys.ARROW_LEFT, Keys.ARROW_LEFT, Keys.ARROW_LEFT)
    assert int(page.find("#split-handle").get_attribute("aria-valuenow")) < int(before)
    page.mode("error")
    page.wait("figures", "document.querySelector('[data-metric=flip]').textContent.match(/[0-9]/)")
    page.mode("neural")
    page.settle()


def check_dragging(page):
    """Older pictures are never drawn after newer ones, and the last value is reached."""
    slider = page.find("#controls input[type=range][data-variable=turn]")
    page.run("arguments[0].scrollIntoView({block: 'center'}); window.drawn = []", slider)
    width = slider.size["width"]
    chain = ActionChains(page.driver, duration=15).move_to_element(slider).click_and_hold()
    for i in range(60):
        chain.move_by_offset(int(width / 100) * (1 if i % 20 < 10 else -1), 0)
    chain.release().perform()
    page.settle()
    drawn = page.run("return window.drawn.map(d => d.version)")
    assert drawn == sorted(drawn) and len(set(drawn)) > 3, drawn
    assert drawn[-1] == page.run("return window.sent")
    # The camera by the mouse, and by keys.
    before = page.settle()
    stage = page.find("#stage")
    ActionChains(page.driver, duration=15).move_to_element(stage).click_and_hold().move_by_offset(
        40, 10).release().perform()
    turned = page.settle()
    assert turned != before, "orbiting changes nothing"
    page.press(stage, Keys.ARROW_LEFT, Keys.ARROW_LEFT)
    assert page.settle() != turned, "arrow keys do not turn"
    page.press(stage, "0")
    assert page.settle() == before, "the scene's camera does not come back"


def check_url(page):
    """The address holds the state."""
    page.click("#randomise")
    values = "return [...document.querySelectorAll('#controls input[type=number]')].map(e => e.value)"
    page.settle()
    page.wait("a state in the address", "location.hash.length > 10")
    before = page.run(values)
    link = page.run("return location.href")
    page.driver.get("about:blank")
    page.driver.get(link)
    page.wait("connected", "document.getElementById('status').dataset.state === 'open'")
    page.settle()
    assert page.run(values) == before
    page.tab("share")
    command = page.find("#command").text
    assert command.startswith("lumenaut render ") and "-P " in command, command
    page.tab("scene")


def check_labels(page):
    """Everything that can be used has a name and can be reached by Tab; ids are unique."""
    faults = page.run("""
        const faults = [], ids = new Set();
        for (const e of document.querySelectorAll('[id]')) {
            if (ids.has(e.id)) faults.push('twice: ' + e.id);
            ids.add(e.id);
        }
        for (const e of document.querySelectorAll(
                'button, input, select, textarea, a[href], [tabindex="0"], [role=slider]')) {
            if (e.type === 'file') continue;
            const by = (e.getAttribute('aria-labelledby') ?? '').split(' ')
                .map(id => document.getElementById(id)?.textContent ?? '').join('');
            const name = e.getAttribute('aria-label') || by || e.labels?.[0]?.textContent ||
                e.textContent || e.title;
            if (!name.trim()) faults.push('no name: ' + e.outerHTML.slice(0, 120));
        }
        for (const e of document.querySelectorAll('[aria-controls], [aria-labelledby]'))
            for (const a of ['aria-controls', 'aria-labelledby'])
                for (const id of (e.getAttribute(a) ?? '').split(' ').filter(Boolean))
                    if (!ids.has(id)) faults.push(a + ' of nothing: ' + id);
        return faults;""")
    assert not faults, faults


def check_restart(page, viewer, lumenaut, arguments):
    viewer.process.send_signal(signal.SIGKILL)
    viewer.process.wait()
    page.wait("the loss is told", "document.getElementById('status').dataset.state !== 'open'")
    assert page.find("#notice").is_displayed()
    again = Viewer(lumenaut, *arguments, "--port", str(viewer.port))
    page.run("window.drawn = []")
    page.wait("connected again", "document.getElementById('status').dataset.state === 'open'", 40)
    page.settle()
    assert not page.find("#notice").is_displayed()
    return again


def check_training(lumenaut):
    """A training is started, watched and stopped in the page, and the network stays."""
    with Viewer(lumenaut, SCENE) as viewer, Page(viewer.url) as page:
        page.wait("connected", "document.getElementById('status').dataset.state === 'open'")
        page.settle()
        assert page.run("return document.querySelector('input[value=neural]').disabled")
        page.tab("training")
        assert page.find("#training-command").text == f"lumenaut train {SCENE} -o box.lmn --view"
        page.click("#train-start")
        running = "document.getElementById('training-state').textContent === 'Running'"
        page.wait("running", running)
        page.wait("steps", "Number(document.querySelector('[data-training=step]').textContent) > 3")
        assert page.run("return document.querySelector('input[value=neural]').checked")
        page.wait("where it learns", "document.querySelectorAll('#states-plot .state').length > 3")
        page.press(page.find("#states-list"), Keys.HOME, Keys.ARROW_DOWN, Keys.ENTER)
        page.click("#train-pause")
        page.wait("paused", "document.getElementById('training-state').textContent === 'Paused'")
        page.click("#train-start")
        page.wait("running again", running)
        page.click("#train-stop")
        page.wait("the model", "document.getElementById('training-command').textContent.includes('--resume')")
        page.settle()
        assert page.run("return document.title").startswith("box.lmn") and os.path.exists("box.lmn")


def check_orthographic(lumenaut):
    """There, nearer is narrower."""
    with Viewer(lumenaut, str(ROOT / "scenes/tests/orthographic.xml")) as viewer, Page(viewer.url) as page:
        page.wait("connected", "document.getElementById('status').dataset.state === 'open'")
        page.mode("buffer")
        page.tab("camera")
        before = page.settle()
        width = "return document.querySelector('[data-fact=kind] dd').textContent"
        kind, words = page.run(width).split(", ")
        page.press(page.find("#stage"), "+", "+", "+", "+")
        assert page.settle() != before, "zooming changes nothing"
        assert kind == "Orthographic"
        assert float(page.run(width).split()[1]) < 0.9 * float(words.split()[0])
        page.press(page.find("#stage"), "0")
        assert page.settle() == before


def check_many(lumenaut):
    """Among the controls of 25 variables one is found by its words."""
    with Viewer(lumenaut, str(ROOT / "scenes/pocket/scene.xml")) as viewer, Page(viewer.url) as page:
        page.wait("connected", "document.getElementById('status').dataset.state === 'open'")
        page.mode("buffer")
        page.settle()
        shown = ("return [...document.querySelectorAll('#controls > .control')].filter(e => !e.hidden)"
                 ".map(e => e.dataset.group)")
        everything = page.run(shown)
        assert len(everything) > 8
        page.press(page.find("#find"), "chest tur")
        assert page.run(shown) == ["chest_turn"], page.run(shown)
        page.press(page.find("#find"), *[Keys.BACKSPACE] * 9)
        assert page.run(shown) == everything


def check_widths(url):
    """No sideways scrolling at any width, light and dark."""
    for width, is_dark in ((500, False), (1280, True), (2560, False)):
        with Page(url, width, 900, is_dark) as page:
            page.wait("connected", "document.getElementById('status').dataset.state === 'open'")
            page.settle()
            over = page.run("return document.documentElement.scrollWidth - window.innerWidth")
            assert over <= 0, f"{width} wide: {over} pixels too much"
            shots = os.environ.get("SCREENSHOTS")
            if shots:
                page.driver.save_screenshot(f"{shots}/viewer-{width}.png")


def train(lumenaut):
    subprocess.run([lumenaut, "train", SCENE, "--variables", VARIABLES, "-q", "-o", "m.lmn", "--width", "16",
                    "--depth", "1", "--steps", "40", "--spp", "4", "--memory", "8", "--eval-every", "never"],
                   check=True, timeout=120)


def step(name):
    if os.environ.get("VERBOSE"):
        print(f"{time.strftime('%H:%M:%S')} {name}", flush=True)


def main():
    lumenaut = os.path.abspath(sys.argv[1])
    for program in (CHROMIUM, DRIVER):
        if not os.access(program, os.X_OK):
            print(f"no {program}")
            return 77
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        train(lumenaut)
        viewer = Viewer(lumenaut, "m.lmn")
        try:
            with Page(viewer.url) as page:
                for check in (check_controls, check_modes, check_dragging, check_url, check_labels):
                    if check is check_controls:
                        step("check_start")
                        check_start(page, viewer)
                    step(check.__name__)
                    check(page)
                faults = [e for e in page.driver.get_log("browser") if e["level"] in ("SEVERE", "WARNING")
                          and "willReadFrequently" not in e["message"]]  # by WATCH
                assert not faults, faults
                step("check_restart")
                viewer = check_restart(page, viewer, lumenaut, ["m.lmn"])
            step("check_widths")
            check_widths(viewer.url)
            step("check_training")
            check_training(lumenaut)
            step("check_orthographic")
            check_orthographic(lumenaut)
            step("check_many")
            check_many(lumenaut)
        finally:
            viewer.process.terminate()
            viewer.process.communicate(timeout=20)
    return 0


if __name__ == "__main__":
    sys.exit(main())
