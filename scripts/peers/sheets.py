#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""sheets.py [--spp 512] [--scenes A,B]: docs/results/scenes.png and scenes.md.

The seven scenes by `lumenaut trace` (integrator path), beside Mitsuba 3 with the same samples and
depth, and beside the pictures by Tungsten that come with some of them, at these pictures' proportions;
relMSE and FLIP by `lumenaut compare`. Pictures are kept in build/peers/sheets and made again when
they are not there.
"""
import argparse
import dataclasses
import json
import pathlib
import subprocess
import sys

import numpy as np
from PIL import Image, ImageDraw

import bench_scenes
import cases
import classroom
import render_mitsuba

FOLDER = cases.ROOT / "build/peers/sheets"
SQUARE, WIDE = (192, 192), (256, 144)
MARGIN, CAPTION, COLUMN = 8, 30, 256


@dataclasses.dataclass(frozen=True)
class Row:
    title: str
    scene: bench_scenes.Scene
    size: tuple
    spp_factor: float = 1.0
    exposure: float = 1.0
    reference: pathlib.Path = None
    note: str = ""


def rows():
    scenes = {s.name: s for s in bench_scenes.SCENES}
    tungsten = {n: scenes[n].path.parent / "TungstenRender.exr"
                for n in ("cornell-box", "staircase2", "veach-mis")}
    deep = dataclasses.replace
    mis, room = scenes["veach-mis"], scenes["classroom"]
    return [
        Row("sphere-caustic", scenes["sphere-caustic"], SQUARE, 2),
        Row("veach-ajar", scenes["veach-ajar"], SQUARE, 2),
        Row("spaceship", scenes["spaceship"], SQUARE, 1, 3),
        Row("cornell-box", deep(scenes["cornell-box"], max_depth=65), SQUARE, 1, 1.5,
            tungsten["cornell-box"]),
        Row("staircase2", deep(scenes["staircase2"], max_depth=65), SQUARE, 1, 1,
            tungsten["staircase2"], "the file's 1280x720 is the middle of Tungsten's square"),
        Row("veach-mis", deep(mis, max_depth=5), WIDE, 1, 1, tungsten["veach-mis"],
            "the file's depth is 5; Tungsten shows direct light only: nothing of the wall in the lower "
            "plates"),
        Row("veach-mis, direct light", deep(mis, max_depth=2), WIDE, 1, 1, tungsten["veach-mis"],
            "depth 2, as Tungsten's picture"),
        Row("classroom", room, WIDE, 1, .8, None,
            "the skies are different models (docs/scene-format.md)"),
        Row("classroom, our sky for both",
            deep(room, path=cases.ROOT / "build/peers/classroom-envmap.xml"), WIDE, 1, .8, None,
            "our sky and sun baked into an envmap"),
    ]


def load(mi, path):
    bitmap = mi.Bitmap(str(path))
    return np.array(bitmap.convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False))


def shrink(image, size):
    """Means over the pixels of a smaller picture, whose edges may cut pixels."""
    for axis, n in ((1, size[0]), (0, size[1])):
        rows = np.moveaxis(image.astype(np.float64), axis, 0)
        sums = np.concatenate([np.zeros_like(rows[:1]), np.cumsum(rows, axis=0)])
        edges = np.linspace(0, len(rows), n + 1)
        low = edges.astype(int).clip(0, len(rows) - 1)
        part = (edges - low)[:, None, None]
        at = sums[low] * (1 - part) + sums[low + 1] * part
        image = np.moveaxis(np.diff(at, axis=0) * n / len(rows), 0, axis)
    return image.astype(np.float32)


def ours(row, spp, path):
    u = bench_scenes.shares(row.scene)
    command = [bench_scenes.LUMENAUT, "trace", row.scene.path, "-o", path, "-q", "--json", "--size",
               f"{row.size[0]}x{row.size[1]}", "--spp", str(spp), "--max-depth",
               str(row.scene.max_depth), "--rr-depth", "5", "--integrator", "path"]
    for name, share in u.items():
        command += ["-P", f"{name}={100 * share:.9g}%"]
    return json.loads(subprocess.run(command, check=True, capture_output=True).stdout)["render_s"]


def theirs(mi, row, spp, path):
    u = bench_scenes.shares(row.scene)
    settings = {"max_depth": row.scene.max_depth, "rr_depth": 5, "hide_emitters": False}
    text = render_mitsuba.freeze_with_bounds(mi, str(row.scene.path), list(u.values()))
    scene, integrator = render_mitsuba.load(mi, text, row.size, settings)
    image = render_mitsuba.render(mi, scene, integrator, spp, 1)
    mi.Bitmap(image.astype(np.float32)).write(str(path))


def compare(image, reference):
    command = [bench_scenes.LUMENAUT, "compare", image, reference, "--json", "-q"]
    done = subprocess.run(command, check=True, capture_output=True)
    return json.loads(done.stdout)["metrics"]


def srgb(image, exposure):
    x = np.clip(image * exposure, 0, 1)
    x = np.where(x <= 0.0031308, 12.92 * x, 1.055 * x**(1 / 2.4) - 0.055)
    return Image.fromarray((255 * x + 0.5).astype(np.uint8))


def make(mi, row, spp):
    """{who: path} of the pictures, all of one size."""
    stem = FOLDER / f"{row.title.replace(', ', '-').replace(' ', '-')}-{spp}"
    pictures = {"lumenaut": pathlib.Path(f"{stem}-ours.exr"),
                "Mitsuba 3": pathlib.Path(f"{stem}-mitsuba.exr")}
    if not pictures["lumenaut"].exists():
        ours(row, spp, pictures["lumenaut"])
    if not pictures["Mitsuba 3"].exists():
        theirs(mi, row, spp, pictures["Mitsuba 3"])
    if row.reference and row.reference.exists():
        pictures["Tungsten"] = pathlib.Path(f"{stem}-tungsten.exr")
        small = shrink(load(mi, row.reference), row.size)
        mi.Bitmap(small).write(str(pictures["Tungsten"]))
    return pictures


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--spp", type=int, default=512)
    parser.add_argument("--scenes", help="some of them, with commas between")
    parser.add_argument("--output", type=pathlib.Path, default=cases.ROOT / "docs/results")
    args = parser.parse_args()
    mi = render_mitsuba.use("llvm_ad_rgb")
    classroom.make(mi)
    FOLDER.mkdir(parents=True, exist_ok=True)
    chosen = {s.name for s in bench_scenes.chosen(args.scenes)}
    shown = [r for r in rows() if r.scene.name in chosen]
    height = MARGIN + sum(r.size[1] + CAPTION for r in shown)
    sheet = Image.new("RGB", (3 * (COLUMN + MARGIN) + MARGIN, height), "white")
    draw, y = ImageDraw.Draw(sheet), MARGIN
    table = ["| scene | depth | spp | beside | relMSE | FLIP | mean differs | |",
             "| --- | ---: | ---: | --- | ---: | ---: | ---: | --- |"]
    for row in shown:
        spp = int(args.spp * row.spp_factor)
        pictures = make(mi, row, spp)
        for column, (who, path) in enumerate(pictures.items()):
            x = MARGIN + column * (COLUMN + MARGIN)
            image = load(mi, path)
            sheet.paste(srgb(image, row.exposure), (x, y))
            draw.text((x, y + row.size[1] + 4), f"{row.title}: {who}", fill="black")
            if who == "lumenaut":
                mine = image
                continue
            m = compare(pictures["lumenaut"], path)
            differs = mine.mean() / image.mean() - 1
            note = row.note if who == "Tungsten" or not row.reference else ""
            table.append(f"| {row.title} | {row.scene.max_depth} | {spp} | {who} | {m['relmse']:.4f} | "
                         f"{m['flip']:.3f} | {differs:+.2%} | {note} |")
            print(table[-1], flush=True)
        y += row.size[1] + CAPTION
    args.output.mkdir(parents=True, exist_ok=True)
    sheet.save(args.output / "scenes.png", optimize=True)
    page = ["# The shared scenes", "",
            "Written by `.venv/bin/python scripts/peers/sheets.py`: [scenes.png](scenes.png) shows "
            "`lumenaut trace --integrator path`, Mitsuba 3 (llvm_ad_rgb) with the same samples and depth, "
            "and, where one comes with the scene, the picture by Tungsten, made smaller. relMSE and FLIP "
            "are those of `lumenaut compare` and hold the noise of both pictures, fireflies too; "
            "[peers.md](peers.md) has the tests that tell noise from error.", "", *table, "",
            "veach-mis has nothing below the front edge of its floor: a square picture, whose height "
            "is more than the file's 16:9 shows, is black there.", ""]
    (args.output / "scenes.md").write_text("\n".join(page), encoding="utf-8")
    print(f"{args.output / 'scenes.png'}: {(args.output / 'scenes.png').stat().st_size / 1e6:.2f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
