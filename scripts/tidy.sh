#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# tidy.sh JOBS: clang-tidy over all sources; every warning is an error. Sources are read a few at a
# time, as the preset lint would compile them: what clang-tidy does for their headers is most of its
# work.
set -euo pipefail
jobs=$1
build=build/lint
cmake --preset lint >/dev/null

# The commands as clang can read them: without the flags that only gcc knows.
mkdir -p "$build/tidy"
sed -e 's/ -fpch-preprocess//g' -e 's/ -Wno-\(maybe-uninitialized\|restrict\|stringop-[a-z]*\)//g' \
  "$build/compile_commands.json" >"$build/tidy/compile_commands.json"

# Of the files in the build folder only those that include ours.
grep -oP '"file": "\K[^"]+' "$build/compile_commands.json" | sort -u |
  awk -v build="$PWD/build/" 'index($0, build) != 1 || /\/Unity\//' | tr '\n' '\0' |
  xargs -0 -n 1 -P "$jobs" clang-tidy -p "$build/tidy" --quiet --warnings-as-errors='*' 2> >(
    # Counts of what was suppressed in system headers say nothing.
    grep -v 'warnings\? generated\|Suppressed\|Use -header-filter' >&2)
