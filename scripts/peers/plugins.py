# SPDX-License-Identifier: Apache-2.0
"""What of Mitsuba is read, and where each part is compared: rows(), for check_trace.py.

A row names the cases (cases.py) that show the part. Where Mitsuba 3 has no such plugin, or another
model, it says what stands in: a twin in Python (old_plugins.py), or CTest tests against formulas,
known values or a second reading of the same thing.
"""
import dataclasses
import subprocess

import cases

TWIN = "not in Mitsuba 3; its twin in Python (old_plugins.py)"


@dataclasses.dataclass(frozen=True)
class Row:
    group: str
    what: str
    cases: tuple = ()
    tests: tuple = ()
    note: str = ""


def row(group, what, names="", tests="", note=""):
    return Row(group, what, tuple(names.split()), tuple(tests.split()), note)


def shapes():
    g = "shape"
    return [
        row(g, "obj: polygons, normals", "obj spaceship-1 veach-ajar-1"),
        row(g, "obj: groups, materials, no normals", "obj_groups classroom-constant"),
        row(g, "obj: negative indices", tests="scene_meshes",
            note="Mitsuba 3 refuses them; known values"),
        row(g, "ply: text", "ply_ascii"),
        row(g, "ply: binary, normals, texture coordinates", "ply_binary"),
        row(g, "ply: double, other byte order", "ply_big_endian"),
        row(g, "ply: all scalar types, quads", tests="scene_meshes",
            note="Mitsuba 3 reads triangles and floats; known values"),
        row(g, "ply: attributes of vertices and faces", "mesh_attribute"),
        row(g, "serialized: versions 3 and 4, shape index", "serialized words_of_0_6",
            "scene_serialized"),
        row(g, "rectangle", "diffuse area"), row(g, "cube", "cube area"),
        row(g, "sphere", "sphere area"), row(g, "disk", "disk area staircase2"),
        row(g, "cylinder", "cylinder"),
        row(g, "shapegroup, instance", "instance bumpmap_mesh"),
        row(g, "flip_normals", "cylinder words_of_0_6"),
        row(g, "face_normals", "ply_face_normals"),
    ]


def materials():
    g = "bsdf"
    return [
        row(g, "diffuse", "diffuse cornell-box"),
        row(g, "roughdiffuse (Oren-Nayar)", "ours/roughdiffuse", "render_material_values", TWIN),
        row(g, "conductor: eta and k", "conductor"), row(g, "conductor: none", "conductor_none"),
        row(g, "conductor: every name", "metals conductor_named"),
        row(g, "roughconductor: Beckmann", "roughconductor_beckmann veach-mis"),
        row(g, "roughconductor: GGX", "roughconductor_ggx"),
        row(g, "roughconductor: anisotropic", "roughconductor_anisotropic"),
        row(g, "roughconductor: textured roughness", "rough_texture rough_texture_anisotropic"),
        row(g, "dielectric", "dielectric dielectric_tinted"),
        row(g, "indices of refraction by name", "ior_names"),
        row(g, "thindielectric", "thindielectric"),
        row(g, "roughdielectric: Beckmann", "roughdielectric_beckmann"),
        row(g, "roughdielectric: GGX", "roughdielectric_ggx sphere-caustic-1"),
        row(g, "roughdielectric: anisotropic, textured",
            "roughdielectric_anisotropic rough_texture_glass"),
        row(g, "plastic", "plastic"), row(g, "plastic: nonlinear", "plastic_nonlinear"),
        row(g, "roughplastic: Beckmann", "roughplastic_beckmann roughplastic_texture"),
        row(g, "roughplastic: GGX, nonlinear", "roughplastic_ggx"),
        row(g, "roughplastic: textured roughness", tests="render_material_values render_materials",
            note="Mitsuba 3 has one number; sampled values"),
        row(g, "principled", "principled principled_default principled_metal principled_glass"),
        row(g, "phong", "ours/phong", "render_material_values", TWIN),
        row(g, "blinnphong", "ours/blinnphong", "render_material_values", TWIN),
        row(g, "mask", "mask"), row(g, "twosided", "twosided"),
        row(g, "blendbsdf", "blendbsdf blendbsdf_nested"),
        row(g, "blendbsdf: of mirrors, glass, masks", "ours/blendbsdf_delta",
            note="Mitsuba 3's samples do not fit its values there; its twin in Python"),
        row(g, "mixturebsdf", "ours/mixturebsdf", note=TWIN),
        row(g, "bumpmap", "bumpmap bumpmap_metal bumpmap_mesh"),
        row(g, "normalmap", "normalmap normalmap_mirror normalmap_anisotropic"),
        row(g, "null", "null"),
    ]


