# SPDX-License-Identifier: MIT
"""The rows of the page EVIDENCE.md whose numbers are of spikes, which the command dermis computes: see evidence.py."""
import tempfile
from concurrent.futures import ThreadPoolExecutor
from statistics import NormalDist

import matplotlib.pyplot as plt
import numpy as np

import touchsim
from drawing import BLUE, GREEN, GREY, VERMILLION
from rows import CLASSES, DEPTHS, Row, data, fitted, preset, r2, save
from runs import afferents_of, fire, run, scene

RADIUS = 0.5e-3  # m, of the probe
WAIT = 0.2  # s after which a response to a sine is periodic
# The logarithms of the gains of seven afferents, of equal weight, over the spread, as in fit_afferents.py.
NODES = np.array([NormalDist().inv_cdf((i + 0.5) / 7) for i in range(7)])
NODES /= NODES.std()


def gains(kind, factor):
    """The gains of a class times a factor, as a key of [[afferents]]."""
    values = fitted(kind)
    return f"gains = {[[factor * values.get(f'gains[{j}][{k}]', 0.0) for k in (0, 1)] for j in (0, 1)]}"


def strains(kind, um):
    """The strains at the depth of a class below a probe that moves by amplitudes in um."""
    return touchsim.strain_below(DEPTHS[kind], RADIUS) * 1e-6 * np.asarray(um)


def sine_spikes(dermis, kind, hz, um, seconds, wait=WAIT, sensitivity="median"):
    """The number of spikes from `wait` on for so many seconds: of the median afferent, unless a
    sensitivity is given, for each amplitude of a sine."""
    load = f'envelope = "sine"\nmean = 0\nfrequency = {float(hz)}'
    times = fire(dermis, strains(kind, um), load, wait + seconds, [(preset(kind, sensitivity), range(len(um)))])
    return np.array([(t >= wait).sum() for t in times])


def side_by_side(function, arguments):
    with ThreadPoolExecutor(2) as pool:
        return list(pool.map(lambda each: function(*each), arguments))


def mean_rates(dermis, kind, hz, um):
    """Mean rates (Hz) of seven afferents. The current is proportional to q: an afferent's gain scales the amplitude."""
    factors = np.exp(fitted(kind)["spread"] * NODES)
    return sine_spikes(dermis, kind, hz, np.outer(um, factors).ravel(), 1.0).reshape(-1, len(NODES)).mean(1)


def rates_row(dermis, folder):
    figure, axes = plt.subplots(1, 3, figsize=(9, 3), constrained_layout=True)
    numbers, texts = {}, []
    for axis, kind in zip(axes, CLASSES):
        table = np.array([[float(row[key]) for key in ("hz", "um", "rate")] for row in data("rates.csv")
                          if row["class"] == kind])
        parts = [table[table[:, 0] == hz] for hz in np.unique(table[:, 0])]
        ours = side_by_side(mean_rates, [(dermis, kind, part[0, 0], part[:, 1]) for part in parts])
        for part, rates, colour in zip(parts, ours, (GREY, BLUE, GREEN, VERMILLION, "black")):
            axis.semilogx(part[:, 1], rates, color=colour, label=f"{part[0, 0]:g} Hz")
            axis.semilogx(part[:, 1], part[:, 2], "o", color=colour, markersize=3)
        axis.set_title(f"{kind.upper()} afferents: spikes per second", fontsize=9)
        axis.set_xlabel("amplitude (µm)", fontsize=9)
        wanted, found = np.concatenate(parts)[:, 2], np.concatenate(ours)
        numbers[f"rates_{kind}_r2"] = r2(found, wanted)
        numbers[f"rates_{kind}_rms"] = float(np.sqrt(((found - wanted)**2).mean()))
        texts.append(f"{kind.upper()} {numbers[f'rates_{kind}_rms']:.1f} Hz rms")
    axes[0].legend(fontsize=8, frameon=False)
    save(figure, folder / "evidence_rates.png")
    return Row(numbers, "evidence_rates.png", {"texts": "; ".join(texts)})


def held_out(dermis, stimulus, times, waves):
    """The R2 of the mean rates of each class. waves: of each pair of frequencies its stimulus of amplitude 1 at times
    (s), from which on rates are counted for a second."""
    numbers = {}
    for kind in CLASSES:
        rows = [row for row in data("heldout.csv") if (row["class"], row["stimulus"]) == (kind, stimulus)]
        factors, found = np.exp(fitted(kind)["spread"] * NODES), []
        for low, high in dict.fromkeys((float(row["low"]), float(row["high"])) for row in rows):
            um = [float(row["um"]) for row in rows if float(row["low"]) == low and float(row["high"]) == high]
            cells = strains(kind, np.outer(um, factors).ravel())
            spikes = fire(dermis, np.outer(waves(low, high), cells), "", times[-1], [(preset(kind), range(len(cells)))],
                          times[1])
            found.extend(np.array([(t >= times[-1] - 1).sum() for t in spikes]).reshape(-1, len(factors)).mean(1))
        numbers[f"{stimulus}_{kind}_r2"] = r2(np.array(found), np.array([float(row["rate"]) for row in rows]))
    return numbers


