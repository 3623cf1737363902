#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""bench.py BUILD [NAME...]: runs the benches that docs/benchmarks.md reports, or those named.

What NAME measured goes to BUILD/bench/results/NAME.json, whole or not at all: the bench's last line
with its command, commit, machine, date and seconds. Real data is read from the folder named by
WAYSTONE_DATA; a bench whose data is missing is skipped, and one that fails keeps its earlier result. Exits
with 1 when one failed.
scripts/benchmark_tables.py writes the document from the results.
"""
import argparse
import datetime
import glob
import hashlib
import json
import os
import platform
import resource
import subprocess
import sys
import time
from pathlib import Path

# Name of a result, and what waystone-bench is given for it, or one of SCRIPTS: BUILD is the folder of
# the build, RESULTS the results of this run, or else those of docs/benchmarks.
RUNS = """
world                world
world-other          world --plan other --seed 2 --frames 500
kitchen              rgbd DATA/kitchen
kitchen-400          rgbd DATA/kitchen --set keyframes.min_matches_last=400 --set keyframes.min_matches_before_last=200
kitchen-500          rgbd DATA/kitchen --set keyframes.min_matches_last=500 --set keyframes.min_matches_before_last=250
world-extrapolated   world --set planes.max_extrapolation=1000 --set planes.min_anchored=0
kitchen-extrapolated rgbd DATA/kitchen --set planes.max_extrapolation=1000 --set planes.min_anchored=0
world-greedy         world --set planes.segmentation.greedy=true
kitchen-greedy       rgbd DATA/kitchen --set planes.segmentation.greedy=true
world-paper          world --set planes.segmentation.greedy=true --set planes.max_extrapolation=1000 --set planes.min_anchored=0
kitchen-paper        rgbd DATA/kitchen --set planes.segmentation.greedy=true --set planes.max_extrapolation=1000 --set planes.min_anchored=0
pairs                pairs DATA/labelled_pairs/*
pairs-greedy         pairs DATA/labelled_pairs/* --set planes.segmentation.greedy=true
rendered-pairs       rendered-pairs --first 5001
rendered-pairs-greedy rendered-pairs --first 5001 --set planes.segmentation.greedy=true
homographies         homographies DATA/homographies/*
verdicts             verdicts DATA
recall               recall DATA
recall-exchanged     recall DATA --exchanged yes
recall-77k           recall DATA --landmarks 100 --search no --set features.working_pixels=76800
recall-307k          recall DATA --landmarks 100 --search no --set features.working_pixels=307200
recall-1m            recall DATA --landmarks 100 --search no --set features.working_pixels=1000000
peers                peers DATA --only kitchen,corridor
cameras              cameras DATA
look-alikes          look-alikes
look-alikes-others   look-alikes --first 17 --buildings 8
look-alikes-photos   look-alikes --first 17 --buildings 8 --every 8
storeys              storeys DATA
large-77k            look-alikes --first 17 --buildings 4 --width 1280 --set features.working_pixels=76800
large-154k           look-alikes --first 17 --buildings 4 --width 1280
large-307k           look-alikes --first 17 --buildings 4 --width 1280 --set features.working_pixels=307200
large-1m             look-alikes --first 17 --buildings 4 --width 1280 --set features.working_pixels=1000000
scale                scale
collection           collection DATA
linear               linear DATA/kitchen 250 500 1000
campus               campus 4 16 52
graphs               graphs DATA/kitchen DATA/church world
density-300          graphs DATA/kitchen --keyframes 300:150 --opencv-every 0
density-350          graphs DATA/kitchen --keyframes 350:175 --opencv-every 0
density-400          graphs DATA/kitchen --keyframes 400:200 --opencv-every 0
density-500          graphs DATA/kitchen --keyframes 500:250 --opencv-every 0
build                build DATA/kitchen --frames 250,500,1000
poses                poses --kitchen DATA/kitchen --church DATA/church --panoramas DATA/dealership
reconstruction       reconstruction DATA/kitchen
joining              joining DATA
visits               visits DATA
joining-panoramas    joining-panoramas DATA/dealership
compass              compass DATA/dealership
directions           directions DATA/york_urban DATA/dealership
segments             segments DATA/york_urban/images
relative             relative DATA/dealership
orientation          orientation --scale 0.75
orientation-bare     orientation --scale 0.75 --buildings 1 --trim no
building             building DATA/kitchen DATA/dealership
odometry             odometry
study                study
kidnapped            kidnapped DATA/dealership
serve                serve
cluster              cluster --program BUILD/cli/waystone --folder BUILD/cluster
simulation           simulation --measured RESULTS/cluster.json --scale RESULTS/scale.json
page                 page 500 10000
orientation-paper    orientation --scale 0.75 --camera rig --set orientation.turns.use_motions=false
"""

# The folders that a bench needs in DATA, if it is given all of DATA.
PHOTOS = ["church", "corridor", "kitchen", "pavilion", "tower"]
FOLDERS = {"cameras": PHOTOS, "collection": PHOTOS, "joining": PHOTOS, "peers": PHOTOS, "recall": [*PHOTOS, "dealership"],
           "storeys": ["tower"], "visits": PHOTOS,
           "verdicts": ["church/map", "church/query_P8", "corridor", "dealership/rig", "homographies", "kitchen",
                        "street/image_0", "tower", "york_urban"]}

SCRIPTS = {"cluster": "tests/cluster/cluster_test.py", "simulation": "bench/cluster/simulate.py"}


def runs():
    """{name: arguments}, with DATA in them."""
    return {words[0]: words[1:] for words in map(str.split, RUNS.strip().splitlines())}


def data_folder():
    return os.environ.get("WAYSTONE_DATA", "../shared/data")


def with_data(arguments):
    """The arguments with the folder of the data, or None if that lacks some of them."""
    filled = []
    for argument in arguments:
        paths = [argument]
        if argument.split("/")[0] == "DATA":
            paths = sorted(glob.glob(data_folder() + argument[len("DATA"):]))
        if argument == "DATA" and not all((Path(data_folder()) / each).exists() for each in FOLDERS[arguments[0]]):
            return None
        if not paths:
            return None
        filled += paths
    return filled


def shown(command):
    """How to run what a result names as its command."""
    name, _, rest = command.partition(" ")
    return f"{SCRIPTS[name]} {rest}" if name in SCRIPTS else f"waystone-bench {command}"


def with_paths(arguments, build, results):
    """The arguments with the folders of this run."""
    filled = []
    for argument in arguments:
        folder, _, rest = argument.partition("/")
        if folder == "RESULTS":
            argument = str(results / rest if (results / rest).exists() else Path("docs/benchmarks") / rest)
        filled.append(f"{build}/{rest}" if folder == "BUILD" else argument)
    return filled


def inputs_of(arguments):
    """{name: commit} of the results among the arguments (with_paths)."""
    paths = [Path(argument) for argument in arguments if argument.endswith(".json")]
    return {path.stem: json.loads(path.read_text(encoding="utf-8"))["commit"] for path in paths}


def git(*arguments):
    return subprocess.run(["git", *arguments], check=True, capture_output=True, text=True).stdout.strip()


def sources():
    """The commit, what the programs are built from in it, and whether they are.

    Commits that differ in documents alone have the same sources.
    """
    files = ("--", ":!docs", ":!*.md")
    content = hashlib.sha256(git("ls-files", "--stage", *files).encode()).hexdigest()[:12]
    return {"commit": git("rev-parse", "--short=9", "HEAD"), "sources": content,
            "clean": not git("status", "--porcelain", *files)}


def machine():
    def field(path, name):
        lines = Path(path).read_text(encoding="utf-8").splitlines()
        found = [line for line in lines if line.split("=")[0].split(":")[0].strip() == name]
        return found[0].replace(":", "=", 1).split("=", 1)[1].strip().strip('"') if found else "unknown"
    return {"cpu": field("/proc/cpuinfo", "model name"), "cores": os.cpu_count(),
            "os": f"{field('/etc/os-release', 'PRETTY_NAME')}, {platform.machine()}"}


def rounded(value):
    """Six digits exceed the accuracy of any of these."""
    if isinstance(value, float):
        return float(f"{value:.6g}")
    if isinstance(value, dict):
        return {key: rounded(each) for key, each in value.items()}
    return [rounded(each) for each in value] if isinstance(value, list) else value


def last_line(command):
    """Runs it, shows its output, and returns its last line."""
    last = ""
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        for line in process.stdout:
            print(line if len(line) < 400 else line[:400] + "...\n", end="", flush=True)
            last = line
    if process.returncode != 0:
        raise RuntimeError(f"exit status {process.returncode}")
    return last


def measure(program, arguments, filled, about):
    """The record of one run. Raises ValueError unless its last line is a JSON object."""
    cpu = resource.getrusage(resource.RUSAGE_CHILDREN)
    start = time.monotonic()
    result = json.loads(last_line([program, *filled]))
    seconds = time.monotonic() - start
    now = resource.getrusage(resource.RUSAGE_CHILDREN)
    if not isinstance(result, dict) or result.get("bench") != arguments[0]:
        raise ValueError(f"the last line is no result of '{arguments[0]}'")
    return {"command": " ".join(arguments), **about,
            "date": datetime.datetime.now(datetime.timezone.utc).date().isoformat(),
            "seconds": round(seconds, 1),
            "cpu_seconds": round(now.ru_utime + now.ru_stime - cpu.ru_utime - cpu.ru_stime, 1),
            "result": rounded(result)}


def write(path, record):
    part = path.with_suffix(".part")
    part.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    os.replace(part, path)


def run(program, results, name, arguments, about, build="."):
    """Whether all is well: measured, or skipped because there is no data for it."""
    print(f"\n== {name}: {shown(' '.join(arguments))}", flush=True)
    filled = with_data(arguments)
    if filled is None:
        print(f"skipped: {data_folder()} has not got its data (set WAYSTONE_DATA to where it is)")
        return True
    try:
        filled = with_paths(filled, build, results)
        inputs = inputs_of(filled)
        record = measure(program, arguments, filled, {**about, **({"inputs": inputs} if inputs else {})})
        write(results / f"{name}.json", record)
    except (OSError, RuntimeError, ValueError) as error:
        print(f"bench.py: {name} failed: {error}", file=sys.stderr)
        return False
    return True


def main(build, names):
    unknown = [name for name in names if name not in runs()]
    if unknown:
        sys.exit(f"bench.py: there is no {', '.join(unknown)}; there are {', '.join(runs())}")
    results = Path(build) / "bench/results"
    results.mkdir(parents=True, exist_ok=True)
    about = {**sources(), "machine": machine()}
    start = time.monotonic()
    failed = [name for name in names or runs()
              if not run(SCRIPTS.get(runs()[name][0], f"{build}/bench/waystone-bench"), results, name, runs()[name],
                         about, build)]
    print(f"\n{(time.monotonic() - start) / 60:.0f} minutes; results in {results}"
          + (f"; failed: {', '.join(failed)}" if failed else ""))
    return 1 if failed else 0


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", metavar="BUILD", help="folder of the build, such as build/release")
    parser.add_argument("names", metavar="NAME", nargs="*", help="a result; all without any")
    given = parser.parse_args()
    sys.exit(main(given.build, given.names))
