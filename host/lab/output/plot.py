# SPDX-License-Identifier: MIT
"""Pictures of what the command leaves in a folder: a run or a sweep, with a page; a fit; the errors of a bench.

The command runs this file with a folder, what to draw ("run", "fit" or "errors") and of a run the units of all keys, of
errors the scene's name and its tolerance.
The Python package has it as dermis._plot. It needs NumPy and matplotlib.
"""
from __future__ import annotations

import base64
import csv
import dataclasses
import html
import io
import json
import os
import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LightSource
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

Array = np.ndarray[Any, np.dtype[Any]]
BLUE, VERMILLION, GREEN, PURPLE = "#0072B2", "#D55E00", "#009E73", "#AA4499"
CLASSES = {"sa1": BLUE, "sa2": GREEN, "fa1": VERMILLION, "fa2": PURPLE}  # the colours of the classes in every picture
# The name of a quantity, its unit, and the factor to this unit. Heights have metres only with a spacing.
QUANTITIES = {"strain": ("strain", "1", 1.0), "sa1": ("SA1", "1", 1.0), "sa2": ("SA2", "s", 1.0),
              "fa1": ("FA1", "1/s", 1.0), "fa2": ("FA2", "1/s²", 1.0)}
IN_METRES = {"curvature": ("curvature", "1/mm", 1e-3), "deformation": ("height", "µm", 1e6)}
IN_CELLS = {"curvature": ("curvature", "1", 1.0), "deformation": ("height", "1", 1.0)}
MOST_MAPS = 6  # columns of maps; of more times some are chosen evenly
MOST_LINES = 8  # lines of one panel that have a colour and a name


@dataclasses.dataclass
class Run:
    """What a run has given, from its files or from a Result."""
    title: str
    width: int  # cells
    height: int
    spacing: float | None  # m between cells; None: there are no metres
    time: Array  # s
    columns: dict[str, Array]  # by their names in traces.csv
    impulses: list[tuple[float, str, float]]  # time in s, quantity, mean weight in the quantity's unit times s
    fields: dict[tuple[str, float], Array]  # by quantity and time in s
    receptors: list[tuple[str, int, int]]  # class and cell
    responses: Array  # of shape (times, sites)
    spikes: Array  # with the fields time, in s, and afferent
    fibres: list[tuple[str, float, float]]  # the class of each afferent and its cell, or the middle of its endings' cells
    # Velocity and repeat of what slides, along x and y, in m or cells; a repeat of None or infinity: there is none.
    pattern: Sequence[Sequence[float | None]] | None  # None: nothing slides
    loads: list[Mapping[str, Any]]  # keys of each table [load]; empty: not known
    error: float  # the bound on the error; NaN: not known
    facts: dict[str, str]
    warnings: list[str] = dataclasses.field(default_factory=list)
    scene: str = ""  # the text of the scene; empty: not known
    narrow: bool = False  # pictures for a phone

    def label(self, quantity: str) -> tuple[str, float]:
        """Return what an axis of a quantity says, and the factor to its unit."""
        name, unit, factor = (QUANTITIES | (IN_METRES if self.spacing else IN_CELLS))[quantity]
        return f"{name} ({unit})", factor

    def length(self) -> tuple[str, float]:
        """Return the unit of lengths along the skin, and how long a cell is."""
        return ("mm", 1e3 * self.spacing) if self.spacing else ("cells", 1.0)

    def extent(self) -> tuple[float, float, float, float]:
        """Return from where to where the skin goes along x and y, in the unit of lengths."""
        return 0, self.length()[1] * self.width, 0, self.length()[1] * self.height


def _read(path: Path, reader: Callable[[Any], Any] = lambda file: list(csv.DictReader(file)), mode: str = "r") -> Any:
    """Return what the reader makes of a file: by default the rows of a CSV file. Errors name the file."""
    with open(path, mode) as file:
        try:
            return reader(file)
        except (ValueError, EOFError) as error:
            raise ValueError(f"{path}: cannot be read ({error})") from None


def _table(file: Any) -> dict[str, Array]:
    """Return the columns of traces.csv by name."""
    names = file.readline().strip().split(",")
    if names[0] != "time":
        raise ValueError("its first column is not time")
    rows = np.array([line.split(",") for line in file.read().splitlines()], float)
    return dict(zip(names, rows.T if rows.size else np.empty((len(names), 0))))


