#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""bench_error.py [--scenes A,B] [--size 128] [--spp 16,64,256] [--runs 4] [--stratified] [--again]

Time to equal relMSE, ours and Mitsuba 3's, on the scenes and configurations of bench_scenes.py.

relMSE is the mean of (x - r)^2 / (r^2 + 0.01) over pixels and channels; `trimmed` leaves out the 0.1 %
of pixels whose error is greatest (fireflies). References r have --reference-spp samples (16384),
half by `lumenaut trace --integrator path` and half by Mitsuba's llvm_ad_rgb, other seeds than those
measured, so that they favour neither; kept in build/peers/references-SIZE. What remains of their own
noise, known from the difference of the halves, is taken off every error. Every renderer uses the
scene's reconstruction filter and, but for those called after one, the scene's sampler. classroom has
our sky baked into an envmap, as the renderers' own skies are different models.

Errors fall with time as C / t: C is fitted (in logarithms) to all numbers of samples, and the time
to equal error is as C is. `slopes` are the powers of t that a free fit finds, -1 for plain Monte
Carlo. Rendering alone is timed, by turns. Scenes done are in --output (build/peers/bench_error.json)
and are skipped the next time, unless --again or the settings differ.
"""
import argparse
import json
import math
import pathlib
import statistics
import subprocess
import sys
import tempfile

import numpy as np

import bench_scenes
import cases

FOLDER = cases.ROOT / "build/peers"
TRIM = 0.001
REFERENCE_SEED = 20001
PASS = 1024  # samples of one part of a reference
PEERS = {v: (v, None) for v in bench_scenes.VARIANTS}
STRATIFIED_PEER = {"llvm_ad_rgb multijitter": ("llvm_ad_rgb", "multijitter")}
OURS = {"lumenaut": ()}
INDEPENDENT_OURS = {"lumenaut independent": ("--sampler", "independent")}


class Peer:
    """A worker process, as a process has one variant: a picture in a file, and its seconds."""

    def __init__(self, folder, variant, sampler, scene, size):
        self.file = folder / f"{variant}-{sampler}.npy"
        command = [sys.executable, __file__, "--serve", variant, sampler or "", scene.name,
                   str(size), str(self.file)]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        text=True)

    def render(self, spp, seed):
        self.process.stdin.write(f"{spp} {seed}\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        if not line:
            raise SystemExit(f"{self.file.stem}: the worker ended")
        return np.load(self.file), float(line)

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def serve(variant, sampler, name, size, file):
    scene = bench_scenes.comparable(bench_scenes.chosen(name)[0])
    render = bench_scenes.theirs(variant, scene, bench_scenes.shares(scene), int(size), sampler)
    for line in sys.stdin:
        image, seconds = render(*map(int, line.split()))
        np.save(file, image)
        print(seconds, flush=True)


def read_image(path):
    """[height, width, 3] of what `lumenaut trace` wrote as PFM, whose rows go up."""
    with open(path, "rb") as file:
        assert file.readline().strip() == b"PF"
        width, height = map(int, file.readline().split())
        kind = "<f4" if float(file.readline()) < 0 else ">f4"
        data = np.frombuffer(file.read(), kind).reshape(height, width, 3)
    return data[::-1].astype(np.float64)


def our_renderer(folder, scene, u, size, options):
    def render(spp, seed):
        picture = folder / "ours.pfm"
        seconds = bench_scenes.ours(scene, u, size, spp, seed, *options, picture=picture)
        return read_image(picture), seconds
    return render


def in_passes(render, spp):
    """The mean of `spp` samples, in parts with seeds of their own."""
    parts = [min(PASS, spp - done) for done in range(0, spp, PASS)]
    images = [render(n, REFERENCE_SEED + i)[0] * (n / spp) for i, n in enumerate(parts)]
    return sum(images)


def reference(scene, size, spp, our_render, their_render):
    """Both halves, from the cache when they are there."""
    folder = FOLDER / f"references-{size}"
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{scene.name}-{scene.max_depth}-{spp}.npz"
    if path.exists():
        stored = np.load(path)
        if str(stored["values"]) == repr(scene.values):
            return stored["ours"], stored["theirs"]
    print(f"{scene.name}: reference of {spp} spp", file=sys.stderr, flush=True)
    halves = in_passes(our_render, spp // 2), in_passes(their_render, spp // 2)
    np.savez(path, ours=halves[0], theirs=halves[1], values=repr(scene.values))
    return halves


def errors(image, r):
    """(relMSE, relMSE without the worst pixels)"""
    e = ((image - r)**2 / (r * r + 0.01)).mean(axis=2).ravel()
    kept = np.sort(e)[:len(e) - math.ceil(TRIM * len(e))]
    return float(e.mean()), float(kept.mean())


def fit(points, noise):
    """C of error = C / t, and the power of t of a free fit; points are (seconds, error)."""
    t, e = (np.array(c) for c in zip(*points))
    e = np.maximum(e - noise, 0.05 * e)
    x, y = np.log(t), np.log(e)
    slope = float(np.polyfit(x, y, 1)[0]) if len(t) > 1 else -1.0
    return float(np.exp((x + y).mean())), slope


def summary(runs, noise):
    """Per renderer: at each number of samples mean errors and median seconds, constants, slopes."""
    out = {}
    for who, measured in runs.items():
        levels = []
        for spp, results in measured.items():
            levels.append({"spp": spp, "s": statistics.median(r["s"] for r in results),
                           "relmse": statistics.fmean(r["relmse"] for r in results),
                           "trimmed": statistics.fmean(r["trimmed"] for r in results)})
        out[who] = {"levels": levels}
        for k in ("relmse", "trimmed"):
            points = [(level["s"], level[k]) for level in levels]
            out[who][f"{k}_s"], out[who][f"{k}_slope"] = fit(points, noise[k])
    return out


def measure(scene, args):
    scene = bench_scenes.comparable(scene)
    u, levels = bench_scenes.shares(scene), [int(n) for n in args.spp.split(",")]
    kinds = {**PEERS, **(STRATIFIED_PEER if args.stratified else {})}
    mine = {**OURS, **(INDEPENDENT_OURS if args.stratified else {})}
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        peers = {who: Peer(folder, *how, scene, args.size) for who, how in kinds.items()}
        renders = {who: our_renderer(folder, scene, u, args.size, options)
                   for who, options in mine.items()}
        renders.update({who: peer.render for who, peer in peers.items()})
        plain = our_renderer(folder, scene, u, args.size, ("--integrator", "path"))
        halves = reference(scene, args.size, args.reference_spp, plain, renders["llvm_ad_rgb"])
        r = (halves[0] + halves[1]) / 2
        noise = dict(zip(("relmse", "trimmed"), (x / 4 for x in errors(halves[0] - halves[1] + r, r))))
        for who in peers: # compiles, for every number of samples
            for spp in levels if who != "scalar_rgb" else levels[:1]:
                renders[who](spp, 0)
        runs = {who: {spp: [] for spp in levels} for who in renders}
        for seed in range(1, args.runs + 1):
            for spp in levels:
                for who, render in renders.items():
                    image, seconds = render(spp, seed)
                    whole, trimmed = errors(image, r)
                    runs[who][spp].append({"seed": seed, "s": seconds, "relmse": whole,
                                           "trimmed": trimmed})
        for peer in peers.values():
            peer.close()
    result = {"scene": scene.name, "values": dict(scene.values), "max_depth": scene.max_depth,
              "reference_noise": noise, "renderers": summary(runs, noise), "runs": runs}
    for k in ("relmse", "trimmed"):
        costs = {who: r[f"{k}_s"] for who, r in result["renderers"].items()}
        result[f"{k}_ratio"] = min(costs[v] for v in PEERS) / costs["lumenaut"]
    return result


def print_scene(result):
    for who, r in result["renderers"].items():
        low, high = r["levels"][0], r["levels"][-1]
        ratio = result["renderers"]["lumenaut"]
        print(f"{result['scene']:<16}{who:<26}{low['relmse']:>10.5f}{high['relmse']:>10.5f}"
              f"{high['s']:>8.2f}{r['relmse_s']:>11.5f}{r['relmse_slope']:>7.2f}"
              f"{r['relmse_s'] / ratio['relmse_s']:>8.2f}{r['trimmed_s']:>11.5f}"
              f"{r['trimmed_slope']:>7.2f}{r['trimmed_s'] / ratio['trimmed_s']:>8.2f}", flush=True)


def print_means(results):
    for k in ("relmse", "trimmed"):
        ratios = {r["scene"]: r[f"{k}_ratio"] for r in results}
        worst = min(ratios, key=ratios.get)
        print(f"time to equal {k} over Mitsuba's faster variant: geometric mean "
              f"{statistics.geometric_mean(ratios.values()):.2f}, least {ratios[worst]:.2f} ({worst})")


def main():
    if sys.argv[1:2] == ["--serve"]:
        return serve(*sys.argv[2:])
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[2])
    parser.add_argument("--scenes", help="some of them, with commas between")
    parser.add_argument("--size", type=int, default=128)
    parser.add_argument("--spp", default="16,64,256")
    parser.add_argument("--runs", type=int, default=4)
    parser.add_argument("--reference-spp", type=int, default=16384)
    parser.add_argument("--stratified", action="store_true", help="the other sampler of both, too")
    parser.add_argument("--again", action="store_true", help="measure scenes that are done, too")
    parser.add_argument("--output", type=pathlib.Path, default=FOLDER / "bench_error.json")
    args = parser.parse_args()
    settings = {k: getattr(args, k) for k in ("size", "spp", "runs", "reference_spp", "stratified")}
    done = {}
    if args.output.exists():
        stored = json.loads(args.output.read_text(encoding="utf-8"))
        if stored["settings"] == settings:
            done = {r["scene"]: r for r in stored["results"]}
    print(f"{'scene':<16}{'renderer':<26}{'relMSE':>10}{'to':>10}{'in s':>8}{'relMSE s':>11}"
          f"{'slope':>7}{'/ours':>8}{'trimmed s':>11}{'slope':>7}{'/ours':>8}")
    results = []
    for scene in bench_scenes.chosen(args.scenes):
        if args.again or scene.name not in done:
            done[scene.name] = measure(scene, args)
            args.output.parent.mkdir(parents=True, exist_ok=True)
            document = {"settings": settings, "results": list(done.values())}
            args.output.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
        results.append(done[scene.name])
        print_scene(results[-1])
    if results:
        print_means(results)
    return 0


if __name__ == "__main__":
    sys.exit(main())
