# SPDX-License-Identifier: MIT
"""Draws figures 3 to 12 of the published study, and error against cost, from a results folder into its figures/."""
import sys
from collections import namedtuple
from pathlib import Path

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image  # matplotlib's own requirement

BLUE, VERMILLION, GREEN, ORANGE, PURPLE = "#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7"
EXACT_LINE = dict(color="black", linestyle=(0, (4, 3)), linewidth=0.8)
SURFACES = ["flat", "wave", "spiral"]
LOADS = ["circular", "point", "linear"]
METHODS = ["published", "exact"]
RESPONSES = {"sa1": "SA1", "sa2": "SA2 (s)", "fa1": "FA1 (1/s)", "fa2": "FA2 (1/s²)"}
SHOWN_SECONDS = {"sa1": 10, "sa2": 10, "fa1": 4, "fa2": 4}
PROBES = [(75, 75), (85, 85), (60, 80), (37, 37), (112, 112)]
SPIKE_SAMPLES = 2  # the published central difference sees the jump of the load in these

Curve = namedtuple("Curve", "label colour published exact")


def read_trace(folder):
    with open(folder / "traces.csv") as file:
        names = file.readline().strip().split(",")
        return dict(zip(names, np.loadtxt(file, delimiter=",", unpack=True)))


def read_deformation(study, method, scene):
    return np.load(study / method / scene / "deformation_t9.99.npy")


def cell_mean(trace):
    return {"time": trace["time"]} | {q: trace[f"{q}_mean"] for q in RESPONSES}


def probe_sum(trace, weights):
    return {"time": trace["time"]} | {q: sum(w * trace[f"{q}_probe{k}"] for k, w in enumerate(weights))
                                      for q in RESPONSES}


# The study divides by the number of points inside its loop over them, so point k ends with the weight 5^(k - 5).
def plotted_average(trace):
    return probe_sum(trace, [5.0 ** (k - 5) for k in range(5)])


# A palette takes a third of the bytes of full colour.
def save(figure, study, name):
    figure.canvas.draw()
    image = Image.fromarray(np.asarray(figure.canvas.buffer_rgba())[..., :3])
    image.quantize(256, Image.Quantize.MAXCOVERAGE).save(study / "figures" / f"{name}.png", optimize=True)
    plt.close(figure)


def draw_map(axes, values, title, cmap="cividis", **options):
    axes.set(title=title, xlabel="x (cells)", ylabel="y (cells)")
    return axes.imshow(values, cmap=cmap, origin="lower", interpolation="nearest", **options)


def draw_surfaces(study, name, title, maps):
    figure, panels = plt.subplots(1, 3, figsize=(10, 3.3))
    for axes, surface, values in zip(panels, SURFACES, maps):
        image = draw_map(axes, values, surface, vmin=np.min(maps), vmax=np.max(maps))
    figure.colorbar(image, ax=panels, label="height", shrink=0.85)
    figure.suptitle(title)
    save(figure, study, name)


# Later curves are thinner, so that a curve under another can be seen.
def draw_lines(axes, quantity, curves, first=0):
    for c, width in zip(curves, np.linspace(3, 1.5, len(curves))):
        axes.plot(c.published["time"][first:], c.published[quantity][first:], color=c.colour, linewidth=width,
                  label=c.label)
    for c in curves:
        axes.plot(c.exact["time"][first:], c.exact[quantity][first:], **EXACT_LINE,
                  label="exact solution" if c is curves[-1] else None)
    axes.set_xlim(0, SHOWN_SECONDS[quantity])


# The spike of FA2 grows as one over the time step and hides what follows it: the rest gets an inset.
def draw_response(axes, quantity, curves, tail_ticks=None):
    draw_lines(axes, quantity, curves)
    axes.set(xlabel="time (s)", ylabel=RESPONSES[quantity])
    if quantity == "fa2":
        inset = axes.inset_axes([0.36, 0.36, 0.61, 0.52])
        draw_lines(inset, quantity, curves, SPIKE_SAMPLES)
        if tail_ticks:
            inset.set_yscale("symlog", linthresh=-tail_ticks[1])
            inset.set(yticks=tail_ticks, ylim=(tail_ticks[-1], -tail_ticks[1] / 2))
        inset.tick_params(labelsize=7)
        inset.set_title("the same after the spike", fontsize=8, pad=3)


