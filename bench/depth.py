# SPDX-License-Identifier: MIT
"""The picture of receptors at depths: what the spread of a press to a depth costs, and how far it is off Love's sums.

For report.py. What a fit would do that does not see where pressed cells lie among the nodes is computed here anew."""

import numpy as np

CLASSES = {"6": ("SA1", 0.3), "10": ("FA1", 0.5), "22": ("SA2", 1.1), "40": ("FA2", 2)}  # of a fingertip, mm, by z/h where h is 0.05 mm
PYRAMID, FFT, SUMS, TRAP = "#0072B2", "#CC79A7", "#009E73", "#D55E00"
BOUND = 1e-3  # spread_error (host/core/model/spread.hpp)
MASK = np.array([1, 6, 15, 20, 15, 6, 1]) / 64


def love(n, z):
    """What a pressed cell causes 0 .. n - 1 cells away along rows and columns, z cells below, per unit of its pressure."""
    a, b = np.meshgrid(np.arange(n + 1) - 0.5, np.arange(n + 1) - 0.5)
    r = np.sqrt(a * a + b * b + z * z)
    corner = np.arctan2(a * b, z * r) + a * b * z / r * (1 / (a * a + z * z) + 1 / (b * b + z * z))
    return np.diff(np.diff(corner, axis=0), axis=1) / (2 * np.pi)


def stencils(z):
    """The levels with a stencil, five of them, with their radii (host/core/model/spread.cpp)."""
    first = 0
    while z >= (8 if first == 0 else 7) * 2**first:
        first += 1
    return [(level, 5 if level == 0 else 4) for level in range(first, first + 5)]


