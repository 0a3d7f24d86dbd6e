# SPDX-License-Identifier: MIT
"""The page of figures, RESULTS.md, from the rows of one run of dermis-bench: RESULTS.md.in, whose {{names}} are functions
of this file. Lines behind a name are words for its lines. A section none of whose tables has a line is left out."""
import csv
import math
import re
from pathlib import Path

DASH = "–"
PEER_NAMES = {"native": "C++", "numba": "Numba", "numpy": "NumPy"}
METHODS = {"exact": "exact", "euler": "forward Euler", "rk2": "RK2", "rk4": "RK4", "backward-euler": "backward Euler",
           "crank-nicolson": "Crank-Nicolson", "sdirk2": "SDIRK2"}
FASTEST = 4  # ms: the least retardation time of the stiff chain
SIMULATED_SECONDS = 2.56  # of the rows of accuracy and stiff


def number(text):
    return float(text) if text else math.nan


def load(path):
    """The rows as text, and as numbers cells, seconds, least (pictures take the least of the runs, tables the median), ns
    and least_ns of a cell and step, us of a step, cost; on: cpu, vulkan or peer; shape: width, height and pads of
    exact-4x6x64; place: the threads of a CPU, 0 of a device."""
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        steps = max(number(row["steps"]), 1) if row["steps"] else 1
        row["cells"] = number(row["width"]) * number(row["height"])
        row["seconds"], row["least"] = number(row["wall_median_s"]), number(row["wall_least_s"])
        row["ns"], row["least_ns"] = (row[key] * 1e9 / row["cells"] / steps for key in ("seconds", "least"))
        row["ms"], row["us"] = row["seconds"] * 1e3, row["seconds"] / steps * 1e6
        row["cost"] = row["least"] * 1e9 / row["cells"] / SIMULATED_SECONDS
        row["on"] = "cpu" if on_cpu(row) else "vulkan" if on_vulkan(row) else "peer"
        row["place"] = "0" if row["on"] == "vulkan" else row["threads"]
        sides = row["method"].split("-")[-1].split("x")
        row["shape"] = tuple(map(int, sides)) if len(sides) == 3 else None
    return rows


def fits(row, match):
    return all(row[k] in v if isinstance(v, (set, frozenset)) else row[k] == v for k, v in match.items())


def of(rows, workload, **match):
    return [r for r in rows if r["workload"] == workload and fits(r, match)]


def on_cpu(row):
    return row["backend"].startswith("cpu")


def on_vulkan(row):
    return row["backend"].startswith("vulkan")


def step_of(row):
    """ms, on the stiff chain."""
    return number(row["dt_over_tau"]) * FASTEST


def small(x):
    """An error: two digits, as 2.5e-3, 0.12 or 140."""
    return f"{x:.1e}".replace("e-0", "e-") if x < 0.01 else f"{x:.0f}" if x >= 10 else f"{x:.2g}"


def num(x, digits=3):
    """Three digits, without an exponent where a reader would not expect one."""
    if math.isnan(x):
        return DASH
    if x == 0 or x >= 100:
        return f"{x:.0f}"
    return small(x) if x < 1e-3 else f"{x:.{max(digits - 1 - math.floor(math.log10(x)), 0)}f}"


def best(rows, value, **match):
    """The number of the fastest row that matches; not a number if there is none."""
    return min((number(r[value]) if isinstance(r[value], str) else r[value] for r in rows
                if r["status"] in ("ok", "unstable") and fits(r, match)), default=math.nan)


def table(head, lines):
    lines = [line for line in lines if any(cell not in (DASH, "") for cell in line[1:])]
    return "\n".join(f"| {' | '.join(line)} |" for line in (head, ["---"] * len(head), *lines)) + "\n" if lines else ""


def grid(rows, corner, lines, columns, value="ns"):
    """A table of the best rows. lines: a name and what rows match, each. columns: so too, or a function of what a line matches."""
    def cell(line, column):
        return column(line) if callable(column) else num(best(rows, value, **{**line, **column}))

    return table([corner, *(title for title, _ in columns)],
                 [[name, *(cell(line, column) for _, column in columns)] for name, line in lines])


def beside(rows, value, match, against):
    """A column of numbers, each with its ratio in brackets. against: of a line, what the row beside it matches."""
    def cell(line):
        x = best(rows, value, **match, **line)
        return f"{num(x)} ({num(x / best(rows, value, **{**match, **line, **against(line)}), 2)})"
    return cell


