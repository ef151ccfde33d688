#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""make_tests.py [FOLDER]    (default: scenes/tests)

Writes the small scenes that are compared with Mitsuba 3, one per plugin, with their textures and
meshes; in ours/ those of plugins that only Mitsuba 0.x had. Standard library only; the same bytes every time.
"""
import math
import pathlib
import struct
import sys
import zlib

import tests_formats
import tests_lights
import tests_materials
import tests_pictures

HEAD = """<?xml version="1.0" encoding="utf-8"?>
<!-- {what}. Made by scripts/scenes/make_tests.py. CC0. -->
<scene version="3.0.0">
    <integrator type="path">
        <integer name="max_depth" value="{depth}"/>
    </integrator>
    <sensor type="perspective">
        <float name="fov" value="32"/>
        <transform name="to_world">
            <lookat origin="0.4, 1.5, 4.2" target="0, 0.62, 0" up="0, 1, 0"/>
        </transform>
        <sampler type="independent">
            <integer name="sample_count" value="64"/>
        </sampler>
        <film type="hdrfilm">
            <integer name="width" value="128"/>
            <integer name="height" value="128"/>
            {rfilter}
        </film>
    </sensor>
"""

FLOOR = """
    <shape type="rectangle" id="floor">
        <transform name="to_world">
            <rotate x="1" angle="-90"/>
            <scale value="2"/>
        </transform>
        <bsdf type="diffuse">
            <rgb name="reflectance" value="0.5, 0.45, 0.4"/>
        </bsdf>
    </shape>
    <shape type="rectangle" id="back">
        <transform name="to_world">
            <scale value="2"/>
            <translate z="-1.5"/>
        </transform>
        <bsdf type="diffuse">
            <rgb name="reflectance" value="0.2, 0.3, 0.5"/>
        </bsdf>
    </shape>
"""

LIGHT = """
    <shape type="rectangle" id="lamp">
        <transform name="to_world">
            <rotate x="1" angle="90"/>
            <scale value="0.8"/>
            <translate x="-0.5" y="3" z="0.5"/>
        </transform>
        <emitter type="area">
            <rgb name="radiance" value="9, 8, 7"/>
        </emitter>
    </shape>
"""

BALL = """
    <shape type="sphere" id="ball">
        <point name="center" x="0" y="0.65" z="0"/>
        <float name="radius" value="0.65"/>
        <ref id="material"/>
    </shape>
"""

# A ball has all angles; the box beside it flat faces and edges.
THINGS = """
    <shape type="sphere" id="ball">
        <point name="center" x="-0.55" y="0.6" z="0"/>
        <float name="radius" value="0.6"/>
        <ref id="material"/>
    </shape>
    <shape type="cube" id="box">
        <transform name="to_world">
            <scale value="0.4"/>
            <rotate y="1" angle="30"/>
            <translate x="0.75" y="0.401" z="0.2"/>
        </transform>
        <ref id="material"/>
    </shape>
"""


def material(kind, body=""):
    return f'\n    <bsdf type="{kind}" id="material">\n{body}    </bsdf>\n'


def rgb(name, value):
    return f'        <rgb name="{name}" value="{value}"/>\n'


def number(name, value):
    return f'        <float name="{name}" value="{value}"/>\n'


def text(name, value):
    return f'        <string name="{name}" value="{value}"/>\n'


GOLD = rgb("eta", "0.143, 0.375, 1.442") + rgb("k", "3.983, 2.386, 1.603")
GLASS = number("int_ior", 1.5) + number("ext_ior", 1)


def bitmap(name, filename, extra="", to_uv=""):
    return (f'        <texture type="bitmap" name="{name}">\n'
            f'            <string name="filename" value="{filename}"/>\n{extra}'
            + (f'            <transform name="to_uv">\n                {to_uv}\n'
               '            </transform>\n' if to_uv else "")
            + "        </texture>\n")


# Not a checkerboard: Mitsuba 3.9 swaps its colours where a number is asked for.
NUMBERS = '            <boolean name="raw" value="true"/>\n'

CHECKER = """        <texture type="checkerboard" name="{name}">
            <rgb name="color0" value="{a}"/>
            <rgb name="color1" value="{b}"/>
            <transform name="to_uv">
                <scale x="{x}" y="{y}"/>
            </transform>
        </texture>
