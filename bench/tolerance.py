# SPDX-License-Identifier: MIT
"""What a tolerance takes: the model and precision that the plan chooses for it, its bound, the error that is found, and the time.

    tolerance.py dermis [picture.png]

Errors are measured against closed forms in long double, as Scene::tolerance defines them.
"""
import json
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from drawing import BLUE, GREEN, GREY, VERMILLION, chart, figure, logarithmic, save
from runs import scene, table

LONG = np.longdouble
SIZE, STEP, ROWS = 192, 0.0625, 100  # cells; s
TABLE = [(0.11, 0.0), (0.43, 1.0), (2.71, 0.8), (3.3, 0.1)]  # s, levels of the map
FRAMES = [(0.25 * k, level) for k, level in enumerate((0.0, 0.4, 1.0, 0.9, 0.3, 0.7, 0.7, 0.0, 0.2, 0.1))]
TOLERANCES = 10.0 ** np.arange(-14, -0.5)
ONE = [[(1.54, 1.0)]]  # materials: elements, Pa, Pa s
# Eight materials that have one retardation time but for the rounding of float numbers.
ROUNDED = [[(float(np.float32(E)), float(np.float32(E * 0.65)))] for E in 1.5 + 0.1 * np.arange(8)]
EIGHT = [[(50.0 * 1.3**k, 50.0 * 1.3**k * tau) for k, tau in enumerate((1e-5, 1e-4, 4e-3, 0.07, 0.4, 1.4, 300, 1e5))]]
QUANTITIES = ["strain", "sa1", "fa1", "fa2"]
SCENES = {"float maps of material,\none retardation time": (ROUNDED, TABLE, [1, -1], QUANTITIES),
          "one map times an envelope,\nFA2 rectified": (ONE, TABLE, [1, 0], QUANTITIES),
          "frames, on eight\nelements in series": (EIGHT, FRAMES, [1, -1], QUANTITIES[:3])}
TAKEN = {("moments", "f64"): ("moments,\ndouble", "black"), ("march", "f32"): ("march,\nfloat", VERMILLION),
         ("march", "f32-compensated"): ("march, float,\ncompensated", GREEN), ("march", "f64"): ("march,\ndouble", BLUE),
         None: ("refused", GREY)}


