#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""freeze.py SCENE.xml [-u 0.1,0.2,...] -o OUT.xml [--bbox x0,y0,z0,x1,y1,z1] [--list]

Turns a variable scene (the format of the paper's authors, or a plain scene) at one configuration u
into plain Mitsuba 3 XML: variables are given their values, instances of groups that hold emitters
are expanded into shapes, referenced emitters are put into their shapes, file names become absolute,
what only the renderer of the time knew goes away. For tests only.

u holds one number in [0,1] per parameter, in the order of the document; 0.5 when not given. A
camera's target lies in the middle third of the scene's bounding box, hence --bbox.

A *.variables.json beside the scene is obeyed, too (json_variables.py). Standard library only. As a
module: parameters(), freeze().
"""
import argparse
import copy
import json
import os
import re
import sys
import xml.etree.ElementTree as ElementTree

import json_variables

RULES = ("num_parameters", "min_bounds", "range_bounds", "rotation_axis", "min_angle",
         "range_angle")
VARIABLE_TAGS = ("sensor", "shape", "emitter", "bsdf")
# Properties of renderers of the time that Mitsuba 3 refuses.
FOREIGN = ("samples_per_pass", "high_quality_edges", "ext_eta", "high_quality", "extEta",
           "strictNormals", "light_group")


def numbers(text):
    return [float(x) for x in re.split(r"[\s,]+", text.strip())]


def triple(values):
    return ", ".join(repr(float(v)) for v in values)


def child(element, name):
    for c in element:
        if c.get("name") == name:
            return c
    return None


def set_rgb(element, name, values):
    old = child(element, name)
    if old is not None and old.tag not in ("rgb", "spectrum", "color"):
        raise ValueError(f"{element.get('id')}: a variable factor on a {old.tag} is not supported")
    if old is None:
        old = ElementTree.SubElement(element, "rgb")
    old.attrib.clear()
    old.tag = "rgb"
    old.set("name", name)
    old.set("value", triple(values))


def to_world_of(element):
    transform = child(element, "to_world")
    if transform is None:
        transform = ElementTree.SubElement(element, "transform", name="to_world")
    return transform


class Variable:
    """An object with an id var_...: what it may do, and how many numbers say so."""

    def __init__(self, element):
        self.element = element
        self.id = element.get("id")
        self.type = element.get("type")
        count = child(element, "num_parameters")
        self.n = int(count.get("value")) if count is not None else 3
        size = 4 if element.tag == "bsdf" else 3
        self.min = self.rule("min_bounds", [0.0] * size)
        self.range = self.rule("range_bounds", [1.0] * size)
        self.parts = self.name_parts()

    def rule(self, name, default):
        node = child(self.element, name)
        return numbers(node.get("value")) if node is not None else default

    def name_parts(self):
        """Names of the parameters, in the order in which u gives them."""
        tag, n = self.element.tag, self.n
        if tag == "sensor":
            return ["x", "y", "z", "target_x", "target_z"]
        if tag == "shape" and self.type == "shapegroup":
            return ["choice"]
        if tag == "shape":
            moves = [axis for axis, width in zip("xyz", self.range) if width > 0][:n]
            return moves + ["angle"] * (len(moves) < n)
        if tag == "emitter":
            return ["angle"] if self.type == "envmap" else ["scale"] if n == 1 else list("rgb")
        if self.type == "diffuse":
            return list("rgb") * (n != 1) + ["choice"] * (n in (1, 4))
        return list("rgb") * (n != 1) + ["alpha"] * (n in (1, 4))

    def at(self, axis, u):
        return self.min[axis] + u * self.range[axis]

    def apply(self, u, bbox):
        u = dict(zip(self.parts, u))
        {"sensor": self.place_camera, "shape": self.apply_shape, "emitter": self.apply_emitter,
         "bsdf": self.apply_bsdf}[self.element.tag](u, bbox)

    def place_camera(self, u, bbox):
        if bbox is None:
            raise ValueError("a variable camera needs the scene's bounding box")
        low, high = bbox[:3], bbox[3:]
        third = [(high[i] - low[i]) / 3 for i in range(3)]
        target = [low[0] + (1 + u["target_x"]) * third[0], low[1] + third[1],
                  low[2] + (1 + u["target_z"]) * third[2]]
        origin = [self.at(i, u[axis]) for i, axis in enumerate("xyz")]
        transform = to_world_of(self.element)
        transform[:] = [ElementTree.Element("lookat", origin=triple(origin), target=triple(target),
                                            up="0, 1, 0")]

    def apply_shape(self, u, _bbox):
        element = self.element
        if self.type == "shapegroup":
            shapes = element.findall("shape")
            chosen = shapes[min(int(u["choice"] * len(shapes)), len(shapes) - 1)]
            for shape in shapes:
                if shape is not chosen:
                    element.remove(shape)
            return
        transform = to_world_of(element)
        if self.type == "instance":
            transform[:] = []
        if "angle" in u:
            axis = self.rule("rotation_axis", [0.0, 1.0, 0.0])
            angle = float(child(element, "min_angle").get("value")) \
                + u["angle"] * float(child(element, "range_angle").get("value"))
            ElementTree.SubElement(transform, "rotate", x=repr(axis[0]), y=repr(axis[1]),
                                   z=repr(axis[2]), angle=repr(angle))
        offset = [self.at(i, u.get(axis, 0.0)) for i, axis in enumerate("xyz")]
        if child(element, "min_bounds") is not None:
            ElementTree.SubElement(transform, "translate", value=triple(offset))

    def apply_emitter(self, u, _bbox):
        if self.type == "envmap":
            ElementTree.SubElement(to_world_of(self.element), "rotate", y="1",
                                   angle=repr(100 + 40 * u["angle"]))
            return
        name = "intensity" if child(self.element, "intensity") is not None else "radiance"
        set_rgb(self.element, name, [self.at(i, u.get("scale", u.get("rgb"[i])))
                                     for i in range(3)])

    def apply_bsdf(self, u, _bbox):
        is_diffuse = self.type == "diffuse"
        if "choice" in u:
            options = [r for r in self.element.findall("ref") if r.get("name") == "reflectance"]
            keep = options[min(int(u["choice"] * len(options)), len(options) - 1)]
            for option in options:
                if option is not keep:
                    self.element.remove(option)
        if "r" in u:
            set_rgb(self.element, "reflectance" if is_diffuse else "specular_reflectance",
                    [self.at(i, u[c]) for i, c in enumerate("rgb")])
        if "alpha" in u:
            alpha = child(self.element, "alpha")
            if alpha is None:
                alpha = ElementTree.SubElement(self.element, "float", name="alpha")
            alpha.set("value", repr(self.at(3, u["alpha"])))


def read_with_includes(path):
    """The document with included ones in place and absolute file names."""
    root = ElementTree.parse(path).getroot()
    folder = os.path.dirname(path)
    for node in root.iter("string"):
        if node.get("name") == "filename" and "$" not in node.get("value"):
            node.set("value", os.path.abspath(os.path.join(folder, node.get("value"))))
    for parent in list(root.iter()):
        for i, node in reversed(list(enumerate(parent))):
            if node.tag == "include":
                parent[i:i + 1] = read_with_includes(os.path.join(folder, node.get("filename")))
    return root


def read(path, defines=None):
    """The document with $names replaced by their defaults or by `defines`."""
    root = read_with_includes(path)
    values = {d.get("name"): d.get("value") for d in root.findall("default")}
    values.update(defines or {})
    for element in list(root.iter()):
        for key, text in element.attrib.items():
            element.set(key, re.sub(r"\$(\w+)", lambda m: values.get(m.group(1), m.group(0)), text))
    for default in root.findall("default"):
        root.remove(default)
    return root


def variables_of(root):
    return [Variable(e) for e in root.iter()
            if e.tag in VARIABLE_TAGS and (e.get("id") or "").startswith("var_")]


def parameters(path):
    """Names like `door.angle`, one per number of u."""
    return [f"{v.id[4:]}.{part}" for v in variables_of(read(path)) for part in v.parts]


def put_emitters_into_shapes(root):
    """Shapes may <ref> a top-level area emitter, which several may share."""
    named = {e.get("id"): e for e in root.findall("emitter") if e.get("id")}
    used = set()
    for shape in root.iter("shape"):
        for i, node in enumerate(list(shape)):
            if node.tag == "ref" and node.get("id") in named:
                own = copy.deepcopy(named[node.get("id")])
                del own.attrib["id"]
                shape[i] = own
                used.add(node.get("id"))
    for name in used:
        root.remove(named[name])


def expand_instances(root):
    """Puts shapes in place of instances whose group holds an emitter, which Mitsuba 3 refuses."""
    groups = {g.get("id"): g for g in root.findall("shape") if g.get("type") == "shapegroup"}
    lit = {name: group for name, group in groups.items() if group.find(".//emitter") is not None}
    for instance in [s for s in root.findall("shape") if s.get("type") == "instance"]:
        group = lit.get(instance.find("ref").get("id"))
        if group is None:
            continue
        placement = child(instance, "to_world")
        for shape in group.findall("shape"):
            copied = copy.deepcopy(shape)
            copied.attrib.pop("id", None)
            if placement is not None:
                to_world_of(copied).extend(copy.deepcopy(list(placement)))
            root.append(copied)
        root.remove(instance)
    for group in lit.values():
        root.remove(group)


def clean(root, folder):
    """Drops what Mitsuba 3 refuses; the caller chooses the integrator."""
    for element in list(root.iter()):
        for node in list(element):
            if node.get("name") in RULES + FOREIGN or node.tag in ("mode", "hide"):
                element.remove(node)
            elif node.tag == "string" and node.get("name") == "filename":
                node.set("value", os.path.abspath(os.path.join(folder, node.get("value"))))
            elif node.tag == "string" and node.get("value") == "trilinear":
                node.set("value", "bilinear")
    for integrator in root.findall("integrator"):
        root.remove(integrator)
    for film in root.iter("film"):
        film.set("type", "hdrfilm")
        for node in list(film):
            name = node.get("name") or ""
            if (name not in ("width", "height") and not name.startswith("crop_")
                    and node.tag != "rfilter"):
                film.remove(node)


def freeze(path, u=None, bbox=None, defines=None):
    """The XML text of `path` at u (None: 0.5 everywhere, but the defaults of a *.variables.json)."""
    root = read(path, defines)
    beside = path.removesuffix(".xml") + ".variables.json"
    if os.path.exists(beside):
        json_variables.apply(root, beside, u, set_rgb, to_world_of)
        u = []
    variables = variables_of(root)
    n = sum(len(v.parts) for v in variables)
    u = [0.5] * n if u is None else list(u)
    if len(u) != n:
        raise ValueError(f"{path}: {len(u)} numbers for {n} parameters")
    for variable in variables:
        variable.apply(u[:len(variable.parts)], bbox)
        u = u[len(variable.parts):]
    put_emitters_into_shapes(root)
    expand_instances(root)
    clean(root, os.path.dirname(path))
    if root.get("version", "").startswith("2."):
        root.set("version", "3.0.0")
    return ElementTree.tostring(root, encoding="unicode") + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene")
    parser.add_argument("-o", "--output")
    parser.add_argument("-u", type=lambda text: numbers(text), help="one number per parameter")
    parser.add_argument("--bbox", type=lambda text: numbers(text))
    parser.add_argument("--list", action="store_true", help="print the parameters as JSON")
    args = parser.parse_args()
    if args.list:
        print(json.dumps(parameters(args.scene)))
    if args.output:
        text = freeze(args.scene, args.u, args.bbox)
        with open(args.output, "w", encoding="utf-8") as out:
            out.write(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
