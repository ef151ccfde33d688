# SPDX-License-Identifier: Apache-2.0
"""The seven scenes that bench_trace.py and bench_error.py measure, and both renderers at them.

A scene's variables have the values that its file gives them, but for those named here: spaceship's
own camera looks at a black wall. veach-ajar's shows the room by the light of the open door.
"""
import dataclasses
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ElementTree

import cases
import render_mitsuba

LUMENAUT = cases.ROOT / "build/release/lumenaut"
RR_DEPTH = 5
VARIANTS = ("scalar_rgb", "llvm_ad_rgb")


@dataclasses.dataclass(frozen=True)
class Scene:
    name: str
    path: pathlib.Path
    size: int
    max_depth: int
    values: tuple = () # (variable, value in the scene's units)


SCENES = (
    Scene("sphere-caustic", cases.CAUSTIC, 128, 5),
    Scene("veach-ajar", cases.AJAR, 256, 9, (("door", 25.0),)),
    Scene("spaceship", cases.SPACESHIP, 256, 9,
          (("camera.x", -0.52), ("camera.y", 1.4), ("camera.z", 3.69))),
    Scene("cornell-box", cases.CORNELL, 256, 6),
    Scene("staircase2", cases.OUTSIDE / "bitterli/staircase2/scene.xml", 256, 9),
    Scene("veach-mis", cases.OUTSIDE / "bitterli/veach-mis/scene.xml", 256, 9),
    Scene("classroom", cases.OUTSIDE / "bitterli/classroom/scene.xml", 256, 9),
)


def chosen(names):
    """The scenes of a comma-separated list (None: all) whose files are there."""
    wanted = names.split(",") if names else [s.name for s in SCENES]
    known = {s.name: s for s in SCENES}
    for name in wanted:
        if name not in known:
            raise SystemExit(f"no scene is called {name}; there are {', '.join(known)}")
    for name in wanted:
        if not known[name].path.exists():
            print(f"skipped {name}: no {known[name].path} (LUMENAUT_SCENES)", file=sys.stderr)
    return [known[name] for name in wanted if known[name].path.exists()]


def comparable(scene):
    """The scene such that both renderers converge to one picture: classroom under a baked sky."""
    if scene.name != "classroom":
        return scene
    baked = cases.ROOT / "build/peers/classroom-envmap.xml"
    if not baked.exists():
        script = pathlib.Path(__file__).with_name("classroom.py")
        subprocess.run([sys.executable, script], check=True)
    return dataclasses.replace(scene, path=baked)


def shares(scene):
    """{variable: u in [0, 1]}, in the order of the document."""
    command = [LUMENAUT, "params", scene.path, "--json", "-q"]
    listing = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
    values = dict(scene.values)
    u = {}
    for v in listing["variables"]:
        value = values.pop(v["name"], v["default"])
        width = v["max"] - v["min"]
        u[v["name"]] = (value - v["min"]) / width if width > 0 else 0.0
    if values:
        raise SystemExit(f"{scene.name} has no variable {', '.join(values)}")
    return u


def ours(scene, u, size, spp, seed, *options, picture=None):
    """Seconds of rendering by `lumenaut trace`; the picture is written when a name is given."""
    out = picture or pathlib.Path(tempfile.gettempdir()) / f"lumenaut_bench_{os.getpid()}.exr"
    command = [LUMENAUT, "trace", scene.path, "-o", out, "--json", "-q", "--size", f"{size}x{size}",
               "--spp", str(spp), "--max-depth", str(scene.max_depth), "--rr-depth",
               str(RR_DEPTH), "--seed", str(seed), *options]
    for name, share in u.items():
        command += ["-P", f"{name}={100 * share:.9g}%"]
    report = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
    if not picture:
        out.unlink()
    return report["render_s"]


def with_sampler(text, kind):
    root = ElementTree.fromstring(text)
    for sensor in root.iter("sensor"):
        node = sensor.find("sampler")
        if node is None:
            node = ElementTree.SubElement(sensor, "sampler")
        node.set("type", kind)
    return ElementTree.tostring(root, encoding="unicode")


def theirs(variant, scene, u, size, sampler=None):
    """A function (spp, seed) -> [size, size, 3], seconds by Mitsuba; the first call compiles."""
    mi = render_mitsuba.use(variant)
    text = render_mitsuba.freeze_with_bounds(mi, str(scene.path), list(u.values()))
    if sampler:
        text = with_sampler(text, sampler)
    settings = {"max_depth": scene.max_depth, "rr_depth": RR_DEPTH, "hide_emitters": False}
    loaded, integrator = render_mitsuba.load(mi, text, (size, size), settings)

    def render(spp, seed):
        start = time.perf_counter()
        image = render_mitsuba.render(mi, loaded, integrator, spp, seed)
        return image, time.perf_counter() - start
    return render
