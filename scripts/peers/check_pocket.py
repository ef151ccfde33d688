#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""check_pocket.py [--draws 100000] [--n 16] [--json OUT] [--sheet OUT.png] [MODEL...]: scenes/pocket.

How large the pocket of scenes/pocket is and how much it changes the picture, then how well models show
it. Uniform draws: where shutter, blind or block are clearly shut (beyond SHUT, where pictures must hold
no light of the sun; 100 of those in which only one of the three is beyond are traced to see that) there
is no event; all others are traced, 48x36, with --light-groups. A draw is in the pocket when the sun adds
a quarter and more to the picture's mean luminance. Of --n draws in the pocket, traced at --spp: MAPE, FLIP
and relMSE of the same room without the sun, that is what a network loses that never saw a beam, and
of each model, with

    beam   what the network adds to the room without the sun by what the sun adds, as luminance over
           the pixels that it makes twice as bright: 1 is right, 0 is no beam

What was found and references are kept in build/peers/pocket.
"""
import argparse
import hashlib
import json
import pathlib
import random
import statistics
import sys
import tempfile

import numpy as np
from PIL import Image

import bench_denoiser
import cases
import check_caustic
import sheets

SCENE = cases.ROOT / "scenes/pocket/scene.xml"
FOLDER = cases.ROOT / "build/peers/pocket"
SHUT = {"shutter": 0.75, "blind": 0.88, "block": 35.0} # the beam ends at .7, .8 and some 20 degrees
EVENT, STRONG = 0.25, 0.5
METRICS = ("mape", "flip", "relmse")
SEED = 60001


def traced(values, size, spp, folder):
    """Channels of `trace --light-groups`."""
    sets = [w for name, v in values.items() for w in ("-P", f"{name}={v!r}")]
    out = folder / "picture.exr"
    bench_denoiser.run("trace", SCENE, "-o", out, "--json", "-q", "-t", 1, "--size", size, "--spp", spp,
                       "--seed", SEED, "--integrator", "path", "--light-groups", *sets)
    return bench_denoiser.channels(out)


def sun_share(values, folder):
    """What the sun adds to the mean luminance of the room without it."""
    channels = traced(values, "48x36", 16, folder)
    sun, lamp = (check_caustic.luminance(channels, f"{name}.").mean() for name in ("sun_light", "lamp_light"))
    return float(sun / lamp)


def kept_at(suffix, *what):
    """Where something about the scene as it is is kept."""
    key = repr((SCENE.read_bytes(), SCENE.with_name("scene.variables.json").read_bytes(), *what))
    FOLDER.mkdir(parents=True, exist_ok=True)
    return FOLDER / f"{hashlib.sha256(key.encode()).hexdigest()[:16]}{suffix}"


def reference(values, args, folder):
    path = kept_at(".npz", sorted(values.items()), args.size, args.spp)
    if not path.exists():
        channels = traced(values, args.size, args.spp, folder)
        np.savez_compressed(path, **{name: bench_denoiser.stack(channels, f"{name}.", "RGB")
                                     for name in ("sun_light", "lamp_light")})
    kept = np.load(path)
    return kept["sun_light"], kept["lamp_light"]


def closed(values):
    return [name for name, limit in SHUT.items() if abs(values[name]) > limit]


def find(args, folder):
    """(report, [(draw, configuration, share)] of all draws in the pocket)"""
    kept = kept_at(".json", args.draws, args.seed, SHUT, EVENT, STRONG)
    if kept.exists():
        return json.loads(kept.read_text(encoding="utf-8"))
    variables = bench_denoiser.run("params", SCENE, "--json", "-q")["variables"]
    ranges = {v["name"]: (v["min"], v["max"]) for v in variables}
    r = random.Random(args.seed)
    shares, pocket, leaks, tried = [], [], 0, 0
    for i in range(args.draws):
        values = {name: r.uniform(*ends) for name, ends in ranges.items()}
        shut = closed(values)
        if not shut:
            shares.append(sun_share(values, folder))
            if shares[-1] >= EVENT:
                pocket.append((i, values, shares[-1]))
        elif len(shut) == 1 and tried < 100:
            tried += 1
            leaks += bool(sun_share(values, folder) > 0)
    share = np.array(shares)
    full = float(share.max()) if shares else 0.0
    def part(mask):
        n = int(np.count_nonzero(mask))
        return {"draws": n, "volume": n / args.draws, "error": n**0.5 / args.draws}
    found = {"variables": len(variables), "draws": args.draws, "traced": len(shares), "shut_traced": tried,
            "shut_with_light": leaks, "any": part(share > 0), "pocket": part(share >= EVENT),
            "strong": part(share >= STRONG), "largest_share": full}
    kept.write_text(json.dumps([found, pocket]), encoding="utf-8")
    return found, pocket


def errors(image, whole, folder):
    for name, picture in (("a", image), ("b", whole)):
        bench_denoiser.write_pfm(folder / f"{name}.pfm", picture)
    found = bench_denoiser.run("compare", folder / "a.pfm", folder / "b.pfm", "--json", "-q")["metrics"]
    return {m: found[m] for m in METRICS}


def shown(model, values, args, folder):
    sets = [w for name, v in values.items() for w in ("-P", f"{name}={v!r}")]
    bench_denoiser.run("render", model, "-o", folder / "picture.exr", "--json", "-q", "-t", 1, "--size", args.size,
                       "--scene", SCENE, *sets)
    return bench_denoiser.stack(bench_denoiser.channels(folder / "picture.exr"), "", "RGB")


def judge(args, pocket, folder):
    """{who: mean errors} and rows of pictures: reference, without the sun, models."""
    rows, found = [], {}
    for _, values, _ in pocket[:args.n]:
        sun, lamp = reference(values, args, folder)
        whole = sun + lamp
        y_sun, y_lamp = (x.astype(np.float64) @ check_caustic.LUMINANCE for x in (sun, lamp))
        lit = y_sun >= np.maximum(y_lamp, 1e-6)
        pictures = {"no sun": lamp, **{str(m): shown(m, values, args, folder) for m in args.models}}
        for who, image in pictures.items():
            added = image.astype(np.float64) @ check_caustic.LUMINANCE - y_lamp
            beam = added[lit].sum() / y_sun[lit].sum() if lit.any() else float("nan")
            found.setdefault(who, []).append({**errors(image, whole, folder), "beam": float(beam)})
        rows.append([whole, *pictures.values()])
    means = {who: {m: statistics.fmean(e[m] for e in each) for m in (*METRICS, "beam")}
             for who, each in found.items()}
    return means, found, rows


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("models", nargs="*", type=pathlib.Path, metavar="MODEL")
    parser.add_argument("--draws", type=int, default=100000)
    parser.add_argument("--n", type=int, default=16, help="configurations in the pocket to judge")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--size", default="256x192")
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--sheet", type=pathlib.Path, help="six of them: reference, no sun, models")
    parser.add_argument("--json", type=pathlib.Path)
    args = parser.parse_args()
    if args.draws < 1 or args.n < 1 or args.spp < 1:
        parser.error("--draws, --n and --spp are 1 or more")
    for file in (*args.models, SCENE, bench_denoiser.LUMENAUT):
        if not file.exists():
            parser.error(f"{file}: not there")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        found, pocket = find(args, folder)
        print(f"{found['variables']} variables, {found['draws']} draws, {found['traced']} not shut; of "
              f"{found['shut_traced']} with one of three shut {found['shut_with_light']} have light of the sun")
        for title, x in (("any light of the sun", found["any"]), ("the pocket: a quarter", found["pocket"]),
                         ("with half and more", found["strong"])):
            print(f"{title:<22}{x['draws']:>6} draws: volume {x['volume']:.2e} +- {x['error']:.1e}")
        print(f"the sun adds at most {found['largest_share']:.0%} to a picture's mean", flush=True)
        if not pocket:
            raise SystemExit("no draw is in the pocket; more --draws")
        means, each, rows = judge(args, pocket, folder)
        print(f"{min(args.n, len(pocket))} configurations of the pocket:")
        print(f"{'':<32}{'MAPE':>8}{'FLIP':>8}{'relMSE':>9}{'beam':>8}")
        for who, m in means.items():
            print(f"{who:<32}{m['mape']:>8.4f}{m['flip']:>8.4f}{m['relmse']:>9.4f}{m['beam']:>8.3f}")
        if args.sheet:
            args.sheet.parent.mkdir(parents=True, exist_ok=True)
            lines = [np.hstack([np.array(sheets.srgb(p, 1.0)) for p in row]) for row in rows[:6]]
            Image.fromarray(np.vstack(lines)).save(args.sheet, optimize=True)
    if args.json:
        args.json.write_text(json.dumps({**found, "means": means, "each": each,
                                         "configurations": [{"draw": i, "share": s, "values": v}
                                                            for i, v, s in pocket]}, indent=1) + "\n",
                             encoding="utf-8")
    return 1 if found["shut_with_light"] else 0


if __name__ == "__main__":
    sys.exit(main())
