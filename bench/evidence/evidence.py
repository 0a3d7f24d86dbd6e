# SPDX-License-Identifier: MIT
"""Published results about touch beside what dermis computes: evidence.py dermis folder [--row NAME] [--without NAME ..] [--write]

Writes the page EVIDENCE.md and its pictures into the folder. rows.csv has the rows, and what each is
judged by. Exits with 1 where a number is not as in expected.csv (name, value, and by how much it may
differ), or bench/EVIDENCE.md counts otherwise, after the page is written. --row: computes this row alone and prints its
numbers, without a page. --without: leaves rows out, and the page. --write: writes expected.csv anew.
"""
import argparse
import re
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from rows import HERE, Row, data, listed, save

import firing
import halfspace
import places
import vibration
from drawing import VERMILLION
from runs import run, scene, table, traces

FILES = ("rows.csv", "adaptation.csv", "heldout.csv", "bar.csv", "rates.csv", "shares.csv", "spheres.csv", "fields.csv", "thresholds.csv",
         "edges.csv", "afferents.csv", "press.csv", "reach.csv", "spacing.csv", "touchsim.csv")
WORDS = {name: (ours, why) for name, ours, why in re.findall(r"^#: (\w+)\n(.*)\n(.*)$", (HERE / "words.txt").read_text(), re.M)}


def amplitude(dermis, response, hz, tau):
    """The amplitude of a response to a sine of amplitude 1, from a run of dermis with one retardation time (s)."""
    wait = int(np.ceil(15 * tau * hz))  # periods, after which it swings evenly
    with tempfile.TemporaryDirectory() as folder:
        text = scene("sine", tau=tau, hz=hz, response=response, step=1 / hz / 32, duration=(wait + 2) / hz)
        values = traces(run(dermis, text, folder))[f"{response}_mean"]
    last = values[(wait + 1) * 32:(wait + 2) * 32]
    return 2 / 32 * abs((last * np.exp(-2j * np.pi * np.arange(32) / 32)).sum())


def of_a_sine(hz, tau):
    """FA1's as a formula, by which the retardation time is fitted."""
    return 2 * np.pi * hz / np.hypot(1, 2 * np.pi * hz * tau)


def filter_row(dermis, folder):
    hz, um = np.array([(float(r["hz"]), float(r["um"])) for r in data("thresholds.csv") if r["class"] == "ra"]).T
    tau = min(np.geomspace(1e-5, 1, 2000), key=lambda t: np.std(np.log(of_a_sine(hz, t) * um)))
    with ThreadPoolExecutor() as pool:
        ours = 1 / np.array(list(pool.map(lambda f: amplitude(dermis, "fa1", f, tau), hz)))
    decibels = 20 * np.log10(ours / um)
    ours = ours * 10 ** (-decibels.mean() / 20)
    figure, axis = plt.subplots(figsize=(4.2, 2.8), constrained_layout=True)
    axis.loglog(hz, ours, color=VERMILLION, label="dermis, FA1")
    axis.loglog(hz, um, "o", color="black", markersize=4, label="published")
    axis.set_title("thresholds of RA afferents (µm)", fontsize=9)
    axis.set_xlabel("frequency (Hz)", fontsize=9)
    axis.legend(fontsize=8, frameon=False)
    save(figure, folder / "evidence_thresholds.png")
    return Row({"ra_fa1_db": float(np.std(decibels)), "ra_fa1_tau_ms": tau * 1e3}, "evidence_thresholds.png")


def adaptation_row(dermis, folder):
    numbers, names = {}, {0: "held", -0.15: "falling", 0.15: "rising"}
    text = (HERE.parents[1] / "host/examples/held_depth.toml").read_text()
    for row in data("adaptation.csv"):
        depth, drift = float(row["depth_mm"]), float(row["drift"])
        rise = depth / 0.4
        pressed = text.replace('"0.65 mm"', f'"{depth} mm"').replace("duration = 14", "duration = 16").replace(
            'envelope = "ramp"\nrise = 1.625',
            f'envelope = "table"\ntimes = [0, {rise}, {rise + 12}]\nvalues = [0, 1, {1 + drift}]')
        with tempfile.TemporaryDirectory() as work:
            sa1 = traces(run(dermis, pressed, work))["sa1_probe0"]
        held = round(rise / 0.025)
        numbers[f"{names[drift]}_{depth}_mm"] = 100 * (sa1[held + 480] / sa1[held] - 1)
    return Row(numbers)


def ridges_row(dermis, folder):
    return Row({f"ridges_{name}": value for name, value in vibration.measure(dermis).items()}, "vibration.png")


