# SPDX-License-Identifier: Apache-2.0
# render, eval and params on a model: its scene is found, a changed one refused, garbage too.
mkdir scenes
cp "$here"/scenes/box.* scenes
"$lumenaut" train scenes/box.xml -q -o m.lmn --method faithful --width 16 --depth 1 --patch-size 12 --resolution-start 24 \
    --memory 4 --spp 2 --eval-every never --steps 10 -D spp=3
"$lumenaut" render m.lmn -o a.exr -q -t 1 -P slide=50% --json >a.json
json 'd["size"] == [48, 32] and d["render_s"] > 0 and d["values"]["slide"] == 0' <a.json
"$lumenaut" render m.lmn -o b.exr -q -t 2
cmp a.exr b.exr
"$lumenaut" render m.lmn -o c.exr -q --size 20x30 --crop 2,3,5,7 --buffers --spp 2 --max-depth 3
"$lumenaut" render m.lmn -o c.exr -q --origin 0,3,4 --json | json 'd["camera"]["origin"] == [0, 3, 4]'
"$lumenaut" compare c.exr a.exr --json | json 'd["metrics"]["mape"] > 0.01'
"$lumenaut" render m.lmn -o - --format png -q --exposure 2 >c.png
"$lumenaut" compare c.png c.png >/dev/null
"$lumenaut" params m.lmn --json | json 'len(d["variables"]) == 6 and d["spp"] == 3'
"$lumenaut" eval m.lmn -n 3 --size 24 --spp 4 --sheet s.png --json -q >e.json
json 'd["n"] == 3 and len(d["configurations"]) == 3 and d["mean"]["mape"] > 0 and d["noise"]["mape"] > 0' <e.json
json 'abs(sum(c["metrics"]["mape"] for c in d["configurations"]) / 3 - d["mean"]["mape"]) < 1e-9' <e.json
json 'set(d["configurations"][0]["values"]) == {"slide", "tint.r", "tint.g", "tint.b", "gloss", "shown"}' <e.json
json 'd["frame_s"] > 0 and d["trace_s"] > 0' <e.json
"$lumenaut" eval m.lmn -n 3 --size 24 --spp 4 -q | grep -q '^MAPE'

# from elsewhere: relative to the model; moved: --scene
(cd scenes && "$lumenaut" render ../m.lmn -o x.png -q && rm x.png)
mv scenes moved
code 3 "$lumenaut" render m.lmn -o x.png -q 2>&1
"$lumenaut" render m.lmn -o d.exr -q --scene moved/box.xml
"$lumenaut" compare a.exr d.exr --json | json 'd["metrics"]["mse"] == 0'

# changed
sed -i 's/value="6, 6, 5"/value="6, 6, 4"/' moved/box.xml
code 3 "$lumenaut" render m.lmn -o x.png -q --scene moved/box.xml 2>&1
code 3 "$lumenaut" eval m.lmn -q --scene moved/box.xml 2>&1
code 3 "$lumenaut" train moved/box.xml -D spp=3 -q -o m.lmn --resume --steps 11 2>&1
"$lumenaut" render m.lmn -o e.exr -q --scene moved/box.xml --force

# garbage
: >empty.lmn
head -c 3000 "$lumenaut" >noise.lmn
for part in 1 2 3 4 5 6 7; do head -c $(($(wc -c <m.lmn) * part / 8)) m.lmn >cut$part.lmn; done
printf '\377\377\377\377\377\377\377\177{' >huge.lmn
for file in missing.lmn empty.lmn noise.lmn huge.lmn cut*.lmn; do
    for command in "render -o x.png" eval params; do
        code 3 "$lumenaut" $command $file -q --scene "$here/scenes/box.xml" 2>message
        [ "$(wc -l <message)" -eq 1 ] || { cat message >&2; exit 1; }
    done
    code 3 "$lumenaut" train "$here/scenes/box.xml" -q -o $file --resume --steps 5 2>message
    [ "$(wc -l <message)" -eq 1 ]
    code 3 "$lumenaut" plot $file -o x.svg 2>message
    [ "$(wc -l <message)" -eq 1 ]
done
[ ! -e x.png ] && [ ! -e x.svg ] && [ ! -e missing.lmn ] && [ ! -s empty.lmn ]
