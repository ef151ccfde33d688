# SPDX-License-Identifier: Apache-2.0
# info: what a bug report needs; lower instruction sets by option and by environment.
"$lumenaut" info
"$lumenaut" info --json -t 3 | json 'd["threads"] == 3 and d["version"] and d["embree"].startswith("3.")'
"$lumenaut" info --json --cpu-mask baseline | json 'd["cpu_used"] == "baseline"'
LMN_CPU_MASK=baseline "$lumenaut" info --json | json 'd["cpu_used"] == "baseline"'
LMN_CPU_MASK=nonsense code 2 "$lumenaut" info 2>&1
