#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""kill_again.py COMMAND...: runs a command, kills it by SIGKILL after a while, and runs it again with a
longer while each time, until it ends by itself. Exits as it does.
"""
import subprocess
import sys


def main():
    patience, kills = 0.08, 0
    while True:
        with subprocess.Popen(sys.argv[1:]) as child:
            try:
                code = child.wait(patience)
                print(f"killed {kills} times", file=sys.stderr)
                return code
            except subprocess.TimeoutExpired:
                child.kill()
        kills += 1
        patience *= 1.15


if __name__ == "__main__":
    sys.exit(main())
