#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""bench_torch_step.py [--width 512] [--depth 8] [--variables 8] [--patches 32] [--threads 2] [--runs 5]

Seconds of one training step (forward, loss, backward, Adam) of the paper's network in PyTorch, and of
a forward pass alone; medians after a warm-up, as JSON. `lumenaut bench train` measures the same step.
"""
import argparse
import json
import statistics
import time

import torch

import torch_generator


def median_seconds(run, n):
    run()
    times = []
    for _ in range(n):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return statistics.median(times)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    for name, value in (("width", 512), ("depth", 8), ("variables", 8), ("patches", 32),
                        ("patch-size", 32), ("threads", 2), ("runs", 5)):
        parser.add_argument(f"--{name}", type=int, default=value)
    a = parser.parse_args()
    torch.set_num_threads(a.threads)
    torch.manual_seed(1)

    net = torch_generator.Generator(a.variables, a.width, a.depth)
    adam = torch.optim.Adam(net.parameters(), lr=1e-4)
    side = a.patch_size
    inputs = torch.rand(a.patches, side, side, 16)
    inputs[..., :3] = 0
    v, targets = torch.rand(a.patches, a.variables), torch.rand(a.patches, side, side, 3)

    def step():
        adam.zero_grad(set_to_none=True)
        torch_generator.losses(net(inputs, v), targets, False).mean().backward()
        adam.step()

    def forward():
        with torch.no_grad():
            net(inputs, v)

    step_s, forward_s = median_seconds(step, a.runs), median_seconds(forward, a.runs)
    n_in = a.width + torch_generator.N_Q
    products = 3 * a.width + (a.depth + 1) * n_in * a.width + n_in * 3
    flop = 2.0 * products * a.patches * side * side
    print(json.dumps({"peer": f"torch {torch.__version__}", **vars(a), "step_s": step_s,
                      "step_gflops": 3e-9 * flop / step_s, "forward_s": forward_s,
                      "forward_gflops": 1e-9 * flop / forward_s}))


if __name__ == "__main__":
    main()
