#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""compile_each.py JOBS: has clang read each source by itself, with warnings as errors.

The other builds compile several sources of a library as one, so that a source could use what only
another one includes or names. clang reads them in half of gcc's time; gcc's own warnings are errors in
the build with AddressSanitizer.
"""
import concurrent.futures
import json
import re
import subprocess
import sys
from pathlib import Path

BUILD = Path("build/standalone")


def commands():
    """The command that compiles each of our sources, by path. Generated sources are left out."""
    root = Path.cwd()
    for entry in json.loads((BUILD / "compile_commands.json").read_text()):
        source = Path(entry["file"]).relative_to(root)
        if source.suffix == ".cc" and source.parts[0] not in ("build", "cmake"):
            command = re.sub(r"^.*?(\S*/(c|g|clang)\+\+\S*) ", r"\1 ", entry["command"])
            yield source, re.sub(r" -o \S+", "", command) + " -fsyntax-only"


def read(source, command):
    done = subprocess.run(command, shell=True, cwd=BUILD, capture_output=True, text=True, check=False)
    if done.returncode or done.stderr:
        print(f"{source}:\n{done.stderr}", flush=True)
    return done.returncode == 0


def main(jobs):
    subprocess.run(["scripts/build.sh", "standalone", str(jobs), "waystone_headers"], check=True)
    todo = list(commands())
    print(f"Reading {len(todo)} sources, each by itself", file=sys.stderr)
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        failed = list(pool.map(lambda each: read(*each), todo)).count(False)
    return f"{failed} sources can't be compiled by themselves" if failed else 0


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1])))
