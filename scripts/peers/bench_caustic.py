#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""bench_caustic.py [--runs 6] [--alpha 0.01,0.05]: error times seconds within sphere-caustic's caustic.

relMSE over the caustic on the floor (a window of 46x14 of 128x128 pixels) against 65,536 spp of
`lumenaut trace`, times the seconds of rendering the whole picture: for our `path`, our
`path+photons`, and Mitsuba's llvm_ad_rgb `path`. Means of errors, medians of seconds.
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import tempfile
import time

import numpy as np

import cases
import check_trace
import render_mitsuba

SIZE, DEPTH = 128, 5
X, Y, WIDTH, HEIGHT = 40, 110, 46, 14


def ours(mi, out, alpha, *options):
    command = [check_trace.LUMENAUT, "trace", cases.CAUSTIC, "-o", out, "-q", "--json", "--size",
               f"{SIZE}x{SIZE}", "--max-depth", str(DEPTH), "-P", f"sphere_mat.alpha={alpha}", *options]
    report = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
    bitmap = mi.Bitmap(str(out)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False)
    return np.array(bitmap, dtype=np.float64), report["render_s"]


def error(image, reference):
    d = image[Y:Y + HEIGHT, X:X + WIDTH] - reference
    return float((d * d / (reference * reference + 1e-2)).mean())


def mitsuba(mi, out, alpha):
    """A function (spp, seed) -> image, seconds, at the same configuration."""
    command = [check_trace.LUMENAUT, "params", cases.CAUSTIC, "--json"]
    listing = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
    u = [(v["default"] - v["min"]) / (v["max"] - v["min"]) for v in listing["variables"]]
    for i, v in enumerate(listing["variables"]):
        if v["name"] == "sphere_mat.alpha":
            u[i] = (alpha - v["min"]) / (v["max"] - v["min"])
    text = render_mitsuba.freeze_with_bounds(mi, str(cases.CAUSTIC), u)
    settings = {"max_depth": DEPTH, "rr_depth": 5, "hide_emitters": False}
    scene, integrator = render_mitsuba.load(mi, text, (SIZE, SIZE), settings)

    def render(spp, seed):
        start = time.perf_counter()
        image = np.array(mi.render(scene, integrator=integrator, spp=spp, seed=seed))
        return image[..., :3].astype(np.float64), time.perf_counter() - start
    render(4, 0)
    return render


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=6)
    parser.add_argument("--alpha", default="0.01,0.05")
    args = parser.parse_args()
    mi = render_mitsuba.use("llvm_ad_rgb")
    out = pathlib.Path(tempfile.mkdtemp()) / "picture.exr"
    print(f"{'alpha':>6} {'integrator':<16}{'spp':>5}{'relMSE':>10}{'s':>8}{'relMSE s':>11}{'ratio':>8}")
    for alpha in map(float, args.alpha.split(",")):
        reference, _ = ours(mi, out, alpha, "--crop", f"{X},{Y},{WIDTH},{HEIGHT}", "--spp", "65536",
                            "--seed", "99", "--integrator", "path")
        peer = mitsuba(mi, out, alpha)
        runs = {
            "mitsuba path": (128, lambda spp, seed: peer(spp, seed)),
            "path": (128, lambda spp, seed: ours(mi, out, alpha, "--spp", str(spp), "--seed",
                                                 str(seed), "--integrator", "path")),
            "path+photons": (64, lambda spp, seed: ours(mi, out, alpha, "--spp", str(spp), "--seed",
                                                        str(seed), "--integrator", "path+photons")),
            "the same, independent": (64, lambda spp, seed: ours(mi, out, alpha, "--spp", str(spp), "--seed",
                                                           str(seed), "--integrator", "path+photons",
                                                           "--sampler", "independent")),
        }
        measured = {name: [] for name in runs}
        for seed in range(args.runs): # by turns
            for name, (spp, render) in runs.items():
                image, seconds = render(spp, seed)
                measured[name].append((error(image, reference), seconds))
        costs = {name: statistics.mean(e for e, _ in m) * statistics.median(s for _, s in m)
                 for name, m in measured.items()}
        for name, m in measured.items():
            print(f"{alpha:>6} {name:<16}{runs[name][0]:>5}{statistics.mean(e for e, _ in m):>10.5f}"
                  f"{statistics.median(s for _, s in m):>8.3f}{costs[name]:>11.6f}"
                  f"{costs[name] / costs['path+photons']:>8.2f}", flush=True)


if __name__ == "__main__":
    main()
