#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tiny OpenEXR files of every kind that image_load() reads, written by the OpenEXR project's own
package (PyPI: OpenEXR). tests/image/test_exr.c reads them.

    exr_files.py [FOLDER]    (default: tests/image/data)

Pixel (x, y) holds R = (x + 32 y) / 64, G = y / 16, B = -x / 16 as half floats, depth.Z = 0.25 x + 3.5 y
- 7 as float, id.Y = x + 100 y as unsigned integer. All but id.Y are exact in 24 bits.
"""
import pathlib
import sys

import numpy as np
import OpenEXR as exr

WIDTH, HEIGHT = 13, 37


def channels(width=WIDTH, height=HEIGHT):
    y, x = np.mgrid[0:height, 0:width]
    return {
        "R": ((x + 32 * y) / 64).astype(np.float16),
        "G": (y / 16).astype(np.float16),
        "B": (-x / 16).astype(np.float16),
        "depth.Z": (0.25 * x + 3.5 * y - 7).astype(np.float32),
        "id.Y": (x + 100 * y).astype(np.uint32),
    }


def main():
    root = pathlib.Path(__file__).resolve().parents[2]
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else root / "tests/image/data"
    folder.mkdir(parents=True, exist_ok=True)
    kinds = {
        "none": exr.NO_COMPRESSION, "rle": exr.RLE_COMPRESSION, "zips": exr.ZIPS_COMPRESSION,
        "zip": exr.ZIP_COMPRESSION, "piz": exr.PIZ_COMPRESSION, "pxr24": exr.PXR24_COMPRESSION,
        "b44": exr.B44_COMPRESSION, "b44a": exr.B44A_COMPRESSION, "dwaa": exr.DWAA_COMPRESSION,
    }
    scan, tiled = {"type": exr.scanlineimage}, {"type": exr.tiledimage}
    for name, kind in kinds.items():
        header = {**scan, "compression": kind, "comments": "tiny"}
        exr.File(header, channels()).write(str(folder / f"{name}.exr"))
    tiles = exr.TileDescription()
    tiles.xSize, tiles.ySize = 16, 8
    for name in ("none", "zip"):
        header = {**tiled, "compression": kinds[name], "tiles": tiles}
        exr.File(header, channels()).write(str(folder / f"tiled_{name}.exr"))
    header = {**scan, "compression": exr.ZIP_COMPRESSION, "lineOrder": exr.DECREASING_Y}
    exr.File(header, channels()).write(str(folder / "decreasing.exr"))
    window = (np.array([-5, 100], np.int32), np.array([WIDTH - 6, HEIGHT + 99], np.int32))
    header = {**scan, "compression": exr.ZIP_COMPRESSION, "dataWindow": window,
              "displayWindow": (np.array([0, 0], np.int32), np.array([639, 479], np.int32))}
    exr.File(header, channels()).write(str(folder / "window.exr"))
    parts = [exr.Part({**scan, "compression": exr.ZIP_COMPRESSION}, channels(), "first"),
             exr.Part({**scan, "compression": exr.ZIP_COMPRESSION},
                      {"Y": np.zeros((HEIGHT, WIDTH), np.float16)}, "second")]
    exr.File(parts).write(str(folder / "parts.exr"))
    samples = np.empty((2, 2), object)
    for i in range(4):
        samples[i // 2, i % 2] = np.ones(i + 1, np.float32)
    header = {"type": exr.deepscanline, "compression": exr.ZIPS_COMPRESSION}
    exr.File(header, {"Z": samples}).write(str(folder / "deep.exr"))


main()