def ratio(rows, value, match, against):
    """A column of ratios of a line's row to another."""
    return lambda line: num(best(rows, value, **{**line, **match}) / best(rows, value, **{**line, **against}), 2)


def by(names, column, **match):
    """Lines by the words that the page has for values of a column."""
    return [(text, {column: key, **match}) for key, text in names.items()]


def plural(threads):
    return "1 thread" if threads == "1" else f"{threads} threads"


def driver(rows):
    return next((r["driver"] for r in rows if on_vulkan(r)), "Vulkan")


def threads_of(rows):
    """One thread and all of them, as text: of the rows of the CPU."""
    return sorted({r["threads"] for r in rows if on_cpu(r)}, key=int)


def on_threads(rows):
    return [(plural(t), {"on": "cpu", "threads": t}) for t in threads_of(rows)]


def shapes(rows):
    """The shapes of pads, small ones first, by their names."""
    return [(f"{n} of {w} x {h}", {"shape": (w, h, n)})
            for w, h, n in sorted({r["shape"] for r in rows}, key=lambda s: (s[0] * s[1], s[2]))]


def all_threads(rows):
    return plural(rows[0]["cores"])


def drivers(rows):
    return "; ".join(sorted({f"{r['driver']} {r['driver_version']}" for r in rows if on_vulkan(r)})) or "no device"


def peers(rows):
    there = sorted({f"{r['driver']} {r['driver_version']}".strip() for r in rows
                    if r["backend"] in ("numba", "numpy", "cvode") and r["status"] == "ok"})
    missing = sorted({r["backend"] for r in rows if r["status"] == "not installed"})
    return ("; ".join(there) or "none") + ("; not installed: " + ", ".join(missing) if missing else "")


def presses(rows):
    found = [r for r in of(rows, "pads", model="batch") if r["receptors"] in ("", "0")]
    places = [(plural(t), t) for t in threads_of(found)] + [(driver(found), "0")]
    columns = [(f"{title}, {name}", {"precision": p, "place": place})
               for p, title in (("f32", "f32"), ("f32-compensated", "default")) for name, place in places]
    return grid(found, "pads", shapes(found), columns, "us")


def option_shapes(found):
    return sorted({r["shape"] for r in found}, key=lambda s: -s[2])


def options(rows, names):
    found, columns = of(rows, "options"), []
    for s in option_shapes(found):
        for place in sorted({r["place"] for r in found if r["shape"] == s}, key=lambda p: (p == "0", int(p))):
            columns.append((f"{f'{s[2]} of ' if s[2] > 1 else ''}{s[0]} x {s[1]}, {driver(found) if place == '0' else plural(place)}",
                            beside(found, "us", {"shape": s, "place": place}, lambda line: {"model": "all"})))
    return grid(found, "what is asked for", by(names, "model"), columns)


def kinds(rows, names):
    found = of(rows, "kinds")
    first = {r["height"]: {"model": r["model"], "width": r["width"]} for r in reversed(found)}
    lines = [(f"{text.format(width)} | {width} x {r['height']}", {"model": model, "width": width, "height": r["height"]})
             for model, text in names.items()
             for width, r in sorted({r["width"]: r for r in of(found, "kinds", model=model)}.items(), key=lambda w: -int(w[0]))]
    columns = [(name, beside(found, "ns", match, lambda line: first[line["height"]])) for name, match in on_threads(found)]
    return grid(found, "skin | cells", lines, columns).replace("| --- |", "| --- | --- |", 1)


def places(rows):
    """Lines of the chart of cells: name, cells and ns of each size, CPU threads first."""
    lines = {}
    for r in sorted(of(rows, "cells"), key=lambda r: (on_vulkan(r), int(r["threads"] or 0), r["cells"])):
        cells, ns = lines.setdefault(r["device"] if on_vulkan(r) else plural(r["threads"]), ([], []))
        cells.append(r["cells"])
        ns.append(r["least_ns"])
    return lines


def crossings(rows):
    """For each device the cells from which on it is faster than every number of threads; None where it never is."""
    lines, found = places(rows), {}
    cpu = [line for name, line in lines.items() if "thread" in name]
    for name, (cells, ns) in lines.items():
        if "thread" in name or not cpu:
            continue
        log = [math.log(min(line[1][i] for line in cpu) / ns[i]) for i in range(len(cells))]  # > 0: the device is faster
        slower = [i for i, x in enumerate(log) if x <= 0]
        i = slower[-1] if slower else -1
        found[name] = None if i + 1 == len(log) else cells[0] if i < 0 else math.exp(
            math.log(cells[i]) + log[i] / (log[i] - log[i + 1]) * math.log(cells[i + 1] / cells[i]))
    return found


