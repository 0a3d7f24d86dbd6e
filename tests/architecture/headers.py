# SPDX-License-Identifier: MIT
"""Every header compiles alone, and includes what it uses. Arguments: compiler, folder of the sources, other folders.

By day the public headers are compiled, by night all. A header that is the first include of another one is compiled by
that. Compilers differ in what their own headers bring along, so that whoever uses a name of the standard library includes the header of that name, or does so by a header of
this project.
"""

import os
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

# Kernels are compiled by what defines their types, host/core/simd/model.hpp; the module of Python where it is built.
ELSEWHERE = ("host/examples/", "host/doors/python/", "host/doors/mujoco/", "kernels/")
FLAGS = ["-std=c++20", "-fsyntax-only", "-w", "-DFMT_HEADER_ONLY", "-x", "c++"]
# A name, and the headers of which one declares it.
NAMES = {
    r"\bu?int(?:8|16|32|64|max|ptr)_t\b|\bU?INT(?:8|16|32|64|MAX)_MAX\b": ["cstdint", "stdint.h"],
    r"\bstd::string\b": ["string"],
    r"\bstd::string_view\b": ["string_view", "string"],
    r"\bstd::vector\b": ["vector"],
    r"\bstd::array\b": ["array"],
    r"\bstd::map\b": ["map"],
    r"\bstd::function\b": ["functional"],
    r"\bstd::optional\b": ["optional"],
    r"\bstd::(?:unique_ptr|shared_ptr|make_unique|make_shared)\b": ["memory"],
    r"\bstd::(?:atomic)\b": ["atomic"],
    r"\bstd::(?:mutex|lock_guard|unique_lock)\b": ["mutex"],
    r"\bstd::thread\b": ["thread"],
    r"\bstd::(?:sqrt|abs|floor|ceil|exp|isfinite|hypot|fma)\b|\bINFINITY\b|\bNAN\b": ["cmath", "cstdlib"],
    r"\bstd::numeric_limits\b": ["limits"],
    r"\bstd::mem(?:cpy|set|cmp)\b": ["cstring"],
    r"\bstd::(?:clamp|min|max|sort|copy|copy_n|fill|any_of|find)\b": ["algorithm"],
    r"\bstd::exception_ptr\b": ["exception"],
    r"\bstd::(?:istream|ios)\b": ["istream", "ios", "iostream", "fstream"],
    r"\bstd::filesystem\b": ["filesystem"],
}


def includes_of(source, file):
    """The includes of a file: those of the project as paths, others as they stand."""
    text = re.sub(r"//.*", "", (source / file).read_text())
    found = []
    for name in re.findall(r'^\s*#\s*include\s*["<]([^">]+)', text, re.M):
        for path in (name, f"include/{name}", str(Path(file).parent / name)):
            if (source / path).is_file():
                name = path
                break
        found.append(name)
    return text, found


def main(compiler, source, *folders):
    source = Path(source)
    files = [str(f.relative_to(source)) for room in ("host", "include", "kernels") for f in sorted((source / room).rglob("*"))
             if f.suffix in (".hpp", ".h", ".inl")]
    known = {file: includes_of(source, file) for file in files}
    if "host/lab/scenes/input_file.hpp" not in known:
        sys.exit(f"no headers in {source}")
    faults = []

    def reached(file, seen):
        for name in known[file][1] if file in known else []:
            if name not in seen:
                seen.add(name)
                reached(name, seen)
        return seen

    own = [f for f in files if not f.startswith(ELSEWHERE) and not f.endswith(".inl")]
    for file in own:
        seen = reached(file, set())
        for pattern, headers in NAMES.items():
            used = re.search(pattern, known[file][0])
            if used and not seen.intersection(headers):
                faults.append(f"{file} uses {used[0]} and does not include <{headers[0]}>")
    compiled = own if "DERMIS_NIGHT" in os.environ else [f for f in own if f.startswith("include/")]
    first = {names[0] for file in compiled if (names := known[file][1])}

    def alone(file):
        done = subprocess.run([compiler, *FLAGS, f"-I{source}", f"-I{source}/include", *(f"-I{f}" for f in folders), "-"],
                              input=f'#include "{file}"\n', capture_output=True, text=True)
        return done.returncode and f"{file} does not compile alone:\n{done.stderr[:1000]}"

    with ThreadPoolExecutor(2) as pool:
        faults += filter(None, pool.map(alone, [f for f in compiled if f not in first]))
    print(f"{len(own)} headers, {len(set(compiled) - first)} compiled")
    if faults:
        sys.exit("\n".join(faults))


main(*sys.argv[1:])
