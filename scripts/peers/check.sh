#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# check.sh: compares with the peers afresh: references are made anew and the tests that read them run on
# those; then tile means of big pictures against Mitsuba's.
set -u
cd "$(dirname "$0")/../.." || exit 1
fresh=$PWD/build/peers/references
status=0

rm -rf "$fresh"
sh scripts/references/run.sh "$fresh" || status=1
LMN_REFERENCES=$fresh ctest --test-dir build/release --output-on-failure \
    -R '^(image|nn|references)' || status=1
.venv/bin/python scripts/peers/check_trace.py --markdown docs/results/peers.md || status=1
.venv/bin/python scripts/peers/check_sky.py || status=1

[ $status -eq 0 ] && echo "peers: all agree" || echo "peers: some disagree"
exit $status
