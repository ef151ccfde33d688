#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""kill.py EVERY SCENE [OPTION...]: trains killed.lmn with a checkpoint every EVERY steps, and kills the
process by SIGKILL as soon as the first is there.
"""
import os
import subprocess
import sys
import time


def main():
    every, scene, *options = sys.argv[1:]
    command = [os.environ["lumenaut"], "train", scene, "-q", "-o", "killed.lmn", "--steps", "1000000",
               "--checkpoint-every", f"{every}i", *options]
    with subprocess.Popen(command) as child:
        while not os.path.exists("killed.lmn"):
            if child.poll() is not None:
                return 1
            time.sleep(0.001)
        child.kill()
    return 0


if __name__ == "__main__":
    sys.exit(main())
