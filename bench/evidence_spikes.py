# SPDX-License-Identifier: MIT
"""The rows of the page EVIDENCE.md whose numbers are of spikes, which the command dermis computes: see evidence.py."""
import csv
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from statistics import NormalDist

import matplotlib.pyplot as plt
import numpy as np

import touchsim
from evidence_row import BLUE, GREEN, GREY, VERMILLION, Row, data, fire, run, save

CLASSES = {"sa1": "sa1", "ra": "fa1", "pc": "fa2"}  # of the data, and what dermis calls them
DEPTHS = {"sa1": 0.3e-3, "ra": 0.5e-3, "pc": 2e-3}  # m, those of the fit
RADIUS = 0.5e-3  # m, of the probe
WAIT = 0.2  # s after which a response to a sine is periodic
# The logarithms of the gains of seven afferents, of equal weight, over the spread, as in fit_afferents.py.
NODES = np.array([NormalDist().inv_cdf((i + 0.5) / 7) for i in range(7)])
NODES /= NODES.std()
PRESS = """
[grid]
width = {width}
height = {height}
spacing = 1e-4
[surface]
kind = "flat"
relief = 1e-5
[material]
modulus = 5e4 # Pa, of TouchSim
viscosity = 0
thickness = 1e-3
curvature_length = 0
[load]
kind = "file"
path = "pressure.npy"
{load}
[receptors.depth]
sa1 = 0.3e-3
fa1 = 0.5e-3
fa2 = 2e-3
[sites]
path = "sites.csv"
{afferents}
[time]
step = 1e-3
duration = {duration}
[output]
traces = []
"""


def fitted():
    """The numbers of afferents.csv for each class."""
    found = {kind: {} for kind in CLASSES}
    for row in data("afferents.csv", "")[0]:
        found[row["class"]][row["parameter"]] = float(row["value"])
    return found


def gains(kind, factor):
    """The gains of a class times a factor, as a key of [[afferents]]."""
    values = fitted()[kind]
    return f"gains = {[[factor * values.get(f'gains[{j}][{k}]', 0.0) for k in (0, 1)] for j in (0, 1)]}"


def preset(kind):
    return f'type = "{CLASSES[kind]}"'


def strains(kind, um):
    """The strains at the depth of a class below a probe that moves by amplitudes in um."""
    return touchsim.strain_below(DEPTHS[kind], RADIUS) * 1e-6 * np.asarray(um)


def sine_spikes(dermis, kind, hz, um, seconds, wait=WAIT):
    """The number of spikes from `wait` on for so many seconds: of a preset afferent for each amplitude of a sine."""
    load = f'envelope = "sine"\nmean = 0\nfrequency = {float(hz)}'
    times = fire(dermis, strains(kind, um), load, wait + seconds, [(preset(kind), range(len(um)))])
    return np.array([(t >= wait).sum() for t in times])


def side_by_side(function, arguments):
    with ThreadPoolExecutor(2) as pool:
        return list(pool.map(lambda each: function(*each), arguments))


def mean_rates(dermis, kind, hz, um):
    """Mean rates (Hz) of seven afferents. The current is proportional to q: an afferent's gain scales the amplitude."""
    factors = np.exp(fitted()[kind]["spread"] * NODES)
    return sine_spikes(dermis, kind, hz, np.outer(um, factors).ravel(), 1.0).reshape(-1, len(NODES)).mean(1)


