#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""check_caustic.py [--n 32] [--sheet OUT.png] [--json OUT] MODEL: is the caustic there?

Whether a network puts sphere-caustic's caustic in place, in shape and energy, at low roughness: --n
configurations, uniform but for sphere_mat.alpha in --alpha (0.01,0.1), each rendered by the model and
by `trace --integrator path+photons` with --spp samples. The caustic's region follows from references
alone: pixels that show nothing but diffuse surfaces, where the picture has D more luminance than the
same picture with a black sphere, D at least a quarter of its 20th largest, without the pieces that are
smaller than a quarter of the largest (stray pixels are noise). Energy is the sum of luminance there. Of each configuration:

    energy   the network's by the reference's
    caustic  the same with the black sphere's picture taken away from both: what the sphere brings
    around   that in the box around the region and --margin: near 1 where a caustic is only smeared
    noise    half the difference of the reference's two halves, by their mean
    shift    pixels between the centroids of what the sphere brings, in the region and --margin around

Exit status 1 when fewer than --share (0.9) of the energies are within 10 %. --paths I traces
configuration I's region again by paths alone and tells how far the photons are off. References are
kept in build/peers/caustic, so that the next model takes seconds.
"""
import argparse
import hashlib
import json
import os
import pathlib
import random
import shutil
import statistics
import sys
import tempfile
import xml.etree.ElementTree as ElementTree

import numpy as np
from PIL import Image, ImageDraw
from scipy import ndimage

import bench_denoiser
import cases
import sheets

FOLDER = cases.ROOT / "build/peers/caustic"
ALPHA, SPHERE, BLACK = "sphere_mat.alpha", "sphere_group", "Light"
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
RANK, PART = 20, 0.25
TOLERANCE = 0.1
REFERENCE_SEED, PATHS_SEED = 50001, 50002
ZOOM, MARGIN, CAPTION, ROWS = 2, 8, 20, 6


def with_black_sphere(scene, folder):
    """The path of a copy of the scene whose sphere has the lamp's black body."""
    try:
        tree = ElementTree.parse(scene)
    except (OSError, ElementTree.ParseError) as error:
        raise SystemExit(f"{scene}: {error}") from None
    group = tree.find(f".//shape[@id='{SPHERE}']/shape[@type='sphere']/ref")
    if group is None or tree.find(f".//bsdf[@id='{BLACK}']") is None:
        raise SystemExit(f"{scene}: is not sphere-caustic: no sphere in {SPHERE}, or no bsdf {BLACK}")
    group.set("id", BLACK)
    path = folder / "black.xml"
    tree.write(path)
    return path


def drawn(scene, n, alpha, seed):
    """n configurations, {name: value}."""
    variables = bench_denoiser.run("params", scene, "--json", "-q")["variables"]
    if ALPHA not in (v["name"] for v in variables):
        raise SystemExit(f"{scene}: has no variable {ALPHA}")
    r = random.Random(seed)
    ranges = {v["name"]: (v["min"], v["max"]) for v in variables}
    ranges[ALPHA] = alpha
    return [{name: r.uniform(*ends) for name, ends in ranges.items()} for _ in range(n)]


