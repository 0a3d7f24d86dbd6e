# SPDX-License-Identifier: MIT
"""Whether the suites notice a wrong instruction: mutants.py TESTS OUT [COUNT] [SEED]

Copies the program TESTS, which has the whole library in it, changes one byte of one instruction, and runs suites until one
fails: a sum becomes a difference, a product a sum, a quotient a product, a minimum a maximum, a branch its opposite; in a
shader alike. gdb tells first which suites execute the instruction: only they can notice, the short ones first. A mutant
that no suite notices has survived: it is equivalent (its results are the same for every input), or a test is missing.
OUT is a table of mutants, one a line; those that it has for this program are not run again.
"""

import csv
import hashlib
import os
import random
import re
import resource
import shutil
import struct
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

# Functions by their names.
GROUPS = {
    "coefficients": r"dermis::model::.*(coefficients|Divided|Phi<|Forcing|Segment|SineGains|Totals|elements_of|forcing_of)",
    "half-space": r"HalfSpace|stresses_of|error_of_stresses|spread_of|strain_below_punch",
    "pyramid": r"Spreading<|DeepCells|Felt::|halve|raise_|spread_",
    "fibres": r"FibrePopulation|cpu::Fibres|fibre_substeps|Spiking|fire",
    "contacts": r"dermis::contact::",
    "loops": r"dermis::(simd|cpu)::",
    "schedule": r"dermis::(model|planner|reduced)::(Timeline|CountedRun|Moments|References|Stepper|SiteStepper|bounds_of)",
    "recorder": r"dermis::vulkan::",
}
SWAPS = {0x58: 0x5C, 0x5C: 0x58, 0x59: 0x58, 0x5E: 0x59, 0x5D: 0x5F, 0x5F: 0x5D}  # add sub mul div min max of SSE and AVX
FLOATING = re.compile(r"v?(add|sub|mul|div|min|max)[sp][sd]$")
X87 = {b"\xde\xc1": 0xC9, b"\xde\xc9": 0xC1, b"\xde\xe9": 0xC1, b"\xde\xf9": 0xC9}
SHADER = {129: 131, 131: 129, 133: 129, 136: 133}  # OpFAdd, OpFSub, OpFMul, OpFDiv
LIMIT = 300  # s of a processor, after which a suite counts as failed; or ten times as long
COSTS = Path("build/release/Testing/Temporary/CTestCostData.txt")


def opcode_at(code):
    """Where the opcode is in an instruction of floats, or None."""
    if code[0] in (0x62, 0xC4, 0xC5):
        return {0x62: 4, 0xC4: 3, 0xC5: 2}[code[0]]
    i = 0
    while code[i] in (0x66, 0xF2, 0xF3) or 0x40 <= code[i] <= 0x4F:
        i += 1
    return i + 1 if code[i] == 0x0F else None


def change_of(code, name, branches):
    """(which byte of an instruction changes, to what), or None."""
    if FLOATING.match(name):
        at = opcode_at(code)
        return (at, SWAPS[code[at]]) if at is not None and code[at] in SWAPS else None
    if code in X87:
        return 1, X87[code]
    if branches or name in ("ja", "jbe"):
        if len(code) == 2 and 0x70 <= code[0] <= 0x7F:
            return 0, code[0] ^ 1
        if len(code) == 6 and code[0] == 0x0F and 0x80 <= code[1] <= 0x8F:
            return 1, code[1] ^ 1
    return None


def is_ours(function):
    """Whether a demangled function is the library's: by its name, because std's and the tests' have our types as arguments."""
    if not function.startswith("std::_Function_handler<"):  # the body of a lambda
        function = function.replace("(anonymous namespace)::", "")
        while function != (shorter := re.sub(r"<[^<>]*>", "", function)):
            function = shorter
        function = function.split("(")[0].split()[-1]
    return "dermis::" in function and "DOCTEST" not in function and "test::" not in function


def places_of_code(program):
    """Lists (group, offset in the file, old byte, new byte, instruction, function, address) of the program's code."""
    sections = subprocess.run(["readelf", "-SW", program], capture_output=True, text=True, check=True).stdout
    text = re.search(r"\.text\s+PROGBITS\s+([0-9a-f]+)\s+([0-9a-f]+)", sections)
    shift = int(text[1], 16) - int(text[2], 16)
    lines = subprocess.Popen(["objdump", "-dC", "-j", ".text", "--insn-width=16", program], stdout=subprocess.PIPE, text=True).stdout
    places, group, function = [], None, ""
    for line in lines:
        if line.endswith(">:\n"):
            function = line.split(" <", 1)[1][:-3]
            group = next((g for g, names in GROUPS.items() if is_ours(function) and re.search(names, function)), None)
        elif group and (found := re.match(r" *([0-9a-f]+):\t((?:[0-9a-f]{2} )+) *\t(\S+)", line)):
            code = bytes.fromhex(found[2])
            change = change_of(code, found[3], group == "recorder")
            if change:
                address = int(found[1], 16)
                places.append((group, address - shift + change[0], code[change[0]], change[1], found[3], function, address))
    return places


def places_of_shaders(program):
    """The same of the shaders that the program holds; the function is the shader's number, and the address None."""
    data, places, shaders = Path(program).read_bytes(), [], 0
    for start in re.finditer(re.escape(struct.pack("<I", 0x07230203)), data):
        word, at = lambda i: struct.unpack_from("<I", data, i)[0], start.start() + 20
        if start.start() % 4 or word(start.start() + 4) >> 16 != 1:
            continue
        shaders += 1
        while word(at) >> 16:
            code, length = word(at) & 0xFFFF, word(at) >> 16
            if code in SHADER:
                places.append(("shaders", at, code, SHADER[code], f"OpF {code}", f"shader {shaders}", None))
            at += 4 * length
            if code == 56 and word(at) & 0xFFFF != 54:  # the end of the last function
                break
    return places


