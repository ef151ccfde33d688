#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# build.sh PRESET [TARGET...]: configures build/PRESET when needed and builds it. CMake's chatter is
# shown only when it fails.
set -u
preset=$1
shift
cd "$(dirname "$0")/.." || exit 1

log=build/$preset.log
mkdir -p build
if [ ! -f "build/$preset/build.ninja" ]; then
    cmake --preset "$preset" >"$log" 2>&1 || { cat "$log" >&2; exit 1; }
fi
cmake --build --preset "$preset" ${1:+--target "$@"} >"$log" 2>&1 || {
    # Ninja's lines of what went well say nothing here.
    grep -v '^\[[0-9]*/[0-9]*\] [A-Z]' "$log" >&2
    exit 1
}
