# SPDX-License-Identifier: Apache-2.0
# The completion script knows commands, options and the words that options take.
command -v bash >/dev/null || { echo "no bash"; exit 77; }
"$lumenaut" --completions >completion
cat >try.bash <<'END'
. ./completion
try() { COMP_WORDS=(lumenaut "$@"); COMP_CWORD=$#; COMPREPLY=(); _lumenaut; echo "${COMPREPLY[@]}"; }
try tra
try trace --half
try train --explore ''
try trace --sampler so
END
bash try.bash
