# SPDX-License-Identifier: Apache-2.0
"""Many maps, cheaply: parts of a rendered walk, each under several names with names of places."""
import json
import shutil
from concurrent.futures import ThreadPoolExecutor

from offline import run

FRAMES = 160
WINDOW = 56
EVERY = 4
NAMES_A_PART = 10


class Maps:
    """{name: map file} in a folder, and photos of all parts and of elsewhere."""

    def __init__(self, program, folder, count):
        self.program, self.folder = program, folder
        folder.mkdir(parents=True, exist_ok=True)
        self.walk = folder / "walk"
        if not (self.walk / "queries.csv").exists():
            run(program, "demo", "--write", self.walk)
        self.photos = sorted((self.walk / "queries").glob("*.jpg"))
        parts = max(2, count // NAMES_A_PART)
        with ThreadPoolExecutor(2) as both:
            bases = list(both.map(lambda i: self.part(i, parts), range(parts)))
            files = list(both.map(lambda i: self.named(bases[i % parts], f"map{i:03}"), range(count)))
        self.files = {file.stem: file for file in files}

    def part(self, i, parts):
        """A map of a window of the walk; every tenth one of SIFT features, the others of ORB."""
        path = self.folder / f"part-{parts}-{i}.db"
        if not path.exists():
            first = (FRAMES - WINDOW) * i // max(1, parts - 1)
            run(self.program, "build", self.walk / "images", "--from", first, "--to", first + WINDOW, "--every", EVERY,
                "--features", "sift" if i % 10 == 0 else "orb", "-o", path, "--quiet")
        return path

    def named(self, base, name):
        """The same map with a place of that name, which answers carry, so that no two maps answer alike."""
        path = self.folder / f"{base.stem}-maps" / f"{name}.db"
        if not path.exists():
            path.parent.mkdir(exist_ok=True)
            part = path.with_suffix(".part")
            shutil.copy(base, part)
            last = json.loads(run(self.program, "info", base, "--json"))["keyframes"]
            run(self.program, "name", part, "--keyframes", f"1:{last}", f"hall of {name}")
            part.rename(path)
        return path
