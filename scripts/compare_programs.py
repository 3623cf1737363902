#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that two builds of the program `waystone` make the same maps and give the same answers.

For changes that must not change behaviour: record what the program does before the change, compare
after each step.

  scripts/compare_programs.py record  PROGRAM FOLDER [--data DATA] [--quick]
  scripts/compare_programs.py compare PROGRAM FOLDER [--data DATA] [--quick]

`record` makes maps of two rendered walks and, where DATA (default: ../shared/data) exists, of
kitchen, church, street and dealership, asks each map for photos with `localize --json`, and stores
maps and answers in FOLDER. `compare` does the same with another program and lists every difference.
Left out of the comparison: the options and the schema version recorded in a map, tables and columns
that only the newer schema has, the hash and the number of rows of tables that are left out, times,
the map's version (a hash of the file) and messages for people. `--quick` takes fewer images.

Exits with 1 when anything differs.
"""
import argparse
import concurrent.futures
import glob
import json
import os
import shutil
import sqlite3
import subprocess
import sys
import tempfile

VOLATILE_ANSWER_FIELDS = {"timing_ms", "map_version", "message"}
VOLATILE_TABLES = {"contents"}  # hashes of the other tables
VOLATILE_COLUMNS = {"map": {"options", "created", "created_at"}}


def run(program, *arguments):
    done = subprocess.run([program, *arguments], capture_output=True, text=True)
    return done.returncode, done.stdout, done.stderr


def write_walks(program, folder):
    for name, extra in (("walk", []), ("office", ["--setting", "office"])):
        path = os.path.join(folder, name)
        if not os.path.isdir(path):
            code, _, err = run(program, "demo", "--write", path, *extra)
            if code != 0:
                sys.exit(f"{program} demo --write: {err}")


def pictures(pattern, step=1):
    return sorted(glob.glob(pattern))[::step]


def jobs(folder, data, quick):
    """name -> (arguments of build, [(arguments of localize, photos)])"""
    few = 4 if quick else 1
    walk = os.path.join(folder, "walk")
    office = os.path.join(folder, "office", "panorama")
    made_photos = pictures(os.path.join(walk, "**", "*.jpg"))
    queries = [p for p in made_photos if "quer" in p] or made_photos[5::9]
    last = str(60 if quick else 100000)
    found = {
        "walk": ([walk, "--layers", "planes"] + (["--to", last] if quick else []),
                 [([], queries[::few])]),
        "office": ([office, "--to", "60" if quick else "110"],
                   [([], pictures(office + "/*.jpg", 7 * few)),
                    (["--series"], pictures(office + "/*.jpg")[12:20]),
                    (["--fov-deg", "70"], queries[:3])]),
    }
    if not data:
        return found
    kitchen = os.path.join(data, "kitchen")
    kitchen_photos = pictures(kitchen + "/rgb/*.*")
    foreign = pictures(data + "/church/query_P8/*.jpg")[:3]
    found["kitchen"] = (
        [kitchen, "--to", "499", "--every", "12" if quick else "3",
         "--camera", kitchen + "/camera.yaml", "--layers", "planes,orientation"],
        [([], kitchen_photos[500::40 * few] + foreign)])
    found["church"] = ([data + "/church/map"] + (["--to", "11"] if quick else []),
                       [([], pictures(data + "/church/query_P8/*.jpg", few))])
    found["street"] = ([data + "/street", "--every", "2" if quick else "1"],
                       [([], pictures(data + "/street/**/*.png", 10)[:5] + foreign)])
    panoramas = data + "/dealership/panorama"
    found["dealership"] = (
        [panoramas, "--every", "4" if quick else "2"],
        [([], pictures(panoramas + "/*.jpg", 12 * few)),
         (["--series"], pictures(panoramas + "/*.jpg")[21:29]),
         (["--fov-deg", "90"], pictures(data + "/dealership/rig/*/front.jpg", 60))])
    return found


def make(program, name, job, folder):
    build, asked = job
    path = os.path.join(folder, name + ".db")
    code, _, err = run(program, "build", *build, "-o", path, "--force", "--progress", "none",
                       "--json")
    answers = []
    if code not in (0, 4):
        answers.append(f"build failed with {code}: {err}")
    else:
        for arguments, photos in asked:
            if photos:
                _, out, err = run(program, "localize", path, *photos, "--json", *arguments)
                answers += out.splitlines() + [line for line in err.splitlines()]
    with open(os.path.join(folder, name + ".answers"), "w", encoding="utf-8") as file:
        file.write("\n".join(answers) + "\n")
    print(f"  {name}: {len(answers)} answers", flush=True)


def without_volatile(value):
    if isinstance(value, dict):
        return {k: without_volatile(v) for k, v in value.items() if k not in VOLATILE_ANSWER_FIELDS}
    if isinstance(value, list):
        return [without_volatile(v) for v in value]
    return value


def answer(line):
    try:
        return without_volatile(json.loads(line))
    except ValueError:
        return None  # a message for people


def tables(path):
    db = sqlite3.connect(f"file:{path}?mode=ro", uri=True)
    names = [row[0] for row in db.execute(
        "SELECT name FROM sqlite_master WHERE type = 'table' ORDER BY name")]
    found = {}
    for name in names:
        if name in VOLATILE_TABLES or name.startswith("sqlite_"):
            continue
        columns = [row[1] for row in db.execute(f"PRAGMA table_info({name})")]
        rows = db.execute(f"SELECT * FROM {name}").fetchall()
        found[name] = {c: [row[i] for row in rows] for i, c in enumerate(columns)
                       if c not in VOLATILE_COLUMNS.get(name, ())}
    return found


def differences(name, before, after):
    found = []
    if not os.path.exists(os.path.join(before, name + ".db")):
        if os.path.exists(os.path.join(after, name + ".db")):
            found.append(f"{name}: a map that was not made before")
    elif not os.path.exists(os.path.join(after, name + ".db")):
        return [f"{name}: no map"]
    else:
        old = tables(os.path.join(before, name + ".db"))
        new = tables(os.path.join(after, name + ".db"))
        for table, columns in old.items():
            for column, values in columns.items():
                got = new.get(table, {}).get(column)
                if got is None:
                    found.append(f"{name}: column {table}.{column} is gone")
                elif got != values:
                    count = (f"{len(got)} rows instead of {len(values)}" if len(got) != len(values)
                             else f"{sum(a != b for a, b in zip(got, values))} rows differ")
                    found.append(f"{name}: {table}.{column}: {count}")
    with open(os.path.join(before, name + ".answers"), encoding="utf-8") as file:
        old_answers = [answer(line) for line in file]
    with open(os.path.join(after, name + ".answers"), encoding="utf-8") as file:
        new_answers = [answer(line) for line in file]
    if len(old_answers) != len(new_answers):
        found.append(f"{name}: {len(new_answers)} answers instead of {len(old_answers)}")
    for i, (a, b) in enumerate(zip(old_answers, new_answers)):
        if a != b:
            keys = [k for k in {**(a or {}), **(b or {})} if (a or {}).get(k) != (b or {}).get(k)]
            found.append(f"{name}: answer {i} differs in {', '.join(keys)}")
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["record", "compare"])
    parser.add_argument("program")
    parser.add_argument("folder")
    parser.add_argument("--data", default=os.path.normpath(
        os.path.join(os.path.dirname(__file__), "..", "..", "shared", "data")))
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--only", help="names of maps, comma-separated")
    args = parser.parse_args()
    program = os.path.abspath(args.program)
    folder = os.path.abspath(args.folder)
    os.makedirs(folder, exist_ok=True)
    if args.what == "record":
        write_walks(program, folder)
    data = args.data if os.path.isdir(args.data) else None
    todo = jobs(folder, os.path.abspath(data) if data else None, args.quick)
    if args.only:
        todo = {name: job for name, job in todo.items() if name in args.only.split(",")}
    into = folder if args.what == "record" else tempfile.mkdtemp(prefix="compare-")
    with concurrent.futures.ThreadPoolExecutor(1 if args.what == "record" else 2) as pool:
        list(pool.map(lambda item: make(program, item[0], item[1], into), todo.items()))
    if args.what == "record":
        return 0
    found = [line for name in todo for line in differences(name, folder, into)]
    print("\n".join(found) if found else f"{len(todo)} maps and their answers are equal")
    if found:
        print(f"what was made is in {into}")
    else:
        shutil.rmtree(into)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
