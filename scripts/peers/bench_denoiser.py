#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""bench_denoiser.py [--scene FILE] [--configurations 8] [--json OUT] [--markdown OUT] MODEL...

A frame by a model beside path tracing and Intel's Open Image Denoise (PyPI pyoidn) given the same time
and ten times the same time. T is the median time of the frame, buffers, network and all, of --size
(900x900) with --buffer-spp (1) on --threads (2). Within T, and within 10 T, the tracer takes as many
samples as fit in what the denoiser leaves of it, at least one; the denoiser gets albedo and normals
from the same samples. Albedo that is 0 (metals, glass) becomes 1, as its manual asks, and pixels are
box-filtered (splatting correlates their noise, on which it fails), those of the references too. Its
times are those of its filter alone, prepared and warm. Rows say when it alone takes longer.

Configurations are those of `lumenaut eval` with --seed: uniform draws. Errors are `lumenaut compare`'s
in the --crop middle pixels of each side (whole pictures are made and denoised), against the mean of two
traced halves of --reference-spp (1024) samples in all; `noise` is half the error of one half against
the other. References are kept in build/peers/denoiser. No training may run beside it. The program is
build/release/lumenaut, or what LUMENAUT names (with LD_LIBRARY_PATH for its library).
"""
import argparse
import hashlib
import importlib.metadata
import json
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ElementTree

import numpy as np
import OpenEXR
import pyoidn

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDER = ROOT / "build/peers/denoiser"
LUMENAUT = pathlib.Path(os.environ.get("LUMENAUT", ROOT / "build/release/lumenaut"))
QUALITIES = ("high", "fast")
METRICS = ("mape", "relmse", "flip", "flip_hdr")
SEED, REFERENCE_SEEDS = 7, (40001, 40002)
OIDN_VERSION = importlib.metadata.version("pyoidn")


def limit_threads(n):
    """Before the denoiser is first used: it takes as many threads as the process may."""
    os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:n])


def run(*words):
    done = subprocess.run([LUMENAUT, *map(str, words)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(done.stderr.strip() or f"lumenaut {words[0]}: exit {done.returncode}")
    return json.loads(done.stdout)


def channels(path):
    """{name: [height, width]} of an EXR, in floats."""
    file = OpenEXR.File(str(path), separate_channels=True)
    return {name: c.pixels.astype(np.float32) for name, c in file.channels().items()}


def stack(c, prefix, letters):
    return np.ascontiguousarray(np.stack([c[f"{prefix}{x}"] for x in letters], axis=2))


def write_pfm(path, image):
    height, width, _ = image.shape
    path.write_bytes(f"PF\n{width} {height}\n-1\n".encode() + image[::-1].astype("<f4").tobytes())


def box_filtered(scene, folder):
    """The path of a copy of the scene whose film has a box filter, its files beside it by links."""
    scene = pathlib.Path(scene).resolve()
    tree = ElementTree.parse(scene)
    films = list(tree.iter("film"))
    if not films:
        raise SystemExit(f"{scene}: has no <film> of its own")
    for film in films:
        for node in film.findall("rfilter"):
            film.remove(node)
        ElementTree.SubElement(film, "rfilter", type="box")
    for path in scene.parent.iterdir():
        if path != scene:
            (folder / path.name).symlink_to(path)
    tree.write(folder / scene.name)
    return folder / scene.name


class Picture:
    """How pictures of one configuration are made, and judged in the middle of them."""

    def __init__(self, args, model, scene, box_scene, values, folder):
        self.args, self.model, self.scene, self.folder = args, model, scene, folder
        self.box_scene = box_scene
        self.sets = [w for name, v in values.items() for w in ("-P", f"{name}={v!r}")]
        width, height = map(int, args.size.split("x"))
        w, h = min(args.crop, width), min(args.crop, height)
        self.box = ((width - w) // 2, (height - h) // 2, w, h)

    def middle(self, image):
        x, y, w, h = self.box
        return image[y:y + h, x:x + w]

    def made(self, command, file, *words):
        """(report, channels) of `lumenaut render` or `trace`."""
        out = self.folder / "picture.exr"
        report = run(command, file, "-o", out, "--json", "-q", "-t", self.args.threads, "--size",
                     self.args.size, *self.sets, *words)
        return report, out

    def frame(self):
        times = []
        for _ in range(self.args.runs):
            report, out = self.made("render", self.model, "--spp", self.args.buffer_spp, "--seed", SEED,
                                    "--scene", self.scene)
            times.append(report["render_s"])
        return statistics.median(times), stack(channels(out), "", "RGB")

    def trace(self, spp, *words):
        report, out = self.made("trace", self.box_scene, "--spp", spp, "--integrator", "path", "--buffers",
                                "--seed", SEED, *words)
        return report["render_s"], out

    def reference(self):
        """Two halves, from the folder when they are there."""
        spp = self.args.reference_spp // 2
        key = hashlib.sha256(repr(("box", self.scene, pathlib.Path(self.scene).stat().st_mtime, self.sets,
                                   self.args.size, self.box, spp)).encode()).hexdigest()[:16]
        halves = []
        for seed in REFERENCE_SEEDS:
            path = FOLDER / f"{key}-{seed}.exr"
            if not path.exists():
                FOLDER.mkdir(parents=True, exist_ok=True)
                run("trace", self.box_scene, "-o", self.folder / "half.exr", "--json", "-q", "-t",
                    self.args.threads, "--size", self.args.size, "--crop", ",".join(map(str, self.box)),
                    "--spp", spp, "--integrator", "path", "--seed", seed, *self.sets)
                shutil.move(self.folder / "half.exr", path)
            halves.append(stack(channels(path), "", "RGB"))
        return halves

    def errors(self, image, reference):
        paths = [self.folder / "a.pfm", self.folder / "b.pfm"]
        for path, picture in zip(paths, (image, reference)):
            write_pfm(path, picture)
        found = run("compare", *paths, "--json")["metrics"]
        return {m: found[m] for m in METRICS}


def denoised(path, quality):
    """(seconds of the warm filter, picture)"""
    c = channels(path)
    color, albedo, normal = stack(c, "", "RGB"), stack(c, "albedo.", "RGB"), stack(c, "normal.", "XYZ")
    color = np.maximum(color, 0)
    albedo = np.clip(np.where(albedo.max(axis=2, keepdims=True) > 0, albedo, 1), 0, 1)
    normal = np.clip(normal, -1, 1)
    times, out = [], None
    for i in range(3):
        start = time.perf_counter()
        out = pyoidn.denoise(color, albedo, normal, hdr=True, quality=quality)
        if i > 0: # the first prepares the filter
            times.append(time.perf_counter() - start)
    return min(times), out


def fitting(budget, costs):
    """Samples per pixel that fit, at least 1; costs: (seconds before the first, of each)."""
    return max(1, int((budget - costs[0]) / max(costs[1], 1e-9)))


def measure(picture):
    """{method: {seconds, spp, errors}} of one configuration."""
    frame_s, frame = picture.frame()
    halves = picture.reference()
    reference = (halves[0] + halves[1]) / 2
    noise = {k: v / 2 for k, v in picture.errors(*halves).items()}
    rows = {"network": {"budget_s": frame_s, "s": frame_s, "denoise_s": 0.0,
                        "spp": picture.args.buffer_spp,
                        "errors": picture.errors(picture.middle(frame), reference)}}
    timed = {spp: min(picture.trace(spp)[0] for _ in range(picture.args.runs)) for spp in (1, 5)}
    each = (timed[5] - timed[1]) / 4
    costs = (max(0.0, timed[1] - each), each)
    for quality in QUALITIES:
        alone_s, _ = denoised(picture.trace(1)[1], quality)
        for factor in (1, 10):
            budget = factor * frame_s
            spp = fitting(budget - alone_s, costs)
            trace_s, path = picture.trace(spp)
            denoise_s, image = denoised(path, quality)
            rows[f"path tracing + OIDN {quality}, {factor} T"] = {
                "budget_s": budget, "s": trace_s + denoise_s, "denoise_s": denoise_s, "spp": spp,
                "errors": picture.errors(picture.middle(image), reference)}
    for factor in (1, 10):
        budget = factor * frame_s
        spp = fitting(budget, costs)
        trace_s, path = picture.trace(spp)
        rows[f"path tracing alone, {factor} T"] = {
            "budget_s": budget, "s": trace_s, "denoise_s": 0.0, "spp": spp,
            "errors": picture.errors(picture.middle(stack(channels(path), "", "RGB")), reference)}
    return {"noise": noise, "methods": rows}


def mean_of(results):
    """The same of all configurations: means, of times and samples medians."""
    out = {}
    for who in results[0]["methods"]:
        rows = [r["methods"][who] for r in results]
        out[who] = {k: statistics.median(r[k] for r in rows) for k in ("budget_s", "s", "denoise_s",
                                                                       "spp")}
        out[who]["errors"] = {m: statistics.fmean(r["errors"][m] for r in rows) for m in METRICS}
    return out


def bench(model, args):
    scene = args.scene or run("params", model, "--json")["scene"]
    listed = run("eval", model, "-n", args.configurations, "--size", 16, "--spp", 2, "--seed", args.seed,
                 "--json", "-q", "--scene", scene)["configurations"]
    results = []
    with tempfile.TemporaryDirectory(prefix="lumenaut-denoiser-") as name, \
            tempfile.TemporaryDirectory(prefix="lumenaut-scene-") as scene_folder:
        box_scene = box_filtered(scene, pathlib.Path(scene_folder))
        for i, c in enumerate(listed):
            print(f"{model}: configuration {i + 1} of {len(listed)}", file=sys.stderr, flush=True)
            picture = Picture(args, model, scene, box_scene, c["values"], pathlib.Path(name))
            results.append({"values": c["values"], **measure(picture)})
    noise = {m: statistics.fmean(r["noise"][m] for r in results) for m in METRICS}
    return {"model": str(model), "scene": scene, "reference_noise": noise, "mean": mean_of(results),
            "configurations": results}


def note(row):
    return " (alone longer than that)" if row["denoise_s"] > row["budget_s"] else ""


def table(result):
    lines = ["| | s | of it OIDN | spp | MAPE | relMSE | FLIP | HDR-FLIP |",
             "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |"]
    for who, row in result["mean"].items():
        e = row["errors"]
        lines.append(f"| {who}{note(row)} | {row['s']:.3f} | {row['denoise_s']:.3f} | {row['spp']:g} | "
                     f"{e['mape']:.4f} | {e['relmse']:.5f} | {e['flip']:.4f} | {e['flip_hdr']:.4f} |")
    e = result["reference_noise"]
    lines.append(f"| noise of the references | | | | {e['mape']:.4f} | {e['relmse']:.5f} | "
                 f"{e['flip']:.4f} | {e['flip_hdr']:.4f} |")
    return lines


def document(results, args):
    w = min(args.crop, *map(int, args.size.split("x")))
    lines = ["# The neural frame beside path tracing and a denoiser", "",
             f"Written by `scripts/peers/bench_denoiser.py`: {args.configurations} uniform "
             f"configurations, pictures of {args.size} on {args.threads} threads, errors in the middle "
             f"{w}x{w} pixels against {args.reference_spp} spp. T is the time of the network's frame, "
             f"whose buffers have {args.buffer_spp} spp; OIDN {OIDN_VERSION}.", ""]
    for r in results:
        lines += [f"## {pathlib.Path(r['scene']).parent.name}", "", *table(r), ""]
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[2])
    parser.add_argument("models", nargs="+", metavar="MODEL", type=pathlib.Path)
    parser.add_argument("--scene", help="where the scene is, when not where the model says")
    parser.add_argument("--configurations", type=int, default=8)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--size", default="900x900")
    parser.add_argument("--crop", type=int, default=300)
    parser.add_argument("--buffer-spp", type=int, default=1)
    parser.add_argument("--reference-spp", type=int, default=1024)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--markdown", type=pathlib.Path)
    args = parser.parse_args()
    limit_threads(args.threads)
    results = [bench(model, args) for model in args.models]
    for r in results:
        print(f"\n{r['model']}: {r['scene']}", *table(r), sep="\n")
    if args.json:
        settings = {k: str(v) for k, v in vars(args).items()}
        args.json.write_text(json.dumps({"settings": settings, "oidn": OIDN_VERSION, "results": results},
                                        indent=1) + "\n", encoding="utf-8")
    if args.markdown:
        args.markdown.write_text(document(results, args), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
