# SPDX-License-Identifier: MIT
"""The picture of receptors at depths, for report.py: what the spread of a press to a depth costs, and how far it is off
Love's sums, for each way that a user can have."""
import numpy as np

from drawing import BLUE, GREEN, figure, logarithmic, rule
from page import of, small

CLASSES = {6: "SA1", 10: "FA1", 22: "SA2", 40: "FA2"}  # of a fingertip, by depth over spacing where a cell is 0.05 mm
BOUND = 1e-3  # spread_error (host/core/model/spread.hpp)
WAYS = {  # what takes it, and a colour
    "pyramid": ("pyramid: frames,\nand a Skin", BLUE),
    "fft-long-double": ("FFT, long double:\na map times an\nenvelope, once a run", "black"), "sums": ("direct sums:\na cell of a site", GREEN)}


def of_cell(row):
    """Nanoseconds of the processor per cell and map."""
    return float(row["busy_least_s"]) * 1e9 / row["cells"] / float(row["steps"])


def line(rows, model):
    """Depths over the spacing, errors and nanoseconds of one way, by depth."""
    return np.array(sorted((float(r["method"][4:]), float(r["err_sa1"]), of_cell(r)) for r in of(rows, "depth-errors", model=model))).T


def depth(rows):
    press = min(of_cell(r) for r in of(rows, "depth", model="surface", width="200", height="200", threads="1"))
    drawn, (axes,) = figure(1, 2, 4.6, "A depth to a thousandth costs a few ns a cell; to the last digit, hundreds",
                            width_ratios=(1.25, 1))
    cost, by_depth = axes
    logarithmic(cost)
    places = {"pyramid": (8, -4), "fft-long-double": (-20, 34), "sums": (8, 28)}
    for way, (words, colour) in WAYS.items():
        _, error, ns = line(rows, way)
        cost.plot(ns, error, "o", color=colour, alpha=0.7)
        cost.annotate(words, (ns.max(), np.median(error)), places[way], textcoords="offset points", color=colour, fontsize=9,
                      va="center", ha="center" if way in ("fft-long-double", "sums") else "left")
    rule(cost, press, "a press without\n depths", "bottom", across=True)
    rule(cost, BOUND, "promised: 1e-3", "right", colour="black")
    cost.set(xlabel="ns per cell and class, one thread", ylabel="error: sum of |weight error| over all cells", ylim=(1e-17, 1e-2), xlim=(0.5, 2e5))
    logarithmic(by_depth)
    for model, style, name in (("pyramid", "-", "stress"), ("pyramid-strain", "--", "strain")):
        z, error, _ = line(rows, model)
        by_depth.plot(z, error, style, color=BLUE, label=name)
    rule(by_depth, BOUND, "promised: 1e-3", "left", colour="black")
    for z, name in CLASSES.items():
        rule(by_depth, z, name, "bottom", across=True)
    by_depth.set(xlabel="depth / width of a cell", ylim=(1e-6, 1e-2))
    by_depth.set_xticks((0.3, 1, 3, 10, 30), ("0.3", "1", "3", "10", "30"))
    by_depth.set_title("the pyramid, at its worst place")
    by_depth.legend(fontsize=9, frameon=False, loc="upper right")
    return drawn


def claims(rows):
    error = {way: line(rows, way)[1].max() for way in (*WAYS, "pyramid-strain")}
    return {f"the pyramid keeps its promise of 1e-3 at every depth: {small(error['pyramid'])}": max(
        error["pyramid"], error["pyramid-strain"]) < BOUND,
        "it is no better than 1e-4 at SA1's depth, so that it is a choice": line(rows, "pyramid")[1].max() > 1e-4,
        "FFT in long double and direct sums by at most 1e-15": max(error["fft-long-double"], error["sums"]) < 1e-15}
