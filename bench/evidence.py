# SPDX-License-Identifier: MIT
"""Published results about touch beside what dermis computes: evidence.py dermis folder [--expected numbers.csv]

Writes the page EVIDENCE.md and its pictures into the folder. Exits with 1 where a number is not as in the file of
expected numbers (bench/evidence/expected.csv: name, value, and by how much it may differ), after the page is written.
"""
import argparse
import csv
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import evidence_spikes
import vibration
from evidence_row import BLUE, DATA, GREEN, GREY, HERE, SOURCES, VERMILLION, Row, data, lines_of, run, save

FILES = ("thresholds.csv", "rates.csv", "afferents.csv", "adaptation.csv", "press.csv", "edges.csv", "relaxation.csv")
HALF_SPACE = """
[grid]
width = {width}
height = {height}
spacing = {spacing}
[surface]
relief = 1e-5
[material]
modulus = 1 # Pa: a response is the stress in Pa, or the strain times the modulus
viscosity = 1e-9
thickness = 1e-3
curvature_length = 0
[load]
kind = "file"
path = "pressure.npy"
[receptors]
kernel = "{kernel}"
{poisson}
[time]
step = 0.1
duration = 0.1
[output]
traces = []
fields = [{{ at = 0.1, what = ["sa1"] }}]
"""
HOLD = """
preset = "fingertip"
[grid]
width = 1
height = 1
[surface]
kind = "flat"
[load]
radius = 1
intensity = 1e3
envelope = "ramp"
rise = {rise}
[time]
step = 0.025
duration = 16
[output]
traces = ["sa1"]
extremes = false
"""
SINE = """
[grid]
width = 1
height = 1
spacing = 1e-3
[surface]
relief = 1e-5
[material]
modulus = 1
viscosity = {tau}
thickness = 1e-3
curvature_length = 0
[load]
radius = 1
envelope = "sine"
frequency = {hz}
[time]
step = {step}
duration = {duration}
[output]
traces = ["{response}"]
extremes = false
"""


def below(dermis, pressure, spacing, depths, kernel="stress"):
    """What acts at each of some depths (m) below a map of pressures: a map each, from dermis."""
    height, width = pressure.shape
    poisson = "poisson = 0.4" if kernel == "strain" else ""
    with tempfile.TemporaryDirectory() as folder:
        np.save(f"{folder}/pressure.npy", pressure)
        sweep = ",".join(f"{{ sa1 = {depth} }}" for depth in depths)
        scene = HALF_SPACE.format(width=width, height=height, spacing=spacing, kernel=kernel, poisson=poisson)
        out = run(dermis, scene, folder, "--set", f"receptors.depth={sweep}")
        folders = [out / str(i + 1) for i in range(len(depths))] if len(depths) > 1 else [out]
        return [np.load(f / "sa1_t0.1.npy") for f in folders]


def amplitude(dermis, response, hz, tau):
    """The amplitude of a response to a sine of amplitude 1, from a run of dermis with one retardation time (s)."""
    wait = int(np.ceil(15 * tau * hz))  # periods, after which it swings evenly
    with tempfile.TemporaryDirectory() as folder:
        scene = SINE.format(tau=tau, hz=hz, response=response, step=1 / hz / 32, duration=(wait + 2) / hz)
        out = run(dermis, scene, folder)
        values = np.genfromtxt(out / "traces.csv", delimiter=",", names=True)[f"{response}_mean"]
    last = values[(wait + 1) * 32:(wait + 2) * 32]
    return 2 / 32 * abs((last * np.exp(-2j * np.pi * np.arange(32) / 32)).sum())


def of_a_sine(response, hz, tau):
    """The same as a formula, by which the retardation time is fitted."""
    w = 2 * np.pi * hz
    return w ** {"sa1": 0, "fa1": 1, "fa2": 2}[response] / np.hypot(1, w * tau)


