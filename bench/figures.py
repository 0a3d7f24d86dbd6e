# SPDX-License-Identifier: MIT
"""Draws figures 3 to 12 of the published study, and error against cost, from a results folder into its figures/."""
import csv
import functools
import sys
from collections import namedtuple
from pathlib import Path

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

BLUE, VERMILLION, GREEN, ORANGE, PURPLE = "#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7"
EXACT_LINE = dict(color="black", linestyle=(0, (4, 3)), linewidth=0.9)
SURFACES = ["flat", "wave", "spiral"]
LOADS = ["circular", "point", "linear"]
RESPONSES = {"sa1": "SA1", "sa2": "SA2 (s)", "fa1": "FA1 (1/s)", "fa2": "FA2 (1/s²)"}
PROBES = [(75, 75), (85, 85), (60, 80), (37, 37), (112, 112)]
ROW = 75
SHOWN_SECONDS = {"sa1": 10, "sa2": 10, "fa1": 4, "fa2": 4}
SPIKE_SAMPLES = 2  # the published central difference sees the jump of the load in these

Runs = namedtuple("Runs", "published exact")
Curve = namedtuple("Curve", "label colour runs value")  # value(trace, quantity) gives the curve's samples


@functools.lru_cache(maxsize=None)
def read_trace(folder):
    path = folder / "traces.csv"
    with open(path) as file:
        names = file.readline().strip().split(",")
        return dict(zip(names, np.loadtxt(file, delimiter=",", unpack=True)))


def scene_runs(study, scene):
    return Runs(*(read_trace(study / method / scene) for method in Runs._fields))


def cell_mean(trace, quantity):
    return trace[f"{quantity}_mean"]


def probe_value(probe):
    return lambda trace, quantity: trace[f"{quantity}_probe{probe}"]


# The study divides by the number of probes inside its loop over them, so probe k ends with the weight 5^(k - 5).
def plotted_average(trace, quantity):
    return sum(trace[f"{quantity}_probe{k}"] / 5 ** (5 - k) for k in range(5))


def save(figure, study, name):
    figure.savefig(study / "figures" / f"{name}.png", pil_kwargs={"compress_level": 9})
    plt.close(figure)


def draw_map(axes, values, title, quantity, **limits):
    image = axes.imshow(values, cmap="cividis", origin="lower", **limits)
    axes.set(title=title, xlabel="x (cells)", ylabel="y (cells)")
    axes.figure.colorbar(image, ax=axes, shrink=0.75, label=quantity)


def draw_three_maps(study, name, title, maps, quantity, **limits):
    figure, panels = plt.subplots(1, 3, figsize=(10, 3.4))
    for axes, (panel_title, values) in zip(panels, maps.items()):
        draw_map(axes, values, panel_title, quantity, **limits)
    figure.suptitle(title)
    save(figure, study, name)


def draw_lines(axes, quantity, curves):
    for c in curves:
        axes.plot(c.runs.published["time"], c.value(c.runs.published, quantity), color=c.colour, label=c.label)
    for c in curves:
        axes.plot(c.runs.exact["time"], c.value(c.runs.exact, quantity), **EXACT_LINE,
                  label="exact solution" if c is curves[-1] else None)


def draw_response(axes, quantity, curves, tail_scale="linear"):
    draw_lines(axes, quantity, curves)
    axes.set(xlim=(0, SHOWN_SECONDS[quantity]), xlabel="time (s)", ylabel=RESPONSES[quantity])
    if quantity == "fa2":
        draw_tail(axes, curves, tail_scale)


# The spike of FA2 grows as one over the time step and hides what follows it: the rest gets an inset of its own.
def draw_tail(axes, curves, scale):
    tails = [c.value(trace, "fa2")[SPIKE_SAMPLES:] for c in curves for trace in c.runs]
    low, high = min(map(np.min, tails)), max(map(np.max, tails))
    inset = axes.inset_axes([0.34, 0.30, 0.63, 0.52])
    draw_lines(inset, "fa2", curves)
    inset.set(xlim=(0, SHOWN_SECONDS["fa2"]), ylim=(low - 0.08 * (high - low), high + 0.08 * (high - low)))
    if scale == "symlog":
        inset.set_yscale("symlog", linthresh=-low / 100)
    inset.axhline(0, color="0.7", linewidth=0.6, zorder=0)
    inset.tick_params(labelsize=7)
    inset.set_title("same curves after the spike", fontsize=8, pad=3)


def figure_3(study):
    maps = {f"{s} surface": np.load(study / f"maps/surface_{s}.npy") for s in SURFACES}
    draw_three_maps(study, "figure_03", "Figure 3: the three surfaces before any load", maps, "height",
                    vmin=min(map(np.min, maps.values())), vmax=max(map(np.max, maps.values())))


