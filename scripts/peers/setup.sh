#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# setup.sh: the programs that we compare with, pinned, in .venv; libllvm19 for Mitsuba's LLVM
# variants (Debian's libllvm15, which they would find first, fails). Does nothing when up to date.
set -u
cd "$(dirname "$0")/../.." || exit 1

requirements=scripts/peers/requirements.txt
stamp=.venv/lumenaut-peers.txt

sh scripts/deps.sh scripts/peers/packages.txt || exit 1
if [ -x .venv/bin/python ] && cmp -s "$requirements" "$stamp"; then exit 0; fi

echo "peers: installing into .venv (some gigabytes, minutes)"
[ -x .venv/bin/python ] || /usr/bin/python3 -m venv .venv || {
    echo "peers: /usr/bin/python3 -m venv .venv failed" >&2
    exit 1
}
mkdir -p build
.venv/bin/pip install --quiet --disable-pip-version-check -r "$requirements" >build/peers.log 2>&1 || {
    cat build/peers.log >&2
    echo "peers: pip could not install $requirements" >&2
    exit 1
}
cp "$requirements" "$stamp"