"""


def card(body, shape="rectangle"):
    """A leaning card that faces the camera."""
    return f"""
    <shape type="{shape}" id="card">
        <transform name="to_world">
            <scale value="0.75"/>
            <rotate x="1" angle="-15"/>
            <rotate y="1" angle="20"/>
            <translate y="0.8"/>
        </transform>
{body}    </shape>
"""


def mesh(plugin, filename, extra=""):
    return f"""
    <shape type="{plugin}" id="thing">
        <string name="filename" value="{filename}"/>
{extra}        <transform name="to_world">
            <scale x="0.7" y="0.7" z="0.55"/>
            <rotate y="1" angle="25"/>
            <translate y="0.7"/>
        </transform>
        <bsdf type="twosided">
            <bsdf type="diffuse">
                <rgb name="reflectance" value="0.7, 0.4, 0.2"/>
            </bsdf>
        </bsdf>
    </shape>
"""


TENT = '<rfilter type="tent"/>'
BACKLIT = FLOOR + LIGHT


def scenes():
    """name -> (what it shows, body, depth, filter)"""
    plain = {
        "diffuse": ("A diffuse material, light between walls",
                    material("diffuse", rgb("reflectance", "0.8, 0.3, 0.2")) + THINGS + BACKLIT),
        "conductor": ("A smooth conductor with eta and k",
                      material("conductor", GOLD) + THINGS + BACKLIT),
        "conductor_named": ("A smooth conductor by name, tinted",
                            material("conductor", text("material", "Cu")
                                     + rgb("specular_reflectance", "0.9, 1, 0.8")) + THINGS
                            + BACKLIT),
        "conductor_none": ("A perfect mirror", material("conductor", text("material", "none"))
                           + THINGS + BACKLIT),
        "roughconductor_beckmann": ("A rough conductor, Beckmann",
                                    material("roughconductor", text("distribution", "beckmann")
                                             + number("alpha", 0.25) + GOLD) + THINGS + BACKLIT),
        "roughconductor_ggx": ("A rough conductor, GGX",
                               material("roughconductor", text("distribution", "ggx")
                                        + number("alpha", 0.15) + GOLD) + THINGS + BACKLIT),
        "roughconductor_anisotropic": ("A rough conductor, rougher along v",
                                       material("roughconductor", text("distribution", "ggx")
                                                + number("alpha_u", 0.08)
                                                + number("alpha_v", 0.35) + GOLD) + THINGS
                                       + BACKLIT),
        "dielectric": ("Clear glass", material("dielectric", GLASS) + THINGS + BACKLIT),
        "dielectric_tinted": ("Glass of two tints",
                              material("dielectric", GLASS
                                       + rgb("specular_reflectance", "1, 0.6, 0.5")
                                       + rgb("specular_transmittance", "0.6, 0.9, 0.8")) + THINGS
                              + BACKLIT),
        "roughdielectric_beckmann": ("Rough glass, Beckmann",
                                     material("roughdielectric", text("distribution", "beckmann")
                                              + number("alpha", 0.2) + GLASS) + THINGS + BACKLIT),
        "roughdielectric_ggx": ("Rough glass, GGX",
                                material("roughdielectric", text("distribution", "ggx")
                                         + number("alpha", 0.3) + GLASS) + THINGS + BACKLIT),
        "plastic": ("Plastic", material("plastic", rgb("diffuse_reflectance", "0.1, 0.4, 0.2"))
                    + THINGS + BACKLIT),
        "plastic_nonlinear": ("Plastic that shifts its colour",
                              material("plastic", rgb("diffuse_reflectance", "0.7, 0.3, 0.1")
                                       + number("int_ior", 1.9)
                                       + '        <boolean name="nonlinear" value="true"/>\n')
                              + THINGS + BACKLIT),
        "twosided": ("A sheet with a face and a back",
                     card('        <bsdf type="twosided">\n            <bsdf type="diffuse">\n'
                          '                <rgb name="reflectance" value="0.8, 0.1, 0.1"/>\n'
                          '            </bsdf>\n            <bsdf type="roughconductor">\n'
                          '                <float name="alpha" value="0.3"/>\n'
                          '            </bsdf>\n        </bsdf>\n')
                     + card('        <bsdf type="twosided">\n            <bsdf type="diffuse">\n'
                            '                <rgb name="reflectance" value="0.8, 0.1, 0.1"/>\n'
                            '            </bsdf>\n            <bsdf type="diffuse">\n'
                            '                <rgb name="reflectance" value="0.1, 0.7, 0.2"/>\n'
                            '            </bsdf>\n        </bsdf>\n')
                     .replace('"card"', '"back_card"').replace('angle="20"', 'angle="215"')
                     .replace('<translate y="0.8"/>', '<translate x="0.6" y="0.8" z="-0.7"/>')
                     + BACKLIT),
        "mask": ("A sheet with holes, one half there elsewhere",
                 card('        <bsdf type="mask">\n'
                      + bitmap("opacity", "textures/holes.png", NUMBERS)
                      + '            <bsdf type="twosided">\n                <bsdf type="diffuse">\n'
                      '                    <rgb name="reflectance" value="0.8, 0.6, 0.1"/>\n'
                      '                </bsdf>\n            </bsdf>\n        </bsdf>\n')
                 + """
    <shape type="rectangle" id="veil">
        <transform name="to_world">
            <scale x="0.5" y="0.5"/>
            <translate x="0.9" y="0.5" z="0.9"/>
        </transform>
        <bsdf type="mask">
            <float name="opacity" value="0.4"/>
            <bsdf type="twosided">
                <bsdf type="diffuse"/>
            </bsdf>
        </bsdf>
    </shape>
