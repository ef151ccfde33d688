#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# run.sh [FOLDER]: writes the reference files of the tests afresh from the peers: into tests/<area>/data,
# or into FOLDER/<area>, where LMN_REFERENCES=FOLDER makes the tests look.
set -u
cd "$(dirname "$0")/../.." || exit 1

status=0
while read -r script area; do
    [ -e "scripts/references/$script" ] || continue
    folder=${1:+$1/$area}
    folder=${folder:-tests/$area/data}
    mkdir -p "$folder"
    echo "$script -> $folder"
    .venv/bin/python "scripts/references/$script" "$folder" || {
        echo "references: $script failed" >&2
        status=1
    }
done <<LIST
metrics.py image
exr_files.py image
nn.py nn
field.py nn
trace.py render
LIST
exit $status
