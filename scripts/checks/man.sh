#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# man.sh [ROOT]: the man pages convert with scdoc and please mandoc.
cd "${1:-$(dirname "$0")/../..}" || exit 1
set -- docs/man/*.scd
[ -e "$1" ] || { echo "no docs/man/*.scd"; exit 77; }
pages=$(mktemp -d) || exit 1
trap 'rm -rf "$pages"' EXIT
status=0
for source in "$@"; do
    page=$pages/$(basename "$source" .scd)
    scdoc <"$source" >"$page" || { echo "$source: scdoc refuses it"; status=1; continue; }
    # scdoc starts every paragraph with .PP, also where man(7) needs none.
    mandoc -Tlint -W warning "$page" | sed "s|^mandoc: $page|$source|" |
        grep -v 'skipping paragraph macro' | grep . && status=1
done
exit $status
