#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# header.sh [ROOT]: the public header compiles alone, as C99, C11 and C++11, without a warning.
root=${1:-$(dirname "$0")/../..}
status=0
for header in "$root"/include/lumenaut/*.h; do
    for std in c99 c11; do
        gcc -x c -std=$std -Wall -Wextra -pedantic -Werror -fsyntax-only "$header" || status=1
    done
    g++ -x c++ -std=c++11 -Wall -Wextra -pedantic -Werror -fsyntax-only "$header" || status=1
done
exit $status
