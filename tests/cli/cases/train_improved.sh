# SPDX-License-Identifier: Apache-2.0
# The improved method, the default: the same bytes at once, on other threads, and killed on the way and resumed;
# its model renders and is measured; what it has not is refused.
scene=$here/scenes/box.xml
small="--width 16 --depth 1 --memory 4 --resolution-max 48 --spp 2 --eval-every never"
train() { "$lumenaut" train "$scene" -q "$@"; }
train $small -o one.lmn --steps 12 -t 1 --json | json 'd["steps"] == 12 and d["patches_traced"] == 12 * 16'
train $small -o two.lmn --steps 12 -t 2
cmp one.lmn two.lmn
cmp one.lmn.state two.lmn.state
train $small -o half.lmn --steps 5
train -o half.lmn --steps 12 --resume
cmp one.lmn half.lmn
cmp one.lmn.state half.lmn.state
train $small -o long.lmn --steps 215 # when paths are cut
train $small -o short.lmn --steps 207 -t 1
train -o short.lmn --steps 215 --resume
cmp long.lmn short.lmn
cmp long.lmn.state short.lmn.state
/usr/bin/python3 "$here/kill.py" 5 "$scene" $small
step=$(train -o killed.lmn --resume --steps 1 --json | sed 's/.*"steps":\([0-9]*\),.*/\1/')
end=$((step + 3))
train -o killed.lmn --resume --steps $end
train $small -o whole.lmn --steps $end
cmp killed.lmn whole.lmn
cmp killed.lmn.state whole.lmn.state
[ -z "$(ls | grep '\.tmp')" ] # what a kill left of a file is cleared away

# the model alone renders, and cannot be resumed; nor with the state of another training
mkdir away
cp one.lmn away
"$lumenaut" render away/one.lmn -q -o away/a.pfm --size 24x16
code 3 train -o away/one.lmn --resume --steps 20 2>message
[ "$(wc -l <message)" -eq 1 ] && grep -q 'without away/one.lmn.state: no such file' message
train $small --seed 5 -o other.lmn --steps 12
cp other.lmn.state away/one.lmn.state
code 3 train -o away/one.lmn --resume --steps 20 2>message
[ "$(wc -l <message)" -eq 1 ] && grep -q 'the state of another training' message
cp one.lmn.state away/one.lmn.state
train -o away/one.lmn --resume --steps 12
rm away/one.lmn
train -o away/one.lmn --resume --steps 12
cmp away/one.lmn one.lmn
[ "$(stat -c %s one.lmn)" -lt 16777216 ]

# what was told of exploration is kept, and may not change
train $small -o uniform.lmn --steps 3 --explore uniform --json | json 'd["steps"] == 3'
train -o uniform.lmn --steps 4 --resume --explore uniform
code 2 train -o uniform.lmn --steps 5 --resume --explore loss-only 2>&1

"$lumenaut" render one.lmn -q -o a.pfm --size 24x16
"$lumenaut" render one.lmn -q -o b.pfm --size 24x16 -t 1
cmp a.pfm b.pfm
"$lumenaut" eval one.lmn -q -n 2 --size 32 --spp 4 --json | json 'd["mean"]["mape"] > 0'

# its own options only, and a network of the scene's shape
code 2 train -o x.lmn --steps 1 --chains 3 2>&1
code 2 train --method improved -o x.lmn --steps 1 --depth 0 2>&1
code 2 train --method improved -o x.lmn --steps 1 --explore loss-only 2>&1
[ ! -e x.lmn ]
/usr/bin/python3 - <<'END'
for end in "", ".state":
    data = open("one.lmn" + end, "rb").read()
    assert rb'the scene\",\"cube' in data
    open("grids.lmn" + end, "wb").write(data.replace(rb'the scene\",\"cube', b"the scene and cube", 1))
    open("word.lmn" + end, "wb").write(data.replace(b"grids", b"girds", 1))
    open("short.lmn" + end, "wb").write(data[:len(data) // 2])
END
for file in grids.lmn word.lmn short.lmn; do
    code 3 "$lumenaut" render $file -q -o c.pfm 2>message
    [ "$(wc -l <message)" -eq 1 ]
    code 3 train -o $file --resume --steps 20 2>message
    [ "$(wc -l <message)" -eq 1 ]
    mv $file a.model
    code 3 train -o $file --resume --steps 20 2>message
    [ "$(wc -l <message)" -eq 1 ]
    mv a.model $file
done
[ ! -e c.pfm ]