def run_in(folder: Path) -> Run:
    """Read the files of a run."""
    summary = _read(folder / "summary.json", json.load)
    if "unfinished" in summary:
        raise ValueError(f"{folder}: its files are those of a run that was stopped; run it again")
    written = [file["file"] for file in summary["files"]]  # others may lie beside them
    columns = _read(folder / "traces.csv", _table)
    fields = {}
    for name in written:
        quantity, of_time, at = name.removesuffix(".npy").partition("_t")
        if of_time:
            fields[quantity, float(at)] = _read(folder / name, np.load, "rb")
    receptors, responses = [], np.empty((0, 0))
    if "receptors.csv" in written:
        receptors = [(row["type"], int(row["x"]), int(row["y"])) for row in _read(folder / "receptors.csv")]
        responses = _read(folder / "responses.npy", np.load, "rb")
    spikes, fibres = np.empty(0, [("time", "f8"), ("afferent", "u4")]), []
    if "afferents.csv" in written:
        spikes = _read(folder / "spikes.npy", np.load, "rb")
        fibres = [(row["class"], float(row["x"]), float(row["y"])) for row in _read(folder / "afferents.csv")]
    plan, grid, moving = summary["plan"], summary["grid"], summary.get("pattern")  # earlier versions have none
    facts = {"grid": f"{grid['width']} x {grid['height']} cells", "time of stepping": f"{summary['seconds']:.3g} s",
             "computed by": f"{plan['model']}, {plan['method']}, {plan['precision']}, {summary['steps']} steps",
             "device": summary["device"]["name"], "version": f"{summary['version']}, commit {summary['commit']}",
             "set": " ".join(summary["set"])}
    return Run(title=folder.name, width=grid["width"], height=grid["height"], spacing=grid["spacing"],
               time=columns.pop("time"), columns=columns,
               impulses=[(float(row["time"]), row["quantity"], float(row["mean"]))
                         for row in _read(folder / "impulses.csv")],
               fields=fields, receptors=receptors, responses=responses, spikes=spikes, fibres=fibres,
               pattern=moving and (moving["velocity"], moving["repeat"]), loads=summary.get("loads", []), facts=facts,
               error=np.float64(plan["predicted_error"]), warnings=summary["warnings"], scene=summary["scene"])


def run_of(result: Any) -> Run:
    """Take what a dermis.Result has."""
    columns: dict[str, Array] = {}
    for name in result:
        trace = result[name]
        some = {"mean": trace.mean, "min": trace.min, "max": trace.max}
        columns |= {f"{name}_{of}": values for of, values in some.items() if len(values)}
        columns |= {f"{name}_probe{i}": values for i, values in enumerate(trace.probes)}
    scene = result.scene
    fibres = []
    for a in scene.afferents:
        cells = np.array(a.cells or [(x, y) for kind, x, y in scene.sites if kind == a.type], float)
        middles = cells if a.radius else cells.reshape(-1, a.endings, 2).mean(axis=1)
        fibres += [(a.type, x, y) for x, y in middles]
    facts = {"grid": f"{scene.width} x {scene.height} cells", "time of stepping": f"{result.seconds:.3g} s",
             "computed by": f"{result.model}, {result.precision}, {result.steps} steps", "device": result.device.name}
    return Run(title="dermis", width=scene.width, height=scene.height, spacing=scene.spacing, time=result.time,
               columns=columns,
               impulses=[(i.time, i.quantity, i.mean) for i in result.impulses], fields=dict(result.fields),
               receptors=scene.sites, responses=result.responses, spikes=result.spikes, fibres=fibres,
               pattern=scene._moving_pattern, error=result.predicted_error, facts=facts,
               loads=[vars(load) for load in (scene.load if isinstance(scene.load, list) else [scene.load])])


def _pressed(load: Mapping[str, Any]) -> str:
    """Return what a load is, as "circular load of 10,000 Pa, envelope pulse"."""
    size, how = load["intensity"], "times" if load["kind"] in ("file", "sequence") else "of"
    amount = f"{size:,.6g} Pa" if load["control"] == "pressure" else f"{1e3 * size:.4g} mm of depth"
    return f"{load['kind']} load {how} {amount}, envelope {load['envelope']}"


def _greatest(run: Run) -> Iterable[str]:
    """Say the greatest value of each quantity that has a trace or sites, and when it is."""
    for name, (label, unit, _) in QUANTITIES.items():
        values = [column for of, column in run.columns.items() if of.startswith(f"{name}_")]
        values += [run.responses[:, i] for i, site in enumerate(run.receptors) if site[0] == name]
        if values and len(run.time):
            most = max(values, key=lambda column: np.abs(column).max())
            at = int(np.abs(most).argmax())
            yield f"{label} {most[at]:.4g}{f' {unit}' if unit != '1' else ''} at {run.time[at]:.4g} s"


def head(run: Run) -> dict[str, str]:
    """Return what a page begins with, by name."""
    first = {"pressed": "; ".join(map(_pressed, run.loads)), "greatest responses": ", ".join(_greatest(run)),
             "spikes": f"{len(run.spikes)}, of {len(run.fibres)} afferents" if run.fibres else "",
             "error at most": "not computed: dermis plan bounds it" if np.isnan(run.error) else f"{run.error:.2g}"}
    return {name: text for name, text in (first | run.facts).items() if text}


