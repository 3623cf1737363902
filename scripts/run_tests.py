#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""run_tests.py BUILD_DIR [CTEST_ARGUMENT...]: runs ctest and counts the test cases.

The last line is `N passed, N failed, N skipped`; failed and skipped cases are named above it. A test
program counts with each of its GoogleTest cases, any other test as one. Exits with 1 when a test
failed, or when none ran.
"""
import os
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

# As the program does at its start (cli/system/freed_memory.h): freed memory is kept for the next
# image. Returning it to the kernel each time makes tests of whole maps up to a quarter slower.
KEEP_FREED_MEMORY = "glibc.malloc.mmap_threshold=33554432:glibc.malloc.trim_threshold=268435456"


def gtest_cases(report):
    """(name, outcome, reason) of each case in a report of GoogleTest."""
    for case in ElementTree.parse(report).getroot().iter("testcase"):
        if case.get("status") == "notrun":
            continue
        name, skipped = f"{case.get('classname')}.{case.get('name')}", case.find("skipped")
        if case.find("failure") is not None:
            yield name, "failed", ""
        elif skipped is not None:
            # The text is "file:line", then what the test says.
            said = (skipped.text or "").strip().split("\n")[1:]
            yield name, "skipped", " ".join(said).strip()
        else:
            yield name, "passed", ""


def ctest_outcome(case):
    if case.find("skipped") is not None or case.get("status") == "notrun":
        return "skipped"
    return "failed" if case.get("status") == "fail" else "passed"


def cases_of(test, reports):
    """The cases of one ctest entry. A program that died has no report, or one without a failure."""
    name, outcome = test.get("name"), ctest_outcome(test)
    report = reports / f"test_{name}.xml"
    if not report.exists():
        return [(name, outcome, "")]
    cases = list(gtest_cases(report))
    if outcome == "failed" and not any(case[1] == "failed" for case in cases):
        cases.append((name, "failed", ""))
    return cases


def main(build, arguments):
    results = Path(build).resolve() / "test_results"
    shutil.rmtree(results, ignore_errors=True)
    results.mkdir(parents=True)
    summary = results / "ctest.xml"
    code = subprocess.run(
        ["ctest", "--test-dir", build, "--output-on-failure", "--no-tests=error",
         "--output-junit", str(summary), *arguments],
        env={**os.environ, "GTEST_OUTPUT": f"xml:{results}/", "GLIBC_TUNABLES": KEEP_FREED_MEMORY},
        check=False).returncode

    cases = []
    if summary.exists():
        for test in ElementTree.parse(summary).getroot().iter("testcase"):
            cases += cases_of(test, results)
    counts = {"passed": 0, "failed": 0, "skipped": 0}
    for name, outcome, reason in cases:
        counts[outcome] += 1
        if outcome != "passed":
            print(f"{outcome}: {name}" + (f" ({reason})" if reason else ""))
    print(", ".join(f"{count} {outcome}" for outcome, count in counts.items()), flush=True)
    return 1 if code != 0 or counts["failed"] or not counts["passed"] else 0


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1], sys.argv[2:]))