def figure_3(study):
    draw_surfaces(study, "figure_03", "Figure 3: the three surfaces before any load",
                  [np.load(study / f"maps/surface_{surface}.npy") for surface in SURFACES])


def figure_4(study):
    figure, panels = plt.subplots(1, 3, figsize=(10, 3.1))
    for axes, load in zip(panels, LOADS):
        pressure = np.load(study / f"maps/pressure_{load}.npy")
        image = draw_map(axes, pressure, f"{load}, peak {pressure.max():.2g} Pa")
        figure.colorbar(image, ax=axes, label="pressure (Pa)", fraction=0.046)
    figure.suptitle("Figure 4: the three pressure maps, each with its own scale")
    save(figure, study, "figure_04")


def figure_5(study):
    before = np.load(study / "maps/surface_spiral.npy")
    after, exact = (read_deformation(study, method, "spiral_circular") for method in METHODS)
    figure = plt.figure(figsize=(9, 7))
    y, x = np.indices(before.shape)
    for place, values, title in ((221, before, "before"), (222, after, "after 9.99 s under the load")):
        axes = figure.add_subplot(place, projection="3d", facecolor="none")
        axes.plot_surface(x, y, values, cmap="cividis", rcount=75, ccount=75, antialiased=False,
                          vmin=after.min(), vmax=before.max())
        axes.set(xlabel="x (cells)", ylabel="y (cells)", zlabel="height", zlim=(after.min(), before.max()),
                 xticks=(0, 50, 100, 150), yticks=(0, 50, 100, 150), zticks=(0, 0.5, 1))
        axes.set_title(title, y=0.98)
        axes.set_box_aspect((1, 1, 0.45), zoom=1.08)
    profile, displacement = figure.add_subplot(223), figure.add_subplot(224)
    profile.plot(before[75], color=BLUE, label="before")
    profile.plot(after[75], color=VERMILLION, label="after, published method")
    profile.plot(exact[75], **EXACT_LINE, label="after, exact solution")
    profile.set(title="profile along y = 75", xlabel="x (cells)", ylabel="height")
    profile.legend(loc="lower right")
    image = draw_map(displacement, before - after, "displacement: before minus after")
    figure.colorbar(image, ax=displacement, label="displacement", fraction=0.046)
    figure.suptitle("Figure 5: the circular load presses a hollow into the spiral ridges")
    save(figure, study, "figure_05")


def figure_6(study):
    draw_surfaces(study, "figure_06", "Figure 6: the surfaces after 9.99 s under the circular load",
                  [read_deformation(study, "published", f"{surface}_circular") for surface in SURFACES])


def figure_7(study):
    styles = [dict(color=BLUE, linewidth=3.5), dict(color=GREEN, linewidth=2), dict(color=ORANGE, linestyle="--")]
    figure, (greatest, mean, excess) = plt.subplots(1, 3, figsize=(10, 3.6))
    for load, style in zip(LOADS, styles):
        published, exact = (read_trace(study / method / f"flat_{load}") for method in METHODS)
        greatest.semilogy(published["time"][1:], published["strain_max"][1:], **style)
        mean.semilogy(published["time"][1:], published["strain_mean"][1:], **style)
        difference = published["strain_max"] - exact["strain_max"]
        excess.plot(published["time"], 100 * difference / exact["strain_max"][-1], **style, label=load)
    for axes, title in ((greatest, "greatest displacement"), (mean, "mean displacement"),
                        (excess, "published minus exact, greatest\n(the three curves coincide)")):
        axes.set(title=title, ylabel="displacement", xlabel="time (s)", xlim=(0, 10))
    excess.set_ylabel("% of the final displacement")
    excess.legend(title="load")
    figure.suptitle("Figure 7: displacement of the flat surface under each load, published method")
    save(figure, study, "figure_07")


