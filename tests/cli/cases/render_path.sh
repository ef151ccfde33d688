# SPDX-License-Identifier: Apache-2.0
# render --path: frames of key frames, as files and as one stream; what is wrong with a path is told.
scene=$here/scenes/box.xml
"$lumenaut" train "$scene" -q -o m.lmn --width 16 --depth 1 --steps 20 --spp 4 --memory 8 --eval-every never
cat >keys.json <<'END'
{"lumenaut_path": 1, "fps": 4, "keys": [
 {"time": 0, "values": {"slide": -1, "shown": 1}, "camera": null},
 {"time": 1, "values": {"slide": 1, "shown": 0}, "camera": {"origin": [2, 2, 4], "target": [0, 0.7, 0],
  "up": [0, 1, 0], "fov": 40}}]}
END
"$lumenaut" render m.lmn --path keys.json -o f_%03d.png -q
[ "$(ls f_*.png | tr '\n' ' ')" = "f_000.png f_001.png f_002.png f_003.png f_004.png " ]

# keys are met, values are in between, a choice holds
"$lumenaut" render m.lmn -o a.png -q -P slide=-1 --up 0,1,0
"$lumenaut" compare a.png f_000.png --json | json 'd["metrics"]["mape"] < 0.01'
"$lumenaut" render m.lmn -o a.png -q -P slide=1 -P shown=off --origin 2,2,4 --target 0,0.7,0 --up 0,1,0 --fov 40
cmp a.png f_004.png
sed 's/"camera": {.*/"camera": null}]}/; /"up":/d' keys.json >still.json
"$lumenaut" render m.lmn --path still.json -o s_%d.png -q
"$lumenaut" render m.lmn -o a.png -q -P slide=0 -P shown=on
cmp a.png s_2.png

# one stream
"$lumenaut" render m.lmn --path keys.json -o m.y4m -q --size 20x10
"$lumenaut" render m.lmn --path keys.json -o - --format y4m -q --size 20x10 | cmp - m.y4m
[ "$(head -n 1 m.y4m)" = "YUV4MPEG2 W20 H10 F4000:1000 Ip A1:1 C444 XCOLORRANGE=LIMITED" ]
[ "$(wc -c <m.y4m)" = $(($(head -n 1 m.y4m | wc -c) + 5 * (6 + 600))) ]

# errors
code 2 "$lumenaut" render m.lmn --path keys.json -o f.png 2>&1
code 2 "$lumenaut" render m.lmn --path keys.json -o f_%s.png 2>&1
code 2 "$lumenaut" render m.lmn --path keys.json -o f_%d.png -P slide=0 2>&1
code 2 "$lumenaut" render m.lmn --path keys.json -o f_%d.png --fov 30 2>&1
code 3 "$lumenaut" render m.lmn --path none.json -o f_%d.png 2>&1
for bad in '{' '{}' '{"lumenaut_path": 1, "keys": []}' '{"lumenaut_path": 1, "fps": 0, "keys": []}' \
    '{"lumenaut_path": 1, "keys": [{"time": 0}, {"time": -1}]}' \
    '{"lumenaut_path": 1, "keys": [{"time": 0, "values": {"slid": 1}}, {"time": 1}]}' \
    '{"lumenaut_path": 1, "keys": [{"time": 0, "camera": {"fov": 3}}, {"time": 1}]}' \
    '{"lumenaut_path": 1, "keys": [{"time": 0}, {"time": 1e6}]}'; do
    echo "$bad" >bad.json
    code 3 "$lumenaut" render m.lmn --path bad.json -o f_%d.png 2>&1
done
! ls f_0.png 2>/dev/null
