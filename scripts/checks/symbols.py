#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""symbols.py [ROOT [LIBRARY]]: the shared library exports what the header declares, no more."""
import pathlib
import re
import subprocess
import sys


def declared_in(text):
    text = re.sub(r"/\*.*?\*/", " ", text, flags=re.S)
    return set(re.findall(r"^LMN_API\b[^;(]*?(\w+)\s*\(", text, flags=re.M))


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2])
    library = sys.argv[2] if len(sys.argv) > 2 else root / "build/release/liblumenaut.so"
    declared = declared_in((root / "include/lumenaut/lumenaut.h").read_text(encoding="utf-8"))
    command = ["nm", "--dynamic", "--defined-only", "--format=posix", str(library)]
    listing = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    exported = {line.split()[0].split("@")[0] for line in listing.splitlines() if line}
    problems = [f"exported without the prefix lmn_: {name}"
                for name in sorted(exported) if not name.startswith("lmn_")]
    problems += [f"exported but not in the header: {name}" for name in sorted(exported - declared)]
    problems += [f"in the header but not exported: {name}" for name in sorted(declared - exported)]
    print("\n".join(problems), end="\n" if problems else "")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
