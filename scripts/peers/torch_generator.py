# SPDX-License-Identifier: Apache-2.0
"""The paper's generator and its loss in PyTorch, for references and benchmarks.

Inputs of a pixel: emission 3 | normal 3 | position 3 | wi 3 | albedo 3 | alpha 1, then v.
src/nn/generator.h says the same in C.
"""
import torch
from torch import nn
from torch.nn import functional

N_Q = 13


class Generator(nn.Module):
    def __init__(self, n_variables, width, depth):
        super().__init__()
        n_in = width + N_Q + n_variables
        self.position = nn.Linear(3, width)
        self.hidden = nn.ModuleList(nn.Linear(n_in, width) for _ in range(depth + 1))
        self.output = nn.Linear(n_in, 3)

    def forward(self, inputs, v):
        """inputs [patches, rows, columns, 16], v [patches, D]: log1p of radiance, [..., 3]."""
        spread = v[:, None, None, :].expand(*inputs.shape[:3], v.shape[1])
        q = torch.cat([inputs[..., 3:], spread], -1)
        h = functional.leaky_relu(self.position(inputs[..., 6:9]))
        for layer in self.hidden:
            h = functional.leaky_relu(layer(torch.cat([h, q], -1)))
        y = self.output(torch.cat([h, q], -1))
        emission = torch.log1p(inputs[..., :3])
        return torch.where(emission > 1, emission, y + emission)

    def flat(self, what=lambda p: p):
        """All weights (or what(weight)) in the order of the checkpoint."""
        return torch.cat([what(p).detach().reshape(-1) for p in self.parameters()])


def window(channels, dtype):
    x = torch.arange(-5, 6, dtype=torch.float64)
    taps = torch.exp(-x * x / (2 * 1.5**2))
    taps = taps / taps.sum()
    return torch.outer(taps, taps).to(dtype).expand(channels, 1, 11, 11).contiguous()


def ssim(f, t, legacy):
    """Per patch. f, t [patches, rows, columns, 3]; legacy: axes as they come, rows as channels."""
    if not legacy:
        f, t = f.permute(0, 3, 1, 2), t.permute(0, 3, 1, 2)
    channels = f.shape[1]
    w = window(channels, f.dtype)

    def blur(x):
        return functional.conv2d(x, w, padding=5, groups=channels)

    c1, c2 = 1e-4, 9e-4
    mu_f, mu_t = blur(f), blur(t)
    var_f, var_t = blur(f * f) - mu_f**2, blur(t * t) - mu_t**2
    covariance = blur(f * t) - mu_f * mu_t
    s = (2 * mu_f * mu_t + c1) * (2 * covariance + c2)
    s = s / ((mu_f**2 + mu_t**2 + c1) * (var_f + var_t + c2))
    return s.mean(dim=(1, 2, 3))


def losses(f, t, legacy):
    """Per patch: mean(2 |f - t|) + 1 - SSIM."""
    return 2 * (f - t).abs().mean(dim=(1, 2, 3)) + 1 - ssim(f, t, legacy)
