# SPDX-License-Identifier: Apache-2.0
# Missing, cut-off and wrong files: exit 3, one line that names the place, no output file.
bad() { # bad FILE...: trace must refuse it
    code 3 "$lumenaut" trace "$@" -o out.png -q 2>message
    cat message
    [ "$(wc -l <message)" -eq 1 ] || { echo "not one line: $*" >&2; exit 1; }
    [ ! -e out.png ] && [ -z "$(ls out.png* 2>/dev/null)" ]
}
scene=$here/scenes/box.xml
bad missing.xml
mkdir folder
bad folder
: >empty.xml
bad empty.xml
size=$(wc -c <"$scene")
for part in 1 2 3; do
    head -c $((size * part / 4)) "$scene" >cut.xml
    bad cut.xml
done
head -c 3000 "$lumenaut" >noise.xml
bad noise.xml
sed 's/name="fov"/name="fow"/' "$scene" >typo.xml
bad typo.xml
sed 's/type="cube"/type="cub"/' "$scene" >kind.xml
bad kind.xml
sed 's/value="45"/value="400"/' "$scene" >range.xml
bad range.xml
bad "$scene" --variables missing.json
head -c 200 "$here/scenes/box.variables.json" >cut.json
bad "$scene" --variables cut.json
sed 's/cube.to_world/cub.to_world/' "$here/scenes/box.variables.json" >target.json
bad "$scene" --variables target.json
bad "$scene" -D spq=3

for file in missing.exr empty.xml noise.xml folder; do
    code 3 "$lumenaut" compare "$file" "$file" 2>message
    cat message
    [ "$(wc -l <message)" -eq 1 ]
done
"$lumenaut" trace "$scene" -o good.exr -q
"$lumenaut" trace "$scene" -o good.png -q
"$lumenaut" trace "$scene" -o small.png -q --size 20x20
for file in good.exr good.png; do
    for part in 1 2 3; do
        head -c $(($(wc -c <$file) * part / 4)) $file >cut
        code 3 "$lumenaut" compare cut $file 2>message
        [ "$(wc -l <message)" -eq 1 ]
    done
done
code 3 "$lumenaut" compare small.png good.png 2>&1
