#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""make_pocket.py [FOLDER]    (default: scenes/pocket)

Makes scene.xml and scene.variables.json of the scene with a small pocket: a room with 25 variables, of
which 22 matter a little. The other three stand between a bright lamp outside and a window in the right
wall: a plate with a slit that slides along the wall, one that slides up and down, and a block with a
slot that turns. Only where all three are open does a beam get through to the back wall. Standard
library only; the same bytes every time.
"""
import json
import math
import pathlib
import sys

# The room: x -2 .. 2, y 0 .. 2.6, z -2 .. 2, open towards the camera.
HALF, HEIGHT = 2.0, 2.6
WINDOW = (HALF, 1.5, 0.9)          # its centre, in the right wall
WINDOW_Y, WINDOW_Z = 0.4, 0.35     # half its height and width
BEAM = (0.66, 0.15, 0.736)         # from the window to the lamp
LAMP_AT, BLOCK_AT = 3.2, 1.6       # along it
SHUTTER_RANGE, BLIND_RANGE, BLOCK_RANGE = 4.2, 4.8, 90.0
SLOT, BLOCK_DEPTH, BLOCK_SIDE = 0.36, 1.4, 0.6

HEADER = """<?xml version="1.0" encoding="utf-8"?>
<!-- A room with a small pocket: 25 variables, three of which must agree for a beam to come in. Written by
     scripts/scenes/make_pocket.py; what varies is in scene.variables.json. Plain Mitsuba 3 XML. CC0. -->
<scene version="3.0.0">
    <integrator type="path">
        <integer name="max_depth" value="6"/>
    </integrator>
    <sensor type="perspective" id="sensor">
        <string name="fov_axis" value="x"/>
        <float name="fov" value="35.5"/>
        <transform name="to_world">
            <lookat origin="0, 1.3, 7" target="0, 1.25, 0" up="0, 1, 0"/>
        </transform>
        <sampler type="independent">
            <integer name="sample_count" value="128"/>
        </sampler>
        <film type="hdrfilm">
            <integer name="width" value="256"/>
            <integer name="height" value="192"/>
            <rfilter type="tent"/>
        </film>
    </sensor>
