# SPDX-License-Identifier: Apache-2.0
"""Variables of a *.variables.json written into the XML of a scene, for freeze.py.

Written from docs/scene-format.md alone, so that it checks what the product does. Kinds: translate,
rotate, scale, color, float and intensity, with targets that name an object or one of its
properties; anything else is refused. Standard library only.
"""
import json
import math
import xml.etree.ElementTree as ElementTree

COMPONENTS = {"color": "rgb", "translate": "xyz", "scale": "xyz"}


def numbers(text):
    return [float(x) for x in text.replace(",", " ").split()]


def vector(node, missing):
    if node.get("value"):
        values = numbers(node.get("value"))
        return values * 3 if len(values) == 1 else values
    return [float(node.get(axis, missing)) for axis in "xyz"]


def rotated(point, axis, degrees):
    """Rodrigues' formula."""
    length = math.sqrt(sum(a * a for a in axis))
    k = [a / length for a in axis]
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    dot = sum(a * b for a, b in zip(k, point))
    cross = [k[1] * point[2] - k[2] * point[1], k[2] * point[0] - k[0] * point[2],
             k[0] * point[1] - k[1] * point[0]]
    return [p * c + x * s + a * dot * (1 - c) for p, x, a in zip(point, cross, k)]


def origin_of(transform):
    """Where a to_world puts (0, 0, 0)."""
    point = [0.0, 0.0, 0.0]
    for node in transform:
        if node.tag == "translate":
            point = [a + b for a, b in zip(point, vector(node, 0))]
        elif node.tag == "scale":
            point = [a * b for a, b in zip(point, vector(node, 1))]
        elif node.tag == "rotate":
            point = rotated(point, vector(node, 0), float(node.get("angle")))
        elif node.tag == "matrix" and len(m := numbers(node.get("value"))) == 16:
            point = [sum(m[4 * r + c] * point[c] for c in range(3)) + m[4 * r + 3]
                     for r in range(3)]
        else:
            raise ValueError(f"<{node.tag}> in a to_world that turns is not supported")
    return point


class JsonVariable:
    def __init__(self, spec):
        self.name, self.kind, self.spec = spec["name"], spec["kind"], spec
        targets = spec["targets"]
        self.targets = [targets] if isinstance(targets, str) else targets
        self.low, self.high = self.box()
        # A component whose range is a point is no parameter.
        self.varying = [i for i, (a, b) in enumerate(zip(self.low, self.high)) if a != b]
        self.n = len(self.varying)

    def box(self):
        limits = self.spec["range"]
        if isinstance(limits, dict):
            return limits["min"], limits["max"]
        count = 3 if self.kind == "color" and "from" not in self.spec else 1
        return [limits[0]] * count, [limits[1]] * count

    def values(self, u):
        """In scene units: from u, or the declared default."""
        if u is None:
            default = self.spec["default"]
            return list(default) if isinstance(default, list) else [default] * len(self.low)
        values = list(self.low)
        for i, x in zip(self.varying, u):
            values[i] = self.low[i] + x * (self.high[i] - self.low[i])
        return values


def nodes(**attributes):
    tag = attributes.pop("tag")
    return ElementTree.Element(tag, {k: v if isinstance(v, str) else repr(float(v))
                                     for k, v in attributes.items()})


def moved(variable, values, pivot):
    """The XML of one move, first applied first."""
    x, y, z = (values + [0, 0, 0])[:3] if variable.kind == "translate" else pivot
    if variable.kind == "translate":
        if "direction" in variable.spec:
            x, y, z = (values[0] * d for d in variable.spec["direction"])
        return [nodes(tag="translate", x=x, y=y, z=z)]
    there = nodes(tag="translate", x=x, y=y, z=z)
    back = nodes(tag="translate", x=-x, y=-y, z=-z)
    if variable.kind == "rotate":
        ax, ay, az = variable.spec["axis"]
        return [back, nodes(tag="rotate", x=ax, y=ay, z=az, angle=values[0]), there]
    sx, sy, sz = values * 3 if len(values) == 1 else values
    return [back, nodes(tag="scale", x=sx, y=sy, z=sz), there]


def apply(root, path, u, set_rgb, to_world_of):
    """Writes the configuration u (None: the defaults) into `root`."""
    with open(path, encoding="utf-8") as file:
        variables = [JsonVariable(spec) for spec in json.load(file)["variables"]]
    if u is not None and len(u) != sum(v.n for v in variables):
        raise ValueError(f"{path}: {len(u)} numbers for {sum(v.n for v in variables)} variables")
    named = {e.get("id"): e for e in root.iter() if e.get("id") and e.tag != "ref"}
    moves = {} # target id -> kind -> list of (variable, values)
    rest = u
    for variable in variables:
        own = None if u is None else rest[:variable.n]
        rest = None if u is None else rest[variable.n:]
        values = variable.values(own)
        for target in variable.targets:
            name, _, prop = target.partition(".")
            prop = prop.removesuffix(".value")
            element = named[name]
            if variable.kind in ("translate", "rotate", "scale"):
                moves.setdefault(name, {}).setdefault(variable.kind, []).append((variable, values))
            elif variable.kind == "color" and "from" not in variable.spec:
                set_rgb(element, prop, values)
            elif variable.kind == "intensity":
                rgb = next(c for c in element if c.get("name") in ("radiance", "intensity"))
                rgb.set("value", ", ".join(repr(x * values[0]) for x in vector(rgb, 0)))
            elif variable.kind == "float":
                number = next(c for c in element if c.get("name") == prop)
                number.set("value", repr(float(values[0])))
            else:
                raise ValueError(f"{path}: {variable.name}: kind {variable.kind} is not supported")
    for name, kinds in moves.items():
        transform = to_world_of(named[name])
        origin = origin_of(transform) if "rotate" in kinds or "scale" in kinds else None
        for kind in ("scale", "rotate", "translate"):
            for variable, values in reversed(kinds.get(kind, [])):
                transform.extend(moved(variable, values, variable.spec.get("pivot", origin)))
