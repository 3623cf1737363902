#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""docs.py PROGRAM MAP IMAGES INSIDE ELSEWHERE: what README.md and docs/*.md say, tried out.

Runs every ```sh block, file by file and in order: README.md and the tutorial in a folder that was empty,
where a command that both have is run once; the other documents in a folder each that has what they speak
of: a walk with labelled queries, maps, photos and a server. A block that can't run here has the comment
<!-- not run: the reason --> on the line before it. Checks that links lead somewhere, that the messages
of troubleshooting.md are in the source with their codes, and that how-it-works.md names functions that
there are.
"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM, MAP, IMAGES, INSIDE, ELSEWHERE = (pathlib.Path(one) for one in sys.argv[1:6])
FROM_NOTHING = [ROOT / "README.md", ROOT / "docs/tutorial.md"]
DOCUMENTS = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
ADDRESS = "http://127.0.0.1:8080"
PATIENCE_S = 300
# Of the walk through the room, one picture each 10 cm: those around the photo, which is near the 20th.
WALKED = range(11, 41, 3)
PHOTO_FRAME = WALKED.index(20)
# Documents count in the images of the demo's walk.
DEMO_IMAGES = 160

PRELUDE = """set -euo pipefail
curl() { command curl --silent --show-error --fail-with-body "$@"; }
# The walk that documents begin with is rendered once.
waystone() {
  if [ $# = 3 ] && [ "$1 $2" = "demo --write" ]; then
    [ -e ~/../rendered ] || command waystone demo --write ~/../rendered
    cp -r ~/../rendered "$3"
  else
    command waystone "$@"
  fi
}
# A server that is started, found to serve, and told to end. An earlier one's line must not be found.
served() {
  rm -f served.txt
  env "$@" --port 0 >served.txt & local server=$! tries
  for tries in $(seq 300); do grep -qs Serving served.txt && break; sleep 0.1; done
  grep Serving served.txt
  kill $server
  wait $server
}
"""


def blocks(text):
    """The ```sh blocks with their line and the reason why they aren't run."""
    lines = text.split("\n")
    start = None
    for i, line in enumerate(lines):
        if line.startswith("```sh") and start is None:
            start = i
        elif line == "```" and start is not None:
            reason = re.fullmatch(r"<!-- not run: (.+) -->", lines[start - 1])
            yield start + 1, "\n".join(lines[start + 1:i]) + "\n", reason and reason[1]
            start = None


def prepare(folder, built):
    """What the documents speak of, but for the maps that they build themselves."""
    (folder / "walk").mkdir()
    for i in WALKED:
        shutil.copy(IMAGES / f"{i}.jpg", folder / "walk")
    for name in ("photo.jpg", "left.jpg", "right.jpg"):
        shutil.copy(INSIDE, folder / name)
    (folder / "elsewhere").mkdir()
    shutil.copy(ELSEWHERE, folder / "elsewhere")
    (folder / "maps").mkdir()
    for name in ("office.db", "lab.db", "hall.db", "maps/office.db"):
        if name not in built:
            shutil.copy(MAP, folder / name)
    for queries, photo, frame, frames in (("walk/", INSIDE, PHOTO_FRAME, len(WALKED)), ("", INSIDE, 20, 60)):
        (folder / f"{queries}queries.csv").write_text(f"image,frame,x,y,z\n{photo},{frame},0,0,0\n{ELSEWHERE},,,,\n")
        rows = "".join(f"{i},{0.1 * i},0,0\n" for i in range(frames))
        (folder / f"{queries}poses.csv").write_text("frame,x,y,z\n" + rows)


def shortened(block):
    """The block with --from and --to in the frames of the walk that documents get here."""
    scale = len(WALKED) / DEMO_IMAGES
    return re.sub(r"--(from|to) (\d+)", lambda found: f"--{found[1]} {round(int(found[2]) * scale)}", block)


def script_of(block, url, already):
    """A script of the block's commands that weren't run already, and all of its commands."""
    block = block.replace("build/release/cli/waystone", "waystone").replace(ADDRESS, url)
    lines = block.replace("\\\n", " ").split("\n")
    commands = [re.sub(r"\s+#.*", "", line) for line in lines]
    new = [line for line, command in zip(lines, commands, strict=True) if command not in already]
    return "\n".join("served " + line if line.startswith("waystone serve ") else line for line in new), commands


