# SPDX-License-Identifier: Apache-2.0
# On a terminal there is a coloured bar that is wiped at the end; NO_COLOR, TERM=dumb and --quiet
# are heeded.
cat >run.py <<'END'
import os, pty, sys
def show(environment, *options):
    command = [os.environ["lumenaut"], "trace", os.environ["here"] + "/scenes/box.xml", "-o", "a.png",
               "--size", "256x256", "--spp", "10", *options]
    pid, fd = pty.fork()
    if pid == 0:
        os.execvpe(command[0], command, {**os.environ, **environment})
    text = b""
    try:
        while chunk := os.read(fd, 4096):
            text += chunk
    except OSError:
        pass
    os.waitpid(pid, 0)
    return text.decode()
try:
    os.close(pty.openpty()[0])
except OSError as error:
    print("no pseudo-terminals here:", error)
    sys.exit(77)
colour = show({"TERM": "xterm"})
plain = show({"TERM": "xterm", "NO_COLOR": "1"})
print("\x1b[32m" in colour, "\x1b[32m" in plain, "trace [" in colour, "trace [" in plain)
print("trace [" in show({"TERM": "dumb"}), show({"TERM": "xterm"}, "-q") == "")
print(colour.splitlines()[-1].split("\x1b[K")[-1])
END
/usr/bin/python3 run.py
