# SPDX-License-Identifier: Apache-2.0
# Training with photons: the same bytes on other threads and after a resumption; the option is kept.
scene=$here/scenes/box.xml
tiny="--method faithful --width 16 --depth 1 --patch-size 12 --resolution-start 24 --chains 4 --reuse-warmup 4 --reuse-batch 4 --memory 4 --spp 2 --eval-every never"
train() { "$lumenaut" train "$scene" -q $tiny "$@"; }
train -o one.lmn --steps 20 -t 1 --integrator path+photons --json >one.json
json 'd["steps"] == 20' <one.json
train -o two.lmn --steps 20 -t 2 --integrator path+photons
cmp one.lmn two.lmn
train -o half.lmn --steps 10 --integrator path+photons
"$lumenaut" train "$scene" -q -o half.lmn --steps 20 --resume
cmp one.lmn half.lmn

# kill -9 after a checkpoint
/usr/bin/python3 "$here/kill.py" 5 "$scene" $tiny --integrator path+photons
step=$("$lumenaut" train "$scene" -q -o killed.lmn --resume --steps 1 --json | sed 's/.*"steps":\([0-9]*\),.*/\1/')
end=$((step + 10))
"$lumenaut" train "$scene" -q -o killed.lmn --resume --steps $end
train -o whole.lmn --steps $end --integrator path+photons
cmp killed.lmn whole.lmn

# the improved method, which may look by itself
small="--width 16 --depth 1 --memory 4 --resolution-max 48 --spp 2 --eval-every never"
improve() { "$lumenaut" train "$scene" -q $small "$@"; }
improve -o sharp.lmn --steps 12 -t 1 --integrator path+photons
improve -o alike.lmn --steps 12 -t 2 --integrator path+photons
improve -o apart.lmn --steps 5 --integrator path+photons
"$lumenaut" train "$scene" -q -o apart.lmn --steps 12 --resume
improve -o blunt.lmn --steps 12 --integrator path
cmp sharp.lmn alike.lmn
cmp sharp.lmn apart.lmn
! cmp -s sharp.lmn blunt.lmn
improve -o looked.lmn --steps 12
improve -o named.lmn --steps 12 --integrator auto
cmp looked.lmn named.lmn

# path is the faithful method's default, and what a file without the option means
train -o plain.lmn --steps 20
train -o path.lmn --steps 20 --integrator path
cmp plain.lmn path.lmn
! cmp -s plain.lmn one.lmn
! grep -aq integrator plain.lmn
grep -aq integrator one.lmn
"$lumenaut" eval one.lmn -n 1 --size 16 --spp 16 --json -q | json 'd["mean"]["mape"] > 0'

# auto looks at the scene; a run keeps its integrator
train -o auto.lmn --steps 20 --integrator auto
grep -aq integrator auto.lmn
code 2 "$lumenaut" train "$scene" -q -o one.lmn --resume --steps 30 --integrator auto 2>&1