def _figure(rows: int, columns: int, width: float, height: float, narrow: bool = False,
            **more: Any) -> tuple[Figure, Any]:
    """Return a figure of a size in inches and its panels. narrow: for a phone, the panels of a row below each other."""
    if not narrow:
        figure = Figure(figsize=(width, height), layout="constrained")
        return figure, figure.subplots(rows, columns, squeeze=False, **more)
    figure = Figure(figsize=(4.2, height * columns), layout="constrained")
    more.pop("width_ratios", None)
    return figure, figure.subplots(rows * columns, 1, squeeze=False, **more).reshape(rows, columns)


def _legend(panel: Axes, columns: int) -> None:
    """Name the lines of a panel above it."""
    panel.legend(fontsize=8, loc="lower left", bbox_to_anchor=(0, 1), ncols=columns, frameon=False, borderaxespad=0.2)


def colours_of(name: str, low: float, high: float) -> dict[str, Any]:
    """Return how a map of a quantity is coloured: signed numbers from blue to red around 0."""
    greatest = max(-low, high) or 1.0
    if name in ("fa1", "fa2", "curvature") or (name in CLASSES and low < -0.01 * greatest):
        return {"cmap": "RdBu_r", "vmin": -greatest, "vmax": greatest}
    return {"cmap": "viridis", "vmin": low, "vmax": high}


def _colour(i: int, count: int) -> tuple[float, float, float, float]:
    """Return the colour of one of some lines, none of them as light as yellow."""
    return matplotlib.colormaps["viridis"](0.9 * i / count)


def _draw_impulses(panel: Axes, impulses: list[tuple[float, float]], unit: str) -> None:
    """Draw an arrow for each impulse, as long as its weight is among the others, from 0 on."""
    greatest = max(abs(weight) for _, weight in impulses) or 1.0
    low, high = panel.get_ylim()
    reach = 0.9 * max(high, -low)
    for time, weight in impulses:
        panel.annotate("", xy=(time, reach * weight / greatest), xytext=(time, 0),
                       arrowprops={"arrowstyle": "->", "color": "black"})
        if len(impulses) <= MOST_LINES:
            panel.annotate(f" {weight:.3g} {unit}", xy=(time, 0.9 * reach * weight / greatest), fontsize=8, va="center")
    panel.set_ylim(min(low, -reach * any(w < 0 for _, w in impulses) / 0.9), max(high, low))


def traces(run: Run) -> Figure | None:
    """Draw the mean of each quantity over time, the span of all cells, the probes, and impulses as arrows."""
    names = [name for name in QUANTITIES if f"{name}_mean" in run.columns]
    if not names or not len(run.time):
        return None
    figure, panels = _figure(len(names), 1, 9, 0.6 + 1.5 * len(names), run.narrow, sharex=True)
    for name, panel in zip(names, panels[:, 0]):
        colour = CLASSES.get(name, "black")
        if f"{name}_min" in run.columns:
            panel.fill_between(run.time, run.columns[f"{name}_min"], run.columns[f"{name}_max"], color=colour,
                               alpha=0.2, linewidth=0, label="all cells")
        panel.plot(run.time, run.columns[f"{name}_mean"], color=colour, label="mean")
        probes = [column for column in run.columns if column.startswith(f"{name}_probe")]
        for i, probe in enumerate(probes):
            panel.plot(run.time, run.columns[probe], linewidth=1, color=str(0.7 * i / len(probes)), linestyle="--",
                       label=f"probe {i}" if i < MOST_LINES else None)
        impulses = [(time, weight) for time, quantity, weight in run.impulses if quantity == name]
        label, _ = run.label(name)
        if impulses:
            _draw_impulses(panel, impulses, {"fa1": "", "fa2": "1/s"}.get(name, ""))
            label += "\narrows: impulses"
        panel.axhline(0, color="grey", linewidth=0.5)
        panel.set_ylabel(label)
        panel.margins(x=0)
    _legend(panels[0, 0], 2 if run.narrow else 6)
    panels[-1, 0].set_xlabel("time (s)")
    return figure


def _chosen(times: list[float]) -> list[float]:
    places = np.linspace(0, len(times) - 1, min(len(times), MOST_MAPS)).round().astype(int)
    return [times[i] for i in places]


def maps(run: Run) -> Figure | None:
    """Draw each field at its times, with one range of colours for each quantity."""
    if not run.fields:
        return None
    times = _chosen(sorted({t for _, t in run.fields}))
    names = [name for name in (*QUANTITIES, *IN_METRES) if any((name, t) in run.fields for t in times)]
    tall = 0.5 + 2.2 * float(np.clip(run.height / run.width, 0.2, 5))  # inches
    figure, panels = _figure(len(names), len(times), 1.4 + 2.4 * len(times), 0.3 + tall * len(names), run.narrow)
    unit, _ = run.length()
    for name, row in zip(names, panels):
        label, factor = run.label(name)
        fields = {t: factor * run.fields[name, t] for t in times if (name, t) in run.fields}
        low, high = min(f.min() for f in fields.values()), max(f.max() for f in fields.values())
        for panel, time in zip(row, times):
            if time not in fields:
                panel.set_axis_off()
                continue
            image = panel.imshow(fields[time], origin="lower", extent=run.extent(), **colours_of(name, low, high))
            panel.set_title(f"{time:.4g} s", fontsize=9)
            panel.set(xlabel=f"x ({unit})", ylabel=f"y ({unit})")
        figure.colorbar(image, ax=list(row), label=label)
    return figure


