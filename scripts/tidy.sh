#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# tidy.sh BUILD JOBS [FILE...]: clang-tidy over the sources (all of ours by default) as they are
# compiled in BUILD; every warning is an error.
set -euo pipefail
build=$1 jobs=$2
shift 2

# The commands as clang can read them: without the flags that only gcc knows.
mkdir -p "$build/tidy"
sed -e 's/ -fpch-preprocess//g' -e 's/ -Wno-\(maybe-uninitialized\|restrict\|stringop-[a-z]*\)//g' \
  "$build/compile_commands.json" >"$build/tidy/compile_commands.json"

files=("$@")
if [ ${#files[@]} -eq 0 ]; then
  # Only what is compiled: clang-tidy needs each file's flags.
  mapfile -t files < <(grep -oP '"file": "\K[^"]+' "$build/compile_commands.json" |
    grep -v "^$PWD/build/" | sort -u)
fi
printf '%s\0' "${files[@]}" |
  xargs -0 -n 1 -P "$jobs" clang-tidy -p "$build/tidy" --quiet --warnings-as-errors='*' 2> >(
    # Counts of what was suppressed in system headers say nothing.
    grep -v 'warnings\? generated\|Suppressed\|Use -header-filter' >&2 || true)
