# SPDX-License-Identifier: Apache-2.0
# Data on standard output, talk on standard error, which every mode of progress keeps to.
scene=$here/scenes/box.xml
"$lumenaut" trace "$scene" -o a.png -q >out 2>err
[ ! -s out ] && [ ! -s err ]
"$lumenaut" trace "$scene" -o a.png >out 2>err
[ ! -s out ] && grep -q '^lumenaut: a.png: 48x32, 8 spp' err
"$lumenaut" trace "$scene" -o a.png --progress=json --size 128x128 --spp 2 >out 2>err
[ ! -s out ]
/usr/bin/python3 - <<'END'
import json
events = [json.loads(line) for line in open("err")]
progress = [e for e in events if e["event"] == "progress"]
assert progress and all(0 <= e["fraction"] <= 1 and e["phase"] == "trace" for e in progress)
assert all({"elapsed_s", "rate"} <= e.keys() for e in progress)
assert [e["event"] for e in events[-2:]] == ["end", "note"], events[-2:]
END
"$lumenaut" trace "$scene" -o a.png --progress=bar --size 256x256 --spp 10 2>err
tr '\r' '\n' <err | grep -q '^trace \[=*>* *\] *[0-9]* %.*paths/s.*ETA'
# a closed pipe and a full disk are failures that are told
code 1 "$lumenaut" params "$scene" >/dev/full 2>err
cat err
