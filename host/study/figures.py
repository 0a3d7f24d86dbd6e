# SPDX-License-Identifier: MIT
"""Draws figures 3 to 12 of the published study and error against cost into the folder figures."""
import io
from collections import namedtuple
from concurrent.futures import ProcessPoolExecutor
from itertools import repeat

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image  # matplotlib's own requirement

from results import LOADS, METHODS, PLOTTED_WEIGHTS, PROBES, SURFACES, SWEEPS, Results

plt.rcdefaults()  # none of the user's settings changes a picture
plt.rcParams.update({"figure.dpi": 150, "figure.constrained_layout.use": True, "font.size": 9, "axes.titlesize": 9.5,
                     "legend.fontsize": 8})
BLUE, VERMILLION, GREEN, ORANGE, PURPLE = "#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7"
EXACT_LINE = dict(color="black", linestyle=(0, (4, 3)), linewidth=0.8)
RESPONSES = {"sa1": "SA1", "sa2": "SA2 (s)", "fa1": "FA1 (1/s)", "fa2": "FA2 (1/s²)"}
SHOWN_SECONDS = {"sa1": 10, "sa2": 10, "fa1": 4, "fa2": 4}
SPIKE_SAMPLES = 2  # the published central difference sees the jump of the load in these
RIDGES = "ridge heights"  # the unit of heights and displacements: the surfaces' relief is 1
ZERO = 1e-18  # where an error of 0 stands on a logarithmic axis

Curve = namedtuple("Curve", "label colour published exact")


def cell_mean(trace):
    return {"time": trace["time"]} | {q: trace[f"{q}_mean"] for q in RESPONSES}


def probe_sum(trace, weights):
    return {"time": trace["time"]} | {q: sum(w * trace[f"{q}_probe{k}"] for k, w in enumerate(weights))
                                      for q in RESPONSES}


def plotted_average(trace):
    return probe_sum(trace, PLOTTED_WEIGHTS)


# A palette takes a third of the bytes of full colour.
def save(figure, study, name):
    figure.canvas.draw()
    image = Image.fromarray(np.asarray(figure.canvas.buffer_rgba())[..., :3])
    png = io.BytesIO()
    image.quantize(256, Image.Quantize.MAXCOVERAGE).save(png, format="png", optimize=True)
    study.write(f"figures/{name}.png", png.getvalue())
    plt.close(figure)


def draw_map(axes, values, title, cmap="cividis", **options):
    axes.set(title=title, xlabel="x (cells)", ylabel="y (cells)")
    return axes.imshow(values, cmap=cmap, origin="lower", interpolation="nearest", **options)


# Both figures of the surfaces have one range of colours, so that before and after can be compared.
def read_surfaces(study):
    before = [study.surface(surface) for surface in SURFACES]
    return before, [study.field(f"published/{surface}_circular", "deformation") for surface in SURFACES]


def draw_surfaces(study, name, title, maps, low, high):
    figure, panels = plt.subplots(1, 3, figsize=(10, 3.3))
    for axes, surface, values in zip(panels, SURFACES, maps):
        image = draw_map(axes, values, surface, vmin=low, vmax=high)
    figure.colorbar(image, ax=panels, label=f"height ({RIDGES})", shrink=0.85)
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


# The spike of FA2 grows as one over the time step and hides what follows it: the axis ends before it, and its height is
# told. symlog: linear below this value, logarithmic beyond, where curves differ by decades; the spike is then shown.
def draw_response(axes, quantity, curves, symlog=None):
    draw_lines(axes, quantity, curves)
    axes.set(xlabel="time (s)", ylabel=RESPONSES[quantity])
    if quantity != "fa2":
        return
    spikes = [max(c.published["fa2"][:SPIKE_SAMPLES]) for c in curves]
    if symlog:
        axes.set_yscale("symlog", linthresh=symlog)
        axes.set_ylabel(f"{RESPONSES['fa2']}, symlog: linear within ±{symlog:g}")
        return
    after = [c[quantity][SPIKE_SAMPLES:] for pair in curves for c in (pair.published, pair.exact)]
    low = min(values.min() for values in after)
    axes.set_ylim(1.1 * low, -0.35 * low)
    axes.text(0.03, 0.95, f"cut off: published spike up to {max(spikes):.3g} at {curves[0].published['time'][1]:g} s",
              transform=axes.transAxes, va="top", fontsize=8)


