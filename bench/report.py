# SPDX-License-Identifier: MIT
"""Pictures and the page RESULTS.md of a run of dermis-bench: report.py results.csv folder [picture ..].

All of them, or only the named pictures."""

import csv
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image  # matplotlib's own requirement

import depth as of_depth
from page import crossings, of, page, places, shape

BLUE, VERMILLION, GREEN, ORANGE, PURPLE, SKY = "#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7", "#56B4E9"
METHOD = {
    "euler": VERMILLION,
    "rk2": ORANGE,
    "rk4": PURPLE,
    "backward-euler": "grey",
    "crank-nicolson": SKY,
    "sdirk2": GREEN,
    "exact": BLUE,
}
QUANTITIES = {
    "err_strain": "strain",
    "err_sa1": "SA1",
    "err_sa2": "SA2",
    "err_fa1": "FA1",
    "err_fa2": "FA2",
    "err_curvature": "curvature (against the continuum)",
}
SIMULATED_SECONDS = 2.56  # of the rows of accuracy and stiff
FLOORS = {"float": 2.0**-24, "double": 2.0**-53}
ZERO = 1e-18  # where an error of 0 stands on a logarithmic axis
SIZES = {"256": GREEN, "512": SKY, "1024": ORANGE, "2048": BLUE, "4096": "black"}
PEERS = {
    "native": ("p", "black"),
    "pocl": ("h", PURPLE),
    "halide": ("<", VERMILLION),
    "numba": ("P", "grey"),
    "numpy": ("X", ORANGE),
}


def number(text):
    return float(text) if text else np.nan


# Pictures take the least of the runs, tables the median.
def load(path):
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        row["cells"] = number(row["width"]) * number(row["height"])
        row["seconds"], row["least"] = number(row["wall_median_s"]), number(row["wall_least_s"])
        steps = row["cells"] * max(number(row["steps"]), 1) if row["width"] else np.nan
        row["ns"], row["least_ns"] = row["seconds"] * 1e9 / steps, row["least"] * 1e9 / steps
        row["cost"] = row["least"] * 1e9 / row["cells"] / SIMULATED_SECONDS
    return rows


def origin(rows):
    first = rows[0]
    drivers = sorted({f"{r['driver']} {r['driver_version']}" for r in rows if device_of(r) == "vulkan"})
    return (
        f"{first['cpu']}, {first['cores']} cores, {first['compiler']}{''.join(', ' + d for d in drivers)}; "
        f"commit {first['commit']}, {first['date']}{', quick' if first['size'] == 'quick' else ''}"
    )


# A palette takes a third of the bytes of full colour.
def save(figure, folder, name, rows, bottom=0.0):
    figure.tight_layout(rect=(0, bottom + 0.025, 1, 1))
    figure.text(0.995, 0.008, origin(rows), ha="right", fontsize=7, color="grey")
    figure.canvas.draw()
    image = Image.fromarray(np.asarray(figure.canvas.buffer_rgba())[..., :3])
    image.quantize(256, Image.Quantize.MAXCOVERAGE).save(folder / f"{name}.png", optimize=True)
    plt.close(figure)


def device_of(row):
    return "vulkan" if row["backend"].startswith("vulkan") else "cpu"


# Error upwards on a logarithmic axis that ends in 0, cost to the right: better is below and to the left.
def error_axes(axis, top):
    axis.set(xscale="log", yscale="log", ylim=(ZERO / 3, top))
    ticks = 10.0 ** np.arange(-16, np.log10(top), 4)
    axis.set_yticks([ZERO, *ticks], ["0", *(f"$10^{{{round(np.log10(t))}}}$" for t in ticks)])
    axis.yaxis.set_minor_locator(matplotlib.ticker.NullLocator())
    axis.axhline(ZERO * 4, color="black", linewidth=0.5)
    axis.grid(alpha=0.25)
    for name, floor in FLOORS.items():
        axis.axhline(floor, color="grey", linestyle=(0, (1, 2)), linewidth=1)
        axis.text(
            1, floor * 1.3, f"{name} ", transform=axis.get_yaxis_transform(), color="grey", fontsize=8, ha="right"
        )


