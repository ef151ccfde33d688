# SPDX-License-Identifier: Apache-2.0
"""Test scenes of file formats, for make_tests.py, whose pieces m has: scenes(m), write_files(m, folder)."""
import math
import struct
import zlib

ATTRIBUTE = """        <bsdf type="twosided">
            <bsdf type="diffuse">
                <texture type="mesh_attribute" name="reflectance">
                    <string name="name" value="{name}"/>
                </texture>
            </bsdf>
        </bsdf>
"""

# Of the newest kind but in the words of 0.6; Mitsuba 3 renames them likewise.
OLD = """<?xml version="1.0" encoding="utf-8"?>
<!-- The words of Mitsuba 0.6. Made by scripts/scenes/make_tests.py. CC0. -->
<scene version="0.6.0">
    <integrator type="path">
        <integer name="maxDepth" value="6"/>
    </integrator>
    <sensor type="perspective">
        <float name="fov" value="32"/>
        <string name="fovAxis" value="x"/>
        <float name="nearClip" value="0.1"/>
        <transform name="toWorld">
            <lookat origin="0.4, 1.5, 4.2" target="0, 0.62, 0" up="0, 1, 0"/>
        </transform>
        <sampler type="independent">
            <integer name="sampleCount" value="64"/>
        </sampler>
        <film type="hdrfilm">
            <integer name="width" value="128"/>
            <integer name="height" value="128"/>
            <boolean name="banner" value="false"/>
            <rfilter type="tent"/>
        </film>
    </sensor>
    <bsdf type="plastic" id="material">
        <rgb name="diffuseReflectance" value="0.2, 0.5, 0.3"/>
        <rgb name="specularReflectance" value="0.8, 0.8, 0.8"/>
        <float name="intIOR" value="1.6"/>
        <string name="extIOR" value="air"/>
    </bsdf>
    <shape type="sphere">
        <point name="center" x="-0.55" y="0.6" z="0"/>
        <float name="radius" value="0.6"/>
        <ref id="material"/>
    </shape>
    <shape type="serialized">
        <string name="filename" value="meshes/two.serialized"/>
        <integer name="shapeIndex" value="1"/>
        <boolean name="faceNormals" value="true"/>
        <transform name="toWorld">
            <scale value="0.5"/>
            <rotate y="1" angle="30"/>
            <translate x="0.8" y="0.5" z="0.2"/>
        </transform>
        <bsdf type="roughconductor">
            <float name="alphaU" value="0.2"/>
            <float name="alphaV" value="0.3"/>
            <rgb name="eta" value="0.143, 0.375, 1.442"/>
            <rgb name="k" value="3.983, 2.386, 1.603"/>
            <rgb name="specularReflectance" value="0.9, 0.9, 0.9"/>
        </bsdf>
    </shape>
    <shape type="rectangle">
        <transform name="toWorld">
            <rotate x="1" angle="-90"/>
            <scale value="2"/>
        </transform>
        <bsdf type="diffuse">
            <texture type="bitmap" name="reflectance">
                <string name="filename" value="textures/picture.png"/>
                <string name="filterType" value="bilinear"/>
                <string name="wrapMode" value="mirror"/>
                <float name="uscale" value="3"/>
                <float name="vscale" value="2"/>
                <float name="uoffset" value="0.2"/>
            </texture>
        </bsdf>
    </shape>
    <shape type="cube">
        <boolean name="flipNormals" value="true"/>
        <transform name="toWorld">
            <scale x="2.5" y="2.2" z="4.5"/>
            <translate y="2.15"/>
        </transform>
        <bsdf type="diffuse">
            <rgb name="reflectance" value="0.6, 0.6, 0.6"/>
        </bsdf>
    </shape>
    <shape type="rectangle">
        <transform name="toWorld">
            <rotate x="1" angle="90"/>
            <scale x="0.8" y="0.8"/>
            <translate x="-0.5" y="3" z="0.5"/>
        </transform>
        <emitter type="area">
            <spectrum name="radiance" value="8"/>
        </emitter>
    </shape>
</scene>
"""

