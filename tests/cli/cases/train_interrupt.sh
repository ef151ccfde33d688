# SPDX-License-Identifier: Apache-2.0
# An interrupt ends the step, saves, says how to go on and exits with 130.
cat >run.py <<'END'
import json, os, signal, subprocess
command = [os.environ["lumenaut"], "train", os.environ["here"] + "/scenes/box.xml", "-o", "a.lmn",
           "--width", "16", "--depth", "1", "--memory", "4", "--spp", "2",
           "--eval-every", "never", "--progress=json", "--json"]
child = subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
lines = []
for line in child.stderr:
    lines.append(json.loads(line))
    if lines[-1]["event"] == "progress":
        child.send_signal(signal.SIGINT)
        break
lines += [json.loads(line) for line in child.stderr]
report = json.loads(child.stdout.read())
print(child.wait(), report["interrupted"], report["steps"] > 0)
progress = [line for line in lines if line["event"] == "progress"][0]
print(sorted(progress.keys() & {"step", "loss", "resolution", "acceptance", "fraction", "cpu_s", "phase"}))
print("\n".join(line["text"] for line in lines if line["event"] == "note"))
END
/usr/bin/python3 run.py
[ -s a.lmn ] && [ -s a.lmn.state ] && [ -s a.metrics.jsonl ] && [ "$(ls | wc -l)" -eq 4 ]
"$lumenaut" params a.lmn >/dev/null