def errors(ladder, column):
    return [max(number(r[column]), ZERO) for r in ladder]


# The first picture: five methods on the CPU.
def work_precision(rows, folder):
    figure, axis = plt.subplots(figsize=(8, 5.4))
    cpu = [r for r in of(rows, "accuracy", stencil="five-point") if device_of(r) == "cpu"]
    error_axes(axis, 1e3)
    series = (
        ("euler", "march", "o", VERMILLION, "forward Euler"),
        ("crank-nicolson", "march", "s", GREEN, "Crank-Nicolson (2nd order)"),
        ("rk4", "march", "^", PURPLE, "RK4"),
        ("exact", "march", "D", BLUE, "exact"),
        ("exact", "moments", "*", "black", "moments (closed form)"),
    )
    for method, model, marker, colour, label in series:
        for precision, line, face in (("f64", "-", colour), ("f32", "--", "white")):
            ladder = [r for r in cpu if (r["method"], r["model"], r["precision"]) == (method, model, precision)]
            stable = [r for r in ladder if r["status"] == "ok"]
            if not stable:
                continue
            axis.plot(
                [r["cost"] for r in stable],
                errors(stable, "err_strain"),
                line,
                marker=marker,
                color=colour,
                markerfacecolor=face,
                markersize=11 if marker == "*" else 6,
                linewidth=1.3,
                label=label if precision == "f64" else None,
            )
            refused = [r for r in ladder if r["status"] == "unstable"]
            axis.plot(
                [r["cost"] for r in refused],
                errors(refused, "err_strain"),
                "x",
                color=colour,
                markersize=8,
                markeredgewidth=2,
            )
    explicit = [r for r in cpu if r["method"] in ("euler", "rk4")]
    end = min(r["cost"] for r in explicit if r["status"] == "ok") * 0.93  # the next step is twice as long
    low = axis.get_xlim()[0]
    axis.axvspan(low, end, color="black", alpha=0.07, linewidth=0)
    axis.set_xlim(low, axis.get_xlim()[1] * 1.5)
    beyond = max(number(r["dt_over_tau"]) for r in explicit if r["status"] == "unstable")
    axis.text(
        np.sqrt(low * end),
        5e-12,
        f"steps of {beyond:.1f} tau:\nEuler and RK4\nare refused\n(crosses)",
        ha="center",
        va="center",
        fontsize=10,
    )
    axis.plot([], [], "-", color="black", marker="o", label="filled: double")
    axis.plot([], [], "--", color="black", marker="o", markerfacecolor="white", label="open: float")
    axis.set(
        xlabel="ns per cell and simulated second (least of the runs)",
        ylabel="greatest error of strain / greatest strain",
        title=f"Error against cost, {cpu[0]['width']} x {cpu[0]['height']} cells on the CPU; each line joins step sizes",
    )
    axis.legend(fontsize=9, ncol=2, loc="lower right", bbox_to_anchor=(1, 0.155))
    save(figure, folder, "work_precision", rows)


def series_label(device, model, method, precision, stencil):
    return " ".join(
        filter(
            None,
            [
                method if model == "march" else model,
                {"f32-compensated": "f32 compensated"}.get(precision, precision),
                "Vulkan" if device == "vulkan" else "",
                "4th-order stencil" if stencil != "five-point" else "",
            ],
        )
    )


