# SPDX-License-Identifier: MIT
"""How every chart of this folder looks and is checked: colours, logarithmic axes, labels beside lines, the file."""
import sys
from pathlib import Path

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from PIL import Image  # matplotlib's own requirement

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "host/lab/output"))
from plot import CLASSES  # the colours of the classes

BLUE, VERMILLION, GREEN, ORANGE, PURPLE, SKY, GREY = (
    "#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7", "#56B4E9", "#777777")
PRECISIONS = {"f32": ("float", VERMILLION), "f32-compensated": ("compensated sums", GREEN), "f64": ("double", BLUE)}
METHODS = {  # by name: what a label says, a colour and a marker
    "exact": ("dermis, exact", BLUE, "D"), "euler": ("forward Euler", ORANGE, "o"), "rk2": ("RK2", "#8C6D31", "<"),
    "rk4": ("RK4", PURPLE, "^"), "backward-euler": ("backward Euler", GREY, "v"),
    "crank-nicolson": ("Crank-Nicolson", SKY, "s"), "sdirk2": ("SDIRK2", "black", ">")}
ZERO = 1e-18  # where an error of 0 stands on a logarithmic axis
plt.rcdefaults()  # none of the user's settings changes a picture
plt.rcParams.update({"font.size": 10.5, "axes.titlesize": 10.5, "axes.grid": True, "grid.alpha": 0.25, "lines.markersize": 5,
                     "lines.linewidth": 1.5, "figure.dpi": 100, "figure.constrained_layout.use": True,
                     "axes.spines.top": False, "axes.spines.right": False})


def figure(rows, columns, height, title, **more):
    """A picture 800 px wide whose title is its claim; its axes."""
    figure, axes = plt.subplots(rows, columns, figsize=(8, height), squeeze=False, **more)
    figure.suptitle(title, fontsize=12.5, fontweight="bold", x=0.01, ha="left")
    return figure, axes


def plain(x, _=None):
    """A number of an axis: 0.01 to 1000 in full, others as a power of ten."""
    power = round(np.log10(x)) if x > 0 else 0
    return f"{x:g}" if 0.009 < x < 2000 else f"$10^{{{power}}}$" if abs(x / 10.0**power - 1) < 1e-9 else ""


def logarithmic(axis, x=True, y=True):
    """Axes with a number at each decade, or at every second or fourth, and none between."""
    for wanted, one, set_scale in ((x, axis.xaxis, axis.set_xscale), (y, axis.yaxis, axis.set_yscale)):
        if wanted:
            set_scale("log")
            one.set_major_locator(matplotlib.ticker.LogLocator(numticks=7))
            one.set_major_formatter(plain)
            one.set_minor_formatter(matplotlib.ticker.NullFormatter())


def error_axis(axis, top, words="0: no bit is off"):
    """An axis of errors that ends in 0 below a rule, which says what that means."""
    axis.set_yscale("log")
    axis.set_ylim(ZERO / 4, top)
    decades = 10.0 ** np.arange(-16, np.log10(top), 4)
    axis.set_yticks([ZERO, *decades], ["0", *map(plain, decades)])
    axis.yaxis.set_minor_locator(matplotlib.ticker.NullLocator())
    axis.axhline(4 * ZERO, color="black", linewidth=0.7)
    axis.text(0.93, ZERO, words, transform=axis.get_yaxis_transform(), va="center", ha="right", fontsize=9, color=GREY)


def rule(axis, value, text, side="right", across=False, colour=GREY, over="bottom"):
    """A dotted line at a value of y (across: of x), with its name at one end of it; over: "top", its name lies below it."""
    (axis.axvline if across else axis.axhline)(value, color=colour, linestyle=(0, (1, 2)), linewidth=1.2)
    end = {"right": 0.99, "left": 0.01, "top": 0.98, "bottom": 0.02}[side]
    where = dict(x=value, y=end, transform=axis.get_xaxis_transform(), va=side) if across else dict(
        x=end, y=value, transform=axis.get_yaxis_transform(), ha=side, va=over)
    axis.text(s=f" {text} ", color=colour, fontsize=9, **where)


def named(axis, names, side="right", apart=13, fontsize=9.5):
    """Writes names beside the ends of lines, (x, y, name, colour), none over another: apart by so many pixels."""
    axis.figure.canvas.draw()  # places the axes
    names = sorted(((axis.transData.transform((x, y))[1], x, y, *more) for x, y, *more in names))
    heights = np.array([n[0] for n in names])
    for _ in range(200):
        close = np.flatnonzero(np.diff(heights) < apart - 0.1)
        for i in close:
            middle = heights[i:i + 2].mean()
            heights[i:i + 2] = middle - apart / 2, middle + apart / 2
    for height, (was, x, y, name, colour) in zip(heights, names):
        axis.annotate(name, (x, y), (7 if side == "right" else -7, (height - was) * 72 / axis.figure.dpi),
                      textcoords="offset points", va="center", ha="left" if side == "right" else "right", color=colour,
                      fontsize=fontsize, annotation_clip=False)


def small(figure):
    """Small numbers at all axes, on a fine grid."""
    for axis in figure.axes:
        axis.tick_params(labelsize=8)
        axis.grid(alpha=0.3)


def key(figure, handles, labels, share=0.07, **more):
    """One key of all lines below a picture, on a share of its height."""
    figure.get_layout_engine().set(rect=(0, share, 1, 1 - share))
    figure.legend(handles, labels, loc="lower center", frameon=False, fontsize=9, handlelength=1.2, columnspacing=1, **more)


def save(figure, picture, footer=""):
    """Writes a picture with a palette, which takes a third of the bytes of full colour."""
    if footer:
        figure.supxlabel(footer, x=0.995, ha="right", fontsize=6.8, color=GREY)
    figure.canvas.draw()
    image = Image.fromarray(np.asarray(figure.canvas.buffer_rgba())[..., :3])
    image.quantize(256, Image.Quantize.MAXCOVERAGE).save(picture, optimize=True)
    plt.close(figure)


def held(claims):
    """Says each claim of a chart, and ends with status 1 where one does not hold."""
    for claim, holds in claims.items():
        print(f"{'holds' if holds else 'FAILS'}: {claim}")
    if not all(claims.values()):
        sys.exit("a claim of this chart does not hold")


def chart(measured, claims, draw):
    """SCRIPT dermis [picture.png ..]: measures, checks the claims, and with a name draws the picture."""
    found = measured(sys.argv[1])
    if len(sys.argv) > 2:
        draw(found, *sys.argv[2:])
    held(claims(found))