def noise_row(dermis, folder):
    count, step, random = 20000, 5e-5, np.random.default_rng(1)
    hz = np.fft.rfftfreq(count, step)

    def noise(low, high):
        spectrum = np.where((hz >= low) & (hz <= high), random.normal(size=len(hz)) + 1j * random.normal(size=len(hz)), 0)
        wave = np.fft.irfft(spectrum, count)
        return np.append(wave, wave[:4001]) / np.sqrt((wave**2).mean())

    return Row(held_out(dermis, "noise", np.arange(count + 4001) * step, noise))


def pairs_row(dermis, folder):
    times = np.arange(40001) * 2.5e-5
    return Row(held_out(dermis, "pair", times, lambda low, high: np.sin(2 * np.pi * low * times) + np.sin(2 * np.pi * high * times)))


def lowest(dermis, kind, hz, um):
    """The lowest of some amplitudes at which a sensitive afferent fires once the response to the sine is periodic."""
    counts = sine_spikes(dermis, kind, hz, um, max(0.1, 1.5 / hz), max(WAIT, 1 / hz), "threshold")
    assert counts[0] == 0 and counts[-1] > 0, f"{kind}, {hz} Hz: no threshold from {um[0]:.4g} to {um[-1]:.4g} um"
    return um[np.argmax(counts > 0)]


def thresholds_row(dermis, folder):
    numbers = {}
    for kind in CLASSES:
        hz, um = np.array([(float(r["hz"]), float(r["um"])) for r in data("thresholds.csv") if r["class"] == kind]).T
        ladders = um[:, None] * np.geomspace(0.25, 4, 400)
        found = side_by_side(lowest, [(dermis, kind, f, ladder) for f, ladder in zip(hz, ladders)])
        decibels = 20 * np.log10(np.array(found) / um)
        numbers[f"threshold_{kind}_rms_db"] = float(np.sqrt((decibels**2).mean()))
    away = {f"{kind}_away": np.log(fitted(kind)["threshold_gain"]) / fitted(kind)["spread"] for kind in ("sa1", "pc")}
    return Row(numbers, told={"factors": ", ".join(f"{fitted(kind)['threshold_gain']:.2g}" for kind in CLASSES), **away})


def entrained(dermis, kind, hz):
    """The first and last amplitude with exactly one spike per cycle, over the threshold; the last is None where the
    greatest amplitude, 1 mm, has one too."""
    um = np.geomspace(0.1, 1000, 1000)
    counts = sine_spikes(dermis, kind, hz, um, 1.0)
    one, least = np.flatnonzero(counts == hz), um[np.argmax(counts > 0)]
    assert len(one) and np.all(np.diff(one) == 1), f"{kind}, {hz} Hz: one spike per cycle at the amplitudes {um[one]}"
    return um[one[0]] / least, um[one[-1]] / least if one[-1] < len(um) - 1 else None


def ramp_row(dermis, folder):
    return Row({"ramp_ra": entrained(dermis, "ra", 40)[0], "ramp_pc": entrained(dermis, "pc", 200)[0]})


def plateau_row(dermis, folder):
    (first, last), (_, last_pc) = entrained(dermis, "ra", 40), entrained(dermis, "pc", 200)
    assert last is not None and last_pc is None, f"one spike per cycle up to {last} and {last_pc} times the threshold"
    return Row({"plateau_ra": last / first}, told={"first": first, "last": last})


def hold_row(dermis, folder):
    load = 'envelope = "table"\ntimes = [0, 0.05]\nvalues = [0, 1]'
    mm = (0.5, 1.0, 1.5)
    tables = [(preset("sa1"), range(3)), ('type = "sa1"', [1] * 400)]
    found = fire(dermis, strains("sa1", np.array(mm) * 1e3), load, 1.0, tables)
    held = [((t > 0.3) & (t <= 1)).sum() / 0.7 for t in found]
    rates, drawn = held[:3], np.array(held[3:])
    units = {d: [((t > 0.3) & (t <= 1)).sum() / 0.7 for t in
                 (touchsim.recursion(("SA1", i), touchsim.probe("ramp", 0, d, touchsim.STEP)) for i in range(4))] for d in mm}
    told = ", ".join(f"{min(u):.0f} to {max(u):.0f}" for u in units.values())
    return Row({"hold_sa1": float(rates[1]), "hold_sa1_silent": float(np.mean(drawn == 0)), "hold_sa1_mean": float(drawn.mean())},
               told={"rates": rates, "units": told, "silent": 100 * np.mean(drawn == 0)})


def units_row(dermis, folder):
    wanted, refined = touchsim.published(), touchsim.published(step=touchsim.FINE)
    found = touchsim.spikes(dermis, touchsim.units())
    numbers, texts = {}, []
    for kind in ("SA1", "RA"):
        mine = [key for key in wanted if key[0][0] == kind]
        spikes = sum(len(wanted[key]) for key in mine)
        share, same = (100 * sum(touchsim.within(wanted[key], other[key], 1e-3) for key in mine) / spikes
                       for other in (found, refined))
        numbers[f"touchsim_{kind.lower()}_share"] = share
        texts.append(f"TouchSim's own {kind} units at 10 us in place of 0.2 ms: {same:.0f} %")
    return Row(numbers, told={"texts": "; ".join(texts)})


