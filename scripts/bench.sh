#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# bench.sh: what this machine does: kernels against their peak, paths per second, a training step,
# a frame. One JSON document each in build/bench.
set -u
cd "$(dirname "$0")/.." || exit 1
mkdir -p build/bench
status=0
for what in kernels trace train frame; do
    echo "== lumenaut bench $what"
    build/release/lumenaut bench "$what" --json >"build/bench/$what.json" || { status=1; continue; }
    cat "build/bench/$what.json"
done
exit $status
