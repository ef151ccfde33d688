#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""bench_trace.py [--json] [--runs 5] [--scenes A,B]: paths per second, ours and Mitsuba 3's.

Same scene, configuration (bench_scenes.py), size, samples and depth on all CPUs, integrator `path`;
runs alternate between the renderers; medians. Rendering alone: loading and Mitsuba's compilation
(its first run) do not count.
"""
import argparse
import json
import statistics
import subprocess
import sys

import bench_scenes

SPP = 32


class Peer:
    """A worker process per variant, as a process has one variant: prints seconds per line read."""

    def __init__(self, variant, name, spp):
        command = [sys.executable, __file__, "--serve", variant, name, str(spp)]
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


def serve(variant, name, spp):
    scene = bench_scenes.chosen(name)[0]
    render = bench_scenes.theirs(variant, scene, bench_scenes.shares(scene), scene.size)
    for run, _ in enumerate(sys.stdin):
        print(render(int(spp), run)[1], flush=True)


def measure(scene, runs, spp):
    u = bench_scenes.shares(scene)
    peers = {v: Peer(v, scene.name, spp) for v in bench_scenes.VARIANTS}
    seconds = {"lumenaut": [], **{v: [] for v in peers}}
    for run in range(runs):
        seconds["lumenaut"].append(bench_scenes.ours(scene, u, scene.size, spp, run,
                                                     "--integrator", "path"))
        for variant, peer in peers.items():
            seconds[variant].append(peer.seconds())
    for peer in peers.values():
        peer.close()
    paths = scene.size * scene.size * spp
    rates = {who: paths / statistics.median(s) / 1e6 for who, s in seconds.items()}
    return {"scene": scene.name, "values": dict(scene.values), "size": scene.size, "spp": spp,
            "max_depth": scene.max_depth, "runs": runs, "mpaths_per_s": rates, "seconds": seconds,
            "ratio": rates["lumenaut"] / max(rates[v] for v in bench_scenes.VARIANTS)}


def print_row(r, is_first):
    if is_first:
        print(f"Mpaths/s, median of {r['runs']} alternating runs, {r['spp']} spp")
        print(f"{'scene':<16}{'size':>6}{'depth':>6}{'lumenaut':>10}{'scalar':>10}{'llvm':>10}"
              f"{'/scalar':>9}{'/llvm':>9}{'/faster':>9}")
    ours, scalar, llvm = (r["mpaths_per_s"][k] for k in ("lumenaut", *bench_scenes.VARIANTS))
    print(f"{r['scene']:<16}{r['size']:>6}{r['max_depth']:>6}{ours:>10.2f}{scalar:>10.2f}"
          f"{llvm:>10.2f}{ours / scalar:>9.2f}{ours / llvm:>9.2f}{r['ratio']:>9.2f}", flush=True)


def main():
    if sys.argv[1:2] == ["--serve"]:
        return serve(*sys.argv[2:])
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--spp", type=int, default=SPP)
    parser.add_argument("--scenes", help="some of them, with commas between")
    parser.add_argument("--json", action="store_true")
    args = parser.parse_args()
    results = []
    for scene in bench_scenes.chosen(args.scenes):
        results.append(measure(scene, args.runs, args.spp))
        if not args.json:
            print_row(results[-1], len(results) == 1)
    if args.json:
        print(json.dumps(results, indent=1))
    elif results:
        ratios = {r["scene"]: r["ratio"] for r in results}
        worst = min(ratios, key=ratios.get)
        print(f"over the faster variant: geometric mean {statistics.geometric_mean(ratios.values()):.2f}, "
              f"least {ratios[worst]:.2f} ({worst})")
    return 0


if __name__ == "__main__":
    sys.exit(main())
