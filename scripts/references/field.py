#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""field.py [FOLDER]           (default: tests/nn/data)
field.py --check BINARY     makes references afresh and runs BINARY (test_nn_field_references) on them

A small compact network (src/nn/field.h) in PyTorch, in doubles: hash grids, layers, output, loss, and
autograd's gradient of all weights, those of the grids included. field.bin holds floats (weights and
pixels of a few runs; outputs, losses, errors, gradient), field.json says where in it they are.
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import torch

N_RUN = [33, 1, 130, 64] # pixels; the third in more than one tile
CONFIG = {"n_grids": 2, "n_levels": 5, "log2_size": 9, "base": 4, "growth": 1.5,
          "n_features": 7, "n_variables": 5, "n_lights": 2, "width": 24, "depth": 3}
N_FEATURES_OF_LEVEL = 2
PRIMES = [1, 2654435761, 805459861]
LARGEST_BELOW_1 = 1 - 2**-24
MOST_PULL, MOST_SURPRISE = 16, 30 # bounds of src/nn/field_train.c


def levels():
    """(cells along an edge, entries) of each level of a grid."""
    n_cells = CONFIG["base"]
    for _ in range(CONFIG["n_levels"]):
        edge = int(n_cells) + 1
        yield int(n_cells), min(edge**3, 1 << CONFIG["log2_size"])
        n_cells *= CONFIG["growth"]


def encode_level(table, n_cells, p):
    """Eq. 4 and trilinear interpolation of Mueller et al. 2022; p [n][3], table [entries][2]."""
    x = p.clamp(0, LARGEST_BELOW_1) * n_cells
    low = x.floor().long()
    f = x - low
    edge, out = n_cells + 1, 0
    for corner in range(8):
        offset = torch.tensor([corner & 1, corner >> 1 & 1, corner >> 2])
        i = low + offset
        if edge**3 > len(table):
            hashed = [i[:, a] * PRIMES[a] & 0xFFFFFFFF for a in range(3)]
            entry = (hashed[0] ^ hashed[1] ^ hashed[2]) % len(table)
        else:
            entry = i[:, 0] + edge * (i[:, 1] + edge * i[:, 2])
        weight = torch.where(offset == 1, f, 1 - f).prod(1)
        out = out + weight[:, None] * table[entry]
    return out


class Field:
    """Weights in one flat tensor: tables, then W row by row and b of each layer."""

    def __init__(self, flat):
        self.flat = flat.clone().requires_grad_()
        self.tables, self.layers, at = [], [], 0

        def take(*shape):
            nonlocal at
            size = int(torch.tensor(shape).prod())
            at += size
            return self.flat[at - size:at].reshape(shape)

        for _ in range(CONFIG["n_grids"]):
            self.tables.append([(n, take(entries, N_FEATURES_OF_LEVEL)) for n, entries in levels()])
        for n_out, n_in in shapes():
            self.layers.append((take(n_out, n_in), take(n_out)))
        assert at == len(flat)

    def __call__(self, positions, features, scale, v, lights, most):
        """Of a run's pixels radiance [n][3], whose gradient by an output is at most `most` [n], and
        the logarithm of the expected loss [n]."""
        encoded = [encode_level(table, n, positions[:, g])
                   for g, grid in enumerate(self.tables) for n, table in grid]
        h = torch.cat([*encoded, features, v.expand(len(features), -1)], 1)
        for w, b in self.layers[:-1]:
            h = torch.nn.functional.leaky_relu(h @ w.T + b, 0.01)
        w, b = self.layers[-1]
        o = h @ w[:-1].T + b[:-1]
        if o.requires_grad:
            o.register_hook(lambda d: d.clamp(-most[:, None], most[:, None]))
        parts = o.clamp(-10, 12).exp().reshape(len(o), CONFIG["n_lights"], 3)
        return scale * (lights * parts).sum(1), (h.detach() @ w[-1] + b[-1]).clamp(-10, 12)


def shapes():
    """[n_out, n_in] of the layers."""
    n_in = (CONFIG["n_grids"] * CONFIG["n_levels"] * N_FEATURES_OF_LEVEL + CONFIG["n_features"] +
            CONFIG["n_variables"])
    sizes = [n_in] + [CONFIG["width"]] * CONFIG["depth"] + [3 * CONFIG["n_lights"] + 1]
    return [(sizes[i + 1], sizes[i]) for i in range(len(sizes) - 1)]


def luminance(x):
    return (x @ torch.tensor([0.2126, 0.7152, 0.0722], dtype=x.dtype))[:, None]


