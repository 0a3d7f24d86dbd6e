# SPDX-License-Identifier: MIT
"""The rows of the page EVIDENCE.md about places: fields, spheres, a bar, dots, gratings, strokes. See evidence.py."""
import csv
import tempfile
from pathlib import Path

import numpy as np

import vibration
from evidence_row import Row, data, fire, run
from evidence_spikes import CLASSES, DEPTHS, NODES, fitted, preset, r2

SKIN = """
preset = "fingertip"
[grid]
width = {width}
height = {width}
spacing = {spacing}
[surface]
kind = "flat"
{load}
[receptors]
depth = {{ {type} = {depth} }}
[sites]
path = "sites.csv"
[[afferents]]
{afferents}
[time]
step = 1e-3
duration = {duration}
[output]
traces = []
"""


def discs(kind, centres, width, spacing, random=None):
    """Sites, as text, of afferents around centres (cells): their endings, drawn for each centre, or once for all of them
    if no random numbers are given."""
    count, radius = int(fitted()[kind]["endings"]), fitted()[kind]["radius"] / spacing
    lines, once = ["type,x,y"], random is None
    random = random or np.random.default_rng(5)
    for n, (x, y) in enumerate(centres):
        if n == 0 or not once:
            r, angle = radius * np.sqrt(random.uniform(size=count)), 2 * np.pi * random.uniform(size=count)
        cells = np.clip(np.rint(np.array([x + r * np.cos(angle), y + r * np.sin(angle)])), 0, width - 1).astype(int)
        lines += [f"{CLASSES[kind]},{a},{b}" for a, b in cells.T]
    return "\n".join([*lines, ""])


def keys(kind):
    """The afferent of a class, with the endings and the sensitivity of the published fields."""
    values = fitted()[kind]
    return f'type = "{CLASSES[kind]}"\nsensitivity = {values["field_gain"]}\nspread = 0\nendings = {values["endings"]:.0f}'


def field_areas(dermis, kind, um, width=200, spacing=5e-5, apart=8):
    """The areas (mm2) of the field of 529 afferents at a probe of 0.5 mm: the share that fires, each at another place of
    the probe and with other endings, times the area of all places."""
    middles = np.arange(-88, 89, apart) + width // 2
    load = ('[load]\nkind = "punch"\ncontrol = "depth"\nradius = 5\nintensity = 1e-3\nenvelope = "ramp"\nrise = 0.01')
    areas = []
    with tempfile.TemporaryDirectory() as folder:
        places = [(x, y) for y in middles for x in middles]
        Path(folder, "sites.csv").write_text(discs(kind, places, width, spacing, np.random.default_rng(5)))
        scene = SKIN.format(width=width, spacing=spacing, load=load, type=CLASSES[kind], depth=DEPTHS[kind], afferents=keys(kind),
                            duration=0.2)
        for depth in um:
            out = run(dermis, scene, folder, "--set", f"load.intensity={depth * 1e-6}")
            with open(out / "afferents.csv", newline="") as file:
                fires = sum(int(row["spikes"]) > 0 for row in csv.DictReader(file))
            areas.append(fires * (apart * spacing * 1e3)**2)
    return np.array(areas)


def fields_row(dermis, folder):
    numbers, texts = {}, []
    for kind in ("sa1", "ra"):
        um, wanted = np.array([(float(r["um"]), float(r["mm2"])) for r in data("fields.csv") if r["class"] == kind]).T
        ours = field_areas(dermis, kind, um)
        numbers |= {f"field_{kind}_rms": float(np.sqrt((np.log(ours / wanted)**2).mean()))}
        numbers |= {f"field_{kind}_{depth:.0f}_um": area for depth, area in zip(um, ours)}
        texts.append(f"{kind.upper()} {', '.join(f'{area:.1f}' for area in ours)} mm2 for "
                     f"{', '.join(f'{area:.1f}' for area in wanted)}")
    values = fitted()
    return Row("; ".join(texts) + " at 50, 100, 200, 350 and 500 um",
               "Endings are fitted, {:.0f} of SA1 within {:.1f} mm and {:.0f} of RA within {:.0f} mm, with a sensitivity of {:.1f} and "
               "{:.0f}: with the median's no afferent fires at 50 um. With these row:rates, whose rates are those of the median "
               "afferent, and row:edges do not hold: row:edges says by how much".format(values["sa1"]["endings"], values["sa1"]["radius"] * 1e3, values["ra"]["endings"],
                       values["ra"]["radius"] * 1e3, values["sa1"]["field_gain"], values["ra"]["field_gain"]), numbers)


