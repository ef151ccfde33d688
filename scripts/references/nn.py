#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""nn.py [FOLDER]           (default: tests/nn/data)
nn.py --check BINARY     makes references afresh and runs BINARY (test_nn_references) on them

A small generator network in PyTorch, in doubles: nn.bin holds floats (weights, inputs, targets; outputs,
and for both axes of SSIM losses, gradient, weights after Adam steps, norms), nn.json says where in it
they are. tests/nn/test_references.c compares with them; LMN_REFERENCES=PARENT makes it read PARENT/nn.
"""
import copy
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import torch

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "peers"))
import torch_generator

CONFIG = {"n_variables": 5, "width": 24, "depth": 2, "patch_size": 12, "n_patches": 3}
STEPS, LEARNING_RATE = 3, 1e-4


def make_batch():
    """Smooth patches with noise; every fifth pixel emits, some above where emission wins."""
    n, side, d = CONFIG["n_patches"], CONFIG["patch_size"], CONFIG["n_variables"]
    inputs = torch.rand(n, side, side, 16)
    inputs[..., :3] *= (torch.rand(n, side, side, 1) < 0.2) * 4
    ramp = torch.linspace(0, 1, side)
    smooth = (ramp[:, None] + ramp[None, :])[None, ..., None] * torch.rand(n, 1, 1, 3)
    targets = torch.log1p(smooth + 0.3 * torch.rand(n, side, side, 3))
    return inputs, torch.rand(n, d), targets


def gradient_norms(net, inputs, v, targets, legacy):
    norms = []
    for p in range(len(inputs)):
        net.zero_grad()
        torch_generator.losses(net(inputs[p:p + 1], v[p:p + 1]), targets[p:p + 1], legacy).backward()
        norms.append(net.flat(lambda w: w.grad).norm())
    return torch.stack(norms)


def step_norms(net, adam, inputs, v, targets, legacy):
    """The step that Adam would make for each patch alone."""
    norms = []
    for p in range(len(inputs)):
        other = copy.deepcopy(net)
        trial = torch.optim.Adam(other.parameters(), lr=LEARNING_RATE)
        trial.load_state_dict(copy.deepcopy(adam.state_dict()))
        other.zero_grad()
        f = other(inputs[p:p + 1], v[p:p + 1])
        torch_generator.losses(f, targets[p:p + 1], legacy).backward()
        trial.step()
        norms.append((other.flat() - net.flat()).norm())
    return torch.stack(norms)


def train(start, inputs, v, targets, legacy):
    net = copy.deepcopy(start)
    adam = torch.optim.Adam(net.parameters(), lr=LEARNING_RATE)
    out = {"gradient_norms": gradient_norms(net, inputs, v, targets, legacy)}
    for step in range(STEPS):
        net.zero_grad()
        losses = torch_generator.losses(net(inputs, v), targets, legacy)
        losses.mean().backward()
        if step == 0:
            out["losses"] = losses.detach()
            out["gradient"] = net.flat(lambda w: w.grad)
        adam.step()
    out["weights_after"] = net.flat()
    out["step_norms"] = step_norms(net, adam, inputs, v, targets, legacy)
    return out


def write(folder):
    folder.mkdir(parents=True, exist_ok=True)
    torch.manual_seed(4)
    torch.set_num_threads(1)

    net = torch_generator.Generator(CONFIG["n_variables"], CONFIG["width"], CONFIG["depth"]).double()
    for p in net.parameters():
        p.data = p.data.float().double() # what a float can hold, so that both start from the same
    inputs, v, targets = (x.float().double() for x in make_batch())
    arrays = {"weights": net.flat(), "inputs": inputs, "v": v, "targets": targets,
              "outputs": net(inputs, v).detach()}
    for axes, legacy in (("correct", False), ("legacy", True)):
        results = train(net, inputs, v, targets, legacy)
        arrays.update({f"{axes}.{name}": value for name, value in results.items()})

    where, data, offset = {}, b"", 0
    for name, value in arrays.items():
        floats = value.reshape(-1).float().numpy().astype("<f4")
        where[name] = [offset, len(floats)]
        offset += len(floats)
        data += floats.tobytes()
    (folder / "nn.bin").write_bytes(data)
    document = {"peer": f"torch {torch.__version__.split('+')[0]}", **CONFIG, "n_steps": STEPS,
                "learning_rate": LEARNING_RATE, "arrays": where}
    (folder / "nn.json").write_text(json.dumps(document, indent=1) + "\n")
    print(f"{document['peer']}: {len(data)} bytes in {folder / 'nn.bin'}")


def main():
    if len(sys.argv) == 3 and sys.argv[1] == "--check":
        with tempfile.TemporaryDirectory() as parent:
            write(pathlib.Path(parent) / "nn")
            environment = {**os.environ, "LMN_REFERENCES": parent}
            sys.exit(subprocess.run([sys.argv[2]], env=environment, check=False).returncode)
    write(pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "tests/nn/data"))


if __name__ == "__main__":
    main()
