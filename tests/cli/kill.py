#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""kill.py EVERY SCENE [OPTION...]: trains killed.lmn with a checkpoint every EVERY steps, and kills the
process by SIGKILL again and again, resuming what is there: as soon as a new state is there, so that
its model mostly is not, as soon as a new model is there, and at other moments.
"""
import os
import subprocess
import sys
import time

MODEL, STATE = "killed.lmn", "killed.lmn.state"


def identity(path):
    try:
        found = os.stat(path)
        return found.st_ino, found.st_mtime_ns
    except FileNotFoundError:
        return None


def run_until(command, is_enough):
    """False when the process ended by itself."""
    with subprocess.Popen(command) as child:
        while not is_enough():
            if child.poll() is not None:
                return False
            time.sleep(0.0002)
        child.kill()
    return True


def main():
    every, scene, *options = sys.argv[1:]
    command = [os.environ["lumenaut"], "train", scene, "-q", "-o", MODEL, "--steps", "1000000",
               "--checkpoint-every", f"{every}i"]
    moments = [STATE, STATE, MODEL, 0.05, STATE, 0.08, MODEL, 0.11, STATE]
    n_early = 0
    for i, moment in enumerate(moments):
        start, before = time.monotonic(), (identity(MODEL), identity(STATE))
        how = options if i == 0 else ["--resume"]
        if not run_until(command + how, lambda: identity(moment) not in (None, before[moment == STATE])
                         if isinstance(moment, str) else time.monotonic() - start > moment):
            print(f"ended by itself before {moment}")
            return 1
        n_early += identity(STATE) != before[1] and identity(MODEL) == before[0]
    print(f"{n_early} of {len(moments)} kills between state and model", file=sys.stderr)
    return 0


if __name__ == "__main__":
    sys.exit(main())