# Every method, precision, stencil and device, for each quantity.
def work_precision_all(rows, folder):
    figure, axes = plt.subplots(2, 3, figsize=(15, 10))
    series = {}
    for r in of(rows, "accuracy"):
        series.setdefault((device_of(r), r["model"], r["method"], r["precision"], r["stencil"]), []).append(r)
    for axis, (error, title) in zip(axes.flat, QUANTITIES.items()):
        error_axes(axis, 1e4)
        for (device, model, method, precision, stencil), ladder in series.items():
            if stencil != "five-point" and error != "err_curvature":
                continue
            stable = [r for r in ladder if r["status"] == "ok"]
            axis.plot(
                [r["cost"] for r in stable],
                errors(stable, error),
                color="black" if model != "march" else METHOD[method],
                linestyle={"f32": "-", "f64": ":", "f32-compensated": "--"}[precision],
                marker="s" if device == "vulkan" else ("*" if model != "march" else "o"),
                markersize=7 if model != "march" else 3.5,
                markerfacecolor="white" if stencil != "five-point" else None,
                linewidth=1,
                label=series_label(device, model, method, precision, stencil),
            )
            refused = [r for r in ladder if r["status"] == "unstable"]
            axis.plot(
                [r["cost"] for r in refused],
                np.minimum(errors(refused, error), 3e3),
                "x",
                color=METHOD[method],
                markersize=6,
            )
        axis.set(
            title=title,
            xlabel="ns per cell and simulated second (least of the runs)",
            ylabel="greatest error / greatest value",
        )
    axes.flat[5].plot([], [], "x", color="black", label="refused as unstable")
    figure.legend(
        *axes.flat[5].get_legend_handles_labels(), loc="lower center", ncol=6, fontsize=8, bbox_to_anchor=(0.5, 0.025)
    )
    save(figure, folder, "work_precision_all", rows, bottom=0.1)


# Beside loops that move the same bytes and compute nothing: their responses go past the caches or through them, and the
# faster one is the roof.
def roofline(rows, folder):
    figure, axis = plt.subplots(figsize=(8, 5))
    styles = {
        "cpu-avx512": ("o", BLUE),
        "cpu-avx2": ("s", SKY),
        "cpu-plain": ("^", GREEN),
        **PEERS,
        "vulkan": ("D", VERMILLION),
        "vulkan-cell": ("v", PURPLE),
    }
    sizes = [n for n in SIZES if of(rows, "press", width=n)]
    threads = rows[0]["cores"]
    for i, n in enumerate(sizes):
        found = [
            r
            for r in of(rows, "press", width=n)
            if r["backend"] == "numpy" or device_of(r) == "vulkan" or r["threads"] == threads
        ]
        for roof, colour, left, right, what in (
            ("cpu-moves", "black", -0.42, 0.2, "CPU"),
            ("vulkan-moves", VERMILLION, 0.22, 0.4, "Vulkan"),
        ):
            moved = [r["least_ns"] for r in found if r["backend"].startswith(roof)]
            if moved:
                axis.hlines(
                    44 / min(moved),
                    i + left,
                    i + right,
                    color=colour,
                    linewidth=3,
                    label=f"{what}: the same bytes moved alone" if i == 0 else None,
                )
        for k, (backend, (marker, colour)) in enumerate(styles.items()):
            ns = min((r["least_ns"] for r in found if r["backend"] == backend), default=np.nan)
            if ns == ns or i == 0:
                axis.plot(
                    i - 0.38 + 0.08 * k, 44 / ns, marker, color=colour, markersize=8, label=backend if i == 0 else None
                )
    axis.set(
        xticks=range(len(sizes)),
        xticklabels=[f"{n} x {n} cells" for n in sizes],
        ylim=(0, None),
        ylabel="GB/s (44 bytes per cell and step)",
        title=f"one press on {threads} threads, beside loops that only move its memory",
    )
    flops = axis.secondary_yaxis("right", functions=(lambda x: x * 62 / 44, lambda x: x * 44 / 62))
    flops.set_ylabel("Gflop/s (62 flop per cell and step)")
    axis.legend(fontsize=8, ncol=3, loc="upper center", bbox_to_anchor=(0.5, -0.07))
    axis.grid(alpha=0.25, axis="y")
    save(figure, folder, "roofline", rows)