# What Mitsuba 3 has no more: gridtexture, scale, vertexcolors, srgb, blackbody; quads in PLY files
# and negative indices in OBJ files it never read.
ONLY_OLD = OLD[:OLD.index('    <bsdf type="plastic"')].replace("The words of", "Textures of") + """
    <shape type="ply">
        <string name="filename" value="../meshes/quads.ply"/>
        <transform name="toWorld">
            <scale value="0.6"/>
            <translate x="-0.6" y="0.7"/>
        </transform>
        <bsdf type="twosided">
            <bsdf type="diffuse">
                <texture type="vertexcolors" name="reflectance"/>
            </bsdf>
        </bsdf>
    </shape>
    <shape type="obj">
        <string name="filename" value="../meshes/negative.obj"/>
        <transform name="toWorld">
            <scale value="0.5"/>
            <translate x="0.7" y="0.5" z="0.3"/>
        </transform>
        <bsdf type="diffuse">
            <srgb name="reflectance" value="#c08040"/>
        </bsdf>
    </shape>
    <shape type="rectangle">
        <transform name="toWorld">
            <rotate x="1" angle="-90"/>
            <scale value="2"/>
        </transform>
        <bsdf type="diffuse">
            <texture type="scale" name="reflectance">
                <float name="scale" value="1.5"/>
                <texture type="gridtexture">
                    <rgb name="color0" value="0.3, 0.35, 0.4"/>
                    <rgb name="color1" value="0.1, 0.1, 0.1"/>
                    <float name="lineWidth" value="0.04"/>
                    <float name="uvscale" value="8"/>
                </texture>
            </texture>
        </bsdf>
    </shape>
    <shape type="sphere">
        <point name="center" x="-0.5" y="3" z="1.5"/>
        <float name="radius" value="0.3"/>
        <emitter type="area">
            <blackbody name="radiance" temperature="3200K" scale="0.02"/>
        </emitter>
    </shape>
</scene>
"""


