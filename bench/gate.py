# SPDX-License-Identifier: MIT
"""The gate: compares a table of dermis-bench with an earlier one of the same machine: gate.py earlier.csv now.csv [--speed] [--cpu]

Joins rows of the same machine (CPU, cores, device, driver) and the same size. Errors of exact devices must be equal to the
last bit, exactness and status must be equal, and no row may be lost. --speed: no ratio may be more than SLACK times the
earlier one where the compiler is the same. --cpu: devices were not measured now. Exit status 1 where something is lost, 2
where the tables have no row, or none of the speeds asked for, in common, or cannot be read.
"""
import argparse
import collections
import csv
import re
import sys
from pathlib import Path

SLACK = 1.5  # on a machine that also served five others, ratios of the unchanged program were within 1.4 of each other
NAME = ("threads", "workload", "width", "height", "steps", "receptors", "model", "method", "precision", "stencil", "dt_over_tau")
EQUAL = ("err_strain", "err_sa1", "err_sa2", "err_fa1", "err_fa2", "err_curvature")
FLAGS = {"cpu-avx2": {"avx2"}, "cpu-avx512": {"avx512f", "avx512dq", "avx512vl"}}  # of a processor with these instructions


class Incomparable(Exception):
    """A table that dermis-bench did not write, or that has nothing in common with the other. The message says why."""


def read(path, like=None):
    """The rows of a table. like: those of another, whose schema it must have."""
    try:
        lines = list(csv.reader(Path(path).read_text().splitlines()))
    except (OSError, UnicodeDecodeError):
        raise Incomparable(f"{path} cannot be read") from None
    if not lines or lines[0][:1] != ["schema"]:
        raise Incomparable(f"{path} is no table of dermis-bench")
    rows = []
    for number, cells in enumerate(lines[1:], 2):
        if like and cells[0] != like[0]["schema"]:
            raise Incomparable(f"{path}, line {number}: schema = {cells[0]}; allowed: {like[0]['schema']}")
        if like and lines[0] != list(like[0]):
            raise Incomparable(f"{path} has other columns than schema {cells[0]}")
        if len(cells) != len(lines[0]):
            raise Incomparable(f"{path}, line {number} has {len(cells)} cells; allowed: {len(lines[0])}")
        rows.append(dict(zip(lines[0], cells)))
        missing = {"ratio", "ratio_to", "exact", "status", "compiler", "backend", *NAME, *EQUAL} - set(rows[-1])
        if missing:
            raise Incomparable(f"{path} has no column {min(missing)}")
        if not re.fullmatch(r"([0-9.]+(e[+-]?[0-9]+)?)?", rows[-1]["ratio"]):
            raise Incomparable(f"{path}, line {number}: ratio = {rows[-1]['ratio']}; allowed: a number >= 0, or nothing")
    if not rows:
        raise Incomparable(f"{path} has no rows")
    return rows


def of(row, *names):
    return " ".join(row[name] for name in names)


def driver(row):
    return of(row, "device", "driver", "driver_version")


def machine(row):
    return f"{row['cpu']} with {row['cores']} cores, {row['size']}"


def on_device(row):
    return row["backend"].startswith("vulkan")


def name(row):
    """Every instruction set computes the same bits: where they are no contenders, a row's backend says which one was the best."""
    best = row["backend"].startswith("cpu-") and row["workload"] not in ("press", "press-fa1")
    return f"{'cpu' if best else row['backend']} {of(row, *NAME)}"


def processor():
    """The flags of this processor."""
    try:
        return set(next((line for line in open("/proc/cpuinfo") if line.startswith("flags")), "").split())
    except OSError:
        return set()


def why_missing(row, now, devices, flags):
    """Why there cannot be a row; empty if it is lost."""
    if machine(row) not in {machine(r) for r in now}:
        return f"only the earlier table has {machine(row)}"
    if on_device(row) and not devices:
        return "Vulkan was not asked for"
    if on_device(row) and any(map(on_device, now)) and driver(row) not in map(driver, now):
        return f"another device or driver: {driver(row)}"
    return f"this processor has no {row['backend'][4:]}" if FLAGS.get(row["backend"], set()) - flags else ""


def compare(earlier, now, speed=False, devices=True, flags=None):
    """What is lost, what is not compared, and how many rows and speeds are compared."""
    partners = {(machine(r), driver(r), name(r)): r for r in now}
    lost, said, rows, speeds = [], collections.Counter(), 0, 0
    for before in earlier:
        if not on_device(before) and not before["backend"].startswith("cpu-"):
            continue  # a peer's
        row = partners.get((machine(before), driver(before), name(before)))
        if not row:
            why = why_missing(before, now, devices, processor() if flags is None else flags)
            said[why] += 1
            lost += [] if why else [f"{name(before)}: the row is lost"]
            continue
        rows += 1
        exact = before["exact"] == row["exact"] == "true"
        lost += [f"{name(before)}: {column} was {before[column]}, is {row[column]}"
                 for column in (*EQUAL[: 6 * exact], "exact", "status") if before[column] != row[column]]
        if speed and before["ratio"] and row["ratio"] and before["ratio_to"] == row["ratio_to"]:
            if before["compiler"] != row["compiler"]:
                said[f"speeds: the compiler was {before['compiler']}, is {row['compiler']}"] += 1
                continue
            speeds += 1
            most = float(before["ratio"]) * SLACK
            if not float(row["ratio"]) <= most:
                lost.append(f"{name(before)}: time over that of {row['ratio_to']} was {before['ratio']}, is {row['ratio']}; "
                            f"allowed: {most:.3g}")
    said = [f"not compared: {why} ({count} rows)" for why, count in said.items() if why]
    if not rows:
        raise Incomparable(f"no row in common: the earlier table is of {machine(earlier[0])}; the other is of {machine(now[0])}")
    if speed and not speeds:
        raise Incomparable("; ".join(["no speed in common", *said]))
    return lost, said, rows, speeds


def main(*arguments):
    parser = argparse.ArgumentParser(description="what of an earlier table is lost", allow_abbrev=False)
    parser.add_argument("earlier")
    parser.add_argument("now")
    parser.add_argument("--speed", action="store_true", help="compare ratios of times too")
    parser.add_argument("--cpu", action="store_true", help="devices were not measured now")
    asked = parser.parse_args(arguments)
    try:
        table = read(asked.now)
        lost, said, rows, speeds = compare(read(asked.earlier, table), table, asked.speed, not asked.cpu)
    except Incomparable as e:
        print(f"gate: {e}", file=sys.stderr)
        return 2
    print(*said, *(f"LOST {line}" for line in lost),
          f"{rows} rows and {speeds} speeds compared with {asked.earlier}: {len(lost)} lost", sep="\n")
    return 1 if lost else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
