#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""trace.py [FOLDER [CASE...]]    (default: tests/render/data, all cases)

What Mitsuba 3 makes of small pictures: NAME.json per case with the mean of every 16 x 16 tile (and of
the whole picture, last) and its standard error from independent seeds. Our own scenes/tests/*.xml
as they are, outside scenes at the configurations of cases.py. tests/house/test_references.c renders the
same and compares.
"""
import dataclasses
import json
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "peers"))
import cases
import render_mitsuba
import tiles

SIZE, SPP, SEEDS = 64, 256, 16
OWN_SPP = 128  # many scenes, and the test's own noise is larger still


def rounded(values):
    return [[float(f"{x:.5g}") for x in row] for row in values]


def reference(mi, case, where):
    scene, integrator = render_mitsuba.load_case(mi, case)
    means = np.array([tiles.tile_means(render_mitsuba.render(mi, scene, integrator, case.spp, seed))
                      for seed in range(case.seeds)])
    return {**where, "u": list(case.u), "peer": f"Mitsuba {mi.__version__} {mi.variant()}",
            "size": case.size, "tile": tiles.TILE, "max_depth": case.max_depth,
            "rr_depth": case.rr_depth, "spp": case.spp, "seeds": case.seeds,
            "mean": rounded(means.mean(axis=0)),
            "error": rounded(means.std(axis=0, ddof=1) / np.sqrt(case.seeds))}


def main():
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else cases.ROOT / "tests/render/data"
    folder.mkdir(parents=True, exist_ok=True)
    mi = render_mitsuba.use("llvm_ad_rgb")
    small = {"size": SIZE, "seeds": SEEDS}
    for case in cases.own_cases() + cases.DEMO_CASES + cases.OUTSIDE_CASES:
        if sys.argv[2:] and case.name not in sys.argv[2:]:
            continue
        if not case.scene.exists():
            print(f"left as it is: {case.name}: no {case.scene}", file=sys.stderr)
            continue
        if case.scene.is_relative_to(cases.ROOT / "scenes"):
            where = {"scene": str(case.scene.relative_to(cases.ROOT))}
        else:
            where = {"outside": str(case.scene.relative_to(cases.OUTSIDE))}
        spp = OWN_SPP if "scene" in where else SPP
        result = reference(mi, dataclasses.replace(case, **{**small, "spp": spp}), where)
        lines = [f' {json.dumps(k)}: {json.dumps(v)}' for k, v in result.items()]
        name = case.name.replace("/", "_")
        (folder / f"{name}.json").write_text("{\n" + ",\n".join(lines) + "\n}\n")
        print(f"{folder.name}/{name}.json")


if __name__ == "__main__":
    main()
