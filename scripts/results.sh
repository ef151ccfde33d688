#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# results.sh: the paper's central comparison, active exploration beside uniform draws, on two of its
# authors' scenes at equal time, tracing included: curves and sheets in build/results, to be looked
# at and copied to docs/results. Four runs of RESULTS_TIME (15m) on RESULTS_THREADS threads (all).
set -u
cd "$(dirname "$0")/.." || exit 1
lumenaut=build/release/lumenaut
scenes=${LUMENAUT_SCENES:-../shared/scenes}
out=build/results
threads=${RESULTS_THREADS:-0}
mkdir -p "$out"
[ -d "$scenes/official" ] || {
    echo "results: skipped, no scenes in $scenes (set LUMENAUT_SCENES)"
    exit 0
}

# run SCENE SPP: the paper's constants but for a width, step size and samples that suit a CPU.
run() {
    scene=$1
    for explore in active uniform; do
        model=$out/$scene-$explore
        $lumenaut train "$scenes/official/$scene/scene.xml" -o "$model.lmn" --method faithful --explore $explore \
            --seed 1 --width 128 --learning-rate 5e-4 --spp "$2" --time "${RESULTS_TIME:-15m}" \
            --eval-every 90s --eval-n 8 --eval-size 64 --eval-spp 512 --memory 512 -t "$threads" \
            --json >"$model.train.json" || exit 1
        $lumenaut eval "$model.lmn" --n 6 --size 128 --spp 512 --sheet "$model.png" \
            --json >"$model.json" || exit 1
    done
    $lumenaut plot "$out/$scene-active.metrics.jsonl" "$out/$scene-uniform.metrics.jsonl" \
        -o "$out/$scene.svg" || exit 1
    $lumenaut plot "$out/$scene-active.metrics.jsonl" -o "$out/$scene-chains.svg" || exit 1
}

run sphere-caustic 64
run veach-ajar 32
echo "curves and sheets are in $out"