""" + BACKLIT),
        "bitmap": ("A picture on a card and on a ball, as 8-bit sRGB",
                   material("diffuse", bitmap("reflectance", "textures/picture.png")) + BALL
                   + card("        <bsdf type=\"twosided\">\n        <bsdf type=\"diffuse\">\n"
                          + bitmap("reflectance", "textures/picture.png",
                                   '            <string name="filter_type" value="nearest"/>\n')
                          + "        </bsdf>\n        </bsdf>\n")
                   .replace('<translate y="0.8"/>', '<translate x="-0.7" y="0.8" z="-0.8"/>')
                   + BACKLIT),
        "bitmap_wrap": ("Repeated, mirrored and clamped pictures, one read as plain numbers",
                        "".join(
                            card("        <bsdf type=\"diffuse\">\n"
                                 + bitmap("reflectance", "textures/picture.png",
                                          f'            <string name="wrap_mode" value="{mode}"/>\n'
                                          + extra,
                                          '<scale x="2.5" y="2.5"/>\n                '
                                          '<rotate z="1" angle="20"/>\n                '
                                          '<translate x="-0.3" y="0.2"/>')
                                 + "        </bsdf>\n")
                            .replace('"card"', f'"{mode}"').replace('value="0.75"', 'value="0.45"')
                            .replace('<translate y="0.8"/>', f'<translate x="{x}" y="0.8"/>')
                            for mode, extra, x in (
                                ("repeat", "", -0.95), ("mirror", "", 0),
                                ("clamp", '            <boolean name="raw" value="true"/>\n', 0.95)))
                        + BACKLIT),
        "checkerboard": ("Checkerboards on a ball and a box",
                         material("diffuse", CHECKER.format(name="reflectance", a="0.8, 0.7, 0.1",
                                                            b="0.1, 0.2, 0.6", x=8, y=5))
                         + THINGS + BACKLIT),
        "rough_texture": ("Roughness and tint from textures",
                          material("roughconductor", text("distribution", "ggx")
                                   + bitmap("alpha", "textures/ramp.png", NUMBERS)
                                   + CHECKER.format(name="specular_reflectance", a="0.9, 0.9, 0.9",
                                                    b="0.9, 0.5, 0.2", x=6, y=6) + GOLD) + THINGS
                          + BACKLIT),
        "area": ("Area lights: a ball, a disk, a box, one with a picture",
                 FLOOR + """
    <shape type="sphere" id="ball">
        <point name="center" x="-0.8" y="0.35" z="0.4"/>
        <float name="radius" value="0.35"/>
        <emitter type="area">
            <rgb name="radiance" value="4, 2, 1"/>
        </emitter>
    </shape>
    <shape type="disk" id="disk">
        <transform name="to_world">
            <scale x="0.5" y="0.3"/>
            <rotate x="1" angle="50"/>
            <translate x="0.1" y="1.6" z="-0.6"/>
        </transform>
        <emitter type="area">
            <rgb name="radiance" value="1, 3, 5"/>
        </emitter>
    </shape>
    <shape type="cube" id="box">
        <transform name="to_world">
            <scale x="0.15" y="0.3" z="0.15"/>
            <translate x="0.5" y="0.3" z="0.5"/>
        </transform>
        <emitter type="area">
            <rgb name="radiance" value="1, 2, 1"/>
        </emitter>
    </shape>
    <shape type="rectangle" id="screen">
        <transform name="to_world">
            <scale x="0.5" y="0.4"/>
            <rotate y="1" angle="-40"/>
            <translate x="1.1" y="0.9" z="-0.5"/>
        </transform>
        <emitter type="area">
            <texture type="bitmap" name="radiance">
                <string name="filename" value="textures/picture.png"/>
            </texture>
        </emitter>
    </shape>
