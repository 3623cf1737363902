#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""tidy.py JOBS [FOLDER...]: clang-tidy over all sources, or those of some folders; warnings are errors.

Each check walks all headers that a source includes, which is most of clang-tidy's work. So sources of
a folder are read as one, as many as their local names allow. A batch that doesn't compile that way is
read in halves.
"""
import concurrent.futures
import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import check_local_names

BUILD = Path("build/dev")
BATCH = 100  # sources; with more the last one would run alone
# Folders whose sources may be read together. Those of tests aren't mixed with others, which are read
# with more checks.
GROUPS = [("core", "world"), ("schema", "localizer", "quality"), ("builder",),
          ("api", "registry", "server"), ("cli",), ("bench",), ("tests/core", "tests/world"),
          ("tests/builder", "tests/server"), ("tests",)]
# Takes a third of clang-tidy's time to find copies whose cost doesn't matter in tests.
NOT_IN_TESTS = "--checks=-performance-unnecessary-value-param"
# Flags that only gcc knows, or that clang-tidy doesn't need.
DROPPED = re.compile(r"-fpch-preprocess|--param=\S+|-Wno-(maybe-uninitialized|restrict|stringop-\w+)|-g\d?|-O\d|-c")


def group_of(source):
    for group in GROUPS:
        if any(map(source.is_relative_to, group)):
            return group
    sys.exit(f"{source} is in none of the GROUPS of scripts/tidy.py; add its folder")


def sources_and_flags(folders):
    """{source: compiler flags} of our sources; generated ones are left out."""
    found = {}
    for entry in json.loads((BUILD / "compile_commands.json").read_text()):
        source = Path(entry["file"]).relative_to(Path.cwd())
        if source.suffix != ".cc" or source.parts[0] in ("build", "cmake"):
            continue
        if folders and not any(source.is_relative_to(folder) for folder in folders):
            continue
        words = shlex.split(entry["command"])
        words = words[next(i for i, word in enumerate(words) if word.endswith("++")) + 1:]
        flags, i = [], 0
        while i < len(words):
            pair = 2 if words[i] in ("-isystem", "-o", "-include") else 1
            if words[i] != "-o" and words[i] != entry["file"] and not DROPPED.fullmatch(words[i]):
                flags.append(tuple(words[i:i + pair]))
            i += pair
        found.setdefault(source, flags)
    return found


def local_names(source):
    text = source.read_text()
    names = {key: found for key, found in check_local_names.local_names(text).items()}
    if re.search(r"^int main\(", text, re.MULTILINE):
        names["", "main"] = {None}
    return names


def fits(names, batch_names):
    """Whether no two names clash; aliases may be the same."""
    for key, found in names.items():
        other = batch_names.get(key)
        if other and not (other == found and all(s and s.startswith("= ") for s in found)):
            return False
    return True


def batches(sources):
    """Lists of sources of one group without a name in common."""
    made = []  # (group, names, sources)
    for source in sorted(sources):
        names, group = local_names(source), group_of(source)
        if 'extern "C" {' in source.read_text():  # its definitions would replace the system's in the others
            group = source
        for of, taken, members in made:
            if of == group and len(members) < BATCH and fits(names, taken):
                break
        else:
            taken, members = {}, []
            made.append((group, taken, members))
        taken.update(names)
        members.append(source)
    return sorted((members for _, _, members in made), key=len, reverse=True)


def run_tidy(batch, flags):
    """Whether clang-tidy finds nothing in the batch; prints what it finds."""
    merged = dict.fromkeys(flag for source in batch for flag in flags[source])
    text = "".join(f'#include "{Path.cwd() / source}"\n' for source in batch)
    # Beside the sources' root, so that it finds .clang-tidy.
    unit = Path("build/tidy") / (str(batch[0]).replace("/", "_") + f"_{len(batch)}.cc")
    unit.write_text(text)
    checks = [NOT_IN_TESTS] if batch[0].parts[0] == "tests" else []
    done = subprocess.run(
        ["clang-tidy", "--quiet", "--warnings-as-errors=*", *checks, str(unit), "--",
         *(word for flag in merged for word in flag)],
        capture_output=True, text=True, check=False)
    if done.returncode == 0:
        return True
    if len(batch) > 1 and "clang-diagnostic-error" in done.stdout + done.stderr:
        half = len(batch) // 2
        return all([run_tidy(batch[:half], flags), run_tidy(batch[half:], flags)])
    print(done.stdout or done.stderr, flush=True)
    return False


def main(jobs, folders):
    subprocess.run(["cmake", "--preset", "dev"], check=True, stdout=subprocess.DEVNULL)
    Path("build/tidy").mkdir(parents=True, exist_ok=True)
    flags = sources_and_flags(folders)
    todo = batches(flags)
    print(f"Reading {len(flags)} sources in {len(todo)} batches with clang-tidy", file=sys.stderr)
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        clean = list(pool.map(lambda batch: run_tidy(batch, flags), todo))
    return 0 if all(clean) else 1


if __name__ == "__main__":
    os.environ["LC_ALL"] = "C.UTF-8"
    sys.exit(main(int(sys.argv[1]), sys.argv[2:]))
