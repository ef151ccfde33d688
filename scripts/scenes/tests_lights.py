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


SUNSKY = """
    <emitter type="sunsky">
        <vector name="sun_direction" x="0.5" y="0.6" z="0.6"/>
        <float name="turbidity" value="2.5"/>
        <transform name="to_world">
            <rotate x="1" angle="-90"/>
        </transform>
    </emitter>
"""


def glowing(kind, where, texture, extra="", emitter="area"):
    return f"""
    <shape type="{kind}">
{extra}        <transform name="to_world">
            {where}
        </transform>
        <emitter type="{emitter}">
{texture}        </emitter>
    </shape>
"""


SENSORS = {
    "thinlens": ("A camera with a lens, out of focus behind and before", "thinlens", """
        <float name="fov" value="32"/>
        <float name="aperture_radius" value="0.15"/>
        <float name="focus_distance" value="3.8"/>""", "", ""),
    "orthographic": ("A camera without perspective", "orthographic", "",
                     """
            <scale x="1.6" y="1.3"/>""", ""),
    "principal_point": ("A camera that looks aside, and mirrored", "perspective", """
        <float name="fov" value="30"/>
        <string name="fov_axis" value="larger"/>
        <float name="principal_point_offset_x" value="0.15"/>
        <float name="principal_point_offset_y" value="-0.1"/>""", """
            <scale x="-1"/>""", ""),
    "near_far": ("Near and far planes that cut, by focal length", "perspective", """
        <string name="focal_length" value="70mm"/>
        <float name="near_clip" value="4.1"/>
        <float name="far_clip" value="4.9"/>""", "", ""),
    "crop": ("A part of the film", "perspective", """
        <float name="fov" value="50"/>""", "", """
            <integer name="crop_offset_x" value="40"/>
            <integer name="crop_offset_y" value="56"/>
            <integer name="crop_width" value="64"/>
            <integer name="crop_height" value="64"/>"""),
}


def with_sensor(head, kind, values, scale, film):
    """The common head of test scenes with another sensor."""
    head = head.replace('<sensor type="perspective">\n        <float name="fov" value="32"/>',
                        f'<sensor type="{kind}">{values}'.rstrip())
    head = head.replace('<transform name="to_world">', f'<transform name="to_world">{scale}', 1)
    return head.replace('<film type="hdrfilm">', f'<film type="hdrfilm">{film}')


def sensor_scenes(m):
    """name -> the whole document"""
    grid = m.material("diffuse", m.CHECKER.format(name="reflectance", a="0.8, 0.6, 0.2",
                                                  b="0.1, 0.2, 0.5", x=8, y=6))
    for name, (what, *sensor) in SENSORS.items():
        head = with_sensor(m.HEAD.format(what=what, depth=4, rfilter=m.TENT), *sensor)
        yield name, head + grid + m.THINGS + m.BACKLIT + "</scene>\n"


def scenes(m):
    """name -> (what it shows, body)"""
    checker = m.CHECKER.format(name="radiance", a="1, 0.4, 0.1", b="0.1, 0.3, 0.9", x=4, y=3)
    picture = m.bitmap("radiance", "textures/picture.png")
    things = m.material("diffuse") + m.THINGS + m.FLOOR
    return {
        "directionalarea": ("Surfaces that shine along their normals: a card, a disk, a sphere",
                            things
                            + glowing("rectangle", '<scale x="0.5" y="0.8"/>\n            '
                                      '<rotate x="1" angle="70"/>\n            '
                                      '<translate x="-0.3" y="3" z="-0.6"/>', picture,
                                      emitter="directionalarea")
                            + glowing("disk", '<scale x="0.3" y="0.5"/>\n            '
                                      '<rotate x="1" angle="150"/>\n            '
                                      '<translate x="1.3" y="2.3" z="1.6"/>', picture,
                                      emitter="directionalarea")
                            + glowing("sphere", '<scale value="0.2"/>\n            '
                                      '<translate x="0.2" y="1.4" z="0.6"/>',
                                      m.rgb("radiance", "2, 4, 6").replace("  <", "      <"),
                                      emitter="directionalarea")),
        "spot": ("Two spots, one through a picture", things + SPOT),
        "directional": ("Light from two directions", things + DIRECTIONAL),
        "sunsky": ("The sun in a clear sky", things + SUNSKY),
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