def spheres_row(dermis, folder):
    force, curvature, wanted = np.array([[float(row[key]) for key in ("force", "curvature", "rate")]
                                         for row in data("spheres.csv")]).T
    modulus, poisson = 5e4, 0.4
    contact = np.cbrt(0.75 * force * (1 - poisson**2) / modulus / (curvature + fitted()["sa1"]["finger_curvature"]))
    strains = 1.5 * force / (np.pi * contact**2) / (1 + (DEPTHS["sa1"] / contact)**2) / modulus
    cells = np.outer(strains, np.exp(fitted()["sa1"]["spread"] * NODES)).ravel()
    load = 'envelope = "table"\ntimes = [0, 0.05]\nvalues = [0, 1]'
    spikes = fire(dermis, cells, load, 1.5, [(preset("sa1"), range(len(cells)))])
    rates = np.array([(t > 0.5).sum() for t in spikes]).reshape(-1, len(NODES)).mean(1)
    return Row("from {:.0f} to {:.0f} Hz for {:.0f} to {:.0f} Hz".format(rates.min(), rates.max(), wanted.min(), wanted.max()),
               "The pressure is Hertz's, the strain that on its axis at 0.3 mm; the curvature of the finger, "
               f"{fitted()['sa1']['finger_curvature']:.0f} 1/m, and the afferent are fitted to these points and to row:rates. The "
               "file does not name the forces: 10, 15 and 20 gf are a reading. A rate is the mean over seven afferents",
               {"spheres_r2": r2(rates, wanted)})


