#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""run.py LUMENAUT CASE.sh: runs a case and compares what it says with what stands beside it.

CASE.sh is run by sh -e in an empty folder, with $lumenaut (the program), $here (this folder) and
`json PYTHON-EXPRESSION` (true when it holds of the document d on standard input). Beside it may be
CASE.stdout.glob and CASE.stderr.glob, one shell pattern a line; a stream without a file is not
looked at. The case must exit with 0, or what CASE.exit says; 77 skips, with its last line as reason.
"""
import fnmatch
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

PRELUDE = """
json() { /usr/bin/python3 -c 'import json, sys
d = json.load(sys.stdin)
ok = eval(sys.argv[1])
if not ok: print("not so:", sys.argv[1], file=sys.stderr); print(json.dumps(d)[:2000], file=sys.stderr)
sys.exit(not ok)' "$1"; }
code() { want=$1; shift; got=0; "$@" || got=$?
    [ "$got" -eq "$want" ] || { echo "exit $got, not $want: $*" >&2; exit 1; }; }
"""


def compare(case, stream, text):
    expected = case.with_suffix(f".{stream}.glob")
    if not expected.exists():
        return []
    wanted = expected.read_text(encoding="utf-8").splitlines()
    got = text.splitlines()
    problems = [f"{stream}:{i + 1}: got      {g}\n{stream}:{i + 1}: expected {w}"
                for i, (g, w) in enumerate(zip(got, wanted)) if not fnmatch.fnmatchcase(g, w)]
    problems += [f"{stream}: unexpected: {line}" for line in got[len(wanted):]]
    problems += [f"{stream}: missing: {line}" for line in wanted[len(got):]]
    return problems


def main():
    lumenaut, case = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
    folder = tempfile.mkdtemp(prefix=f"lumenaut-{case.stem}-")
    environment = {k: v for k, v in os.environ.items() if k not in ("LMN_CPU_MASK", "NO_COLOR")}
    environment.update(lumenaut=str(pathlib.Path(lumenaut).resolve()), here=str(case.parent.parent),
                       LC_ALL="C.UTF-8")
    script = PRELUDE + case.read_text(encoding="utf-8")
    try:
        done = subprocess.run(["sh", "-e", "-c", script, case.stem], cwd=folder, env=environment,
                              capture_output=True, text=True, errors="replace", check=False)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    wanted = case.with_suffix(".exit")
    code = int(wanted.read_text()) if wanted.exists() else 0
    if done.returncode == 77 and code != 77:
        print((done.stdout + done.stderr).strip().splitlines()[-1])
        return 77
    problems = compare(case, "stdout", done.stdout) + compare(case, "stderr", done.stderr)
    if done.returncode != code:
        problems.append(f"exit {done.returncode}, expected {code}")
    if problems:
        print("\n".join(problems))
        print("--- stdout", done.stdout[-4000:], "--- stderr", done.stderr[-4000:], sep="\n")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
