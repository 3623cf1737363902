#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""fuzz.py BUILD_DIR SECONDS [JOBS] [SEED] [TARGET...]: runs each target of tests/fuzz for SECONDS, JOBS at
once. SEED 0, the default, is another one each time; the same one tries the same inputs in the same order.

What libFuzzer adds to the inputs of tests/fuzz/corpus stays in BUILD_DIR/corpus for the next time, and
what breaks a target goes to BUILD_DIR/crashes. Prints a line a target: inputs a second, and coverage
(edges) of the kept inputs and at the end. Exits with 1 when something broke.
"""
import concurrent.futures
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

SEEDS = Path("tests/fuzz/corpus")
TIMEOUT_S = 25  # for one input
MEMORY_MB = 2048  # including the sanitizers' own


def options_for_sanitizers():
    here = Path.cwd()
    return {"LSAN_OPTIONS": f"suppressions={here}/scripts/lsan.supp:print_suppressions=0",
            "UBSAN_OPTIONS": "print_stacktrace=1:halt_on_error=1"}


def number(pattern, text, which=-1):
    found = re.findall(pattern, text)
    return int(found[which]) if found else 0


def run(program, build, target, seconds, seed, scratch):
    """(line to print, whether the target held)."""
    corpus, crashes, logs = (build / name for name in ("corpus", "crashes", "logs"))
    for folder in (corpus / target, crashes, logs):
        folder.mkdir(parents=True, exist_ok=True)
    done = subprocess.run(
        [program, target, f"-max_total_time={seconds}", f"-seed={seed}", f"-timeout={TIMEOUT_S}", f"-rss_limit_mb={MEMORY_MB}",
         "-print_final_stats=1", f"-artifact_prefix={crashes}/{target}-", corpus / target, SEEDS / target],
        capture_output=True, text=True, errors="replace", check=False,
        env={**os.environ, **options_for_sanitizers(), "TMPDIR": scratch})
    (logs / f"{target}.log").write_text(done.stderr)
    line = (f"{target:17} {number(r'exec/s: +([0-9]+)', done.stderr):7} inputs/s, coverage "
            f"{number(r'INITED +cov: ([0-9]+)', done.stderr)} -> {number(r'cov: ([0-9]+)', done.stderr)}, "
            f"{len(os.listdir(corpus / target))} inputs kept")
    if done.returncode == 0:
        return line, True
    artifacts = re.findall(r"Test unit written to (\S+)", done.stderr)
    said = re.findall(r"what\(\): .*|SUMMARY: .*|ERROR: .*|runtime error: .*", done.stderr)
    replay = f"{program} {target} {artifacts[-1]}" if artifacts else f"see {logs}/{target}.log"
    return f"{line}\n  broken: {'; '.join(said[:2])}\n  replay: {replay}", False


def main(build, seconds, jobs, seed, targets):
    program = build / "tests/fuzz/fuzz"
    targets = targets or sorted(folder.name for folder in SEEDS.iterdir())
    held = []
    shared_memory = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None
    with tempfile.TemporaryDirectory(prefix="waystone-fuzz-", dir=shared_memory) as scratch, \
            concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        runs = [pool.submit(run, program, build, target, seconds, seed, scratch) for target in targets]
        for each in runs:
            line, good = each.result()
            print(line, flush=True)
            held.append(good)
    print(f"{sum(held)} of {len(held)} targets held")
    return 0 if all(held) else 1


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    sys.exit(main(Path(sys.argv[1]), int(sys.argv[2]), int((sys.argv + [""])[3] or 1),
                  int(sys.argv[4]) if len(sys.argv) > 4 else 0, sys.argv[5:]))