def scenes(m):
    """name -> (what it shows, body)"""
    def placed(text, move):
        return text.replace('<translate y="0.7"/>', f"<translate {move}/>")

    def attributes(name, move):
        text = m.mesh("ply", "meshes/painted.ply").replace('"thing"', f'"{name}"')
        begin, end = text.index("        <bsdf"), text.index("    </shape>")
        return placed(text[:begin] + ATTRIBUTE.format(name=name) + text[end:], move)

    def part(index, name, move):
        number = f'        <integer name="shape_index" value="{index}"/>\n' if index else ""
        return placed(m.mesh("serialized", name, number)
                      .replace('"thing"', f'"{name[7:-11]}_{index}"'), move)

    def picture(filename, extra, move):
        return (m.card('        <bsdf type="twosided">\n        <bsdf type="diffuse">\n'
                       + m.bitmap("reflectance", filename, extra)
                       + "        </bsdf>\n        </bsdf>\n")
                .replace('"card"', f'"{filename[9:-4]}"').replace('value="0.75"', 'value="0.42"')
                .replace('<translate y="0.8"/>', f"<translate {move}/>"))

    nearest = '            <string name="filter_type" value="nearest"/>\n'
    raw = '            <boolean name="raw" value="true"/>\n'
    return {
        "mesh_attribute": ("Colours of vertices and of faces, and a number of vertices",
                           attributes("vertex_color", 'x="-0.8" y="0.75" z="-0.3"')
                           + attributes("face_color", 'x="0.8" y="0.9" z="-0.5"')
                           + attributes("vertex_tint", 'x="0" y="0.3" z="0.9"') + m.BACKLIT),
        "ply_big_endian": ("A PLY mesh in doubles and the other byte order",
                           m.mesh("ply", "meshes/doubles.ply") + m.BACKLIT),
        "obj_groups": ("An OBJ file with groups, materials and no normals",
                       m.mesh("obj", "meshes/groups.obj") + m.BACKLIT),
        "serialized": ("Serialized meshes: versions 3 and 4, with and without normals",
                       part(0, "meshes/two.serialized", 'x="-0.9" y="0.7"')
                       + part(1, "meshes/two.serialized", 'x="0.2" y="0.6" z="-0.4"')
                       + part(0, "meshes/old.serialized", 'x="1.1" y="0.7" z="0.3"') + m.BACKLIT),
        "bitmap_formats": ("Pictures as TGA, BMP, HDR, grey and 16-bit PNG",
                           picture("textures/packed.tga", nearest, 'x="-1" y="1.2" z="-0.4"')
                           + picture("textures/card.bmp", nearest, 'x="0" y="1.3" z="-0.6"')
                           + picture("textures/glow.hdr", "", 'x="1" y="1.2" z="-0.4"')
                           + picture("textures/wide.png", "", 'x="-0.6" y="0.45" z="0.5"')
                           + picture("textures/grey.png", raw, 'x="0.5" y="0.45" z="0.6"')
                           + m.BACKLIT),
        "envmap_hdr": ("Light from a Radiance picture",
                       m.material("diffuse") + m.THINGS + m.FLOOR + """
    <emitter type="envmap">
        <string name="filename" value="textures/sky.hdr"/>
        <transform name="to_world">
            <rotate y="1" angle="-40"/>
        </transform>
    </emitter>
"""),
        "spectrum": ("Colours by wavelength",
                     m.material("diffuse", '        <spectrum name="reflectance" value="400:0.05, '
                                '480:0.1, 560:0.35, 620:0.7, 700:0.75"/>\n') + m.BALL
                     + m.BACKLIT.replace(
                         '<rgb name="radiance" value="9, 8, 7"/>',
                         '<spectrum name="radiance" value="400:2, 500:6, 600:9, 700:12"/>')),
    }


def whole_scenes():
    """name -> text; ours/: what Mitsuba 3 does not read"""
    return {"words_of_0_6": OLD, "ours/textures_of_0_6": ONLY_OLD}


# ---- Meshes ------------------------------------------------------------------------------------

def wave(n, height=0.35):
    """Points and normals of a sheet with a wave in it, n x n."""
    rows = []
    for i in range(n):
        for j in range(n):
            x, y = 2 * i / (n - 1) - 1, 2 * j / (n - 1) - 1
            z = height * math.cos(4 * x) * math.cos(3 * y)
            dx = -height * 4 * math.sin(4 * x) * math.cos(3 * y)
            dy = -height * 3 * math.cos(4 * x) * math.sin(3 * y)
            length = math.sqrt(dx * dx + dy * dy + 1)
            rows.append((x, y, z, -dx / length, -dy / length, 1 / length))
    return rows


def cells(n):
    return [(i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1)
            for i in range(n - 1) for j in range(n - 1)]


def write_painted(path, n=9):
    """Colours of vertices as floats and of faces; a number of vertices by itself."""
    lines = ["ply", "format ascii 1.0", "comment made by scripts/scenes/make_tests.py, CC0",
             f"element vertex {n * n}"]
    lines += [f"property float {c}" for c in ("x", "y", "z", "r", "g", "b", "tint_0")]
    lines += [f"element face {2 * (n - 1)**2}", "property list uchar int vertex_indices"]
    lines += [f"property float {c}" for c in "rgb"] + ["end_header"]
    for k, (x, y, z, *_) in enumerate(wave(n)):
        colour = (0.1 + 0.8 * (k % n) / (n - 1), 0.5 + 0.4 * math.sin(k), 0.9 - 0.8 * k / n**2)
        values = (x, y, z, *colour, 0.2 + 0.6 * (k % 3) / 2)
        lines.append(" ".join(f"{v:.6f}" for v in values))
    for k, (a, b, c, d) in enumerate(cells(n)):
        colour = f"{0.2 + 0.7 * (k % 2):.3f} {0.1 + 0.2 * (k % 5):.3f} {0.9 - 0.4 * (k % 3):.3f}"
        lines += [f"3 {a} {b} {c} {colour}", f"3 {a} {c} {d} {colour}"]
    path.write_text("\n".join(lines) + "\n")


