#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""man_pages.py LUMENAUT DOCS/MAN: every command has a page, and each page has the options that
`--help` shows, with the same letters and arguments, and no other."""
import pathlib
import re
import subprocess
import sys


def run(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def help_options(lumenaut, command):
    """{"output": ("o", "FILE"), "json": (None, None)}"""
    found = {}
    for line in run(lumenaut, command, "--help").splitlines():
        match = re.match(r"^  (?:-(\w), |    )--([\w-]+)(?: ([^\s\[]+))?", line)
        if match:
            letter, name, argument = match.groups()
            # What follows a flag is two blanks away.
            if not re.match(r"^.{6}--[\w-]+ \S", line):
                argument = None
            found[name] = (letter, argument)
    return found


def page_options(path):
    found = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        match = re.match(r"^(?:\*-(\w)\*, )?\*--([\w-]+)\*(?: _(.+)_)?$", line)
        if match:
            letter, name, argument = match.groups()
            found[name] = (letter, argument)
    return found


def main():
    lumenaut, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    overview = run(lumenaut, "--help")
    commands = re.findall(r"^  (\w+) ", overview.split("Options:")[0], flags=re.M)
    main_page = (folder / "lumenaut.1.scd").read_text(encoding="utf-8")
    problems = [f"lumenaut(1) does not name {c}" for c in commands
                if f"*lumenaut-{c}*(1)" not in main_page]
    pages = {p.name.split(".")[0].removeprefix("lumenaut-") for p in folder.glob("lumenaut-*.1.scd")}
    problems += [f"page without a command: {name}" for name in pages - set(commands)]
    for command in commands:
        path = folder / f"lumenaut-{command}.1.scd"
        if not path.exists():
            problems.append(f"no page: {path.name}")
            continue
        said, written = help_options(lumenaut, command), page_options(path)
        for name in sorted(said.keys() | written.keys()):
            if said.get(name) != written.get(name):
                problems.append(f"{path.name}: --{name}: --help has {said.get(name)}, "
                                f"the page {written.get(name)}")
    print("\n".join(problems) or f"{len(commands)} commands agree")
    return 1 if problems or len(commands) < 9 else 0


if __name__ == "__main__":
    sys.exit(main())
