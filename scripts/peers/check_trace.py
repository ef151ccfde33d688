#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""check_trace.py [--json] [CASE...]: `lumenaut trace` agrees with Mitsuba 3 up to noise.

For every case of cases.py both render the same configuration from several seeds (equal filter,
depth and roulette); tiles.py says how 16 x 16 tiles are compared. The family-wise level over all
tiles, channels and cases is 1 %. A case with a tile beyond it is rendered again from fresh seeds
with four times the samples (rare bright paths make the first spread too small), and fails when the
fresh images fail alone. Exit status 1 when a case fails.
"""
import argparse
import dataclasses
import json
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy as np

import cases
import render_mitsuba
import tiles

LUMENAUT = cases.ROOT / "build/release/lumenaut"
RETRY = 4


def ours(mi, case, folder, seeds, spp):
    """[seeds, tiles, 3] by our tool, and its seconds of rendering."""
    command = [LUMENAUT, "params", case.scene, "--json"]
    listing = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
    names = [v["name"] for v in listing["variables"]]
    if len(names) != len(case.u):
        raise SystemExit(f"{case.name}: {len(names)} variables, {len(case.u)} expected: {names}")
    means, seconds = [], 0.0
    for seed in seeds:
        out = folder / "ours.exr"
        command = [LUMENAUT, "trace", case.scene, "-o", out, "--size", f"{case.size}x{case.size}",
                   "--spp", str(spp), "--seed", str(seed), "--max-depth", str(case.max_depth),
                   "--rr-depth", str(case.rr_depth), "--json"]
        for name, u in zip(names, case.u):
            command += ["-P", f"{name}={100 * u:.9g}%"]
        report = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
        seconds += report["render_s"]
        bitmap = mi.Bitmap(str(out)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32,
                                             False)
        means.append(tiles.tile_means(np.array(bitmap, dtype=np.float64)))
    return np.array(means), seconds


def theirs(mi, case, seeds, spp):
    """[seeds, tiles, 3] by Mitsuba, and its seconds of rendering."""
    settings = {"max_depth": case.max_depth, "rr_depth": case.rr_depth, "hide_emitters": False}
    text = render_mitsuba.freeze_with_bounds(mi, str(case.scene), case.u)
    scene, integrator = render_mitsuba.load(mi, text, (case.size, case.size), settings)
    start = time.perf_counter()
    means = [tiles.tile_means(render_mitsuba.render(mi, scene, integrator, spp, seed))
             for seed in seeds]
    return np.array(means), time.perf_counter() - start


def judge(mi, case, level, folder):
    """Renders, compares, and once more with fresh seeds when a tile is beyond `level`."""
    for attempt in range(2):
        spp = case.spp * (RETRY if attempt else 1)
        seeds = range(1 + 1000 * attempt, 1 + 1000 * attempt + case.seeds)
        a, ours_s = ours(mi, case, folder, seeds, spp)
        b, theirs_s = theirs(mi, case, seeds, spp)
        verdict = tiles.compare(a, b)
        if verdict.p.min() >= level:
            break
    index, channel = verdict.worst()
    return {"case": case.name, "ok": bool(verdict.p.min() >= level), "attempts": attempt + 1,
            "seeds": case.seeds, "spp": spp, "worst": tiles.tile_name(index, case.size),
            "channel": "RGB"[channel], "p": float(verdict.p[index, channel]),
            "z": float(verdict.z[index, channel]),
            "difference": float(verdict.relative[index, channel]),
            "whole_difference": float(np.abs(verdict.relative[-1]).max()),
            "whole_error": float(verdict.error[-1].max()),
            "tile_error": float(np.median(verdict.error[:-1])),
            "ours_s": ours_s, "mitsuba_s": theirs_s}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", help="cases; all when none is named")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--seeds", type=int, help="images per renderer")
    parser.add_argument("--spp", type=int, help="samples per pixel of each image")
    args = parser.parse_args()

    chosen = [c for c in cases.all_cases() if not args.names or c.name in args.names]
    present = [c for c in chosen if c.scene.exists()]
    for case in chosen:
        if case not in present:
            print(f"skipped {case.name}: no {case.scene} (LUMENAUT_SCENES)", file=sys.stderr)
    tests = sum(3 * ((c.size // tiles.TILE)**2 + 1) for c in present)
    level = tiles.ALPHA / max(tests, 1)

    mi = render_mitsuba.use("llvm_ad_rgb")
    results = []
    if not args.json:
        print(f"{tests} tests, each at {level:.2g} (together {tiles.ALPHA:g}); differences relative "
              "to Mitsuba's mean")
        print(f"{'case':<18} {'':<5} {'worst':<12} {'z':>7} {'p':>8} {'differs':>8}   "
              f"{'whole image':>16} {'tile noise':>10} {'ours':>7} {'mitsuba':>8}")
    with tempfile.TemporaryDirectory() as folder:
        for case in present:
            changes = {k: v for k, v in (("seeds", args.seeds), ("spp", args.spp)) if v}
            result = judge(mi, dataclasses.replace(case, **changes), level, pathlib.Path(folder))
            results.append(result)
            if not args.json:
                print("{case:<18} {0:<5} {1:<12} {z:7.2f} {p:8.1e} {2:8.2%}   {3:7.3%} ±{4:7.3%} "
                      "{5:10.2%} {ours_s:6.1f}s {mitsuba_s:7.1f}s".format(
                          "ok" if result["ok"] else "FAIL",
                          result["worst"].removeprefix("tile ") + " " + result["channel"],
                          result["difference"], result["whole_difference"],
                          result["whole_error"], result["tile_error"], **result), flush=True)
    if args.json:
        print(json.dumps({"alpha": tiles.ALPHA, "level": level, "tests": tests,
                          "results": results}, indent=1))
    return 0 if all(r["ok"] for r in results) else 1


if __name__ == "__main__":
    sys.exit(main())