def fails(program, suite):
    command = [program, f"--source-file=*/{suite}_test.cpp", "--no-skip", "--abort-after=1"]
    try:
        return subprocess.run(command, capture_output=True, timeout=10 * LIMIT,
                              preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (LIMIT, LIMIT))).returncode != 0
    except subprocess.TimeoutExpired:
        return True


def fails_under_shims(program, mutant):
    """Whether the suite `shims` notices: its devices run the shaders that a software driver does not take."""
    command = [sys.executable, Path(__file__).resolve().parents[1] / "shims/shims.py", "--tests", mutant,
               "--command", program.parents[1] / "dermis", "--layers", program.parent / "shims"]
    return subprocess.run(command, capture_output=True).returncode != 0


def usual_time(suite):
    """The seconds that ctest has measured of a suite, so that short ones come first; 0 before the first test."""
    return next((float(line.split()[2]) for line in COSTS.read_text().splitlines() if line.startswith(suite + " ")), 0) \
        if COSTS.exists() else 0


def suites():
    """The suites of the program, the short ones first. `shims` is a program that runs others, `threads` needs a sanitizer."""
    names = {path.name.removesuffix("_test.cpp") for path in Path(__file__).resolve().parents[1].glob("*/*_test.cpp")}
    return sorted(names - {"shims", "threads"}, key=lambda name: (usual_time(name), name))


def reached(program, suite, addresses, folder):
    """Which of the addresses a suite executes: a set, from gdb, or from the folder where it was asked before."""
    out = folder / suite
    if not out.exists():
        command = ["gdb", "-nx", "-batch", "-x", Path(__file__).with_name("reached.py"), "--args", program,
                   f"--source-file=*/{suite}_test.cpp", "--no-skip"]
        said = subprocess.run(command, capture_output=True, text=True, errors="replace",
                              env={**os.environ, "REACHED": " ".join(map(str, [out, *addresses]))})
        if not out.exists():
            sys.exit(f"mutants: {suite}: {said.stdout[-1000:]}{said.stderr[-1000:]}")
    return {int(line) for line in out.read_text().split()}


def main():
    program, table = Path(sys.argv[1]).resolve(), Path(sys.argv[2])
    count, seed = (int(text) for text in [*sys.argv[3:], *["100", "1"][len(sys.argv) - 3:]])
    version = hashlib.sha256(program.read_bytes()).hexdigest()[:12]
    places = places_of_code(program) + places_of_shaders(program)
    draw, groups = random.Random(seed), [*GROUPS, "shaders"]
    by_group = {g: [p for p in places if p[0] == g] for g in groups}
    for g in groups:
        print(f"{g}: {len(by_group[g])} places", flush=True)
    drawn = [draw.choice(by_group[groups[i % len(groups)]]) for i in range(count)]
    addresses = sorted({place[-1] for place in drawn if place[-1] is not None})
    folder = table.parent / f"reached-{version}-{hashlib.sha256(repr(addresses).encode()).hexdigest()[:12]}"
    folder.mkdir(parents=True, exist_ok=True)
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        executed = dict(zip(suites(), pool.map(lambda suite: reached(program, suite, addresses, folder), suites())))
    done = {}
    if table.exists():
        with table.open(newline="") as rows:
            done = {(r["program"], int(r["offset"])): r["failing"] for r in csv.DictReader(rows)}

    def failing_of(number):
        _, offset, old, new, _, _, address = drawn[number]
        if (version, offset) in done:
            return done[version, offset]
        mutant = table.parent / f"mutant-{os.getpid()}-{number}"
        try:
            shutil.copy(program, mutant)
            with mutant.open("r+b") as file:
                file.seek(offset)
                if file.read(1)[0] != old:
                    sys.exit(f"mutants: offset {offset} does not hold {old:#x}")
                file.seek(offset)
                file.write(bytes([new]))
            for suite in executed:
                if address in executed[suite] | {None} and fails(mutant, suite):
                    return suite
            return "shims" if address is None and fails_under_shims(program, mutant) else ""
        finally:
            mutant.unlink(missing_ok=True)

    survivors = []
    with table.open("a", newline="") as out, ThreadPoolExecutor(os.cpu_count()) as pool:
        write = csv.writer(out)
        if out.tell() == 0:
            write.writerow(["program", "offset", "group", "instruction", "new_byte", "failing", "function"])
        for number, failing in enumerate(pool.map(failing_of, range(count))):
            group, offset, _, new, instruction, function, address = drawn[number]
            if (version, offset) not in done:
                write.writerow([version, offset, group, instruction, hex(new), failing, function])
                out.flush()
            never = address is not None and not any(address in of for of in executed.values())
            outcome = failing or ("NEVER RUN" if never else "SURVIVES")
            print(f"{number + 1}/{count} {group:<13}{outcome:<14}{instruction:<10}{function[:90]}", flush=True)
            if not failing:
                survivors.append((outcome, group, hex(offset), instruction, function))
    print(f"{len(survivors)} of {count} survive")
    for survivor in survivors:
        print("  ", *survivor)


if __name__ == "__main__":
    main()
