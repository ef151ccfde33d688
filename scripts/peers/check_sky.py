#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""check_sky.py: how far our sky is from Mitsuba's, which is another model; never fails.

Prints the table of docs/scene-format.md: luminance of what a horizontal plate gets of the sky, and
a plate that faces the sun of the sun, ours over Mitsuba's.
"""
import math
import pathlib
import subprocess
import tempfile

import numpy as np

import cases
import render_mitsuba

TURBIDITIES, ELEVATIONS = (2, 3, 6), (5, 15, 45, 75)
LUMINANCE = np.array([0.2126729, 0.7151522, 0.0721750])
SIZE, SPP = 4, 4096

# A white plate that fills the picture, lit by one part of the emitter.
SCENE = """<scene version="3.0.0">
    <sensor type="orthographic">
        <transform name="to_world">
            <lookat origin="{eye}" target="0, 0, 0" up="0, 1, 0"/>
        </transform>
        <film type="hdrfilm"><rfilter type="box"/></film>
    </sensor>
    <shape type="rectangle">
        <transform name="to_world">
            <scale value="9"/>
            <lookat origin="0, 0, 0" target="{normal}" up="0, 1, 0"/>
        </transform>
        <bsdf type="diffuse"><rgb name="reflectance" value="1"/></bsdf>
    </shape>
    <emitter type="sunsky">
        <vector name="sun_direction" x="{sun[0]}" y="{sun[1]}" z="{sun[2]}"/>
        <float name="turbidity" value="{turbidity}"/>
        <float name="{dark}" value="0"/>
    </emitter>
</scene>
"""


def plate(part, turbidity, elevation):
    angle = math.radians(elevation)
    sun = (math.cos(angle), 0.0, math.sin(angle))
    normal = (0.0, 0.0, 1.0) if part == "sky" else sun
    place = ", ".join(f"{x:.7f}" for x in normal)
    return SCENE.format(eye=place, normal=place, sun=sun, turbidity=turbidity,
                        dark="sun_scale" if part == "sky" else "sky_scale")


def main():
    mi = render_mitsuba.use("llvm_ad_rgb")
    settings = {"max_depth": 2, "rr_depth": 5}
    print("| |", " | ".join(f"{e}°" for e in ELEVATIONS), "|")
    with tempfile.TemporaryDirectory() as folder:
        path, out = pathlib.Path(folder) / "plate.xml", pathlib.Path(folder) / "plate.exr"
        for turbidity in TURBIDITIES:
            for part in ("sky", "sun"):
                row = []
                for elevation in ELEVATIONS:
                    text = plate(part, turbidity, elevation)
                    path.write_text(text)
                    subprocess.run([cases.ROOT / "build/release/lumenaut", "trace", path, "-o", out,
                                    "--size", f"{SIZE}x{SIZE}", "--spp", str(SPP), "--max-depth",
                                    "2", "--integrator", "path"], check=True, capture_output=True)
                    ours = np.array(mi.Bitmap(str(out)))[..., :3].mean(axis=(0, 1))
                    scene, integrator = render_mitsuba.load(mi, text, (SIZE, SIZE), settings)
                    theirs = render_mitsuba.render(mi, scene, integrator, SPP, 0)
                    row.append(ours @ LUMINANCE / (theirs.mean(axis=(0, 1)) @ LUMINANCE))
                print(f"| {part}, turbidity {turbidity} |",
                      " | ".join(f"{x:.2f}" for x in row), "|", flush=True)


if __name__ == "__main__":
    main()