def skin(run: Run) -> Figure | None:
    """Draw the places that loads press and those of afferents or receptors, if no field shows the skin.

    Of other kinds of loads no place is known.
    """
    loads = [load for load in run.loads if load["kind"] in ("linear", "circular", "point", "punch")]
    if run.fields or not loads:
        return None
    figure, panels = _figure(1, 1, 4.5, 0.6 + 3.6 * float(np.clip(run.height / run.width, 0.2, 2)), run.narrow)
    panel, (unit, cell) = panels[0, 0], run.length()
    for load in loads:
        x, y = (cell * (at + 0.5) for at in load["center"] or (run.width // 2, run.height // 2))
        radius = cell * (load["radius"] or max(1, min(run.width, run.height) // 4))
        if load["kind"] == "linear":
            panel.axhspan(y - radius, y + radius, color="0.85")
        else:
            panel.add_patch(Ellipse((x, y), 2 * radius, 2 * (cell * (load["radius_y"] or 0) or radius), color="0.85"))
    for kind, colour in CLASSES.items():
        if own := [place for of, *place in run.fibres or run.receptors if of == kind]:
            x, y = cell * (np.transpose(own) + 0.5)
            panel.plot(x, y, "o", color=colour, markersize=3, label=f"{len(own)} {kind.upper()}")
            _legend(panel, 4)
    panel.set(xlabel=f"x ({unit})", ylabel=f"y ({unit})", aspect="equal", xlim=run.extent()[:2], ylim=run.extent()[2:])
    return figure


def surface(run: Run) -> Figure | None:
    """Draw the skin's surface as it is pressed, lit from the side, and a cut through its deepest row."""
    times = _chosen(sorted(t for name, t in run.fields if name == "deformation"))
    if not times or min(run.width, run.height) < 2:  # no light falls from the side on a line
        return None
    label, factor = run.label("deformation")
    unit, cell = run.length()
    heights = [factor * run.fields["deformation", t] for t in times]
    deepest = int(np.unravel_index(np.argmin(heights[-1]), heights[-1].shape)[0])
    figure, panels = _figure(1, 2, 9, 4, run.narrow)
    lit, cut = panels[0]
    last = heights[-1]
    steep = 1 / max(np.hypot(*np.gradient(last)).max(), 1e-300)
    shaded = LightSource(315, 45).shade(last, matplotlib.colormaps["viridis"], vert_exag=steep, blend_mode="soft")
    lit.imshow(shaded, origin="lower", extent=run.extent())
    scale = matplotlib.cm.ScalarMappable(matplotlib.colors.Normalize(last.min(), last.max()), "viridis")
    figure.colorbar(scale, ax=lit, label=label)
    lit.axhline((deepest + 0.5) * cell, color="white", linewidth=0.8, linestyle="--")
    lit.set(xlabel=f"x ({unit})", ylabel=f"y ({unit})", title=f"{times[-1]:.4g} s")
    x = (np.arange(last.shape[1]) + 0.5) * cell
    for i, (time, height) in enumerate(zip(times, heights)):
        cut.plot(x, height[deepest], color=_colour(i, len(times)), label=f"{time:.4g} s")
    cut.set(xlabel=f"x ({unit}) along the dashed line, y = {(deepest + 0.5) * cell:.3g} {unit}", ylabel=label)
    _legend(cut, 4)
    return figure


def receptors(run: Run) -> Figure | None:
    """Draw the sites of each class in their places, coloured by their response at its peak, and over time."""
    kinds = [kind for kind in CLASSES if any(kind == of for of, _, _ in run.receptors)]
    if not kinds or not len(run.time):
        return None
    figure, panels = _figure(len(kinds), 2, 9, 0.4 + 2.4 * len(kinds), run.narrow, width_ratios=[1, 1.7])
    unit, cell = run.length()
    for kind, (places, course) in zip(kinds, panels):
        own = [i for i, receptor in enumerate(run.receptors) if receptor[0] == kind]
        x, y = ((np.array([run.receptors[i][axis] for i in own]) + 0.5) * cell for axis in (1, 2))
        values, label = run.responses[:, own], run.label(kind)[0]
        peak = int(np.abs(values).max(axis=1).argmax())
        shown = places.scatter(x, y, c=values[peak], s=14, edgecolors="grey", linewidths=0.4,
                               **colours_of(kind, values[peak].min(), values[peak].max()))
        figure.colorbar(shown, ax=places)
        places.set(xlabel=f"x ({unit})", ylabel=f"y ({unit})", aspect="equal", xlim=run.extent()[:2],
                   ylim=run.extent()[2:])
        places.set_title(f"{len(own)} sites, {label} at {run.time[peak]:.4g} s", fontsize=9)
        course.fill_between(run.time, *np.quantile(values, [0.1, 0.9], axis=1), color=CLASSES[kind], alpha=0.25,
                            linewidth=0, label="80 % of the sites")
        course.plot(run.time, np.median(values, axis=1), color=CLASSES[kind], label="median")
        greatest = int(np.abs(values).max(axis=0).argmax())
        course.plot(run.time, values[:, greatest], color="black", linewidth=0.7, label=f"site {own[greatest]}")
        course.axvline(run.time[peak], color="grey", linewidth=0.6, linestyle="--")
        course.set(xlabel="time (s)", ylabel=label)
        course.margins(x=0)
        _legend(course, 3)
    return figure


def spikes(run: Run) -> Figure | None:
    """Draw each spike as a dot, the afferents of a class one above the other, and the rate of each class."""
    classes = [kind for kind, _, _ in run.fibres]
    kinds = [kind for kind in CLASSES if kind in classes]
    if not kinds:
        return None
    figure, panels = _figure(2, 1, 9, 5.5, run.narrow, sharex=True, height_ratios=[2, 1])
    raster, rate = panels[:, 0]
    of_kind = np.array([kinds.index(kind) for kind in classes])
    row = np.argsort(np.argsort(of_kind, kind="stable"))
    times, numbers = run.spikes["time"], run.spikes["afferent"].astype(int)
    end = max([*run.time[-1:], *times], default=1.0)
    bins = np.linspace(0, end, 51)
    for i, kind in enumerate(kinds):
        own, count = of_kind[numbers] == i, int((of_kind == i).sum())
        raster.plot(times[own], row[numbers[own]], "|", color=CLASSES[kind], markersize=4, rasterized=own.sum() > 5000,
                    label=f"{kind.upper()}: {own.sum()} spikes of {count} afferents")
        counts, _ = np.histogram(times[own], bins)
        rate.stairs(counts / (count * np.diff(bins)), bins, color=CLASSES[kind])
    raster.set(ylabel="afferent", ylim=(-1, len(run.fibres)))
    _legend(raster, 1 if run.narrow else 4)
    rate.set(xlabel="time (s)", ylabel="rate of an afferent (1/s)", xlim=(0, end))
    return figure


def events(run: Run) -> Figure | None:
    """Draw a dot for each spike at the place of the sliding pattern that was then at the afferent, a panel for each class.

    This is the spatial event plot of Phillips, Johnson and Hsiao (PNAS 85, 1988, 1317): many afferents stand in for one
    that is swept by the pattern at many places.
    """
    times, numbers = run.spikes["time"], run.spikes["afferent"].astype(int)
    kinds = [kind for kind in CLASSES if kind in {run.fibres[n][0] for n in numbers}]
    if not kinds or run.pattern is None:
        return None
    unit, cell = run.length()
    classes = np.array([kind for kind, _, _ in run.fibres])
    moving = np.nan_to_num(np.array(run.pattern, float), nan=np.inf, posinf=np.inf)
    velocity, repeat = cell / (run.spacing or 1) * moving
    repeat *= np.maximum(1, np.ceil(cell * np.array([run.width, run.height]) / repeat))  # as many as cover the skin
    middles = cell * (np.array([place for _, *place in run.fibres])[numbers] + 0.5)
    places = np.mod(middles - times[:, None] * velocity, repeat)
    across, along = np.ptp(places, axis=0)[::-1] + 1e-9
    beside = across > along / 3
    height = float(np.clip((8 / len(kinds) if beside else 8) * across / along, 0.8, 8)) + 0.7
    figure, panels = _figure(*((1, len(kinds)) if beside else (len(kinds), 1)), 8, height * (1 if beside else len(kinds)),
                             run.narrow, sharex=True, sharey=True)
    for kind, panel in zip(kinds, panels.flat):
        own = classes[numbers] == kind
        panel.plot(*places[own].T, ".", color=CLASSES[kind], markersize=2, rasterized=own.sum() > 5000)
        panel.set_title(f"{kind.upper()}, {own.sum()} spikes of {(classes == kind).sum()} afferents", fontsize=9)
        panel.set(xlabel=f"x of the pattern ({unit})", ylabel=f"y of the pattern ({unit})", aspect="equal")
        panel.label_outer()
    return figure


@dataclasses.dataclass
class Sweep:
    """The rows of a sweep's runs.csv."""
    rows: list[dict[str, str]]
    keys: dict[str, str]  # keys of the scene that were set, with their units
    outcomes: list[str]  # columns such as sa1_mean_peak
    narrow: bool = False  # pictures for a phone


def sweep_of(rows: list[dict[str, str]], unit_of: Callable[[str], str], spacing: float | None) -> Sweep:
    """Take the rows of runs.csv. unit_of: the unit of a key. spacing: m between cells; None: lengths have no unit."""
    names = list(rows[0])
    of_first = names[names.index("cells_different") + 1:names.index("set")]
    outcomes = [name for name in dict.fromkeys(name for row in rows for name in row)
                if name.endswith(("_final", "_peak", "_peak_time"))]
    units = {key: unit_of(key) for key in of_first if key not in outcomes}
    return Sweep(rows, {key: "" if unit == "m" and not spacing else unit for key, unit in units.items()}, outcomes)


def _curves(sweep: Sweep) -> tuple[str, dict[str, list[dict[str, str]]]]:
    """Return the key with the most values, which becomes the x axis, and the rows of each setting of the others."""
    values = {key: {row[key] for row in sweep.rows} for key in sweep.keys}
    along = max(sweep.keys, key=lambda key: len(values[key]))
    curves: dict[str, list[dict[str, str]]] = {}
    for row in sweep.rows:
        name = ", ".join(f"{key} = {row[key]}" for key in sweep.keys if key != along and len(values[key]) > 1)
        curves.setdefault(name, []).append(row)
    return along, curves


def sweep(of: Sweep) -> Figure | None:
    """Draw the peak of each quantity over the key with the most values."""
    shown = [name for name in QUANTITIES if f"{name}_mean_peak" in of.outcomes]
    if not shown or not of.keys:
        return None
    columns: dict[str, tuple[str, ...]] = {"mean of all cells": ("mean",)}
    if any(f"{name}_max_peak" in of.outcomes for name in shown):
        columns["cell that answers most"] = ("min", "max")
    along, curves = _curves(of)
    texts = list(dict.fromkeys(row[along] for row in of.rows))
    try:
        places, numeric = {text: float(text) for text in texts}, True
    except ValueError:
        places, numeric = {text: float(i) for i, text in enumerate(texts)}, False
    figure, panels = _figure(len(shown), len(columns), 1 + 3.8 * len(columns), 0.9 + 1.8 * len(shown), of.narrow,
                             sharex=True)
    for name, row in zip(shown, panels):
        for (title, statistics), panel in zip(columns.items(), row):
            for i, (label, rows) in enumerate(curves.items()):
                peaks = [max((float(r.get(f"{name}_{s}_peak") or "nan") for s in statistics), key=abs) for r in rows]
                points = sorted(zip((places[r[along]] for r in rows), peaks))
                panel.plot(*zip(*points), "o-", markersize=3, color=_colour(i, len(curves)),
                           label=label if i < MOST_LINES else None)
            panel.set_title(title if name == shown[0] else "", fontsize=9)
        row[0].set_ylabel("peak of\n{} ({})".format(*QUANTITIES[name]))
    for panel in panels[-1]:
        panel.set_xlabel(f"{along} ({of.keys[along]})" if of.keys[along] and numeric else along)
        if not numeric:
            panel.set_xticks(range(len(texts)), texts)
        elif min(places.values()) > 0 and max(places.values()) > 50 * min(places.values()):
            panel.set_xscale("log")
    if len(curves) > 1:
        panels[0, 0].legend(fontsize=7, loc="lower left", bbox_to_anchor=(0, 1.2), ncols=2)
    return figure


def fit(rows: list[dict[str, str]]) -> Figure:
    """Draw measured curves, the model's, and their difference."""
    points = [{name: float(value) for name, value in row.items()} for row in rows]
    name, history = list(rows[0])[-2], "strain" in rows[0]
    if not history:  # the axis is logarithmic
        points = sorted((p for p in points if p["time"] > 0), key=lambda p: (p.get("curve", 0), p["time"]))
    curves: dict[float, list[dict[str, float]]] = {}
    for p in points:
        curves.setdefault(p.get("curve", 0), []).append(p)
    scale = max(abs(p[name]) for p in points) if min(p[name] for p in points) <= 0 else None
    figure, panels = _figure(2, 1, 6, 5, sharex=True, height_ratios=[3, 1])
    curve, residual = panels[:, 0]
    for i, own in enumerate(curves.values()):
        time, measured, model = (np.array([p[key] for p in own]) for key in ("time", name, "model"))
        curve.plot(time, measured, ".", color=BLUE, label="data" if i == 0 else None)
        curve.plot(time, model, color=VERMILLION, label="model" if i == 0 else None)
        residual.plot(time, 100 * (model - measured) / (scale or measured), ".", color=BLUE)
    units = {"modulus": "Pa", "compliance": "1/Pa", "stress": "Pa"}
    curve.set(xscale="linear" if history else "log", ylabel=f"{name} ({units[name]})")
    _legend(curve, 2)
    residual.axhline(0, color="black", linewidth=0.8)
    residual.set(xlabel="time (s)", ylabel="% of the greatest" if scale else "model - data (%)")
    return figure


# The methods of a family share a colour; their markers differ.
FAMILIES = {"exact": (BLUE, "o"), "euler": (VERMILLION, "o"), "rk2": (VERMILLION, "<"), "rk4": (VERMILLION, "^"),
            "backward-euler": (GREEN, "v"), "crank-nicolson": (GREEN, "s"), "sdirk2": (GREEN, ">")}


def _plain(x: float, _: Any = None) -> str:
    """Return what an axis says at a power of ten."""
    return f"{x:g}" if 0.0009 < x < 2000 else f"$10^{{{np.log10(x):.0f}}}$"


def errors(rows: list[dict[str, str]], scene: str, tolerance: float) -> Figure:
    """Draw the error of each way to compute a scene over the time that it takes, and a line up to its bound.

    No label stands over another. The points of a Vulkan device are open.
    """
    figure, panels = _figure(1, 1, 8, 5.5)
    panel = panels[0, 0]
    taken = [row for row in rows if row["seconds"]]
    kept = [row for row in taken if row["bound"] and float(row["bound"]) <= tolerance]
    best = min(kept, key=lambda row: float(row["seconds"]), default=None)
    panel.set_title(f"{scene}: the tolerance of {tolerance:g} is kept " + (
        f"in {1e3 * float(best['seconds']):.3g} ms, by {best['model']} in {best['precision']}" if best else "by no way"), fontsize=11)
    least = 0.3 * min((float(row["error"]) for row in taken if float(row["error"]) > 0), default=1e-17)
    names: list[tuple[float, float, str, str]] = []
    for name in dict.fromkeys(row["method"] for row in taken):
        colour, marker = FAMILIES[name]
        own = [row for row in taken if row["method"] == name]
        points = [(1e3 * float(row["seconds"]), max(float(row["error"]), least)) for row in own]  # 0 lies on the lower border
        if name != "exact":
            panel.plot(*zip(*points), color=colour, linewidth=0.8)
        for row, (x, y) in zip(own, points):
            on_device = name == "exact" and row["device"] != "cpu"
            spread = [[abs(1e3 * float(row[f"seconds_{end}"]) - x)] for end in ("low", "high")]
            panel.errorbar([x], [y], xerr=spread, fmt=marker, color=colour, markersize=5, elinewidth=0.8,
                           markerfacecolor="white" if on_device else colour)
            if row["bound"]:
                panel.plot([x, x], [y, max(float(row["bound"]), least)], color=colour, linewidth=0.6)
            if name == "exact":
                names.append((x, y, f"{row['model']} {row['precision']}" + ", Vulkan" * on_device, colour))
        names += [] if name == "exact" else [(*points[-1], name, colour)]
    panel.axhline(tolerance, color="black", linestyle=":", linewidth=1)
    panel.text(0.01, tolerance, "tolerance", transform=panel.get_yaxis_transform(), va="bottom", fontsize=8)
    panel.set(xscale="log", yscale="log", xlabel="time of a run (ms)", ylabel="greatest error / greatest value (1)")
    for axis, digits in ((panel.xaxis, (1, 2, 5)), (panel.yaxis, (1,))):
        axis.set_major_locator(matplotlib.ticker.LogLocator(subs=digits, numticks=8))
        axis.set_major_formatter(_plain)
        axis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    figure.draw_without_rendering()  # places the axes
    written: list[tuple[float, float]] = []  # points
    for x, y, name, colour in sorted(names, key=lambda one: one[1]):
        right, own = panel.transData.transform((x, y)) * 72 / figure.dpi
        high = own
        while any(abs(r - right) < 120 and abs(h - high) < 10 for r, h in written):
            high += 10 if colour == BLUE else -10  # the exact ways lie at the lower border, others often at the upper one
        written.append((right, high))
        panel.annotate(name, (x, y), (7, high - own), textcoords="offset points", va="center", fontsize=8, color=colour)
    return figure


RUN_FIGURES: tuple[Callable[[Run], Figure | None], ...] = (skin, traces, maps, surface, receptors, spikes, events)
CAPTIONS = {
    "skin": "The skin: what the loads press is grey. Points are receptors, or the middles of afferents.",
    "traces": "Mean of all cells, probes, and the span from the least cell to the greatest.",
    "maps": "Fields of the scene.",
    "surface": "The surface of the skin as it is pressed.",
    "receptors": "Sites in their places when one of their class answers most, and all of them over time.",
    "spikes": "Spikes of the afferents (nerve fibres of the skin), and how often an afferent fires.",
    "events": "Spikes where the sliding pattern was then at their afferent: what the afferents see of the pattern.",
    "sweep": "How results change with the values that were set.",
}


STYLE = """<meta name="viewport" content="width=device-width"><style>
body { font: 16px/1.5 system-ui, sans-serif; margin: 2em auto; max-width: 60em; padding: 0 1em; color: #222 }
figure { margin: 2em 0 } figcaption { color: #555 } img { max-width: 100%; height: auto }
td, th { padding: 0 1em 0 0; text-align: left; vertical-align: top }
pre { overflow-x: auto; background: #f4f4f4; padding: 1em }
@media (max-width: 700px) { table, tbody, tr, th, td { display: block } td { padding-bottom: .5em } }</style>"""


def page_of(title: str, facts: Mapping[str, str], warnings: Iterable[str], scene: str,
            pictures: Mapping[str, bytes], narrow: Mapping[str, bytes]) -> str:
    """Return a page of HTML that needs no other file. pictures: as SVG. narrow: the same for a phone."""
    text = html.escape
    parts = ["<!DOCTYPE html>", f'<html lang="en"><meta charset="utf-8"><title>{text(title)}</title>',
             STYLE, f"<h1>{text(title)}</h1>", "<table>"]
    parts += [f"<tr><th>{text(name)}</th><td>{text(value)}</td></tr>" for name, value in facts.items()] + ["</table>"]
    parts += [f"<p><strong>Warning:</strong> {text(warning)}.</p>" for warning in warnings]
    for name, svg in pictures.items():
        wide, slim = ("data:image/svg+xml;base64," + base64.b64encode(of).decode() for of in (svg, narrow[name]))
        caption = text(CAPTIONS[name])
        parts.append(f'<figure><picture><source media="(max-width: 700px)" srcset="{slim}"><img alt="{caption}" '
                     f'src="{wide}"></picture><figcaption>{caption}</figcaption></figure>')
    parts += [f"<details><summary>The scene</summary><pre>{text(scene)}</pre></details>"] if scene else []
    return "\n".join(parts) + "</html>\n"


def _drawn(figure: Figure, kind: str) -> bytes:
    content = io.BytesIO()
    with matplotlib.rc_context({"svg.hashsalt": "dermis"}):  # the same file from the same numbers
        figure.savefig(content, format=kind, dpi=120, metadata={"Date": None} if kind == "svg" else None)
    return content.getvalue()


def _write(path: Path, content: bytes) -> None:
    part = path.with_name(f"{path.name}.dermis-{os.getpid()}.part")
    try:
        with open(part, "xb") as file:
            file.write(content)
        part.rename(path)
    finally:
        part.unlink(missing_ok=True)


def _noted(figures: Mapping[str, Figure], part: int) -> Iterable[tuple[str, Figure]]:
    """Yield the figures, and show on a terminal how many of three parts of the work are done and the seconds left."""
    start = time.monotonic()
    for done, item in enumerate(figures.items()):
        yield item
        share = (part + (done + 1) / len(figures)) / 3
        left = (time.monotonic() - start) * (1 - share) * 3 * len(figures) / (done + 1)
        if sys.stderr.isatty():
            text = f"drawing {100 * share:3.0f} %, {left:.0f} s left" if share < 1 else ""
            print(f"\r\033[K{text}", end="", file=sys.stderr, flush=True)


def write(folder: Path, source: Run | Sweep, figures: Mapping[str, Figure]) -> None:
    """Write each figure as PNG and SVG, and report.html with all of them."""
    slim = figures_of(dataclasses.replace(source, narrow=True))
    wide = {name: _drawn(figure, "svg") for name, figure in _noted(figures, 0)}
    narrow = {name: _drawn(figure, "svg") for name, figure in _noted(slim, 1)}
    for name, figure in _noted(figures, 2):
        _write(folder / f"{name}.svg", wide[name])
        _write(folder / f"{name}.png", _drawn(figure, "png"))
    text = (source.title, head(source), source.warnings, source.scene) if isinstance(source, Run) else (
        folder.name, {"runs": str(len(source.rows)), "keys": ", ".join(source.keys)}, [], "")
    _write(folder / "report.html", page_of(*text, wide, narrow).encode())


def read(folder: Path, unit_of: Callable[[str], str]) -> Run | Sweep:
    """Read a folder of `dermis run`: a run, or a sweep."""
    starts = {"runs.csv": b"run,model,precision,", "summary.json": b'{\n  "program": "dermis",'}
    ours = [name for name in starts if (folder / name).is_file() and (folder / name).read_bytes().startswith(starts[name])]
    if "runs.csv" in ours:
        rows = _read(folder / "runs.csv")
        return sweep_of(rows, unit_of, run_in(folder / rows[0]["run"]).spacing)
    if ours:
        return run_in(folder)
    raise FileNotFoundError(f"{folder}: has neither summary.json nor runs.csv of dermis; allowed: a folder of `dermis run`")


def figures_of(source: Run | Sweep) -> dict[str, Figure]:
    """Draw what there is, by name."""
    draws: tuple[Callable[[Any], Figure | None], ...] = RUN_FIGURES if isinstance(source, Run) else (sweep,)
    return {draw.__name__: figure for draw in draws if (figure := draw(source))}


def main(folder: Path, what: str, *more: str) -> None:
    if what == "run":
        source = read(folder, lambda key: json.loads(more[0] if more else "{}").get(key, ""))
        write(folder, source, figures_of(source))
    else:
        rows = _read(folder / f"{what}.csv")
        figure = fit(rows) if what == "fit" else errors(rows, more[0], float(more[1]))
        _write(folder / f"{what}.png", _drawn(figure, "png"))


if __name__ == "__main__":
    try:
        main(Path(sys.argv[1]), *sys.argv[2:])
    except (OSError, ValueError) as error:
        sys.exit(f"dermis: {error}")
