#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""bench_trace.py [--json] [--runs 5]: paths per second of `lumenaut trace` and of Mitsuba 3.

Same scene, configuration, size, samples and depth on all CPUs; runs alternate between the renderers;
medians. Rendering alone: loading and Mitsuba's compilation (its first run) do not count.
"""
import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

import numpy as np

import cases
import check_trace
import render_mitsuba

SCENES = [("sphere-caustic", cases.CAUSTIC, 128, 5), ("veach-ajar", cases.AJAR, 256, 9),
          ("cornell-box", cases.CORNELL, 256, 6)]
SCENES += [(name, cases.OUTSIDE / folder / name / "scene.xml", 256, 9)
           for folder, name in (("official", "spaceship"), ("bitterli", "staircase2"),
                                ("bitterli", "veach-mis"), ("bitterli", "classroom"))]
VARIANTS = ("scalar_rgb", "llvm_ad_rgb")
SPP = 32


def our_seconds(scene, size, spp, depth, seed):
    out = pathlib.Path(tempfile.gettempdir()) / f"lumenaut_bench_{os.getpid()}.exr"
    command = [check_trace.LUMENAUT, "trace", scene, "-o", out, "--json", "--size", f"{size}x{size}",
               "--spp", str(spp), "--max-depth", str(depth), "--rr-depth", "5", "--seed", str(seed)]
    report = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
    out.unlink()
    return report["render_s"]


class Peer:
    """A worker process per variant, as a process has one variant: prints seconds per line read."""

    def __init__(self, variant, scene, size, spp, depth):
        command = [sys.executable, __file__, "--serve", variant, str(scene), str(size), str(spp),
                   str(depth)]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        text=True)
        self.seconds() # compiles

    def seconds(self):
        self.process.stdin.write("\n")
        self.process.stdin.flush()
        return float(self.process.stdout.readline())

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def serve(variant, scene, size, spp, depth):
    mi = render_mitsuba.use(variant)
    settings = {"max_depth": int(depth), "rr_depth": 5, "hide_emitters": False}
    text = render_mitsuba.freeze_with_bounds(mi, scene)
    loaded, integrator = render_mitsuba.load(mi, text, (int(size), int(size)), settings)
    for run, _ in enumerate(sys.stdin):
        start = time.perf_counter()
        np.array(mi.render(loaded, integrator=integrator, spp=int(spp), seed=run))
        print(time.perf_counter() - start, flush=True)


def main():
    if sys.argv[1:2] == ["--serve"]:
        return serve(*sys.argv[2:])
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--spp", type=int, default=SPP)
    parser.add_argument("--json", action="store_true")
    args = parser.parse_args()
    results = []
    for name, scene, size, depth in SCENES:
        if not scene.exists():
            print(f"skipped {name}: no {scene} (LUMENAUT_SCENES)", file=sys.stderr)
            continue
        peers = {v: Peer(v, scene, size, args.spp, depth) for v in VARIANTS}
        seconds = {"lumenaut": [], **{v: [] for v in VARIANTS}}
        for run in range(args.runs):
            seconds["lumenaut"].append(our_seconds(scene, size, args.spp, depth, run))
            for variant, peer in peers.items():
                seconds[variant].append(peer.seconds())
        for peer in peers.values():
            peer.close()
        paths = size * size * args.spp
        rates = {who: paths / statistics.median(s) / 1e6 for who, s in seconds.items()}
        results.append({"scene": name, "size": size, "spp": args.spp, "max_depth": depth,
                        "runs": args.runs, "mpaths_per_s": rates, "seconds": seconds})
        if not args.json:
            if len(results) == 1:
                print(f"Mpaths/s, median of {args.runs} alternating runs, {args.spp} spp")
                print(f"{'scene':<16}{'size':>6}{'depth':>6}{'lumenaut':>10}{'scalar':>10}"
                      f"{'llvm':>10}{'/scalar':>9}{'/llvm':>9}")
            ours, scalar, llvm = (rates[k] for k in ("lumenaut", *VARIANTS))
            print(f"{name:<16}{size:>6}{depth:>6}{ours:>10.2f}{scalar:>10.2f}{llvm:>10.2f}"
                  f"{ours / scalar:>9.2f}{ours / llvm:>9.2f}", flush=True)
    if results and not args.json:
        for who in VARIANTS:
            ratios = [r["mpaths_per_s"]["lumenaut"] / r["mpaths_per_s"][who] for r in results]
            print(f"geometric mean over {who}: {statistics.geometric_mean(ratios):.2f}")
    if args.json:
        print(json.dumps(results, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
