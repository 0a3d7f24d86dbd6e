# SPDX-License-Identifier: MIT
"""The published study, repeated by its script: study_test.py DERMIS SOURCE WORK"""
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np

dermis, source, work = sys.argv[1], Path(sys.argv[2]), Path(sys.argv[3])
sys.path.insert(0, str(source / "host/study"))
import claims  # noqa: E402
import study  # noqa: E402
from results import LOADS, RESPONSES, SURFACES, Results  # noqa: E402

out = work / "study"
HOLD, IN_PART = {1, 2, 8, 9, 10, 12, 13, 17}, {5, 14, 15, 16, 18, 19}


def call(*options, program=dermis):
    script = source / "host/study/study.py"
    return subprocess.run([sys.executable, "-B", script, program, *options], capture_output=True, text=True)


def check(holds, what):
    if not holds:
        sys.exit(f"study: {what}")


def columns(path):
    with open(path) as file:
        names = file.readline().strip().split(",")
        return dict(zip(names, np.loadtxt(file, delimiter=",", unpack=True)))


def test_all_cells_are_equal_on_vulkan_and_the_cpu_and_the_last_words_name_the_file_to_open():
    done = call("--out", str(out))
    check(done.returncode == 0 and not done.stderr, done.stdout[-2000:] + done.stderr)
    # exact has an output more to compare, the last step's
    cells = 22500 * (19 * (1000 + 1) + 19 * 1000) * 5
    found = re.search(r"^38 scenes; (\d+) cells compared, 0 different$", done.stdout, re.M)
    check(found and 0.99 < int(found[1]) / cells <= 1.01, done.stdout)
    check(done.stdout.endswith(f"open first: {out / 'index.html'}\n"), done.stdout)


def test_the_study_s_numbers_are_reproduced_where_its_surface_is_exact_to_rounding_else_to_that_of_float():
    results, worst = Results(dermis, out, False), dict.fromkeys(SURFACES, 0.0)
    for surface in SURFACES:
        for load in LOADS:
            published = columns(source / f"tests/data/traces_{surface}_{load}.csv")
            traces = results.traces(f"double/published/{surface}_{load}")
            rows = published["step"].astype(int)
            names = ["time", "strain_mean", "strain_max"] + [f"{q}_{what}" for q in RESPONSES
                                                             for what in ("mean", *(f"probe{k}" for k in range(5)))]
            check(set(names) == set(published) - {"step"}, f"other columns: {sorted(published)}")
            for name in names:
                off = abs(traces[name][rows] - published[name]).max()
                worst[surface] = max(worst[surface], off / max(abs(published[name]).max(), 1e-300))
    print(worst)
    check(worst["flat"] < 1.2e-13, f"flat: off by {worst['flat']}")
    check(max(worst.values()) < 1e-5, f"ridges, which the study has in float: off by {worst}")


def test_eight_of_the_23_claims_hold_and_six_in_part():
    text = (out / "claims.md").read_text()
    check(text.startswith("8 of 23 claims hold, 6 in part, 9 do not.\n"), text[:100])
    verdicts = {int(n): verdict for n, verdict in re.findall(r"^\| (\d+) \|.*\*\*([a-z ]+)\*\*[^|]*\|$", text, re.M)}
    expected = {n: "holds" if n in HOLD else "holds in part" if n in IN_PART else "does not hold" for n in range(1, 24)}
    check(verdicts == expected, f"{verdicts}")
    check("{" not in text and "nan" not in text, "a field is open")
    evidence = re.search(r"\[EVIDENCE.md\]\((.*?)\)", text)[1]
    check((out / evidence).resolve() == source.resolve() / "bench/EVIDENCE.md", evidence)


def test_a_field_that_only_the_text_or_only_the_script_has_is_an_error():
    for text, fields in ("{a}", {}), ("{a}", {"a": 1, "b": 2}):
        try:
            claims.fill(text, fields)
        except KeyError:
            continue
        check(False, f"{text} took {fields}")
    check(claims.fill("{a:.1f}, {b? yes / no}", {"a": [1, 2.25], "b": False}) == "1.0, 2.2, no", "a list or a verdict")


