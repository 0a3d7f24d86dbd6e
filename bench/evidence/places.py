# SPDX-License-Identifier: MIT
"""The rows of the page EVIDENCE.md about places: fields, spheres, a bar, dots, gratings, strokes. See evidence.py."""
import tempfile
from pathlib import Path

import numpy as np

import halfspace
import vibration
from firing import NODES
from rows import CLASSES, DEPTHS, Row, data, fitted, listed, preset, r2
from runs import afferents_of, fire, run, scene


def discs(kind, centres, width, spacing, random=None):
    """Sites, as text, of afferents around centres (cells): their endings, drawn for each centre, or once for all of them
    if no random numbers are given."""
    count, radius = int(fitted(kind)["endings"]), fitted(kind)["radius"] / spacing
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
    values = fitted(kind)
    return f'type = "{CLASSES[kind]}"\nsensitivity = {values["field_gain"]}\nspread = 0\nendings = {values["endings"]:.0f}'


def on_skin(dermis, kind, load, duration, sites, width, spacing, step=1e-3, afferents=None, set=None, **files):
    """The spikes (s) of afferents at sites of a flat fingertip."""
    text = scene("skin", width=width, spacing=spacing, load=load, type=CLASSES[kind], depth=DEPTHS[kind],
                 afferents=afferents or keys(kind), duration=duration, step=step)
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "sites.csv").write_text(sites)
        return [times for _, times in afferents_of(run(dermis, text, folder, *(["--set", set] if set else []), **files))]


def sliding(dermis, kind, texture, speed, duration, sites, width, spacing, pressure=1, **more):
    """The same while a texture slides past at a speed (m/s) under an even pressure (Pa)."""
    load = (f'[load]\nkind = "file"\npath = "even.npy"\nintensity = {pressure}\n[load.texture]\npath = "texture.npy"\n'
            f"velocity = [{speed}, 0]")
    return on_skin(dermis, kind, load, duration, sites, width, spacing, even=np.ones((width, width)), texture=texture, **more)


NINE = [(x, y) for x in (20, 30, 40) for y in (20, 30, 40)]  # cells of nine afferents, of 60 x 60


def field_areas(dermis, kind, um, width=200, spacing=5e-5, apart=8):
    """The areas (mm2) of the field of 529 afferents at a probe of 0.5 mm: the share that fires, each at another place of
    the probe and with other endings, times the area of all places."""
    middles = np.arange(-88, 89, apart) + width // 2
    load = ('[load]\nkind = "punch"\ncontrol = "depth"\nradius = 5\nintensity = 1e-3\nenvelope = "ramp"\nrise = 0.01')
    sites = discs(kind, [(x, y) for y in middles for x in middles], width, spacing, np.random.default_rng(5))
    fires = [sum(len(times) > 0 for times in on_skin(dermis, kind, load, 0.2, sites, width, spacing, set=f"load.intensity={depth * 1e-6}"))
             for depth in um]
    return np.array(fires) * (apart * spacing * 1e3)**2


def fields_row(dermis, folder):
    numbers, texts = {}, []
    for kind in ("sa1", "ra"):
        um, wanted = np.array([(float(r["um"]), float(r["mm2"])) for r in data("fields.csv") if r["class"] == kind]).T
        ours = field_areas(dermis, kind, um)
        numbers |= {f"field_{kind}_rms": float(np.sqrt((np.log(ours / wanted)**2).mean()))}
        numbers |= {f"field_{kind}_{depth:.0f}_um": area for depth, area in zip(um, ours)}
        texts.append(f"{kind.upper()} {listed(ours, '.1f')} mm2 for {listed(wanted, '.1f')}")
    sizes = {kind: {**fitted(kind), "mm": fitted(kind)["radius"] * 1e3} for kind in ("sa1", "ra")}
    return Row(numbers, told={"texts": "; ".join(texts), **sizes})


