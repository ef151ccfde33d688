# SPDX-License-Identifier: Apache-2.0
# bench: one JSON document a kind, with the documented members.
scene=$here/scenes/box.xml
small="--width 16 --depth 1 --patches 2 --runs 3 -q --json"
"$lumenaut" bench kernels $small >k.json
json 'd["bench"] == "kernels" and d["peak_gflops"] > 0 and len(d["results"]) == 3' <k.json
json 'all(r["seconds"] > 0 and r["gflops"] > 0 and r["share_of_peak"] > 0 for r in d["results"])' <k.json
"$lumenaut" bench $small train >t.json
json 'd["results"][0]["step_s"] > 0 and d["results"][0]["width"] == 16 and d["results"][0]["patches"] == 2' <t.json
json '0 < d["results"][0]["share_of_peak"] < 1.5' <t.json
"$lumenaut" bench trace "$scene" "$scene" $small --size 40x30 --spp 2 --max-depth 3 >p.json
json 'len(d["results"]) == 2 and d["results"][1]["paths_per_s"] > 0 and d["results"][0]["max_depth"] == 3' <p.json
json 'all(r["change_s"] > 0 and r["load_s"] > 0 and r["build_s"] > 0 for r in d["results"])' <p.json
"$lumenaut" bench frame "$scene" --method faithful $small --size 40x30 >f.json
json 'd["results"][0]["frame_s"] > 0 and d["results"][0]["network_s"] > 0 and d["results"][0]["variables"] == 6' <f.json
json 'd["results"][0]["method"] == "faithful" and d["results"][0]["width"] == 16' <f.json
"$lumenaut" bench frame "$scene" --runs 2 -q --json --size 70x50 -P slide=50% >f.json
json 'd["results"][0]["method"] == "improved" and d["results"][0]["width"] == 64 and d["results"][0]["depth"] == 3' <f.json
json 'd["results"][0]["network_s"] >= d["results"][0]["layers_s"] > 0 and d["results"][0]["share_of_peak"] > 0' <f.json
json 'd["results"][0]["frame_s"] > sum(d["results"][0][k + "_s"] for k in ("buffers", "look", "network", "tone")) * 0.5' <f.json
json 'all(d["results"][0][k + "_s"] > 0 for k in ("buffers", "look", "encode", "tone"))' <f.json
json '[r["variables"] for r in d["results"][0]["by_variables"]][-2:] == [64, 128]' <f.json
json 'all(r["frame_s"] > r["network_s"] > 0 for r in d["results"][0]["by_variables"])' <f.json
code 2 "$lumenaut" bench frame "$scene" --method best 2>/dev/null
"$lumenaut" bench buffers "$scene" $small --size 40x30 --spp 2 -P slide=50% >b.json
json 'd["results"][0]["frames_per_s"] > 0 and d["results"][0]["buffer_spp"] == 2' <b.json
code 3 "$lumenaut" bench buffers "$scene" $small -P nothing=1 2>&1
"$lumenaut" bench $small "$scene" >all.json 2>&1 && exit 1
"$lumenaut" bench trace "$scene" --runs 1 --size 16x16 -q
code 3 "$lumenaut" bench trace missing.xml -q 2>&1
