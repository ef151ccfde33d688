#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# axe.sh: the wheel of tests/viewer/axe.txt into build/axe, for tests/viewer/axe.py, which is skipped
# without it. Does nothing when it is there.
set -u
cd "$(dirname "$0")/.." || exit 1
ls build/axe/*.whl >/dev/null 2>&1 && exit 0
/usr/bin/python3 -m pip download --quiet --disable-pip-version-check --no-deps --require-hashes \
    -r tests/viewer/axe.txt -d build/axe 2>/dev/null || echo "axe: PyPI has not given it"
