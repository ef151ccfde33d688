#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""screenshots.py [FOLDER]: the viewer as a visitor sees it, as JPEG files in FOLDER [docs/results]: scenes/mirror
after a minute of training beside the path tracer after the same seconds, light and dark, and the small box of the
tests on a narrow screen; and many variables."""
import base64
import os
import pathlib
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "tests/viewer"))

from client import Viewer  # noqa: E402  (the tests' own)
from page import Page  # noqa: E402

LUMENAUT = str(ROOT / "build/release/lumenaut")
MIRROR = str(ROOT / "scenes/mirror/scene.xml")
POCKET = str(ROOT / "scenes/pocket/scene.xml")
SECONDS = 8  # for paths


def take(page, path):
    shot = page.driver.execute_cdp_cmd("Page.captureScreenshot", {"format": "jpeg", "quality": 85})
    path.write_bytes(base64.b64decode(shot["data"]))
    print(path)


def opened(url, words, width, height, is_dark=False):
    page = Page(f"{url}{'&' if '#' in url else '#'}{words}", width, height, is_dark)
    page.wait("connected", "document.getElementById('status').dataset.state === 'open'")
    return page


def main():
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "docs/results").resolve()
    with tempfile.TemporaryDirectory() as box:
        os.chdir(box)
        subprocess.run([LUMENAUT, "train", MIRROR, "-o", "mirror.lmn", "--time", "60s", "-t", "1", "-q"], check=True)
        with Viewer(LUMENAUT, "mirror.lmn") as v:
            for name, is_dark, tab in (("viewer", False, "scene"), ("viewer-dark", True, "camera")):
                with opened(v.url, "mode=split", 1400, 980, is_dark) as page:
                    page.tab(tab)
                    time.sleep(SECONDS)
                    take(page, folder / f"{name}.jpg")
            with opened(v.url, "mode=neural", 500, 900) as page:
                page.settle()
                time.sleep(2)
                take(page, folder / "viewer-narrow.jpg")
        with Viewer(LUMENAUT, POCKET) as v, opened(v.url, "mode=traced", 1400, 980) as page:
            time.sleep(SECONDS)
            take(page, folder / "viewer-many.jpg")
    return 0


if __name__ == "__main__":
    sys.exit(main())
