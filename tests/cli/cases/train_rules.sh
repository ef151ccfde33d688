# SPDX-License-Identifier: Apache-2.0
# The rules that stop a run, the paper's switches, and what is written on the way.
scene=$here/scenes/box.xml
tiny="--method faithful --width 16 --depth 1 --patch-size 12 --resolution-start 24 --chains 4 --reuse-warmup 4 --reuse-batch 4 --memory 4 --spp 2 --eval-n 2 --eval-size 16 --eval-spp 4"
train() { "$lumenaut" train "$scene" -q $tiny --json "$@"; }
train -o a.lmn --time 0.2s --eval-every never | json 'd["cpu_s"] >= 0.2 and "eval" not in d'
train -o b.lmn --target mape=1000 --steps 50 --eval-every 5i | json 'd["steps"] == 5 and d["eval"]["mape"] > 0'
train -o c.lmn --target psnr=1000 --steps 12 --eval-every 5i | json 'd["steps"] == 12 and d["eval_step"] == 12'
grep -c '"eval"' c.metrics.jsonl
for how in "--explore uniform" "--explore loss-only" --no-reuse --no-growth --no-preconditioning --legacy-ssim; do
    train -o d.lmn --steps 8 --eval-every never $how >/dev/null
    ! cmp -s d.lmn c.lmn
done
train -o d.lmn --steps 8 --eval-every never --learning-rate 1e-3 --max-depth 2 --seed 5 >/dev/null
head -n 1 d.metrics.jsonl | json 'd["run"]["options"]["learning_rate"] == 1e-3 and d["run"]["options"]["seed"] == 5'
"$lumenaut" plot d.lmn -o d.svg
"$lumenaut" plot d.metrics.jsonl -o - | cmp - d.svg
/usr/bin/python3 -c 'import xml.etree.ElementTree as e; assert e.parse("d.svg").getroot().tag.endswith("svg")'
"$lumenaut" plot c.metrics.jsonl d.lmn -o cd.svg
/usr/bin/python3 -c 'import xml.etree.ElementTree as e; t = "".join(e.parse("cd.svg").getroot().itertext()); assert all(w in t for w in ["relMSE on", "Loss of fresh", "time"]), t'
ls d.lmn* d.metrics*