def scaling(rows, folder):
    figure, (cells, steps, threads) = plt.subplots(1, 3, figsize=(16, 4.8))
    growth = sorted(of(rows, "growth"), key=lambda r: r["cells"])
    cells.semilogx(
        [r["cells"] for r in growth],
        [r["least_ns"] for r in growth],
        "o-",
        color=BLUE,
        label="march, means and extremes of all five",
    )
    pressed = sorted((r for r in of(rows, "press") if r["threads"] != "1"), key=lambda r: r["cells"])
    for backend, colour in (
        ("cpu-avx512", VERMILLION),
        ("cpu-avx2", SKY),
        ("cpu-plain", GREEN),
        ("native", PURPLE),
        ("cpu-moves", "black"),
    ):
        line = {}
        for r in (r for r in pressed if r["backend"] == backend):
            line[r["cells"]] = min(r["least_ns"], line.get(r["cells"], np.inf))
        if line:
            cells.plot(list(line), list(line.values()), "s--", color=colour, label=f"press, {backend}")
    cells.set(
        xlabel="cells", ylabel="ns per cell and step", title="time of a cell, by the number of cells", ylim=(0, None)
    )
    cells.legend(fontsize=8)
    loops, sizes = {"cpu-avx512": VERMILLION, "cpu-avx2": SKY, "cpu-plain": GREEN}, {
        "256": "v",
        "512": "^",
        "2048": "o",
        "4096": "s",
    }
    presses = [r for r in of(rows, "press") if r["backend"] in loops and r["width"] in sizes]
    for r in presses:
        threads.plot(
            int(r["threads"]), 1 / r["least_ns"], sizes[r["width"]], color=loops[r["backend"]], markerfacecolor="none"
        )
    for loop in {r["backend"]: 0 for r in presses}:
        threads.plot([], [], "-", color=loops[loop], label=loop)
    for size, marker in sizes.items():
        threads.plot([], [], marker, color="black", markerfacecolor="none", label=f"{size}²")
    threads.legend(fontsize=8, loc="upper left")
    threads.set(
        xlabel="threads",
        xticks=sorted({int(r["threads"]) for r in of(rows, "press") if r["backend"].startswith("cpu")}),
        ylabel="cells and steps per ns",
        title="a press with threads",
        xlim=(0.5, None),
        ylim=(0, None),
    )
    for precision, colour in (("f32", VERMILLION), ("f32-compensated", ORANGE), ("f64", BLUE)):
        ladder = [
            r
            for r in of(rows, "accuracy", method="exact", model="march", precision=precision, stencil="five-point")
            if device_of(r) == "cpu"
        ]
        steps.loglog(
            [number(r["steps"]) for r in ladder], [r["least"] for r in ladder], "o-", color=colour, label=precision
        )
    steps.set(xlabel="steps", ylabel="s", title=f"time by the number of steps (march, {int(ladder[0]['width'])}²)")
    steps.legend(fontsize=8)
    for axis in (cells, steps, threads):
        axis.grid(alpha=0.25)
    save(figure, folder, "scaling", rows)


def devices(rows, folder):
    figure, axis = plt.subplots(figsize=(9, 9))
    order = [
        b
        for b in (
            "cpu-avx512",
            "cpu-avx2",
            "cpu-plain",
            "cpu-moves",
            "cpu-moves-cached",
            *PEERS,
            "vulkan",
            "vulkan-cell",
            "vulkan-moves",
        )
        if of(rows, "press", backend=b)
    ]
    sizes = [n for n in SIZES if of(rows, "press", width=n)]
    height = 0.85 / len(sizes)
    for k, n in enumerate(sizes):
        for i, backend in enumerate(order):
            ns = min((r["least_ns"] for r in of(rows, "press", width=n, backend=backend)), default=np.nan)
            axis.barh(
                i + height * (k - (len(sizes) - 1) / 2),
                ns,
                0.9 * height,
                color=SIZES[n],
                label=f"{n} x {n} cells" if i == 0 else None,
            )
            axis.text(ns, i + height * (k - (len(sizes) - 1) / 2), f" {ns:.3g}", va="center", fontsize=6)
    axis.set(
        yticks=range(len(order)),
        yticklabels=order,
        xlim=(0, None),
        xlabel="ns per cell and press (least of the rounds; the best number of threads)",
        title="CPU, Vulkan and peers on the same press (moves: a loop that only moves its memory)",
    )
    axis.margins(x=0.08)
    axis.invert_yaxis()
    axis.legend(fontsize=9)
    axis.grid(alpha=0.25, axis="x")
    save(figure, folder, "devices", rows)


