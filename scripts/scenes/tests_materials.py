# SPDX-License-Identifier: Apache-2.0
"""Scenes of make_tests.py about materials beyond the basic ones, and their textures."""
import math

RAW = '            <boolean name="raw" value="true"/>\n'


def nested(kind, body=""):
    return f'        <bsdf type="{kind}">\n{body}        </bsdf>\n'


def scenes(t):
    """name -> (what it shows, body); t: the module make_tests."""
    def about(kind, body, things=t.THINGS):
        return t.material(kind, body) + things + t.BACKLIT

    def flag(name, value):
        return f'        <boolean name="{name}" value="{value}"/>\n'

    glossy = t.text("distribution", "ggx")
    return {
        "roughplastic_beckmann": (
            "Rough plastic, Beckmann",
            about("roughplastic", t.rgb("diffuse_reflectance", "0.1, 0.4, 0.2"))),
        "roughplastic_ggx": (
            "Rough plastic, GGX, that shifts its colour",
            about("roughplastic", glossy + t.number("alpha", 0.3) + t.number("int_ior", 1.9)
                  + t.rgb("diffuse_reflectance", "0.8, 0.4, 0.1")
                  + t.rgb("specular_reflectance", "0.9, 1, 0.7") + flag("nonlinear", "true"))),
        "roughplastic_texture": (
            "Rough plastic with a picture, nearly smooth",
            about("roughplastic", t.number("alpha", 0.04)
                  + t.bitmap("diffuse_reflectance", "textures/picture.png"))),
        "thindielectric": (
            "Thin glass of two tints",
            about("thindielectric", t.number("int_ior", 1.7)
                  + t.rgb("specular_reflectance", "1, 0.8, 0.7")
                  + t.rgb("specular_transmittance", "0.7, 0.9, 0.8"))),
        "null": ("A ball and a box that are not there", about("null", "")),
        "blendbsdf": (
            "Metal and paint by a picture",
            about("blendbsdf", t.bitmap("weight", "textures/holes.png", RAW)
                  + nested("roughconductor", t.number("alpha", 0.15) + t.GOLD)
                  + nested("diffuse", t.rgb("reflectance", "0.2, 0.5, 0.7")))),
        # Without mirrors and glass, where Mitsuba 3.9's samples do not fit its values: it adds the
        # density of one part to the probability of a mirror direction of the other, and looks at
        # one part in the direction that the other failed to give.
        "blendbsdf_nested": (
            "A blend of a blend and of rough plastic",
            about("blendbsdf", t.number("weight", 0.3)
                  + nested("blendbsdf", t.number("weight", 0.6)
                           + nested("roughconductor", glossy + t.number("alpha", 0.3))
                           + nested("diffuse", t.rgb("reflectance", "0.8, 0.5, 0.2")))
                  + nested("roughplastic", t.number("alpha", 0.2)))),
        "bumpmap": (
            "Bumps on paint",
            about("bumpmap", t.number("scale", 0.4)
                  + t.bitmap("height", "textures/bumps.png", RAW)
                  + nested("diffuse", t.rgb("reflectance", "0.7, 0.6, 0.5")))),
        "bumpmap_metal": (
            "Deep bumps on metal from both sides, repeated, as Mitsuba had them before 3.7",
            about("twosided", nested(
                "bumpmap", t.number("scale", 0.15) + flag("flip_invalid_normals", "false")
                + flag("use_shadowing_function", "false")
                + t.bitmap("height", "textures/bumps.png", RAW, '<scale x="2" y="3"/>')
                + nested("roughconductor", glossy + t.number("alpha", 0.2) + t.GOLD)))),
        "normalmap": (
            "Rough plastic under a normal map",
            about("normalmap", t.bitmap("normalmap", "textures/normals.png", RAW)
                  + nested("roughplastic", t.number("alpha", 0.2)))),
        "normalmap_mirror": (
            "A mirror under a normal map, as Mitsuba had it before 3.7",
            about("normalmap", t.bitmap("normalmap", "textures/normals.png", RAW)
                  + flag("flip_invalid_normals", "false")
                  + flag("use_shadowing_function", "false")
                  + nested("conductor", t.GOLD))),
        "normalmap_anisotropic": (
            "Brushed metal under a normal map",
            about("normalmap", t.bitmap("normalmap", "textures/normals.png", RAW)
                  + nested("roughconductor", glossy + t.number("alpha_u", 0.06)
                           + t.number("alpha_v", 0.4) + t.GOLD))),
        # Not anisotropic: Mitsuba 3.9's bumpmap makes its tangent of the local normal and dp/du in
        # world space, so that the look depends on how the scene is turned (later versions do not).
        "bumpmap_mesh": (
            "Bumps on metal, on a smooth mesh that is stretched by an instance",
            t.material("twosided", nested(
                "bumpmap", t.number("scale", 0.1) + t.bitmap("height", "textures/bumps.png", RAW)
                + nested("roughconductor", glossy + t.number("alpha", 0.2) + t.GOLD))) + """
    <shape type="shapegroup" id="sheet">
        <shape type="ply">
            <string name="filename" value="meshes/wave.ply"/>
            <ref id="material"/>
        </shape>
    </shape>
    <shape type="instance">
        <ref id="sheet"/>
        <transform name="to_world">
            <scale x="1.1" y="0.6" z="0.5"/>
            <rotate y="1" angle="25"/>
            <translate y="0.7"/>
        </transform>
    </shape>
""" + t.BACKLIT),
        "roughdielectric_anisotropic": (
            "Rough glass, rougher along u",
            about("roughdielectric", glossy + t.number("alpha_u", 0.4) + t.number("alpha_v", 0.1)
                  + t.GLASS)),
        "principled": (
            "The principled material: paint with a clear coat and sheen",
            about("principled", t.rgb("base_color", "0.8, 0.3, 0.2") + t.number("roughness", 0.4)
                  + t.number("specular", 0.7) + t.number("spec_tint", 0.5)
                  + t.number("sheen", 0.6) + t.number("sheen_tint", 0.4)
                  + t.number("flatness", 0.3) + t.number("clearcoat", 0.8)
                  + t.number("clearcoat_gloss", 0.3))),
        "principled_default": ("The principled material as it comes", about("principled", "")),
        "principled_metal": (
            "The principled material: brushed metal, in part paint",
            about("principled", t.rgb("base_color", "0.9, 0.7, 0.3")
                  + t.bitmap("metallic", "textures/holes.png", RAW)
                  + t.number("anisotropic", 0.8) + t.bitmap("roughness", "textures/ramp.png", RAW))),
        "principled_glass": (
            "The principled material: rough glass, in part opaque",
            about("principled", t.rgb("base_color", "0.6, 0.9, 0.8") + t.number("spec_trans", 0.8)
                  + t.number("eta", 1.5) + t.number("roughness", 0.45)
                  + t.number("spec_tint", 0.3))),
        "rough_texture_anisotropic": (
            "Roughness along u and v from pictures",
            about("roughconductor", t.bitmap("alpha_u", "textures/ramp.png", RAW)
                  + t.bitmap("alpha_v", "textures/holes.png", RAW) + t.GOLD)),
        "rough_texture_glass": (
            "Rough glass with roughness from a picture",
            about("roughdielectric", glossy + t.bitmap("alpha", "textures/ramp.png", RAW)
                  + t.GLASS)),
    }


