# SPDX-License-Identifier: Apache-2.0
# bench learn: the same results at once, on other threads, and killed on the way again and again.
scene=$here/scenes/box.xml
faithful=faithful:16:depth=1:memory_mib=16:resolution_start=32
improved=16:depth=1:memory_mib=4:resolution_max=48
learn() { "$lumenaut" bench learn "$scene" --methods $faithful,uniform:$improved,improved:$improved -q \
    --steps 6 --seeds 2 --configurations 3 --candidates 5 --resolution 24 --reference-spp 16 "$@"; }
learn --out one -t 1 >one.txt
[ "$(wc -l <one.txt)" -eq 14 ]
json 'd["steps"] == 6 and [len(r["evaluations"]) for r in d["scenes"][0]["runs"]] == [4] * 6' <one/results.json
json '[e["step"] for e in d["scenes"][0]["runs"][0]["evaluations"]] == [1, 2, 4, 6]' <one/results.json
json 'all(v > 0 for n in d["scenes"][0]["noise"].values() for k, v in n.items())' <one/results.json
json 'len(d["scenes"][0]["summary"]) == 6 and all(len(s["methods"]) == 3 for s in d["scenes"][0]["summary"])' \
    <one/results.json

/usr/bin/python3 -c 'import xml.dom.minidom as x; x.parse("one/box.svg")'

[ -s one/box-sheet.png ]
cmp one.txt one/table.txt

# --json prints the same document; nothing is done again
learn --out one -t 1 --json >again.json
cmp again.json one/results.json

/usr/bin/python3 "$here/kill_again.py" "$lumenaut" bench learn "$scene" -t 2 -q --steps 6 --seeds 2 \
    --methods $faithful,uniform:$improved,improved:$improved --configurations 3 --candidates 5 \
    --resolution 24 --reference-spp 16 --out two >two.txt
/usr/bin/python3 - <<'END'
import json

def timeless(x):
    if isinstance(x, list):
        return [timeless(i) for i in x]
    if not isinstance(x, dict):
        return x
    return {k: timeless(v) for k, v in x.items()
            if not k.endswith("_s") and k not in ("speedup", "threads", "tests")}

one, two = (timeless(json.load(open(f"{n}/results.json"))) for n in ("one", "two"))
assert one == two
END

# a training that comes apart is a result; the others go on
"$lumenaut" bench learn "$scene" --methods $faithful:learning_rate=1,improved:$improved -q --out apart \
    --steps 2 --seeds 1 --configurations 1 --candidates 1 --resolution 24 --reference-spp 4 >apart.txt
[ "$(grep -c ' inf ' apart.txt)" -eq 2 ]
json '"step" in d["scenes"][0]["runs"][0]["failure"] and not "failure" in d["scenes"][0]["runs"][1]' \
    <apart/results.json
[ -s apart/box-sheet.png ]

# one process at a time
code 1 /usr/bin/python3 - "$lumenaut" "$scene" <<'END' 2>&1
import fcntl, subprocess, sys
with open("one/.lock") as lock:
    fcntl.flock(lock, fcntl.LOCK_EX)
    sys.exit(subprocess.call([sys.argv[1], "bench", "learn", sys.argv[2], "--out", "one", "-q"]))
END

# more steps go on; other options, bad ones and other scenes do not
learn --out one --steps 8 | grep -q 'uniform'
json '[e["step"] for e in d["scenes"][0]["runs"][5]["evaluations"]] == [1, 2, 4, 6, 8]' <one/results.json
sed 's/"spp":8/"spp":12/' one/box-improved-16-depth=1-memory_mib=4-resolution_max=48-2.jsonl >changed
cp changed one/box-improved-16-depth=1-memory_mib=4-resolution_max=48-2.jsonl
code 2 learn --out one 2>&1
code 2 "$lumenaut" bench learn "$scene" 2>&1
code 2 "$lumenaut" bench learn --out x 2>&1
code 2 "$lumenaut" bench learn "$scene" --out x --methods improvd 2>&1
code 2 "$lumenaut" bench learn "$scene" --out x --methods improved:ssp=4 2>&1
code 2 "$lumenaut" bench learn "$scene" --out x --methods improved:spp=no 2>&1
code 2 "$lumenaut" bench learn "$scene" --out x --methods improved,improved 2>&1
code 2 "$lumenaut" bench learn "$scene" "$scene" --out x 2>&1
code 2 "$lumenaut" bench learn "$scene" --out x --candidates 3 2>&1
code 3 "$lumenaut" bench learn missing.xml --out x 2>&1
[ ! -e x ]
