# SPDX-License-Identifier: MIT
"""Runs the program dermis-hashes in many circumstances and prints a table: a row for each, and whether every hash is that
of the program as it is. Fails unless all are. --all adds the circumstances that take minutes, other compilers most of all.

What is in double and needs exponentials and sines has the bits of the C library's functions, which differ between
processors: the rows of another library count those results, and hold all others to the same bits."""

import argparse
import os
import shlex
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

NO_CACHE = {"MESA_SHADER_CACHE_DISABLE": "true"}  # Mesa's cache does not know the width of vectors
NO_FUSED = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F"}
MODES = ("up", "down", "zero", "flush")

# (name, arguments, variables)
ON_CPU = [(f"{n} threads", f"threads={n}", {}) for n in (1, 2, 3, 7)]
ON_CPU += [(f"caller's floats: {mode}, {when}", f"{when}={mode}", {}) for mode in MODES for when in ("early", "late")]
REPEATS = 20
# glibc has exponentials and sines of its own for processors without fused products, whose last bits are others.
OTHER_LIBRARY = [("another C library's functions: without FMA", "", NO_FUSED)]
# Processors without AVX, and with AVX2: (name, before the program, whether it has another library's functions).
PROCESSORS = [("a Nehalem, emulated", "qemu-x86_64 -cpu Nehalem", True),
              ("a Haswell, emulated", "qemu-x86_64 -cpu Haswell", False)]

ON_VULKAN = [("the driver as it is", "", {})]
ON_VULKAN += [(f"LP_NUM_THREADS={n}", "", {"LP_NUM_THREADS": str(n)}) for n in (0, 1, 2, 7)]
ON_VULKAN += [(f"vectors of {n} bits", "", {"LP_NATIVE_VECTOR_WIDTH": str(n), **NO_CACHE}) for n in (128, 256, 512)]
ON_VULKAN += [(f"caller's floats: {mode}, {when}", f"{when}={mode}", {}) for mode in MODES for when in ("early", "late")]
ON_VULKAN += [(f"layer: {shim}", "", {"DERMIS_SHIM": shim}) for shim in
              ("groups=8", "groups=32", "groups=128", "narrow=245760", "narrow=400000", "metal", "least")]
QUICK_ON_VULKAN = ("LP_NUM_THREADS=7", "vectors of 128 bits", "caller's floats: flush, late")

# (name, compiler, options, before the program)
CROSS = "aarch64-linux-gnu-g++"
BUILDS = [(f"g++ {options}", "g++", options, "") for options in
          ("-O0", "-O1", "-O2 -march=native", "-O3 -march=native", "-O3 -ffast-math")]
BUILDS += [(f"clang++ {options}", "clang++", options, "") for options in ("-O0", "-O2", "-O3 -march=native")]
BUILDS += [("aarch64 -O2", CROSS, "-O2", "qemu-aarch64"), ("aarch64 -O0", CROSS, "-O0", "qemu-aarch64")]


def hashes(command, variables=None):
    done = subprocess.run(command, env={**os.environ, **(variables or {})}, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{shlex.join(map(str, command))} ended with {done.returncode}:\n{done.stdout}{done.stderr}")
    return dict(line.split() for line in done.stdout.splitlines())


def common(all_hashes):
    """What several runs have in common."""
    return {key: value if all(found[key] == value for found in all_hashes) else "varies"
            for key, value in all_hashes[0].items()}


def build(name, compiler, options, source, work):
    folder = work / name.replace(" ", "").replace("+", "p")
    flags = options
    # file by file once, because each file of the library includes all that it needs
    unity = "OFF" if (compiler, options) == ("g++", "-O0") else "ON"
    settings = ["-DCMAKE_BUILD_TYPE=None", f"-DCMAKE_CXX_COMPILER={compiler}",
                f"-DCMAKE_UNITY_BUILD={unity}",
                f"-DCMAKE_C_COMPILER={compiler.replace('clang++', 'clang').replace('g++', 'gcc')}"]
    if compiler == CROSS:
        # Headers that are the same for every processor are this system's.
        flags += " -idirafter /usr/include -static"
        settings += ["-DCMAKE_SYSTEM_NAME=Linux", "-DCMAKE_SYSTEM_PROCESSOR=aarch64",
                     "-DCMAKE_C_FLAGS=-idirafter /usr/include -static"]
    if shutil.which("ccache"):
        settings.append("-DCMAKE_CXX_COMPILER_LAUNCHER=ccache")
    for command in (["cmake", "--fresh", "-G", "Ninja", "-S", source / "tests/determinism/variant", "-B", folder,
                     f"-Ddermis_source={source}", f"-DCMAKE_CXX_FLAGS={flags}", *settings],
                    ["cmake", "--build", folder, "--target", "dermis-hashes"]):
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"{shlex.join(map(str, command))}:\n{done.stdout[-4000:]}{done.stderr[-2000:]}")
    return folder / "dermis-hashes"