def rates_row(dermis, folder):
    rows, source = data("rates.csv", "Muniak et al. 2007")
    figure, axes = plt.subplots(1, 3, figsize=(9, 3), constrained_layout=True)
    numbers, texts = {}, []
    for axis, kind in zip(axes, CLASSES):
        table = np.array([[float(row[key]) for key in ("hz", "um", "rate")] for row in rows if row["class"] == kind])
        parts = [table[table[:, 0] == hz] for hz in np.unique(table[:, 0])]
        ours = side_by_side(mean_rates, [(dermis, kind, part[0, 0], part[:, 1]) for part in parts])
        for part, rates, colour in zip(parts, ours, (GREY, BLUE, GREEN, VERMILLION, "black")):
            axis.semilogx(part[:, 1], rates, color=colour, label=f"{part[0, 0]:g} Hz")
            axis.semilogx(part[:, 1], part[:, 2], "o", color=colour, markersize=3)
        axis.set_title(f"{kind.upper()} afferents: spikes per second", fontsize=9)
        axis.set_xlabel("amplitude (µm)", fontsize=9)
        wanted, away = np.concatenate(parts)[:, 2], np.concatenate(ours) - np.concatenate(parts)[:, 2]
        numbers[f"rates_{kind}_r2"] = float(1 - (away**2).sum() / ((wanted - wanted.mean())**2).sum())
        numbers[f"rates_{kind}_rms"] = float(np.sqrt((away**2).mean()))
        texts.append(f"{kind.upper()}: R2 {numbers[f'rates_{kind}_r2']:.3f}, {numbers[f'rates_{kind}_rms']:.1f} Hz rms")
    axes[0].legend(fontsize=8, frameon=False)
    save(figure, folder / "evidence_rates.png")
    return Row("Mean rates by amplitude", "rates of SA1, RA and PC afferents at five frequencies and 15 amplitudes",
               "; ".join(texts), all(numbers[f"rates_{kind}_r2"] > 0.9 for kind in CLASSES),
               "This is a fit and no prediction: up to nine numbers of each class are fitted to these 75 points, to "
               "thresholds and to shares of afferents that fire ([afferents.csv](#data)). A rate is the mean over "
               "seven afferents with the fitted spread of gains",
               "one cell and `[[afferents]]` with a class alone, the load a sine", source, numbers,
               "evidence_rates.png")


def lowest(dermis, kind, hz, um):
    """The lowest of some amplitudes at which a preset afferent fires once the response to the sine is periodic."""
    counts = sine_spikes(dermis, kind, hz, um, max(0.1, 1.5 / hz), max(WAIT, 1 / hz))
    assert counts[0] == 0 and counts[-1] > 0, f"{kind}, {hz} Hz: no threshold from {um[0]:.4g} to {um[-1]:.4g} um"
    return um[np.argmax(counts > 0)]


def fitted_thresholds_row(dermis):
    rows, source = data("thresholds.csv", "Ouyang et al. 2021")
    numbers, texts = {}, []
    for kind in CLASSES:
        hz, um = np.array([(float(r["hz"]), float(r["um"])) for r in rows if r["class"] == kind]).T
        ladders = um[:, None] * fitted()[kind]["threshold_gain"] * np.geomspace(0.25, 4, 400)
        found = side_by_side(lowest, [(dermis, kind, f, ladder) for f, ladder in zip(hz, ladders)])
        decibels = 20 * np.log10(np.array(found) / fitted()[kind]["threshold_gain"] / um)
        numbers[f"threshold_{kind}_rms_db"] = float(np.sqrt((decibels**2).mean()))
        texts.append(f"{kind.upper()} {numbers[f'threshold_{kind}_rms_db']:.1f}")
    factors = ", ".join(f"{fitted()[kind]['threshold_gain']:.2g}" for kind in CLASSES)
    return Row("Thresholds of the fitted afferents", "the points of rows 1 to 3",
               f"dB rms: {', '.join(texts)}, after one factor per class", all(n < 2 for n in numbers.values()),
               f"The afferents of the thresholds are more sensitive than the preset's, by factors of {factors}. The "
               "pair of poles and the membrane give PC the fall at high frequencies that row 2 lacks, and SA1 is "
               "closer than in row 3, because it follows strain and rate. RA is further off than in row 1, because "
               "the same filter must give the rates of row 9. SA1 and RA are off most at the highest frequencies",
               "as row 9", source,
               numbers)


def entrained(dermis, kind, hz):
    """The first and last amplitude with exactly one spike per cycle, over the threshold; the last is None where the
    greatest amplitude, 1 mm, has one too."""
    um = np.geomspace(0.1, 1000, 1000)
    counts = sine_spikes(dermis, kind, hz, um, 1.0)
    one, least = np.flatnonzero(counts == hz), um[np.argmax(counts > 0)]
    assert len(one) and np.all(np.diff(one) == 1), f"{kind}, {hz} Hz: one spike per cycle at the amplitudes {um[one]}"
    return um[one[0]] / least, um[one[-1]] / least if one[-1] < len(um) - 1 else None