def figure_03(study):
    before, after = read_surfaces(study)
    draw_surfaces(study, "figure_03", "Figure 3: the three surfaces before any load", before,
                  np.min(after), np.max(before))


def figure_04(study):
    figure, panels = plt.subplots(1, 3, figsize=(10, 3.1))
    for axes, load in zip(panels, LOADS):
        pressure = study.pressure(load)
        image = draw_map(axes, pressure, f"{load}, peak {pressure.max():.2g} Pa")
        figure.colorbar(image, ax=axes, label="pressure (Pa)", fraction=0.046)
    figure.suptitle("Figure 4: the three pressure maps, each with its own scale")
    save(figure, study, "figure_04")


def figure_05(study):
    before = study.surface("spiral")
    after, exact = (study.field(f"{method}/spiral_circular", "deformation") for method in METHODS)
    figure = plt.figure(figsize=(9, 7))
    y, x = np.indices(before.shape)
    for place, values, title in ((221, before, "before"), (222, after, "after 9.99 s under the load")):
        axes = figure.add_subplot(place, projection="3d", facecolor="none")
        axes.plot_surface(x, y, values, cmap="cividis", rcount=75, ccount=75, antialiased=False,
                          vmin=after.min(), vmax=before.max())
        axes.set(xlabel="x (cells)", ylabel="y (cells)", zlabel=f"height ({RIDGES})", zlim=(after.min(), before.max()),
                 xticks=(0, 50, 100, 150), yticks=(0, 50, 100, 150), zticks=(0, 0.5, 1))
        axes.set_title(title, y=0.98)
        axes.set_box_aspect((1, 1, 0.45), zoom=1.08)
    profile, displacement = figure.add_subplot(223), figure.add_subplot(224)
    profile.plot(before[75], color=BLUE, label="before")
    profile.plot(after[75], color=VERMILLION, label="after, published method")
    profile.plot(exact[75], **EXACT_LINE, label="after, exact solution")
    profile.set(title="profile along y = 75", xlabel="x (cells)", ylabel=f"height ({RIDGES})")
    profile.legend(loc="lower right")
    image = draw_map(displacement, before - after, "displacement: before minus after")
    figure.colorbar(image, ax=displacement, label=f"displacement ({RIDGES})", fraction=0.046)
    figure.suptitle("Figure 5: the circular load presses a hollow into the spiral ridges")
    save(figure, study, "figure_05")


def figure_06(study):
    before, after = read_surfaces(study)
    draw_surfaces(study, "figure_06", "Figure 6: the surfaces after 9.99 s under the circular load (colours as in figure 3)",
                  after, np.min(after), np.max(before))


def figure_07(study):
    styles = [dict(color=BLUE, linewidth=3.5), dict(color=GREEN, linewidth=2), dict(color=ORANGE, linestyle="--")]
    figure, (greatest, mean, excess) = plt.subplots(1, 3, figsize=(10, 3.6))
    for load, style in zip(LOADS, styles):
        published, exact = (study.traces(f"{method}/flat_{load}") for method in METHODS)
        greatest.semilogy(published["time"][1:], published["strain_max"][1:], **style)
        mean.semilogy(published["time"][1:], published["strain_mean"][1:], **style)
        difference = published["strain_max"] - exact["strain_max"]
        excess.plot(published["time"], 100 * difference / exact["strain_max"][-1], **style, label=load)
    for axes, title in ((greatest, "greatest displacement"), (mean, "mean displacement"),
                        (excess, "published minus exact, greatest\n(the three curves coincide)")):
        axes.set(title=title, ylabel=f"displacement ({RIDGES})", xlabel="time (s)", xlim=(0, 10))
    excess.set_ylabel("% of the final displacement")
    excess.legend(title="load")
    figure.suptitle("Figure 7: displacement of the flat surface under each load, published method")
    save(figure, study, "figure_07")


