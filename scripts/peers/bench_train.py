#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""bench_train.py [--json] [--runs 5]: seconds of a training step, `lumenaut bench train` and PyTorch.

The same step (32 patches of 32x32, the paper's network) on the same CPUs; runs alternate between the
two, each after a warm-up of its own; medians.
"""
import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys

HERE = pathlib.Path(__file__).parent
LUMENAUT = HERE.parents[1] / "build/release/lumenaut"


def run(*command):
    return json.loads(subprocess.run([str(c) for c in command], check=True,
                                     stdout=subprocess.PIPE).stdout)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name, value in (("runs", 5), ("width", 512), ("depth", 8), ("patches", 32),
                        ("threads", len(os.sched_getaffinity(0)))):
        parser.add_argument(f"--{name}", type=int, default=value)
    parser.add_argument("--json", action="store_true")
    a = parser.parse_args()
    sizes = ["--width", a.width, "--depth", a.depth, "--patches", a.patches, "--threads", a.threads,
             "--runs", 1]
    ours, theirs = [], []
    for _ in range(a.runs):
        ours.append(run(LUMENAUT, "bench", "train", "--json", "-q", *sizes)["results"][0])
        theirs.append(run(sys.executable, HERE / "bench_torch_step.py", *sizes))
    result = {"bench": "train", **vars(a), "peer": theirs[0]["peer"],
              "step_s": statistics.median(r["step_s"] for r in ours),
              "peer_step_s": statistics.median(r["step_s"] for r in theirs),
              "gflops": statistics.median(r["gflops"] for r in ours),
              "peer_gflops": statistics.median(r["step_gflops"] for r in theirs),
              "share_of_peak": statistics.median(r["share_of_peak"] for r in ours),
              "seconds": {"lumenaut": [r["step_s"] for r in ours],
                          "peer": [r["step_s"] for r in theirs]}}
    result["speedup"] = result["peer_step_s"] / result["step_s"]
    if a.json:
        print(json.dumps(result, indent=1))
    else:
        print(f"step of {a.patches} patches, width {a.width}: lumenaut {result['step_s']:.3f} s, "
              f"{result['peer']} {result['peer_step_s']:.3f} s: {result['speedup']:.2f} x, "
              f"{100 * result['share_of_peak']:.0f} % of the fp32 peak")
    return 0


if __name__ == "__main__":
    sys.exit(main())