def bar_row(dermis, folder):
    import evidence  # for its half-space
    place, wanted = np.array([(float(row["mm"]), float(row["rate"])) for row in data("bar.csv")]).T
    even = np.linspace(-3.6, 3.4, 281)
    keep = np.append(True, np.diff(place) > 1e-6)
    wanted = np.interp(even, place[keep], wanted[keep])
    width, spacing = 400, 5e-5
    pressure = evidence.rigid_bar(width, 800, spacing, 1.42e-3)
    line = evidence.below(dermis, pressure, spacing, (DEPTHS["sa1"],))[0][400]
    x = (np.arange(width) - width / 2 + 0.5) * spacing * 1e3
    random, count = np.random.default_rng(2), int(fitted()["sa1"]["endings"])

    def best(offsets):
        """The greatest R2 of the stress above a threshold, times a gain: of an afferent with endings at offsets (mm)."""
        felt = np.max([np.interp(even - offset, x, line) for offset in offsets], 0)
        shapes = [np.maximum(felt - t * felt.max(), 0) for t in np.linspace(-0.2, 0.8, 21)]
        return max(r2((s @ wanted) / (s @ s) * s, wanted) for s in shapes)

    def median(radius):
        draws = (radius * np.sqrt(random.uniform(size=count)) * np.cos(2 * np.pi * random.uniform(size=count))
                 for _ in range(200))
        return float(np.median([best(offsets) for offsets in draws]))

    middle = np.abs(even) < 0.5
    numbers = {"bar_r2_single": best([0.0]), "bar_r2_0.8": median(0.8), "bar_r2_fit": median(fitted()["sa1"]["radius"] * 1e3),
               "bar_ratio": float(line.max() / line[width // 2])}
    return Row(f"with a single ending R2 {numbers['bar_r2_single']:.2f}; edges over the middle in the recording "
               f"{wanted.max() / wanted[middle].min():.0f}",
               "The stress at 0.3 mm below a rigid bar of 2.84 mm, with the gain and the threshold that suit the recording "
               f"best; {count} endings, the median of 200 draws. The ratio is that of the stress. One afferent and one "
               "bar", numbers)


def dot_map(dermis, kind, kpa=120, width=120, spacing=1e-4, speed=0.03):
    """The spikes of an afferent while a dot of 0.4 mm slides past it at a speed (m/s), by the dot's place: rows across the
    slide and columns along it, 0.1 mm apart."""
    length, start, offsets = 2 * width, 1.5 * width, np.arange(-40, 41)
    y, x = (np.mgrid[0:width * 8, 0:length * 8] + 0.5) / 8 - 0.5
    dot = np.hypot(y - width / 2, x - start) * spacing <= 0.2e-3
    load = (f'[load]\nkind = "file"\npath = "even.npy"\nintensity = {kpa * 1e3}\n[load.texture]\npath = "texture.npy"\n'
            f"velocity = [{speed}, 0]")
    with tempfile.TemporaryDirectory() as folder:
        np.save(f"{folder}/even.npy", np.ones((width, width)))
        np.save(f"{folder}/texture.npy", dot.reshape(width, 8, length, 8).mean((1, 3)))
        places = [(width // 2, width // 2 + offset) for offset in offsets]
        Path(folder, "sites.csv").write_text(discs(kind, places, width, spacing))
        scene = SKIN.format(width=width, spacing=spacing, load=load, type=CLASSES[kind], depth=DEPTHS[kind],
                            afferents=keys(kind), duration=length * spacing / speed)
        spikes = np.load(run(dermis, scene, folder) / "spikes.npy")
    # The dot's place, from the afferent's middle: the texture repeats itself.
    along = (start + spikes["time"] * speed / spacing - width / 2 + length / 2) % length - length / 2
    places = along * spacing * 1e3
    return np.histogram2d(spikes["afferent"], places, [np.arange(len(offsets) + 1), np.arange(-4, 4.01, 0.1)])[0]


def half_shift(image, axis):
    """The shift (mm) at which the correlation of a map with itself falls to a half."""
    shape = [2 * n for n in image.shape]
    whole = np.fft.irfft2(np.abs(np.fft.rfft2(image - image.mean(), shape))**2, shape)
    line = (whole[:, 0] if axis == 0 else whole[0]) / whole[0, 0]
    n = int(np.argmax(line < 0.5))
    return 0.1 * (n - 1 + (line[n - 1] - 0.5) / (line[n - 1] - line[n]))


def dots_row(dermis, folder):
    numbers, texts = {}, []
    for kind in ("ra", "sa1"):
        image = dot_map(dermis, kind)
        for axis, name in enumerate(("across", "along")):
            numbers[f"dot_{CLASSES[kind]}_{name}"] = half_shift(image, axis)
        texts.append(f"{CLASSES[kind].upper()} {image.sum():.0f} spikes over {(image > 0).sum() / 100:.1f} mm2")
    return Row("; ".join(texts), "The sensitive places of human FA1 and SA1 afferents are as fine as a ridge, about 0.4 mm. "
               "Here an afferent has the endings and the sensitivity of row:fields on flat skin, and a dot of 120 kPa slides past "
               "at 30 mm/s; one layout of endings. Ridges as places of the endings are not needed for it", numbers)


def spacing_rate(dermis, kind, mm, width=60, spacing=1e-4):
    """The mean rate (Hz) of nine afferents while a square array of dots of 1 mm diameter and 0.5 mm height slides past at 60
    mm/s. A mean pressure of 6 kPa, as of 0.6 N on a fingertip, rests on the dots, as far as a dot carries it: pressed in by
    its height."""
    cells, radius, speed = round(mm * 1e-3 / spacing), 5e-4, 0.06
    y, x = np.mgrid[0:cells, 0:cells] - cells // 2
    dot = (np.hypot(x, y) * spacing <= radius).astype(float)
    force = min(6e3 * (cells * spacing)**2, 2 * radius * 5e-4 * 5e4 / (1 - 0.4**2))
    seconds = 12 * cells * spacing / speed
    load = (f'[load]\nkind = "file"\npath = "even.npy"\nintensity = 1\n[load.texture]\npath = "texture.npy"\n'
            f"velocity = [{speed}, 0]")
    places = [(x, y) for x in (20, 30, 40) for y in (20, 30, 40)]
    listed = "\n".join(["type,x,y", *(f"fa2,{x},{y}" for x, y in places), ""])
    with tempfile.TemporaryDirectory() as folder:
        np.save(f"{folder}/even.npy", np.ones((width, width)))
        np.save(f"{folder}/texture.npy", dot / dot.sum() * force / spacing**2)
        sites = listed if kind == "pc" else discs(kind, places, width, spacing, np.random.default_rng(5))
        Path(folder, "sites.csv").write_text(sites)
        scene = SKIN.format(width=width, spacing=spacing, load=load, type=CLASSES[kind], depth=DEPTHS[kind],
                            afferents=preset(kind, "threshold") if kind == "pc" else keys(kind),
                            duration=seconds).replace("step = 1e-3", "step = 5e-4")
        spikes = np.load(run(dermis, scene, folder) / "spikes.npy")
    return (spikes["time"] > seconds / 3).sum() / (seconds * 2 / 3) / len(places)


def spacing_row(dermis, folder):
    numbers, texts = {}, []
    for kind in CLASSES:
        mm = np.array([float(row["mm"]) for row in data("spacing.csv") if row["class"] == kind])
        rates = np.array([spacing_rate(dermis, kind, each) for each in mm])
        numbers |= {f"spacing_{kind}_most": mm[rates.argmax()], f"spacing_{kind}_wide": rates[-1] / rates.max()}
        texts.append(f"{kind.upper()} {', '.join(f'{rate:.0f}' for rate in rates)} Hz")
    return Row(f"from 1.1 to 6.3 mm {'; '.join(texts)}",
               "The file does not say which afferents, how many and with what force. Speed, force, radius and height of the dots are "
               "those of the model of Ouyang et al.; how much of the force the dots carry is our choice, and makes the rates fall "
               "where dots are far apart. SA1 and RA have the endings and the sensitivity of row:fields, PC a single ending and "
               "the sensitivity of the thresholds", numbers)


def grating_rates(dermis, kind, period, vibrating):
    """The rates (Hz) of a preset afferent, with the endings of its field, at 16 places of a grating: ridges of a cosine,
    whose mean strain is 0.5 at the surface, held, or vibrating at 20 Hz by a fifth of it."""
    count, places = int(fitted()[kind]["endings"]), np.arange(16) / 16 * period
    random = np.random.default_rng(5)
    offsets = fitted()[kind]["radius"] * np.sqrt(random.uniform(size=count)) * np.cos(2 * np.pi * random.uniform(size=count))
    wave = 2 * np.pi / period
    left = (1 + wave * DEPTHS[kind]) * np.exp(-wave * DEPTHS[kind])  # of a wave of stress in a half-space
    cells = 0.5 * (1 + left * np.cos(wave * np.add.outer(places, offsets))).ravel()
    time = np.arange(4001) * 5e-4
    envelope = np.clip(time / 0.05, 0, 1) * (1 + vibrating * 0.2 * np.sin(2 * np.pi * 20 * time))
    spikes = fire(dermis, np.outer(envelope, cells), "", 2.0, [(f"{preset(kind)}\nendings = {count}", range(len(cells)))], 5e-4)
    return np.array([(t > 1).sum() for t in spikes[:len(places)]])


def gratings_row(dermis, folder):
    periods = np.array([1, 2, 3, 4, 5, 6]) * 1e-3

    def modulation(kind, vibrating):
        rates = [grating_rates(dermis, kind, period, vibrating) for period in periods]
        return np.array([(r.max() - r.min()) / max(r.max() + r.min(), 1) for r in rates])

    still, shaken, ra = modulation("sa1", False), modulation("sa1", True), modulation("ra", True)
    told = "; ".join(f"{name} " + ", ".join(f"{m:.2f}" for m in of) for name, of in
                     (("SA1 static", still), ("SA1 vibrating", shaken), ("RA vibrating", ra)))
    return Row(f"modulation, (most - least)/(most + least), at periods of 1 to 6 mm: {told}",
               "The abstract says that modulation grows with the period, is equal in static and vibrating gratings, and "
               "greater in SA1 than in RA afferents. Depth of the grating, 20 Hz and amplitude are our choice; the "
               "endings are those of row:fields, the sensitivity the median's; RA does not fire at a grating that stands still",
               {"grating_growth": shaken[-1] - shaken[0], "grating_still": (still - shaken).mean(),
                "grating_over_ra": (shaken - ra).mean()})


def stroke_rate(dermis, kind, speed, width=60, spacing=1e-4):
    """The mean rate (Hz) of nine afferents, with the endings and the sensitivity of the published fields, while a brush slides
    past."""
    length, seconds = 4 * width, 4 * width * spacing / speed
    load = (f'[load]\nkind = "file"\npath = "even.npy"\nintensity = 2e4\n[load.texture]\npath = "texture.npy"\n'
            f"velocity = [{speed}, 0]")
    with tempfile.TemporaryDirectory() as folder:
        np.save(f"{folder}/even.npy", np.ones((width, width)))
        np.save(f"{folder}/texture.npy", vibration.texture(1, width, length))
        places = [(x, y) for x in (20, 30, 40) for y in (20, 30, 40)]
        Path(folder, "sites.csv").write_text(discs(kind, places, width, spacing, np.random.default_rng(5)))
        scene = SKIN.format(width=width, spacing=spacing, load=load, type=CLASSES[kind], depth=DEPTHS[kind],
                            afferents=keys(kind), duration=seconds).replace("step = 1e-3", f"step = {seconds / 600}")
        spikes = np.load(run(dermis, scene, folder) / "spikes.npy")
    return (spikes["time"] > seconds / 4).sum() / (0.75 * seconds) / len(places)


def strokes_row(dermis, folder):
    speeds, texts, slopes = np.array([0.005, 0.02, 0.08, 0.32]), [], {}
    for kind in ("sa1", "ra"):
        rates = np.array([stroke_rate(dermis, kind, speed) for speed in speeds])
        fires = rates > 0
        slopes[kind] = np.polyfit(np.log(speeds[fires]), np.log(rates[fires]), 1)[0]
        texts.append(f"{CLASSES[kind].upper()} {', '.join(f'{rate:.0f}' for rate in rates)} Hz")
    return Row(f"at 5, 20, 80 and 320 mm/s {'; '.join(texts)}; the exponent of FA1 is {slopes['ra']:.2f}",
               "The mean rate of human afferents under a brush is a power of its speed, of fast adapting ones with a greater "
               "exponent. The brush is a random texture under 20 kPa, endings and sensitivities those of row:fields; exponents "
               "are of the speeds at which a class fires. While a sensitive SA1 afferent was sensitive to a steady strain too, it "
               "fired at its greatest rate at every speed (exponent -0.007) and this row failed. The sensitivity became one to "
               "changes alone because of rates in a hold, not for this row, but with its result known. With the median's "
               "sensitivity neither class fires. The paper's exponents were not seen",
               {"stroke_faster": slopes["ra"] - slopes["sa1"], "stroke_sa1": slopes["sa1"], "stroke_fa1": slopes["ra"]})