def write_doubles(path, n=11):
    header = ("ply\nformat binary_big_endian 1.0\n"
              "comment made by scripts/scenes/make_tests.py, CC0\n"
              f"element vertex {n * n}\n"
              + "".join(f"property double {c}\n" for c in "xyz")
              + "".join(f"property float {c}\n" for c in ("nx", "ny", "nz"))
              + f"property uchar age\nelement face {2 * (n - 1)**2}\n"
              "property list uchar uint vertex_index\nend_header\n")
    path.write_bytes(header.encode()
                     + b"".join(struct.pack(">3d3fB", *row, 7) for row in wave(n))
                     + b"".join(struct.pack(">B3IB3I", 3, a, b, c, 3, a, c, d)
                                for a, b, c, d in cells(n)))


def write_colour_quads(path, n=9):
    lines = ["ply", "format ascii 1.0", "comment made by scripts/scenes/make_tests.py, CC0",
             f"element vertex {n * n}"]
    lines += [f"property float {c}" for c in "xyz"]
    lines += [f"property uchar {c}" for c in ("red", "green", "blue")]
    lines += [f"element face {(n - 1)**2}", "property list uchar int vertex_indices", "end_header"]
    for k, (x, y, z, *_) in enumerate(wave(n)):
        lines.append(f"{x:.6f} {y:.6f} {z:.6f} {40 + 20 * (k % n)} {250 - 3 * k} 90")
    lines += ["4 " + " ".join(map(str, c)) for c in cells(n)]
    path.write_text("\n".join(lines) + "\n")


GROUPS = """# made by scripts/scenes/make_tests.py, CC0
mtllib none.mtl
o tower
g base
v -0.7 -1 -0.7
v 0.7 -1 -0.7
v 0.7 -1 0.7
v -0.7 -1 0.7
v -0.5 0.3 -0.5
v 0.5 0.3 -0.5
v 0.5 0.3 0.5
v -0.5 0.3 0.5
vt 0 0
vt 1 0
vt 1 1
vt 0 1
usemtl stone
s 1
f 4/1 3/2 7/3 8/4
f 3/1 2/2 6/3 7/4
f 2/1 1/2 5/3 6/4
f 1/1 4/2 8/3 5/4
l 1 2 3
g roof
usemtl tiles
v 0 1 0
f 8 7 9
f 7 6 9
f 6 5 9
f 5 8 9
"""


def write_serialized(path, version, meshes):
    """meshes: (points with normals or None, quads, has_normals, is_double) each."""
    out, starts = b"", []
    for rows, quads, has_normals, is_double in meshes:
        kind = "d" if is_double else "f"
        triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
        body = struct.pack("<I", (0x2000 if is_double else 0x1000) | (1 if has_normals else 0))
        body += b"wave\0" if version == 4 else b""
        body += struct.pack("<2Q", len(rows), len(triangles))
        for first, last in ((0, 3), (3, 6))[:2 if has_normals else 1]:
            body += b"".join(struct.pack(f"<3{kind}", *row[first:last]) for row in rows)
        body += b"".join(struct.pack("<3I", *t) for t in triangles)
        starts.append(len(out))
        out += struct.pack("<2H", 0x041C, version) + zlib.compress(body, 9)
    out += struct.pack(f"<{len(starts)}{'Q' if version == 4 else 'I'}", *starts)
    path.write_bytes(out + struct.pack("<I", len(starts)))


# ---- Pictures ----------------------------------------------------------------------------------

