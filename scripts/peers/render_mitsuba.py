#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""render_mitsuba.py SCENE.xml [-o OUT.exr] [--time]: a scene by Mitsuba 3, for comparison.

Writes OUT.a.exr and OUT.b.exr, two halves of the samples from different seeds (their difference
gives the noise of any tile), and OUT.exr, their mean. --time renders again and again and prints one
JSON document with paths per second; the first run, which compiles, does not count.

Needs `make peers` and is run by .venv/bin/python. As a module: use(), load(), load_case(), render(), bounds().
"""
import argparse
import glob
import json
import os
import statistics
import sys
import time
import xml.etree.ElementTree as ElementTree

import numpy as np

import freeze
import old_plugins

MAX_PATHS = 1 << 21  # of one pass: bounds the memory of the LLVM variant


def use(variant):
    """Imports Mitsuba with a variant; points drjit to Debian's libllvm19, as 15 fails."""
    libraries = sorted(glob.glob("/usr/lib/*/libLLVM*19*"))
    if libraries:
        os.environ.setdefault("DRJIT_LIBLLVM_PATH", libraries[0])
    import mitsuba
    mitsuba.set_variant(variant)
    mitsuba.set_log_level(mitsuba.LogLevel.Error)
    return mitsuba


def with_film_size(text, size):
    """A picture of that size: of the whole film, or of the part that the scene crops."""
    root = ElementTree.fromstring(text)
    for film in root.iter("film"):
        for side, axis, value in zip(("width", "height"), "xy", size):
            crop = freeze.child(film, f"crop_{side}")
            names = (side, f"crop_{side}", f"crop_offset_{axis}") if crop is not None else (side,)
            whole = int(crop.get("value")) if crop is not None else 0
            for name in names:
                node = freeze.child(film, name)
                if node is None:
                    node = ElementTree.SubElement(film, "integer", name=name, value="0")
                scaled = int(node.get("value")) * value // whole if whole else value
                node.set("value", str(scaled))
    return ElementTree.tostring(root, encoding="unicode")


def path_settings(path):
    """max_depth, rr_depth and hide_emitters of the (nested) `path` integrator that a file asks for."""
    settings = {"max_depth": -1, "rr_depth": 5, "hide_emitters": False}
    for integrator in freeze.read(path).iter("integrator"):
        for node in integrator:
            if node.get("name") in ("max_depth", "rr_depth", "maxDepth", "rrDepth"):
                name = node.get("name").replace("Depth", "_depth")
                settings[name] = int(node.get("value"))
            elif node.get("name") in ("hide_emitters", "hideEmitters"):
                settings["hide_emitters"] = node.get("value") == "true"
    return settings


def as_new(text):
    """Old plugins that Mitsuba 3.9 does not bring up to date by itself: the sky of 0.x has +y up; the
    sun's direction is in world space in both."""
    root = ElementTree.fromstring(text)
    is_old = root.get("version", "3").startswith("0.")
    for emitter in root.iter("emitter"):
        if emitter.get("type") not in ("sunsky", "sun", "sky"):
            continue
        for node in list(emitter):
            name = node.get("name")
            if name in ("sun_radius_scale", "sunRadiusScale"):
                node.set("name", "sun_aperture")
                node.set("value", str(0.5338 * float(node.get("value")))) # degrees, as it was
        if is_old and freeze.child(emitter, "to_world") is None:
            transform = ElementTree.SubElement(emitter, "transform", name="to_world")
            ElementTree.SubElement(transform, "rotate", x="1", angle="-90")
    return ElementTree.tostring(root, encoding="unicode")


def load(mi, text, size, settings):
    """(scene, integrator) of frozen XML text."""
    return mi.load_string(with_film_size(as_new(text), size)), mi.load_dict({"type": "path", **settings})


def load_case(mi, case):
    """(scene, integrator) of a case of cases.py."""
    if case.name.startswith("ours/"):
        old_plugins.register(mi)
    settings = {"max_depth": case.max_depth, "rr_depth": case.rr_depth, "hide_emitters": False}
    text = freeze_with_bounds(mi, str(case.scene), case.u or None)
    if case.is_mixed:
        text = old_plugins.as_mixtures(text)
    scene, integrator = load(mi, text, (case.size, case.size), settings)
    if case.integrator != "path":
        integrator = mi.load_dict({**settings, "type": case.integrator})
    return scene, integrator


def bounds(mi, text):
    box = mi.load_string(as_new(text)).bbox()
    return [float(x) for x in (*np.array(box.min).ravel(), *np.array(box.max).ravel())]


def render(mi, scene, integrator, spp, seed):
    """[height, width, 3] radiance; passes get seeds of their own."""
    width, height = (int(x) for x in scene.sensors()[0].film().crop_size())
    per_pass = max(1, min(spp, MAX_PATHS // (width * height)))
    total, done, n = np.zeros((height, width, 3)), 0, 0
    while done < spp:
        count = min(per_pass, spp - done)
        image = mi.render(scene, integrator=integrator, spp=count, seed=seed * 65536 + n)
        total += np.array(image, dtype=np.float64)[..., :3] * count
        done += count
        n += 1
    return total / spp


def measure(mi, scene, integrator, spp, runs):
    seconds = []
    for run in range(runs + 1):
        start = time.perf_counter()
        np.array(mi.render(scene, integrator=integrator, spp=spp, seed=run))
        seconds.append(time.perf_counter() - start)
    median = statistics.median(seconds[1:])
    width, height = (int(x) for x in scene.sensors()[0].film().crop_size())
    return {"variant": mi.variant(), "width": width, "height": height, "spp": spp, "runs": runs,
            "first_s": seconds[0], "median_s": median, "min_s": min(seconds[1:]),
            "paths_per_s": width * height * spp / median}


def size_of(text):
    width, _, height = text.partition("x")
    return int(width), int(height or width)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene")
    parser.add_argument("-o", "--output", help="OUT.exr")
    parser.add_argument("-u", type=freeze.numbers, help="configuration, one number per parameter")
    parser.add_argument("--size", type=size_of, default=(256, 256))
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--max-depth", type=int)
    parser.add_argument("--rr-depth", type=int)
    parser.add_argument("--variant", default="llvm_ad_rgb")
    parser.add_argument("--time", action="store_true")
    parser.add_argument("--runs", type=int, default=5)
    args = parser.parse_args()

    mi = use(args.variant)
    settings = path_settings(args.scene)
    for name in ("max_depth", "rr_depth"):
        if getattr(args, name) is not None:
            settings[name] = getattr(args, name)
    text = freeze_with_bounds(mi, args.scene, args.u)
    scene, integrator = load(mi, text, args.size, settings)
    if args.time:
        print(json.dumps({"scene": args.scene, **settings,
                          **measure(mi, scene, integrator, args.spp, args.runs)}))
    if args.output:
        stem = args.output.removesuffix(".exr")
        halves = [render(mi, scene, integrator, args.spp // 2, 2 * args.seed + k) for k in (0, 1)]
        images = {".a": halves[0], ".b": halves[1], "": (halves[0] + halves[1]) / 2}
        for suffix, image in images.items():
            mi.Bitmap(image.astype(np.float32)).write(f"{stem}{suffix}.exr")
    return 0


def freeze_with_bounds(mi, path, u=None):
    """freeze.freeze(), with the bounding box (at u = 0.5) that a variable camera needs."""
    box = bounds(mi, freeze.freeze(path, None, [0, 0, 0, 1, 1, 1]))
    return freeze.freeze(path, u, box)


if __name__ == "__main__":
    sys.exit(main())