def thresholds(dermis):
    """For each class and response: frequencies, published thresholds, ours after one gain, rms in dB, tau in s."""
    rows, source = data("thresholds.csv", "Ouyang et al. 2021")
    found = {}
    for kind, response in (("ra", "fa1"), ("pc", "fa2"), ("sa1", "sa1"), ("sa1", "fa1")):
        hz, um = np.array([(float(r["hz"]), float(r["um"])) for r in rows if r["class"] == kind]).T
        tau = min(np.geomspace(1e-5, 1, 2000), key=lambda t: np.std(np.log(of_a_sine(response, hz, t) * um)))
        with ThreadPoolExecutor() as pool:
            ours = 1 / np.array(list(pool.map(lambda f: amplitude(dermis, response, f, tau), hz)))
        decibels = 20 * np.log10(ours / um)
        found[kind, response] = hz, um, ours * 10 ** (-decibels.mean() / 20), float(np.std(decibels)), tau
    return found, source


def draw_thresholds(found, picture):
    figure, axes = plt.subplots(1, 3, figsize=(9, 3), constrained_layout=True)
    for axis, (kind, title) in zip(axes, (("ra", "RA"), ("pc", "PC"), ("sa1", "SA1"))):
        for (name, response), (hz, um, ours, rms, _) in found.items():
            if name == kind:
                colour = {"sa1": BLUE, "fa1": VERMILLION, "fa2": GREEN}[response]
                axis.loglog(hz, ours, color=colour, label=f"dermis, {response.upper()}: {rms:.1f} dB")
                axis.loglog(hz, um, "o", color="black", markersize=4)
        axis.set_title(f"thresholds of {title} afferents (µm)", fontsize=9)
        axis.set_xlabel("frequency (Hz)", fontsize=9)
        axis.legend(fontsize=8, frameon=False)
    save(figure, picture)


def threshold_rows(dermis, folder):
    found, source = thresholds(dermis)
    draw_thresholds(found, folder / "evidence_thresholds.png")
    rms = {key: value[3] for key, value in found.items()}
    tau = {key: value[4] * 1e3 for key, value in found.items()}
    scene = "[vibration.toml](../host/examples/vibration.toml) with another frequency"
    ra, pc, sa1, rate = ("ra", "fa1"), ("pc", "fa2"), ("sa1", "sa1"), ("sa1", "fa1")
    how = ("The threshold that dermis predicts is inverse to the amplitude of the response to a sine; a run for each "
           "point. The displacement of the probe stands for the pressure")
    return [
        Row("RA afferents: thresholds", "eight points from 0.5 to 68 Hz, 940 to 47 µm",
            f"FA1: {rms[ra]:.1f} dB rms, after one fitted gain and one fitted retardation time of {tau[ra]:.1f} ms",
            rms[ra] < 2, f"{how}. Two numbers are fitted to eight points; the shape is the model's", scene, source,
            {"ra_fa1_db": rms[ra], "ra_fa1_tau_ms": tau[ra]}, "evidence_thresholds.png"),
        Row("PC afferents: thresholds", "14 points from 20 to 822 Hz, 6 to 0.05 µm",
            f"FA2: {rms[pc]:.1f} dB rms, after one fitted gain and one fitted retardation time of {tau[pc]:.1f} ms",
            rms[pc] < 2, "FA2 grows with frequency up to the highest in the data, whereas a corpuscle is most "
            "sensitive at some 250 Hz. The poles and the membrane of an afferent give such a maximum: row 12", scene, source,
            {"pc_fa2_db": rms[pc], "pc_fa2_tau_ms": tau[pc]}),
        Row("SA1 afferents: thresholds", "nine points from 0.5 to 134 Hz, 90 to 6 µm",
            f"SA1: {rms[sa1]:.1f} dB rms; the rate (FA1) of the same strain: {rms[rate]:.1f} dB",
            rms[sa1] < 2, "SA1 afferents answer to strain and to its rate; dermis has one response for "
            "each, and afferents that follow both: row 12", scene, source,
            {"sa1_sa1_db": rms[sa1], "sa1_fa1_db": rms[rate]}),
    ]


