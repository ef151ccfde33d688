# SPDX-License-Identifier: Apache-2.0
# trace: every format, standard output, JSON, windows, the same bytes for any number of threads.
scene=$here/scenes/box.xml
"$lumenaut" trace "$scene" -o a.exr --json -q >a.json
json 'd["command"] == "trace" and d["size"] == [48, 32] and d["spp"] == 8' <a.json
json 'd["render_s"] > 0 and d["load_s"] > 0 and d["paths_per_s"] > 0' <a.json
json 'd["peak_memory_bytes"] > 1e6 and d["channels"] == ["R", "G", "B"]' <a.json
json 'd["values"]["slide"] == 0 and d["values"]["shown"] == 1' <a.json

# threads and repetition
"$lumenaut" trace "$scene" -o b.exr -q -t 1
"$lumenaut" trace -q "$scene" -t 2 -o c.exr
cmp b.exr c.exr
"$lumenaut" trace "$scene" -o d.exr -q --seed 1
! cmp -s b.exr d.exr

# formats, by name and by --format, and the pipe
"$lumenaut" trace "$scene" -o a.png -q
"$lumenaut" trace "$scene" -o a.pfm -q
"$lumenaut" trace "$scene" -o a.dat --format png -q
cmp a.png a.dat
"$lumenaut" trace "$scene" -o - --format png -q | cmp - a.png
"$lumenaut" trace "$scene" -o - --format exr -q -t 2 >e.exr
"$lumenaut" compare e.exr b.exr --json | json 'd["metrics"]["mse"] == 0'
[ "$(head -c 8 a.png | od -An -tx1 | tr -d ' \n')" = 89504e470d0a1a0a ]

# from elsewhere: what is left out is the scene's
"$lumenaut" trace "$scene" -o k.exr -q --origin 0,1.5,5 --json >k.json
json 'd["camera"]["origin"] == [0, 1.5, 5] and d["camera"]["fov"] == 45' <k.json
"$lumenaut" compare k.exr b.exr --json | json 'd["metrics"]["mape"] < 0.02'
"$lumenaut" trace "$scene" -o k.exr -q --target -1,0.7,-1e-1 --up 0.1,1,0 --fov 30 --json >k.json
json 'd["camera"]["target"] == [-1, 0.7, -0.1] and d["camera"]["fov"] == 30' <k.json
"$lumenaut" compare k.exr b.exr --json | json 'd["metrics"]["mape"] > 0.1'
for wrong in "--origin 1,2" "--target 1,2,3,4" "--up 0,0,0" "--up 1,,2" "--fov 180" "--target 0,1.5,5" "--origin 1,2,inf"; do
    code 2 "$lumenaut" trace "$scene" -o x.png -q $wrong 2>>said
done

# channels
"$lumenaut" trace "$scene" -o f.exr -q --buffers --half-buffers --spp 3 --json >f.json
json 'd["spp"] == 4 and len(d["channels"]) == 34' <f.json
json '"a.R" in d["channels"] and "normal.X" in d["channels"]' <f.json

# light groups: by emitter, named, with photons
"$lumenaut" trace "$scene" -o l.exr -q --light-groups --json >l.json
json 'd["channels"] == ["R", "G", "B", "lamp.emitter.R", "lamp.emitter.G", "lamp.emitter.B"]' <l.json
"$lumenaut" trace "$scene" -o l.exr -q --light-groups=all=lamp --integrator path+photons --json >l.json
json 'd["channels"] == ["R", "G", "B", "all.R", "all.G", "all.B"] and d["integrator"] == "path+photons"' <l.json
code 2 "$lumenaut" trace "$scene" -o x.png --light-groups=all=lmap 2>>said

# behind mirrors and glass
"$lumenaut" trace "$scene" -o m.exr -q --follow-delta --split-delta --json >m.json
json 'len(d["channels"]) == 41 and {"chain_throughput.R", "chain_emission.B", "chain_length.Y", "rest.R", "seen.B"} <= set(d["channels"])' <m.json
"$lumenaut" trace "$scene" -o m.exr -q --split-delta --light-groups --integrator path+photons --json >m.json
json 'd["channels"][3::3] == ["lamp.emitter.rest.R", "lamp.emitter.seen.R"]' <m.json

# options act whatever their order; -- ends them; variables and defines
cp "$scene" ./-box.xml
cp "$here/scenes/box.variables.json" ./-box.variables.json
"$lumenaut" trace -P slide=100% -o g.exr -q -P tint=0.1,0.2,0.9 -D spp=2 --json -- -box.xml >g.json
json 'd["spp"] == 2 and d["values"]["slide"] == 1 and abs(d["values"]["tint.b"] - .9) < 1e-6' <g.json
"$lumenaut" trace "$scene" -o h.exr -q --sampler sobol --mis balance --max-depth 2 --rr-depth 1
"$lumenaut" trace "$scene" -o i.exr -q --size 20x30 --crop 2,3,5,7 --json | json 'd["size"] == [5, 7]'

# what users get wrong
code 2 "$lumenaut" trace "$scene" -o x.png -P slid=1 2>>said
code 2 "$lumenaut" trace "$scene" -o x.png -P slide=7 2>>said
code 2 "$lumenaut" trace "$scene" -o x.png -P shown=onn 2>>said
code 2 "$lumenaut" trace "$scene" -o x.png --size 20x30 --crop 18,0,5,5 2>>said
code 2 "$lumenaut" trace "$scene" -o x.png --size 99999x2 2>>said
code 2 "$lumenaut" trace "$scene" -o x.png --max-depth -2 2>>said
cat said
[ ! -e x.png ]
