#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# bench_ablation.sh [OPTION...]: the improved method with each of its parts left out, one at a time, for
# the same time: 5 minutes each on the bundled scene, and on sphere-caustic where it is; mirrors and
# glass on scenes/mirror. Two hours; run it again after an interruption. Options go to
# `lumenaut bench learn`. Results in build/learn/ablation.
set -eu
cd "$(dirname "$0")/.."
outside=${LUMENAUT_SCENES:-../shared/scenes}/official/sphere-caustic/scene.xml

learn() { # learn OUT METHODS [OPTION...] -- SCENE...
    out=$1 methods=improved,$2
    shift 2
    build/release/lumenaut bench learn --methods "$methods" --minutes 5 --seeds 1 \
        --configurations 32 --candidates 64 --probe 30s --resolution 64 --reference-spp 1024 \
        --out "build/learn/$out" --tests build/learn/tests "$@"
}

parts=uniform,improved:resolution_max=600 # exploration off; pixels of pictures instead of points
for part in 1 2 4 8 16 32 64 128 256; do # LMN_WITHOUT_* of lumenaut.h
    parts=$parts,improved:without=$part
done
learn ablation/chains improved:without=512 "$@" -- scenes/mirror/scene.xml
if [ -e "$outside" ]; then
    learn ablation "$parts" "$@" -- scenes/demo/scene.xml "$outside"
else
    learn ablation "$parts" "$@" -- scenes/demo/scene.xml
fi
