#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# checks_fail.sh SOURCE_DIR: shows each check of scripts/checks a tiny tree with one fault and wants
# exit 1 and a line that names it; and one without fault, which must pass.
set -u
source=$(cd "$1" && pwd)
checks=$source/scripts/checks
tree=$(mktemp -d) || exit 1
trap 'rm -rf "$tree"' EXIT
spdx='/* SPDX-License-Identifier: Apache-2.0 */'
failures=0

# A tree that every check accepts.
reset() {
    rm -rf "$tree"
    mkdir -p "$tree/src/base" "$tree/src/nn" "$tree/src/scene" "$tree/src/render" "$tree/tools/t" \
        "$tree/viewer" "$tree/include/lumenaut" "$tree/docs/man" "$tree/scenes" "$tree/scripts"
    cp "$source/.clang-format" "$tree/"
    put src/base/a.h 'int a(void);'
    put src/nn/b.c '#include "base/a.h"' 'struct s {' '    int (*free)(void *);' '};' \
        '/* malloc(3), printf(3) */' 'int b(struct s *s);'
    put tools/t/main.c '#include <lumenaut/lumenaut.h>' '#include "own.h"'
    put tools/t/own.h 'int own;'
    put include/lumenaut/lumenaut.h '#define LMN_API __attribute__((visibility("default")))' \
        'LMN_API int lmn_one(void);'
    put docs/variables.schema.json '{"type": "object", "required": ["variables"]}'
    put scenes/x.variables.json '{"variables": []}'
    printf 'page(1)\n\n# NAME\n\npage - a page\n' >"$tree/docs/man/page.1.scd"
    put lib.c ''
}

put() { # put FILE LINE...
    file=$tree/$1
    shift
    case $file in
    *.[ch]) printf '%s\n' "$spdx" "$@" >"$file" ;;
    *) printf '%s\n' "$@" >"$file" ;;
    esac
}

run() { # run CHECK [ARGUMENT]
    check=$1
    shift
    case $check in
    *.py) /usr/bin/python3 "$checks/$check" "$tree" "$@" ;;
    *) sh "$checks/$check" "$tree" "$@" ;;
    esac >"$tree/out.log" 2>&1
}

accepts() { # accepts CHECK [ARGUMENT]
    run "$@"
    [ $? -eq 0 ] && return
    echo "$1: refuses a good tree:"
    cat "$tree/out.log"
    failures=$((failures + 1))
}

refuses() { # refuses CHECK PATTERN [ARGUMENT]
    check=$1
    pattern=$2
    shift 2
    run "$check" "$@"
    if [ $? -ne 1 ] || ! grep -q -- "$pattern" "$tree/out.log"; then
        echo "$check: did not report: $pattern"
        cat "$tree/out.log"
        failures=$((failures + 1))
    fi
    reset
}

library() { # library SOURCE: what symbols.py looks at
    gcc -shared -fPIC -fvisibility=hidden -o "$tree/lib.so" -x c "$1" || exit 1
}

reset
for check in includes.py text.py format.sh header.sh schema.py man.sh scripts.sh; do
    accepts "$check"
done

put src/base/a.h '#include "nn/b.h"' && put src/nn/b.h ''
refuses includes.py 'base must not depend on nn'
put src/nn/b.c '#include "scene/c.h"' && put src/scene/c.h ''
refuses includes.py 'nn must not depend on scene'
put src/nn/b.c '#include "c.h"' && put src/nn/c.h ''
refuses includes.py 'not a path from src/'
put tools/t/main.c '#include "../../src/base/a.h"'
refuses includes.py 'only <lumenaut/lumenaut.h>'
put tools/t/main.c '#include <base/a.h>'
refuses includes.py 'main.c:2: <base/a.h>'
put tools/t/main.c '#include "viewer.h"' && put viewer/hall.h ''
accepts includes.py
put tools/t/main.c '#include "hall.h"'
refuses includes.py 'only <lumenaut/lumenaut.h>'
put viewer/server.c '#include "../src/base/a.h"'
refuses includes.py 'server.c:2:'
put src/render/e.c '#include <embree3/rtcore.h>'
put src/scene/e2.c '#include <embree3/rtcore.h>'
refuses includes.py 'more than one file includes Embree'
for call in malloc free strdup; do
    put src/nn/b.c 'int f(void)' '{' "    return $call(0);" '}'
    refuses includes.py "b.c:4: $call: heap calls"
done
for call in printf exit abort; do
    put src/nn/b.c 'int f(void)' '{' "    return $call(0);" '}'
    refuses includes.py "b.c:4: $call: the library"
done

printf 'int a;\n' >"$tree/src/base/a.c"
refuses text.py 'a.c:1: the first line'
put src/base/a.c "$(printf '\tint a;')"
refuses text.py 'a.c:2: tab'
put src/base/a.c 'int a; '
refuses text.py 'a.c:2: trailing blank'
put src/base/a.c "$(printf 'int a;\342\200\213')"
refuses text.py 'U+200B'
put src/nn/a.h ''
refuses text.py 'the name is taken'
printf '%s' "$spdx" >"$tree/src/base/a.c"
refuses text.py 'no newline'
put src/base/a.c "/* $(printf '%0100d' 0) */"
refuses text.py '106 columns'

put src/base/a.c 'int  a;'
refuses format.sh 'clang-format'
put include/lumenaut/lumenaut.h 'int f(uint32_t a);'
refuses header.sh 'uint32_t'
put include/lumenaut/lumenaut.h 'int f(void *class, int new);'
refuses header.sh 'new'

api='__attribute__((visibility("default")))'
put lib.c "$api int lmn_one(void);" 'int lmn_one(void) { return 1; }'
library "$tree/lib.c"
accepts symbols.py "$tree/lib.so"
put lib.c "$api int lmn_one(void);" 'int lmn_one(void) { return 1; }' "$api int stray;"
library "$tree/lib.c"
refuses symbols.py 'without the prefix lmn_: stray' "$tree/lib.so"
put lib.c "$api int lmn_one(void);" 'int lmn_one(void) { return 1; }' "$api int lmn_two;"
library "$tree/lib.c"
refuses symbols.py 'not in the header: lmn_two' "$tree/lib.so"
put lib.c 'int a;'
library "$tree/lib.c"
refuses symbols.py 'not exported: lmn_one' "$tree/lib.so"

put scenes/x.variables.json '{}'
refuses schema.py "'variables' is a required property"
put scenes/x.variables.json '{'
refuses schema.py 'x.variables.json: Expecting'
printf 'page(1)\n\nno section\n\n\\. ._x_\n' >"$tree/docs/man/page.1.scd"
refuses man.sh 'page.1.scd'
put scripts/a.sh 'if true'
refuses scripts.sh 'a.sh'
put scripts/a.py 'def'
refuses scripts.sh 'a.py:1'

[ "$failures" -eq 0 ] || { echo "$failures checks do not do their work"; exit 1; }
