# SPDX-License-Identifier: Apache-2.0
# The scene with a small pocket is what its script makes, and the beam comes in only where shutter,
# blind and block all let it: it brings half of the picture's light and more there, none elsewhere.
root=$here/../..
/usr/bin/python3 "$root/scripts/scenes/make_pocket.py" made >/dev/null
cmp made/scene.xml "$root/scenes/pocket/scene.xml"
cmp made/scene.variables.json "$root/scenes/pocket/scene.variables.json"
"$lumenaut" params made/scene.xml --json | json 'len(d["variables"]) == 25'
sum() { # sum SHUTTER BLIND BLOCK
    "$lumenaut" trace made/scene.xml -o picture.pfm -q --size 48x36 --spp 64 -P shutter="$1" -P blind="$2" \
        -P block="$3"
    /usr/bin/python3 -c 'import array
with open("picture.pfm", "rb") as f:
    head = [f.readline() for _ in range(3)]
    print(sum(array.array("f", f.read())))'
}
shut=$(sum 2 2 60)
open=$(sum 0 0 0)
holds() { /usr/bin/python3 -c "import sys; sys.exit(not ($1))" || { echo "not so: $1" >&2; exit 1; }; }
holds "$open > 1.5 * $shut > 0"
for only in "0.8 0 0" "-0.8 0 0" "0 0.9 0" "0 -0.9 0" "0 0 22" "0 0 -22" "4.2 0 0" "0 4.8 0" "0 0 90"; do
    one=$(sum $only)
    holds "abs($one / $shut - 1) < 0.02"
done
