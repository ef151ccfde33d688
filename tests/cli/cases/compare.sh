# SPDX-License-Identifier: Apache-2.0
# compare: an image with itself has no error; a noisier one has some; the map is written.
scene=$here/scenes/box.xml
"$lumenaut" trace "$scene" -o a.exr -q --spp 4
"$lumenaut" trace "$scene" -o b.exr -q --spp 64 --seed 7
"$lumenaut" compare a.exr a.exr
"$lumenaut" compare a.exr a.exr --json |
    json 'all(d["metrics"][k] == 0 for k in ("mae", "mape", "relmse", "mse", "dssim", "flip", "flip_hdr")) and d["metrics"]["psnr"] is None'
"$lumenaut" compare a.exr b.exr --map map.png --json >c.json
json '0 < d["metrics"]["flip"] < 1 and 0 < d["metrics"]["mape"] < 2 and 5 < d["metrics"]["psnr"] < 60' <c.json
json 'd["size"] == [48, 32] and d["test"] == "a.exr" and d["reference"] == "b.exr"' <c.json
"$lumenaut" compare map.png map.png >/dev/null