def cells(rows):
    lines = places(rows)
    sizes = sorted({c for line in lines.values() for c in line[0]})
    return table(["cells", *lines], [[f"{round(math.sqrt(c))} x {round(math.sqrt(c))}",
                                      *(num(dict(zip(*line)).get(c, math.nan)) for line in lines.values())] for c in sizes])


def native_pads(rows):
    found, columns = of(rows, "pads", precision="f32"), []
    for name, match in on_threads(found):
        native, batch = {**match, "model": "native-bits"}, {**match, "model": "batch"}
        columns += [(f"own loop, {name}", native), (f"dermis, {name}", batch), (f"ratio, {name}", ratio(found, "ns", batch, native))]
    return grid(found, "pads", shapes(of(found, "pads", model="native-bits")), columns)


def touched(rows, names):
    found = of(rows, "touch")
    columns = [(f"{s[2]} pads, {name}", {"shape": s, **match})
               for s in sorted({r["shape"] for r in found}, key=lambda s: -s[2]) for name, match in on_threads(found)]
    return grid(found, "us", by(names, "model"), columns, "us")


def bodies(rows, names):
    columns = []
    for kind, share in (("bodies", "all"), ("few-bodies", "one in a hundred")):
        for r in of(rows, kind, model="touch-press"):
            columns += [(f"{share} of {r['shape'][2]} pads", {"workload": kind}),
                        ("over the press", ratio(rows, "us", {"workload": kind}, {"workload": kind, "model": "touch-press"}))]
    return grid(rows, "us", by(names, "model"), columns, "us")


def batches(rows, names):
    found = of(rows, "pads-batch")
    in_each = max((int(r["receptors"]) / r["shape"][2] for r in found if r["model"] == "batch-sites"), default=0)
    return grid(found, "", [(text.format(f"{in_each:.0f}"), line) for text, line in by(names, "model")],
                [("CPU path, 1 thread", {"on": "cpu"}), (driver(found), {"on": "vulkan"})])


def hand_sites(rows):
    found = [r for r in of(rows, "pads-batch") if r["model"] in ("sites", "fields")]
    return table(["sites", "read as sites", "all cells as fields"],
                 [[r["receptors"], num(r["us"]), num(fields["us"])] for r, fields in zip(found[::2], found[1::2])])


def by_a_copy(rows, model):
    return num(best(of(rows, "state"), "seconds", model=model) / best(of(rows, "state"), "seconds", model="memcpy"), 2)


def by_side(rows):
    return [(n, {"width": n}) for n in sorted({r["width"] for r in of(rows, "press")}, key=int)]


def isas_of(rows):
    return [b for b in ("cpu-avx512", "cpu-avx2", "cpu-plain") if any(r["backend"] == b for r in of(rows, "press"))]


def press(rows):
    all_of, moves = {"threads": rows[0]["cores"]}, {"backend": {"cpu-moves", "cpu-moves-cached"}}
    best_isa, *others = isas_of(rows) or [""]
    columns = [(f"dermis, {all_threads(rows)}", {"backend": best_isa, **all_of}), ("1 thread", {"backend": best_isa, "threads": "1"}),
               *((f"{isa[4:]}, {all_threads(rows)}", {"backend": isa, **all_of}) for isa in others),
               (f"limit, {all_threads(rows)}", {**moves, **all_of}), ("limit, 1 thread", {**moves, "threads": "1"}),
               (driver(of(rows, "press")), {"backend": "vulkan"}), ("its limit", {"backend": "vulkan-moves"})]
    return grid(of(rows, "press"), "N", by_side(rows), columns)


def beside_peers(rows):
    all_of = {"threads": rows[0]["cores"]}
    dermis = {"backend": next(iter(isas_of(rows)), "")}
    columns = [("dermis", {**dermis, **all_of}), ("C++", {"backend": "native", **all_of}), ("dermis, 1 thread", {**dermis, "threads": "1"}),
               ("C++, 1 thread", {"backend": "native", "threads": "1"}), ("Numba", {"backend": "numba"}), ("NumPy", {"backend": "numpy"})]
    return grid(of(rows, "press"), "N", by_side(rows), columns)


