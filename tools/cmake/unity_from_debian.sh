#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# usage: unity_from_debian.sh DIR
# Puts Unity's three files, as they lie in Debian's source package ntpsec, into DIR/src.
# Needs no root: it works on source lists of its own, made from the system's.
set -euo pipefail
shopt -s nullglob

dir=$1
tmp=$(mktemp -d)
trap 'rm -rf "$tmp"' EXIT
mkdir -p "$tmp/lists/partial" "$tmp/sources"

command -v apt-get >/dev/null || { echo "unity_from_debian.sh: no apt-get here" >&2; exit 1; }
for file in /etc/apt/sources.list.d/*.sources; do
    sed 's/^Types:.*/Types: deb-src/' "$file" >"$tmp/sources/${file##*/}"
done
for file in /etc/apt/sources.list /etc/apt/sources.list.d/*.list; do
    [[ -f $file ]] || continue
    sed -n 's/^deb\(-src\)\{0,1\} /deb-src /p' "$file" | sort -u \
        >"$tmp/sources/from-$(basename "$file" .list).list"
done
apt=(apt-get -qq -o "Dir::Etc::sourcelist=/dev/null" -o "Dir::Etc::sourceparts=$tmp/sources"
    -o "Dir::State::lists=$tmp/lists" -o "APT::Sandbox::User=root")

cd "$tmp"
"${apt[@]}" update
"${apt[@]}" source --download-only ntpsec >&2
tar xf ntpsec_*.orig.tar.xz --wildcards --strip-components=3 '*/tests/unity/unity*.[ch]'
mkdir -p "$dir/src"
cp unity.c unity.h unity_internals.h "$dir/src/"
