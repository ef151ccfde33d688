#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""hostile.py LUMENAUT [SHOWN]: files that want to hurt, given to the program one by one.

Cut off, absurd counts, NaN, cycles, entity bombs, absurd sizes of pictures, devices and pipes for
files; of checkpoints the model, the state beside it, or both. Each must end soon with status 0 or 3 (a bad input file) and at most one line on stderr that
has no control characters, in bounded memory; a picture that comes of it must be finite. SHOWN prints
what was said of each file whose name contains it.
"""
import json
import os
import pathlib
import resource
import struct
import subprocess
import sys
import tempfile
import time
import zlib

ROOT = pathlib.Path(__file__).resolve().parents[2]
SEEDS = ROOT / "scenes/tests"
SECONDS = 30
MEBIBYTES = 200           # of the plain program
SANITIZED_MEBIBYTES = 500 # shadow memory and freed blocks that wait

SENSOR = ('<sensor type="perspective"><float name="fov" value="40"/><transform name="to_world">'
          '<lookat origin="0, 1, 5" target="0, 0, 0" up="0, 1, 0"/></transform><film type="hdrfilm">'
          '<integer name="width" value="8"/><integer name="height" value="8"/></film></sensor>')
SKY = '<emitter type="constant"/>'


def scene(body, sensor=SENSOR, version="3.0.0"):
    return f'<scene version="{version}">{sensor}{body}</scene>'.encode()


def shape(kind, filename, extra=""):
    return scene(f'<shape type="{kind}"><string name="filename" value="{filename}"/>{extra}</shape>{SKY}')


def textured(filename, extra=""):
    return scene(f'<shape type="sphere"><bsdf type="diffuse"><texture type="bitmap" name="reflectance">'
                 f'<string name="filename" value="{filename}"/>{extra}</texture></bsdf></shape>{SKY}')


def envmap(filename):
    return scene('<shape type="sphere"/><emitter type="envmap">'
                 f'<string name="filename" value="{filename}"/></emitter>')


def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(width, height, data, depth=8, kind=0):
    header = struct.pack(">2I5B", width, height, depth, kind, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b""))


# ---- The corpus: (name, {file: bytes}); the first file is the scene -------------------------------

def cut_off():
    """Every kind of file, cut at many places."""
    files = {"obj": "meshes/house.obj", "ply": "meshes/painted.ply", "serialized": "meshes/two.serialized"}
    for kind, path in files.items():
        whole = (SEEDS / path).read_bytes()
        for n in places(len(whole)):
            yield f"{kind} cut at {n}", {"s.xml": shape(kind, f"m.{kind}"), f"m.{kind}": whole[:n]}
    binary = (SEEDS / "meshes/doubles.ply").read_bytes()
    for n in places(len(binary)):
        yield f"binary ply cut at {n}", {"s.xml": shape("ply", "m.ply"), "m.ply": binary[:n]}
    for path in ("baseline.jpg", "progressive.jpg", "wide.png", "picture.png", "sky.exr", "card.pfm",
                 "glow.hdr", "packed.tga", "card.bmp"):
        whole = (SEEDS / "textures" / path).read_bytes()
        name = "t" + pathlib.Path(path).suffix
        for n in places(len(whole)):
            yield f"{path} cut at {n}", {"s.xml": textured(name), name: whole[:n]}
    whole = (SEEDS / "diffuse.xml").read_bytes()
    for n in places(len(whole)):
        yield f"xml cut at {n}", {"s.xml": whole[:n]}
        yield f"include cut at {n}", {"s.xml": scene('<include filename="i.xml"/>'), "i.xml": whole[:n]}
    whole = (ROOT / "tests/cli/scenes/box.variables.json").read_bytes()
    box = (ROOT / "tests/cli/scenes/box.xml").read_bytes()
    for n in places(len(whole)):
        yield f"json cut at {n}", {"s.xml": box, "s.variables.json": whole[:n]}


def places(size):
    return sorted(n for n in {0, 1, 2, size // 7, size // 3, size // 2, size - 9, size - 1} if 0 <= n < size)


def mislabelled():
    noise = bytes((i * 7919 + i // 251 * 104729) % 256 for i in range(3000))
    for name in ("t.png", "t.jpg", "t.exr", "t.pfm", "t.hdr", "t.tga", "t.bmp"):
        yield f"noise as {name}", {"s.xml": textured(name), name: noise}
        yield f"zeros as {name}", {"s.xml": textured(name), name: bytes(3000)}
    for kind in ("obj", "ply", "serialized"):
        yield f"noise as {kind}", {"s.xml": shape(kind, "m"), "m": noise}
    yield "noise as xml", {"s.xml": noise}
    yield "zeros as xml", {"s.xml": bytes(3000)}
    yield "noise as json", {"s.xml": scene(SKY), "s.variables.json": noise}
    yield "utf-16", {"s.xml": scene(SKY).decode().encode("utf-16")}
    yield "bad utf-8", {"s.xml": scene('<bsdf type="\xff\xfe" id="\x80"/>').replace(b"\xc3", b"")}


def huge_counts():
    def ply(vertices, faces, data=b"", form="binary_little_endian", index="uchar int"):
        return (f"ply\nformat {form} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\n"
                f"property float z\nelement face {faces}\nproperty list {index} vertex_indices\n"
                "end_header\n").encode() + data

    point = struct.pack("<3f", 0, 0, 0)
    for name, data in (
            ("vertices 2^32 - 1", ply(4294967295, 1)), ("vertices 2^64", ply(2**64, 1)),
            ("vertices -1", ply(-1, 1)), ("faces 2^31", ply(3, 2**31, 3 * point)),
            ("a face of 2^32 - 1", ply(3, 1, 3 * point + b"\xff" * 4, index="uint int")),
            ("a face of -1", ply(3, 1, 3 * point + b"\xff" * 4, index="int int")),
            ("a face of 1e30", ply(3, 1, 3 * point + struct.pack("<f", 1e30), index="float int")),
            ("indices beyond", ply(3, 1, 3 * point + struct.pack("<B3i", 3, 0, 1, 3))),
            ("indices below", ply(3, 1, 3 * point + struct.pack("<B3i", 3, 0, 1, -1))),
            ("text, 2^31 vertices", ply(2**31, 1, b"0 0 0\n", "ascii"))):
        yield f"ply: {name}", {"s.xml": shape("ply", "m.ply"), "m.ply": data}
    for name, text in (
            ("index 2^31", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 2147483648\n"),
            ("index -2^63", "v 0 0 0\nf 1 1 -9223372036854775808\n"),
            ("index 1e99", "v 0 0 0\nf 1 1 1e99\n"), ("index 0", "v 0 0 0\nf 0 0 0\n"),
            ("texture index beyond", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/9 2/9 3/9\n"),
            ("a face of 200000", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf" + " 1 2 3" * 66667 + "\n"),
            ("a long line", "v" + " 0" * 1000000 + "\n"), ("no line end", "v 0 0 0" * 1)):
        yield f"obj: {name}", {"s.xml": shape("obj", "m.obj"), "m.obj": text.encode()}
    for vertices, faces in ((2**60, 1), (2**63, 2**63), (3, 2**61), (2**32, 2**32)):
        body = struct.pack("<I", 0x1000) + b"m\0" + struct.pack("<2Q", vertices, faces) + bytes(64)
        data = struct.pack("<2H", 0x041C, 4) + zlib.compress(body)
        data += struct.pack("<QI", 0, 1)
        yield f"serialized: {vertices} vertices", {"s.xml": shape("serialized", "m"), "m": data}
    data = (SEEDS / "meshes/two.serialized").read_bytes()
    for index in (2, 2147483647, -1):
        yield f"serialized: shape {index}", {
            "s.xml": shape("serialized", "m", f'<integer name="shape_index" value="{index}"/>'), "m": data}
    bomb = struct.pack("<2H", 0x041C, 4) + zlib.compress(bytes(1 << 28), 9) + struct.pack("<QI", 0, 1)
    yield "serialized: 256 MiB of zeros", {"s.xml": shape("serialized", "m"), "m": bomb}
    for name, value in (("width", "1000000"), ("width", "2147483647"), ("width", "-1"), ("width", "0"),
                        ("height", "99999999999999999999"), ("height", "nan")):
        yield f"film {name} {value}", {"s.xml": scene(SKY, SENSOR.replace(
            '"width" value="8"' if name == "width" else '"height" value="8"', f'"{name}" value="{value}"'))}
    for name, value in (("max_depth", "2147483648"), ("max_depth", "-2"), ("rr_depth", "-5")):
        yield f"{name} {value}", {"s.xml": scene(
            f'<integrator type="path"><integer name="{name}" value="{value}"/></integrator>{SKY}')}
    yield "crop beyond", {"s.xml": scene(SKY, SENSOR.replace("</film>", '<integer name="crop_width" '
          'value="2147483647"/><integer name="crop_offset_x" value="2147483647"/></film>'))}


def absurd_pictures():
    row = zlib.compress(bytes(1000000), 9)
    pictures = {
        "t.png": {"32768 x 32768, all there": png(32768, 32768, zlib.compress(bytes(4097 * 32768), 9), 1),
                  "2^31 wide": png(2**31 - 1, 2**31 - 1, row), "0 wide": png(0, 5, row),
                  "says 30000 x 30000": png(30000, 30000, zlib.compress(bytes(100)))},
        "t.hdr": {"2^31 wide": b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2147483647 +X 2147483647\nab",
                  "a long header": b"#?RADIANCE\n" + b"A=" + b"b" * 1000000,
                  "runs without end": b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 16\n\2\2\0\x10\xff\1"},
        "t.tga": {"65535 x 65535": struct.pack("<3B2HB4H2B", 0, 0, 10, 0, 0, 0, 0, 0, 65535, 65535, 24, 0)
                  + b"\xff\1\2\3"},
        "t.bmp": {"2^31 - 1 wide": b"BM" + struct.pack("<IIIIiiHHIIiiII", 99, 0, 54, 40, 2**31 - 1, -2**31,
                                                      1, 24, 0, 0, 0, 0, 0, 0),
                  "palette beyond": b"BM" + struct.pack("<IIIIiiHHIIiiII", 99, 0, 2**32 - 1, 40, 4, 4, 1, 8,
                                                       0, 0, 0, 0, 2**32 - 1, 0) + bytes(60)},
        "t.pfm": {"2^31 wide": b"PF\n2147483647 2147483647\n-1\n", "-1 wide": b"PF\n-1 -1\n-1\n"},
    }
    exr = (SEEDS / "textures/sky.exr").read_bytes()
    at = exr.index(b"dataWindow\0box2i\0") + 21
    pictures["t.exr"] = {
        "2^31 wide": exr[:at] + struct.pack("<4i", -2**31, -2**31, 2**31 - 1, 2**31 - 1) + exr[at + 16:],
        "32768 x 32768": exr[:at] + struct.pack("<4i", 0, 0, 32767, 32767) + exr[at + 16:],
        "inside out": exr[:at] + struct.pack("<4i", 5, 5, 1, 1) + exr[at + 16:]}
    jpeg = (SEEDS / "textures/progressive.jpg").read_bytes()
    at = jpeg.index(b"\xff\xc2") + 5
    wide = jpeg[:at] + struct.pack(">2H", 65500, 65500) + jpeg[at + 4:]
    scan = jpeg.index(b"\xff\xda")
    pictures["t.jpg"] = {"65500 x 65500": wide, "0 x 0": jpeg[:at] + bytes(4) + jpeg[at + 4:],
                         "65500 x 65500, scans without end": wide[:-2] + jpeg[scan:-2] * 2000}
    for name, kinds in pictures.items():
        for what, data in kinds.items():
            yield f"{name}: {what}", {"s.xml": textured(name), name: data}
            yield f"envmap {name}: {what}", {"s.xml": envmap(name), name: data}


def numbers():
    """NaN, infinities and what has no inverse."""
    nan, inf = struct.pack("<f", float("nan")), struct.pack("<f", float("inf"))
    head = (b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
            b"property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n")
    face = struct.pack("<B3i", 3, 0, 1, 2)
    for what, x in (("NaN", nan), ("infinite", inf), ("1e38", struct.pack("<f", 1e38))):
        yield f"ply: {what}", {"s.xml": shape("ply", "m.ply"),
                               "m.ply": head + (x + bytes(8)) + struct.pack("<6f", 1, 0, 0, 0, 1, 0) + face}
        pixels = (x * 3 + struct.pack("<3f", 1, 1, 1)) * 8
        pfm = b"PF\n4 4\n-1\n" + pixels
        yield f"pfm: {what}", {"s.xml": textured("t.pfm"), "t.pfm": pfm}
        yield f"envmap: {what}", {"s.xml": envmap("t.pfm"), "t.pfm": pfm}
    for word in ("nan", "inf", "-inf", "1e999", "1e-999", "0x10", "1e", "--1", "1" * 5000):
        yield f"obj: v {word[:9]}", {"s.xml": shape("obj", "m.obj"),
                                     "m.obj": f"v {word} 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".encode()}
        for name, body in (
                ("radius", f'<shape type="sphere"><float name="radius" value="{word}"/></shape>'),
                ("radiance", '<shape type="sphere"><emitter type="area"><rgb name="radiance" '
                             f'value="{word}"/></emitter></shape>'),
                ("alpha", '<shape type="sphere"><bsdf type="roughconductor"><float name="alpha" '
                          f'value="{word}"/></bsdf></shape>'),
                ("int_ior", '<shape type="sphere"><bsdf type="roughdielectric"><float name="int_ior" '
                            f'value="{word}"/></bsdf></shape>'),
                ("scale", '<shape type="sphere"><transform name="to_world"><scale '
                          f'value="{word}"/></transform></shape>'),
                ("turbidity", f'<emitter type="sunsky"><float name="turbidity" value="{word}"/></emitter>')):
            yield f"{name} {word[:9]}", {"s.xml": scene(body + SKY)}
        yield f"fov {word[:9]}", {"s.xml": scene(SKY, SENSOR.replace('"40"', f'"{word}"'))}
    for body in ('<scale value="0"/>', '<scale x="0" y="1" z="1"/>', f'<matrix value="{"0 " * 16}"/>',
                 '<scale value="1e38"/><scale value="1e38"/>', '<rotate x="0" y="0" z="0" angle="10"/>',
                 f'<matrix value="{"1 " * 17}"/>', '<lookat origin="0,0,0" target="0,0,0" up="0,1,0"/>',
                 '<lookat origin="0,0,0" target="0,1,0" up="0,1,0"/>'):
        yield f"transform {body[:40]}", {"s.xml": scene(
            f'<shape type="cube"><transform name="to_world">{body}</transform></shape>{SKY}')}
        yield f"camera {body[:40]}", {"s.xml": scene(SKY, SENSOR.replace(
            '<lookat origin="0, 1, 5" target="0, 0, 0" up="0, 1, 0"/>', body))}
    box = (ROOT / "tests/cli/scenes/box.xml").read_bytes()
    for value in ("NaN", "1e999", "-1e308, 1e308", "1, 0", "null", "\"1\", \"2\"", "0, 1, 2"):
        text = ('{"variables": [{"name": "g", "kind": "float", "targets": "metal.alpha", "range": ['
                f'{value}]}}]}}')
        yield f"json range {value}", {"s.xml": box, "s.variables.json": text.encode()}


def cycles():
    yield "include itself", {"s.xml": scene('<include filename="s.xml"/>')}
    yield "include in turn", {"s.xml": scene('<include filename="a.xml"/>'),
                              "a.xml": scene('<include filename="s.xml"/>')}
    for name, body in (
            ("bsdf", '<bsdf type="mask" id="a"><ref id="a"/></bsdf>'),
            ("bsdfs", '<bsdf type="twosided" id="a"><ref id="b"/></bsdf>'
                      '<bsdf type="twosided" id="b"><ref id="a"/></bsdf>'),
            ("textures", '<texture type="scale" id="a"><ref id="b"/></texture>'
                         '<texture type="scale" id="b"><ref id="a"/></texture>'),
            ("group", '<shape type="shapegroup" id="g"><shape type="instance"><ref id="g"/></shape></shape>'),
            ("alias", '<alias id="a" as="b"/><alias id="b" as="a"/><shape type="cube"><ref id="a"/></shape>'),
            ("default", '<default name="a" value="$b"/><default name="b" value="$a"/>'
                        '<shape type="sphere"><float name="radius" value="$a"/></shape>')):
        yield f"cycle of {name}", {"s.xml": scene(body + SKY)}


def bombs():
    lol = '<!DOCTYPE scene [<!ENTITY a "' + "x" * 100 + '">'
    for i in range(1, 10):
        lol += f'<!ENTITY {chr(97 + i)} "{("&" + chr(96 + i) + ";") * 10}">'
    yield "billion laughs", {"s.xml": (lol + ']><scene version="3.0.0"><bsdf type="&j;"/></scene>').encode()}
    yield "external entity", {"s.xml": b'<!DOCTYPE s [<!ENTITY e SYSTEM "file:///etc/passwd">]>'
                                       b'<scene version="3.0.0">&e;</scene>'}
    yield "external document", {"s.xml": b'<!DOCTYPE s SYSTEM "/dev/zero"><scene version="3.0.0"/>'}
    yield "quadratic blowup", {"s.xml": ('<!DOCTYPE s [<!ENTITY a "' + "x" * 100000 + '">]>'
                                         '<scene version="3.0.0" id="' + "&a;" * 10000 + '"/>').encode()}
    yield "deep", {"s.xml": b"<scene version='3.0.0'>" + b"<bsdf type='twosided'>" * 200000}
    yield "many attributes", {"s.xml": ("<scene version='3.0.0' " + " ".join(
        f"a{i}='1'" for i in range(100000)) + "/>").encode()}
    yield "a long value", {"s.xml": scene(f'<bsdf type="{"x" * 4000000}"/>')}
    yield "a long comment", {"s.xml": scene("<!--" + "x" * 4000000 + "-->" + SKY)}
    yield "deep json", {"s.xml": scene(SKY), "s.variables.json": b"[" * 300000}
    yield "wide json", {"s.xml": scene(SKY), "s.variables.json":
                        b'{"variables": [' + b'{"name": "a"},' * 200000 + b"{}]}"}
    doubling = "".join(f'<default name="a{i}" value="$a{i - 1}$a{i - 1}"/>' for i in range(1, 60))
    yield "doubling defaults", {"s.xml": scene(f'<default name="a0" value="xxxxxxxx"/>{doubling}{SKY}')}


def odd_files():
    for path in ("/dev/zero", "/dev/full", "pipe", "folder", "/proc/self/mem", "x" * 5000, "", ".", "a&#0;b"):
        yield f"texture {path[:20]}", {"s.xml": textured(path)}
        for kind in ("obj", "ply", "serialized"):
            yield f"{kind} {path[:20]}", {"s.xml": shape(kind, path)}
        yield f"include {path[:20]}", {"s.xml": scene(f'<include filename="{path}"/>')}
        yield f"spectrum {path[:20]}", {"s.xml": scene(
            f'<bsdf type="diffuse"><spectrum name="reflectance" filename="{path}"/></bsdf>')}


def corpus():
    for part in (cut_off, mislabelled, huge_counts, absurd_pictures, numbers, cycles, bombs, odd_files):
        yield from part()


# ---- Checkpoints: (name, {file: bytes}) with m.lmn and m.lmn.state ---------------------------------

def checkpoint(lumenaut, method, seed=0):
    """(model, state) of a small training."""
    options = {"improved": "--width 8 --depth 1 --memory 1 --resolution-max 16 --spp 1",
               "faithful": "--width 8 --depth 0 --patch-size 12 --chains 2 --memory 1 --spp 1"}[method]
    with tempfile.TemporaryDirectory(prefix="lumenaut-hostile-") as folder:
        write_all(pathlib.Path(folder), box_files())
        subprocess.run([lumenaut, "train", "s.xml", "-q", "-o", "m.lmn", "--steps", "2", "--eval-every",
                        "never", "--method", method, "--seed", str(seed), *options.split()],
                       cwd=folder, check=True)
        return tuple((pathlib.Path(folder) / name).read_bytes() for name in ("m.lmn", "m.lmn.state"))


def box_files():
    folder = ROOT / "tests/cli/scenes"
    return {"s.xml": (folder / "box.xml").read_bytes(),
            "s.variables.json": (folder / "box.variables.json").read_bytes()}


def write_all(folder, files):
    for path, data in files.items():
        (folder / path).write_bytes(data)


def edit(data, change):
    """The file with its header changed."""
    size = struct.unpack_from("<Q", data)[0]
    header = json.loads(data[8:8 + size])
    change(header)
    text = json.dumps(header).encode()
    return struct.pack("<Q", len(text)) + text + data[8 + size:]


def fill(data, tensor, value):
    """The file with the first bytes of a tensor replaced."""
    size = struct.unpack_from("<Q", data)[0]
    at = 8 + size + json.loads(data[8:8 + size])[tensor]["data_offsets"][0]
    return data[:at] + value + data[at + len(value):]


def broken(data, method):
    """(what, bytes) of one of the two files."""
    for n in places(len(data)):
        yield f"cut at {n}", data[:n]
    yield "too long", data + b"0"
    yield "a header of 2^64 - 1", b"\xff" * 8 + data[8:]
    yield "noise", bytes((i * 7919 + i // 251 * 104729) % 256 for i in range(3000))

    def put(key, value):
        return edit(data, lambda h: h["__metadata__"].__setitem__(key, value))

    size = struct.unpack_from("<Q", data)[0]
    header = json.loads(data[8:8 + size])
    for key in header["__metadata__"]:
        for value in ("", "9" * 30, "[null]", "{\n\u0000}"):
            yield f"{key} is {value!r}", put(key, value)
        yield f"no {key}", edit(data, lambda h, k=key: h["__metadata__"].pop(k))
    options = json.loads(header["__metadata__"]["options"])
    for key, value in options.items():
        for absurd in (-1, 4294967295, None):
            if absurd != value:
                yield f"option {key} = {absurd!r}", put("options", json.dumps({**options, key: absurd}))
    if method == "improved":
        network = json.loads(header["__metadata__"]["network"])
        for key in network:
            for absurd in (-1, [], ["a"] * 63, ["a"] * 100000, [["a", 1 << 62]], [[1], {}], None):
                yield f"network {key} = {str(absurd)[:30]}", put("network", json.dumps({**network, key: absurd}))
    for name in [n for n in header if n != "__metadata__"]:
        yield f"no {name}", edit(data, lambda h, k=name: h.pop(k))
        for what, change in {"rows 2^40": {"shape": [1 << 40]},
                             "elsewhere": {"data_offsets": [0, 1 << 50]}}.items():
            yield f"{name}: {what}", edit(data, lambda h, k=name, c=change: h[k].update(c))
        if header[name]["data_offsets"][0] < header[name]["data_offsets"][1]:
            yield f"{name}: NaN", fill(data, name, b"\xff" * 8)


def checkpoints(lumenaut):
    for method in ("improved", "faithful"):
        model, state = checkpoint(lumenaut, method)
        other_model, other_state = checkpoint(lumenaut, method, 5)
        for what, data in broken(model, method):
            yield f"{method} model: {what}", {"m.lmn": data, "m.lmn.state": state}
        for what, data in broken(state, method):
            yield f"{method} state: {what}", {"m.lmn": model, "m.lmn.state": data}
            if "option" in what or "state.counters" in what or "cut" in what:
                yield f"{method} state alone: {what}", {"m.lmn.state": data}
        for what, pair in {"alone": (model, b""), "swapped": (state, model), "two models": (model, model),
                           "two states": (state, state), "another state": (model, other_state),
                           "another model": (other_model, state)}.items():
            yield f"{method} {what}", dict(zip(("m.lmn", "m.lmn.state"), pair))


# ---- Running --------------------------------------------------------------------------------------

def run(command, folder):
    """status, stderr, seconds, mebibytes at most"""
    start = time.monotonic()
    with open(folder / "stderr", "w+b") as errors:
        process = subprocess.Popen(command, cwd=folder, stdin=subprocess.DEVNULL,
                                   stdout=subprocess.DEVNULL, stderr=errors)
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                break
            if time.monotonic() - start > SECONDS:
                process.kill()
            time.sleep(0.002)
        errors.seek(0)
        said = errors.read().decode("utf-8", "replace")
    return (os.waitstatus_to_exitcode(status), said, time.monotonic() - start, usage.ru_maxrss / 1024)


def is_finite(path):
    """Of a PFM."""
    data = path.read_bytes().split(b"\n", 3)[3]
    values = struct.unpack(f"<{len(data) // 4}f", data)
    return all(-1e38 < x < 1e38 for x in values)


def problem(command, files, most, shown, peaks):
    """What is wrong, or None; adds memory and seconds to `peaks`."""
    with tempfile.TemporaryDirectory(prefix="lumenaut-hostile-") as name:
        folder = pathlib.Path(name)
        (folder / "folder").mkdir()
        os.mkfifo(folder / "pipe")
        write_all(folder, files)
        status, said, seconds, mebibytes = run(command, folder)
        peaks.append((mebibytes, seconds))
        if shown:
            print(f"  {status} {seconds:.2f} s {mebibytes:.0f} MiB: {said.strip()[:300]}")
        if status not in (0, 3):
            return f"status {status}: {said[-2000:]}"
        lines = said.splitlines()
        if status == 3 and len(lines) != 1 or status == 0 and lines:
            return f"{len(lines)} lines: {said[:500]}"
        if any(ord(c) < 32 for c in "".join(lines)) or len(said) > 2000:
            return f"a long or unprintable message: {said[:500]!r}"
        if mebibytes > most:
            return f"{mebibytes:.0f} MiB"
        if status == 0 and "out.pfm" in command and not is_finite(folder / "out.pfm"):
            return "the picture is not finite"
        return None


def commands(lumenaut):
    """(name, files, command) of all that is tried."""
    quiet = ["-q", "-t", "1"]
    for name, files in corpus():
        yield name, files, [lumenaut, "trace", "s.xml", "-o", "out.pfm", "--spp", "2", *quiet]
    for name, files in checkpoints(lumenaut):
        files = {**box_files(), **files}
        if "m.lmn" in files and " model" in name:
            yield f"render {name}", files, [lumenaut, "render", "m.lmn", "-o", "out.pfm", "--size", "8x8",
                                            *quiet]
            if "network" in name or "grid" in name:
                yield f"from {name}", files, [lumenaut, "train", "s.xml", "-o", "x.lmn", "--from", "m.lmn",
                                              "--memory", "1", "--resolution-max", "16", "--spp", "1",
                                              "--steps", "1", "--eval-every", "never", *quiet]
        yield f"resume {name}", files, [lumenaut, "train", "s.xml", "-o", "m.lmn", "--resume", "--steps",
                                        "3", "--eval-every", "never", *quiet]


def main():
    lumenaut = str(pathlib.Path(sys.argv[1]).resolve())
    shown = sys.argv[2] if len(sys.argv) > 2 else None
    symbols = pathlib.Path(lumenaut).read_bytes()
    is_sanitized = b"__asan_init" in symbols or b"__tsan_init" in symbols
    most = SANITIZED_MEBIBYTES if is_sanitized else MEBIBYTES
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    n, failures, peaks = 0, [], []
    for name, files, command in commands(lumenaut):
        if shown is not None and shown not in name:
            continue
        n += 1
        if shown is not None:
            print(name)
        trouble = problem(command, files, most, shown is not None, peaks)
        if trouble:
            failures.append(name)
            print(f"{name}: {trouble}", flush=True)
    print(f"{n} files, {len(failures)} failures; at most {max(p[0] for p in peaks):.0f} MiB, "
          f"{max(p[1] for p in peaks):.1f} s")
    return 1 if failures or n == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