def ways(rows):
    found = of(rows, "press", status="ok")
    lines = [(f"{name}, {method.replace('-', ' ')}", {"backend": p, "method": method, "threads": "1" if p == "numpy" else rows[0]["cores"]})
             for p, name in PEER_NAMES.items() for method in dict.fromkeys(r["method"] for r in found if r["backend"] == p)]
    return grid(found, "way", lines, by_side(rows))


Z = (1, 6, 10, 22, 40)  # depths over the spacing of cells


def depths(rows):
    found, columns = of(rows, "depth"), []

    def more(line, where):
        ratio, press = best(found, "ratio", **{**line, **where}), best(found, "ns", **{**line, **where, "model": "surface"})
        return num(press), f"{num((ratio - 1) / 4 * press)} ({num((ratio - 1) / 4, 2)})"

    for device, threads in dict.fromkeys((r["device"], r["threads"]) for r in found):
        name, where = plural(threads) if device == "cpu" else device, {"device": device, "threads": threads}
        there = lambda line, where=where: not math.isnan(best(found, "ratio", **{**line, **where}))
        columns += [(title, lambda line, i=i, where=where, there=there: more(line, where)[i] if there(line) else DASH)
                    for i, title in enumerate((f"{name}: a press", "a class more"))]
    lines = [(f"{f'{s[2]} of ' if s[2] > 1 else ''}{s[0]} x {s[1]} | {model.replace('z/h=', '')}", {"shape": s, "model": model})
             for s, model in dict.fromkeys((r["shape"], r["model"]) for r in found if r["model"] != "surface")]
    return grid(found, "cells | z/h", lines, columns).replace("| --- |", "| --- | --- |", 1)


def depth_errors(rows, names):
    return table(["way", *(f"z/h = {z}" for z in Z)], [[text, *("".join(
        f"{small(number(r['err_sa1']))} in {num(r['ns'])} ns" for r in of(rows, "depth-errors", model=way, method=f"z/h={z}"))
        for z in Z)] for way, text in names.items()])


def errors_in(row):
    return [small(number(row[e])) for e in ("err_strain", "err_fa1")]


def accuracy(rows, names):
    lines = []
    for key, name in names.items():
        method, precision = key.split()
        ladder = sorted(of(rows, "accuracy", method=method, model="march", precision=precision, stencil="five-point", on="cpu"),
                        key=lambda r: number(r["steps"]))
        for few, many in zip(ladder[:1], ladder[-1:]):
            lines.append([name, *(["refused"] * 2 if few["status"] == "unstable" else errors_in(few)), few["steps"],
                          *errors_in(many), many["steps"]])
    return table(["method", "strain, few steps", "FA1", "steps", "strain, many steps", "FA1", "steps"], lines)


def stiff(rows):
    found = {(r["method"], round(step_of(r), 6)): r for r in of(rows, "stiff", model="sites")}
    lines = []
    for step in sorted({step for _, step in found}):
        line = [found.get((m, step)) for m in METHODS]
        lines.append([num(step), *(DASH if not r else "refused" if r["status"] == "unstable" else ", ".join(errors_in(r)) for r in line),
                      num(line[0]["cost"]) if line[0] else DASH])
    return table(["step, ms", *METHODS.values(), "exact: ns per cell and simulated second"], lines)


def solver_table(rows, workload, head, against):
    names = {"sine": "exact, the load a sine", "frames-linear": "exact, frames every {:.3g} ms, linear between them",
             "frames-parabolic": "exact, frames every {:.3g} ms, parabolas through them"}
    return table(head, [[names.get(r["model"], f"{r['backend'].upper()}, {r['method'].replace('rtol=', 'tolerance ')}").format(step_of(r)),
                         *errors_in(r), num(r["least"] * 1e3), num(r["least"] / against, 2)]
                        for r in of(rows, workload) if r["status"] != "not installed" and r["model"] != "sites"])


def solvers(rows):
    same = next((r["least"] for r in of(rows, "stiff", method="exact") if abs(step_of(r) - 10) < 1e-6), math.nan)
    return solver_table(rows, "stiff", ["solver", "error of strain", "error of FA1", "ms", "times exact"], same)


def spikes(rows, names):
    lines = []
    for r in of(rows, "spikes", status="ok"):
        step = r["least"] / number(r["steps"]) * 1e3
        what = f"mean rate {r['method'][6:-2]} Hz" if r["model"] == "located" else names[r["method"]]
        lines.append([f"{PEER_NAMES.get(r['backend'], 'dermis')}: {what}", r["receptors"], driver([r]) if on_vulkan(r) else plural(r["threads"]),
                      num(step), num(step * 1e6 / number(r["receptors"]))])
    return table(["", "afferents", "where", "ms for a step of 1 ms", "ns an afferent"], lines)