def own_scenes(t):
    """The same for plugins that Mitsuba 3 has not: Mitsuba 0.x had them."""
    def about(kind, body):
        return t.material(kind, body) + t.THINGS + t.BACKLIT

    return {
        "roughdiffuse": ("Oren and Nayar's rough surface",
                         about("roughdiffuse", t.rgb("reflectance", "0.8, 0.6, 0.4")
                               + t.number("alpha", 0.5))),
        "phong": ("Phong's glossy surface",
                  about("phong", t.number("exponent", 40)
                        + t.rgb("diffuse_reflectance", "0.3, 0.2, 0.1")
                        + t.rgb("specular_reflectance", "0.4, 0.5, 0.6"))),
        "blinnphong": ("Blinn's glossy surface",
                       about("blinnphong", t.number("exponent", 60)
                             + t.rgb("diffuse_reflectance", "0.1, 0.3, 0.2")
                             + t.rgb("specular_reflectance", "0.5, 0.4, 0.3"))),
        "mixturebsdf": ("Three materials by weight, and a tenth of nothing",
                        about("mixturebsdf", t.text("weights", "0.4, 0.3, 0.2")
                              + nested("diffuse", t.rgb("reflectance", "0.9, 0.4, 0.1"))
                              + nested("conductor", t.GOLD)
                              + nested("roughplastic", t.number("alpha", 0.2)))),
        "blendbsdf_delta": (
            "A blend of a blend and of something half there",
            about("blendbsdf", t.number("weight", 0.3)
                  + nested("blendbsdf", t.number("weight", 0.6)
                           + nested("dielectric", t.GLASS)
                           + nested("diffuse", t.rgb("reflectance", "0.8, 0.5, 0.2")))
                  + nested("mask", t.number("opacity", 0.5) + nested("diffuse")))),
        "roughplastic_alpha": ("Rough plastic with roughness from a picture",
                               about("roughplastic", t.bitmap("alpha", "textures/ramp.png", RAW))),
    }


def bumps(n=32):
    """A smooth height that repeats, as 8-bit numbers."""
    out = []
    for y in range(n):
        for x in range(n):
            a, b = 2 * math.pi * x / n, 2 * math.pi * y / n
            out.append(round(127 + 60 * math.sin(3 * a) * math.cos(2 * b)
                             + 50 * math.cos(a + 2 * b)))
    return out


def normals(n=32):
    """Normals of a height of that kind, as (n + 1) / 2."""
    out = []
    for y in range(n):
        for x in range(n):
            a, b = 2 * math.pi * x / n, 2 * math.pi * y / n
            v = (0.7 * math.cos(3 * a) * math.cos(2 * b), -0.6 * math.sin(2 * a + b), 1.0)
            length = math.sqrt(sum(c * c for c in v))
            out += [round(127.5 + 127.5 * c / length) for c in v]
    return out