def spheres_row(dermis, folder):
    force, curvature, wanted = np.array([[float(row[key]) for key in ("force", "curvature", "rate")]
                                         for row in data("spheres.csv")]).T
    modulus, poisson = 5e4, 0.4
    contact = np.cbrt(0.75 * force * (1 - poisson**2) / modulus / (curvature + fitted("sa1")["finger_curvature"]))
    strains = 1.5 * force / (np.pi * contact**2) / (1 + (DEPTHS["sa1"] / contact)**2) / modulus
    cells = np.outer(strains, np.exp(fitted("sa1")["spread"] * NODES)).ravel()
    load = 'envelope = "table"\ntimes = [0, 0.05]\nvalues = [0, 1]'
    spikes = fire(dermis, cells, load, 1.5, [(preset("sa1"), range(len(cells)))])
    rates = np.array([(t > 0.5).sum() for t in spikes]).reshape(-1, len(NODES)).mean(1)
    return Row({"spheres_r2": r2(rates, wanted)}, told={
        "least": rates.min(), "most": rates.max(), "wanted_least": wanted.min(), "wanted_most": wanted.max(),
        "curvature": fitted("sa1")["finger_curvature"]})


def bar_row(dermis, folder):
    place, wanted = np.array([(float(row["mm"]), float(row["rate"])) for row in data("bar.csv")]).T
    even = np.linspace(-3.6, 3.4, 281)
    keep = np.append(True, np.diff(place) > 1e-6)
    wanted = np.interp(even, place[keep], wanted[keep])
    width, spacing = 400, 5e-5
    pressure = halfspace.rigid_bar(width, 800, spacing, 1.42e-3)
    line = halfspace.below(dermis, pressure, spacing, (DEPTHS["sa1"],))[0][400]
    x = (np.arange(width) - width / 2 + 0.5) * spacing * 1e3
    random, count = np.random.default_rng(2), int(fitted("sa1")["endings"])

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
    numbers = {"bar_r2_single": best([0.0]), "bar_r2_0.8": median(0.8), "bar_r2_fit": median(fitted("sa1")["radius"] * 1e3),
               "bar_ratio": float(line.max() / line[width // 2])}
    return Row(numbers, told={"recorded": wanted.max() / wanted[middle].min(), "count": count})


def dot_map(dermis, kind, kpa=120, width=120, spacing=1e-4, speed=0.03):
    """The spikes of an afferent while a dot of 0.4 mm slides past it at a speed (m/s), by the dot's place: rows across the
    slide and columns along it, 0.1 mm apart."""
    length, start, offsets = 2 * width, 1.5 * width, np.arange(-40, 41)
    y, x = (np.mgrid[0:width * 8, 0:length * 8] + 0.5) / 8 - 0.5
    dot = np.hypot(y - width / 2, x - start) * spacing <= 0.2e-3
    sites = discs(kind, [(width // 2, width // 2 + offset) for offset in offsets], width, spacing)
    texture = dot.reshape(width, 8, length, 8).mean((1, 3))
    spikes = sliding(dermis, kind, texture, speed, length * spacing / speed, sites, width, spacing, kpa * 1e3)
    # The dot's place, from the afferent's middle: the texture repeats itself.
    number = np.repeat(np.arange(len(spikes)), [len(times) for times in spikes])
    along = (start + np.concatenate(spikes) * speed / spacing - width / 2 + length / 2) % length - length / 2
    places = along * spacing * 1e3
    return np.histogram2d(number, places, [np.arange(len(offsets) + 1), np.arange(-4, 4.01, 0.1)])[0]


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
    return Row(numbers, told={"texts": "; ".join(texts)})


def spacing_rate(dermis, kind, mm, width=60, spacing=1e-4):
    """The mean rate (Hz) of nine afferents while a square array of dots of 1 mm diameter and 0.5 mm height slides past at 60
    mm/s. A mean pressure of 6 kPa, as of 0.6 N on a fingertip, rests on the dots, as far as a dot carries it: pressed in by
    its height."""
    cells, radius, speed = round(mm * 1e-3 / spacing), 5e-4, 0.06
    y, x = np.mgrid[0:cells, 0:cells] - cells // 2
    dot = (np.hypot(x, y) * spacing <= radius).astype(float)
    force = min(6e3 * (cells * spacing)**2, 2 * radius * 5e-4 * 5e4 / (1 - 0.4**2))
    seconds = 12 * cells * spacing / speed
    sites = "\n".join(["type,x,y", *(f"fa2,{x},{y}" for x, y in NINE), ""]) if kind == "pc" else discs(
        kind, NINE, width, spacing, np.random.default_rng(5))
    spikes = sliding(dermis, kind, dot / dot.sum() * force / spacing**2, speed, seconds, sites, width, spacing, step=5e-4,
                     afferents=preset(kind, "threshold") if kind == "pc" else None)
    return (np.concatenate(spikes) > seconds / 3).sum() / (seconds * 2 / 3) / len(NINE)


def spacing_row(dermis, folder):
    numbers, texts = {}, []
    for kind in CLASSES:
        mm = np.array([float(row["mm"]) for row in data("spacing.csv") if row["class"] == kind])
        rates = np.array([spacing_rate(dermis, kind, each) for each in mm])
        numbers |= {f"spacing_{kind}_most": mm[rates.argmax()], f"spacing_{kind}_wide": rates[-1] / rates.max()}
        texts.append(f"{kind.upper()} {listed(rates)} Hz")
    return Row(numbers, told={"texts": "; ".join(texts)})


def grating_rates(dermis, kind, period, vibrating):
    """The rates (Hz) of a preset afferent, with the endings of its field, at 16 places of a grating: ridges of a cosine,
    whose mean strain is 0.5 at the surface, held, or vibrating at 20 Hz by a fifth of it."""
    count, places = int(fitted(kind)["endings"]), np.arange(16) / 16 * period
    random = np.random.default_rng(5)
    offsets = fitted(kind)["radius"] * np.sqrt(random.uniform(size=count)) * np.cos(2 * np.pi * random.uniform(size=count))
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
    texts = "; ".join(f"{name} {listed(of, '.2f')}" for name, of in
                      (("SA1 static", still), ("SA1 vibrating", shaken), ("RA vibrating", ra)))
    return Row({"grating_growth": shaken[-1] - shaken[0], "grating_still": (still - shaken).mean(),
                "grating_over_ra": (shaken - ra).mean()}, told={"texts": texts})


def stroke_rate(dermis, kind, speed, width=60, spacing=1e-4):
    """The mean rate (Hz) of nine afferents, with the endings and the sensitivity of the published fields, while a brush slides
    past."""
    length, seconds = 4 * width, 4 * width * spacing / speed
    sites = discs(kind, NINE, width, spacing, np.random.default_rng(5))
    spikes = sliding(dermis, kind, vibration.texture(1, width, length), speed, seconds, sites, width, spacing, 2e4, step=seconds / 600)
    return (np.concatenate(spikes) > seconds / 4).sum() / (0.75 * seconds) / len(NINE)


def strokes_row(dermis, folder):
    speeds, texts, slopes = np.array([0.005, 0.02, 0.08, 0.32]), [], {}
    for kind in ("sa1", "ra"):
        rates = np.array([stroke_rate(dermis, kind, speed) for speed in speeds])
        fires = rates > 0
        slopes[kind] = np.polyfit(np.log(speeds[fires]), np.log(rates[fires]), 1)[0]
        texts.append(f"{CLASSES[kind].upper()} {listed(rates)} Hz")
    return Row({"stroke_faster": slopes["ra"] - slopes["sa1"], "stroke_sa1": slopes["sa1"], "stroke_fa1": slopes["ra"]},
               told={"texts": "; ".join(texts)})
