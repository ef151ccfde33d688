#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""bench_report.py FOLDER OUT.md: a page with what `make bench` measured, from its JSON documents.

FOLDER has kernels.json, train.json, trace.json, frame.json, and with peers peers-train.json and
peers-trace.json; ../peers/bench_error.json is beside it after `make bench-error`. What is not there is
left out.
"""
import datetime
import json
import os
import pathlib
import platform
import statistics
import subprocess
import sys


def load(folder, name):
    path = folder / f"{name}.json"
    if not path.exists() or path.stat().st_size == 0:
        return None
    return json.loads(path.read_text(encoding="utf-8"))


def table(headings, rows):
    lines = ["| " + " | ".join(headings) + " |",
             "| " + " | ".join("---" if i == 0 else "---:" for i in range(len(headings))) + " |"]
    return lines + ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows] + [""]


def machine():
    for line in pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
        if line.startswith("model name"):
            return line.split(":", 1)[1].strip()
    return platform.machine()


def revision(root):
    command = ["git", "-C", str(root), "describe", "--always", "--dirty"]
    return subprocess.run(command, capture_output=True, text=True, check=False).stdout.strip()


def scene_name(path):
    return pathlib.Path(path).parent.name


def ours(folder):
    lines = []
    kernels, train = load(folder, "kernels"), load(folder, "train")
    trace, buffers, frame = load(folder, "trace"), load(folder, "buffers"), load(folder, "frame")
    if train:
        lines += ["## Training step", "", f"`lumenaut bench train --runs {train['runs']}`", ""]
        rows = [(r["width"], r["patches"], f"{r['step_s']:.3f}", f"{r['gflops']:.0f}",
                 f"{r['peak_gflops']:.0f}", f"{100 * r['share_of_peak']:.0f} %")
                for r in train["results"]]
        lines += table(("width", "patches of 32x32", "s", "GFLOP/s", "fp32 peak GFLOP/s", "share"), rows)
    if kernels:
        lines += ["## Network", "", f"`lumenaut bench kernels --runs {kernels['runs']}`, width "
                  f"{kernels['width']}, {kernels['kernels']} kernels", ""]
        rows = [(r["name"], f"{r['seconds']:.3f}", f"{r['gflops']:.0f}",
                 f"{100 * r['share_of_peak']:.0f} %") for r in kernels["results"]]
        lines += table(("what", "s", "GFLOP/s", "share of peak"), rows)
    if trace:
        lines += ["## Path tracing", "", f"`lumenaut bench trace --runs {trace['runs']}`; change: from "
                  "new values of all variables to being ready to trace; rays: the share of time that finding "
                  "what they meet takes (Embree, or our own code in scenes of few primitives)", ""]
        rows = [(scene_name(r["file"]), f"{r['size'][0]}x{r['size'][1]}", r["spp"], r["max_depth"],
                 r["triangles"], f"{r['paths_per_s'] / 1e6:.2f}",
                 f"{100 * r['ray_share']:.0f} %", f"{r['load_s']:.2f}",
                 f"{r['build_s']:.2f}", f"{1e3 * r['change_s']:.3f}") for r in trace["results"]]
        lines += table(("scene", "size", "spp", "depth", "triangles", "Mpaths/s", "rays", "load s", "build s",
                        "change ms"), rows)
    if buffers:
        lines += ["## First-hit buffers", "", f"`lumenaut bench buffers --runs {buffers['runs']}`", ""]
        rows = [(scene_name(r["file"]), f"{r['size'][0]}x{r['size'][1]}", r["buffer_spp"],
                 f"{1e3 * r['buffers_s']:.1f}", f"{r['frames_per_s']:.1f}") for r in buffers["results"]]
        lines += table(("scene", "size", "spp", "ms", "frames/s"), rows)
    if frame:
        lines += ["## A frame by the network", "", f"`lumenaut bench frame --runs {frame['runs']}`", ""]
        rows = [(scene_name(r["file"]), f"{r['size'][0]}x{r['size'][1]}", r["method"], r["width"],
                 r["variables"], f"{r['frame_s']:.3f}", f"{r['buffers_s']:.3f}", f"{r['network_s']:.3f}",
                 f"{r['network_gflops']:.0f}") for r in frame["results"]]
        lines += table(("scene", "size", "method", "width", "variables", "frame s", "buffers s",
                        "network s", "GFLOP/s"), rows)
    return lines


def against_peers(folder):
    lines = []
    train, trace = load(folder, "peers-train"), load(folder, "peers-trace")
    if train:
        lines += ["## Training step beside PyTorch", "", "`.venv/bin/python scripts/peers/bench_train.py "
                  f"--runs {train['runs']}`, alternating, {train['threads']} threads", ""]
        rows = [("lumenaut", f"{train['step_s']:.3f}", f"{train['gflops']:.0f}",
                 f"{train['speedup']:.2f}"),
                (train["peer"], f"{train['peer_step_s']:.3f}", f"{train['peer_gflops']:.0f}", "1")]
        lines += table(("who", "s", "GFLOP/s", "times as fast"), rows)
    if trace:
        lines += ["## Path tracing beside Mitsuba 3", "", "`.venv/bin/python scripts/peers/bench_trace.py "
                  f"--runs {trace[0]['runs']}`, alternating, Mpaths/s", ""]
        rows = []
        for r in trace:
            rate = r["mpaths_per_s"]
            rows.append((r["scene"], r["size"], r["spp"], r["max_depth"], f"{rate['lumenaut']:.2f}",
                         f"{rate['scalar_rgb']:.2f}", f"{rate['llvm_ad_rgb']:.2f}",
                         f"{rate['lumenaut'] / rate['scalar_rgb']:.2f}",
                         f"{rate['lumenaut'] / rate['llvm_ad_rgb']:.2f}"))
        lines += table(("scene", "side", "spp", "depth", "lumenaut", "scalar_rgb", "llvm_ad_rgb",
                        "/ scalar", "/ llvm"), rows)
        lines += means("the faster variant", {r["scene"]: r["ratio"] for r in trace})
    return lines + equal_error(load(folder.parent / "peers", "bench_error"))


def means(what, ratios):
    worst = min(ratios, key=ratios.get)
    return [f"Over {what}: geometric mean {statistics.geometric_mean(ratios.values()):.2f}, least "
            f"{ratios[worst]:.2f} ({worst}).", ""]


def equal_error(document):
    """Time to equal relMSE: error times seconds, per renderer, from bench_error.py."""
    if not document:
        return []
    o = document["settings"]
    lines = ["## Time to equal error beside Mitsuba 3", "", f"`make bench-error`: {o['size']}x"
             f"{o['size']}, {o['spp']} spp, {o['runs']} runs each by turns, references of "
             f"{o['reference_spp']} spp (half ours, half Mitsuba's). relMSE times seconds, fitted over "
             "the numbers of samples; in brackets without the 0.1 % of pixels that are worst. How many "
             "times as long the faster of Mitsuba's variants takes to the same error, last.", ""]
    names = list(document["results"][0]["renderers"])
    rows = []
    for r in document["results"]:
        costs = [f"{1e3 * r['renderers'][n]['relmse_s']:.3g} ({1e3 * r['renderers'][n]['trimmed_s']:.3g})"
                 for n in names]
        rows.append((r["scene"], r["max_depth"], *costs,
                     f"{r['relmse_ratio']:.2f} ({r['trimmed_ratio']:.2f})"))
    lines += table(("scene", "depth", *(f"{n}, 1e-3 s" for n in names), "times as long"), rows)
    lines += means("relMSE", {r["scene"]: r["relmse_ratio"] for r in document["results"]})
    return lines + means("relMSE without the worst pixels",
                         {r["scene"]: r["trimmed_ratio"] for r in document["results"]})


def main():
    folder, out = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    body = ours(folder) + against_peers(folder)
    if not body:
        print(f"bench_report: nothing in {folder}", file=sys.stderr)
        return 1
    cpus = len(os.sched_getaffinity(0))
    load_average = os.getloadavg()[1]
    head = ["# Measurements", "", f"Written by `make bench` on {datetime.date.today().isoformat()}, "
            f"revision {revision(out.resolve().parents[1])}, from the JSON of each command: {machine()}, "
            f"{cpus} CPUs, {platform.system()} {platform.release().split('-')[0]}. Figures are medians. "
            f"Load average of the last five minutes: {load_average:.1f}"
            f"{' (others were at work: read times as upper bounds)' if load_average > cpus + 1 else ''}.",
            ""]
    out.write_text("\n".join(head + body).rstrip() + "\n", encoding="utf-8")
    print(out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