def press_row(dermis, folder):
    rows = data("press.csv")
    width, height, spacing, radius, force = 132, 162, 1e-4, 1e-3, 0.119047
    even = halfspace.even_press(width, height, spacing)
    depth = float(rows[0]["depth_mm"]) * 1e-3
    centre = halfspace.below(dermis, halfspace.flat_punch(width, height, spacing, radius, force), spacing, (depth,))[0][81, 66] / 1e3
    alike, ours = firing.fire_in_press(dermis, even)
    numbers = {"punch_kpa": centre, **{f"press_{kind}": share for kind, share in ours.items()},
               **{f"press_{kind}_alike": share for kind, share in alike.items()}}
    return Row(numbers, told={"texts": listed(alike[row["class"]] for row in rows)})


def reach_row(dermis, folder):
    rows, (width, height, spacing) = data("reach.csv"), (132, 162, 1e-4)
    pressure = halfspace.even_press(width, height, spacing)
    numbers = {}
    for kernel, end in (("displacement", ""), ("stress", "_stress")):
        away, fires = firing.fire_by_distance(dermis, pressure, kernel)
        numbers[f"reach_whole{end}"] = 100 * fires.mean()
        for row in rows:
            within = abs(away - float(row["mm"])) < float(row["half_width_mm"])
            numbers[f"reach_{row['mm']}_mm{end}"] = fires[within].mean()
    return Row(numbers, told={"texts": listed((numbers[f"reach_{row['mm']}_mm_stress"] for row in rows), ".2f")})


ROWS = {"adaptation": adaptation_row, "ridges": ridges_row, "noise": firing.noise_row, "pairs": firing.pairs_row,
        "bar": places.bar_row, "dots": places.dots_row, "spacing": places.spacing_row, "gratings": places.gratings_row,
        "ramp": firing.ramp_row, "rates": firing.rates_row, "spheres": places.spheres_row, "fields": places.fields_row,
        "thresholds": firing.thresholds_row, "filter": filter_row, "strokes": places.strokes_row,
        "edges": firing.edges_row, "plateau": firing.plateau_row, "hold": firing.hold_row, "press": press_row,
        "reach": reach_row, "units": firing.units_row}


def judged(value, line):
    """Whether a number is within the tolerance of a line of rows.csv."""
    published, tolerance = float(line["published"]), line["tolerance"]
    if tolerance == "at least":
        return value >= published
    return value <= published if tolerance == "at most" else abs(value - published) <= float(tolerance)


def asked(line):
    tolerance = line["tolerance"]
    return f"{tolerance} {line['published']}" if tolerance.startswith("at") else f"{line['published']} ± {tolerance}"


def told(name, row, which):
    """What words.txt says of a row: 0: what dermis has; 1: why."""
    return WORDS[name][which].format(**row.numbers, **row.told)


def verdict_of(lines, agrees):
    return ("compatible" if lines[0]["kind"] == "by choice" else "agrees") if agrees else "**fails**"


def digits(value):
    return f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"


def page(rows):
    """The page. rows: for each its name, its lines of rows.csv and what is computed."""
    agree = {name: all(judged(row.numbers[line["name"]], line) for line in lines) for name, lines, row in rows}
    kinds = {kind: [name for name, lines, _ in rows if lines[0]["kind"] == kind]
             for kind in dict.fromkeys(lines[0]["kind"] for _, lines, _ in rows)}
    counted = {kind: f"{sum(agree[name] for name in names)} of {len(names)}" for kind, names in kinds.items()}
    head = (HERE / "EVIDENCE.md.in").read_text().format(prediction=counted["prediction"], fit=counted["fit"], other=counted["other model"],
                                                        chosen=len(kinds["by choice"]))
    heading = "\n| # | published | asked for | dermis | verdict |\n|---|---|---|---|---|\n"
    verdict = {name: verdict_of(lines, agree[name]) for name, lines, _ in rows}
    titles = {"prediction": "Predictions", "fit": "Fits", "by choice": "Compatible by a choice of ours", "other model": "Other models"}
    number = {name: n for n, (name, _, _) in enumerate(rows, 1)}
    for kind, names in kinds.items():
        head += f"\n## {titles[kind]}: {counted[kind]}\n{heading}"
        for name, lines, row in rows:
            if name in names:
                wants = "; ".join(f"{line['quantity']}: {asked(line)}" for line in lines)
                ours = "; ".join(digits(row.numbers[line["name"]]) for line in lines)
                head += f"| {number[name]} | {lines[0]['title']} ({lines[0]['source']}) | {wants} | {ours} | {verdict[name]} |\n"
    for name, lines, row in rows:
        picture = f"\n![{lines[0]['title']}]({row.picture})\n" if row.picture else ""
        head += f"\n## {number[name]}. {lines[0]['title']}\n{picture}\n| {lines[0]['source']} | asked for | dermis | |\n|---|---|---|---|\n"
        for line in lines:
            value = row.numbers[line["name"]]
            head += f"| {line['quantity']} | {asked(line)} | {digits(value)} | {verdict_of(lines, judged(value, line))} |\n"
        head += f"\ndermis: {told(name, row, 0)}.\n\n{told(name, row, 1)}.\n\n`python3 bench/evidence/evidence.py DERMIS FOLDER --row {name}` computes it.\n"
    head = re.sub(r"row:(\w+)", lambda found: f"row {number[found[1]]}", head)
    head += "\n## Data\n\n"
    for name in FILES:
        text = " ".join(line[2:] for line in (HERE / name).read_text().splitlines() if line.startswith("#"))
        head += f"- [{name}](evidence/{name}): {text}\n"
    sources = dict(line.split(": ", 1) for line in (HERE / "sources.txt").read_text().splitlines())
    missing = [name for name in sources if name not in head]
    assert not missing, f"no row and no data are of {missing}"
    return head + "\n## Sources\n\n" + "".join(f"- {name}: {text}.\n" for name, text in sources.items())


