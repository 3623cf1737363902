# SPDX-License-Identifier: Apache-2.0
"""The maps of a soak and the answers that `waystone localize` gives on them."""
import json
import subprocess
import sys


def make_maps(program, folder, count):
    """Map files of parts of a building, photos, and {map's version: {photo: answer}}."""
    walk = folder / "walk"
    if not (walk / "queries.csv").exists():
        run(program, "demo", "--write", walk)
    maps = []
    for name, first, last in (("west", 0, 56), ("east", 104, 159), ("middle", 52, 108))[:count]:
        path = folder / f"{name}.db"
        if not path.exists():
            run(program, "build", walk / "images", "--from", first, "--to", last, "--every", 4, "-o", path)
        maps.append(path)
    every = sorted((walk / "queries").glob("*.jpg"))
    elsewhere = [photo for photo in every if photo.name.startswith("other")]
    photos = [photo for photo in every if photo not in elsewhere][::2] + elsewhere[::7]
    answers = {}
    for path in maps:
        lines = run(program, "localize", path, *photos, "--json").splitlines()
        parsed = [json.loads(line) for line in lines]
        answers[parsed[0]["map_version"]] = {
            photo: comparable(answer) for photo, answer in zip(photos, parsed, strict=True)}
    return maps, photos, answers


def version(program, path):
    return json.loads(run(program, "info", path, "--json"))["version"]


def run(program, *arguments):
    """What the program prints; it may say that there is no usable answer (4) to some of the photos."""
    done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, check=False)
    if done.returncode not in (0, 4):
        sys.exit(f"waystone {arguments[0]} exited with {done.returncode}: {done.stderr}")
    return done.stdout


def comparable(answer):
    """An answer without times and the names that whoever asked gave."""
    return {key: value for key, value in answer.items() if key not in ("timing_ms", "image", "map")}