def draw_averages(study, name, title, colours):
    traces = {s: [study.traces(f"{method}/{s}_circular") for method in METHODS] for s in colours}
    figure, rows = plt.subplots(4, 2, figsize=(8.5, 9.6))
    averages = {"the study's average:\nfive points weighted 1/3125 to 1/5": plotted_average,
                "mean over all cells": cell_mean}
    for column, (heading, average) in zip(rows.T, averages.items()):
        curves = [Curve(f"{s}, published method", colours[s], *map(average, traces[s])) for s in colours]
        for axes, quantity in zip(column, RESPONSES):
            draw_response(axes, quantity, curves)
        first, second = (c.published["sa1"][-1] for c in curves)
        excess = 100 * (second / first - 1)
        alike = ": the curves coincide" if abs(excess) < 0.5 else ""
        column[0].set_title(f"{heading}{alike}\nfinal SA1, {' over '.join(reversed(colours))}: {excess:+.2f} %")
        column[0].legend(loc="lower right")
    figure.suptitle(f"{title} under the circular load")
    save(figure, study, name)


def figure_08(study):
    draw_averages(study, "figure_08", "Figure 8: average responses of wave and spiral ridges",
                  {"wave": BLUE, "spiral": ORANGE})


def figure_09(study):
    draw_averages(study, "figure_09", "Figure 9: average responses of flat skin and spiral ridges",
                  {"flat": GREEN, "spiral": ORANGE})


def figure_10(study):
    traces = [study.traces(f"{method}/wave_circular") for method in METHODS]
    colours = [BLUE, VERMILLION, GREEN, ORANGE, PURPLE]
    curves = [Curve(f"x = {x}, y = {y}", colour, *(probe_sum(trace, weights) for trace in traces))
              for (x, y), colour, weights in zip(PROBES, colours, np.eye(5))]
    figure, panels = plt.subplot_mosaic([["map", "sa1", "sa2"], ["key", "fa1", "fa2"]], figsize=(11, 6.2))
    draw_map(panels["map"], study.surface("wave"), "the five points; dotted: edge of the load",
             cmap="gray", alpha=0.5)
    panels["map"].contour(study.pressure("circular"), levels=[1e-6], colors="black", linestyles=":")
    panels["map"].scatter(*zip(*PROBES), c=colours, s=60, edgecolors="black", zorder=3)
    for quantity in RESPONSES:
        draw_response(panels[quantity], quantity, curves)
    panels["key"].axis("off")
    panels["key"].legend(*panels["sa1"].get_legend_handles_labels(), loc="center", title="published method")
    figure.suptitle("Figure 10: responses at five points of the wave surface: none outside the circular load")
    save(figure, study, "figure_10")


def draw_sweep(study, name, title, sweep, label, symlog=None):
    colours = plt.cm.viridis(np.linspace(0.2, 0.9, len(SWEEPS[sweep])))
    curves = [Curve(label.format(value), colour,
                    *(cell_mean(study.traces(f"sweep_{sweep}/{value}/{method}")) for method in METHODS))
              for value, colour in zip(SWEEPS[sweep], colours)]
    figure, panels = plt.subplots(2, 2, figsize=(9.5, 6.6))
    for axes, quantity in zip(panels.flat, RESPONSES):
        draw_response(axes, quantity, curves, symlog)
    panels[1, 0].legend(title="published method")
    figure.suptitle(f"{title}\nwave surface, circular load, mean over all cells")
    save(figure, study, name)


