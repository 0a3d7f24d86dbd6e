# SPDX-License-Identifier: MIT
"""Each command of the gallery draws the picture above it.

    gallery.py DERMIS PAGE FOLDER BENCH     `./run study` and `./run bench` by the programs that they start, and quickly
"""
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

PYTHON = "/usr/bin/python3"  # has NumPy and Matplotlib
ELSEWHERE = ("./run page", "python ../../tests/embedding/mujoco/hand.py")  # tests/page and tests/doors/python


def programs_of(call, dermis, bench, top):
    """The programs that a command of the page starts."""
    words = shlex.split(call.replace("\\\n", " "))
    if words[0] == "dermis":
        return [[dermis, *words[1:]]]
    if call == "./run study":
        return [[PYTHON, "-B", top / "host/study/study.py", dermis]]
    if call == "./run bench":
        drawn = [[PYTHON, top / f"bench/{name}.py", dermis, f"out/{name}.png", *["results.csv"] * (name == "spikes")]
                 for name in ("long", "needs", "spectrum", "spikes", "stability", "tolerance")]
        return [[bench, "--quick", "--out", "results.csv"], [PYTHON, top / "bench/report.py", "results.csv", "out"], *drawn]
    script = re.fullmatch(r"(?:/usr/bin/)?python3 (bench/\w+\.py) build/release/dermis (\w+\.png)", call)
    if not script:
        sys.exit(f"{call}: no such command is known")
    return [[PYTHON, top / script[1], dermis, pathlib.Path("out", script[2])]]


def run_call(call, work, page, programs):
    """Runs a command of the page in a copy of its folder, unless another picture has."""
    if work.exists():
        return
    shutil.copytree(page.parent, work)
    (work / "out").mkdir()
    for program in programs:
        done = subprocess.run(program, cwd=work, capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"{call}: {program[0]}: exit status {done.returncode}: {done.stdout[-2000:]}{done.stderr}")


def main():
    dermis, page, folder, bench = sys.argv[1], pathlib.Path(sys.argv[2]).resolve(), pathlib.Path(sys.argv[3]), sys.argv[4]
    drawn = 0
    for picture, text in re.findall(r"^!\[[^]]*\]\(([^)]*)\)\n(.*?)(?=^!\[|\Z)", page.read_text(), re.M | re.S):
        name = pathlib.Path(picture).name
        calls = re.findall(r"^    ((?:dermis|\./run|python|/usr/bin/python).*(?:\\\n.*)*)$", text, re.M)
        if not calls:
            sys.exit(f"{picture}: the page has no command that draws it")
        if calls[0].startswith(ELSEWHERE):
            continue
        of_dermis = calls[0].startswith("dermis")
        work = folder / (pathlib.Path(picture).stem if of_dermis else re.sub(r"\W+", "_", calls[0]))
        run_call("\n".join(calls), work, page, [p for c in calls for p in programs_of(c, dermis, bench, page.parents[2])])
        # A script, and a command that draws many, may call the picture by another name, which the text then has.
        names = {name, *re.findall(r"\w+\.png", text)}
        new = [path for path in work.rglob("*.png") if path.name in names and path.parent != work]
        if not new or any(path.read_bytes()[:4] != b"\x89PNG" for path in new):
            sys.exit(f"{picture}: not drawn by {calls}")
        drawn += 1
    if drawn < 19:
        sys.exit(f"{page}: only {drawn} pictures with a command that was run")
    print(f"{drawn} pictures drawn")


main()
