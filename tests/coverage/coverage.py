# SPDX-License-Identifier: MIT
"""Runs the test suites of a build with --coverage, and prints what of host/ they reached: lines and branches of each room, and
every error branch that was compiled and never taken.

Arguments: --build the build's folder, --keep to count what ran before.
Branches are those of conditions as gcov counts them; the exceptional way out of each call is none of them. Error branches
are statements that throw, calls of functions that only throw, checks (need.., check..) that never failed, and handlers;
which of them were taken is told by the stacks of all exceptions that were thrown (throws.cpp).
"""

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import time
from collections import defaultdict
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from sites import never_return, sites_of

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from suites import labelled

ROOT = Path(__file__).resolve().parents[2]
# Suites that mostly compute, for minutes without optimisation.
COMPUTING = ("backends", "bounds", "closed_form", "fibres", "intervals", "loops", "planner", "search", "stability")
# Cases that compute as long; a claim about memory, which does not hold for a build with counters; and allocations that
# fail where throws.cpp itself allocates.
LEFT_OUT = ("millions of receptors*", "a march of a material in each cell under a sine takes at most*",
            "an allocation that fails in the command*")

WAYS = "1:60"  # the first 60 of the 300 lists of calls that a day draws


def jobs_of(build):
    """The programs to run: the suites, the long ones first, and what C does wrong."""
    tests = build / "tests"
    names = {path.name.removesuffix("_test.cpp") for path in (ROOT / "tests").glob("*/*_test.cpp")} - {*COMPUTING, "shims"}
    long = labelled(build, "long")
    for name in sorted(names, key=lambda name: (name not in long, name)):
        yield [tests / "dermis-tests", f"--source-file=*/{name}_test.cpp", "--no-skip",
               f"--test-case-exclude={','.join(LEFT_OUT)}"]
    yield [tests / "doors/c/c_interface_static"]
    yield [tests / "doors/c/c_contacts_static"]


def run_job(job, variables):
    """Runs a program. Returns whether it was right."""
    start = time.monotonic()
    done = subprocess.run(job, env=variables, capture_output=True, text=True, errors="replace")
    right = done.returncode == 0 and not re.search(r"test cases: +0 ", done.stdout)
    print(f"{' '.join([job[0].name, *job[1:2]]):<50}{time.monotonic() - start:>5.0f} s{'' if right else '  FAILED'}", flush=True)
    if not right:
        print((done.stdout + done.stderr)[-4000:], flush=True)
    return right


def run_suites(build, throws):
    """Runs suites with every exception written down. Returns whether all passed."""
    for counts in build.rglob("*.gcda"):
        counts.unlink()
    shutil.rmtree(throws, ignore_errors=True)
    throws.mkdir()
    preloaded = build / "throws.so"
    subprocess.run(["c++", "-std=c++20", "-O1", "-shared", "-fPIC", Path(__file__).parent / "throws.cpp", "-o", preloaded],
                   check=True)
    # Every file of counts has its full length before a test forbids files to grow.
    for program in (build / "dermis", build / "tests/dermis-tests"):
        subprocess.run([program, "--version"], check=True, capture_output=True)
    variables = {**os.environ, "LD_PRELOAD": str(preloaded), "DERMIS_THROWS": str(throws), "DERMIS_WAYS": WAYS}
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return all(list(pool.map(lambda job: run_job(job, variables), jobs_of(build))))


def counted(build):
    """What gcov says: {path: {line: count}} and {path: {(line, function, number, of so many): count}} of conditions."""
    lines, branches = defaultdict(lambda: defaultdict(int)), defaultdict(lambda: defaultdict(int))
    counts = sorted(build.rglob("*.gcda"))
    batches = [counts[i::os.cpu_count()] for i in range(os.cpu_count())]

    def gcov(batch):
        return subprocess.run(["gcov", "--json-format", "--branch-probabilities", "--stdout", *batch], cwd=build,
                              capture_output=True, text=True, check=True).stdout

    with ThreadPoolExecutor() as pool:
        reports = [json.loads(report) for text in pool.map(gcov, batches) for report in text.splitlines() if report]
    for report in reports:
        for file in report["files"]:
            path = os.path.relpath(os.path.join(report["current_working_directory"], file["file"]), ROOT)
            if path.startswith("host/"):
                add(file["lines"], lines[path], branches[path])
    # Loops over registers are inlined in hundreds of copies, whose conditions are those of templates.
    for path in [path for path in branches if path.endswith(".inl")]:
        del branches[path]
    return lines, branches


def add(records, lines, branches):
    for record in records:
        number = record["line_number"]
        lines[number] += record["count"]
        ways = conditions(record["branches"])
        for i, count in enumerate(ways):
            branches[number, i, len(ways)] += count


def conditions(ways):
    """The counts of branches without the two ways out of each call: by an exception, and as usual."""
    kept = []
    for way in ways:
        if not way["throw"]:
            kept.append(way)
        elif kept:
            kept.pop()
    return [way["count"] for way in kept]