def draw_averages(study, name, title, colours):
    traces = {s: [read_trace(study / method / f"{s}_circular") for method in METHODS] for s in colours}
    figure, rows = plt.subplots(4, 2, figsize=(9, 9.6))
    averages = {"the study's average: five points weighted 1/3125 to 1/5": plotted_average,
                "mean over all cells": cell_mean}
    for column, (heading, average) in zip(rows.T, averages.items()):
        curves = [Curve(f"{s}, published method", colours[s], *map(average, traces[s])) for s in colours]
        for axes, quantity in zip(column, RESPONSES):
            draw_response(axes, quantity, curves)
        first, second = (c.published["sa1"][-1] for c in curves)
        excess = 100 * (second / first - 1)
        column[0].set_title(f"{heading}\nfinal SA1, {' over '.join(reversed(colours))}: {excess:+.2f} %")
        column[0].legend(loc="lower right")
    figure.suptitle(f"{title} under the circular load")
    save(figure, study, name)


def figure_8(study):
    draw_averages(study, "figure_08", "Figure 8: average responses of wave and spiral ridges",
                  {"wave": BLUE, "spiral": ORANGE})


def figure_9(study):
    draw_averages(study, "figure_09", "Figure 9: average responses of flat skin and spiral ridges",
                  {"flat": GREEN, "spiral": ORANGE})


def figure_10(study):
    traces = [read_trace(study / method / "wave_circular") for method in METHODS]
    colours = [BLUE, VERMILLION, GREEN, ORANGE, PURPLE]
    curves = [Curve(f"x = {x}, y = {y}", colour, *(probe_sum(trace, weights) for trace in traces))
              for (x, y), colour, weights in zip(PROBES, colours, np.eye(5))]
    figure, panels = plt.subplot_mosaic([["map", "sa1", "sa2"], ["key", "fa1", "fa2"]], figsize=(11, 6.2))
    draw_map(panels["map"], np.load(study / "maps/surface_wave.npy"), "the five points; dotted: edge of the load",
             cmap="gray", alpha=0.5)
    panels["map"].contour(np.load(study / "maps/pressure_circular.npy"), levels=[1e-6], colors="black", linestyles=":")
    panels["map"].scatter(*zip(*PROBES), c=colours, s=60, edgecolors="black", zorder=3)
    for quantity in RESPONSES:
        draw_response(panels[quantity], quantity, curves)
    panels["key"].axis("off")
    panels["key"].legend(*panels["sa1"].get_legend_handles_labels(), loc="center", title="published method")
    figure.suptitle("Figure 10: responses at five points of the wave surface: none outside the circular load")
    save(figure, study, "figure_10")


def draw_sweep(study, name, title, sweep, label, tail_ticks=None):
    folders = sorted((study / sweep).iterdir(), key=lambda folder: float(folder.name))
    colours = plt.cm.viridis(np.linspace(0.2, 0.9, len(folders)))
    curves = [Curve(label.format(folder.name), colour, *(cell_mean(read_trace(folder / method)) for method in METHODS))
              for folder, colour in zip(folders, colours)]
    figure, panels = plt.subplots(2, 2, figsize=(9.5, 6.6))
    for axes, quantity in zip(panels.flat, RESPONSES):
        draw_response(axes, quantity, curves, tail_ticks)
    panels[1, 0].legend(title="published method")
    figure.suptitle(f"{title}\nwave surface, circular load, mean over all cells")
    save(figure, study, name)


def figure_11(study):
    draw_sweep(study, "figure_11", "Figure 11: the stiffer the skin, the lower SA1 and SA2",
               "sweep_modulus", "E = {} Pa")


def figure_12(study):
    draw_sweep(study, "figure_12", "Figure 12: the less viscous the skin, the faster SA1 and the sharper FA1 and FA2",
               "sweep_viscosity", "η = {} Pa·s", tail_ticks=(0, -0.1, -1, -10))


