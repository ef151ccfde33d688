#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# bench.sh: what this machine does: kernels against their peak, paths per second, a training step,
# a frame; and beside PyTorch and Mitsuba where `make peers` has installed them. One JSON document
# each in build/bench, and all of them as tables in bench/RESULTS.md.
set -u
cd "$(dirname "$0")/.." || exit 1
out=build/bench
rm -rf "$out"
mkdir -p "$out"
status=0

measure() { # measure NAME COMMAND...
    name=$1
    shift
    echo "== $*"
    "$@" >"$out/$name.json" || { status=1; rm -f "$out/$name.json"; }
}

for what in kernels train trace buffers frame; do
    measure "$what" build/release/lumenaut bench "$what" --json
done
if .venv/bin/python -c 'import torch, mitsuba' 2>/dev/null; then
    for what in train trace; do
        measure "peers-$what" .venv/bin/python "scripts/peers/bench_$what.py" --json
    done
else
    echo "peers: skipped, no .venv (make peers)"
fi
/usr/bin/python3 scripts/bench_report.py "$out" bench/RESULTS.md || status=1
exit $status