def entrainment_row(dermis):
    (first, last), (first_pc, last_pc) = entrained(dermis, "ra", 40), entrained(dermis, "pc", 200)
    assert last is not None and last_pc is None, f"one spike per cycle up to {last} and {last_pc} times the threshold"
    return Row("One spike per cycle", "as the amplitude grows, the rate of an afferent stays at one spike per cycle "
               "over a range of amplitudes, a plateau",
               f"RA at 40 Hz: from {first:.2f} to {last:.2f} times the threshold; PC at 200 Hz: from {first_pc:.2f} "
               "times the threshold on, up to 1 mm",
               bool(20 * np.log10(last / first) > 3),
               "That there are plateaus is compared, and 3 dB asked for; the widths of single afferents in the paper "
               "are not. The PC afferent cannot fire twice in a cycle, because the fit gives no gain to the other "
               "half of it: at great amplitudes real afferents may", "as row 9, with 1000 amplitudes",
               "Freeman and Johnson 1982.",
               {"entrained_ra_first": first, "entrained_ra_last": last, "entrained_pc_first": first_pc})


def touchsim_row(dermis):
    wanted = touchsim.published()
    found = touchsim.spikes(dermis, {name: unit["model"] for name, unit in touchsim.units().items()})
    numbers, texts, agrees = {}, [], True
    for kind in ("SA1", "RA"):
        share, first, of_first, rates, of_rates, away = touchsim.totals(wanted, found, kind)
        numbers |= {f"touchsim_{kind.lower()}_{key}": value for key, value in
                    (("share", float(share)), ("first", first), ("rates", rates), ("away", away))}
        texts.append(f"{kind}: {rates} of {of_rates} rates within 1 Hz, the others within {away}, {first} of "
                     f"{of_first} first spikes and {100 * share:.0f} % of all spikes within 0.25 ms")
        agrees &= rates == of_rates and first == of_first and share > 0.9
    return Row("Spikes of TouchSim's units", "the units SA1 0 to 3 and RA 0, 1, 4 and 6, without noise, below a probe "
               "of 1 mm: two presses and 12 sines", "; ".join(texts), agrees,
               "All rates, all first spikes and 90 % of the spikes are asked for. Each spike moves the spikes that "
               "follow it, so that the step of TouchSim's own method matters too: at 10 us in place of 0.2 ms it has "
               "18 % (SA1) and 57 % (RA) of its spikes where they were. Filter and gains are TouchSim's; a reset and "
               "two currents after a spike are fitted in place of its post-spike current", "`bench/touchsim.py` writes it and prints all numbers", "Saal et al. 2017, "
               "whose method is written anew in `bench/touchsim.py`.", numbers)


def pressed(dermis, pressure, load, duration, places, tables, texture=None):
    """For each afferent its spikes (s), where a map of pressures acts. places: for each class the rows and columns of
    its endings; tables: the text of each [[afferents]], of afferents at all places of its class."""
    height, width = pressure.shape
    texts = "".join("[[afferents]]\n" + text + "\n" for text in tables)
    scene = PRESS.format(width=width, height=height, load=load, duration=duration, afferents=texts)
    sites = [f"{CLASSES[kind]},{x},{y}" for kind, (rows, columns) in places.items() for y, x in zip(rows, columns)]
    with tempfile.TemporaryDirectory() as folder:
        np.save(f"{folder}/pressure.npy", pressure)
        Path(folder, "sites.csv").write_text("\n".join(["type,x,y", *sites, ""]))
        if texture is not None:
            np.save(f"{folder}/texture.npy", texture)
        out = run(dermis, scene, folder)
        spikes = np.load(out / "spikes.npy")
        with open(out / "afferents.csv", newline="") as file:
            count = len(list(csv.DictReader(file)))
    return [spikes["time"][spikes["afferent"] == n] for n in range(count)]


