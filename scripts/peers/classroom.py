#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""classroom.py: bitterli/classroom under skies that both renderers have: build/peers/classroom-*.xml.

Its sunsky is another model in Mitsuba 3 than here, so that only the rest of the scene can be
compared: under a constant sky, and under our own sky and sun, traced into a picture all around.
"""
import math
import pathlib
import subprocess
import tempfile
import xml.etree.ElementTree as ElementTree

import numpy as np

import cases
import freeze

SCENE = cases.OUTSIDE / "bitterli/classroom/scene.xml"
FOLDER = cases.ROOT / "build/peers"
LUMENAUT = cases.ROOT / "build/release/lumenaut"
WIDTH, FACE = 1024, 512

# A look at nothing but the sky, 90 degrees wide. Rows of a picture go down.
EYE = """<scene version="0.6.0">
    <sensor type="perspective">
        <float name="fov" value="90"/>
        <transform name="toWorld"><lookat origin="0, 0, 0" target="{forward}" up="{up}"/></transform>
        <film type="hdrfilm"><rfilter type="box"/></film>
    </sensor>
{emitter}</scene>
"""
FACES = {(1, 0, 0): (0, 1, 0), (-1, 0, 0): (0, 1, 0), (0, 1, 0): (0, 0, 1), (0, -1, 0): (0, 0, 1),
         (0, 0, 1): (0, 1, 0), (0, 0, -1): (0, 1, 0)}


def look(mi, emitter, forward, up, folder):
    scene, out = folder / "eye.xml", folder / "eye.exr"
    scene.write_text(EYE.format(forward=f"{forward}"[1:-1], up=f"{up}"[1:-1], emitter=emitter))
    subprocess.run([LUMENAUT, "trace", scene, "-o", out, "-q", "--size", f"{FACE}x{FACE}", "--spp",
                    "16", "--max-depth", "2", "--integrator", "path"], check=True)
    return np.array(mi.Bitmap(str(out)))[..., :3]


def all_around(mi, emitter):
    """[WIDTH / 2, WIDTH, 3]: what Mitsuba's envmap shows so that it looks like the emitter."""
    u, v = np.meshgrid((np.arange(WIDTH) + 0.5) / WIDTH, (np.arange(WIDTH // 2) + 0.5) / (WIDTH // 2))
    phi, theta = 2 * math.pi * u, math.pi * v
    d = np.stack([np.sin(phi) * np.sin(theta), np.cos(theta), -np.cos(phi) * np.sin(theta)], -1)
    image = np.zeros((*u.shape, 3), np.float32)
    with tempfile.TemporaryDirectory() as folder:
        for forward, up in FACES.items():
            picture = look(mi, emitter, forward, up, pathlib.Path(folder))
            f, top = np.array(forward), np.array(up)
            left = np.cross(top, f) # +x of the camera is to the left of the picture
            depth = d @ f
            mine = depth >= np.abs(d).max(axis=-1) - 1e-9
            x = (0.5 - 0.5 * (d @ left)[mine] / depth[mine]) * FACE
            y = (0.5 - 0.5 * (d @ top)[mine] / depth[mine]) * FACE
            image[mine] = picture[y.astype(int).clip(0, FACE - 1), x.astype(int).clip(0, FACE - 1)]
    return image


def make(mi):
    """Writes both scenes, once."""
    if not SCENE.exists() or all((FOLDER / f"classroom-{k}.xml").exists() for k in ("constant", "envmap")):
        return
    FOLDER.mkdir(parents=True, exist_ok=True)
    root = freeze.read_with_includes(str(SCENE))
    sky = root.find("emitter")
    image = all_around(mi, ElementTree.tostring(sky, encoding="unicode"))
    mi.Bitmap(image).write(str(FOLDER / "classroom-sky.exr"))
    skies = {"constant": '<emitter type="constant"><rgb name="radiance" value="6, 7, 9"/></emitter>',
             "envmap": '<emitter type="envmap"><string name="filename" value="'
                       f'{(FOLDER / "classroom-sky.exr").resolve()}"/></emitter>'}
    for name, text in skies.items():
        sky.clear()
        new = ElementTree.fromstring(text)
        sky.attrib.update(new.attrib)
        sky.extend(list(new))
        (FOLDER / f"classroom-{name}.xml").write_text(ElementTree.tostring(root, encoding="unicode"))


if __name__ == "__main__":
    import render_mitsuba
    make(render_mitsuba.use("llvm_ad_rgb"))
