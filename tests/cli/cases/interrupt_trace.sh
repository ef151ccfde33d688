# SPDX-License-Identifier: Apache-2.0
# An interrupt stops a long picture, and nothing is left of it.
cat >run.py <<'END'
import os, signal, subprocess, sys, time
done = subprocess.Popen([os.environ["lumenaut"], "trace", os.environ["here"] + "/scenes/box.xml",
                         "-o", "a.png", "--size", "2000x2000", "--spp", "100", "--progress=json"], stderr=subprocess.PIPE,
                        text=True)
for line in done.stderr:
    if '"progress"' in line:
        break
started = time.monotonic()
done.send_signal(signal.SIGINT)
rest = done.stderr.read().splitlines()
code = done.wait()
print(code, rest[-1], time.monotonic() - started < 60)
END
/usr/bin/python3 run.py
[ "$(ls)" = run.py ]
