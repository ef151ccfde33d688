#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""bench_view.py [-t N] [--size N] [--json FILE] MODEL...: how fast the viewer answers.

Of each model: frames a second at full size, by a client that takes one after another, each of another
configuration; and in the real page in Chromium, while a slider is dragged for some seconds, the time from
the input to the picture of it on the screen, 50th and 95th percentile, at the size that the viewer chose.
"""
import argparse
import json
import os
import pathlib
import random
import statistics
import sys
import time

ROOT = pathlib.Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests/viewer"))

from client import Client, Viewer  # noqa: E402  (the tests' own)


def full_size(port, size, n):
    """Seconds per frame of new configurations, one at a time: median, and of its parts by the server."""
    draw, times, parts = random.Random(1), [], []
    with Client(port, timeout=120) as c:
        for i in range(n + 2):
            values = [draw.uniform(v["min"], v["max"]) if not v["choices"] else v["value"]
                      for v in c.hello["variables"]]
            start = time.monotonic()
            state = c.state(values=values, width=size, height=size, layers=["neural"])
            frame = c.frame(state["version"])
            if i >= 2:
                times.append(time.monotonic() - start)
                parts.append((frame.render_ms, frame.encode_ms, len(frame.bytes)))
            assert frame.width == size, frame.width
    return {"frame_s": statistics.median(times), "fps": 1 / statistics.median(times),
            "render_ms": statistics.median(p[0] for p in parts),
            "encode_ms": statistics.median(p[1] for p in parts),
            "frame_bytes": statistics.median(p[2] for p in parts)}


def percentile(values, share):
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]


def dragging(url, size, seconds):
    """Latencies in the page, milliseconds; None without a browser."""
    try:
        from page import ActionChains, Page
    except SystemExit:
        return None
    with Page(url, 1400, 1000, is_watched=False) as page:  # reading pixels back takes time
        page.wait("connected", "document.getElementById('status').dataset.state === 'open'")
        page.run("const s = document.getElementById('size'); s.value = 'own';"
                 "s.dispatchEvent(new Event('change', {bubbles: true}));"
                 "for (const id of ['size-width', 'size-height']) {"
                 "  const e = document.getElementById(id); e.value = arguments[0];"
                 "  e.dispatchEvent(new Event('change', {bubbles: true})); }", size)
        page.run("""window.times = [];
            document.addEventListener('lumenaut:drawn', e => {
                if (e.detail.fromInput !== null) window.times.push([e.detail.fromInput, e.detail.width]);
            });""")
        slider = page.find("#controls input[type=range]")
        page.run("arguments[0].scrollIntoView({block: 'center'})", slider)
        time.sleep(2)
        page.run("window.times = []")
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            chain = ActionChains(page.driver, duration=16).move_to_element(slider).click_and_hold()
            for i in range(50):
                chain.move_by_offset(2 if i % 25 < 12 else -2, 0)
            chain.release().perform()
        time.sleep(0.5)
        found = page.run("return window.times")
    late = [t for t, _ in found]
    return {"pictures": len(late), "p50_ms": percentile(late, 0.5), "p95_ms": percentile(late, 0.95),
            "width": statistics.median(w for _, w in found)}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("models", nargs="+", metavar="MODEL")
    parser.add_argument("-t", "--threads", default="2")
    parser.add_argument("--size", type=int, default=900)
    parser.add_argument("--frames", type=int, default=15)
    parser.add_argument("--seconds", type=float, default=10, help="of dragging")
    parser.add_argument("--scene", help="where the scene is now")
    parser.add_argument("--json", metavar="FILE")
    a = parser.parse_args()
    results = []
    for model in a.models:
        words = [model, "-t", a.threads] + (["--scene", a.scene] if a.scene else [])
        with Viewer(str(ROOT / "build/release/lumenaut"), *words) as v:
            result = {"model": model, "size": a.size, "threads": int(a.threads)}
            result.update(full_size(v.port, a.size, a.frames))
            result["dragging"] = dragging(v.url, a.size, a.seconds)
        results.append(result)
        d = result["dragging"]
        print(f"{os.path.basename(model)}: {result['fps']:.1f} fps at {a.size}x{a.size} "
              f"({result['render_ms']:.0f} ms of rendering, {result['encode_ms']:.0f} of encoding); " +
              (f"dragging: p50 {d['p50_ms']:.0f} ms, p95 {d['p95_ms']:.0f} ms at width {d['width']:.0f}, "
               f"{d['pictures']} pictures" if d else "no browser"))
    if a.json:
        pathlib.Path(a.json).write_text(json.dumps({"results": results}, indent=1) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