"""),
        "constant": ("Light from everywhere",
                     material("plastic") + THINGS + FLOOR + """
    <emitter type="constant">
        <rgb name="radiance" value="0.8, 0.9, 1.1"/>
    </emitter>
"""),
        "envmap": ("Light from a picture all around, turned",
                   material("roughconductor", number("alpha", 0.1) + GOLD) + THINGS + FLOOR + """
    <emitter type="envmap">
        <string name="filename" value="textures/sky.exr"/>
        <float name="scale" value="1.5"/>
        <transform name="to_world">
            <rotate y="1" angle="70"/>
        </transform>
    </emitter>
"""),
        "point": ("Two point lights", material("diffuse") + THINGS + FLOOR + """
    <emitter type="point">
        <point name="position" x="-1" y="2.5" z="2"/>
        <rgb name="intensity" value="12, 10, 8"/>
    </emitter>
    <emitter type="point">
        <transform name="to_world">
            <translate x="1.5" y="1" z="1"/>
        </transform>
        <rgb name="intensity" value="0.5, 1, 2"/>
    </emitter>
"""),
        "sphere": ("Spheres: by centre and radius, by a transform, turned inside out",
                   material("diffuse", CHECKER.format(name="reflectance", a="0.9, 0.9, 0.9",
                                                      b="0.2, 0.2, 0.7", x=10, y=6)) + """
    <shape type="sphere">
        <point name="center" x="-0.9" y="0.4" z="0.3"/>
        <float name="radius" value="0.4"/>
        <ref id="material"/>
    </shape>
    <shape type="sphere">
        <transform name="to_world">
            <rotate x="1" angle="60"/>
            <scale value="0.5"/>
            <translate x="0.1" y="0.5" z="-0.2"/>
        </transform>
        <ref id="material"/>
    </shape>
    <shape type="sphere">
        <boolean name="flip_normals" value="true"/>
        <point name="center" x="1" y="0.35" z="0.4"/>
        <float name="radius" value="0.35"/>
        <bsdf type="twosided">
            <ref id="material"/>
        </bsdf>
    </shape>
""" + BACKLIT),
        "disk": ("Disks, one an ellipse",
                 card('        <bsdf type="diffuse">\n'
                      + CHECKER.format(name="reflectance", a="0.9, 0.4, 0.1", b="0.2, 0.2, 0.2",
                                       x=4, y=8)
                      + '        </bsdf>\n', "disk") + """
    <shape type="disk">
        <transform name="to_world">
            <scale x="0.7" y="0.3"/>
            <rotate x="1" angle="-90"/>
            <translate x="0.6" y="0.02" z="0.8"/>
        </transform>
        <bsdf type="diffuse">
            <rgb name="reflectance" value="0.1, 0.6, 0.6"/>
        </bsdf>
    </shape>
""" + BACKLIT),
        "cylinder": ("Cylinders: a standing one, a leaning one turned inside out, a shining one",
                     material("diffuse", CHECKER.format(name="reflectance", a="0.9, 0.7, 0.3",
                                                        b="0.2, 0.3, 0.6", x=8, y=4)) + """
    <shape type="cylinder">
        <point name="p0" x="-0.9" y="0" z="0.2"/>
        <point name="p1" x="-0.8" y="1" z="0.3"/>
        <float name="radius" value="0.35"/>
        <bsdf type="twosided">
            <ref id="material"/>
        </bsdf>
    </shape>
    <shape type="cylinder">
        <boolean name="flip_normals" value="true"/>
        <transform name="to_world">
            <scale x="0.4" y="-0.4" z="0.9"/>
            <rotate x="1" angle="-60"/>
            <translate x="0.8" y="0.2" z="0.4"/>
        </transform>
        <bsdf type="twosided">
            <ref id="material"/>
        </bsdf>
    </shape>
    <shape type="cylinder" id="tube">
        <point name="p0" x="-0.3" y="1.3" z="-0.6"/>
        <point name="p1" x="1.1" y="1.6" z="-0.8"/>
        <float name="radius" value="0.06"/>
        <emitter type="area">
            <rgb name="radiance" value="5, 9, 12"/>
        </emitter>
    </shape>
