#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""hour.py LUMENAUT [SECONDS]: scripted use of the viewer for an hour: pages that come and go, drag, rest, ask for
pixels and files. Memory and descriptors stay as they were. Named check: `make check-viewer`."""
import os
import pathlib
import random
import statistics
import subprocess
import sys
import tempfile
import time

from client import Client, Viewer

ROOT = pathlib.Path(__file__).parents[2]
SCENE = str(ROOT / "scenes/demo/scene.xml")
SAMPLES = 40  # looks at memory; the first quarter warms up


def use(port, draw, seconds):
    """One page's life; how many pictures it saw."""
    n, end = 0, time.monotonic() + seconds
    with Client(port, timeout=120) as c:
        while time.monotonic() < end:
            values = [draw.uniform(v["min"], v["max"]) if not v["choices"] else draw.randrange(len(v["choices"]))
                      for v in c.hello["variables"]]
            layers = draw.choice([["neural"], ["traced"], ["neural", "traced"], ["neural", "error"], ["normal"]])
            size = draw.choice([(256, 256), (400, 300), (640, 640)])
            camera = None
            if draw.random() < 0.3:
                camera = dict(c.hello["camera"])
                camera["origin"] = [x + draw.uniform(-0.3, 0.3) for x in camera["origin"]]
            for i in range(draw.randrange(1, 12)):  # a drag
                values[0] = c.hello["variables"][0]["min"]
                state = c.state(values=values, layers=layers, width=size[0], height=size[1], camera=camera,
                                moving=True)
                c.frame(state["version"])
                n += 1
            state = c.state(values=values, layers=layers, width=size[0], height=size[1], camera=camera)
            for i in range(draw.randrange(1, 8)):  # a rest
                frame = c.frame(state["version"])
                n += 1
                if frame.is_final:
                    break
            if draw.random() < 0.3:
                c.send({"type": "pixel", "id": n, "x": draw.randrange(size[0]), "y": draw.randrange(size[1])})
                c.text("pixel", lambda t: t["id"] == n)
            if draw.random() < 0.1:
                c.send({"type": "capture", "id": n, "layer": "neural", "format": draw.choice(["png", "exr"])})
                while c.next_frame().layer != 255:
                    pass
            c.texts.clear()
    return n


def main():
    lumenaut, seconds = os.path.abspath(sys.argv[1]), float(sys.argv[2]) if len(sys.argv) > 2 else 3600
    draw, sizes, n = random.Random(3), [], 0
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        subprocess.run([lumenaut, "train", SCENE, "-q", "-o", "m.lmn", "--steps", "60", "--memory", "32",
                        "--eval-every", "never"], check=True, timeout=300)
        with Viewer(lumenaut, "m.lmn", "--scene", SCENE) as v:
            for i in range(SAMPLES):
                n += use(v.port, draw, seconds / SAMPLES)
                v.rest()
                sizes.append(v.size())
                if i % 4 == 3:
                    print(f"{(i + 1) * seconds / SAMPLES:6.0f} s  {n:6} pictures  {sizes[-1][0] / 2**20:7.1f} MiB  "
                          f"{sizes[-1][1]} descriptors", flush=True)
        assert v.process.returncode == 0
    quarter = SAMPLES // 4
    early, late = sizes[quarter:2 * quarter], sizes[-quarter:]
    memory = [statistics.median(s[0] for s in part) / 2**20 for part in (early, late)]
    print(f"memory {memory[0]:.1f} MiB, then {memory[1]:.1f}; descriptors {early[0][1]}, then {late[-1][1]}")
    assert memory[1] < memory[0] * 1.05 + 4, memory
    assert max(s[1] for s in late) <= max(s[1] for s in early), (early, late)
    return 0


if __name__ == "__main__":
    sys.exit(main())
