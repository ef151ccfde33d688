#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# deps.sh LIST...: installs the Debian packages that the LIST files name, only when some are missing.
set -u

# The log of apt goes to a file and is shown only when apt fails.
fail() {
    echo "deps: $1" >&2
    exit 1
}

wanted=$(sed 's/#.*//' "$@") || exit 1
if ! command -v dpkg-query >/dev/null 2>&1; then
    echo "deps: not a Debian system, nothing installed; needed:" $wanted >&2
    exit 0 # CMake names what it misses
fi

missing=
for package in $wanted; do
    case $(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null) in
    installed) ;;
    *) missing="$missing $package" ;;
    esac
done
[ -n "$missing" ] || exit 0

as_root=
if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null 2>&1 || fail "missing packages, and neither root nor sudo: apt-get install$missing"
    as_root=sudo
    echo "deps: using sudo to install packages"
fi
echo "deps: installing$missing"

log=$(mktemp) || exit 1
trap 'rm -f "$log"' EXIT
export DEBIAN_FRONTEND=noninteractive
apt() {
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get -q -y "$@" >>"$log" 2>&1 </dev/null
}
# The lists are fetched first: those of a fresh image are empty, those of an old one name gone files.
apt update || { cat "$log" >&2; fail "cannot fetch package lists (apt-get update failed); still missing:$missing"; }
apt install --no-install-recommends $missing ||
    { cat "$log" >&2; fail "apt-get could not install:$missing"; }