def held_depth(dermis):
    """The change of SA1 in % within 12 s of a held depth, for each of adaptation.csv."""
    changes = []
    for depth in (0.65, 1.3):
        with tempfile.TemporaryDirectory() as folder:
            scene = (Path(__file__).parent.parent / "host/examples/held_depth.toml").read_text()
            scene = scene.replace('"0.65 mm"', f'"{depth} mm"').replace("rise = 1.625", f"rise = {depth / 0.4}")
            out = run(dermis, scene.replace("duration = 14", "duration = 16"), folder)
            sa1 = np.genfromtxt(out / "traces.csv", delimiter=",", names=True)["sa1_probe0"]
        held = round(depth / 0.4 / 0.025)
        changes.append(100 * (sa1[held + 480] / sa1[held] - 1))
    return changes


def held_pressure(dermis, depth):
    """The change of SA1 in % within 12 s of a held pressure, which rises as long as a probe would, to a depth (mm)."""
    with tempfile.TemporaryDirectory() as folder:
        out = run(dermis, HOLD.format(rise=depth / 0.4), folder)
        sa1 = np.genfromtxt(out / "traces.csv", delimiter=",", names=True)["sa1_mean"]
    held = round(depth / 0.4 / 0.025)
    return 100 * (sa1[held + 480] / sa1[held] - 1)


def adaptation_row(dermis):
    rows, source = data("adaptation.csv", "Mei et al. 1983")
    depths, ours = [float(row["depth_mm"]) for row in rows], held_depth(dermis)
    agrees = all(abs(o - float(r["change_percent"])) < 10 for o, r in zip(ours, rows))
    pressure = [held_pressure(dermis, depth) for depth in depths]
    texts = ["a pressure that is held instead: " + " and ".join(f"{change:+.0f} %" for change in pressure)]
    numbers = {f"held_pressure_{depth}_mm": change for depth, change in zip(depths, pressure)}
    texts.insert(0, " and ".join(f"{change:+.1f} %" for change in ours))
    numbers |= {f"held_depth_{depth}_mm": change for depth, change in zip(depths, ours)}
    return Row("SA1 afferents adapt at a held depth", "-38 % in 12 s at 0.65 mm, -36 % at 1.3 "
               "mm", "; ".join(texts), agrees,
               "The experiment holds a depth, at which stress relaxes. Under a pressure that is held strain goes on "
               "to grow, and SA1 follows strain; here it follows the stress, `receptors.follow`, below a punch that is "
               "pressed to a depth", "[held_depth.toml](../host/examples/held_depth.toml)", source, numbers)


def rigid_bar(width, height, spacing, half):
    """The pressure under a rigid bar across a map, of mean 1: cells' means of 2/pi/sqrt(1 - (x/half)^2)."""
    edges = np.clip((np.arange(width + 1) - width / 2) * spacing / half, -1, 1)
    return np.diff(np.arcsin(edges)) * half / spacing * 2 / np.pi * np.ones((height, 1))


