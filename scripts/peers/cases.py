# SPDX-License-Identifier: Apache-2.0
"""What check_trace.py and the references render: scenes at frozen configurations.

A case is one picture: a scene, the configuration u (one number in [0,1] per parameter), size, path
depth, samples per seed, and the number of seeds. Outside scenes are found through LUMENAUT_SCENES.
"""
import dataclasses
import os
import pathlib

ROOT = pathlib.Path(__file__).resolve().parents[2]
OUTSIDE = pathlib.Path(os.environ.get("LUMENAUT_SCENES", ROOT / "../shared/scenes"))


@dataclasses.dataclass(frozen=True)
class Case:
    name: str
    scene: pathlib.Path
    u: tuple = ()
    size: int = 128
    max_depth: int = 6
    rr_depth: int = 5
    spp: int = 256
    seeds: int = 16
    integrator: str = "path" # Mitsuba's
    is_mixed: bool = False   # blends are given to Mitsuba as mixtures of old_plugins.py


CAUSTIC = OUTSIDE / "official/sphere-caustic/scene.xml"
AJAR = OUTSIDE / "official/veach-ajar/scene.xml"
SPACESHIP = OUTSIDE / "official/spaceship/scene.xml"
CORNELL = OUTSIDE / "bitterli/cornell-box/scene.xml"

# ball x z, frost, knot, wall r g b, lamp, dimmer
DEMO = ROOT / "scenes/demo/scene.xml"
DEMO_CASES = [
    Case("demo", DEMO, (.5,) * 9, 64),
    Case("demo-1", DEMO, (.9, .1, .8, .15, .9, .2, .4, .85, .3), 64),
    Case("demo-2", DEMO, (.1, .8, .4, .7, .1, .6, .9, .1, .9), 64),
]

# sphere-caustic: left wall, right wall, roughness, sphere x y z, light x z.
# veach-ajar: camera x y z, target x z, door. spaceship: camera x y z, target x z, three lights.
OUTSIDE_CASES = [
    Case("sphere-caustic-1", CAUSTIC, (.8, .2, .1, .1, .7, .2, .6, .5, .5, .5, .5, .5), 128, 5),
    Case("sphere-caustic-2", CAUSTIC, (.5, .5, .5, .9, .1, .6, .25, .9, .1, .9, .1, .9), 128, 5),
    Case("sphere-caustic-3", CAUSTIC, (.1, .9, .3, .3, .3, 1., 1., .1, .9, 0., 1., 0.), 128, 5),
    Case("veach-ajar-1", AJAR, (.5, .5, .5, .5, .5, .5), 128, 9),
    Case("veach-ajar-2", AJAR, (.9, .2, .8, .2, .3, 1.), 128, 9),
    Case("veach-ajar-3", AJAR, (.2, .9, .3, .8, .9, .25), 128, 9),
    Case("cornell-box", CORNELL, (), 128, 6),
    Case("veach-mis", OUTSIDE / "bitterli/veach-mis/scene.xml", (), 128, 5),
    Case("staircase2", OUTSIDE / "bitterli/staircase2/scene.xml", (), 128, 9),
    Case("spaceship-1", SPACESHIP, (.5, .5, .9, .5, .4, .8, .8, .8), 128, 9),
    Case("spaceship-3", SPACESHIP, (.43, 0., .9985, .5, .5, .5, .5, .5), 128, 9),
    Case("spaceship-2", SPACESHIP, (.3, .2, .95, .55, .3, .2, .9, .5), 128, 9),
]


# Outside scenes with another sky, as the sky models differ (classroom.py).
CLASSROOM_CASES = [
    Case(f"classroom-{sky}", ROOT / f"build/peers/classroom-{sky}.xml", (), 128, 9)
    for sky in ("constant", "envmap")]

# Not for comparison: a sky by another model than Mitsuba's (docs/scene-format.md has how far they
# are apart). In ours/: textured roughness, which Mitsuba has not, and what no twin is needed for.
OTHERS = ("sunsky", "ours/roughplastic_alpha", "ours/textures_of_0_6")
SPECIAL = {"directionalarea": {"integrator": "ptracer"}, "ours/blendbsdf_delta": {"is_mixed": True}}


def own_cases():
    """The small scenes of this project, at their default configuration."""
    folder = ROOT / "scenes/tests"
    names = sorted(str(path.relative_to(folder).with_suffix("")) for path in folder.rglob("*.xml"))
    return [Case(name, folder / f"{name}.xml", size=64, **SPECIAL.get(name, {}))
            for name in names if name not in OTHERS]


def all_cases():
    return own_cases() + DEMO_CASES + OUTSIDE_CASES + CLASSROOM_CASES