def spike_steps(rows):
    ns = [(float(r["method"]), 1e9 * r["least"] / number(r["steps"]) / number(r["receptors"])) for r in of(rows, "spikes-steps")]
    return table(["step, ms", "ns an afferent and step", "ns an afferent and second"],
                 [[num(1e3 * step), num(each), num(each / step)] for step, each in ns])


def marches(rows, names):
    return grid(rows, "materials", by(names, "workload", on="cpu"),
                [("N", lambda line: next((r["width"] for r in rows if fits(r, line)), "")), ("f32", {"precision": "f32"}),
                 ("f32 compensated", {"precision": "f32-compensated"}), ("f64", {"precision": "f64"})])


def chains(rows):
    found = of(rows, "chains")
    columns = [("bytes per cell", lambda line: next(r["bytes_per_cell"] for r in found if fits(r, line)))]
    for name, on in ((all_threads(rows), "cpu"), (driver(found), "vulkan")):
        columns += [(f"{name}: ns", {"on": on}), ("times one", ratio(found, "ns", {"on": on}, {"on": on, "method": "exact-1"}))]
    return grid(found, "elements", [(m[6:].replace("-spring", " and a spring"), {"method": m})
                                    for m in dict.fromkeys(r["method"] for r in found)], columns)


def less(rows):
    lines = []

    def add(what, mine, against, other):
        if not math.isnan(mine + other):
            lines.append([what, num(mine), against, num(other), num(other / mine)])

    study = of(rows, "study")
    for against, model, scenes in (("NumPy, every field kept as the study keeps it", "kept", 1), ("NumPy, step by step", "stepped", 1),
                                   ("marched in f32", "march", 9)):
        steps = {"1000"} if scenes == 1 else {"9000"}  # a quick run has fewer, which are no scene of the study
        add("a scene of the study, `moments`, maps in memory to traces in memory", best(study, "seconds", model="moments") / 9, against,
            best(study, "seconds", model=model, steps=steps) / scenes)
    for r in of(rows, "held-map", model="march", on="cpu"):
        add("{steps} steps of a map whose strength alone changes, means, {width} x {width}, `moments`".format(**r),
            best(of(rows, "held-map"), "seconds", model="moments", width=r["width"]), "marched in f32", r["seconds"])
    for name, workload, match in (("sites of a hand on {width} x {width} cells, uniform, `sites`, {steps} steps", "population", {"method": "exact"}),
                                  ("sites of a hand on {width} x {width} cells, four materials, `sites`, {steps} steps", "population",
                                   {"method": "exact-materials"}),
                                  ("the same frame by frame, {width} x {width}, {steps} frames, CPU path", "population-frames", {"on": "cpu"}),
                                  ("the same frame by frame, {width} x {width}, {steps} frames, " + driver(rows), "population-frames",
                                   {"on": "vulkan"})):
        found = of(rows, workload, **match)
        if found:
            add(name.format(**found[0]), best(found, "seconds", model="sites"),
                "the whole field" + (" in f32" if workload == "population" else ""), best(found, "seconds", model="march"))
    return table(["what", "s", "against", "s", "times"], lines)


def growth(rows, names):
    return table(["", "ns per cell and step", "plan, MB", "peak by plan"],
                 [[names[key].format(**r), num(r["ns"]), num(number(r["limit_GBs"]) * 1e3), num(number(r["of_limit"]))]
                  for r in rows for key in [f"{r['workload']} {r['model']}"] if key in names])


def processes(rows, names):
    return table(["command", "processor", "clock"], [[text, num(1e3 * number(r["busy_least_s"])), num(1e3 * r["seconds"])]
                                                     for workload, text in names.items() for r in of(rows, workload)])


def sites(rows):
    found = of(rows, "options")
    most = sorted({(s[2] == 1, max(number(r["receptors"]) for r in found if r["shape"] == s and r["receptors"]) / s[2])
                   for s in option_shapes(found)})
    return " and ".join(f"{n:.0f} in the one skin" if single else f"{n:.0f} in each pad" for single, n in most)


