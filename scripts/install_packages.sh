#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# install_packages.sh LIST...: installs the Debian packages named in the lists that are missing. Says
# what it installs; says nothing when nothing is missing. A line is `PACKAGE [PROGRAM]`, # starts a
# comment; a PROGRAM that is there, wherever it comes from, makes its package unnecessary.
set -euo pipefail

if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
  echo "waystone: this is not a Debian system; install what $* lists by your own means" >&2
  exit 0
fi

missing=()
while read -r package program; do
  if [ -n "$program" ] && command -v "$program" >/dev/null; then continue; fi
  status=$(dpkg-query --show --showformat='${db:Status-Status}' "$package" 2>/dev/null || true)
  # A package of several architectures prints its status once for each.
  [[ $status == *installed* && $status != *not-installed* ]] || missing+=("$package")
done < <(sed -e 's/#.*//' -e 's/[[:space:]]*$//' -e '/^$/d' "$@")
[ ${#missing[@]} -gt 0 ] || exit 0

command="apt-get update && apt-get install -y --no-install-recommends ${missing[*]}"
if [ "$(id -u)" -eq 0 ]; then
  as_root=()
  echo "Installing Debian packages: ${missing[*]}" >&2
elif command -v sudo >/dev/null; then
  as_root=(sudo)
  echo "Installing Debian packages with sudo: ${missing[*]}" >&2
else
  echo "waystone: Debian packages are missing; as root, run: $command" >&2
  exit 1
fi

# Quiet when it succeeds, the whole log when it fails.
log=$(mktemp)
trap 'rm -f "$log"' EXIT
apt() {
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q "$@" >"$log" 2>&1 || {
    cat "$log" >&2
    echo "waystone: apt-get $1 failed; see above, then run: $command" >&2
    exit 1
  }
}
apt update
apt install -y --no-install-recommends "${missing[@]}"