# Batches by the number of pads, beside single skins with as many cells and loops of their own.
def pads(rows, folder):
    figure, axes = plt.subplots(1, 2, figsize=(14, 5.4))
    shapes = {(4, 4): PURPLE, (8, 8): VERMILLION, (16, 16): ORANGE, (20, 25): BLUE, (64, 64): GREEN}
    for axis, device in zip(axes, ("cpu", "vulkan")):
        mine = [
            r
            for r in rows
            if device_of(r) == device and r["precision"] == "f32" and (device == "vulkan" or r["threads"] == "1")
        ]
        single = sorted(of(mine, "cells"), key=lambda r: r["cells"])
        name = single[0]["device"] if single else ""  # one of the devices
        single = [r for r in single if r["device"] == name]
        axis.loglog(
            [r["cells"] for r in single],
            [r["least_ns"] for r in single],
            "--",
            color="black",
            label="one skin of as many cells",
        )
        for (width, height), colour in shapes.items():
            for model, line, label in (("batch", "o-", f"pads of {width} x {height}"), ("native-bits", "x:", None)):
                found = sorted(
                    (r for r in of(mine, "pads", model=model) if shape(r)[:2] == (width, height)),
                    key=lambda r: r["cells"],
                )
                axis.loglog(
                    [r["cells"] for r in found], [r["least_ns"] for r in found], line, color=colour, label=label
                )
        if device == "cpu":
            axis.plot([], [], "x:", color="grey", label="a loop for this kind of pad alone, the same bits")
        alone = of(mine, "pads-batch", model="skins")
        if alone:
            axis.plot(
                [r["cells"] for r in alone],
                [r["least_ns"] for r in alone],
                "*",
                color=BLUE,
                markersize=10,
                label="as many skins of 20 x 25, one by one",
            )
        axis.set(
            xlabel="cells of all pads",
            ylabel="ns per cell and press",
            title={"cpu": "CPU, one thread", "vulkan": "Vulkan"}[device],
        )
        axis.yaxis.set_major_formatter(matplotlib.ticker.FormatStrFormatter("%g"))
        axis.yaxis.set_minor_formatter(
            matplotlib.ticker.NullFormatter() if device == "vulkan" else matplotlib.ticker.FormatStrFormatter("%g")
        )
        axis.tick_params(axis="y", which="minor", labelsize=7)
        axis.grid(alpha=0.25, which="both")
        axis.legend(fontsize=8)
    save(figure, folder, "pads", rows)


# One skin by its number of cells. Where a device becomes faster than every number of threads, the crossing is marked.
def cells(rows, folder):
    figure, axis = plt.subplots(figsize=(9, 5.6))
    colours = iter((SKY, BLUE, "black", GREEN, "grey"))
    device_colours = iter((VERMILLION, ORANGE, PURPLE))
    for name, (count, ns) in places(rows).items():
        on_device = "thread" not in name
        colour = next(device_colours if on_device else colours, "brown")
        axis.loglog(
            count, ns, "s-" if on_device else "o-", color=colour, label=name if on_device else f"CPU path, {name}"
        )
        crossing = crossings(rows).get(name)
        if crossing:
            y = np.exp(np.interp(np.log(crossing), np.log(count), np.log(ns)))
            axis.plot(crossing, y, "o", color=colour, markersize=16, markerfacecolor="none", markeredgewidth=2)
            axis.annotate(
                f"{name} pays\nfrom {crossing:.2g} cells on",
                (crossing, y),
                (10, 25),
                textcoords="offset points",
                color=colour,
            )
    if not any(crossings(rows).values()):
        axis.text(
            0.5,
            0.02,
            "no device here is faster than the CPU path at any size",
            transform=axis.transAxes,
            ha="center",
            color="grey",
        )
    sides = [s for s in 2 ** np.arange(2, 13) if s * s <= max(r["cells"] for r in of(rows, "cells"))]
    axis.set_xticks([s * s for s in sides], [f"{s}²" for s in sides])
    axis.xaxis.set_minor_locator(matplotlib.ticker.NullLocator())
    axis.yaxis.set_major_formatter(matplotlib.ticker.FormatStrFormatter("%g"))
    axis.set(
        xlabel="cells",
        ylabel="ns per cell and press",
        title="A press by the number of cells, from the caller's pressure to responses that can be read",
    )
    axis.grid(alpha=0.25, which="both")
    axis.legend(fontsize=9)
    save(figure, folder, "cells", rows)


