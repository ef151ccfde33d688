# SPDX-License-Identifier: Apache-2.0
"""Test scenes of lights, sensors and films: scenes(m) for make_tests.py, whose pieces m has."""

SPOT = """
    <emitter type="spot">
        <transform name="to_world">
            <lookat origin="-1.6, 2.6, 1.8" target="-0.4, 0.4, 0" up="0, 1, 0"/>
        </transform>
        <rgb name="intensity" value="40, 32, 24"/>
        <float name="cutoff_angle" value="22"/>
        <float name="beam_width" value="9"/>
    </emitter>
    <emitter type="spot">
        <transform name="to_world">
            <lookat origin="1.5, 2.2, 2.4" target="0.5, 0.5, -0.6" up="0, 1, 0"/>
        </transform>
        <float name="cutoff_angle" value="30"/>
        <rgb name="intensity" value="25, 25, 25"/>
        <texture type="bitmap" name="texture">
            <string name="filename" value="textures/picture.png"/>
        </texture>
    </emitter>
"""

DIRECTIONAL = """
    <emitter type="directional">
        <vector name="direction" x="0.5" y="-1" z="-0.7"/>
        <rgb name="irradiance" value="2, 1.6, 1.2"/>
    </emitter>
    <emitter type="directional">
        <transform name="to_world">
            <rotate x="1" angle="60"/>
            <rotate y="1" angle="-120"/>
        </transform>
        <rgb name="irradiance" value="0.3, 0.5, 0.9"/>
    </emitter>
"""

PROJECTOR = """
    <emitter type="projector">
        <transform name="to_world">
            <lookat origin="-0.8, 1.6, 3" target="0, 0.7, -0.5" up="0.1, 1, 0"/>
        </transform>
        <texture type="bitmap" name="irradiance">
            <string name="filename" value="textures/sky.exr"/>
            <boolean name="raw" value="true"/>
        </texture>
        <float name="scale" value="3"/>
        <float name="fov" value="34"/>
        <string name="fov_axis" value="y"/>
    </emitter>
    <emitter type="projector">
        <transform name="to_world">
            <lookat origin="1.5, 2.5, 2" target="0.6, 0, 0.4" up="0, 1, 0"/>
        </transform>
        <texture type="checkerboard" name="irradiance">
            <rgb name="color0" value="1, 0.5, 0.2"/>
            <rgb name="color1" value="0.2, 0.5, 1"/>
            <transform name="to_uv">
                <scale x="3" y="3"/>
            </transform>
        </texture>
        <string name="focal_length" value="60mm"/>
    </emitter>
"""


def glowing(kind, where, texture, extra=""):
    return f"""
    <shape type="{kind}">
{extra}        <transform name="to_world">
            {where}
        </transform>
        <emitter type="area">
{texture}        </emitter>
    </shape>
"""


def scenes(m):
    """name -> (what it shows, body)"""
    checker = m.CHECKER.format(name="radiance", a="1, 0.4, 0.1", b="0.1, 0.3, 0.9", x=4, y=3)
    picture = m.bitmap("radiance", "textures/picture.png")
    things = m.material("diffuse") + m.THINGS + m.FLOOR
    return {
        "spot": ("Two spots, one through a picture", things + SPOT),
        "directional": ("Light from two directions", things + DIRECTIONAL),
        "projector": ("Two projectors", things + PROJECTOR),
        "area_texture": ("Textured area lights: a sphere, a disk, a card, a mesh",
                         m.FLOOR
                         + glowing("sphere", '<scale value="0.4"/>\n            '
                                   '<rotate x="1" angle="70"/>\n            '
                                   '<translate x="-0.8" y="0.5" z="0.3"/>', checker)
                         + glowing("disk", '<scale x="0.5" y="0.4"/>\n            '
                                   '<rotate x="1" angle="40"/>\n            '
                                   '<translate x="0.1" y="1.4" z="-0.6"/>', checker)
                         + glowing("rectangle", '<scale value="0.25"/>\n            '
                                   '<rotate y="1" angle="30"/>\n            '
                                   '<translate x="0.3" y="0.3" z="0.7"/>', picture)
                         + glowing("ply", '<scale x="0.5" y="0.5" z="0.4"/>\n            '
                                   '<rotate y="1" angle="-30"/>\n            '
                                   '<translate x="1.05" y="0.6" z="-0.4"/>', checker,
                                   '        <string name="filename" value="meshes/wave.ply"/>\n'
                                   '        <boolean name="face_normals" value="true"/>\n')),
    }