def fire_in_press(dermis, pressure, places):
    """How many afferents of each class fire, of the preset's and of sensitive ones, where a pressure rises within 50
    ms, is held and falls. places: for each class the rows and columns of its endings."""
    load = 'envelope = "table"\ntimes = [0, 0.05, 0.95, 1]\nvalues = [0, 1, 1, 0]'
    ends = np.cumsum([len(rows) for rows, _ in places.values()])[:-1]
    found = []
    for sensitive in (False, True):
        factors = {kind: fitted()[kind]["threshold_gain"] if sensitive else 1 for kind in places}
        tables = [f"{preset(kind)}\n{gains(kind, factor)}" for kind, factor in factors.items()]
        fires = [len(times) > 0 for times in pressed(dermis, pressure, load, 1.05, places, tables)]
        found.append([int(part.sum()) for part in np.split(np.array(fires), ends)])
    return found


def edge_pass(dermis, force, endings):
    """Spikes (s) of a preset and of a sensitive FA1 afferent while an edge of 6 mm by 0.5 mm, pressed with a force (N),
    slides at 30 mm/s over their endings, which lie 1 mm apart along its way."""
    edge = np.zeros((60, 240))  # it repeats itself after 24 mm, which take 0.8 s
    edge[:, 180:186] = np.array([0.5, 1, 1, 1, 1, 0.5]) * force / (6e-3 * 0.5e-3)
    tables = [f"{preset('ra')}\nendings = {endings}\n{gains('ra', factor)}"
              for factor in (1, fitted()["ra"]["threshold_gain"])]
    columns = [60 + 10 * n - 5 * (endings - 1) for n in range(endings)]
    load = '[load.texture]\npath = "texture.npy"\nvelocity = [0.03, 0]'
    return pressed(dermis, np.ones((60, 120)), load, 0.8, {"ra": ([30] * endings, columns)}, tables, edge)


def edge_pass_row(dermis):
    rows, source = data("edges.csv", "Hay and Pruszynski 2020")
    keys = "spikes", "interval_ms", "peak_hz", "length_ms"
    published = np.array([[float(row[key]) for key in keys] for row in rows])
    forces = [float(row["force"]) for row in rows]
    least, most = published.min(0), published.max(0)
    told = [f"{m:.0f} ({a:.0f} to {b:.0f})" for a, m, b in zip(least, np.median(published, 0), most)]
    force, endings, numbers, texts, agrees = 0.05, 5, {}, [], True
    one = [len(times) for times in edge_pass(dermis, force, 1)]
    for name, times in zip(("preset", "sensitive"), edge_pass(dermis, force, endings)):
        apart = np.diff(times) * 1e3
        ours = np.array([len(times), np.median(apart), 1e3 / apart.min(), (times[-1] - times[0]) * 1e3])
        agrees &= bool(np.all((ours >= least) & (ours <= most)))
        numbers |= {f"edge_{name}_{key}": float(value) for key, value in zip(keys, ours)}
        text = "the {} afferent {:.0f} spikes, {:.1f} ms apart, up to {:.0f} Hz, within {:.0f} ms"
        texts.append(text.format(name, *ours))
    return Row("15 human FA1 afferents under sliding edges", f"in a pass of an edge at 30 mm/s, {told[0]} spikes, "
               f"{told[1]} ms apart, up to {told[2]} Hz, within {told[3]} ms: the median of the afferents, the least "
               "and the greatest",
               f"an edge of 6 mm by 0.5 mm, {force} N, and afferents with {endings} endings, 1 mm apart: " +
               "; ".join(texts), agrees,
               "All four numbers are asked to be in the afferents' range. The edge reaches one ending for a "
               f"millimetre, so that an afferent with a single ending fires {one[0]} or {one[1]} times and is silent "
               "before and after. The force is chosen for the number of spikes, and the endings' distance for the "
               f"duration, so that intervals and rates are compared; the contact forces in the data, {min(forces):.1f} "
               f"to {max(forces):.1f}, which must be N, are of a whole fingertip. Spikes are not compared one by one",
               f"flat skin of 50 kPa, a texture of one edge, the stress at 0.5 mm, `[[afferents]]` of class `fa1` with "
               f"`endings = {endings}`", source, numbers)