def test_on_the_fingertip_a_held_pressure_strains_by_pressure_over_modulus_over_all_viscosities_that_the_study_cites():
    rows = Results(dermis, out, False).table("sweep_fingertip/runs.csv")
    check(len(rows) == 25, f"{len(rows)} runs")
    for row in rows:
        modulus, strain = float(row["material.modulus"]), float(row["strain_max_final"])
        check(abs(strain * modulus / 1e4 - 1) < 1e-12, f"strain {strain} at {modulus} Pa")
        check(abs(float(row["fa1_mean_peak"]) / float(row["sa1_mean_final"]) * 0.1 - 1) < 1e-3, f"FA1 at {modulus} Pa")
    text = (out / "claims.md").read_text()
    nine = re.findall(r"^\| (?:flat|wave|spiral) \| (?:circular|point|linear) \|", text, re.M)
    check(len(set(nine)) == 9, f"{nine}")
    # a cone of 10 kPa over 50 cells of 50 um
    force = float(re.search(r"^\| flat \| circular \| 10 \| ([\d.]+) \|", text, re.M)[1])
    check(abs(force / (1e4 * np.pi * 2.5e-3**2 / 3 * 1e3) - 1) < 2e-3, f"{force} mN")


def test_the_page_has_each_figure_beside_its_claims():
    page = (out / "index.html").read_text()
    sections = re.findall(r"<section.*?</section>", page, re.S)
    check(len(sections) == 11, f"{len(sections)} sections")
    for section in sections:
        picture = re.search(r'<img src="(.*?)"', section)[1]
        check((out / picture).read_bytes()[:4] == b"\x89PNG", picture)
    beside = set(map(int, re.findall(r"<h3>(\d+)\. ", "".join(sections))))
    check(beside == set(range(1, 24)), f"beside figures: {sorted(beside)}")
    check("**" not in page and "](" not in page and "| " not in page, "text of Markdown is left")


def test_a_cell_that_differs_is_counted():
    class Finished(Results):
        def run(self, folder, *_):
            return folder

    place = out / "exact/flat_point/summary.json"
    whole = place.read_text()
    summary = json.loads(whole)
    check(study.run_study(Finished(dermis, out, False), True) == 0, "cells differ")
    summary["cross_check"]["different"] = 3
    place.write_text(json.dumps(summary))
    check(study.run_study(Finished(dermis, out, False), True) == 3, "three cells that differ are not counted")
    place.write_text(whole)


def test_resume_does_only_what_is_damaged_again():
    damaged = out / "exact/flat_circular/traces.csv"
    whole, text = damaged.read_bytes(), (out / "claims.md").read_text()
    before = {path: path.stat().st_mtime_ns for path in out.rglob("traces.csv")}
    damaged.write_bytes(whole[:100])
    (out / "claims.md").unlink()
    done = call("--out", str(out), "--resume")
    check(done.returncode == 0, done.stdout[-2000:] + done.stderr)
    check(damaged.read_bytes() == whole, "the damaged file stayed")
    changed = [path for path in out.rglob("traces.csv") if path.stat().st_mtime_ns != before.get(path)]
    check(changed == [damaged], f"done again: {changed}")
    check((out / "claims.md").read_text() == text, "other claims")


def test_what_cannot_be_done_is_refused_by_name_and_a_folder_of_others_stays_as_it_was():
    others = work / "others"
    others.mkdir()
    (others / "index.html").write_text("mine")
    done = call("--out", str(others))
    check(done.returncode == 1 and f"{others} has other files; allowed: " in done.stderr, done.stderr)
    check([p.name for p in others.iterdir()] == ["index.html"] and (others / "index.html").read_text() == "mine", "changed")
    done = call("--out", str(work / "new"), program=str(work / "none"))
    check(done.returncode == 1 and f"{work / 'none'} cannot be started" in done.stderr, done.stderr)
    done = call("--walk")
    check(done.returncode == 2 and "--walk" in done.stderr, done.stderr)


shutil.rmtree(work, ignore_errors=True)
work.mkdir(parents=True)
for name, test in list(globals().items()):
    if name.startswith("test_"):
        test()
        print(f"passed: {name}", flush=True)
