# SPDX-License-Identifier: MIT
"""Pictures and the page RESULTS.md of a run of dermis-bench: report.py results.csv folder

report.py --claims results.csv checks what the pictures claim of errors, refused steps and bits, and draws nothing.
"""
import sys
from pathlib import Path

import numpy as np
from matplotlib.ticker import LogLocator

import depth
from drawing import (BLUE, GREEN, GREY, METHODS, ORANGE, PRECISIONS, PURPLE, SKY, VERMILLION, ZERO, error_axis, figure, held,
                     logarithmic, named, rule, save)
from page import PEER_NAMES, crossings, driver, load, number, of, on_cpu, on_vulkan, page, places, plural, step_of

def origin(rows):
    first = rows[0]
    drivers = sorted({f"{r['driver']} {r['driver_version']}" for r in rows if on_vulkan(r)})
    return (f"{first['cpu']}, {first['cores']} cores, {first['compiler']}{''.join(', ' + d for d in drivers)}; "
            f"commit {first['commit']}, {first['date']}{', quick' if first['size'] == 'quick' else ''}")


def errors(ladder, column="err_strain"):
    return np.array([max(number(r[column]), ZERO) for r in ladder])


def of_ladders(rows):
    """Ladders of steps of the accuracy rows by (method, precision, model), five-point stencil."""
    ladders = {}
    for r in of(rows, "accuracy", stencil="five-point"):
        ladders.setdefault((r["method"], r["precision"], r["model"]), []).append(r)
    return ladders


def work_precision(rows):
    """Error against the time of a whole run: methods, precisions and models."""
    ladders = of_ladders(rows)
    first = ladders["exact", "f64", "march"][0]
    drawn, ((axis,),) = figure(1, 1, 5.2, "Steps buy digits; the exact step has them all at any length")
    logarithmic(axis, y=False)
    error_axis(axis, 3e3, "0: not a bit is off")
    ends = []
    for (method, precision, model), ladder in ladders.items():
        words, colour, marker = METHODS[method] if model == "march" else ("moments: no cell is stepped", "black", "*")
        if method != "exact" and precision != "f64":
            continue
        stable, refused = ([r for r in ladder if r["status"] == s] for s in ("ok", "unstable"))
        x = [1e3 * r["least"] for r in stable]
        if method == "exact" and model == "march":
            colour, words = PRECISIONS[precision][1], f"exact, {PRECISIONS[precision][0]}"
        axis.plot(x, errors(stable), marker=marker, color=colour, markersize=9 if marker == "*" else 5)
        axis.plot([1e3 * r["least"] for r in refused], np.minimum(errors(refused), 1e3), "x", color=colour, markersize=7,
                  markeredgewidth=2)
        ends.append((x[-1], errors(stable)[-1], words, colour))
    axis.text(axis.get_xlim()[0] * 1.5, 1e2, "x: refused as unstable", fontsize=9.5, color=GREY, va="center")
    for unit, words, beside in ((2.0**-24, "float rounds here", 0.03), (2.0**-53, "double rounds here", 20)):
        rule(axis, unit, "")
        axis.text(axis.get_xlim()[0] * 1.05, unit * beside, words, fontsize=9, color=GREY, va="center")
    axis.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.set(xlabel=f"ms of a whole run, 2.56 s of {first['width']} x {first['height']} cells in 4 to "
             f"{max(int(r['steps']) for r in ladders['exact', 'f64', 'march'])} steps",
             ylabel="greatest error of strain / greatest strain")
    right = max(x for x, *_ in ends)
    named(axis, [(right, *end) for _, *end in ends])
    return drawn


def work_precision_claims(rows):
    found = {key: [r for r in ladder if r["status"] == "ok"] for key, ladder in of_ladders(rows).items()}
    least = {key: errors(ladder).min() for key, ladder in found.items()}
    most = {key: errors(ladder).max() for key, ladder in found.items()}
    stencils = {r["stencil"]: number(r["err_curvature"]) for r in of(rows, "accuracy", method="exact", precision="f32")}
    return {
        "the exact step is off by at most 4e-16 in double, at any step": most["exact", "f64", "march"] < 4e-16,
        "moments are off by no more": most["exact", "f64", "moments"] < 4e-16,
        "by at most 1e-6 in float": most["exact", "f32", "march"] < 1e-6,
        "and by at most 2e-7 with compensated sums": most["exact", "f32-compensated", "march"] < 2e-7,
        "RK4 is off by 10,000 times as much or more": least["rk4", "f64", "march"] > 1e-12,
        "Crank-Nicolson by 1e-7 or more, forward Euler by 1e-4": least["crank-nicolson", "f64", "march"] > 1e-7
        and least["euler", "f64", "march"] > 1e-4,
        "forward Euler and RK4 are refused at steps of 3.9 tau": all(
            any(r["status"] == "unstable" for r in ladder) for key, ladder in of_ladders(rows).items() if key[0] in ("euler", "rk4")),
        "the fourth-order stencil has a tenth of the curvature's error": stencils["fourth-order"] < 0.1 * stencils["five-point"]}


