# SPDX-License-Identifier: MIT
"""Runs every suite with the label `threads` under ThreadSanitizer, two at a time, and prints a table: cases, reports and
seconds of each suite.

Arguments: --tests dermis-tests of the preset tsan, --work a folder for reports, --only SUITE.
Fails where a case fails, nothing ran, or there is a report but for those of a driver that tests/main.cpp names.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from suites import labelled

# A claim about memory, which does not hold for this build, and grids of whose memory the sanitizer would need several
# times as much.
EXCLUDED = ("--test-case-exclude=a march of a material in each cell under a sine takes at most*,"
            "a response of more than 128 MiB*,millions of receptors*")
# Address-space randomisation may leave no room for the sanitizer's shadow.
FIXED_ADDRESSES = ["setarch", "-R"]


def run_suite(options, name):
    """Runs a suite. Returns its row of the table, and whether it is right."""
    reports = options.work / name
    shutil.rmtree(reports, ignore_errors=True)
    reports.mkdir(parents=True)
    # Thousands of devices, each with its driver's threads, would take 20 GB of what the sanitizer keeps.
    variables = {**os.environ, "TSAN_OPTIONS": f"log_path={reports}/report history_size=4 memory_limit_mb=6000"}
    start = time.monotonic()
    done = subprocess.run([*FIXED_ADDRESSES, options.tests, f"--source-file=*/{name}_test.cpp", "--no-skip", EXCLUDED],
                          env=variables, capture_output=True, text=True)
    seconds = time.monotonic() - start
    found = re.search(r"test cases: +(\d+) \| +(\d+) passed", done.stdout)
    passed, cases = (int(found[2]), int(found[1])) if found else (0, 0)
    written = [path.read_text() for path in sorted(reports.iterdir())]
    count = sum(text.count("WARNING: ThreadSanitizer") for text in written)
    row = f"{name:<14}{passed:>5}/{cases:<5}{count:>8}{seconds:>9.0f}"
    right = cases > 0 and passed == cases and count == 0
    if not right:
        row += "\n" + (done.stdout + done.stderr)[-6000:] + "\n".join(written)[:12000]
    return row, count, right


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--tests", type=Path, required=True)
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--only")
    options = parser.parse_args()
    options.work = options.work.resolve()
    told = subprocess.run([*FIXED_ADDRESSES, options.tests, "--version"], env={**os.environ, "TSAN_OPTIONS": "help=1"},
                          capture_output=True, text=True)
    if "ThreadSanitizer" not in told.stdout + told.stderr:
        sys.exit(f"threads: {options.tests} has no ThreadSanitizer in it: {told.stderr}")
    suites = [options.only] if options.only else labelled(options.tests.parents[1], "threads")
    print(f"{'suite':<14}{'cases':>8}{'reports':>11}{'seconds':>9}", flush=True)
    right, reports, start = True, 0, time.monotonic()
    with ThreadPoolExecutor(2) as pool:
        for row, count, passed in pool.map(lambda name: run_suite(options, name), suites):
            right, reports = right and passed, reports + count
            print(row, flush=True)
    print(f"threads: {len(suites)} suites, {reports} reports, {time.monotonic() - start:.0f} s")
    sys.exit(not right)


if __name__ == "__main__":
    main()
