#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""text.py [ROOT]: what every text file keeps to.

C, shell and Python files start with an SPDX line; no tabs (but in Makefile), trailing blanks or
invisible Unicode; a newline ends the file; C lines have at most 100 columns; file names are unique in
src/, tools/ and viewer/; files over 800 lines get a warning, which is no failure.
"""
import pathlib
import subprocess
import sys
import unicodedata

TEXT = {".c", ".h", ".sh", ".py", ".md", ".txt", ".scd", ".cmake", ".in", ".json", ".xml", ".yml"}
CODE = {".c", ".h", ".sh", ".py"}
SPDX = "SPDX-License-Identifier: Apache-2.0"


def files_of(root):
    """What git tracks or would; everything, when ROOT is no work tree of its own."""
    if (root / ".git").exists():
        command = ["git", "-C", str(root), "ls-files", "-z", "-co", "--exclude-standard"]
        names = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        paths = [root / name for name in names.split("\0") if name]
    else:
        paths = [p for p in root.rglob("*") if "build" not in p.relative_to(root).parts]
    return sorted(p for p in paths if p.is_file() and (p.suffix in TEXT or p.name == "Makefile"))


def is_invisible(char):
    return unicodedata.category(char) in ("Cc", "Cf", "Co", "Zl", "Zp") and char not in "\n\t"


def check(path, shown):
    try:
        text = path.read_bytes().decode("utf-8")
    except UnicodeDecodeError as error:
        return [f"{shown}: not UTF-8: {error}"], []
    problems, warnings = [], []
    lines = text.split("\n")
    if text and not text.endswith("\n"):
        problems.append(f"{shown}:{len(lines)}: no newline at the end")
    if path.suffix in CODE and not any(SPDX in line for line in lines[:2]):
        problems.append(f"{shown}:1: the first line must hold {SPDX}")
    for number, line in enumerate(lines, 1):
        where = f"{shown}:{number}"
        if "\t" in line and path.name != "Makefile" and path.suffix != ".scd":
            problems.append(f"{where}: tab")
        if line != line.rstrip():
            problems.append(f"{where}: trailing blank")
        for char in line:
            if is_invisible(char):
                problems.append(f"{where}: invisible character U+{ord(char):04X}")
        if path.suffix in (".c", ".h") and len(line) > 100:
            problems.append(f"{where}: {len(line)} columns")
    if path.suffix in CODE and len(lines) > 800:
        warnings.append(f"{shown}: warning: {len(lines)} lines; split at 800")
    return problems, warnings


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2])
    problems, warnings, seen = [], [], {}
    for path in files_of(root):
        shown = path.relative_to(root)
        if shown.parts[0] in ("src", "tools", "viewer") and path.suffix in (".c", ".h"):
            taken = seen.setdefault((shown.parts[0], path.name), shown)
            if taken != shown:
                problems.append(f"{shown}: the name is taken by {taken}")
        more, notes = check(path, shown)
        problems += more
        warnings += notes
    for line in warnings + problems:
        print(line)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
