# SPDX-License-Identifier: Apache-2.0
"""Scenes of make_tests.py about pictures and names: JPEG, EXR and PFM files, all metals, all glasses."""
import math
import struct

METALS = ("a-C Ag Al AlAs AlSb Au Be Cr CsI Cu Cu_palik Cu2O CuO d-C Hg HgTe Ir K Li MgO Mo Na_palik Nb "
          "Ni_palik Rh Se Se-e SiC SnTe Ta Te Te-e ThF4 TiC TiN TiO2 TiO2-e VC V_palik VN W "
          "none").split()
GLASSES = ("vacuum", "helium", "hydrogen", "air", "carbon dioxide", "water", "acetone", "ethanol",
           "carbon tetrachloride", "glycerol", "benzene", "silicone oil", "bromine", "water ice",
           "fused quartz", "pyrex", "acrylic glass", "polypropylene", "bk7", "sodium chloride", "amber",
           "pet", "diamond")


def balls(names, columns, radius, bsdf):
    """A wall of balls, one for each name."""
    out = ""
    for i, name in enumerate(names):
        x = (i % columns - (columns - 1) / 2) * 2.2 * radius
        y = 1.52 - (i // columns) * 2.2 * radius
        out += f"""
    <shape type="sphere">
        <point name="center" x="{x:.4f}" y="{y:.4f}" z="0"/>
        <float name="radius" value="{radius}"/>
{bsdf(name)}    </shape>
"""
    return out


def metal(name):
    return f"""        <bsdf type="conductor">
            <string name="material" value="{name}"/>
        </bsdf>
"""


def glass(name):
    return f"""        <bsdf type="plastic">
            <string name="int_ior" value="{name}"/>
            <string name="ext_ior" value="vacuum"/>
            <rgb name="diffuse_reflectance" value="0.05, 0.1, 0.3"/>
        </bsdf>
"""


def scenes(m):
    """name -> (what it shows, body)"""
    def picture(filename, extra, x):
        return (m.card('        <bsdf type="diffuse">\n' + m.bitmap("reflectance", filename, extra)
                       + "        </bsdf>\n")
                .replace('"card"', f'"{filename[9:].replace(".", "_")}"')
                .replace('value="0.75"', 'value="0.5"')
                .replace('<translate y="0.8"/>', f"<translate {x}/>"))

    sky = """
    <emitter type="constant">
        <rgb name="radiance" value="0.4, 0.4, 0.5"/>
    </emitter>
"""
    return {
        "metals": ("Every metal that has a name", balls(METALS, 7, 0.14, metal) + m.BACKLIT + sky),
        "ior_names": ("Every index of refraction that has a name",
                      balls(GLASSES, 6, 0.17, glass) + m.BACKLIT + sky),
        "bitmap_jpeg": ("Pictures as JPEG: baseline, progressive, grey; as EXR and PFM",
                        picture("textures/baseline.jpg", "", 'x="-0.95" y="1.25" z="-0.4"')
                        + picture("textures/progressive.jpg", "", 'x="0.25" y="1.35" z="-0.6"')
                        + picture("textures/grey.jpg", '            <boolean name="raw" value="true"/>\n',
                                  'x="1.2" y="0.6" z="0.1"')
                        + picture("textures/card.exr", "", 'x="-0.9" y="0.4" z="0.6"')
                        + picture("textures/card.pfm", "", 'x="0.2" y="0.4" z="0.7"') + m.BACKLIT),
    }


def own_scenes(m):
    return {
        "gridtexture": ("A grid, brightened",
                        m.material("diffuse", """        <texture type="scale" name="reflectance">
            <float name="scale" value="1.5"/>
            <texture type="gridtexture">
                <rgb name="color0" value="0.5, 0.3, 0.1"/>
                <rgb name="color1" value="0.1, 0.2, 0.4"/>
                <float name="line_width" value="0.1"/>
                <transform name="to_uv">
                    <scale x="6" y="4"/>
                </transform>
            </texture>
        </texture>
""") + m.THINGS + m.BACKLIT),
    }


# ---- JPEG ---------------------------------------------------------------------------------------

ZIGZAG = sorted(range(64), key=lambda i: (i // 8 + i % 8,
                                          i // 8 if (i // 8 + i % 8) % 2 else i % 8))
QUANTUM = 6


class Bits:
    def __init__(self):
        self.bytes, self.value, self.n = bytearray(), 0, 0

    def put(self, value, n):
        for i in range(n - 1, -1, -1):
            self.value = self.value << 1 | (value >> i & 1)
            self.n += 1
            if self.n == 8:
                self.bytes.append(self.value)
                if self.value == 255:
                    self.bytes.append(0)
                self.value = self.n = 0

    def number(self, code, length, value):
        """A code that ends in the number of bits of `value`, then these."""
        size = abs(value).bit_length()
        self.put(code | size, length)
        self.put(value if value > 0 else value + (1 << size) - 1, size)

    def end(self):
        while self.n:
            self.put(1, 1)
        return bytes(self.bytes)


def blocks_of(plane, n):
    """Quantised cosine coefficients, in zigzag order, of blocks of 8 x 8, row by row."""
    out = []
    c = [[math.cos((2 * x + 1) * u * math.pi / 16) for x in range(8)] for u in range(8)]
    for by in range(0, n, 8):
        for bx in range(0, n, 8):
            block = []
            for u in range(64):
                v, h = divmod(u, 8)
                total = sum((plane[(by + y) * n + bx + x] - 128) * c[v][y] * c[h][x]
                            for y in range(8) for x in range(8))
                scale = (0.5 if v and h else math.sqrt(0.125) if v or h else 0.25) / 2
                block.append(round(total * scale / QUANTUM))
            out.append([block[i] for i in ZIGZAG])
    return out


def put_dc(bits, value):
    bits.number(0, 4, value) # codes of four bits: the category itself


def put_ac(bits, block):
    run = 0
    for value in block[1:]:
        if value == 0:
            run += 1
            continue
        while run > 15:
            bits.put(0xA0, 8)
            run -= 16
        size = abs(value).bit_length() # codes of eight bits: the symbol's place in the table
        bits.put(run * 10 + size - 1, 8)
        bits.put(value if value > 0 else value + (1 << size) - 1, size)
        run = 0
    if run:
        bits.put(0xA1, 8)


def jpeg(planes, n, is_progressive):
    """n x n pixels, all planes (luma, or luma and two of chroma) of full size."""
    def segment(marker, data):
        return struct.pack(">2BH", 255, marker, len(data) + 2) + data

    def scan(components, first, last, coder):
        bits = Bits()
        coder(bits)
        header = bytes([len(components)]) + b"".join(bytes([k + 1, 0]) for k in components)
        return segment(0xDA, header + bytes([first, last, 0])) + bits.end()

    blocks = [blocks_of(p, n) for p in planes]
    parts = range(len(planes))

    def dc(bits, k, i):
        put_dc(bits, blocks[k][i][0] - (blocks[k][i - 1][0] if i else 0))

    def all_dc(bits):
        for i in range(len(blocks[0])):
            for k in parts:
                dc(bits, k, i)

    def everything(bits):
        for i in range(len(blocks[0])):
            for k in parts:
                dc(bits, k, i)
                put_ac(bits, blocks[k][i])

    def ac_of(k):
        def coder(bits):
            for block in blocks[k]:
                put_ac(bits, block)
        return coder

    symbols = [run << 4 | size for run in range(16) for size in range(1, 11)] + [0xF0, 0x00]
    tables = (bytes([0x00]) + bytes([0, 0, 0, 12] + [0] * 12) + bytes(range(12))
              + bytes([0x10]) + bytes([0] * 7 + [len(symbols)] + [0] * 8) + bytes(symbols))
    frame = struct.pack(">B2HB", 8, n, n, len(planes)) + b"".join(bytes([k + 1, 0x11, 0])
                                                                 for k in parts)
    out = (b"\xff\xd8" + segment(0xE0, b"JFIF\0\1\1\0\0\1\0\1\0\0")
           + segment(0xDB, b"\0" + bytes([QUANTUM] * 64))
           + segment(0xC2 if is_progressive else 0xC0, frame) + segment(0xC4, tables))
    if is_progressive:
        out += scan(parts, 0, 0, all_dc)
        out += b"".join(scan([k], 1, 63, ac_of(k)) for k in parts)
    else:
        out += scan(parts, 0, 63, everything)
    return out + b"\xff\xd9"


def ycc(pixels):
    """Three planes of R, G, B, R, G, B, ..."""
    r, g, b = (pixels[k::3] for k in range(3))
    y = [0.299 * x[0] + 0.587 * x[1] + 0.114 * x[2] for x in zip(r, g, b)]
    return y, [128 + (x[2] - x[3]) / 1.772 for x in zip(r, g, b, y)], \
        [128 + (x[0] - x[3]) / 1.402 for x in zip(r, g, b, y)]


def write_pfm(path, n, rgb_at):
    rows = b"".join(struct.pack("<3f", *rgb_at(x, y)) for y in reversed(range(n)) for x in range(n))
    path.write_bytes(f"PF\n{n} {n}\n-1.0\n".encode() + rows)


def write_files(m, folder):
    planes = ycc(m.picture(24))
    textures = folder / "textures"
    (textures / "baseline.jpg").write_bytes(jpeg(planes, 24, False))
    (textures / "progressive.jpg").write_bytes(jpeg(planes, 24, True))
    (textures / "grey.jpg").write_bytes(jpeg(planes[:1], 24, False))

    def card(x, y):
        return 0.1 + 0.03 * x, 0.7 - 0.03 * y, 0.2 if (x + y) % 5 else 0.8

    m.write_exr(textures / "card.exr", 20, 20, card)
    write_pfm(textures / "card.pfm", 20, card)
