#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""check_trace.py [--quick] [--resume] [--markdown OUT.md] [CASE...]: ours agrees with Mitsuba 3.

For every case of cases.py both render the same configuration from several seeds (equal filter,
depth and roulette); tiles.py says how 16 x 16 tiles are compared. The family-wise level over all
tiles, channels and cases is 1 %. A case with a tile beyond it is rendered again from fresh seeds
with four times the samples (rare bright paths make the first spread too small), and fails when the
fresh images fail alone. At the end a table of every plugin that is read (plugins.py) with its
result. Exit status 1 when a case or the test that stands in for one fails, or a plugin has none.

Results are kept in build/peers/check_trace.json; --resume leaves out cases that are there.
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
import classroom
import plugins
import render_mitsuba
import tiles

LUMENAUT = cases.ROOT / "build/release/lumenaut"
STORE = cases.ROOT / "build/peers/check_trace.json"
RETRY = 4
QUICK = {"seeds": 2, "spp": 16}


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
                   "--rr-depth", str(case.rr_depth), "--integrator", "path", "--json", "-q"]
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
    scene, integrator = render_mitsuba.load_case(mi, case)
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


def print_case(r):
    print("{case:<26} {0:<5} {1:<12} {z:7.2f} {p:8.1e} {2:8.2%}   {3:7.3%} ±{4:7.3%} "
          "{5:10.2%} {ours_s:6.1f}s {mitsuba_s:7.1f}s".format(
              "ok" if r["ok"] else "FAIL", r["worst"].removeprefix("tile ") + " " + r["channel"],
              r["difference"], r["whole_difference"], r["whole_error"], r["tile_error"], **r),
          flush=True)


def cells(row, word):
    return (row.group, row.what, ", ".join((*row.cases, *(f"test {t}" for t in row.tests))) or "none",
            word, row.note)


def print_plugins(judged):
    print(f"\n{'':<8} {'what':<56} {'result':<10} by")
    for row, word in judged:
        group, what, by, _, note = cells(row, word)
        print(f"{group:<8} {what:<56} {word:<10} {by}{'; ' + note if note else ''}")
    for name in plugins.uncovered():
        print(f"no plugin names the case {name}")


def markdown(judged, results, level):
    revision = subprocess.run(["git", "-C", str(cases.ROOT), "describe", "--always", "--dirty"],
                              capture_output=True, text=True, check=False).stdout.strip()
    lines = ["# Pictures beside Mitsuba 3", "",
             f"Written by `scripts/peers/check_trace.py --markdown` (`make check-peers`), revision {revision}. "
             "Both render the same configuration from several seeds, with equal filter, depth and "
             "roulette; Welch's t-test compares the means of 16 x 16 tiles and of the whole picture. A "
             f"test fails at p < {level:.2g}: all together fail by chance once in {1 / tiles.ALPHA:g} "
             "runs. A case with a failing tile is rendered again from fresh seeds with four times the "
             "samples, which decide.", "", "## Plugins", "",
             "| | what | result | by | |", "| --- | --- | --- | --- | --- |"]
    for row, word in judged:
        group, what, by, _, note = cells(row, word)
        lines.append(f"| {group} | {what} | {word} | {by} | {note} |")
    lines += ["", "## Cases", "",
              "Differences are relative to Mitsuba's mean; `noise` is the standard error of the "
              "difference.", "",
              "| case | result | seeds x spp | worst tile | z | p | differs | whole picture differs | noise |",
              "| --- | --- | ---: | --- | ---: | ---: | ---: | ---: | ---: |"]
    for r in results.values():
        lines.append(f"| {r['case']} | {'agrees' if r['ok'] else 'DISAGREES'} | {r['seeds']} x {r['spp']} "
                     f"| {r['worst'].removeprefix('tile ')} {r['channel']} | {r['z']:.2f} | {r['p']:.1e} "
                     f"| {r['difference']:.2%} | {r['whole_difference']:.3%} | {r['whole_error']:.3%} |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", help="cases; all when none is named")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--seeds", type=int, help="images per renderer")
    parser.add_argument("--spp", type=int, help="samples per pixel of each image")
    parser.add_argument("--quick", action="store_true", help="little: tries the script itself")
    parser.add_argument("--resume", action="store_true", help="leave out cases whose results are kept")
    parser.add_argument("--markdown", type=pathlib.Path, help="write both tables there")
    args = parser.parse_args()
    changes = {k: v for k, v in (("seeds", args.seeds), ("spp", args.spp)) if v}
    changes = {**(QUICK if args.quick else {}), **changes}

    mi = render_mitsuba.use("llvm_ad_rgb")
    every = [dataclasses.replace(c, **changes) for c in cases.all_cases()]
    chosen = [c for c in every if not args.names or c.name in args.names]
    if any(c.name.startswith("classroom") for c in chosen):
        classroom.make(mi)
    present = [c for c in chosen if c.scene.exists()]
    for case in chosen:
        if case not in present:
            print(f"skipped {case.name}: no {case.scene} (LUMENAUT_SCENES)", file=sys.stderr)
    tests = sum(3 * ((c.size // tiles.TILE)**2 + 1) for c in every)
    level = tiles.ALPHA / tests

    results = {}
    if args.resume and STORE.exists():
        kept = json.loads(STORE.read_text(encoding="utf-8"))
        seeds = {c.name: c.seeds for c in every}
        results = {r["case"]: r for r in kept if r["seeds"] == seeds.get(r["case"])}
    if not args.json:
        print(f"{tests} tests, each at {level:.2g} (together {tiles.ALPHA:g}); differences relative "
              "to Mitsuba's mean")
        print(f"{'case':<26} {'':<5} {'worst':<12} {'z':>7} {'p':>8} {'differs':>8}   "
              f"{'whole image':>16} {'tile noise':>10} {'ours':>7} {'mitsuba':>8}")
    STORE.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        for case in present:
            if case.name not in results:
                results[case.name] = judge(mi, case, level, pathlib.Path(folder))
                STORE.write_text(json.dumps(list(results.values()), indent=1) + "\n", encoding="utf-8")
            if not args.json:
                print_case(results[case.name])
    judged = plugins.judged(results) if not args.names or args.markdown else []
    if args.json:
        print(json.dumps({"alpha": tiles.ALPHA, "level": level, "tests": tests,
                          "results": list(results.values()),
                          "plugins": [cells(*j) for j in judged]}, indent=1))
    elif judged:
        print_plugins(judged)
    if args.markdown:
        args.markdown.write_text(markdown(judged, results, level), encoding="utf-8")
    is_well = all(r["ok"] for r in results.values())
    return 0 if is_well and all(word in ("agree", "passes", "not run") for _, word in judged) else 1


if __name__ == "__main__":
    sys.exit(main())