def stacks(build, throws):
    """Every stack of an exception: its type, and (function, path, line) of its calls, the innermost first."""
    found = []
    logs = defaultdict(set)  # of all processes of a program
    for log in throws.iterdir():
        # The last line may have been cut short.
        logs[log.name.rpartition(".")[0]] |= set(log.read_text().rpartition("\n")[0].splitlines())
    for name in sorted(logs):
        program = next(path for path in build.rglob(name) if path.is_file())
        offsets = [line.split() for line in sorted(logs[name])]
        addresses = sorted({a for _, *stack in offsets for a in stack})
        text = subprocess.run(["addr2line", "-e", program, "-f", "-C"], input="\n".join(addresses), capture_output=True,
                              text=True, check=True).stdout.splitlines()
        places = {}
        for address, function, place in zip(addresses, text[::2], text[1::2]):
            path, _, line = place.split(" ")[0].rpartition(":")
            # A place that is not known has no path.
            places[address] = function, os.path.relpath(path or "?", ROOT), int(line) if line.isdigit() else 0
        found += [(kind, [places[a] for a in stack]) for kind, *stack in offsets]
    return found


def taken(site, lines, thrown, called):
    span = range(site.first, site.last + 1)
    if site.kind == "catch":
        return any(lines.get(n, 0) for n in range(site.first + (site.last > site.first), site.last + 1))
    if site.kind == "throw":
        return any((site.path, n) in thrown for n in span)
    # A lambda, or a function of a longer name, may go by the name of a check.
    return any(name.startswith((site.name, "{lambda")) for n in span for name in called[site.path, n])


def name_of(function):
    """The name of a demangled function without its scope, template and parameters."""
    if "{lambda" in function.rsplit("::", 1)[0].rsplit("(", 1)[-1] or "::{lambda" in function:
        return "{lambda"
    return function.split("(anonymous namespace)::")[-1].split("(")[0].split("<")[0].split("::")[-1].split(" ")[-1]


def error_branches(lines, found):
    """The error branches of what was compiled, and those of them that were never taken."""
    texts = {path: (ROOT / path).read_text() for path in lines}
    of_headers = set().union(*(never_return(text) for path, text in texts.items() if path.endswith(".hpp")))
    thrown, called = set(), defaultdict(set)
    for kind, stack in found:
        path, line = stack[0][1:]
        # An allocation that fails within a statement is none of its branches.
        if kind == "St9bad_alloc":
            if "bad_alloc" in "".join(texts.get(path, "").splitlines()[line - 1:line]):
                thrown.add((path, line))
            continue
        thrown.add((path, line))
        for (function, _, _), (_, path, line) in zip(stack, stack[1:]):
            called[path, line].add(name_of(function))
    every, missed = [], []
    for path in sorted(texts):
        for site in sites_of(path, texts[path], of_headers | never_return(texts[path])):
            if any(n in lines[path] for n in range(site.first, site.last + 1)):
                every.append(site)
                if not taken(site, lines[path], thrown, called):
                    missed.append((site, texts[path].splitlines()[site.first - 1].strip()))
    return every, missed


def share(some, every):
    return f"{some:>6} of {every:>6} ({100 * some / every if every else 100:5.1f} %)"


def report(lines, branches, every, missed):
    rooms = defaultdict(lambda: [0, 0, 0, 0])
    for path in lines:
        room = rooms["/".join(Path(path).relative_to("host").parts[:2])]
        total = [sum(c > 0 for c in lines[path].values()), len(lines[path]), sum(c > 0 for c in branches[path].values()),
                 len(branches[path])]
        room[:] = [a + b for a, b in zip(room, total)]
    print(f"\n{'room':<18}{'lines':>24}{'branches':>27}")
    for name in sorted(rooms):
        print(f"{name:<18}{share(*rooms[name][:2])}   {share(*rooms[name][2:])}")
    print(f"\nerror branches not reached, of {len(every)} (throw, refuse, need, check, catch):")
    for site, text in missed:
        print(f"    {site.path}:{site.first}: {text}")
    some, all_ = sum(r[2] for r in rooms.values()), sum(r[3] for r in rooms.values())
    print(f"branches of host/: {some} of {all_} ({100 * some / all_:.1f} %); error branches not reached: {len(missed)}")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--build", type=Path, required=True)
    parser.add_argument("--keep", action="store_true")
    options = parser.parse_args()
    build = options.build.resolve()
    throws = build / "throws"
    start = time.monotonic()
    passed = options.keep or run_suites(build, throws)
    print(f"coverage: suites took {time.monotonic() - start:.0f} s", flush=True)
    lines, branches = counted(build)
    report(lines, branches, *error_branches(lines, stacks(build, throws)))
    print(f"coverage: {time.monotonic() - start:.0f} s in all")
    sys.exit(not passed)


if __name__ == "__main__":
    main()