""" + BACKLIT),
        "cube": ("Boxes, one sheared and mirrored",
                 material("diffuse", CHECKER.format(name="reflectance", a="0.8, 0.8, 0.8",
                                                    b="0.6, 0.1, 0.1", x=2, y=4)) + """
    <shape type="cube">
        <transform name="to_world">
            <scale x="0.4" y="0.5" z="0.3"/>
            <rotate y="1" angle="40"/>
            <translate x="-0.7" y="0.5"/>
        </transform>
        <ref id="material"/>
    </shape>
    <shape type="cube">
        <transform name="to_world">
            <matrix value="-0.4 0.1 0 0.7 0 0.4 0 0.4 0.1 0 0.4 0.2 0 0 0 1"/>
        </transform>
        <ref id="material"/>
    </shape>
""" + BACKLIT),
        "ply_ascii": ("A PLY mesh as text", mesh("ply", "meshes/gem.ply") + BACKLIT),
        "ply_binary": ("A binary PLY mesh with normals and texture coordinates",
                       mesh("ply", "meshes/wave.ply").replace(
                           '                <rgb name="reflectance" value="0.7, 0.4, 0.2"/>\n',
                           CHECKER.format(name="reflectance", a="0.7, 0.4, 0.2", b="0.2, 0.4, 0.7",
                                          x=6, y=6)) + BACKLIT),
        "ply_face_normals": ("A smooth mesh seen as flat faces",
                             mesh("ply", "meshes/wave.ply",
                                  '        <boolean name="face_normals" value="true"/>\n')
                             + BACKLIT),
        "obj": ("An OBJ mesh with polygons and normals", mesh("obj", "meshes/house.obj") + BACKLIT),
        "instance": ("A shapegroup placed three times", """
    <shape type="shapegroup" id="pair">
        <shape type="sphere">
            <float name="radius" value="0.25"/>
            <bsdf type="roughconductor">
                <float name="alpha" value="0.2"/>
            </bsdf>
        </shape>
        <shape type="cube">
            <transform name="to_world">
                <scale x="0.3" y="0.05" z="0.3"/>
                <translate y="-0.3"/>
            </transform>
            <bsdf type="diffuse">
                <rgb name="reflectance" value="0.7, 0.2, 0.3"/>
            </bsdf>
        </shape>
    </shape>
    <shape type="instance">
        <ref id="pair"/>
        <transform name="to_world">
            <translate x="-0.8" y="0.35"/>
        </transform>
    </shape>
    <shape type="instance">
        <ref id="pair"/>
        <transform name="to_world">
            <scale x="1.4" y="1.4" z="1.4"/>
            <rotate z="1" angle="20"/>
            <translate x="0.15" y="0.6" z="-0.3"/>
        </transform>
    </shape>
    <shape type="instance">
        <ref id="pair"/>
        <transform name="to_world">
            <scale value="0.8"/>
            <rotate y="1" angle="45"/>
            <translate x="0.95" y="0.25" z="0.4"/>
        </transform>
    </shape>
