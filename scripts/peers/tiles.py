# SPDX-License-Identifier: Apache-2.0
"""Means of image tiles and the test that two renderers agree on them.

Each renderer makes n images from independent seeds. A tile's mean in one channel is then n
independent, equally distributed numbers per renderer, whose spread is the noise: no assumption on
the noise of pixels is needed. Welch's t-test compares the two sets; the whole image counts as one
more tile, as a small bias everywhere shows best there. The level is corrected for the number of
tests (Bonferroni), so that a run over all tiles of all images fails by chance once in 1/ALPHA.
"""
import dataclasses

import numpy as np
from scipy import stats

TILE = 16
ALPHA = 0.01 # of a whole run


def tile_means(image):
    """[rows * columns + 1, 3]: means of TILE x TILE tiles row by row, then of the whole image."""
    height, width, channels = image.shape
    rows, columns = height // TILE, width // TILE
    tiles = image[:rows * TILE, :columns * TILE].reshape(rows, TILE, columns, TILE, channels)
    return np.concatenate([tiles.mean(axis=(1, 3)).reshape(-1, channels),
                           image.mean(axis=(0, 1))[None]])


@dataclasses.dataclass
class Verdict:
    p: np.ndarray        # [tiles, 3]: how likely so large a difference is by chance
    z: np.ndarray        # [tiles, 3]: difference over its standard error
    relative: np.ndarray # [tiles, 3]: difference over the reference's mean
    error: np.ndarray    # [tiles, 3]: standard error of the difference over the reference's mean

    def worst(self):
        return np.unravel_index(np.argmin(self.p), self.p.shape)


def compare(ours, theirs):
    """ours, theirs: [seeds, tiles, 3]."""
    n, m = len(ours), len(theirs)
    var_n, var_m = ours.var(axis=0, ddof=1) / n, theirs.var(axis=0, ddof=1) / m
    variance = var_n + var_m
    difference = ours.mean(axis=0) - theirs.mean(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        z = np.where(variance > 0, difference / np.sqrt(variance),
                     np.where(difference == 0, 0, np.inf))
        degrees = variance**2 / (var_n**2 / (n - 1) + var_m**2 / (m - 1))
        degrees = np.where(variance > 0, degrees, n + m - 2)
        level = np.maximum(np.abs(theirs.mean(axis=0)), 1e-12)
    return Verdict(2 * stats.t.sf(np.abs(z), degrees), z, difference / level,
                   np.sqrt(variance) / level)


def tile_name(index, width):
    columns = width // TILE
    if index == columns * columns:
        return "whole image"
    return f"tile {index % columns},{index // columns}"
