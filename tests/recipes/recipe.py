# SPDX-License-Identifier: MIT
"""recipe.py SOURCE WORK: the recipe "A response" of host/README.md is right.

Copies the sources, adds a response "sa3" to the strain in the files that the recipe names and in no other, builds the
command, and runs a scene: sa3 is sa1 to the bit, on the CPU and on Vulkan.
"""
import csv
import pathlib
import re
import shutil
import subprocess
import sys

EDITS = {
    "include/dermis/description.hpp": [
        ("    fa2,\n    curvature,", "    fa2,\n    sa3,\n    curvature,"),
        ("fa2 = 25;", "fa2 = 25, sa3 = 0;"),
        ("std::optional<double> sa1, sa2, fa1, fa2;", "std::optional<double> sa1, sa2, fa1, fa2, sa3;"),
        ("fa1(all), fa2(all) {}\n    DepthKernel sa1, sa2, fa1, fa2;",
         "fa1(all), fa2(all), sa3(all) {}\n    DepthKernel sa1, sa2, fa1, fa2, sa3;"),
    ],
    "host/core/description/names.hpp": [
        ('{fa2, "fa2"},', '{fa2, "fa2"}, {sa3, "sa3"},'),
    ],
    "host/core/description/description.hpp": [
        (
            "{Quantity::fa2, &Density::fa2, &Depths::fa2, &DepthKernels::fa2},",
            "{Quantity::fa2, &Density::fa2, &Depths::fa2, &DepthKernels::fa2},\n"
            "    {Quantity::sa3, &Density::sa3, &Depths::sa3, &DepthKernels::sa3},",
        ),
    ],
    "kernels/layout.h": [
        ("#define QUANTITY_FA2 4\n", "#define QUANTITY_FA2 4\n#define QUANTITY_SA3 5\n"),
        ("#define RESPONSE_MAPS QUANTITY_FA2", "#define RESPONSE_MAPS QUANTITY_SA3"),
    ],
    "kernels/responses.h": [
        ("    return m.strain;\n", "    if (quantity == QUANTITY_SA3) return m.strain;\n    return m.strain;\n"),
    ],
    "kernels/press.comp": [
        ("buffer Fa2 { vec4 fa2[]; };\n",
         "buffer Fa2 { vec4 fa2[]; };\n"
         "layout(std430, binding = PRESS_RESPONSE(QUANTITY_SA3)) writeonly restrict buffer Sa3 { vec4 sa3[]; };\n"),
        ("fa2[i] = RESPONSE(QUANTITY_FA2);\n",
         "fa2[i] = RESPONSE(QUANTITY_FA2);\n    if (asked(QUANTITY_SA3)) sa3[i] = RESPONSE(QUANTITY_SA3);\n"),
    ],
    "host/doors/python/pickle.hpp": [
        ("DERMIS_MEMBERS(Depths, sa1, sa2, fa1, fa2)", "DERMIS_MEMBERS(Depths, sa1, sa2, fa1, fa2, sa3)"),
        ("DERMIS_MEMBERS(DepthKernels, sa1, sa2, fa1, fa2)", "DERMIS_MEMBERS(DepthKernels, sa1, sa2, fa1, fa2, sa3)"),
    ],
    "host/lab/planner/counted_cell.hpp": [
        ("&m.rate, &m.acceleration}", "&m.rate, &m.acceleration, &m.strain}"),
    ],
}
SCENE = """
model = "march"
precision = "f32"
[grid]
width = 37
height = 21
[surface]
kind = "wave"
[material]
elements = [{ modulus = 2.0, viscosity = 1.0 }, { modulus = 3.0, viscosity = 0.1 }]
[load]
kind = "circular"
radius = 9
envelope = "ramp"
rise = 0.3
[time]
step = 0.05
duration = 0.5
[output]
traces = ["sa1", "fa2", "sa3"]
probes = [[18, 10]]
"""


def recipe_files(source):
    """Return the files that the recipe names, and their number as the recipe says it."""
    page = (source / "host/README.md").read_text()
    recipe = re.search(r"- \*\*A response\*\* \((\d+)\): (.*?)\. All other code", page, re.S)
    names = [name.split(":")[0] for name in re.findall(r"`([^`]+)`", recipe[2])]
    every = [p.relative_to(source) for top in ("kernels", "include", "host") for p in (source / top).rglob("*")]
    files = set()
    for name in names:
        if "." in name:
            found = [p.as_posix() for p in every if p.as_posix().endswith("/" + name)]
            if len(found) != 1:
                sys.exit(f"the recipe names {name}, which is {found}")
            files.update(found)
    return files, int(recipe[1])


def run(*command):
    print("+", *command, flush=True)
    return subprocess.run([str(word) for word in command], check=True, stdout=subprocess.PIPE, text=True).stdout


def main(source, work):
    named, count = recipe_files(source)
    if named != set(EDITS) or len(named) != count:
        sys.exit(f"the recipe names {sorted(named)} and says {count}; the change needs {sorted(EDITS)}")
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    for name in ("kernels", "include", "host", "CMakeLists.txt", "LICENSE", "README.md"):
        copy = shutil.copytree if (source / name).is_dir() else shutil.copy
        copy(source / name, work / name)
    for name, edits in EDITS.items():
        text = (work / name).read_text()
        for before, after in edits:
            if text.count(before) != 1:
                sys.exit(f"{name} has {text.count(before)} times: {before}")
            text = text.replace(before, after)
        (work / name).write_text(text)
    build = work / "build"
    run("cmake", "-S", work, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=None",
        "-DCMAKE_CXX_FLAGS=-O0 -Werror=switch", "-DDERMIS_TESTS=OFF", "-DDERMIS_BENCH=OFF", "-DDERMIS_INSTALL=OFF")
    run("cmake", "--build", build, "--target", "dermis-cli")
    dermis = build / "dermis"
    print(run(dermis, "check"))
    (work / "scene.toml").write_text(SCENE)
    for device in ("cpu", "vulkan"):
        compared = ["--check"] if device == "vulkan" else []
        run(dermis, "run", work / "scene.toml", "--device", device, *compared, "--out", work / device)
        with open(work / device / "traces.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        columns = [name for name in rows[0] if name.startswith("sa3")]
        if not columns or not any(float(row[columns[0]]) for row in rows):
            sys.exit(f"{device}: no sa3 in {list(rows[0])}")
        for column in columns:
            if any(row[column] != row[column.replace("sa3", "sa1")] for row in rows):
                sys.exit(f"{device}: {column} is not sa1")


main(pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve())