def figure_11(study):
    draw_sweep(study, "figure_11", "Figure 11: the stiffer the skin, the lower SA1 and SA2",
               "modulus", "E = {} Pa")


def figure_12(study):
    draw_sweep(study, "figure_12", "Figure 12: the less viscous the skin, the faster SA1 and the sharper FA1 and FA2",
               "viscosity", "η = {} Pa·s", symlog=0.01)


# A logarithmic axis of errors that ends in 0.
def error_axes(axes, top):
    axes.set(xscale="log", yscale="log", ylim=(ZERO / 4, top))
    decades = np.arange(-16, np.log10(top), 4)
    axes.set_yticks([ZERO, *10.0 ** decades], ["0", *(f"$10^{{{d:g}}}$" for d in decades)])
    axes.yaxis.set_minor_locator(matplotlib.ticker.NullLocator())
    axes.axhline(4 * ZERO, color="black", linewidth=0.5)
    axes.grid(alpha=0.3)


@plt.rc_context({"font.size": 11, "legend.fontsize": 11})
def error_vs_time(study):
    rows = np.genfromtxt(study.out / "chart.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
    rows.sort(order="step")
    machines = np.unique(rows[["precision", "device"]])
    styles = {"exact": dict(marker="s"), "euler": dict(marker="o", fillstyle="none")}
    figure, panels = plt.subplot_mosaic([["step", "second"], ["key", "key"]], figsize=(9, 5.6), height_ratios=[5, 1])
    for axes, cost, label in ((panels["step"], "ns_per_cell_step", "ns per cell and step"),
                              (panels["second"], "ns_per_cell_second", "ns per cell and simulated second")):
        for method, style in styles.items():
            for machine, colour in zip(machines, [BLUE, ORANGE, GREEN, PURPLE, VERMILLION]):
                ladder = rows[(rows["method"] == method) & (rows[["precision", "device"]] == machine)]
                axes.plot(ladder[cost], np.maximum(ladder["error_strain"], ZERO), color=colour, **style,
                            label=f"{method}, {' on '.join(machine)}")
        decades = np.log10(rows[cost])
        error_axes(axes, 10)
        axes.set(xlabel=label, xlim=10 ** np.array([np.floor(decades.min()), np.ceil(decades.max())]))
        axes.xaxis.set_major_formatter("{x:g}")
        axes.xaxis.set_minor_formatter("")
        for exponent in (-24, -53):
            axes.axhline(2.0 ** exponent, color="black", linestyle=":")
    for kind, exponent in (("float", -24), ("double", -53)):
        axes.text(1.02, 2.0 ** exponent, f"{kind}\nrounding\n$2^{{{exponent}}}$", va="center",
                  transform=axes.get_yaxis_transform())
    panels["step"].set_ylabel("greatest strain error / final strain")
    panels["key"].axis("off")
    panels["key"].legend(*axes.get_legend_handles_labels(), loc="center", ncol=2)
    caveat = ""
    if "vulkan" in rows["device"]:
        device = study.summary("chart/vulkan_f32/1")["device"]
        software = ", a software driver on the CPU's own cores" if device["kind"] == "software" else ""
        caveat = f"\nVulkan: {device['name']}{software}"
    figure.suptitle(f"Error against cost; each line joins time steps from {rows['step'][-1]:.2g} to "
                    f"{rows['step'][0]:.2g} s, the least of three runs each{caveat}", fontsize=10.5)
    save(figure, study, "error_vs_time")


FIGURES = {figure.__name__: figure for figure in (figure_03, figure_04, figure_05, figure_06, figure_07, figure_08, figure_09,
                                                  figure_10, figure_11, figure_12, error_vs_time)}


def draw(name, out):
    FIGURES[name](Results(None, out, False))


def draw_all(out):
    with ProcessPoolExecutor() as pool:
        list(pool.map(draw, FIGURES, repeat(out)))  # raises what a figure raises