def pressed(dermis, pressure, load, duration, sites, tables, texture=None):
    """For each afferent its line of afferents.csv and its spikes (s), where a map of pressures acts. sites: the text of [sites]; tables:
    that of each [[afferents]], of afferents at all sites of its class."""
    height, width = pressure.shape
    texts = "".join("[[afferents]]\n" + text + "\n" for text in tables)
    text = scene("press", width=width, height=height, load=load, duration=duration, sites=sites, afferents=texts)
    with tempfile.TemporaryDirectory() as folder:
        files = {"pressure": pressure} if texture is None else {"pressure": pressure, "texture": texture}
        return afferents_of(run(dermis, text, folder, **files))


HELD = 'envelope = "table"\ntimes = [0, 0.05, 0.95, 1]\nvalues = [0, 1, 1, 0]'


def fire_by_distance(dermis, pressure, kernel):
    """The distance (mm) of FA2 afferents, 16 times as dense as the preset's, from the middle of a map of pressures that
    rises within 50 ms, is held and falls; and whether each fires, with the median's sensitivity and the class's spread."""
    table = f'type = "fa2"\nsensitivity = "median"\n[receptors.kernel]\nfa2 = "{kernel}"'
    spikes = pressed(dermis, pressure, HELD, 1.05, "density = { fa2 = 400 }", [table])
    height, width = pressure.shape
    places = np.array([(float(row["x"]) - width // 2, float(row["y"]) - height // 2) for row, _ in spikes])
    return np.hypot(*places.T) * 0.1, np.array([len(times) > 0 for _, times in spikes])


def fire_in_press(dermis, pressure):
    """The share (%) of the afferents of each class that fire, where a pressure rises within 50 ms, is held and falls: of
    single endings like the median's, and of afferents with the fields of row:fields and the sensitivities and their
    spread that dermis gives."""
    fields = [f'type = "{CLASSES[kind]}"' + "".join(f"\n{key} = {fitted(kind)[key]:.7g}" for key in ("endings", "radius")
                                                  if key in fitted(kind)) for kind in CLASSES]
    shares = []
    for tables in ([preset(kind) for kind in CLASSES], fields):
        spikes = pressed(dermis, pressure, HELD, 1.05, "density = { sa1 = 70, fa1 = 140, fa2 = 25 } # per cm2, as the preset's",
                         tables)
        fires = {kind: [len(times) > 0 for row, times in spikes if row["class"] == of] for kind, of in CLASSES.items()}
        shares.append({kind: 100 * float(np.mean(some)) for kind, some in fires.items()})
    return shares


def edge_pass(dermis, force, endings):
    """Spikes (s) of the median and of a sensitive FA1 afferent while an edge of 6 mm by 0.5 mm, pressed with a force (N),
    slides at 30 mm/s over their endings, which lie 1 mm apart along its way; and of one with the sensitivity of row:fields."""
    edge = np.zeros((60, 240))  # it repeats itself after 24 mm, which take 0.8 s
    edge[:, 180:186] = np.array([0.5, 1, 1, 1, 1, 0.5]) * force / (6e-3 * 0.5e-3)
    tables = [f"{preset('ra')}\nendings = {endings}\n{gains('ra', factor)}"
              for factor in (1, fitted("ra")["threshold_gain"], fitted("ra")["field_gain"])]
    tables = [f"{table}\ncells = {[[60 + 10 * n - 5 * (endings - 1), 30] for n in range(endings)]}" for table in tables]
    load = '[load.texture]\npath = "texture.npy"\nvelocity = [0.03, 0]'
    return [times for _, times in pressed(dermis, np.ones((60, 120)), load, 0.8, "", tables, edge)]


def edges_row(dermis, folder):
    forces = [float(row["force"]) for row in data("edges.csv")]
    force, endings, numbers, texts = 0.05, 5, {}, []
    for name, times in zip(("edge", "edge_sensitive", "edge_field"), edge_pass(dermis, force, endings)):
        apart = np.diff(times) * 1e3
        ours = (len(times), np.median(apart), 1e3 / apart.min(), (times[-1] - times[0]) * 1e3)
        numbers |= {f"{name}_{key}": float(value) for key, value in zip(("spikes", "interval_ms", "peak_hz", "length_ms"), ours)}
        texts.append("{:.0f} spikes, {:.1f} ms apart, up to {:.0f} Hz, within {:.0f} ms".format(*ours))
    fields = numbers["edge_field_spikes"], numbers["edge_field_interval_ms"]
    assert fields[0] > 20 and fields[1] < 6, "the sensitivity of row:fields gives what is asked for"
    return Row(numbers, told={"texts": texts, "force": force, "endings": endings, "least": min(forces), "most": max(forces)})
