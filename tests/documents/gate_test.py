# SPDX-License-Identifier: MIT
"""The benchmark's gate compares what it says, and refuses what it cannot compare: gate_test.py SOURCE WORK"""
import csv
import sys
from pathlib import Path

source, work = Path(sys.argv[1]), Path(sys.argv[2])
sys.path.insert(0, str(source / "bench"))
import gate  # noqa: E402

text = (source / "bench/rows.cpp").read_text().split("header =")[1].split(";")[0]
COLUMNS = "".join(part for part in text.split('"')[1::2]).split(",")  # those that the program writes
ALL = {"avx2", "avx512f", "avx512dq", "avx512vl"}


def check(holds, what):
    if not holds:
        sys.exit(f"gate: {what}")


def row(**more):
    here = {"schema": "3", "size": "quick", "cpu": "Brand; model 3", "cores": "2", "compiler": "GCC 12", "device": "cpu", "exact": "true",
            "backend": "cpu-plain", "threads": "1", "workload": "press", "width": "512", "status": "ok"}
    return {**dict.fromkeys(COLUMNS, ""), **here, **more}


def table(**more):
    """A press with a ratio by two instruction sets, a run on a device, and the study; all rows changed by `more`."""
    press = {"ratio_to": "moves", "ratio": "1.2"}
    rows = [press, {"backend": "vulkan", "device": "llvmpipe", "driver": "llvmpipe", "driver_version": "Mesa 22", "workload": "accuracy",
                    "err_curvature": str(1 / 3)}, {**press, "backend": "cpu-avx512"},
            {"backend": "cpu-avx512", "workload": "study", "err_strain": "0.25"}]
    return [row(**r, **more) for r in rows]


def changed(place, **more):
    after = table()
    after[place] |= more
    return after


def lost(after, **options):
    return "\n".join(gate.compare(table(), after, **{"flags": ALL, **options})[0])


def incomparable(call, *arguments, **options):
    try:
        call(*arguments, **options)
    except gate.Incomparable as e:
        return str(e)
    return "compared"


check(gate.compare(table(), table(), flags=ALL) == ([], [], 4, 0), "a table has lost nothing against itself")
check("vulkan 1 accuracy 512" in lost(table()[:1] + table()[2:]), "a row that is missing is told")
check("err_curvature was 0.333" in lost(changed(1, err_curvature=str(1 / 3 + 2**-54))), "an error's last bit is told")
check(lost(changed(1, exact="false", err_curvature="1")).endswith("exact was true, is false"), "exactness alone is told where it is lost")
check("status was ok, is wrong" in lost(changed(0, status="wrong")), "a status is told")

slow, fast = changed(0, ratio=str(1.2 * gate.SLACK * 1.001)), changed(0, ratio=str(1.2 * gate.SLACK * 0.999))
check(not lost(slow) and "time over that of moves was 1.2" in lost(slow, speed=True), "a speed is compared where that is asked for")
check(not lost(fast, speed=True) and gate.compare(table(), fast, speed=True, flags=ALL)[3] == 2, "within the slack a speed is not lost")
other = table(compiler="Clang 15")
check(not lost(other), "other compilers have the same bits")
check("no speed in common; not compared: speeds: the compiler was GCC 12, is Clang 15" in incomparable(
    gate.compare, table(), other, speed=True), "speeds of two compilers are not compared")

for more in ({"cpu": "Other"}, {"cores": "4"}, {"size": "full"}):
    check(incomparable(gate.compare, table(), [r | more for r in table()]).startswith(
        "no row in common: the earlier table is of Brand; model 3 with 2 cores, quick; the other is of "), f"{more} is another machine")
check(gate.compare(table(), changed(1, driver_version="Mesa 23", err_strain="1"), flags=ALL)[:2] == (
    [], ["not compared: another device or driver: llvmpipe llvmpipe Mesa 22 (1 rows)"]), "drivers are not joined")

narrow = changed(3, backend="cpu-avx2")  # the same bits by other instructions
narrow[2] = narrow[0]
check("cpu-avx512 1 press 512" in lost(narrow), "a row that the program has lost fails")
check(gate.compare(table(), narrow, flags={"avx2"}) == ([], ["not compared: this processor has no avx512 (1 rows)"], 3, 0),
      "one that this processor cannot have is said")
check(gate.compare(table(), table()[:1] + table()[2:], devices=False, flags=ALL)[:2] == (
    [], ["not compared: Vulkan was not asked for (1 rows)"]), "one of a device that was not asked for is said")
check(not gate.compare([*table(), row(backend="numpy")], table(), flags=ALL)[0], "peers are not compared")

work.mkdir(parents=True, exist_ok=True)
path, now = work / "old.csv", table()


def refused(lines):
    path.write_text(lines)
    return incomparable(gate.read, path, now)


with open(path, "w", newline="") as file:
    writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(table())
own = path.read_text()
check(gate.read(path, now) == now, "a table is read as it was written")
check(gate.main(str(path), str(path)) == 0 and gate.main(str(work / "none.csv"), str(path)) == 2, "the exit status says what was found")
for misuse in (str(path), str(path), "--sped"), (), (str(path),):
    try:
        gate.main(*misuse)
    except SystemExit as e:
        check(e.code == 2, f"misuse ends with {e.code}")
    else:
        check(False, f"{misuse} is taken")
check(refused("\n") == f"{path} is no table of dermis-bench", "a blank first line is refused")
check(refused(own.replace("moves,1.2", "moves,fast", 1)) == f"{path}, line 2: ratio = fast; allowed: a number >= 0, or nothing",
      "a ratio that is no number is refused")
check(refused("") == f"{path} is no table of dermis-bench" == refused("time,strain\n0,1\n"), "a foreign table is refused")
check(refused(own.split("\n")[0] + "\n") == f"{path} has no rows", "a table without rows is refused")
check(refused("schema,commit\n1,a\n") == f"{path}, line 2: schema = 1; allowed: 3", "a table of an older schema is refused")
check(refused("schema,commit\n3,a\n") == f"{path} has other columns than schema 3", "a table with other columns is refused")
check(refused(own[:-9]).startswith(f"{path}, line 5 has "), "a table that is cut off is refused")