def joined(levels, n, cells):
    """By level, how each cell of an axis joins these ones by nodes 0 .. radius away on either side: [of cells, cell, node]."""
    down, low, found = np.eye(n), 0, []
    for level in range(levels[-1][0] + 1):
        for radius in (radius for wanted, radius in levels if wanted == level):
            shifted = [np.vstack([down[m:], np.zeros((m, n))]) for m in range(radius + 1)]
            one = [down.T @ s[:, cells] for s in shifted]
            other = [shifted[m].T @ down[:, cells] if m else 0 for m in range(radius + 1)]
            found.append(np.stack([a + b for a, b in zip(one, other)], -1).transpose(1, 0, 2))
        high, coarse = low + len(down) - 1, -((3 - low) // 2)
        nodes = np.arange(coarse, (high + 3) // 2 + 1)
        halve = np.array([[MASK[i - 2 * j + 3] if abs(i - 2 * j) <= 3 else 0 for i in range(low, high + 1)] for j in nodes])
        down, low = halve @ down, coarse
    return found


def trap(z):
    """Errors of weights that are fitted to the mean over all places among the nodes: as that fit sees it, and the worst."""
    levels = stencils(z)
    period = 2 ** levels[-1][0]
    reach = 6 * period  # of the coarsest stencil
    truth, joins = love(reach, z), joined(levels, 2 * reach + period, reach + np.arange(period))
    beside = np.arange(1 - reach, reach)
    here = [np.stack([j[x, reach + x + beside] for x in range(period)]) for j in joins]
    mean = [h.mean(0)[reach - 1:] for h in here]
    pairs = [(k, a, b) for k, (_, radius) in enumerate(levels) for a in range(radius + 1) for b in range(a + 1)]
    y, x = np.nonzero(np.tri(reach).T)
    matrix = np.stack([mean[k][x, a] * mean[k][y, b] + (a != b) * mean[k][x, b] * mean[k][y, a] for k, a, b in pairs], 1)
    times = np.where(x == y, 4, 8) * np.where(y == 0, 0.5, 1) * np.where(x == 0, 0.5, 1)
    weight = np.sqrt(times / np.sqrt(truth[y, x]))
    scale = np.maximum(np.linalg.norm(matrix * weight[:, None], axis=0), 1e-300)
    found = np.linalg.lstsq(matrix * weight[:, None] / scale, truth[y, x] * weight, rcond=1e-6)[0] / scale
    seen = (times * np.abs(matrix @ found - truth[y, x])).sum()
    stencil = [np.zeros((radius + 1, radius + 1)) for _, radius in levels]
    for (k, a, b), w in zip(pairs, found):
        stencil[k][a, b] = stencil[k][b, a] = w
    exact = truth[np.abs(beside)][:, np.abs(beside)]
    places = np.random.default_rng(1).integers(0, period, (40, 2))
    return seen, max(np.abs(sum(h[v] @ s @ h[u].T for h, s in zip(here, stencil)) - exact).sum() for u, v in places)



def of_cell(row):
    """Nanoseconds of the processor per cell and map."""
    return float(row["busy_least_s"]) * 1e9 / row["cells"] / float(row["steps"])


def line(rows, model):
    """Depths over the spacing, errors and nanoseconds of one way, by depth."""
    return np.array(sorted((float(r["method"][4:]), float(r["err_sa1"]), of_cell(r)) for r in rows if r["model"] == model)).T


def beside(axis, text, x, y, place, **more):
    """Writes so many points beside a place."""
    axis.annotate(text, (x, y), place, textcoords="offset points", va="center", ha="left" if place[0] > 0 else "right", **more)


def against_cost(above, below, rows, press):
    leader = {"arrowstyle": "-", "linewidth": 0.5, "shrinkB": 3}
    heights = {"SA1": 2, "FA1": -4, "SA2": -10, "FA2": -22}
    for z, error, ns in line(rows, "pyramid").T:
        above.plot(ns, error, "o", color=PYRAMID, markersize=4, alpha=0.5, markeredgewidth=0)
        if f"{z:g}" in CLASSES:
            name, depth = CLASSES[f"{z:g}"]
            above.plot(ns, error, "o", color=PYRAMID, markersize=7)
            right = 30 + 37 * np.log10(4 / ns)  # all begin at one cost
            beside(above, f"{name}, {depth} mm", ns, error, (right, heights[name]), fontsize=9, arrowprops=leader)
        elif z in (0.3, 0.5, 1):
            beside(above, f"z/h = {z:g}", ns, error, (-7, 0), fontsize=8, color=PYRAMID)
    for axis, model, colour, marker, name in (
        (above, "fft-float", FFT, "s", "FFT, float"),
        (below, "fft-long-double", FFT, "D", "FFT, long double"),
        (below, "sums", SUMS, "^", "direct sums, double"),
    ):
        z, error, ns = line(rows, model)
        axis.plot(ns, error, marker, color=colour, markersize=6)
        if axis is below:
            beside(axis, name, ns.mean(), error.max(), (-9, 0), color=colour, fontsize=9)
            continue
        beside(axis, name, ns.mean(), error.max() * 2, (-20, 0), color=colour, fontsize=9)
        for i in (0, -1):
            beside(axis, f"z/h = {z[i]:g}", ns[i], error[i], (9, 0), color=colour, fontsize=8)
    above.text(0.03, 0.97, "pyramid, float", color=PYRAMID, fontsize=9, transform=above.transAxes, va="top")
    for axis in (above, below):
        axis.axvline(press, color="grey", linestyle=(0, (1, 2)), linewidth=1)
    below.text(press * 1.1, 3e-16, "a press of all\nfour classes", fontsize=8, color="grey", va="center")
    above.axhline(BOUND, color="black", linewidth=0.8, linestyle="--")
    above.text(4e4, BOUND * 1.1, "promised: 1e-3", fontsize=8, ha="right")
    above.set(xscale="log", yscale="log", ylim=(2e-7, 4e-3), xlim=(0.6, 6e4))
    above.set_title("error against cost", pad=17)
    below.set(xscale="log", yscale="log", ylim=(2e-17, 2e-15), xlim=(0.6, 6e4), xlabel="ns per cell and class, one thread")
    above.set_ylabel("error: sum of |weight error| over all cells")
    above.tick_params(labelbottom=False)


def by_depth(above, below, rows, press, quick):
    for model, style, name in (("pyramid", "-", "stress"), ("pyramid-strain", "--", "strain")):
        z, error, ns = line(rows, model)
        above.plot(z, error, style, color=PYRAMID, linewidth=1.5, label=f"the library's weights, {name}")
    depths = (1, 3, 6, 10) if quick else (1, 2, 3, 4, 6, 8, 10, 14, 22)
    seen, worst = np.array([trap(z) for z in depths]).T
    above.plot(depths, worst, "o-", color=TRAP, linewidth=1.2, markersize=4, label="weights fitted to the mean kernel: the trap")
    above.plot(depths, seen, "o:", color=TRAP, linewidth=1.2, markersize=3, label="the same, as that fit sees itself")
    above.axhline(BOUND, color="black", linewidth=0.8, linestyle="--")
    above.set(yscale="log", ylim=(3e-7, 1e-1))
    above.set_title("error by depth, of a cell at the worst place among the nodes", pad=17)
    above.legend(fontsize=8, loc="lower right", frameon=False)
    z, _, ns = line(rows, "pyramid")
    below.plot(z, ns, color=PYRAMID, linewidth=1.5)
    below.text(0.32, ns[0] * 1.25, "pyramid", fontsize=8, color=PYRAMID)
    z, _, ns = line(rows, "fft-float")
    below.plot(z, ns, "s-", color=FFT, markersize=4, linewidth=1)
    beside(below, "FFT, float", 1, ns[0], (-8, 0), fontsize=8, color=FFT)
    below.axhline(press, color="grey", linestyle=(0, (1, 2)), linewidth=1)
    below.text(0.32, press * 0.8, "a press of all four classes", va="top", fontsize=8, color="grey")
    below.set(yscale="log", ylim=(0.4, 150), ylabel="ns per cell and class", xlabel="depth over spacing, z/h")
    for axis in (above, below):
        axis.set(xscale="log", xlim=(0.28, 64))
        axis.set_xticks((0.3, 1, 3, 10, 30), ("0.3", "1", "3", "10", "30"))
        for z, (name, _) in CLASSES.items():
            axis.axvline(float(z), color="black", linewidth=0.5, alpha=0.4)
            if axis is above:
                axis.text(float(z), 1.15e-1, name, fontsize=8, ha="center", va="bottom")
    above.tick_params(labelbottom=False)


def draw(figure, presses, errors):
    """presses, errors: rows of the table, of the workloads depth and depth-errors."""
    shown = figure.subplot_mosaic([["left", "right"], ["left", "right"], ["low", "cost"]], height_ratios=(1, 1, 0.9))
    press = min(of_cell(r) for r in presses if r["model"] == "surface" and r["width"] == r["height"] == "200" and r["threads"] == "1")
    against_cost(shown["left"], shown["low"], errors, press)
    by_depth(shown["right"], shown["cost"], errors, press, presses[0]["size"] == "quick")
    for axis in shown.values():
        axis.grid(alpha=0.25)
    figure.suptitle("Receptors at a depth z below cells h wide; SA1 to FA2 of a fingertip, h = 0.05 mm", fontsize=12)