FASTEST = 4  # ms: the least retardation time of the stiff chain
LIMITS = {"Euler": 2 * FASTEST, "RK4": 2.785 * FASTEST}  # ms
PEER_INTERVAL = 10  # ms between outputs of CVODE, which has steps of its own


def step_of(row):
    return number(row["dt_over_tau"]) * FASTEST


# Refused runs stand at the top, each method's at a height of its own, because their errors go up to 1e158.
def stiff_panel(axis, rows, x_of, column):
    axis.set(xscale="log", yscale="log", ylim=(1e-17, 1e8), yticks=10.0 ** np.arange(-16, 5, 4))
    axis.grid(alpha=0.25)
    axis.axhline(FLOORS["double"], color="grey", linestyle=(0, (1, 2)), linewidth=1)
    series = (
        ("euler", "o", VERMILLION, "forward Euler"),
        ("rk4", "^", PURPLE, "RK4"),
        ("backward-euler", "v", "grey", "backward Euler"),
        ("crank-nicolson", "s", GREEN, "Crank-Nicolson"),
        ("cvode", "*", "black", "CVODE (at its mean step)"),
        ("lsoda", "P", ORANGE, "LSODA (SciPy)"),
        ("exact", "D", BLUE, "exact"),
    )
    for method, marker, colour, label in series:
        ladder = [r for r in rows if method in (r["method"], r["backend"])]
        if not ladder:  # a peer that is not installed
            continue
        stable, refused = ([r for r in ladder if r["status"] == status] for status in ("ok", "unstable"))
        axis.plot(
            [x_of(r) for r in stable],
            errors(stable, column),
            marker=marker,
            color=colour,
            linewidth=1.2,
            label=label,
            markersize=9 if marker == "*" else 6 if marker == "P" else 5,
        )
        axis.plot(
            [x_of(r) for r in refused],
            [1e7 if method == "euler" else 1e6] * len(refused),
            "x",
            color=colour,
            markersize=6,
            markeredgewidth=1.8,
        )


# A smooth load that the library knows by frames, and solvers that know it exactly.
def smooth_panel(axis, rows, column, quantity):
    series = (
        ("frames-linear", "o", BLUE, "frames, linear between them"),
        ("frames-parabolic", "^", SKY, "frames, parabolas through them"),
        ("bdf", "*", "black", "CVODE, given the sine"),
        ("lsoda", "P", ORANGE, "LSODA, given the sine"),
        ("sine", "D", GREEN, "exact, given the sine"),
    )
    for model, marker, colour, label in series:
        ladder = [r for r in rows if r["model"] == model]
        if ladder:
            axis.loglog(
                [1e3 * r["least"] for r in ladder],
                errors(ladder, column),
                marker=marker,
                color=colour,
                linewidth=1.2,
                label=label,
                markersize=6,
            )
        for r in ladder if model.startswith("frames") else ():
            axis.annotate(
                f"{step_of(r):.3g} ms",
                (1e3 * r["least"], errors([r], column)[0]),
                (4, 4),
                textcoords="offset points",
                fontsize=7,
                color=colour,
            )
    axis.set(
        xlabel="ms (least of the rounds)",
        ylabel=f"greatest error of {quantity} / greatest value",
        title="a smooth load, by frames",
    )
    axis.yaxis.label.set_fontsize(9)
    axis.title.set_fontsize(11)
    axis.grid(alpha=0.25)
    axis.legend(fontsize=7, loc="lower right")