def loss_of(f, y, half):
    """Relative squared error per number, of each half by the other's denominator, held constant."""
    a, b, bright = y + half, y - half, luminance(f.detach())

    def denominator(other):
        return bright * (0.25 * bright + 0.75 * luminance(other).clamp(min=0)) + 0.01

    return 0.5 * (f - a)**2 / denominator(b) + 0.5 * (f - b)**2 / denominator(a)


def error_of(f, y, half):
    return (f - y - half) * (f - y + half) / (luminance(f)**2 + 0.01)


def start_weights():
    """Tables as after some learning, layers as PyTorch initialises them."""
    parts = [torch.rand(n * N_FEATURES_OF_LEVEL) - 0.5
             for _ in range(CONFIG["n_grids"]) for _, n in levels()]
    for n_out, n_in in shapes():
        parts.append((2 * torch.rand(n_out * (n_in + 1)) - 1) / n_in**0.5)
    return torch.cat(parts).float().double() # what a float can hold, so that both start from the same


def pixels():
    """Some positions beyond the cube; dark scales and targets; a few bright targets."""
    n = sum(N_RUN)
    bright = 1 + 30 * (torch.rand(n, 1) < 0.05)
    arrays = {"positions": 1.1 * torch.rand(n, CONFIG["n_grids"], 3) - 0.05,
              "features": 2 * torch.rand(n, CONFIG["n_features"]) - 1,
              "scale": torch.rand(n, 3) * (torch.rand(n, 1) < 0.9),
              "targets": torch.rand(n, 3)**2 * bright * (torch.rand(n, 1) < 0.9),
              "halves": torch.rand(n, 3) - 0.5,
              "weights_of_pixels": 0.2 + 2 * torch.rand(n),
              "v": torch.rand(len(N_RUN), CONFIG["n_variables"]),
              "lights": 0.1 + torch.rand(len(N_RUN), CONFIG["n_lights"], 3)}
    return {name: a.float().double() for name, a in arrays.items()}


def write(folder):
    folder.mkdir(parents=True, exist_ok=True)
    torch.manual_seed(5)
    torch.set_num_threads(1)
    arrays = {"weights": start_weights(), **pixels()}
    field = Field(arrays["weights"])
    outputs, losses, errors, total, first = [], [], [], 0, 0
    for i, n in enumerate(N_RUN):
        run = slice(first, first + n)
        positions, features, scale, y, half, weights = (
            arrays[name][run] for name in ("positions", "features", "scale", "targets", "halves",
                                           "weights_of_pixels"))
        unit = 1 / (3 * sum(N_RUN))
        f, expected = field(positions, features, scale, arrays["v"][i], arrays["lights"][i],
                            MOST_PULL * unit * weights)
        loss = loss_of(f, y, half)
        surprise = (loss.detach().mean(1) / expected.detach().exp()).clamp(max=MOST_SURPRISE)
        total = total + unit * ((weights[:, None] * loss).sum() + (expected * (1 - surprise)).sum())
        outputs.append(f.detach())
        losses.append((weights[:, None] * loss.detach()).mean())
        errors.append((weights[:, None] * error_of(f.detach(), y, half)).mean())
        first += n
    total.backward()
    arrays["outputs"] = torch.cat(outputs)
    arrays["losses"] = torch.stack(losses)
    arrays["errors"] = torch.stack(errors)
    arrays["gradient"] = field.flat.grad

    where, data, offset = {}, b"", 0
    for name, value in arrays.items():
        floats = value.reshape(-1).float().numpy().astype("<f4")
        where[name] = [offset, len(floats)]
        offset += len(floats)
        data += floats.tobytes()
    (folder / "field.bin").write_bytes(data)
    document = {"peer": f"torch {torch.__version__.split('+')[0]}", **CONFIG, "runs": N_RUN,
                "arrays": where}
    (folder / "field.json").write_text(json.dumps(document, indent=1) + "\n")
    print(f"{document['peer']}: {len(data)} bytes in {folder / 'field.bin'}")


def main():
    if len(sys.argv) == 3 and sys.argv[1] == "--check":
        with tempfile.TemporaryDirectory() as parent:
            write(pathlib.Path(parent) / "nn")
            environment = {**os.environ, "LMN_REFERENCES": parent}
            sys.exit(subprocess.run([sys.argv[2]], env=environment, check=False).returncode)
    write(pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "tests/nn/data"))


if __name__ == "__main__":
    main()
