#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# build.sh PRESET JOBS [TARGET...]: configures if needed and builds, into build/PRESET.
# Prints one line on success, the whole log on failure.
set -euo pipefail
preset=$1 jobs=$2
shift 2

log=$(mktemp)
trap 'rm -f "$log"' EXIT
if [ ! -f "build/$preset/build.ninja" ]; then
  echo "Configuring build/$preset" >&2
  cmake --preset "$preset" >"$log" 2>&1 || { cat "$log" >&2; exit 1; }
fi
# On a terminal ninja shows its own progress line; elsewhere it is quiet unless something fails.
if [ -t 1 ]; then
  ninja -C "build/$preset" -j "$jobs" "$@"
else
  echo "Building build/$preset" >&2
  ninja --quiet -C "build/$preset" -j "$jobs" "$@"
fi