def fingertip(rows):
    found = [r for r in of(rows, "depth", model="fingertip", shape=(200, 200, 1)) if on_cpu(r)]
    last = max(found, key=lambda r: int(r["threads"]))
    return f"{num(last['us'] / 1e3)} ms on {plural(last['threads'])}"


TABLES = {of.__name__: of for of in (
    presses, options, kinds, cells, native_pads, touched, bodies, batches, hand_sites, press, beside_peers, ways, depths, depth_errors,
    accuracy, stiff, solvers, spikes, spike_steps, marches, chains, less, growth, processes)} | {
    "press_fa1": lambda rows: grid(of(rows, "press-fa1"), "N", by_side(rows), [
        (plural(t), {"threads": t}) for t in dict.fromkeys(("1", rows[0]["cores"]))]),
    "paced": lambda rows, names: table(["", "within a millisecond", "median, us"], [
        [text.format(r["receptors"]), f"{100 * number(r['of_limit']):.2f} %", num(r["seconds"] * 1e6)]
        for m, text in names.items() for r in of(rows, "paced", model=m)]),
    "made": lambda rows, names: grid(of(rows, "pads-made"), "", by(names, "model"), [
        ("CPU path", {"on": "cpu"}), (driver(of(rows, "pads-made")), {"on": "vulkan"})], "ms"),
    "smooth": lambda rows: solver_table(rows, "smooth", ["", "error of strain", "error of FA1", "ms", "times the exact sine"],
                                        best(of(rows, "smooth"), "least", model="sine")),
    "construction": lambda rows, names: grid(rows, "N", by(names, "workload"), [
        (r["width"], {"width": r["width"]}) for r in of(rows, "construction")], "seconds")}
WORDS = {
    "quick": lambda rows: "" if rows[0]["size"] == "full" else
    "\n**A quick run: few rounds on small grids, good for a look and not for a figure.**\n",
    "machine": lambda rows: f"{rows[0]['cpu']}; {rows[0]['cores']} cores",
    **{key: lambda rows, key=key: rows[0][key] for key in ("date", "commit", "compiler")},
    "drivers": drivers, "peers": peers, "threads": all_threads, "sites": sites, "fingertip": fingertip,
    "device": lambda rows: driver(of(rows, "pads")),
    "pays": lambda rows: " ".join(
        f"{name} is faster than the CPU path {f'from some {cells:.2g} cells on' if cells else 'at no size'}."
        for name, cells in crossings(rows).items()) or "No Vulkan device was at hand.",
    "batch": lambda rows: "{2} pads of {0} x {1}".format(*of(rows, "pads-batch", model="batch")[0]["shape"]),
    "hand": lambda rows: "{width} x {height}".format(**of(rows, "pads-batch", model="sites")[0]),
    "save": lambda rows: by_a_copy(rows, "save"), "restore": lambda rows: by_a_copy(rows, "load"),
    "peer_error": lambda rows: num(max((number(r[e]) for r in of(rows, "press") for e in (
        "err_sa1", "err_sa2", "err_fa1", "err_fa2") if r[e]), default=math.nan), 2),
    "accuracy_cells": lambda rows: "{width} x {height}".format(**of(rows, "accuracy")[0]),
    "stencils": lambda rows: " and ".join(
        f"{small(number(r['err_curvature']))} {r['stencil']}" for s in ("five-point", "fourth-order")
        for r in of(rows, "accuracy", stencil=s, method="exact")[:1]),
    "chain_cells": lambda rows: "{width} x {width}".format(**of(rows, "chains")[0]),
    "hundred": lambda rows: num(best(of(rows, "materials-100"), "seconds") / best(of(rows, "materials-1"), "seconds"), 2),
    "growth_steps": lambda rows: of(rows, "growth")[0]["steps"]}


def page(rows):
    """rows: as load() has them."""
    sections = []
    for section in re.split(r"\n(?=## )", (Path(__file__).parent / "RESULTS.md.in").read_text().rstrip()):
        tables = {}
        for name, lines in re.findall(r"{{(\w+)((?:\n.*?)?)}}(?!})", section, re.S):
            if name in TABLES:
                names = dict(line.split(": ", 1) for line in lines.split("\n")[1:])
                tables[name] = TABLES[name](rows, names) if names else TABLES[name](rows)
        if not tables or any(tables.values()):
            sections.append(re.sub(r"{{(\w+)((?:\n.*?)?)}}(?!})", lambda m: tables[m[1]] if m[1] in tables else WORDS[m[1]](rows),
                                   section, flags=re.S))
    return "\n".join(sections)