def built_hashes(name, compiler, flags, before, options):
    program = build(name, compiler, flags, options.source.resolve(), options.work.resolve())
    return hashes([*before.split(), program])


def of_library(name):
    """Whether a result is in double and needs functions of the C library: it has the bits of these."""
    return name in ("sites", "moments", "maps", "below") or (name.endswith("_f64") and not name.startswith("given"))


class Table:
    """Rows of results beside a first one."""

    def __init__(self, expected):
        self.expected = expected
        self.different = 0

    def row(self, name, found, other_library=False):
        compared = [key for key in found if not (other_library and of_library(key))]
        differing = [key for key in compared if self.expected[key] != found[key]]
        self.different += bool(differing) or not compared
        verdict = f"{len(compared)} equal" if not differing else "DIFFER: " + ", ".join(differing)
        if other_library:
            same = sum(self.expected[key] == found[key] for key in found if of_library(key))
            verdict += f"; of {len(found) - len(compared)} in double, which are not promised, {same} equal"
        print(f"{name:<48} {verdict}", flush=True)


def main():
    parser = argparse.ArgumentParser()
    for name in ("--program", "--layers", "--source", "--work"):
        parser.add_argument(name, type=Path, required=True)
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--only", help="rows of all whose name contains this")
    options = parser.parse_args()
    everything = options.all or options.only is not None

    expected = hashes([options.program])
    for name, value in expected.items():
        print(f"{name:<48} {value}")
    table = Table(expected)
    rows = [(f"cpu: {name}", partial(hashes, [options.program, *arguments.split()], variables), variables == NO_FUSED)
            for name, arguments, variables in ON_CPU + OTHER_LIBRARY]
    # by day the rows above are as many
    rows += [(f"cpu: {REPEATS} repeats", lambda: common([hashes([options.program]) for _ in range(REPEATS)]), False)] * everything
    rows += [(f"cpu: {name}", partial(hashes, [*before.split(), options.program]), other_library)
             for name, before, other_library in PROCESSORS if everything]
    layers = {"VK_LAYER_PATH": str(options.layers.resolve()), "VK_INSTANCE_LAYERS": "VK_LAYER_DERMIS_shim"}
    rows += [(f"vulkan: {name}", partial(hashes, [options.program, "device=vulkan", *arguments.split()],
                                         {**variables, **(layers if "DERMIS_SHIM" in variables else {})}), False)
             for name, arguments, variables in ON_VULKAN if everything or name in QUICK_ON_VULKAN]
    rows += [(f"built: {name}", partial(built_hashes, name, compiler, flags, before, options), bool(before))
             for name, compiler, flags, before in BUILDS if everything]
    rows = [row for row in rows if options.only is None or options.only in row[0]]
    with ThreadPoolExecutor(os.cpu_count() if options.all else 1) as pool:
        for (name, _, other_library), found in zip(rows, pool.map(lambda row: row[1](), rows)):
            table.row(name, found, other_library)
    if table.different:
        sys.exit(f"{table.different} rows differ from the first one")


if __name__ == "__main__":
    main()
