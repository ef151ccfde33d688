# SPDX-License-Identifier: Apache-2.0
# 60 steps are the same bytes at once, on other threads, and killed on the way and resumed.
scene=$here/scenes/box.xml
tiny="--method faithful --width 16 --depth 1 --patch-size 12 --resolution-start 24 --chains 4 --reuse-warmup 4 --reuse-batch 4 --memory 4 --spp 2 --eval-every never"
train() { "$lumenaut" train "$scene" -q $tiny "$@"; }
train -o one.lmn --steps 60 -t 1 --json >one.json
json 'd["steps"] == 60 and d["steps_this_run"] == 60 and not d["interrupted"]' <one.json
json 'd["cpu_s"] > 0 and d["peak_memory_bytes"] > d["memory_bytes"] > 0' <one.json
train -o two.lmn --steps 60 -t 2
cmp one.lmn two.lmn
train -o half.lmn --steps 30
train -o half.lmn --steps 60 --resume
cmp one.lmn half.lmn
cmp one.lmn.state half.lmn.state

# kill -9 somewhere after a checkpoint; what came after it is made again
/usr/bin/python3 "$here/kill.py" 10 "$scene" $tiny
printf '{"step":9999999,"loss":1}\n{"step":99' >>killed.metrics.jsonl
step=$("$lumenaut" train "$scene" -q -o killed.lmn --resume --steps 1 --json | sed 's/.*"steps":\([0-9]*\),.*/\1/')
end=$((step + 20))
"$lumenaut" train "$scene" -q -o killed.lmn --resume --steps $end
train -o whole.lmn --steps $end
cmp killed.lmn whole.lmn
cmp killed.lmn.state whole.lmn.state
# the log tells of each step once
/usr/bin/python3 - $end <<'END'
import json, sys
lines = [json.loads(line) for line in open("killed.metrics.jsonl")]
assert "run" in lines[0], lines[0]
steps = [line["step"] for line in lines[1:]]
assert steps == list(range(1, int(sys.argv[1]) + 1)), steps
END

# never past the asked total, other options refused
"$lumenaut" train "$scene" -q -o one.lmn --resume --steps 60 --json | json 'd["steps"] == 60 and d["steps_this_run"] == 0'
cmp one.lmn two.lmn
train -o one.lmn --resume --steps 61 --width 16
code 2 "$lumenaut" train "$scene" -q -o one.lmn --resume --steps 70 --width 17 2>&1
# an earlier model is kept aside
train -o half.lmn --steps 1
cmp half.lmn~ two.lmn
cmp half.lmn~.state two.lmn.state
# also what a kill left before the first model was written; a half of an older pair goes
rm half.lmn
train -o half.lmn --steps 2
[ ! -e half.lmn~ ] && [ -e half.lmn~.state ]
