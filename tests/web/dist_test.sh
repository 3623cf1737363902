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

if ! command -v node >/dev/null || [ ! -d node_modules/esbuild ]; then
  echo "Only the checksums were compared: Node or server/web/node_modules is missing ('make web' installs it)"
  exit 0
fi
again=$(mktemp -d)
trap 'rm -rf "$again"' EXIT
node build.mjs "$again/dist"
diff -rq dist "$again/dist" || { echo "dist/ isn't what its sources give: $advice"; exit 1; }