def stiff(rows):
    """Error against time on a stiff chain, beside solvers that choose their own steps: a held load, and a sine by frames."""
    drawn, (axes,) = figure(1, 2, 4.4, "Under a held load solvers that choose their steps take longer, and err more", sharey=True)
    series = {  # by panel: the rows of a line
        "held": {m: (METHODS[m][0], METHODS[m][1], METHODS[m][2], [r for r in of(rows, "stiff", method=m) if r["status"] == "ok"])
                 for m in ("rk4", "crank-nicolson", "exact")},
        "smooth": {m: (words, colour, marker, of(rows, "smooth", model=m)) for m, words, colour, marker in (
            ("frames-linear", "frames, lines", BLUE, "o"), ("frames-parabolic", "frames, parabolas", SKY, "^"),
            ("sine", "dermis, given the sine", BLUE, "D"))}}
    for axis, workload, title in zip(axes, ("stiff", "smooth"), ("a held load", "a sine of 5 Hz; dermis by frames, solvers given it")):
        lines = series["held" if workload == "stiff" else "smooth"]
        lines["bdf"] = ("CVODE", "black", "*", of(rows, workload, model="bdf"))
        logarithmic(axis)
        ends = []
        for words, colour, marker, ladder in lines.values():
            ladder = [r for r in ladder if r["err_strain"]]  # a peer that is not installed has none
            if ladder:
                axis.plot([1e3 * r["least"] for r in ladder], errors(ladder), marker=marker, color=colour)
                ends.append((1e3 * ladder[-1]["least"], errors(ladder)[-1], words, colour))
        rule(axis, 2.0**-53, "double", "right", over="top")
        axis.set(title=title, xlabel="ms, 256 cells of 4 ms, 70 ms and 1.4 s", ylim=(1e-17, 10))
        named(axis, ends)
    axes[0].set_ylabel("greatest error of strain / greatest strain")
    return drawn


def stiff_claims(rows):
    exact, rk4 = of(rows, "stiff", method="exact"), of(rows, "stiff", method="rk4")
    by_frames = {m: min(errors(of(rows, "smooth", model=m))) for m in ("frames-linear", "frames-parabolic")}
    solvers = [e for r in rows if r["model"] == "bdf" and r["err_strain"] for e in errors([r])]
    return {"the exact step is off by at most 1e-15 at steps of 0.3 to 640 ms": errors(exact).max() < 1e-15,
            "RK4 is refused from 11.14 ms on": {step_of(r) > 11.14 for r in rk4 if r["status"] == "unstable"} == {True}
            and {step_of(r) > 11.14 for r in rk4 if r["status"] == "ok"} == {False},
            "parabolas between frames are closer than lines to a smooth load": by_frames["frames-parabolic"] < by_frames["frames-linear"] / 10,
            "no solver that chooses its steps comes below 1e-13": min(solvers, default=1) > 1e-13}


def by_size(rows, names):
    """Lines of the press rows by their names: cells and least ns of the fastest way at each size. names: by backend and threads."""
    lines = {}
    for r in of(rows, "press"):
        name = names(r)
        if name and r["status"] == "ok":
            line = lines.setdefault(name, {})
            line[r["cells"]] = min(line.get(r["cells"], np.inf), r["least_ns"])
    return {name: np.array(sorted(line.items())).T for name, line in lines.items()}


