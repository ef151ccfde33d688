#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""includes.py [ROOT]: who may include and call what.

- src/<module>/ includes only modules before it: base <- math <- image <- scene <- render,
  base <- math <- nn, train <- {render, nn}, api <- all; own headers by their path from src/.
- tools/, viewer/, bench/ and examples/ know <lumenaut/lumenaut.h> and the headers beside them,
  tools/ also viewer/viewer.h, nothing else.
- One file knows Embree.
- Heap calls live in src/base/mem.c; nothing in src/ prints, exits or aborts.
"""
import pathlib
import re
import sys

MAY_INCLUDE = {
    "base": set(),
    "math": {"base"},
    "image": {"base", "math"},
    "scene": {"base", "math", "image"},
    "render": {"base", "math", "image", "scene"},
    "nn": {"base", "math"},
    "train": {"base", "math", "image", "scene", "render", "nn"},
    "api": {"base", "math", "image", "scene", "render", "nn", "train"},
}
INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*(["<])([^">]+)[">]', re.M)
NOT_CODE = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.S)
HEAP = r"malloc|calloc|realloc|reallocarray|free|strdup|strndup|aligned_alloc|posix_memalign|" \
       r"asprintf|vasprintf"
PRINT = r"printf|vprintf|puts|putchar|perror|exit|_exit|quick_exit|abort|err|errx|warn|warnx"
HEAP_CALL = re.compile(r"(?<![\w.>])(" + HEAP + r")\s*\(")
PRINT_CALL = re.compile(r"(?<![\w.>])(" + PRINT + r")\s*\(")
STREAM = re.compile(r"(?<!\w)(stderr)(?!\w)")


def blank(match):
    """Comments and literals become blanks, so that line numbers stay."""
    return re.sub(r"[^\n]", " ", match.group(0))


def check_src_include(root, path, name, quoted):
    module = path.relative_to(root / "src").parts[0]
    if not (root / "src" / name).is_file():
        if quoted:
            return f'"{name}": not a path from src/'
        return None
    first = name.split("/")[0]
    if first != module and first not in MAY_INCLUDE.get(module, set()):
        return f'"{name}": {module} must not depend on {first}'
    return None


def check_outer_include(root, path, name, quoted):
    if name == "lumenaut/lumenaut.h":
        return None
    if quoted:
        target = (path.parent / name).resolve()
        top = path.relative_to(root).parts[0]
        if target.is_file() and target.is_relative_to((root / top).resolve()):
            return None
        if top == "tools" and name == "viewer.h":
            return None
        return f'"{name}": only <lumenaut/lumenaut.h> and headers beside the file'
    if (root / "src" / name).is_file() or (root / "include" / name).is_file():
        return f"<{name}>: only <lumenaut/lumenaut.h> is public"
    return None


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2])
    problems, embree = [], []
    for path in sorted(p for top in ("src", "tools", "viewer", "bench", "examples", "include")
                       for p in (root / top).rglob("*.[ch]")):
        text = path.read_text(encoding="utf-8", errors="replace")
        shown = path.relative_to(root)
        top = shown.parts[0]
        for match in INCLUDE.finditer(text):
            line = text.count("\n", 0, match.start(1)) + 1
            quoted, name = match.group(1) == '"', match.group(2)
            if name.startswith("embree"):
                embree.append(f"{shown}:{line}")
            check = check_src_include if top == "src" else check_outer_include
            problem = check(root, path, name, quoted)
            if problem:
                problems.append(f"{shown}:{line}: {problem}")
        if top != "src":
            continue
        code = NOT_CODE.sub(blank, text)
        rules = [(PRINT_CALL, "the library does not print or exit"),
                 (STREAM, "the library does not print")]
        if str(shown) != "src/base/mem.c":
            rules.append((HEAP_CALL, "heap calls belong to src/base/mem.c"))
        for pattern, what in rules:
            for match in pattern.finditer(code):
                line = code.count("\n", 0, match.start(1)) + 1
                problems.append(f"{shown}:{line}: {match.group(1)}: {what}")
    if len({where.split(":")[0] for where in embree}) > 1:
        problems.append("more than one file includes Embree: " + " ".join(embree))
    print("\n".join(problems), end="\n" if problems else "")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