""" + BACKLIT),
        "defaults": ("Values by name and a constant spectrum",
                     '\n    <default name="shade" value="0.6"/>\n'
                     '    <default name="radius" value="0.5"/>\n'
                     + material("diffuse", '        <spectrum name="reflectance" '
                                           'value="$shade"/>\n')
                     + BALL.replace('"0.65"/>\n        <ref', '"$radius"/>\n        <ref')
                     + BACKLIT),
        "filter_gaussian": ("The Gaussian pixel filter",
                            material("diffuse", CHECKER.format(name="reflectance", a="0.9, 0.9, 0.9",
                                                               b="0, 0, 0", x=20, y=12))
                            + THINGS + BACKLIT, 4, '<rfilter type="gaussian"/>'),
        "filter_box": ("The box pixel filter",
                       material("diffuse", CHECKER.format(name="reflectance", a="0.9, 0.9, 0.9",
                                                          b="0, 0, 0", x=20, y=12))
                       + THINGS + BACKLIT, 4, '<rfilter type="box"/>'),
    }
    plain.update(tests_formats.scenes(sys.modules[__name__]))
    plain.update(tests_lights.scenes(sys.modules[__name__]))
    plain |= tests_materials.scenes(sys.modules[__name__])
    plain.update(tests_pictures.scenes(sys.modules[__name__]))
    plain |= {"ours/" + name: entry
              for name, entry in tests_pictures.own_scenes(sys.modules[__name__]).items()}
    plain |= {"ours/" + name: (what, body.replace('value="textures/', 'value="../textures/'))
              for name, (what, body)
              in tests_materials.own_scenes(sys.modules[__name__]).items()}
    for name, entry in plain.items():
        what, body, depth, rfilter = (*entry, 6, TENT)[:4] if len(entry) == 2 else entry
        yield name, HEAD.format(what=what, depth=depth, rfilter=rfilter) + body + "</scene>\n"
    yield from tests_formats.whole_scenes().items()
    yield from tests_lights.sensor_scenes(sys.modules[__name__])


# ---- Pictures ----------------------------------------------------------------------------------

def write_png(path, width, height, pixels, channels):
    rows = b"".join(b"\0" + bytes(pixels[y * width * channels:(y + 1) * width * channels])
                    for y in range(height))

    def chunk(kind, data):
        return (struct.pack(">I", len(data)) + kind + data
                + struct.pack(">I", zlib.crc32(kind + data)))

    header = struct.pack(">2I5B", width, height, 8, 2 if channels == 3 else 0, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header)
                     + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


def picture(n=24):
    """A flag with a disk and a corner mark, so that turns and mirrors show."""
    out = []
    for y in range(n):
        for x in range(n):
            r = math.hypot(x - 0.55 * n, y - 0.6 * n) / n
            if r < 0.25:
                out += [220, 60 + int(400 * r), 30]
            elif x < n // 4 and y < n // 4:
                out += [250, 250, 250]
            else:
                out += [30 + 6 * x, 40 + 5 * y, 120]
    return out


def write_exr(path, width, height, rgb_at):
    """Scan lines of floats, uncompressed."""
    def attribute(name, kind, data):
        return name + b"\0" + kind + b"\0" + struct.pack("<I", len(data)) + data

    channels = b"".join(c + b"\0" + struct.pack("<I4B2I", 2, 0, 0, 0, 0, 1, 1)
                        for c in (b"B", b"G", b"R")) + b"\0"
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = (struct.pack("<2I", 20000630, 2) + attribute(b"channels", b"chlist", channels)
              + attribute(b"compression", b"compression", b"\0")
              + attribute(b"dataWindow", b"box2i", box)
              + attribute(b"displayWindow", b"box2i", box)
              + attribute(b"lineOrder", b"lineOrder", b"\0")
              + attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1))
              + attribute(b"screenWindowCenter", b"v2f", struct.pack("<2f", 0, 0))
              + attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1)) + b"\0")
    size = 3 * 4 * width
    offsets = struct.pack(f"<{height}Q", *(len(header) + 8 * height + y * (size + 8)
                                           for y in range(height)))
    lines = b""
    for y in range(height):
        colors = [rgb_at(x, y) for x in range(width)]
        lines += struct.pack("<2i", y, size) + b"".join(
            struct.pack(f"<{width}f", *(c[k] for c in colors)) for k in (2, 1, 0))
    path.write_bytes(header + offsets + lines)


def sky(x, y, width=48, height=24):
    """Blue above, brown below, a sun and a lamp."""
    up = 1 - (y + 0.5) / height
    base = (0.3, 0.45, 0.8 * up + 0.2) if up > 0.5 else (0.25, 0.2, 0.15)
    if abs(x - 0.3 * width) < 1.5 and abs(y - 0.25 * height) < 1.5:
        return (40.0, 34.0, 24.0)
    if abs(x - 0.8 * width) < 3 and abs(y - 0.4 * height) < 2:
        return (2.0, 4.0, 6.0)
    return base


# ---- Meshes ------------------------------------------------------------------------------------

def write_gem(path):
    """A prism of eight sides with a pointed top, without normals."""
    n = 8
    ring = [(math.cos(2 * math.pi * i / n), math.sin(2 * math.pi * i / n)) for i in range(n)]
    vertices = ([(0.6 * c, -1.0, 0.6 * s) for c, s in ring] + [(c, 0.2, s) for c, s in ring]
                + [(0.0, 1.0, 0.0)])
    faces = [(i, i + n, (i + 1) % n + n) for i in range(n)]
    faces += [(i, (i + 1) % n + n, (i + 1) % n) for i in range(n)]
    faces += [(i + n, 2 * n, (i + 1) % n + n) for i in range(n)]
    lines = ["ply", "format ascii 1.0", "comment made by scripts/scenes/make_tests.py, CC0",
             f"element vertex {len(vertices)}", "property float x", "property float y",
             "property float z", f"element face {len(faces)}",
             "property list uchar int vertex_indices", "end_header"]
    lines += [" ".join(f"{c:.6f}" for c in v) for v in vertices]
    lines += [" ".join(map(str, (len(f), *f))) for f in faces]
    path.write_text("\n".join(lines) + "\n")


def write_wave(path, n=13):
    """A sheet with a wave in it, with normals and texture coordinates."""
    rows = []
    for i in range(n):
        for j in range(n):
            u, v = i / (n - 1), j / (n - 1)
            x, y = 2 * u - 1, 2 * v - 1
            z = 0.35 * math.cos(4 * x) * math.cos(3 * y)
            dx = -0.35 * 4 * math.sin(4 * x) * math.cos(3 * y)
            dy = -0.35 * 3 * math.cos(4 * x) * math.sin(3 * y)
            length = math.sqrt(dx * dx + dy * dy + 1)
            rows.append((x, y, z, -dx / length, -dy / length, 1 / length, u, v))
    faces = []
    for i in range(n - 1):
        for j in range(n - 1):
            a, b = i * n + j, (i + 1) * n + j
            faces += [(a, b, b + 1), (a, b + 1, a + 1)]
    names = ("x", "y", "z", "nx", "ny", "nz", "u", "v")
    header = ("ply\nformat binary_little_endian 1.0\n"
              "comment made by scripts/scenes/make_tests.py, CC0\n"
              f"element vertex {len(rows)}\n" + "".join(f"property float {c}\n" for c in names)
              + f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")
    path.write_bytes(header.encode() + b"".join(struct.pack("<8f", *r) for r in rows)
                     + b"".join(struct.pack("<B3i", 3, *f) for f in faces))


HOUSE = """# made by scripts/scenes/make_tests.py, CC0
o house
v -0.8 -1 -0.6
v 0.8 -1 -0.6
v 0.8 -1 0.6
v -0.8 -1 0.6
v -0.8 0.2 -0.6
v 0.8 0.2 -0.6
v 0.8 0.2 0.6
v -0.8 0.2 0.6
v -0.8 1 0
v 0.8 1 0
vn 0 0 1
vn 0 0 -1
vn -1 0 0
vn 1 0 0
vn 0 0.6 0.8
vn 0 0.6 -0.8
s off
f 4//1 3//1 7//1 8//1
f 2//2 1//2 5//2 6//2
f 1//3 4//3 8//3 9//3 5//3
f 3//4 2//4 6//4 10//4 7//4
f 8//5 7//5 10//5 9//5
f 6//6 5//6 9//6 10//6
"""


def main():
    root = pathlib.Path(__file__).resolve().parents[2]
    folder = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else root / "scenes/tests"
    for sub in ("textures", "meshes", "ours"):
        (folder / sub).mkdir(parents=True, exist_ok=True)
    write_png(folder / "textures/picture.png", 24, 24, picture(), 3)
    write_png(folder / "textures/ramp.png", 32, 4, [20 + 4 * x for x in range(32)] * 4, 1)
    write_png(folder / "textures/holes.png", 16, 16,
              [255 if (x // 4 + y // 4) % 2 else 80 for y in range(16) for x in range(16)], 1)
    write_png(folder / "textures/bumps.png", 32, 32, tests_materials.bumps(), 1)
    write_png(folder / "textures/normals.png", 32, 32, tests_materials.normals(), 3)
    write_exr(folder / "textures/sky.exr", 48, 24, sky)
    write_gem(folder / "meshes/gem.ply")
    write_wave(folder / "meshes/wave.ply")
    (folder / "meshes/house.obj").write_text(HOUSE)
    tests_formats.write_files(sys.modules[__name__], folder)
    tests_pictures.write_files(sys.modules[__name__], folder)
    for name, xml in scenes():
        (folder / f"{name}.xml").write_text(xml)
    print(f"{folder}: {len(list(folder.rglob('*.xml')))} scenes")


if __name__ == "__main__":
    main()