def changed(numbers, path, whole):
    """What is not as expected, in words. whole: whether all numbers that are expected have been computed."""
    expected = {row["name"]: row for row in table(path) if whole or row["name"] in numbers}
    wrong = [f"{name} = {numbers.get(name)}; {path} has {expected.get(name, {}).get('value')}"
             for name in sorted(set(numbers) ^ set(expected))]
    for name in sorted(set(numbers) & set(expected)):
        value, allowed = float(expected[name]["value"]), float(expected[name]["tolerance"])
        if not abs(numbers[name] - value) <= allowed:
            wrong.append(f"{name} = {numbers[name]:.6g}; {path} has {value:g} +- {allowed:g}")
    return wrong


def written(numbers, path):
    """Writes the expected numbers anew: each may differ by 1 % or, near 0, by 0.005."""
    lines = [f"{name},{value:.5g},{max(0.01 * abs(value), 0.005):.2g}" for name, value in sorted(numbers.items())]
    head = "# Numbers of bench/EVIDENCE.md. tolerance: by how much a number may differ from its value."
    Path(path).write_text("\n".join([head, "name,value,tolerance", *lines, ""]))


def main():
    options = argparse.ArgumentParser()
    options.add_argument("dermis")
    options.add_argument("folder", type=Path)
    options.add_argument("--row", choices=list(ROWS))
    options.add_argument("--without", choices=list(ROWS), nargs="+", default=[])
    options.add_argument("--write", action="store_true")
    options = options.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    dermis = str(Path(options.dermis).resolve())
    lines = {}
    for line in data("rows.csv"):
        lines.setdefault(line["row"], []).append(line)
    assert list(lines) == list(ROWS), f"rows.csv has the rows {list(lines)}; there are functions for {list(ROWS)}"
    rows = []
    for name in [options.row] if options.row else [name for name in ROWS if name not in options.without]:
        row = ROWS[name](dermis, options.folder)
        row.numbers = {key: float(value) for key, value in row.numbers.items()}
        rows.append((name, lines[name], row))
        print(f"{name}: {lines[name][0]['title']}: {told(name, row, 0)}", flush=True)
        for line in lines[name]:
            value = row.numbers[line["name"]]
            print(f"    {line['quantity']}: {digits(value)}, {asked(line)}: {verdict_of(lines[name], judged(value, line))}", flush=True)
    if options.row:
        return
    numbers = {name: value for _, _, row in rows for name, value in row.numbers.items()}
    if not options.without:
        (options.folder / "EVIDENCE.md").write_text(page(rows))
    if options.write:
        written(numbers, HERE / "expected.csv")
    elif not options.without and page(rows).split("##")[0] != (HERE.parent / "EVIDENCE.md").read_text().split("##")[0]:
        sys.exit(f"evidence: the counts of bench/EVIDENCE.md are not those of {options.folder / 'EVIDENCE.md'}")
    wrong = changed(numbers, HERE / "expected.csv", not options.without)
    if wrong:
        sys.exit("evidence: numbers that are not as expected:\n" + "\n".join(wrong))


if __name__ == "__main__":
    main()
