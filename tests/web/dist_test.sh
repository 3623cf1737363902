#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# dist_test.sh WEB_FOLDER: whether dist/ was made of the sources beside it. By their checksums; and
# where Node and the page's packages are installed, by building it again.
set -euo pipefail
cd "$1"

advice="run 'make web' and commit server/web/dist"
sha256sum --quiet --check dist/sources.sha256 || { echo "dist/ is older than its sources: $advice"; exit 1; }
listed=$(sed 's/^[^ ]*  //' dist/sources.sha256)
present=$(printf '%s\n' ../../clients/js/waystone.* build.mjs package-lock.json package.json src/* | LC_ALL=C sort)
if ! diff <(echo "$listed") <(echo "$present"); then
  echo "dist/ was made of other files: $advice"
  exit 1
fi

# NOTICE names every package whose licence is in licences.txt.
{ echo; cat dist/licences.txt; } | grep -A2 -E '^(-{40})?$' | grep -oE '^[@a-z][^ ]* [0-9.]+$' | cut -d' ' -f1 |
  while read -r package; do
    grep -q "^  $package  *(c)" ../../NOTICE || { echo "NOTICE doesn't name $package"; exit 1; }
  done

if ! command -v node >/dev/null || [ ! -d node_modules/esbuild ]; then
  echo "Only the checksums were compared: Node or server/web/node_modules is missing ('make browser' installs it)"
  exit 77
fi
again=$(mktemp -d)
trap 'rm -rf "$again"' EXIT
node build.mjs "$again/dist"
diff -rq dist "$again/dist" || { echo "dist/ isn't what its sources give: $advice"; exit 1; }
