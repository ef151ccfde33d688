#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# demo.sh: trains the bundled scene for two minutes, then draws neural | path traced | FLIP of
# configurations that training never saw, and the curves of the run. Files go to build/demo.
set -u
cd "$(dirname "$0")/.." || exit 1
lumenaut=build/release/lumenaut
out=build/demo
mkdir -p "$out"

echo "1/3 training scenes/demo/scene.xml for ${DEMO_TIME:=2m} -> $out/demo.lmn"
rm -f "$out/demo.lmn" "$out/demo.lmn.state" "$out/demo.metrics.jsonl"
$lumenaut train scenes/demo/scene.xml -o "$out/demo.lmn" --seed 1 \
    --time "$DEMO_TIME" --eval-every 30s || exit 1
echo "2/3 comparing with path-traced pictures of unseen configurations -> $out/sheet.png"
$lumenaut eval "$out/demo.lmn" --n 6 --size 192 --spp 256 --sheet "$out/sheet.png" || exit 1
echo "3/3 drawing the run -> $out/progress.svg"
$lumenaut plot "$out/demo.lmn" -o "$out/progress.svg" || exit 1

echo
echo "model   $out/demo.lmn"
echo "sheet   $out/sheet.png       neural | path traced | FLIP"
echo "curves  $out/progress.svg"
echo "next    $lumenaut view $out/demo.lmn        a page with a slider for each variable"
echo "        $lumenaut render $out/demo.lmn -P NAME=50% -o picture.png"
