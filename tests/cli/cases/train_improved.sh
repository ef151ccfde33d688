# SPDX-License-Identifier: Apache-2.0
# The improved method: the same bytes at once, on other threads, and killed on the way and resumed;
# its model renders and is measured; what it has not is refused.
scene=$here/scenes/box.xml
small="--method improved --width 16 --depth 1 --memory 4 --resolution-max 48 --spp 2 --eval-every never"
train() { "$lumenaut" train "$scene" -q "$@"; }
train $small -o one.lmn --steps 12 -t 1 --json | json 'd["steps"] == 12 and d["patches_traced"] == 12 * 64'
train $small -o two.lmn --steps 12 -t 2
cmp one.lmn two.lmn
train $small -o half.lmn --steps 5
train -o half.lmn --steps 12 --resume
cmp one.lmn half.lmn
/usr/bin/python3 "$here/kill.py" 5 "$scene" $small
step=$(train -o killed.lmn --resume --steps 1 --json | sed 's/.*"steps":\([0-9]*\),.*/\1/')
end=$((step + 3))
train -o killed.lmn --resume --steps $end
train $small -o whole.lmn --steps $end
cmp killed.lmn whole.lmn

# what was told of exploration is kept, and may not change
train $small -o uniform.lmn --steps 3 --explore uniform --json | json 'd["steps"] == 3'
train -o uniform.lmn --steps 4 --resume --explore uniform
code 2 train -o uniform.lmn --steps 5 --resume --explore loss-only 2>&1

"$lumenaut" render one.lmn -q -o a.pfm --size 24x16
"$lumenaut" render one.lmn -q -o b.pfm --size 24x16 -t 1
cmp a.pfm b.pfm
"$lumenaut" eval one.lmn -q -n 2 --size 32 --spp 4 --json | json 'd["mean"]["mape"] > 0'

# its own options only, and a network of the scene's shape
code 2 train --method improved -o x.lmn --steps 1 --chains 3 2>&1
code 2 train --method improved -o x.lmn --steps 1 --depth 0 2>&1
code 2 train --method improved -o x.lmn --steps 1 --integrator auto 2>&1
code 2 train --method improved -o x.lmn --steps 1 --explore loss-only 2>&1
[ ! -e x.lmn ]
/usr/bin/python3 - <<'END'
import re
data = open("one.lmn", "rb").read()
open("grids.lmn", "wb").write(re.sub(rb'grids\\":\d', rb'grids\\":9', data, count=1))
open("word.lmn", "wb").write(re.sub(rb'grids\\":\d', rb'grids\\":x', data, count=1))
open("short.lmn", "wb").write(data[:len(data) // 2])
END
for file in grids.lmn word.lmn short.lmn; do
    code 3 "$lumenaut" render $file -q -o c.pfm 2>message
    [ "$(wc -l <message)" -eq 1 ]
    code 3 train -o $file --resume --steps 20 2>message
    [ "$(wc -l <message)" -eq 1 ]
done
[ ! -e c.pfm ]
