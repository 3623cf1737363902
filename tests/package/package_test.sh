#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# package_test.sh DEB: unpacks the package into an empty folder and runs what is in it from there. What
# isn't installed (systemd-analyze, lintian, man) is said and left out.
set -euo pipefail
deb=$(realpath "$1")
root=$(mktemp -d)
trap 'rm -rf "$root"' EXIT
fail() { echo "package_test: $1" >&2; exit 1; }

dpkg-deb --extract "$deb" "$root"
waystone=$root/usr/bin/waystone
"$waystone" --version | grep -qx 'waystone [0-9.]*' || fail "--version says something else"

# Every library that it needs is of a package that it depends on, or of those that Debian always has.
ldd "$waystone" | grep -q 'not found' && fail "a library is missing"
depends=$(dpkg-deb --field "$deb" Depends)
for library in libopencv-core libsqlite3-0 libtbb libc6; do
  [[ $depends == *$library* ]] || fail "doesn't depend on $library: $depends"
done

# Walks a made building, maps it, serves the map and asks it three photos.
(cd "$root" && "$waystone" demo >demo.txt 2>&1) || { tail "$root/demo.txt"; fail "the demo failed"; }
grep -q localized "$root/demo.txt" || fail "the demo localized nothing"

# A page for the program and each subcommand, and a completion that knows them.
pages=$root/usr/share/man/man1
for command in $("$waystone" --help | sed -n '/^Subcommands:/,$p' | awk '/^  [a-z]/ {print $1}'); do
  [ -f "$pages/waystone-$command.1.gz" ] || fail "no manual page of $command"
  zcat "$pages/waystone-$command.1.gz" | grep -q '^\.SH SYNOPSIS' || fail "the page of $command is empty"
done
if command -v man >/dev/null; then
  warnings=$(MANROFFSEQ='' man --warnings -l "$pages/waystone-serve.1.gz" 2>&1 >/dev/null)
  [ -z "$warnings" ] || fail "man says: $warnings"
fi
completed=$(bash -c 'source "$1"; COMP_WORDS=(waystone lo); COMP_CWORD=1; _waystone; echo "${COMPREPLY[@]}"' \
  - "$root/usr/share/bash-completion/completions/waystone")
[ "$completed" = localize ] || fail "'waystone lo' is completed to '$completed'"

for file in copyright NOTICE changelog.gz; do
  [ -s "$root/usr/share/doc/waystone/$file" ] || fail "no $file"
done

mkdir "$root/unit"
for name in waystone waystone-node waystone-worker; do
  unit=$root/lib/systemd/system/$name.service
  grep -qx DynamicUser=yes "$unit" && grep -qx ProtectSystem=strict "$unit" || fail "$name isn't shut in"
  [ -s "$root/etc/default/$name" ] || fail "no /etc/default/$name"
  if command -v systemd-analyze >/dev/null; then
    # In its place here, so that the program that it starts is there.
    sed "s#/usr/bin/waystone#$waystone#; s#/etc/default#$root/etc/default#" "$unit" >"$root/unit/$name.service"
    said=$(systemd-analyze verify --man=no "$root/unit/$name.service" 2>&1) && [ -z "$said" ] ||
      fail "systemd-analyze says of $name: $said"
  else
    echo "$name isn't verified: systemd-analyze is missing"
  fi
done
if command -v lintian >/dev/null; then
  # The project has no mail address of its own yet: the two tags that are left out say so.
  lintian --allow-root --fail-on error,warning --suppress-tags-from-file "$(dirname "$0")/lintian_tags.txt" "$deb" || fail "see above"
else
  echo "The package isn't linted: lintian is missing (apt-get install lintian)"
fi
echo "$(basename "$deb") is sound"
