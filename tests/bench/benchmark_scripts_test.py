#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""What scripts/bench.py keeps of a run, and what scripts/benchmark_tables.py makes of it."""
import contextlib
import io
import json
import os
import re
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
import bench  # noqa: E402
import benchmark_tables  # noqa: E402

ABOUT = {"commit": "abc", "clean": True, "machine": {"cpu": "A processor", "cores": 2, "os": "An OS"}}


class BenchTest(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.enterContext(contextlib.redirect_stdout(io.StringIO()))
        self.enterContext(contextlib.redirect_stderr(io.StringIO()))

    def run_bench(self, script, arguments=("world", "--frames", "9")):
        program = self.folder / "program"
        program.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
        program.chmod(0o755)
        return bench.run(str(program), self.folder, "name", list(arguments), ABOUT)

    def record(self):
        return json.loads((self.folder / "name.json").read_text(encoding="utf-8"))

    def test_the_last_line_is_kept_with_where_it_comes_from(self):
        self.assertTrue(self.run_bench("""echo some text; echo '{"bench": "world", "share": 0.123456789}'"""))
        record = self.record()
        self.assertEqual(record["result"], {"bench": "world", "share": 0.123457})
        self.assertEqual(record["command"], "world --frames 9")
        self.assertEqual({key: record[key] for key in ABOUT}, ABOUT)
        self.assertRegex(record["date"], r"^\d{4}-\d\d-\d\d$")
        self.assertEqual([path.name for path in self.folder.glob("name*")], ["name.json"])

    def test_what_fails_leaves_the_earlier_result(self):
        self.assertTrue(self.run_bench("""echo '{"bench": "world"}'"""))
        before = self.record()
        for script in ("""echo '{"bench": "world"}'; exit 5""", "echo no JSON",
                       """echo '{"bench": "other"}'""", """echo '{"bench": "world"'""", "true"):
            self.assertFalse(self.run_bench(script), script)
            self.assertEqual(self.record(), before)

    def test_missing_data_is_skipped(self):
        os.environ["WAYSTONE_DATA"] = str(self.folder)
        self.addCleanup(os.environ.pop, "WAYSTONE_DATA")
        self.assertTrue(self.run_bench("exit 5", ("world", "DATA/nothing/*")))
        self.assertFalse((self.folder / "name.json").exists())
        (self.folder / "photos").mkdir()
        self.assertEqual(bench.with_data(["x", "DATA/phot*"]), ["x", str(self.folder / "photos")])

    def test_a_part_of_the_data_is_not_enough(self):
        os.environ["WAYSTONE_DATA"] = str(self.folder)
        self.addCleanup(os.environ.pop, "WAYSTONE_DATA")
        for folder in bench.FOLDERS["recall"][1:]:
            (self.folder / folder).mkdir()
        self.assertIsNone(bench.with_data(["recall", "DATA"]))
        (self.folder / bench.FOLDERS["recall"][0]).mkdir()
        self.assertEqual(bench.with_data(["recall", "DATA"]), ["recall", f"{self.folder}"])

    def test_a_program_that_is_not_there_fails_its_run_alone(self):
        self.assertFalse(bench.run(str(self.folder / "none"), self.folder, "name", ["world"], ABOUT))

    def test_the_commits_of_inputs_are_kept(self):
        (self.folder / "scale.json").write_text('{"commit": "def"}', encoding="utf-8")
        self.assertTrue(self.run_bench("""echo '{"bench": "world"}'""", ("world", "--scale", "RESULTS/scale.json")))
        self.assertEqual(self.record()["inputs"], {"scale": "def"})


class ScriptTest(unittest.TestCase):
    def test_paths_are_of_the_run_or_else_of_the_committed_results(self):
        with tempfile.TemporaryDirectory() as folder:
            results = Path(folder)
            (results / "scale.json").touch()
            arguments = ["--program", "BUILD/cli/waystone", "--a", "RESULTS/scale.json", "--b", "RESULTS/other.json", "/x"]
            self.assertEqual(bench.with_paths(arguments, "build/release", results),
                             ["--program", "build/release/cli/waystone", "--a", str(results / "scale.json"),
                              "--b", "docs/benchmarks/other.json", "/x"])

    def test_every_bench_with_the_whole_data_says_what_it_needs(self):
        whole = {arguments[0] for arguments in bench.runs().values() if "DATA" in arguments}
        self.assertEqual(whole, set(bench.FOLDERS))

    def test_scripts_are_shown_as_they_are_run(self):
        self.assertEqual(bench.shown("world --plan other"), "waystone-bench world --plan other")
        self.assertEqual(bench.shown("cluster --short"), "tests/cluster/cluster_test.py --short")
        root = Path(__file__).resolve().parents[2]
        for name, script in bench.SCRIPTS.items():
            self.assertIn(name, [arguments[0] for arguments in bench.runs().values()])
            self.assertTrue(os.access(root / script, os.X_OK), script)


class PageTest(unittest.TestCase):
    def test_the_page_has_the_buttons_that_its_bench_presses(self):
        root = Path(__file__).resolve().parents[2]
        bench_script = (root / "bench/web/measure_page.mjs").read_text(encoding="utf-8")
        page = "".join(path.read_text(encoding="utf-8") for path in (root / "server/web/src").glob("*.tsx"))
        names = re.findall(r'getByRole\("button", \{ name: "([^"]+)" \}\)', bench_script)
        self.assertTrue(names)
        for name in names:
            self.assertRegex(page, rf">{re.escape(name)}</button>")


class TablesTest(unittest.TestCase):
    RECORDS = {"run": {**ABOUT, "command": "world", "date": "2026-01-02", "seconds": 99.0, "cpu_seconds": 61.0,
                       "result": {"share": 0.5, "bytes": 2500000, "same": True, "count": 1234,
                                  "list": [{"name": "a-b", "count": 7}]}}}

    def fill(self, text):
        return benchmark_tables.fill(text, self.RECORDS)

    def test_placeholders_become_figures(self):
        self.assertIn("50.0 %, 2.5 MB, yes, 1,234, 7, 7, 1.0 minutes", self.fill(
            "{run.share:.1%}, {run.bytes:.1fM} MB, {run.same}, {run.count}, {run.list[0].count}, "
            "{run.list[a-b].count}, {all.cpu_minutes:.1f} minutes"))

    def test_what_no_result_has_is_refused(self):
        for text in ("{run.nothing}", "{other.share}", "{run.list[1].count}", "{run.list}", "{run.share}"):
            with self.assertRaises(ValueError, msg=text):
                self.fill(text)

    def test_what_was_not_measured_is_a_dash(self):
        text = self.fill("| a | b |\n|---|---|\n| c | {page.maps[0].graph_ms} ms |\n")
        self.assertIn("| - ms |\n\n*`waystone-bench page 500 10000`: not measured yet.*", text)

    def test_a_table_says_where_it_comes_from(self):
        text = self.fill("| a | b |\n|---|---|\n| c | {run.count} |\n\nText.\n")
        self.assertIn("1,234 |\n\n*`waystone-bench world` (61 s of CPU time): 2026-01-02, commit abc, A processor, "
                      "2 cores, An OS.*\n\nText.", text)

    def test_the_readme_has_figures_between_its_marks(self):
        begin, end = benchmark_tables.README_BEGIN, benchmark_tables.README_END
        self.assertEqual(benchmark_tables.with_figures(f"a\n{begin}old\n{end}b\n", "new\n"),
                         f"a\n{begin}new\n{end}b\n")
        for text in ("a\n", f"a\n{begin}b\n", f"a\n{end}b\n"):
            with self.assertRaises(ValueError, msg=text):
                benchmark_tables.with_figures(text, "new\n")

    def test_a_table_at_the_end_says_it_too(self):
        self.assertIn("commit abc", self.fill("| a | b |\n|---|---|\n| c | {run.count} |\n"))

    def test_figures_of_no_result_are_found(self):
        rows = {"{run.count} of {run.count}": True, "-": True, "": True, "50 %": False, "all": False,
                "{run.count} of 50": False}
        for cell, fine in rows.items():
            table = f"| 1 | target 2 | measured |\n|---|---|---|\n| 3 | 4 | {cell} |\n"
            self.assertEqual(benchmark_tables.unmeasured(table) == [], fine, cell)

    def test_a_table_of_different_sources_is_found(self):
        def record(commit, **more):
            return {**self.RECORDS["run"], "commit": commit, **more}
        table = "Text.\n| a | b | c |\n|---|---|---|\n| d | {a.count} | {b.count} |\n"
        for a, b, fine in ((record("x"), record("x"), True), (record("x"), record("y"), False),
                           (record("x", sources="s"), record("y", sources="s"), True)):
            self.assertEqual(benchmark_tables.mixed(table, {"a": a, "b": b}) == [], fine)
        records = {"a": record("x"), "b": record("y")}
        self.assertEqual(benchmark_tables.mixed(benchmark_tables.MIXED + table[6:], records), [])
        self.assertEqual(len(benchmark_tables.mixed(benchmark_tables.MIXED + table[6:] + table, records)), 1)
        self.assertNotIn("commits. -->", benchmark_tables.fill(benchmark_tables.MIXED + table, records))

    def test_inputs_that_were_measured_again_are_found(self):
        records = {"scale": {"commit": "x"}, "simulation": {"commit": "y", "inputs": {"scale": "x", "gone": "z"}}}
        self.assertEqual(benchmark_tables.stale(records), [])
        records["scale"]["commit"] = "y"
        self.assertEqual(len(benchmark_tables.stale(records)), 1)


class MainTest(unittest.TestCase):
    def setUp(self):
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        self.enterContext(contextlib.chdir(self.folder))
        self.enterContext(contextlib.redirect_stdout(io.StringIO()))
        benchmark_tables.FOLDER.mkdir(parents=True)
        Path("results").mkdir()
        self.write_template("{world.count}\n")
        benchmark_tables.README_TEMPLATE.write_text("", encoding="utf-8")
        benchmark_tables.README.write_text(benchmark_tables.README_BEGIN + benchmark_tables.README_END,
                                           encoding="utf-8")
        self.write(benchmark_tables.FOLDER, "2026-01-02", 2)
        self.assertEqual(benchmark_tables.main([]), 0)

    def write_template(self, text):
        benchmark_tables.TEMPLATE.write_text(text, encoding="utf-8")

    def write(self, folder, date, count):
        record = {**TablesTest.RECORDS["run"], "date": date, "result": {"count": count}}
        (Path(folder) / "world.json").write_text(json.dumps(record), encoding="utf-8")

    def committed(self):
        record = json.loads((benchmark_tables.FOLDER / "world.json").read_text(encoding="utf-8"))
        return record["result"]["count"]

    def test_later_results_replace_those_that_are_committed(self):
        self.write("results", "2026-01-03", 3)
        self.assertEqual(benchmark_tables.main(["results"]), 0)
        self.assertEqual(self.committed(), 3)
        self.assertIn("\n3\n", benchmark_tables.DOCUMENT.read_text(encoding="utf-8"))

    def test_earlier_results_do_not(self):
        self.write("results", "2026-01-01", 1)
        self.assertEqual(benchmark_tables.main(["results"]), 0)
        self.assertEqual(self.committed(), 2)

    def test_a_check_writes_nothing(self):
        self.write("results", "2026-01-03", 3)
        self.assertEqual(benchmark_tables.main(["--check", "results"]), 1)
        self.assertEqual(self.committed(), 2)

    def test_results_that_do_not_fill_the_page_are_not_taken(self):
        self.write("results", "2026-01-03", 3)
        self.write_template("{world.nothing}\n")
        with self.assertRaises(ValueError):
            benchmark_tables.main(["results"])
        self.assertEqual(self.committed(), 2)


if __name__ == "__main__":
    unittest.main()
