#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# test.sh [--lint | --long]: builds, runs tests and house rules, and ends with one line of counts,
# `N passed, N failed, N skipped`. Fails when anything failed.
#   (default)  all but `long` tests; house rules; all but `heavy`, `slow` and `long` ones under ASan+UBSan
#   --lint     house rules only
#   --long     every test, every test under ASan+UBSan, TSan on all but `slow` and `long` ones
set -u
cd "$(dirname "$0")/.." || exit 1
mode=${1:-}
jobs=$(nproc)
out=build/test
mkdir -p "$out"
: >"$out/results.txt"

note() { # note STATUS NAME [REASON]
    printf '%s\t%s\t%s\n' "$1" "$2" "${3:-}" >>"$out/results.txt"
}

seconds() { date +%s; }

# check NAME COMMAND...: exit 0 passed, 77 skipped with its last line as the reason, else failed.
check() {
    name=$1
    shift
    start=$(seconds)
    "$@" >"$out/check.log" 2>&1
    case $? in
    0) note passed "$name"; word=ok; grep 'warning:' "$out/check.log" ;;
    77) note skipped "$name" "$(tail -n 1 "$out/check.log")"; word=skipped ;;
    *) note failed "$name"; word=FAILED; head -n 60 "$out/check.log" ;;
    esac
    printf '%-44s %-8s %4d s\n' "$name" "$word" $(($(seconds) - start))
}

# suite PRESET CTEST-OPTIONS...: builds and runs the tests of a preset.
suite() {
    preset=$1
    shift
    check "build: $preset" sh scripts/build.sh "$preset"
    [ "$word" = ok ] || return
    rm -f "$out/$preset.xml"
    start=$(seconds)
    ctest --test-dir "build/$preset" -j "$jobs" --output-on-failure \
        --output-junit "$PWD/$out/$preset.xml" "$@" >"$out/$preset.log" 2>&1
    if [ -s "$out/$preset.xml" ]; then
        /usr/bin/python3 scripts/tally.py "$preset" "$out/$preset.xml" >"$out/$preset.txt"
        cat "$out/$preset.txt" >>"$out/results.txt"
        grep -q '^failed' "$out/$preset.txt" && cat "$out/$preset.log"
        printf '%-44s %-8s %4d s\n' "tests: $preset" \
            "$(grep -c '^passed' "$out/$preset.txt") ok" $(($(seconds) - start))
    else
        cat "$out/$preset.log"
        note failed "tests: $preset"
    fi
}

house_rules() {
    check "rules: includes and calls" /usr/bin/python3 scripts/checks/includes.py
    check "rules: text" /usr/bin/python3 scripts/checks/text.py
    check "rules: format" sh scripts/checks/format.sh
    check "rules: header as C99, C11, C++11" sh scripts/checks/header.sh
    check "rules: exported symbols" /usr/bin/python3 scripts/checks/symbols.py
    check "rules: variables against the schema" /usr/bin/python3 scripts/checks/schema.py
    check "rules: man pages" sh scripts/checks/man.sh
    check "rules: scripts" sh scripts/checks/scripts.sh
}

[ "$mode" = --lint ] || sh scripts/axe.sh

case $mode in
--lint)
    house_rules
    ;;
--long)
    suite release
    suite asan
    TSAN_OPTIONS="suppressions=$PWD/scripts/tsan.supp"
    export TSAN_OPTIONS
    suite tsan -LE 'slow|long'
    ;;
*)
    suite release -LE long
    house_rules
    # Objects are enough for warnings; GCC's optimizer warns in the ASan build, which is -Werror too.
    check "warnings: gcc" sh scripts/build.sh dev lumenaut_internal
    check "warnings: clang" sh scripts/build.sh clang
    suite asan -LE 'heavy|slow|long'
    ;;
esac

skipped=$(grep '^skipped' "$out/results.txt") && {
    echo "skipped:"
    echo "$skipped" | awk -F '\t' '{ printf "  %s: %s\n", $2, $3 }'
}
failed=$(grep '^failed' "$out/results.txt") && {
    echo "failed:"
    echo "$failed" | awk -F '\t' '{ printf "  %s\n", $2 }'
}
awk -F '\t' '{ n[$1]++ }
    END { printf "%d passed, %d failed, %d skipped\n", n["passed"], n["failed"], n["skipped"] }' \
    "$out/results.txt"
[ -z "$failed" ]
