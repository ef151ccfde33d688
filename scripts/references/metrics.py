#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Small image pairs, and what scikit-image and flip-evaluator say of them.

    metrics.py [FOLDER]      (default: tests/image/data)

Writes metrics.json and NAME.reference.pfm, NAME.test.pfm per case. tests/image/test_metrics.c compares
with them; LMN_REFERENCES=PARENT makes it read PARENT/image instead.
"""
import json
import pathlib
import sys

import numpy as np
from flip_evaluator import evaluate
from scipy.ndimage import correlate1d
from skimage.metrics import peak_signal_noise_ratio, structural_similarity


def write_pfm(path, image):
    height, width, _ = image.shape
    with open(path, "wb") as f:
        f.write(b"PF\n%d %d\n-1.0\n" % (width, height))
        f.write(image[::-1].astype("<f4").tobytes())


def srgb(linear):
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def gaussian_blur(image, axes):
    x = np.arange(-5, 6)
    taps = np.exp(-x * x / (2 * 1.5**2))
    taps /= taps.sum()
    for axis in axes:
        image = correlate1d(image, taps, axis=axis, mode="constant", cval=0)
    return image


def ssim_padded(a, b, axes):
    """Mean SSIM with zeros outside, the window sliding along `axes` (as pytorch_ssim)."""
    c1, c2 = 0.01**2, 0.03**2
    mu_a, mu_b = gaussian_blur(a, axes), gaussian_blur(b, axes)
    var_a = gaussian_blur(a * a, axes) - mu_a**2
    var_b = gaussian_blur(b * b, axes) - mu_b**2
    cov = gaussian_blur(a * b, axes) - mu_a * mu_b
    luminance = (2 * mu_a * mu_b + c1) / (mu_a**2 + mu_b**2 + c1)
    return (luminance * (2 * cov + c2) / (var_a + var_b + c2)).mean()


def ssim_skimage(a, b):
    """scikit-image's mean, which leaves out a border of 5 pixels."""
    return structural_similarity(a, b, gaussian_weights=True, sigma=1.5,
                                 use_sample_covariance=False, data_range=1, channel_axis=2)


def expected(reference, test):
    g, p = reference.astype(np.float64), test.astype(np.float64)
    d = p - g
    per_pixel = np.sort((d**2 / (g**2 + 0.01)).mean(axis=2).ravel())
    kept = len(per_pixel) - len(per_pixel) // 1000
    k = 1 / np.percentile(g, 99)
    tone_g, tone_p = (srgb(np.clip(k * v, 0, 1)) for v in (g, p))
    log_g, log_p = np.log1p(g), np.log1p(p)
    _, flip, _ = evaluate(tone_g.astype(np.float32), tone_p.astype(np.float32), "LDR")
    _, flip_hdr, _ = evaluate(reference, test, "HDR")
    return {
        "exposure": k,
        "mae": np.abs(d).mean(),
        "mape": (np.abs(d) / (g + 0.01)).mean(),
        "mse": (d**2).mean(),
        "relmse": per_pixel[:kept].mean(),
        "psnr": peak_signal_noise_ratio(tone_g, tone_p, data_range=1),
        "dssim": 1 - ssim_padded(tone_p, tone_g, (0, 1)),
        "dssim_log": 1 - ssim_padded(log_p, log_g, (0, 1)),
        "dssim_legacy": 1 - ssim_padded(log_p, log_g, (1, 2)),
        "ssim_interior": ssim_skimage(tone_g, tone_p),
        "ssim_log_interior": ssim_skimage(log_g, log_p),
        "flip": flip,
        "flip_hdr": flip_hdr,
    }


def room(rng):
    """A smooth picture with edges, a highlight and fine texture; the test is noisy and half as sharp."""
    h, w = 48, 64
    y, x = np.mgrid[0:h, 0:w].astype(np.float64)
    base = 0.2 + 0.6 * x[..., None] / w * np.array([1.0, 0.7, 0.4])
    base = base + 0.3 * (y[..., None] / h) ** 2 * np.array([0.1, 0.4, 1.0])
    base[(x // 8 + y // 8) % 2 == 0] *= 0.35
    base += 12 * np.exp(-((x - 44) ** 2 + (y - 14) ** 2) / 9)[..., None] * np.array([1, 0.9, 0.6])
    base[30:40, 6:20] = (0.02, 0.35, 0.05)
    test = 0.5 * base + 0.25 * (np.roll(base, 1, 1) + np.roll(base, 1, 0))
    test = test * np.exp(0.15 * rng.standard_normal(base.shape))
    return base, test


def caustic(rng):
    """Mostly black, so that the median luminance is 0; the test is brighter and misses a spot."""
    h, w = 31, 37
    y, x = np.mgrid[0:h, 0:w].astype(np.float64)
    base = np.zeros((h, w, 3))
    base[18:, :] = (0.01, 0.02, 0.03)
    base += 40 * np.exp(-((x - 9) ** 2 + (y - 8) ** 2) / 2)[..., None] * (np.hypot(x - 9, y - 8) < 4)[..., None]
    test = 1.3 * base
    base[20:23, 28:31] = (3, 0.5, 0.1)
    test += 0.002 * rng.random(base.shape)
    return base, test


def main():
    root = pathlib.Path(__file__).resolve().parents[2]
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else root / "tests/image/data"
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(7)
    result = {}
    for make in (room, caustic):
        reference, test = (image.astype(np.float32) for image in make(rng))
        write_pfm(folder / f"{make.__name__}.reference.pfm", reference)
        write_pfm(folder / f"{make.__name__}.test.pfm", test)
        result[make.__name__] = {k: float(v) for k, v in expected(reference, test).items()}
    (folder / "metrics.json").write_text(json.dumps(result, indent=1) + "\n")


main()
