# SPDX-License-Identifier: MIT
"""What a tolerance takes: the model and precision that are chosen for it, the bound, the error and the time.

tolerance.py dermis picture.png. Errors are measured against closed forms in long double, as Scene::tolerance defines them.
"""
import csv
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image  # matplotlib's own requirement

LONG = np.longdouble
SIZE, STEP, ROWS = 192, 0.0625, 100  # cells; s
TABLE = [(0.11, 0.0), (0.43, 1.0), (2.71, 0.8), (3.3, 0.1)]  # s, levels of the map
FRAMES = [(0.25 * k, level) for k, level in enumerate((0.0, 0.4, 1.0, 0.9, 0.3, 0.7, 0.7, 0.0, 0.2, 0.1))]
TOLERANCES = 10.0 ** np.arange(-14, -0.5)
ONE = [(1.54, 1.0)]  # Pa, Pa s
EIGHT = [(50.0 * 1.3**k, 50.0 * 1.3**k * tau) for k, tau in enumerate((1e-5, 1e-4, 4e-3, 0.07, 0.4, 1.4, 300, 1e5))]
QUANTITIES = ["strain", "sa1", "fa1", "fa2"]
SCENES = {"one map times an envelope": (ONE, TABLE, [1, -1], QUANTITIES),
          "the same, with FA2 rectified": (ONE, TABLE, [1, 0], QUANTITIES),
          "frames, on eight elements in series": (EIGHT, FRAMES, [1, -1], QUANTITIES[:3])}
TAKEN = {("moments", "f64"): ("#009E73", "*"), ("march", "f32"): ("#56B4E9", "o"),
         ("march", "f32-compensated"): ("#E69F00", "s"), ("march", "f64"): ("#0072B2", "D")}


def maps():
    x, y = np.meshgrid(np.arange(SIZE), np.arange(SIZE))
    surface = 0.1 * np.sin(2 * np.pi * 9 * (x / SIZE + 0.3 * np.sin(y / 30)))
    pressure = np.exp(-((x - 130) ** 2 + (y - 120) ** 2) / 900.0)
    return surface, pressure


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
def exact(elements, knots, gains, asked, surface, pressure):
    g = creep(elements, knots, np.arange(ROWS) * LONG(STEP))
    P = pressure.astype(LONG)
    rest, curve = laplacian(surface.astype(LONG)), laplacian(P)
    truth = {q: ([], []) for q in asked}
    for n in range(ROWS):
        gain = 1 + (rest - g[0, n] * curve)
        for q, derivative in zip(asked, (0, 0, 1, 2)):
            map = P * g[derivative, n] * (1 if q == "strain" else gain)
            truth[q][1].append(np.abs(map).max())
            if q == "fa2":
                map = gains[0] * np.maximum(map, 0) + gains[1] * np.maximum(-map, 0)
            truth[q][0].append((map.mean(), map.min(), map.max()))
    return {q: (rows, max(largest)) for q, (rows, largest) in truth.items()}


def scene_text(elements, knots, gains, asked, tolerance):
    material = ", ".join(f"{{ modulus = {E}, viscosity = {eta} }}" for E, eta in elements)
    load = (f"kind = \"sequence\"\npath = \"frames.npy\"\ninterval = {knots[1][0]}" if knots is FRAMES else
            f"kind = \"file\"\npath = \"pressure.npy\"\nenvelope = \"table\"\ntimes = {[t for t, _ in knots]}\n"
            f"values = {[level for _, level in knots]}")
    return (f"tolerance = {tolerance:.17g}\n[grid]\nwidth = {SIZE}\nheight = {SIZE}\n[surface]\nkind = \"file\"\npath = \"surface.npy\"\n"
            f"[material]\nelements = [{material}]\n[load]\n{load}\n[time]\nstep = {STEP}\nduration = {STEP * ROWS}\n"
            f"[receptors]\nfa2_gains = {gains}\n[output]\ntraces = {json.dumps(asked)}\n")


