# SPDX-License-Identifier: Apache-2.0
# Fine-tuning: what is taken over, new and dropped is said, line by line; then it is a training as any
# other, with checkpoints of its own.
cp "$here"/scenes/box.* .
small="--memory 4 --resolution-max 48 --spp 2"
run() { "$lumenaut" train -t 1 --progress=none --eval-every never --time 1000s "$@"; }
run box.xml --method improved --width 16 --depth 1 $small -q -o base.lmn --steps 8
"$lumenaut" train box.xml --from base.lmn $small -o same.lmn --steps 3 --eval-every never --progress=none 2>said
grep -c '^lumenaut: taken over: ' said
code 1 grep -q ': new: \|: dropped: ' said
grep -q 'taken over: 1 layers of 16' said
run box.xml -q -o same.lmn --resume --steps 5
rm base.lmn.state
run box.xml --from base.lmn $small -q -o whole.lmn --steps 5
cmp same.lmn whole.lmn
cmp same.lmn.state whole.lmn.state
run box.xml --from base.lmn $small -q -o killed.lmn --steps 2
mv base.lmn hidden.lmn
run box.xml -q -o killed.lmn --resume --steps 5
mv hidden.lmn base.lmn
cmp killed.lmn whole.lmn

# one variable gone, one renamed; over the model itself
/usr/bin/python3 - <<'END'
import json
d = json.load(open("box.variables.json"))
d["variables"] = [v for v in d["variables"] if v["name"] != "gloss"]
d["variables"][0]["name"] = "shift"
json.dump(d, open("box.variables.json", "w"))
END
run box.xml --from base.lmn $small -o base.lmn --steps 2 2>said
grep ': new: \|: dropped: \|earlier' said

# not to be had
code 3 run box.xml --from nothing.lmn -q -o x.lmn --steps 1 2>&1
code 3 run box.xml --from base.lmn --width 17 -q -o x.lmn --steps 1 2>&1
code 3 run box.xml --from base.lmn --method faithful -q -o x.lmn --steps 1 2>&1
code 2 run box.xml --from base.lmn --resume -q -o base.lmn --steps 3 2>&1
code 3 run box.xml --from box.xml -q -o x.lmn --steps 1 2>&1
[ ! -e x.lmn ]
