# SPDX-License-Identifier: Apache-2.0
# Wrong usage: exit 2 and one line that says what was meant.
exec 2>&1
code 2 "$lumenaut" >/dev/null 2>&1
code 2 "$lumenaut" trac
code 2 "$lumenaut" --hepl
code 2 "$lumenaut" frobnicate
code 2 "$lumenaut" trace --spq 3 x.xml
code 2 "$lumenaut" trace --bogus-option x.xml
code 2 "$lumenaut" trace -z x.xml
code 2 "$lumenaut" trace
code 2 "$lumenaut" trace a.xml b.xml
code 2 "$lumenaut" trace --spp 0 x.xml
code 2 "$lumenaut" trace --spp 1x x.xml
code 2 "$lumenaut" trace --spp nan x.xml
code 2 "$lumenaut" trace --spp 99999999999999999999 x.xml
code 2 "$lumenaut" trace --size 64 x.xml
code 2 "$lumenaut" trace --crop 1,2,3 x.xml
code 2 "$lumenaut" trace --buffers=yes x.xml
code 2 "$lumenaut" trace x.xml --spp
code 2 "$lumenaut" trace x.xml
code 2 "$lumenaut" trace x.xml -o a.gif
code 2 "$lumenaut" trace x.xml -o a.ong
code 2 "$lumenaut" trace x.xml -o noextension
code 2 "$lumenaut" trace x.xml -o -
code 2 "$lumenaut" trace x.xml -o - --format png --json
code 2 "$lumenaut" trace x.xml -o a.png --cpu-mask mmx
code 2 "$lumenaut" train x.xml -o a.lmn --explore widely
code 2 "$lumenaut" train x.xml -o a.lmn --time soon
code 2 "$lumenaut" train x.xml -o a.lmn --time 0s
code 2 "$lumenaut" train x.xml -o a.lmn --checkpoint-every 0i
code 2 "$lumenaut" train x.xml -o a.lmn --target mope=0.1
code 2 "$lumenaut" train x.xml -o -
code 2 "$lumenaut" train x.xml
code 2 "$lumenaut" bench kernel
code 2 "$lumenaut" plot a.lmn
code 1 "$lumenaut" trace x.xml -o no/such/folder/a.png
[ -z "$(ls)" ]