class Commands(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.home = pathlib.Path(tempfile.mkdtemp(prefix="waystone-docs-"))
        cls.addClassCleanup(shutil.rmtree, cls.home)
        cls.from_nothing = cls.home / "empty"
        cls.from_nothing.mkdir()
        cls.ran_from_nothing = set()
        (cls.home / "bin").mkdir()
        (cls.home / "bin/waystone").symlink_to(PROGRAM)
        (cls.home / "maps").mkdir()
        for name in ("office.db", "lab.db"):
            shutil.copy(MAP, cls.home / "maps" / name)
        server = subprocess.Popen([PROGRAM, "serve", cls.home / "maps", "--port", "0"], stdout=subprocess.PIPE, text=True)
        cls.addClassCleanup(server.stdout.close)
        cls.addClassCleanup(server.wait, PATIENCE_S)
        cls.addClassCleanup(server.terminate)
        cls.url = re.search(r"http://[\d.:]+", server.stdout.readline())[0]

    def run_document(self, document):
        text = document.read_text(encoding="utf-8")
        found = list(blocks(text))
        from_nothing = document in FROM_NOTHING
        if from_nothing:
            folder = self.from_nothing
        else:
            folder = pathlib.Path(tempfile.mkdtemp(dir=self.home))
            prepare(folder, set(re.findall(r"-o (\S+\.db)(?!.*--force)", "\n".join(block for _, block, _ in found))))
        ran = 0
        for line, block, reason in found:
            if reason:
                continue
            script, commands = script_of(block if from_nothing else shortened(block), self.url, self.ran_from_nothing if from_nothing else ())
            start = time.monotonic()
            done = subprocess.run(["bash", "-c", PRELUDE + script], cwd=folder, capture_output=True, text=True, timeout=PATIENCE_S,
                                  env={"PATH": f"{self.home}/bin:/usr/bin:/bin", "HOME": str(folder)})  # fmt: skip
            where = f"{document.relative_to(ROOT)}, line {line}"
            print(f"{where}: {time.monotonic() - start:.1f} s", flush=True)
            self.assertEqual(done.returncode, 0, f"{where}:\n{block}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
            if from_nothing:
                self.ran_from_nothing.update(commands)
            ran += 1
        return ran

    def test_every_block_runs(self):
        ran = sum(self.run_document(document) for document in DOCUMENTS)
        self.assertGreater(ran, 15)


class Text(unittest.TestCase):
    def test_links_lead_somewhere(self):
        for document in DOCUMENTS:
            for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", document.read_text(encoding="utf-8")):
                self.assertTrue((document.parent / target).exists(), f"{document.name}: {target}")

    def test_troubleshooting_has_the_programs_own_messages(self):
        folders = ("core", "schema", "localizer", "builder", "api", "registry", "server", "cli")
        sources = "\n".join(path.read_text(encoding="utf-8") for folder in folders
                            for path in sorted((ROOT / folder).rglob("*.cc")))
        # Literals beside each other are one.
        sources = re.sub(r'"\s*\n\s*"', "", sources).replace('\\"', '"')
        codes = set(re.findall(r'\{"(\w+)", "', (ROOT / "core/base/error.cc").read_text(encoding="utf-8")))
        text = (ROOT / "docs/troubleshooting.md").read_text(encoding="utf-8")
        rows = re.findall(r"^\| `(.+?)` \| (?:`(\w+)`)? ?\|", text, re.MULTILINE)
        self.assertGreater(len(rows), 30)
        for message, code in rows:
            for part in filter(None, message.split("…")):
                self.assertTrue(part in sources, f"no source says '{part}'")
            self.assertIn(code, codes | {""}, message)

    def test_how_it_works_names_what_there_is(self):
        text = (ROOT / "docs/how-it-works.md").read_text(encoding="utf-8")
        named = re.findall(r"`([\w/.]+\.(?:h|cc))`(?: \||\s+)\s*`(\w+)`", text)
        self.assertGreater(len(named), 25)
        for path, name in named:
            self.assertTrue((ROOT / path).is_file(), path)
            there = re.search(rf"\b{name}\b", (ROOT / path).read_text(encoding="utf-8"))
            self.assertTrue(there, f"{path} has no {name}")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[6:])