def maps():
    x, y = np.meshgrid(np.arange(SIZE), np.arange(SIZE))
    surface = 0.1 * np.sin(2 * np.pi * 9 * (x / SIZE + 0.3 * np.sin(y / 30)))
    pressure = np.exp(-((x - 130) ** 2 + (y - 120) ** 2) / 900.0)
    return surface, pressure, (x // 24 + y // 24) % 8


def laplacian(f):
    wide = np.pad(f, 1, mode="edge")
    return ((wide[1:-1, :-2] - f) + (wide[1:-1, 2:] - f)) + ((wide[:-2, 1:-1] - f) + (wide[2:, 1:-1] - f))


# d/tau - (1 - e^(-d/tau)), which cancels where d is much less than tau: then by its series.
def bent(x):
    series, term = np.zeros_like(x), x * x / 2
    for k in range(3, 14):
        series, term = series + term, -term * x / k
    return np.where(x < 0.1, series, x + np.expm1(-x))


# Strain and its first and second derivative at t under a pressure that is straight between knots: the sum over elements of
# what each change of its slope gives.
def creep(elements, knots, t):
    times, levels = (np.array(of, LONG) for of in zip(*knots))
    slopes = np.append(np.diff(levels) / np.diff(times), 0)
    total = np.zeros((3, len(t)), LONG)
    for modulus, viscosity in elements:
        E, tau = LONG(modulus), LONG(viscosity) / LONG(modulus)
        for begin, bend in zip(times, np.diff(slopes, prepend=0)):
            d = np.maximum(t - begin, 0)
            total += bend / E * np.array([tau * bent(d / tau), -np.expm1(-d / tau), (d > 0) * np.exp(-d / tau) / tau])
    return total


# The means, least and greatest values of each output, and its greatest magnitude.
def exact(materials, knots, gains, asked, surface, pressure, patch):
    g = np.array([creep(elements, knots, np.arange(ROWS) * LONG(STEP)) for elements in materials])
    P, rest, of_cell = pressure.astype(LONG), laplacian(surface.astype(LONG)), patch % len(materials)
    truth = {q: ([], []) for q in asked}
    for n in range(ROWS):
        gain = 1 + (rest - laplacian(P * g[:, 0, n][of_cell]))
        for q, derivative in zip(asked, (0, 0, 1, 2)):
            map = P * g[:, derivative, n][of_cell] * (1 if q == "strain" else gain)
            truth[q][1].append(np.abs(map).max())
            if q == "fa2":
                map = gains[0] * np.maximum(map, 0) + gains[1] * np.maximum(-map, 0)
            truth[q][0].append((map.mean(), map.min(), map.max()))
    return {q: (rows, max(largest)) for q, (rows, largest) in truth.items()}


def scene_text(materials, knots, gains, asked, tolerance):
    elements = ", ".join(f"{{ modulus = {E}, viscosity = {eta} }}" for E, eta in materials[0])
    material = f"elements = [{elements}]" if len(materials) == 1 else 'modulus = "modulus.npy"\nviscosity = "viscosity.npy"'
    load = (f"kind = \"sequence\"\npath = \"frames.npy\"\ninterval = {knots[1][0]}" if knots is FRAMES else
            f"kind = \"file\"\npath = \"pressure.npy\"\nenvelope = \"table\"\ntimes = {[t for t, _ in knots]}\n"
            f"values = {[level for _, level in knots]}")
    return scene("tolerance", tolerance=tolerance, size=SIZE, material=material, load=load, step=STEP, duration=STEP * ROWS, gains=gains,
                 traces=json.dumps(asked))


def error_of(folder, truth):
    rows = table(folder / "traces.csv")
    return max(abs(LONG(row[f"{q}_{of}"]) - value) / largest for q, (exact, largest) in truth.items()
               for row, three in zip(rows, exact) for of, value in zip(("mean", "min", "max"), three))


# The run that a tolerance takes: (model, precision), its bound, its error, and the least seconds of three. None: refused.
def taken(dermis, folder, text, truth):
    path, out = folder / "scene.toml", folder / "out"
    path.write_text(text)
    seconds = []
    for _ in range(3):
        if subprocess.run([dermis, "run", path, "--out", out, "--device", "cpu"], capture_output=True).returncode:
            return None
        summary = json.loads((out / "summary.json").read_text())
        seconds.append(summary["seconds"])
    plan = summary["plan"]
    return (plan["model"], plan["precision"]), plan["predicted_error"], float(error_of(out, truth)), min(seconds)


def measured(dermis):
    """By scene what each tolerance takes."""
    surface, pressure, patch = maps()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        np.save(folder / "surface.npy", surface)
        np.save(folder / "pressure.npy", pressure)
        np.save(folder / "frames.npy", np.array([level * pressure for _, level in FRAMES]))
        for i, key in enumerate(("modulus", "viscosity")):
            np.save(folder / f"{key}.npy", np.array([elements[0][i] for elements in ROUNDED])[patch])
        found = {}
        for title, parts in SCENES.items():
            truth = exact(*parts, surface, pressure, patch)
            found[title] = [taken(dermis, folder, scene_text(*parts, t), truth) for t in TOLERANCES]
        return found


def claims(found):
    first, second, third = ([run and run[0] for run in runs] for runs in found.values())
    every = [(tolerance, run) for runs in found.values() for tolerance, run in zip(TOLERANCES, runs) if run]
    return {"no error is above its bound, and no bound above its tolerance": all(
        error <= bound <= tolerance for tolerance, (_, bound, error, _) in every),
        "from 1e-5 on two scenes are marched in float with compensated sums, below in double": all(
            (kind == ("march", "f32-compensated")) == (tolerance > 5e-6) for way in (second, third)
            for tolerance, kind in zip(TOLERANCES, way) if kind),
        "materials equal but for float's rounding are taken as one, by moments, from 1e-6 on; below every cell is marched": all(
            kind == (("moments", "f64") if tolerance > 5e-7 else ("march", "f64"))
            for tolerance, kind in zip(TOLERANCES, first) if kind),
        "a tolerance of 1e-14 is refused in the first scene, and no other": [way.index(None) for way in (first, second, third)
                                                                             if None in way] == [0] and None not in first[1:]}


def draw(found, picture):
    drawn, axes = figure(2, 3, 5.4, "The plan takes no more than a tolerance needs, and keeps it", sharex="col", sharey="row",
                         height_ratios=(2.4, 1))
    for (error, time), (title, runs) in zip(axes.T, found.items()):
        logarithmic(error)
        logarithmic(time)
        error.plot(TOLERANCES, TOLERANCES, color="black", linestyle=(0, (1, 2)), linewidth=1.2)
        kinds = [run and run[0] for run in runs]
        for kind in dict.fromkeys(kinds):
            words, colour = TAKEN[kind]
            own = [(t, run) for t, run in zip(TOLERANCES, runs) if (run and run[0]) == kind]
            for axis in (error, time):
                axis.axvspan(own[0][0] / 10**0.5, own[-1][0] * 10**0.5, color=colour, alpha=0.09, linewidth=0)
            error.text(np.sqrt(own[0][0] * own[-1][0]), 3e3, words, ha="center", va="top", color=colour, fontsize=8.5,
                       rotation=90 if kind is None else 0)
            if kind:
                x, (bound, off, ms) = [t for t, _ in own], np.array([run[1:] for _, run in own]).T
                error.plot(x, bound, "_", color=colour, markersize=9, markeredgewidth=2)
                error.plot(x, np.maximum(off, 1e-17), "o", color=colour, markersize=4)
                time.plot(x, 1e3 * ms, "o-", color=colour, markersize=4)
        error.set(ylim=(1e-17, 1e4), xlim=(3e-15, 0.3))
        error.set_title(title, fontsize=10)
        time.set(xlabel="tolerance", ylim=(0.2, 300))
        time.set_xticks(10.0 ** np.arange(-14, 0, 4))
    axes[0, 0].set_ylabel("error / greatest value")
    axes[1, 0].set_ylabel("ms of the run")
    axes[0, 0].text(1e-8, 2e-8, "tolerance", rotation=36, fontsize=9, ha="right", va="bottom")
    axes[0, 0].text(2e-6, 1e-10, "–  bound\n•  error", fontsize=9, va="top")
    save(drawn, picture, f"{SIZE} x {SIZE} cells, {ROWS} outputs, two threads")


if __name__ == "__main__":
    chart(measured, claims, draw)
