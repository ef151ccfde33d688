# SPDX-License-Identifier: Apache-2.0
# --help of the program and of each command goes to standard output.
"$lumenaut" --help
"$lumenaut" --version
for command in trace train render eval compare params plot view bench info; do
    "$lumenaut" $command --help >$command.txt
    head -n 1 $command.txt
    tail -n 1 $command.txt
    grep -q -- '--threads N' $command.txt
    # nothing is wider than a terminal of 100 columns
    ! grep '.\{101\}' $command.txt
done
