# SPDX-License-Identifier: MIT
"""The picture of receptors at depths: what the spread of a press to a depth costs, and how far it is off Love's sums.

For report.py. What a fit would do that does not see where pressed cells lie among the nodes is computed here anew."""

import numpy as np

CLASSES = {"6": "SA1", "10": "FA1", "22": "SA2", "40": "FA2"}  # of a fingertip, by depth over a spacing of 0.05 mm
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
    found = [(float(r["method"][4:]), float(r["err_sa1"]), of_cell(r)) for r in rows if r["model"] == model]
    return np.array(sorted(found)).T


def against_cost(axis, rows, press):
    ways = {
        "pyramid": ("o", "black", "the pyramid of the library, float"),
        "fft-float": ("s", "#E69F00", "FFT, float (kissfft)"),
        "fft-long-double": ("D", "#D55E00", "FFT, long double (kissfft),\nas scenes with a tolerance take it"),
        "sums": ("^", "#0072B2", "direct sums, double"),
    }
    for model, (marker, colour, name) in ways.items():
        z, error, ns = line(rows, model)
        shown = np.isin(z, [float(text) for text in CLASSES] + [1])
        axis.plot(ns[shown], error[shown], marker, color=colour, markersize=8 if model == "pyramid" else 6)
        side = {"pyramid": 0.62, "sums": 1.5}.get(model, 0.6)
        axis.text(ns[shown].mean() * side, error[shown].max() * (8 if model != "pyramid" else 14), name, color=colour, fontsize=9,
                  ha="right" if model == "sums" else "left")