class Pictures:
    def __init__(self, args, folder):
        self.args, self.folder = args, folder
        self.black_scene = with_black_sphere(args.scene, folder)

    def made(self, command, file, values, *words):
        out = self.folder / "picture.exr"
        sets = [w for name, v in values.items() for w in ("-P", f"{name}={v!r}")]
        bench_denoiser.run(command, file, "-o", out, "--json", "-q", "-t", self.args.threads, "--size",
                           f"{self.args.size}x{self.args.size}", *sets, *words)
        return out

    def traced(self, scene, values, *words):
        """Channels of a picture by `trace`, from the folder when it is there."""
        key = repr((scene.read_bytes(), sorted(values.items()), self.args.size, words))
        path = FOLDER / f"{hashlib.sha256(key.encode()).hexdigest()[:16]}.exr"
        if not path.exists():
            FOLDER.mkdir(parents=True, exist_ok=True)
            temporary = path.with_suffix(f".part{os.getpid()}")
            shutil.move(self.made("trace", scene, values, *words), temporary) # maybe another disk
            os.replace(temporary, path)
        return bench_denoiser.channels(path)

    def reference(self, values):
        return self.traced(self.args.scene, values, "--integrator", "path+photons", "--spp", self.args.spp,
                           "--seed", REFERENCE_SEED, "--half-buffers", "--buffers")

    def black(self, values):
        """Without the sphere's light nothing is hard to find: a quarter of the samples."""
        return self.traced(self.black_scene, values, "--integrator", "path", "--spp",
                           max(1, self.args.spp // 4), "--seed", REFERENCE_SEED)

    def network(self, values):
        out = self.made("render", self.args.model, values, "--scene", self.args.scene)
        return bench_denoiser.stack(bench_denoiser.channels(out), "", "RGB")

    def paths(self, values, box, spp):
        return self.traced(self.args.scene, values, "--integrator", "path", "--spp", spp, "--seed",
                           PATHS_SEED, "--half-buffers", "--crop", ",".join(map(str, box)))


def luminance(channels, prefix=""):
    return bench_denoiser.stack(channels, prefix, "RGB").astype(np.float64) @ LUMINANCE


def region_of(reference, black):
    """(mask of the caustic's region, mask of diffuse pixels), [height, width]."""
    is_diffuse = (reference["roughness.Y"] > 0.999) & (reference["emission.R"] <= 0)
    brings = np.where(is_diffuse, luminance(reference) - luminance(black), 0)
    level = np.sort(brings, axis=None)[-RANK]
    pieces, n = ndimage.label(is_diffuse & (brings >= PART * level) & (brings > 0), np.ones((3, 3)))
    sizes = np.bincount(pieces.ravel(), minlength=n + 1)
    sizes[0] = 0
    return (sizes >= max(1, PART * sizes.max()))[pieces], is_diffuse


def box_of(mask, margin=0):
    """x, y, width, height around a mask."""
    y, x = np.nonzero(mask)
    x0, y0 = max(x.min() - margin, 0), max(y.min() - margin, 0)
    x1, y1 = min(x.max() + margin, mask.shape[1] - 1), min(y.max() + margin, mask.shape[0] - 1)
    return int(x0), int(y0), int(x1 - x0 + 1), int(y1 - y0 + 1)


def within(mask, box):
    x, y, width, height = box
    out = np.zeros_like(mask)
    out[y:y + height, x:x + width] = mask[y:y + height, x:x + width]
    return out


def centroid(weights):
    weights = np.maximum(weights, 0)
    y, x = np.indices(weights.shape)
    total = weights.sum()
    return np.array([(weights * x).sum(), (weights * y).sum()]) / total if total > 0 else np.full(2, np.nan)


def judged(reference, black, network, margin):
    """What one configuration shows; and the region."""
    region, is_diffuse = region_of(reference, black)
    if not region.any():
        raise SystemExit("a reference has no caustic at all; more --spp")
    whole, without, shown = luminance(reference), luminance(black), network.astype(np.float64) @ LUMINANCE
    a, b = (luminance(reference, half)[region].sum() for half in ("a.", "b."))
    near = within(is_diffuse, box_of(region, margin))
    around = (shown - without)[near].sum() / (whole - without)[near].sum()
    shift = centroid((shown - without) * near) - centroid((whole - without) * near)
    return {"pixels": int(region.sum()), "reference": float(whole[region].sum()),
            "energy": float(shown[region].sum() / whole[region].sum()),
            "caustic": float((shown - without)[region].sum() / (whole - without)[region].sum()),
            "around": float(around), "noise": float(abs(a - b) / (a + b)),
            "shift": float(np.hypot(*shift))}, region


def summary(results):
    def of(name, center=1.0):
        values = [r[name] for r in results]
        off = [abs(v - center) for v in values]
        found = {"median": statistics.median(values), "median_off": statistics.median(off),
                 "worst": values[off.index(max(off))]}
        if center == 1.0:
            found["share_within_10_percent"] = sum(o <= TOLERANCE for o in off) / len(off)
        return found
    total = sum(r["energy"] * r["reference"] for r in results) / sum(r["reference"] for r in results)
    return {"n": len(results), "energy": of("energy"), "caustic": of("caustic"),
            "around": of("around"), "shift": of("shift", 0.0),
            "energy_of_all": total, "noise_worst": max(r["noise"] for r in results)}


def flip_map(folder, network, reference):
    for name, image in (("a", network), ("b", reference)):
        bench_denoiser.write_pfm(folder / f"{name}.pfm", image)
    found = bench_denoiser.run("compare", folder / "a.pfm", folder / "b.pfm", "--json", "--map",
                               folder / "map.png")
    return found["metrics"]["flip"], Image.open(folder / "map.png").convert("RGB")


def draw_sheet(path, folder, shown, size, exposure):
    """Rows of (number, values, result, region, reference, network)."""
    side = size * ZOOM
    sheet = Image.new("RGB", (3 * (side + MARGIN) + MARGIN, len(shown) * (side + CAPTION) + MARGIN + CAPTION),
                      "white")
    draw = ImageDraw.Draw(sheet)
    for column, title in enumerate(("reference, box around the caustic", "network", "FLIP")):
        draw.text((MARGIN + column * (side + MARGIN), MARGIN // 2), title, fill="black")
    for row, (number, values, result, region, reference, network) in enumerate(shown):
        y = CAPTION + row * (side + CAPTION)
        flip, false_colours = flip_map(folder, network, reference)
        pictures = (sheets.srgb(reference, exposure), sheets.srgb(network, exposure), false_colours)
        for column, picture in enumerate(pictures):
            sheet.paste(picture.resize((side, side), Image.NEAREST), (MARGIN + column * (side + MARGIN), y))
        x0, y0, width, height = (ZOOM * v for v in box_of(region, 1))
        draw.rectangle((MARGIN + x0, y + y0, MARGIN + x0 + width, y + y0 + height), outline="red")
        draw.text((MARGIN, y + side + 4), f"{number}: alpha {values[ALPHA]:.3f}, energy "
                  f"{result['energy']:.3f}, caustic {result['caustic']:.3f}, shift {result['shift']:.2f} "
                  f"pixels, FLIP {flip:.3f}", fill="black")
    path.parent.mkdir(parents=True, exist_ok=True)
    sheet.save(path, optimize=True)


def check_paths(pictures, values, spp):
    """How far path+photons is from paths alone in the region."""
    reference = pictures.reference(values)
    region, _ = region_of(reference, pictures.black(values))
    x, y, width, height = box = box_of(region)
    inside = region[y:y + height, x:x + width]
    paths = pictures.paths(values, box, spp)
    energy, a, b = (luminance(paths, prefix)[inside].sum() for prefix in ("", "a.", "b."))
    return {"spp": spp, "photons_by_paths": float(luminance(reference)[region].sum() / energy),
            "noise_of_paths": float(abs(a - b) / (a + b)), "pixels": int(region.sum())}


def pair(text):
    ends = tuple(float(x) for x in text.split(","))
    if len(ends) != 2 or not ends[0] < ends[1]:
        raise argparse.ArgumentTypeError(f"{text}: two numbers, the smaller first")
    return ends


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("model", type=pathlib.Path)
    parser.add_argument("--scene", type=pathlib.Path, default=cases.CAUSTIC)
    parser.add_argument("--n", type=int, default=32, help="configurations")
    parser.add_argument("--alpha", type=pair, default=(0.01, 0.1), help="range of the roughness")
    parser.add_argument("--seed", type=int, default=1, help="of the configurations")
    parser.add_argument("--size", type=int, default=128)
    parser.add_argument("--spp", type=int, default=1024, help="samples of references")
    parser.add_argument("--margin", type=int, default=6, help="pixels around the region for the shift")
    parser.add_argument("--share", type=float, default=0.9, help="of energies that must be within 10 %%")
    parser.add_argument("--paths", type=int, metavar="I", help="check configuration I by paths alone")
    parser.add_argument("--paths-spp", type=int, default=32768)
    parser.add_argument("--sheet", type=pathlib.Path, help="a picture of six, from best to worst energy")
    parser.add_argument("--exposure", type=float, default=0.5, help="of the sheet")
    parser.add_argument("--json", type=pathlib.Path, help="write all figures there")
    parser.add_argument("-t", "--threads", type=int, default=1)
    args = parser.parse_args()
    if args.n < 1 or args.spp < 2 or args.size < 16:
        parser.error("--n is 1 or more, --spp 2, --size 16")
    if args.paths is not None and not 0 <= args.paths < args.n:
        parser.error(f"--paths: a configuration from 0 to {args.n - 1}")
    for file in (args.model, args.scene, bench_denoiser.LUMENAUT):
        if not file.exists():
            parser.error(f"{file}: not there")
    return args


def main():
    args = arguments()
    results, regions = [], []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        pictures = Pictures(args, folder)
        configurations = drawn(args.scene, args.n, args.alpha, args.seed)
        print(f"{'':>3}{'alpha':>8}{'pixels':>8}{'energy':>9}{'caustic':>9}{'around':>8}{'noise':>8}{'shift':>8}")
        for i, values in enumerate(configurations):
            reference = pictures.reference(values)
            network = pictures.network(values)
            result, region = judged(reference, pictures.black(values), network, args.margin)
            results.append({"values": values, **result})
            regions.append((region, bench_denoiser.stack(reference, "", "RGB"), network))
            print(f"{i:>3}{values[ALPHA]:>8.3f}{result['pixels']:>8}{result['energy']:>9.3f}"
                  f"{result['caustic']:>9.3f}{result['around']:>8.3f}{result['noise']:>8.4f}"
                  f"{result['shift']:>8.2f}", flush=True)
        found = summary(results)
        e, s = found["energy"], found["shift"]
        for title in ("energy", "caustic", "around"):
            x = found[title]
            print(f"{title}: median {x['median']:.3f}, median error {x['median_off']:.1%}, worst "
                  f"{x['worst']:.3f}, within 10 %: {x['share_within_10_percent']:.0%}")
        print(f"energy of all together {found['energy_of_all']:.3f}; shift: median {s['median']:.2f}, worst "
              f"{s['worst']:.2f} pixels; noise of references at worst {found['noise_worst']:.2%}")
        if args.paths is not None:
            found["paths"] = check_paths(pictures, configurations[args.paths], args.paths_spp)
            print("path+photons by paths alone, configuration {0}: {photons_by_paths:.4f} (noise of paths "
                  "{noise_of_paths:.4f})".format(args.paths, **found["paths"]))
        if args.sheet:
            order = sorted(range(args.n), key=lambda i: abs(results[i]["energy"] - 1))
            rows = sorted({round(k * (args.n - 1) / (ROWS - 1)) for k in range(ROWS)})
            draw_sheet(args.sheet, folder, [(order[k], configurations[order[k]], results[order[k]],
                                             *regions[order[k]]) for k in rows], args.size, args.exposure)
    if args.json:
        args.json.write_text(json.dumps({"model": str(args.model), "scene": str(args.scene), "alpha": args.alpha,
                                         "size": args.size, "spp": args.spp, "seed": args.seed, **found,
                                         "results": results}, indent=1) + "\n", encoding="utf-8")
    return 0 if e["share_within_10_percent"] >= args.share else 1


if __name__ == "__main__":
    sys.exit(main())