def figure_4(study):
    maps = {load: np.load(study / f"maps/pressure_{load}.npy") for load in LOADS}
    maps = {f"{load} load, peak {values.max():.2g} Pa": values for load, values in maps.items()}
    draw_three_maps(study, "figure_04", "Figure 4: the three pressure maps, each with its own scale", maps, "pressure (Pa)")


def figure_5(study):
    before = np.load(study / "maps/surface_spiral.npy")
    after = Runs(*(np.load(study / method / "spiral_circular/deformation_t9.99.npy") for method in Runs._fields))
    figure = plt.figure(figsize=(9, 7.4))
    y, x = np.indices(before.shape)
    for place, values, title in ((221, before, "before"), (222, after.published, "after 9.99 s of pressure")):
        axes = figure.add_subplot(place, projection="3d")
        axes.plot_surface(x, y, values, cmap="cividis", rcount=75, ccount=75, vmin=before.min(), vmax=before.max())
        axes.set(title=title, xlabel="x (cells)", ylabel="y (cells)", zlabel="height",
                 zlim=(after.published.min(), before.max()))
        axes.set_box_aspect((1, 1, 0.5), zoom=0.9)
    draw_map(figure.add_subplot(223), before - after.published, "displacement: before minus after", "displacement")
    axes = figure.add_subplot(224)
    axes.plot(before[ROW], color=BLUE, label="before")
    axes.plot(after.published[ROW], color=VERMILLION, label="after")
    axes.plot(after.exact[ROW], **EXACT_LINE, label="after, exact solution")
    axes.set(title=f"profile along row {ROW}", xlabel="x (cells)", ylabel="height")
    axes.legend(loc="lower right")
    figure.suptitle("Figure 5: the circular load presses a bowl into the spiral ridges")
    save(figure, study, "figure_05")


def figure_6(study):
    maps = {f"{s} surface": np.load(study / f"published/{s}_circular/deformation_t9.99.npy") for s in SURFACES}
    draw_three_maps(study, "figure_06", "Figure 6: the surfaces after 9.99 s under the circular load", maps, "height",
                    vmin=min(map(np.min, maps.values())), vmax=max(map(np.max, maps.values())))


def figure_7(study):
    styles = {"circular": dict(color=BLUE, linewidth=3), "point": dict(color=GREEN),
              "linear": dict(color=ORANGE, linestyle="--")}
    figure, (maximum, mean, excess) = plt.subplots(1, 3, figsize=(10, 3.8))
    for load, style in styles.items():
        published, exact = scene_runs(study, f"flat_{load}")
        maximum.semilogy(published["time"][1:], published["strain_max"][1:], **style, label=load)
        mean.semilogy(published["time"][1:], published["strain_mean"][1:], **style, label=load)
        difference = published["strain_max"] - exact["strain_max"]
        excess.plot(published["time"], 100 * difference / exact["strain_max"][-1], **style, label=load)
    maximum.set(title="greatest displacement", xlabel="time (s)", ylabel="displacement")
    mean.set(title="mean displacement", xlabel="time (s)", ylabel="displacement")
    excess.set(title="published minus exact, greatest", xlabel="time (s)", ylabel="% of the final displacement", xlim=(0, 5))
    excess.legend(title="load")
    figure.suptitle("Figure 7: displacement of the flat surface under each load")
    save(figure, study, "figure_07")


def draw_averages(study, name, title, surfaces):
    runs = {s: scene_runs(study, f"{s}_circular") for s in surfaces}
    figure, rows = plt.subplots(4, 2, figsize=(9, 10))
    averages = {"as plotted in the study: five points, weights 1/3125 to 1/5": plotted_average,
                "mean over all cells": cell_mean}
    for column, (column_title, value) in enumerate(averages.items()):
        rows[0, column].set_title(column_title)
        for axes, quantity in zip(rows[:, column], RESPONSES):
            draw_response(axes, quantity, [Curve(f"{s}, published method", colour, runs[s], value)
                                           for s, colour in surfaces.items()])
    rows[0, 1].legend(loc="lower right")
    figure.suptitle(title)
    save(figure, study, name)


def figure_8(study):
    draw_averages(study, "figure_08", "Figure 8: average responses of wave and spiral ridges, circular load",
                  {"wave": BLUE, "spiral": VERMILLION})


def figure_9(study):
    draw_averages(study, "figure_09", "Figure 9: average responses of flat skin and spiral ridges, circular load",
                  {"flat": GREEN, "spiral": VERMILLION})