def devices(rows):
    """A press by cells and threads: whole, and its computing alone beside other programs and the memory's limit."""
    cores = rows[0]["cores"]
    pays = [f"{name} pays from {cells:.2g} cells on" for name, cells in crossings(rows).items() if cells]
    drawn, axes = figure(2, 1, 7.6, pays[0] if pays else "No Vulkan device here is faster than the CPU at any size", sharex=True)
    colours = {"dermis, 1 thread": SKY, f"dermis, {plural(cores)}": BLUE, **dict(zip(PEER_NAMES.values(), (
        "black", ORANGE, GREY)))}
    best = next(r["backend"] for r in of(rows, "press") if on_cpu(r))

    def name_of(r):
        if r["backend"] == best:
            return f"dermis, {plural(r['threads'])}"
        if r["backend"] in ("cpu-moves", "cpu-moves-cached", "vulkan-moves"):
            return "memory alone" if r["threads"] == cores or on_vulkan(r) else None
        if r["backend"] == "vulkan":
            return f"dermis, {driver(rows)}"
        peer = PEER_NAMES.get(r["backend"])
        return peer if peer and r["threads"] in (cores, "0") or peer == "NumPy" else None

    whole = {"dermis, " + name.split(" (")[0]: np.array(line) for name, line in places(rows).items()}
    alone = by_size([r for r in rows if r["backend"] != "vulkan-moves"], name_of)
    for (axis,), lines, title in zip(axes, (whole, alone), (
            "Skin::press: from your pressure to four responses that can be read",
            "the press alone, beside other programs and a loop that only moves its memory")):
        logarithmic(axis)
        ends = []
        for name, (cells, ns) in lines.items():
            colour = colours.get(name, VERMILLION)
            axis.plot(cells, ns, "--" if name == "memory alone" else "o-", color="black" if name == "memory alone" else colour)
            ends.append((max(line[0][-1] for line in lines.values()), ns[-1], name, "black" if name == "memory alone" else colour))
        axis.set(title=title, ylabel="ns per cell and press")
        axis.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        named(axis, ends)
    sides = [n for n in 2 ** np.arange(2, 14, 2) if n * n <= max(r["cells"] for r in of(rows, "cells"))]
    axes[1, 0].set_xticks([float(s) ** 2 for s in sides], [f"{s} x {s}" for s in sides])
    axes[1, 0].set(xlabel="cells of the skin")
    return drawn


def devices_claims(rows):
    presses = [r for r in of(rows, "press") if r["status"] != "not installed"]
    return {"every way of a press has the library's bits, or a peer's numbers to 1e-6": all(
        r["status"] == "ok" and max((number(r[e]) for e in ("err_sa1", "err_sa2", "err_fa1", "err_fa2") if r[e]), default=0) < 1e-6
        for r in presses),
        "sizes of one skin go up by two on both axes on each number of threads": all(
            (np.diff(np.sqrt(cells)) > 0).all() for cells, _ in places(rows).values())}


def pads(rows):
    """Batches by the number of pads, beside single skins with as many cells and loops of their own."""
    shapes = {(4, 4): PURPLE, (8, 8): VERMILLION, (16, 16): ORANGE, (20, 25): BLUE, (64, 64): GREEN}
    drawn, (axes,) = figure(1, 2, 4.6, "Pads in one call cost about what one skin of as many cells does")
    for axis, vulkan, title in zip(axes, (False, True), ("CPU, one thread", f"Vulkan ({driver(rows)})")):
        mine = [r for r in rows if r["precision"] == "f32" and (
            on_vulkan(r) if vulkan else not on_vulkan(r) and r["threads"] == "1")]
        single = sorted(of(mine, "cells"), key=lambda r: r["cells"])
        logarithmic(axis)
        single = [r for r in single if r["device"] == single[0]["device"]]  # one of the devices
        axis.plot([r["cells"] for r in single], [r["least_ns"] for r in single], "--", color="black", label="one skin")
        for (width, height), colour in shapes.items():
            for model, line, label in (("batch", "o-", f"pads of {width} x {height}"), ("native-bits", "x:", None)):
                found = sorted((r for r in of(mine, "pads", model=model) if r["shape"][:2] == (width, height)), key=lambda r: r["cells"])
                axis.plot([r["cells"] for r in found], [r["least_ns"] for r in found], line, color=colour, label=label)
        alone = of(mine, "pads-batch", model="skins")
        axis.plot([r["cells"] for r in alone], [r["least_ns"] for r in alone], "*", color=BLUE, markersize=10,
                  label="skins of 20 x 25 one by one")
        axis.set(xlabel="cells of all pads", ylabel="ns per cell and press", title=title)
    axes[0].yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axes[1].plot([], [], "x:", color=GREY, label="a loop for this kind of pad alone")
    axes[1].legend(fontsize=8.5, frameon=False)
    return drawn


# What each picture is of, and its claims; without these rows it is left out.
PICTURES = {work_precision: ("accuracy", work_precision_claims), stiff: ("stiff", stiff_claims), devices: ("press", devices_claims),
            pads: ("pads", None), depth.depth: ("depth-errors", depth.claims)}


def main(path, folder):
    checked, path = path == "--claims", folder if path == "--claims" else path
    rows = load(path)
    timed = [r for r in rows if r["wall_median_s"]]
    claims = {}
    for picture, (workload, claims_of) in PICTURES.items():
        if not of(timed, workload):
            continue
        if claims_of:
            claims |= claims_of(rows)
        if not checked:
            Path(folder).mkdir(parents=True, exist_ok=True)
            save(picture(timed), Path(folder) / f"{picture.__name__}.png", origin(timed))
    if not checked:
        (Path(folder) / "RESULTS.md").write_text(page(rows))
    held(claims)


if __name__ == "__main__":
    main(*sys.argv[1:])
