#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# format.sh [ROOT]: every C file is as clang-format 14 writes it with ROOT/.clang-format.
cd "${1:-$(dirname "$0")/../..}" || exit 1
find src include tools bench tests examples -name '*.[ch]' 2>/dev/null | sort |
    xargs -r -P 2 -n 16 clang-format-14 --dry-run -Werror 2>&1 || exit 1