"""


def number(x):
    return f"{x:.6g}"


def values(**v):
    return " ".join(f'{k}="{number(x)}"' for k, x in v.items())


def rgb(name, color):
    return f'<rgb name="{name}" value="{", ".join(map(number, color))}"/>'


def diffuse(name, color):
    return f'    <bsdf type="diffuse" id="{name}">\n        {rgb("reflectance", color)}\n    </bsdf>\n'


def shape(kind, name, bsdf, *transform, inside=""):
    lines = "".join(f"            <{t}/>\n" for t in transform)
    return (f'    <shape type="{kind}" id="{name}">\n        <transform name="to_world">\n{lines}'
            f'        </transform>\n        <ref id="{bsdf}"/>\n{inside}    </shape>\n')


TURNS = {"+y": 'rotate x="1" angle="-90"', "-y": 'rotate x="1" angle="90"', "+z": None,
         "+x": 'rotate y="1" angle="90"', "-x": 'rotate y="1" angle="-90"'}


def panel(name, bsdf, facing, low, high, inside=""):
    """A rectangle from low to high, equal along the axis that it faces."""
    turn = TURNS[facing]
    half = [max((b - a) / 2, 0) or 1 for a, b in zip(low, high)]
    center = [(a + b) / 2 for a, b in zip(low, high)]
    transform = [t for t in (turn, "scale " + values(**dict(zip("xyz", half))),
                             "translate " + values(**dict(zip("xyz", center)))) if t]
    return shape("rectangle", name, bsdf, *transform, inside=inside)


def area(name, color):
    return (f'        <emitter type="area" id="{name}">\n            {rgb("radiance", color)}\n'
            "        </emitter>\n")


def around(name, bsdf, x, low, high, hole_low, hole_high):
    """A wall that faces -x, y and z from low to high, with a hole: four panels."""
    (y0, z0), (y3, z3), (y1, z1), (y2, z2) = low, high, hole_low, hole_high
    parts = (("below", y0, y1, z0, z3), ("above", y2, y3, z0, z3), ("behind", y1, y2, z0, z1),
             ("before", y1, y2, z2, z3))
    return "".join(panel(f"{name}_{part}", bsdf, "-x", (x, a, c), (x, b, d)) for part, a, b, c, d in parts)


def along(distance):
    return tuple(w + distance * b for w, b in zip(WINDOW, BEAM))


def room():
    y, z = WINDOW[1:]
    hole = (y - WINDOW_Y, z - WINDOW_Z), (y + WINDOW_Y, z + WINDOW_Z)
    h, top = HALF, HEIGHT
    return "".join((
        panel("floor", "floor_mat", "+y", (-h, 0, -h), (h, 0, h)),
        panel("ceiling", "plaster", "-y", (-h, top, -h), (h, top, h)),
        panel("back_wall", "back_mat", "+z", (-h, 0, -h), (h, top, -h)),
        panel("left_wall", "left_mat", "+x", (-h, 0, -h), (-h, top, h)),
        around("right_wall", "plaster", h, (0, -h), (top, h), *hole),
        around("screen", "black", h + 0.02, (-8, -8), (10, 14), *hole)))


def outside():
    """What lets the beam through: seen from the room it is behind the window."""
    x, y, z = WINDOW
    far = 2 * SHUTTER_RANGE + 1
    shutter = [panel(f"shutter_{part}", "shutter_mat", "-x", (x + 0.05, y - 1, z + a), (x + 0.05, y + 1, z + b))
               for part, a, b in (("behind", -far, -WINDOW_Z), ("before", WINDOW_Z, far))]
    far = 2 * BLIND_RANGE + 1
    blind = [panel(f"blind_{part}", "shutter_mat", "-x", (x + 0.1, y + a, z - 1.5), (x + 0.1, y + b, z + 1.5))
             for part, a, b in (("below", -far, -WINDOW_Y), ("above", WINDOW_Y, far))]
    turn = math.degrees(math.atan2(BEAM[0], BEAM[2]))
    center = dict(zip("xyz", along(BLOCK_AT)))
    block = [shape("cube", f"block_{part}", "black",
                   "scale " + values(x=BLOCK_SIDE / 2, y=2, z=BLOCK_DEPTH / 2),
                   "translate " + values(x=side * (SLOT + BLOCK_SIDE) / 2),
                   f'rotate y="1" angle="{number(turn)}"', "translate " + values(**center))
             for part, side in (("left", -1), ("right", 1))]
    origin, target = along(LAMP_AT), WINDOW
    sun = shape("rectangle", "sun", "black", 'scale value="0.1"',
                f'lookat origin="{", ".join(map(number, origin))}" target="{", ".join(map(number, target))}"'
                ' up="0, 1, 0"', inside=area("sun_light", (28000, 24500, 18000)))
    return "".join((*shutter, *blind, *block, sun))


def things():
    lamp = panel("lamp", "black", "-y", (-0.35, HEIGHT - 0.05, -0.35), (0.35, HEIGHT - 0.05, 0.35),
                 area("lamp_light", (26, 23, 18)))
    return "".join((
        shape("cube", "chest", "chest_mat", "scale " + values(x=0.4, y=0.3, z=0.3),
              "translate " + values(x=-1, y=0.3, z=-0.9)),
        shape("cube", "tower", "tower_mat", "scale " + values(x=0.25, y=0.6, z=0.25),
              "translate " + values(x=1.2, y=0.6, z=-1.2)),
        '    <shape type="sphere" id="ball">\n        <float name="radius" value="0.3"/>\n'
        '        <point name="center" x="0.2" y="0.3" z="0.5"/>\n        <ref id="metal"/>\n    </shape>\n',
        lamp))


def scene():
    metal = ('    <bsdf type="roughconductor" id="metal">\n        <string name="distribution" value="ggx"/>\n'
             '        <float name="alpha" value="0.2"/>\n'
             f'        {rgb("eta", (1.66, 0.88, 0.52))}\n        {rgb("k", (9.22, 6.27, 4.84))}\n    </bsdf>\n')
    materials = "".join((
        diffuse("back_mat", (0.5, 0.5, 0.5)), diffuse("left_mat", (0.6, 0.25, 0.2)),
        diffuse("floor_mat", (0.45, 0.4, 0.35)), diffuse("plaster", (0.7, 0.68, 0.64)),
        diffuse("chest_mat", (0.45, 0.35, 0.45)), diffuse("tower_mat", (0.475, 0.435, 0.3)),
        diffuse("shutter_mat", (0.3, 0.32, 0.35)), diffuse("black", (0, 0, 0)), metal))
    return HEADER + "\n" + materials + "\n" + room() + "\n" + things() + "\n" + outside() + "</scene>\n"


def variables():
    def color(name, target, what, default):
        return {"name": name, "kind": "color", "description": what, "targets": f"{target}.reflectance",
                "range": [0.1, 0.8], "default": default}

    def place(name, what, low, high):
        return {"name": name, "kind": "translate", "description": what, "targets": name,
                "range": {"min": [low[0], 0, low[1]], "max": [high[0], 0, high[1]]}, "default": [0, 0, 0]}

    def turn(name, target, what):
        return {"name": name, "kind": "rotate", "description": what, "targets": target, "axis": [0, 1, 0],
                "range": [-45, 45], "default": 0}

    def paint(name, target, what, low, high):
        return {"name": name, "kind": "color", "description": what, "targets": f"{target}.reflectance",
                "from": low, "to": high, "default": 0.5}

    def slide(name, what, direction, limit):
        return {"name": name, "kind": "translate", "description": what,
                "targets": [f"{name}_{p}" for p in (("behind", "before") if name == "shutter"
                                                    else ("below", "above"))],
                "direction": direction, "range": [-limit, limit], "default": round(limit / 3, 6)}

    pivot = [float(number(c)) for c in along(BLOCK_AT)]
    return {
        "$schema": "../../docs/variables.schema.json",
        "description": "25 variables. Only with shutter, blind and block near 0 does the beam come in.",
        "variables": [
            color("back", "back_mat", "Reflectance of the back wall", [0.5, 0.5, 0.5]),
            color("left", "left_mat", "Reflectance of the left wall", [0.6, 0.25, 0.2]),
            color("floor", "floor_mat", "Reflectance of the floor", [0.45, 0.4, 0.35]),
            place("chest", "Where the chest stands", (-0.4, -0.5), (0.4, 0.8)),
            turn("chest_turn", "chest", "The chest turns"),
            paint("chest_paint", "chest_mat", "From blue to red", [0.2, 0.4, 0.7], [0.7, 0.3, 0.2]),
            place("tower", "Where the tower stands", (-0.4, -0.3), (0.4, 0.7)),
            turn("tower_turn", "tower", "The tower turns"),
            paint("tower_paint", "tower_mat", "From dark to bright", [0.15, 0.12, 0.1], [0.8, 0.75, 0.5]),
            place("ball", "Where the metal ball lies", (-0.9, -0.4), (0.9, 0.6)),
            {"name": "polish", "kind": "float", "description": "Roughness of the ball",
             "targets": "metal.alpha", "range": [0.08, 0.5], "default": 0.2},
            place("lamp", "Where the lamp hangs", (-1, -1), (1, 1)),
            slide("shutter", "The plate with the upright slit slides along the wall", [0, 0, 1],
                  SHUTTER_RANGE),
            slide("blind", "The plate with the level slit slides up and down", [0, 1, 0], BLIND_RANGE),
            {"name": "block", "kind": "rotate", "description": "The block with the slot turns",
             "targets": ["block_left", "block_right"], "axis": [0, 1, 0], "pivot": pivot,
             "range": [-BLOCK_RANGE, BLOCK_RANGE], "default": 40},
        ],
    }


def main():
    root = pathlib.Path(__file__).resolve().parents[2]
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else root / "scenes/pocket"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "scene.xml").write_text(scene(), encoding="utf-8")
    text = json.dumps(variables(), indent=4) + "\n"
    (folder / "scene.variables.json").write_text(text, encoding="utf-8")
    print(f"{folder}: {len(text)} and {len(scene())} bytes")


if __name__ == "__main__":
    main()