@plt.rc_context({"font.size": 11, "legend.fontsize": 11})
def error_vs_time(study):
    rows = np.genfromtxt(study / "chart.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
    rows.sort(order="step")
    note = study / "chart_device.txt"
    machines = np.unique(rows[["precision", "device"]])
    styles = {"exact": dict(marker="s"), "euler": dict(marker="o", fillstyle="none")}
    figure, panels = plt.subplot_mosaic([["step", "second"], ["key", "key"]], figsize=(9, 5.6), height_ratios=[5, 1])
    for axes, cost, label in ((panels["step"], "ns_per_cell_step", "ns per cell and step"),
                              (panels["second"], "ns_per_cell_second", "ns per cell and simulated second")):
        for method, style in styles.items():
            for machine, colour in zip(machines, [BLUE, ORANGE, GREEN, PURPLE, VERMILLION]):
                ladder = rows[(rows["method"] == method) & (rows[["precision", "device"]] == machine)]
                axes.loglog(ladder[cost], np.maximum(ladder["error_strain"], 1e-17), color=colour, **style,
                            label=f"{method}, {' on '.join(machine)}")
        decades = np.log10(rows[cost])
        axes.set(xlabel=label, xlim=10 ** np.array([np.floor(decades.min()), np.ceil(decades.max())]), ylim=(3e-18, 10))
        axes.xaxis.set_major_formatter("{x:g}")
        axes.xaxis.set_minor_formatter("")
        axes.grid(alpha=0.3)
        for exponent in (-24, -53):
            axes.axhline(2.0 ** exponent, color="black", linestyle=":")
    for kind, exponent in (("float", -24), ("double", -53)):
        axes.text(1.02, 2.0 ** exponent, f"{kind}\nrounding\n$2^{{{exponent}}}$", va="center",
                  transform=axes.get_yaxis_transform())
    panels["step"].set_ylabel("greatest strain error / final strain")
    panels["key"].axis("off")
    panels["key"].legend(*axes.get_legend_handles_labels(), loc="center", ncol=2)
    caveat = "\n" + note.read_text().strip() if note.exists() else ""
    figure.suptitle(f"Error against cost; each line joins time steps from {rows['step'][-1]:.2g} to "
                    f"{rows['step'][0]:.2g} s{caveat}", fontsize=10.5)
    save(figure, study, "error_vs_time")


@plt.rc_context({"font.size": 10, "legend.fontsize": 9})
def stability(study):
    rows = np.genfromtxt(study / "stability.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
    courses = np.genfromtxt(study / "failures.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
    figure, (errors, failures) = plt.subplots(1, 2, figsize=(10, 4.4), width_ratios=[3, 2])
    colours = {"euler": VERMILLION, "rk2": ORANGE, "rk4": PURPLE, "backward-euler": GREEN, "crank-nicolson": "grey",
               "sdirk2": "saddlebrown", "exact": BLUE}
    top = 1e3
    for method, colour in colours.items():
        for precision in ("f32", "f64"):
            line = rows[(rows["method"] == method) & (rows["precision"] == precision)]
            if not line.size:
                continue
            bare = method != "exact"
            errors.loglog(line["z"], np.clip(line["error"], 1e-17, top), color=colour, lw=1.6 if bare else 2.4,
                          ls="-" if precision == "f64" else "--", label=method if bare else f"{method}, {precision}")
    errors.axhspan(1, top, color="black", alpha=0.06)
    errors.text(1.5e-6, 20, "error as large as the strain: unstable", fontsize=9)
    errors.set(xlabel="step over retardation time, z = dt/tau", ylabel="greatest error / final strain", ylim=(1e-17, top),
               title="held load, first steps at each z")
    errors.grid(alpha=0.3)
    errors.legend(loc="lower right", bbox_to_anchor=(1, 0.03), fontsize=8)
    for method in dict.fromkeys(courses["method"]):
        line = courses[courses["method"] == method]
        failures.plot(line["step"], line["strain"], color=colours[method], marker="o", ms=3,
                      label=f"{method}, z = {line['z'][0]:g}")
    failures.axhline(1, color="black", lw=0.8, ls=":")
    failures.set(xlabel="step", ylabel="strain / (pressure/modulus)", ylim=(-1.5, 3.2), title="what failing looks like")
    failures.legend(fontsize=8, ncol=2, loc="upper center", bbox_to_anchor=(0.5, -0.15))
    save(figure, study, "stability")


if len(sys.argv) != 2:
    sys.exit("usage: figures.py DIR")
folder = Path(sys.argv[1])
(folder / "figures").mkdir(exist_ok=True)
plt.rcParams.update({"figure.dpi": 150, "figure.constrained_layout.use": True, "font.size": 9, "axes.titlesize": 9.5,
                     "legend.fontsize": 8})
for draw in (figure_3, figure_4, figure_5, figure_6, figure_7, figure_8, figure_9, figure_10, figure_11, figure_12,
             error_vs_time, stability):
    draw(folder)
