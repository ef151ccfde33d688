#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# scripts.sh [ROOT]: shell and Python scripts parse.
cd "${1:-$(dirname "$0")/../..}" || exit 1
status=0
for script in $(find scripts tests tools bench packaging -name '*.sh' 2>/dev/null | sort); do
    case $(head -n 1 "$script") in
    *bash*) bash -n "$script" || status=1 ;;
    *) sh -n "$script" || status=1 ;;
    esac
done
find scripts tests tools bench -name '*.py' 2>/dev/null | sort | /usr/bin/python3 -c '
import sys
failed = False
for path in sys.stdin.read().split():
    try:
        compile(open(path, encoding="utf-8").read(), path, "exec")
    except SyntaxError as error:
        print(f"{path}:{error.lineno}: {error.msg}")
        failed = True
sys.exit(failed)' || status=1
exit $status
