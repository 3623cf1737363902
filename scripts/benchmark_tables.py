#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""benchmark_tables.py [--check] [RESULTS]: writes docs/benchmarks.md and the figures of README.md.

They are docs/benchmarks/benchmarks.md.in and readme.md.in with their placeholders filled from the results
beside them, one file a run of scripts/bench.py. Those in RESULTS, where it is given, replace them unless
they are of an earlier day.
{world.found_share:.1%} is found_share of the run `world`, in percent; elements of lists are taken by
their number or name. Formats are Python's; `M` and `K` divide by a million and a thousand. What a run
hasn't measured is a dash. A line below each table gives the date, commit and machine of its runs. With
--check nothing is written. The exit status is 1 when a document isn't what would be written, when a
table has a figure that comes from no result or runs of different sources, or when a run was given
results of another one that aren't there any more. Columns of targets and the first one, which names the
rows, are the template's. A line `<!-- Of different commits. -->` before a table allows it runs of
different sources; it isn't written.
"""
import difflib
import json
import re
import string
import sys
from pathlib import Path

import bench

DOCUMENT = Path("docs/benchmarks.md")
FOLDER = Path("docs/benchmarks")
TEMPLATE = FOLDER / "benchmarks.md.in"
README = Path("README.md")
README_TEMPLATE = FOLDER / "readme.md.in"
NOTE = ("<!-- Written by scripts/benchmark_tables.py: change docs/benchmarks/benchmarks.md.in, or run "
        "`make bench`. -->\n")
README_BEGIN = "<!-- Figures: written by scripts/benchmark_tables.py from docs/benchmarks/readme.md.in. -->\n"
README_END = "<!-- End of the figures. -->\n"
MIXED = "<!-- Of different commits. -->\n"


class Figure:
    """A value of a result, reached by its path and printed by a format."""

    def __init__(self, value, path):
        self.value, self.path = value, path

    def __getattr__(self, key):
        return self[key]

    def __getitem__(self, key):
        path = f"{self.path}.{key}"
        if self.value is None:
            return Figure(None, path)
        if isinstance(self.value, list):
            found = [each for each in self.value if isinstance(each, dict)
                     and key in (each.get("name"), each.get("scene"), each.get("set"))]
            if isinstance(key, int) and key < len(self.value):
                return Figure(self.value[key], path)
            if found:
                return Figure(found[0], path)
        elif isinstance(self.value, dict) and str(key) in self.value:
            return Figure(self.value[str(key)], path)
        raise ValueError(f"there is no {path}")

    def __format__(self, spec):
        value = self.value
        if isinstance(value, bool):
            return "yes" if value else "no"
        if value is None:
            return "-"
        if isinstance(value, (dict, list)):
            raise ValueError(f"{self.path} is no figure")
        if spec.endswith(("M", "K")):
            value, spec = value / {"M": 1e6, "K": 1e3}[spec[-1]], spec[:-1]
        if isinstance(value, int) and not spec:
            spec = ","
        if isinstance(value, float) and not spec:
            raise ValueError(f"{self.path} wants a format")
        return format(value, spec).replace("%", " %")


class Results(dict):
    def __missing__(self, name):
        if name in bench.runs():
            return Figure(None, name)
        raise ValueError(f"there is no result of the run '{name}'")


def read(folder):
    return {path.stem: json.loads(path.read_text(encoding="utf-8"))
            for path in sorted(folder.glob("*.json"))}


def newest(folders):
    """The results of all folders; of those of one run the latest day's, or else the last folder's."""
    records = {}
    for folder in folders:
        for name, record in read(folder).items():
            if name not in records or record["date"] >= records[name]["date"]:
                records[name] = record
    return records


def runs_of(line):
    """The runs whose results are in a line, in their order."""
    names = [re.split(r"[.\[]", field)[0] for _, field, _, _ in string.Formatter().parse(line) if field]
    return list(dict.fromkeys(names))


def stamp(records, names):
    """Where the figures of a table come from, one line per commit, day and machine."""
    together = {}
    for name in names:
        if name not in records:
            together.setdefault("not measured yet", []).append(
                f"`{bench.shown(' '.join(bench.runs()[name]))}`")
            continue
        record = records[name]
        machine = record["machine"]
        commit = record["commit"] + ("" if record["clean"] else " with changes")
        where = (f"{record['date']}, commit {commit}, {machine['cpu']}, {machine['cores']} cores, "
                 f"{machine['os']}")
        if record.get("copied"):
            where += "; copied from the page as it was then, without the other figures of the run"
        seconds = f" ({record['cpu_seconds']:.0f} s of CPU time)" if record["seconds"] else ""
        together.setdefault(where, []).append(f"`{bench.shown(record['command'])}`{seconds}")
    return "".join(f"*{', '.join(commands)}: {where}.*\n" for where, commands in together.items())


def is_table(line):
    return line.startswith("|")


def fill(template, records, name=TEMPLATE):
    """What a template says, in lines as long as figures make them. `name` is for errors.

    Raises ValueError for a placeholder that no result fills.
    """
    results = Results({name: Figure(record["result"], name) for name, record in records.items()})
    timed = [record["cpu_seconds"] for record in records.values() if record["seconds"]]
    results["all"] = Figure({"cpu_minutes": sum(timed) / 60, "timed": len(timed)}, "all")
    out, names = [], []
    for number, line in enumerate(template.splitlines(keepends=True), 1):
        if line == MIXED:
            continue
        if names and not is_table(line):
            out.append("\n" + stamp(records, names))
            names = []
        try:
            out.append(string.Formatter().vformat(line, (), results))
        except ValueError as error:
            raise ValueError(f"{name}:{number}: {error}") from error
        if is_table(line):
            names += [name for name in runs_of(line) if name not in names]
    if names:
        out.append("\n" + stamp(records, names))
    return "".join(out)


def with_figures(readme, figures):
    """The README with these figures between its marks."""
    before, begin, rest = readme.partition(README_BEGIN)
    _, end, after = rest.partition(README_END)
    if not begin or not end:
        raise ValueError(f"{README} has no place for figures")
    return before + begin + figures + end + after


def cells(line):
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def unmeasured(template, path=TEMPLATE):
    """Table cells with something that is in neither a result nor a target."""
    found, heading = [], None
    for number, line in enumerate(template.splitlines(), 1):
        if not is_table(line):
            heading = None
            continue
        if heading is None:
            heading = cells(line)
            continue
        if set(line) <= set("|-: "):
            continue
        for name, cell in list(zip(heading, cells(line)))[1:]:
            said = re.sub(r"{[^}]*}", "", cell)
            if "target" not in name and cell not in ("", "-") and (said == cell or re.search(r"\d", said)):
                found.append(f"{path}:{number}: '{cell}' comes from no result")
    return found


def sources_of(record):
    """What the programs of a run were built from; for early runs only the commit is known."""
    return record.get("sources", record["commit"])


def mixed(template, records, path=TEMPLATE):
    """Tables that compare runs of different sources without saying that they may."""
    found, names, allowed, start = [], [], False, 0
    for number, line in enumerate([*template.splitlines(keepends=True), ""], 1):
        if is_table(line):
            start = start if names else number
            names += [name for name in runs_of(line) if name in records]
            continue
        if len({sources_of(records[name]) for name in names}) > 1 and not allowed:
            runs = ", ".join(f"{name} of {records[name]['commit']}" for name in dict.fromkeys(names))
            found.append(f"{path}:{start}: the table compares different sources: {runs}")
        names, allowed = [], line == MIXED
    return found


def stale(records):
    """Runs whose inputs are results that have since been measured again."""
    return [f"{name} was given {given} of commit {commit}, which is of {records[given]['commit']} now"
            for name, record in records.items() for given, commit in record.get("inputs", {}).items()
            if given in records and records[given]["commit"] != commit]


def main(arguments):
    check = "--check" in arguments
    folders = [FOLDER] + [Path(each) for each in arguments if each != "--check"]
    records, filled = newest(folders), {}
    problems = stale(records)
    for path in (TEMPLATE, README_TEMPLATE):
        template = path.read_text(encoding="utf-8")
        problems += unmeasured(template, path) + mixed(template, records, path)
        filled[path] = fill(template, records, path)
    texts = {DOCUMENT: NOTE + filled[TEMPLATE],
             README: with_figures(README.read_text(encoding="utf-8"), filled[README_TEMPLATE])}
    for path, text in texts.items():
        if check:
            problems += difflib.unified_diff(
                path.read_text(encoding="utf-8").splitlines(), text.splitlines(),
                str(path), "what scripts/benchmark_tables.py writes", lineterm="", n=0)
        elif not problems:
            path.write_text(text, encoding="utf-8")
    if not check and not problems:
        committed = read(FOLDER)
        for name in [name for name in records if records[name] != committed.get(name)]:
            bench.write(FOLDER / f"{name}.json", records[name])
    print("\n".join(problems) if problems else f"{DOCUMENT} and {README} say what {FOLDER} has")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