def textures():
    g = "texture"
    return [
        row(g, "bitmap: PNG, 8-bit sRGB, nearest and bilinear", "bitmap"),
        row(g, "bitmap: PNG, grey and 16-bit; TGA, BMP, Radiance HDR", "bitmap_formats"),
        row(g, "bitmap: JPEG baseline, progressive, grey; EXR, PFM", "bitmap_jpeg"),
        row(g, "bitmap: repeat, mirror, clamp; to_uv; raw", "bitmap_wrap"),
        row(g, "checkerboard", "checkerboard"),
        row(g, "mesh_attribute (vertexcolors)", "mesh_attribute"),
        row(g, "gridtexture", "ours/gridtexture", "render_texture", TWIN),
        row(g, "scale", "ours/gridtexture", note=TWIN),
        row(g, "spectrum by wavelength", "spectrum"),
    ]


def emitters():
    g = "emitter"
    sky = ("another model (Preetham's; Mitsuba 3 has Hosek and Wilkie's): the paper's formulas; "
           "check_sky.py says how far apart")
    return [
        row(g, "area", "area cornell-box staircase2"), row(g, "area: textured", "area_texture area"),
        row(g, "point", "point"), row(g, "spot: beam width, texture", "spot"),
        row(g, "directional", "directional"),
        row(g, "directionalarea", "directionalarea", "render_light_sent",
            "by Mitsuba's ptracer: its path does not see them"),
        row(g, "constant", "constant classroom-constant"),
        row(g, "envmap", "envmap envmap_hdr classroom-envmap"),
        row(g, "sun", tests="render_light_sent scene_reader", note=sky),
        row(g, "sky", tests="render_light_sent scene_reader", note=sky),
        row(g, "sunsky", tests="render_light_sent render_light", note=sky),
        row(g, "projector", "projector"),
    ]


def sensors():
    g = "sensor"
    return [
        row(g, "perspective", "diffuse spaceship-1"), row(g, "thinlens", "thinlens"),
        row(g, "orthographic", "orthographic"), row(g, "principal point, fov axis", "principal_point"),
        row(g, "near and far, focal length", "near_far"), row(g, "crop", "crop"),
    ]


def others():
    return [
        row("film", "hdrfilm", "diffuse"), row("film", "ldrfilm", "veach-mis"),
        row("film", "box filter", "filter_box"), row("film", "tent filter", "diffuse"),
        row("film", "gaussian filter", "filter_gaussian"),
        row("file", "XML 0.5", "veach-mis staircase2", "scene_generations"),
        row("file", "XML 0.6", "words_of_0_6 classroom-constant", "scene_generations"),
        row("file", "XML 2.x, variable",
            "sphere-caustic-1 sphere-caustic-2 sphere-caustic-3 veach-ajar-1 veach-ajar-2 "
            "veach-ajar-3 spaceship-1 spaceship-2 spaceship-3", "scene_generations"),
        row("file", "XML 3.x", "cornell-box", "scene_generations"),
        row("file", "default, -D, alias, include", "defaults", "scene_reader"),
        row("file", "variables declared in JSON", "demo demo-1 demo-2", "scene_variables"),
    ]


def rows():
    return shapes() + materials() + textures() + emitters() + sensors() + others()


def test_passes(name, done={}):
    """Whether a test of build/release passes; each runs once."""
    if name not in done:
        command = ["ctest", "--test-dir", str(cases.ROOT / "build/release"), "--no-tests=error", "-R",
                   f"^{name}$"]
        done[name] = subprocess.run(command, capture_output=True, check=False).returncode == 0
    return done[name]


def verdict(r, results):
    """agree, DISAGREE, MISSING, not run; passes and FAILS are those of tests."""
    known = {c.name for c in cases.all_cases()}
    if not r.cases and not r.tests or any(name not in known for name in r.cases):
        return "MISSING"
    ran = [results[name]["ok"] for name in r.cases if name in results]
    if r.cases and not ran:
        return "not run"
    if r.cases:
        return "agree" if all(ran) else "DISAGREE"
    return "passes" if all(test_passes(name) for name in r.tests) else "FAILS"


def judged(results):
    """[(row, verdict)] of results {case: result}."""
    return [(r, verdict(r, results)) for r in rows()]


def uncovered():
    """Cases that no row names."""
    named = {name for r in rows() for name in r.cases}
    return [c.name for c in cases.all_cases() if c.name not in named]