def write_tga(path, n, pixels):
    """24 bits, packed, the bottom row first."""
    out = struct.pack("<3B2HB4H2B", 0, 0, 10, 0, 0, 0, 0, 0, n, n, 24, 0)
    for y in reversed(range(n)):
        row = [bytes(pixels[3 * (y * n + x):3 * (y * n + x) + 3])[::-1] for x in range(n)]
        x = 0
        while x < n:
            run = 1
            while x + run < n and row[x + run] == row[x]:
                run += 1
            out += bytes([127 + run if run > 1 else 0]) + row[x]
            x += run
    path.write_bytes(out + bytes(8) + b"TRUEVISION-XFILE.\0")


def write_bmp(path, n):
    """24 bits, the bottom row first."""
    rows = b"".join(b"".join(bytes([(40 + 11 * x) % 256, (200 - 9 * y) % 256, (5 * x * y) % 256])
                             for x in range(n)) + bytes(-3 * n % 4) for y in range(n))
    path.write_bytes(b"BM" + struct.pack("<I2HI", 54 + len(rows), 0, 0, 54)
                     + struct.pack("<I2i2H6I", 40, n, n, 1, 24, 0, 0, 2835, 2835, 0, 0) + rows)


def write_hdr(path, width, height, rgb_at):
    """Flat scan lines."""
    out = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n".encode()
    for y in range(height):
        for x in range(width):
            colour = rgb_at(x, y)
            mantissa, exponent = math.frexp(max(*colour, 1e-9))
            scale = mantissa * 256 / max(*colour, 1e-9)
            out += bytes([*(min(int(c * scale), 255) for c in colour), exponent + 128])
    path.write_bytes(out)


def write_wide_png(path, n):
    """16 bits."""
    rows = b"".join(b"\0" + b"".join(struct.pack(">3H", 2600 * x, 2500 * y, 60000 - 1200 * (x + y))
                                     for x in range(n)) for y in range(n))

    def chunk(kind, data):
        return (struct.pack(">I", len(data)) + kind + data
                + struct.pack(">I", zlib.crc32(kind + data)))

    path.write_bytes(b"\x89PNG\r\n\x1a\n"
                     + chunk(b"IHDR", struct.pack(">2I5B", n, n, 16, 2, 0, 0, 0))
                     + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


def glow(x, y, n=16):
    r = math.hypot(x - n / 2, y - n / 2) / n
    return (0.9 - r, 0.02 + 0.6 * r, 0.1 + 0.3 * (x % 4 == 0))


def write_files(m, folder):
    write_painted(folder / "meshes/painted.ply")
    write_doubles(folder / "meshes/doubles.ply")
    write_colour_quads(folder / "meshes/quads.ply")
    (folder / "meshes/groups.obj").write_text(GROUPS)
    (folder / "meshes/negative.obj").write_text(
        "# made by scripts/scenes/make_tests.py, CC0\n"
        "v -1 -1 -1\nv 1 -1 -1\nv 1 -1 1\nv -1 -1 1\nv 0 1 0\n"
        "f -2 -3 -1\nf -3 -4 -1\nf -4 -5 -1\nf -5 -2 -1\n")
    write_serialized(folder / "meshes/two.serialized", 4,
                     [(wave(9), cells(9), True, False), (wave(6, 0.5), cells(6), False, True)])
    write_serialized(folder / "meshes/old.serialized", 3, [(wave(7, 0.2), cells(7), False, False)])
    write_tga(folder / "textures/packed.tga", 24, m.picture())
    write_bmp(folder / "textures/card.bmp", 22)
    write_hdr(folder / "textures/glow.hdr", 16, 16, glow)
    write_hdr(folder / "textures/sky.hdr", 48, 24, m.sky)
    write_wide_png(folder / "textures/wide.png", 24)
    m.write_png(folder / "textures/grey.png", 16, 16,
                [(23 * x + 11 * y) % 256 for y in range(16) for x in range(16)], 1)