def measured(folder, truth):
    with open(folder / "traces.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    return max(abs(LONG(row[f"{q}_{of}"]) - value) / largest for q, (exact, largest) in truth.items()
               for row, three in zip(rows, exact) for of, value in zip(("mean", "min", "max"), three))


# The run that a tolerance takes: (model, precision), its bound, its error, and the least seconds of three. None: refused.
def taken(dermis, folder, text, truth):
    scene, out = folder / "scene.toml", folder / "out"
    scene.write_text(text)
    seconds = []
    for _ in range(3):
        if subprocess.run([dermis, "run", scene, "--out", out, "--device", "cpu"], capture_output=True).returncode:
            return None
        summary = json.loads((out / "summary.json").read_text())
        seconds.append(summary["seconds"])
    plan = summary["plan"]
    return (plan["model"], plan["precision"]), plan["predicted_error"], float(measured(out, truth)), min(seconds)


def draw(axes, title, runs):
    error, time = axes
    error.plot(TOLERANCES, TOLERANCES, color="grey", linestyle=(0, (1, 2)), linewidth=1)
    for tolerance, run in zip(TOLERANCES, runs):
        if run is None:
            error.plot(tolerance, tolerance, "x", color="black", markersize=7)
            continue
        kind, bound, off, seconds = run
        colour, marker = TAKEN.get(kind, ("black", "^"))
        error.plot([tolerance] * 2, [bound, max(off, 1e-18)], color=colour, linewidth=1, alpha=0.6)
        error.plot(tolerance, bound, "_", color=colour, markersize=11, markeredgewidth=2)
        error.plot(tolerance, max(off, 1e-18), marker, color=colour, markersize=6)
        time.plot(tolerance, seconds * 1e3, marker, color=colour, markersize=6)
    error.set(title=title, xscale="log", yscale="log", ylim=(1e-18, 1), xlim=(3e-15, 0.3))
    time.set(xscale="log", yscale="log", xlabel="tolerance")
    for axis in axes:
        axis.grid(alpha=0.25)


def main(dermis, picture):
    figure, axes = plt.subplots(2, len(SCENES), figsize=(13, 6.4), sharex="col", sharey="row", height_ratios=(2, 1))
    surface, pressure = maps()
    drawn = set()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        np.save(folder / "surface.npy", surface)
        np.save(folder / "pressure.npy", pressure)
        np.save(folder / "frames.npy", np.array([level * pressure for _, level in FRAMES]))
        for column, (title, scene) in zip(axes.T, SCENES.items()):
            truth = exact(*scene, surface, pressure)
            runs = [taken(dermis, folder, scene_text(*scene, t), truth) for t in TOLERANCES]
            draw(column, title, runs)
            drawn.update(run[0] for run in runs if run)
    axes[0, 0].set_ylabel("error / greatest value")
    axes[1, 0].set_ylabel("ms")
    for (model, precision), (colour, marker) in TAKEN.items():
        if (model, precision) in drawn:
            axes[0, 0].plot([], [], marker, color=colour, label=f"{model} in {precision}")
    axes[0, 0].plot([], [], color="grey", linestyle=(0, (1, 2)), label="tolerance")
    axes[0, 0].plot([], [], "_", color="black", markersize=11, markeredgewidth=2, label="bound")
    axes[0, 0].plot([], [], "x", color="black", label="refused")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="lower center", ncol=9, columnspacing=1.2, fontsize=9, frameon=False)
    figure.suptitle(f"No more than a scene needs: what each tolerance takes ({SIZE} x {SIZE} cells, {ROWS} rows)", fontsize=12)
    figure.tight_layout(rect=(0, 0.05, 1, 1))
    figure.canvas.draw()
    image = Image.fromarray(np.asarray(figure.canvas.buffer_rgba())[..., :3])
    image.quantize(256, Image.Quantize.MAXCOVERAGE).save(picture, optimize=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