def figure_10(study):
    runs = scene_runs(study, "wave_circular")
    colours = [BLUE, VERMILLION, GREEN, ORANGE, PURPLE]
    curves = [Curve(f"x, y = {x}, {y}", colours[k], runs, probe_value(k)) for k, (x, y) in enumerate(PROBES)]
    figure, panels = plt.subplot_mosaic([["map", "sa1", "sa2"], ["key", "fa1", "fa2"]], figsize=(11, 6.2))
    panels["map"].imshow(np.load(study / "maps/surface_wave.npy"), cmap="gray", origin="lower", alpha=0.6)
    panels["map"].contour(np.load(study / "maps/pressure_circular.npy"), levels=[1e-6], colors="black", linestyles=":")
    panels["map"].scatter(*zip(*PROBES), c=colours, s=60, edgecolors="black", zorder=3)
    panels["map"].set(title="the points; dotted: edge of the load", xlabel="x (cells)", ylabel="y (cells)")
    for quantity in RESPONSES:
        draw_response(panels[quantity], quantity, curves)
    panels["key"].axis("off")
    panels["key"].legend(*panels["sa1"].get_legend_handles_labels(), loc="center", fontsize=10,
                         title="published method, at")
    figure.suptitle("Figure 10: responses at five points of the wave surface, circular load; two points lie outside it")
    save(figure, study, "figure_10")


def draw_sweep(study, name, title, sweep, symbol, tail_scale):
    folders = sorted((study / sweep).iterdir(), key=lambda folder: float(folder.name))
    colours = plt.cm.viridis(np.linspace(0, 0.9, len(folders)))
    curves = [Curve(symbol.format(folder.name), colour, scene_runs(folder, ""), cell_mean)
              for folder, colour in zip(folders, colours)]
    figure, panels = plt.subplots(2, 2, figsize=(9.5, 6.8))
    for axes, quantity in zip(panels.flat, RESPONSES):
        draw_response(axes, quantity, curves, tail_scale)
    panels[1, 0].legend()
    figure.suptitle(title)
    save(figure, study, name)


def figure_11(study):
    draw_sweep(study, "figure_11", "Figure 11: stiffer skin responds less (wave surface, circular load, mean over all cells)",
               "sweep_modulus", "modulus {} Pa", "linear")


def figure_12(study):
    draw_sweep(study, "figure_12", "Figure 12: less viscous skin responds faster (wave surface, circular load, mean over all cells)",
               "sweep_viscosity", "viscosity {} Pa·s", "symlog")


def error_vs_time(study):
    with open(study / "chart.csv") as file:
        rows = sorted(csv.DictReader(file), key=lambda row: float(row["step"]))
    note = study / "chart_device.txt"
    machines = sorted({(row["device"], row["precision"]) for row in rows})
    colours = dict(zip(machines, [BLUE, VERMILLION, GREEN, ORANGE, PURPLE]))
    styles = {"exact": dict(marker="s", linestyle="-"), "euler": dict(marker="o", linestyle="--", fillstyle="none")}
    costs = {"ns_per_cell_step": "ns per cell and step", "ns_per_cell_second": "ns per cell and simulated second"}
    figure, panels = plt.subplot_mosaic([list(costs), ["key", "key"]], figsize=(9, 5.6), height_ratios=[5, 1])
    for cost, label in costs.items():
        axes = panels[cost]
        for method, style in styles.items():
            for device, precision in machines:
                ladder = [row for row in rows if (row["method"], row["device"], row["precision"]) == (method, device, precision)]
                axes.loglog([float(row[cost]) for row in ladder],
                            [max(float(row["error_strain"]), 1e-17) for row in ladder],
                            color=colours[device, precision], label=f"{method}, {precision}, {device}", **style)
        for bits, kind in ((24, "float"), (53, "double")):
            axes.axhline(2.0 ** -bits, color="0.3", linestyle=":")
            axes.text(0.98, 2.0 ** -bits * 1.3, f"{kind} rounding $2^{{-{bits}}}$", ha="right", fontsize=10,
                      transform=axes.get_yaxis_transform())
        axes.set(xlabel=label, ylabel="greatest strain error / final strain", ylim=(4e-18, 10))
        axes.grid(alpha=0.3)
    panels["key"].axis("off")
    panels["key"].legend(*axes.get_legend_handles_labels(), loc="center", ncol=2)
    figure.suptitle("Error against cost" + ("\n" + note.read_text().strip() if note.exists() else ""))
    save(figure, study, "error_vs_time")


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: figures.py DIR")
    study = Path(sys.argv[1])
    (study / "figures").mkdir(exist_ok=True)
    plt.rcParams.update({"savefig.dpi": 150, "font.size": 9, "axes.titlesize": 9.5, "legend.fontsize": 8,
                         "figure.constrained_layout.use": True})
    for draw in (figure_3, figure_4, figure_5, figure_6, figure_7, figure_8, figure_9, figure_10, figure_11, figure_12,
                 error_vs_time):
        draw(study)


main()
