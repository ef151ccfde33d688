#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# bench_ablation.sh [OPTION...]: the improved method with each of its parts left out, one at a time, for
# the same time: 5 minutes each on the bundled scene, and on sphere-caustic where it is. Two hours; run
# it again after an interruption. Options go to `lumenaut bench learn`. Results in build/learn/ablation.
set -eu
cd "$(dirname "$0")/.."
outside=${LUMENAUT_SCENES:-../shared/scenes}/official/sphere-caustic/scene.xml

methods=improved,improved:resolution_max=600 # pixels of pictures instead of points
for part in 1 2 4 8 16 32 64 128 256 512; do # LMN_WITHOUT_* of lumenaut.h
    methods=$methods,improved:without=$part
done
set -- "$@" -- scenes/demo/scene.xml
if [ -e "$outside" ]; then set -- "$@" "$outside"; fi
exec build/release/lumenaut bench learn --methods "$methods" --minutes 5 --seeds 1 \
    --configurations 32 --candidates 64 --probe 30s --resolution 64 --reference-spp 1024 \
    --out build/learn/ablation --tests build/learn/tests "$@"