# The same methods on a chain of elements, one of which is fast: error against step, and against cost.
def stiff(rows, folder):
    figure = plt.figure(figsize=(9, 12.4))
    grid = figure.add_gridspec(3, 2)
    axes = np.array([[figure.add_subplot(grid[row, column]) for column in range(2)] for row in range(2)])
    found = of(rows, "stiff")
    same = next(r for r in found if r["method"] == "exact" and step_of(r) == PEER_INTERVAL)
    for (by_step, by_cost), column, quantity in zip(axes, ("err_strain", "err_fa1"), ("strain", "FA1 (strain rate)")):
        stiff_panel(by_step, found, step_of, column)
        stiff_panel(by_cost, found, lambda r: r["cost"], column)
        by_step.set_ylabel(f"greatest error of {quantity} / greatest value", fontsize=9)
        by_step.axvspan(LIMITS["RK4"], 1e3, color="black", alpha=0.07, linewidth=0)
        for (name, limit), colour, side in zip(LIMITS.items(), (VERMILLION, PURPLE), ("right", "left")):
            by_step.axvline(limit, color=colour, linestyle="--", linewidth=1)
            by_step.text(limit, 1e-13, f"  {name}:  \n  {limit:.3g} ms  ", color=colour, fontsize=9, ha=side)
        by_cost.plot(same["cost"], errors([same], column)[0], "o", color="black", markersize=14, markerfacecolor="none")
        by_cost.text(
            same["cost"], 1e-14, f"outputs every {PEER_INTERVAL} ms,\nthe interval of CVODE's", ha="center", fontsize=9
        )
    axes[0, 0].text(110, 2e-10, "beyond their limits\nthey are refused\n(crosses)", ha="center", fontsize=9)
    for row in range(2):
        axes[row, 0].set(xlim=(0.2, 1e3))
    axes[1, 0].set(xlabel="step, ms")
    axes[1, 1].set(xlabel="ns per cell and simulated second")
    axes[0, 0].set_title("error against step", fontsize=11)
    axes[0, 1].set_title("error against cost", fontsize=11)
    for column, quantity, place in (("err_strain", "strain", grid[2, 0]), ("err_fa1", "FA1", grid[2, 1])):
        smooth_panel(figure.add_subplot(place), of(rows, "smooth"), column, quantity)
    figure.suptitle(
        "Elements of 4 ms, 70 ms and 1.4 s in series: under a held load, and (below) a sine of 5 Hz", fontsize=12
    )
    figure.legend(
        *axes[0, 1].get_legend_handles_labels(), loc="lower center", ncol=4, fontsize=10, bbox_to_anchor=(0.5, 0.025)
    )
    save(figure, folder, "stiff", rows, bottom=0.05)


def depth(rows, folder):
    figure = plt.figure(figsize=(11.5, 6.4))
    of_depth.draw(figure, of(rows, "depth"), of(rows, "depth-errors"))
    save(figure, folder, "depth", rows)


# What each picture is of; without these rows it is left out.
PICTURES = {
    work_precision: "accuracy",
    work_precision_all: "accuracy",
    stiff: "stiff",
    roofline: "press",
    scaling: "growth",
    devices: "press",
    pads: "pads",
    cells: "cells",
    depth: "depth-errors",
}


def main(path, folder, *wanted):
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    rows = load(path)
    timed = [r for r in rows if r["wall_median_s"]]
    for picture, workload in PICTURES.items():
        if of(timed, workload) and (not wanted or picture.__name__ in wanted):
            picture(timed, folder)
    if not wanted:
        (folder / "RESULTS.md").write_text(page(rows, step_of))


main(*sys.argv[1:])
