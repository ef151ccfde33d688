#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# bench_learn.sh [OPTION...]: how fast the methods of training learn, with three seeds of 10 minutes on
# the bundled scene and sphere-caustic, and one of 20 minutes on veach-ajar and spaceship where they
# are; the faithful method also with few samples and large steps, which suit minutes better than hours.
# Seven hours, and some three for test sets the first time; run it again after an interruption. Options
# go to every `lumenaut bench learn`. Results in build/learn/10 and build/learn/20.
set -eu
cd "$(dirname "$0")/.."
outside=${LUMENAUT_SCENES:-../shared/scenes}/official

learn() { # learn MINUTES SEEDS [OPTION...] -- SCENE...
    minutes=$1 seeds=$2
    shift 2
    build/release/lumenaut bench learn --minutes "$minutes" --seeds "$seeds" --out "build/learn/$minutes" \
        --tests build/learn/tests --methods faithful:64,faithful:64:spp=32:learning_rate=0.0005,uniform,improved "$@"
}

if [ -e "$outside/sphere-caustic/scene.xml" ]; then
    learn 10 3 "$@" -- scenes/demo/scene.xml "$outside/sphere-caustic/scene.xml"
else
    learn 10 3 "$@" -- scenes/demo/scene.xml
fi
if [ -e "$outside/veach-ajar/scene.xml" ] && [ -e "$outside/spaceship/scene.xml" ]; then
    learn 20 1 "$@" -- "$outside/veach-ajar/scene.xml" "$outside/spaceship/scene.xml"
fi