def edge_row(dermis, folder):
    width, height, spacing, depths = 200, 800, 5e-5, (3e-4, 5e-4, 1.6e-3)
    x = (np.arange(width) - width / 2 + 0.5) * spacing * 1e3
    figure, axes = plt.subplots(1, 2, figsize=(8, 2.8), sharey=True, constrained_layout=True)
    numbers = {}
    for axis, name, pressure in ((axes[0], "rigid", rigid_bar(width, height, spacing, 1.5e-3)),
                                 (axes[1], "even", np.ones((height, 1)) * (np.abs(x) < 1.5))):
        strains = below(dermis, pressure, spacing, depths, "strain")
        for depth, strain, colour in zip(depths, strains, (BLUE, VERMILLION, GREY)):
            line = strain[height // 2]
            centre = line[width // 2 - 1:width // 2 + 1].mean()
            numbers[f"{name}_bar_{depth * 1e3:g}_mm"] = line.max() / centre
            axis.plot(x, line / centre, color=colour, label=f"{depth * 1e3:g} mm deep")
        axis.set(xlim=(-4, 4))
        axis.set_title({"rigid": "under a rigid bar", "even": "under an even pressure"}[name], fontsize=9)
        axis.set_xlabel("mm from the middle", fontsize=9)
    axes[0].set_ylabel("strain over the middle's", fontsize=9)
    axes[0].legend(fontsize=8, frameon=False)
    save(figure, folder / "evidence_edges.png")
    rigid, even = ([numbers[f"{name}_bar_{d * 1e3:g}_mm"] for d in depths] for name in ("rigid", "even"))
    ours = "{:.1f}, {:.1f} and {:.1f} at 0.3, 0.5 and 1.6 mm; under an even pressure {:.2f}, {:.2f} and {:.2f}"
    return Row("Edges stand out for SA1, hardly for RA", "SA1 afferents answer far more to the edges of a bar than to "
               "its middle, RA afferents little more", "strain at an edge over the middle of a rigid bar of 3 mm: " +
               ours.format(*rigid, *even),
               rigid[0] > 2 and rigid[2] < 1.2, "`kernel = \"strain\"`, Poisson's ratio 0.4. The depths, 0.3 to 0.5 "
               "mm for SA1 and 1.6 mm for RA, are TouchSim's; row 7 speaks for shallower RA receptors. Without "
               "`receptors.depth` it is 1.0 in every class", "any product scene with `receptors.depth` and `kernel = "
               "\"strain\"`", "Phillips and Johnson 1981.", numbers, "evidence_edges.png")


def ridge_row(dermis):
    found = vibration.measure(dermis)
    return Row("Ridges as a filter of vibration", "a sensor with ridges of period lambda, under which a random "
               "texture slides at the speed v, vibrates most at v/lambda; without ridges nothing stands out",
               f"greatest power of FA2 at {found['peak']:.2f} v/lambda; power there over that of its flanks "
               f"{found['across']:.0f} with ridges across the slide, {found['along']:.2f} along it, "
               f"{found['even']:.2f} with an even contact",
               abs(found["peak"] - 1) < 0.05 and found["across"] > 100 and
               all(0.7 < found[w] < 1.5 for w in ("along", "even")),
               "Contact on crests and the stress at 2 mm do it together; with an even contact, or one cell for a "
               "receptor, ridges amplify nothing. Two textures here; the picture has six, and other speeds and ridges",
               "[fingerprint_vibration.toml](../host/examples/fingerprint_vibration.toml)", "Scheibert et al. 2009.",
               {f"ridges_{name}": value for name, value in found.items()}, "vibration.png")


def single_ridge_row(dermis):
    width, spacing, period = 240, 5e-5, 4.6e-4
    wave = 1 + np.cos(2 * np.pi * np.arange(width) * spacing / period) * np.ones((width, 1))
    line = below(dermis, wave, spacing, (4e-4,))[0][width // 2, 97:143]  # five periods
    left = 2 * abs((line * np.exp(-2j * np.pi * np.arange(46) * 5 / 46)).mean()) / line.mean()
    return Row("Single ridges",
               "the sensitive places of human FA1 and SA1 afferents are as fine as a ridge, some 0.4 mm",
               "without `receptors.depth` a receptor feels one cell, and all of a pattern of 0.46 mm is left; at 0.4 "
               f"mm {100 * left:.1f} %",
               False, "Cells that do not couple resolve any pattern, which is no finding about skin; a half-space "
               "resolves none so fine. `[[afferents]]` may have several endings, but no scene here lays them below "
               "ridges",
               "[receptors.toml](../host/examples/receptors.toml) with another depth of SA1", "Jarocka et al. 2021.",
               {"ridge_left_percent": 100 * left})


def flat_punch(width, height, spacing, radius, force):
    """The pressure (Pa) under a rigid flat punch at the cell (width/2, height/2): means of cells, by 40 lines."""
    lines = (np.arange(height * 40) + 0.5) / 40 - 0.5 - height // 2
    chord = np.sqrt(np.clip(radius**2 - (lines[:, None] * spacing) ** 2, 1e-30, None))
    edges = np.clip((np.arange(width + 1) - 0.5 - width // 2) * spacing / chord, -1, 1)
    inside = np.abs(lines[:, None]) * spacing < radius
    each = np.where(inside, np.diff(np.arcsin(edges), axis=1), 0) / (2 * np.pi * radius * spacing) * force
    return each.reshape(height, 40, width).mean(1)


def press_row(dermis):
    rows, source = data("press.csv", "Saal et al. 2017")
    width, height, spacing, radius, force = 132, 162, 1e-4, 1e-3, 0.119047
    y, x = np.mgrid[0:height, 0:width]
    even = (np.hypot(y - 81, x - 66) * spacing <= radius) * force / (np.pi * radius**2)
    depths = [float(r["depth_mm"]) * 1e-3 for r in rows]
    maps = below(dermis, even, spacing, (0, *depths))
    centre = below(dermis, flat_punch(width, height, spacing, radius, force), spacing, (depths[0],))[0][81, 66] / 1e3
    random, numbers, counts, cells, places = np.random.default_rng(1), {"punch_0.3_mm_kpa": centre}, [], [], {}
    for row, stress, density in zip(rows, maps[1:], (70, 140, 25)):  # per cm2, as the preset's
        count = round(density * width * height * spacing**2 * 1e4)
        at = places[row["class"]] = random.integers(0, height, count), random.integers(0, width, count)
        numbers[f"press_{row['class']}"] = int((stress[at] > 100).sum())
        counts.append(f"{numbers['press_' + row['class']]} of {count}")
        cells.append(int((maps[0][at] > 100).sum()))
    numbers |= {f"press_{row['class']}_cells": count for row, count in zip(rows, cells)}
    fires = evidence_spikes.fire_in_press(dermis, even, places)
    for name, some in zip(("preset", "sensitive"), fires):
        numbers |= {f"press_{kind}_{name}": count for kind, count in zip(places, some)}
    shares = [[count / len(at[0]) for count, at in zip(some, places.values())] for some in fires]
    texts = ["{:.0f}, {:.0f} and {:.0f} %".format(*(100 * share for share in some)) for some in shares]
    wanted = [float(row["fire"]) / float(row["of"]) for row in rows]
    return Row("Who answers a press", "TouchSim: 55 of 282 SA1, 27 of 573 RA and 70 of 100 PC fire (20, 5 and 70 %); "
               "20.3 kPa at 0.3 mm", f"of the preset's afferents {texts[0]} fire, of sensitive ones {texts[1]}. "
               f"More than 100 Pa at 0.3, 1.6 and 2 mm: {counts[0]} SA1, {counts[1]} FA1, {counts[2]} FA2, where cells "
               f"that do not couple have {cells[0]}, {cells[1]} and {cells[2]}; below a rigid punch {centre:.1f} kPa "
               "at 0.3 mm",
               any(np.allclose(some, wanted, atol=0.1) for some in shares),
               "The stress is TouchSim's; all three shares of afferents that fire are asked to be within 10 % of all "
               "afferents. Their endings lie at 0.3, 0.5 and 2 mm, as in the fit, and the press takes 50 ms. "
               "Sensitive FA1 afferents come close. Of SA1 those within 1.4 mm of the middle fire and no others; for "
               "FA2 TouchSim has waves that travel along the skin, which dermis does not have",
               "any scene with `[sites]`, `receptors.depth` and `[[afferents]]`", source, numbers)


def relaxation_row(dermis):
    rows, source = data("relaxation.csv", "Pawluk and Howe 1999, Wang et al. 2015")
    numbers, texts, agrees = {}, [], True
    for curve in ("fingerpad", "mouse_skin"):
        told = [float(r["value"]) for r in rows if r["curve"] == curve and r["quantity"] == "time_s"]
        text = subprocess.run([dermis, "fit", HERE.parent / f"host/examples/{curve}_relaxation.csv", "--elements",
                               str(len(told) + 1)], check=True, stdout=subprocess.PIPE, text=True).stdout
        found = [float(t) for t in re.findall(r"e\^\(-t/([^)]*)\)", text)]
        agrees &= np.allclose(found, told, rtol=0.01)
        numbers |= {f"{curve}_time_{i + 1}": t for i, t in enumerate(found)}
        texts.append(f"{curve.replace('_', ' ')}: {', '.join(f'{t:g}' for t in found)} s")
    return Row("Relaxation of skin", "fingerpads: 4 ms, 70 ms and 1.4 s; mouse skin: 0.19 s, of which 0.28 lasts",
               "`dermis fit` finds " + "; ".join(texts), bool(agrees), "By construction: the curves are computed from "
               "these numbers, because no measured curve may be copied. The preset takes the fingerpad's times; their "
               "shares are a choice",
               "[fingerpad.toml](../host/examples/fingerpad.toml)", source, numbers)


def page(rows):
    agree = sum(bool(row.agrees) for row in rows)
    head = f"""# Published results beside ours

What experiments and other models of touch found, and what dermis answers. {agree} of {len(rows)} agree; no row is left
out because it fails. [MODEL.md](../host/core/description/MODEL.md) says what the model is and is not. Afferents are
nerve fibres of the skin. Data and papers are listed at the end. This page is written by `./run evidence`. Its numbers
are compared with [expected.csv](evidence/expected.csv); the test `evidence` fails where one changes.

| # | published | dermis | verdict |
|---|---|---|---|
"""
    head += "".join(f"| {n} | {r.title}: {r.published} | {r.ours} | {r.verdict} |\n" for n, r in enumerate(rows, 1))
    head += ("\nThresholds agree within 2 dB rms, a change of SA1 within 10 %, rates where R2 is above 0.9 in all "
             "classes; rows 6, 8, 10, 13 and 14 say what they ask for.\n")
    for n, row in enumerate(rows, 1):
        picture = f"\n![{row.title}]({row.picture})\n" if row.picture else ""
        head += (f"\n## {n}. {row.title}\n{picture}\n- Published: {row.published}. {row.source}"
                 f"\n- dermis: {row.ours}.\n- Verdict: {row.verdict}. {row.why}.\n- Scene: {row.scene}.\n")
    head += "\n## Data\n\n"
    for name in FILES:
        text = " ".join(line[2:] for line in lines_of(name) if line.startswith("#"))
        head += f"- [{name}](evidence/{name}): {text}\n"
    missing = [name for name in SOURCES if name not in head]
    assert not missing, f"no row and no data are of {missing}"
    return head + "\n## Sources\n\n" + "".join(f"- {name}: {text}.\n" for name, text in SOURCES.items())


def changed(numbers, path):
    """What is not as expected, in words."""
    with open(path, newline="") as file:
        expected = {row["name"]: row for row in csv.DictReader(line for line in file if not line.startswith("#"))}
    wrong = [f"{name} = {numbers.get(name)}; {path} has {expected.get(name, {}).get('value')}"
             for name in sorted(set(numbers) ^ set(expected))]
    for name in sorted(set(numbers) & set(expected)):
        value, allowed = float(expected[name]["value"]), float(expected[name]["tolerance"])
        if not abs(numbers[name] - value) <= allowed:
            wrong.append(f"{name} = {numbers[name]:.6g}; {path} has {value:g} +- {allowed:g}")
    return wrong


def main():
    options = argparse.ArgumentParser()
    options.add_argument("dermis")
    options.add_argument("folder", type=Path)
    options.add_argument("--expected", default=DATA / "expected.csv")
    options = options.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    dermis = str(Path(options.dermis).resolve())
    rows = [*threshold_rows(dermis, options.folder), adaptation_row(dermis), edge_row(dermis, options.folder),
            ridge_row(dermis), single_ridge_row(dermis), press_row(dermis),
            evidence_spikes.rates_row(dermis, options.folder), evidence_spikes.edge_pass_row(dermis),
            relaxation_row(dermis), evidence_spikes.fitted_thresholds_row(dermis),
            evidence_spikes.entrainment_row(dermis), evidence_spikes.touchsim_row(dermis)]
    (options.folder / "EVIDENCE.md").write_text(page(rows))
    numbers = {name: value for row in rows for name, value in row.numbers.items()}
    for row in rows:
        print(f"{row.title}: {row.ours}: {row.verdict.strip('*')}")
    wrong = changed(numbers, options.expected)
    if wrong:
        sys.exit("evidence: numbers that are not as expected:\n" + "\n".join(wrong))


if __name__ == "__main__":
    main()
