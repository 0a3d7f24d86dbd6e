# SPDX-License-Identifier: MIT
"""The page of figures, RESULTS.md, from the rows of one run of dermis-bench. Every number in it is that run's."""

import math

DASH = "–"
PEERS = ("native", "pocl", "halide", "numba", "numpy")
PEER_NAMES = {"native": "C++", "pocl": "OpenCL (PoCL)", "halide": "Halide", "numba": "Numba", "numpy": "NumPy"}
OPTIONS = {
    "all": "all four responses of every cell, f32",
    "compensated": "the same in the default precision (f32 with compensated sums)",
    "three": "three responses: SA1, FA1, FA2, without the integral",
    "two": "two responses: SA1 and FA1",
    "one": "one response: SA1",
    "receptors": "sites in place of fields; the whole frame is handed over",
    "receptors-cells": "the same, with the pressures of their cells alone (`press_cells`)",
    "frames-4": "four frames in one press, responses of the last (`press_frames`), per frame",
    "frames-8": "eight frames in one press, per frame",
}


def number(text):
    return float(text) if text else math.nan


def of(rows, workload, **more):
    return [r for r in rows if r["workload"] == workload and all(r[k] == v for k, v in more.items())]


def on_cpu(row):
    return row["backend"].startswith("cpu")


def on_vulkan(row):
    return row["backend"].startswith("vulkan")


def small(x):
    """An error: two digits, as 2.5e-3, 0.12 or 140."""
    return f"{x:.1e}".replace("e-0", "e-") if x < 0.01 else f"{x:.0f}" if x >= 10 else f"{x:.2g}"


def num(x, digits=3):
    """Three digits, without an exponent where a reader would not expect one."""
    if math.isnan(x):
        return DASH
    if x == 0 or x >= 100:
        return f"{x:.0f}"
    if x < 1e-3:
        return small(x)
    digits = max(digits - 1 - math.floor(math.log10(x)), 0)
    return f"{x:.{digits}f}"


def one(rows, key="seconds", **more):
    """The number of the fastest row that matches; not a number where there is none."""
    return min(
        (r[key] for r in rows if all(r[k] == v for k, v in more.items()) and r["status"] in ("ok", "unstable")),
        default=math.nan,
    )


def table(head, lines):
    lines = [line for line in lines if any(cell not in (DASH, "") for cell in line[1:])]
    return "\n".join(f"| {' | '.join(line)} |" for line in (head, ["---"] * len(head), *lines)) + "\n" if lines else ""


def threads_of(rows):
    """One thread and all of them, as text: of the rows of the CPU."""
    return sorted({r["threads"] for r in rows if on_cpu(r)}, key=int)


def plural(threads):
    return "1 thread" if threads == "1" else f"{threads} threads"


def driver(rows):
    return next((r["driver"] for r in rows if on_vulkan(r)), "Vulkan")


def shape(row):
    """Width, height and number of pads, of exact-4x6x64."""
    return tuple(int(n) for n in row["method"].split("-")[-1].split("x"))


def us(row):
    return row["seconds"] / max(number(row["steps"]), 1) * 1e6


def header(rows):
    first = rows[0]
    quick = (
        ""
        if first["size"] == "full"
        else "\n**A quick run: few rounds on small grids, good for a look and not for a figure.**\n"
    )
    drivers = sorted({f"{r['driver']} {r['driver_version']}" for r in rows if on_vulkan(r)})
    peers = sorted(
        {
            f"{r['driver']} {r['driver_version']}".strip()
            for r in rows
            if r["backend"] in (*PEERS[1:], "cvode", "lsoda") and r["status"] == "ok"
        }
    )
    missing = sorted({r["backend"] for r in rows if r["status"] == "not installed"})
    return f"""# What a press costs
{quick}
| | |
|---|---|
| machine | {first['cpu']}; {first['cores']} cores |
| date | {first['date']} |
| commit | {first['commit']} |
| compiler | {first['compiler']} |
| Vulkan | {'; '.join(drivers) or 'no device'} |
| peers | {'; '.join(peers) or 'none'}{'; not installed: ' + ', '.join(missing) if missing else ''} |

This page is written by one `./run bench`, which measures one commit once; [notes.md](notes.md) says how to use the
benchmark, and what is known from elsewhere. The results of every contender are checked before it is timed: the
library's bits against plain loops on one thread, a peer's numbers against the same model in double. What stands in
one table is timed in turn within the same rounds, and a figure is the median of its rounds. Ratios within a table
mean something; times of another machine, or of a busy one, do not. {DASH} was not measured.

"f32" is single precision. The default precision, "compensated", is f32 with sums that carry their rounding errors. "1
thread" is the calling thread alone.
"""


def presses(rows):
    found = [r for r in of(rows, "pads", model="batch") if r["receptors"] in ("", "0")]
    if not found:
        return ""
    threads, device = threads_of(found), driver(found)
    columns = (
        [("f32", t) for t in threads]
        + [("f32", "0")]
        + [("f32-compensated", t) for t in threads]
        + [("f32-compensated", "0")]
    )
    head = ["pads"] + [f"{'f32' if p == 'f32' else 'default'}, {device if t == '0' else plural(t)}" for p, t in columns]
    lines = []
    for width, height in sorted({shape(r)[:2] for r in found}, key=lambda s: s[0] * s[1]):
        for count in sorted({shape(r)[2] for r in found if shape(r)[:2] == (width, height)}):
            here = [r for r in found if shape(r) == (width, height, count)]
            line = [f"{count} of {width} x {height}"]
            for precision, t in columns:
                times = [
                    us(r)
                    for r in here
                    if r["precision"] == precision and (on_vulkan(r) if t == "0" else on_cpu(r) and r["threads"] == t)
                ]
                line.append(num(min(times, default=math.nan)))
            lines.append(line)
    return f"""
## Time of a press

Microseconds per press of a batch of pads (small skins, pressed by one call of `Skin::press`): the caller's
pressures are checked and copied, every cell is stepped, and the four responses of every cell can be read. {device}
is left out above four million cells. `dermis bench scene.toml --count n` answers for a skin of your own.

{table(head, lines)}"""


def options(rows):
    found = of(rows, "options")
    if not found:
        return ""
    columns = []
    for s in sorted({shape(r) for r in found}, key=lambda s: -s[2]):
        here = [r for r in found if shape(r) == s]
        columns += [(s, t) for t in threads_of(here)] + ([(s, "0")] if any(on_vulkan(r) for r in here) else [])
    device = driver(found)

    def title(s, t):
        return f"{f'{s[2]} of ' if s[2] > 1 else ''}{s[0]} x {s[1]}, {device if t == '0' else plural(t)}"

    def time(s, t, option):
        return min(
            (
                us(r)
                for r in found
                if shape(r) == s
                and r["model"] == option
                and (on_vulkan(r) if t == "0" else on_cpu(r) and r["threads"] == t)
            ),
            default=math.nan,
        )

    lines = []
    for option, text in OPTIONS.items():
        line = [text]
        for s, t in columns:
            here = time(s, t, option)
            line.append(f"{num(here)} ({num(here / time(s, t, 'all'), 2)})")
        lines.append(line)
    receptors = sorted(
        {
            (s[2] == 1, max(number(r["receptors"]) for r in found if shape(r) == s and r["receptors"]) / s[2])
            for s, _ in columns
        }
    )
    text = " and ".join(f"{n:.0f} in the one skin" if single else f"{n:.0f} in each pad" for single, n in receptors)
    return f"""
## What each option saves

Microseconds per frame; in brackets the ratio to the first line. Sites: {text}.

{table(['what is asked for', *(title(s, t) for s, t in columns)], lines)}"""


def places(rows):
    """Lines of the chart of cells: name, cells and ns of each size, CPU threads first."""
    found = sorted(of(rows, "cells"), key=lambda r: r["cells"])
    lines = {}
    for r in sorted(found, key=lambda r: (on_vulkan(r), int(r["threads"] or 0))):
        name = r["device"] if on_vulkan(r) else plural(r["threads"])
        lines.setdefault(name, ([], []))
        lines[name][0].append(r["cells"])
        lines[name][1].append(r["least_ns"])
    return lines


def crossings(rows):
    """For each device the cells from which on it is faster than every number of threads; None where it never is."""
    lines, found = places(rows), {}
    cpu = [line for name, line in lines.items() if "thread" in name]
    for name, (cells, ns) in lines.items():
        if "thread" in name or not cpu:
            continue
        log = [
            math.log(min(line[1][i] for line in cpu) / ns[i]) for i in range(len(cells))
        ]  # > 0: the device is faster
        found[name] = None
        for i in range(len(log) - 1, -1, -1):
            if log[i] <= 0:
                if i + 1 < len(log):
                    part = log[i] / (log[i] - log[i + 1])
                    found[name] = math.exp(math.log(cells[i]) + part * (math.log(cells[i + 1]) - math.log(cells[i])))
                break
        else:
            found[name] = cells[0]
    return found


def cells(rows):
    lines = places(rows)
    if not lines:
        return ""
    sentences = [
        (
            f"{name} is faster than the CPU path from some {cells:.2g} cells on."
            if cells
            else f"{name} is faster than the CPU path at no size."
        )
        for name, cells in crossings(rows).items()
    ] or ["No Vulkan device was at hand."]
    sizes = sorted({c for line in lines.values() for c in line[0]})
    body = [
        [
            f"{round(math.sqrt(c))} x {round(math.sqrt(c))}",
            *(num(dict(zip(*line)).get(c, math.nan)) for line in lines.values()),
        ]
        for c in sizes
    ]
    return f"""
## From which size on a device pays

![nanoseconds per cell and press by the number of cells: threads, devices, other programs and the memory alone](devices.png)

One skin in f32, from the caller's pressure to responses that the caller can read; ns per cell and press (least of the
rounds). {' '.join(sentences)}

{table(['cells', *lines], body)}"""


KINDS = (
    ("uniform", "one material"),
    ("patches-4", "four materials in patches"),
    ("random-4", "four materials at random from cell to cell"),
    ("random-1000", "a thousand materials at random from cell to cell"),
    ("width", "rows of {width}"),
    ("fourth-order", "the fourth-order stencil"),
    ("published", "the published study's stencil"),
    ("elements-1", "one element"),
    ("elements-2", "two elements in series"),
    ("elements-3", "three elements in series"),
)


def kinds(rows):
    found = of(rows, "kinds")
    lines, plain = [], {}
    for model, text in KINDS:
        for width in sorted({r["width"] for r in of(found, "kinds", model=model)}, key=number, reverse=True):
            here = [r for r in found if r["model"] == model and r["width"] == width]
            line = [text.format(width=width), f"{width} x {here[0]['height']}"]
            for t in threads_of(found):
                ns = one(here, "ns", threads=t)
                first = plain.setdefault((here[0]["height"], t), ns)
                line.append(f"{num(ns)} ({num(ns / first, 2)})")
            lines.append(line)
    if not found:
        return ""
    return f"""
## What each kind of skin costs

One skin in f32, from the caller's pressure to responses that can be read; ns per cell and press, in brackets the ratio
to the first skin of as many rows.

{table(["skin", "cells"] + [plural(t) for t in threads_of(found)], lines)}"""


def native_pads(rows):
    found = of(rows, "pads", model="native-bits")
    if not found:
        return ""
    threads = threads_of(found)
    lines = []
    for s in sorted({shape(r) for r in found}, key=lambda s: (s[0] * s[1], s[2])):
        line = [f"{s[2]} of {s[0]} x {s[1]}"]
        for t in threads:
            native, batch = (
                min(
                    (
                        r["ns"]
                        for r in of(rows, "pads", model=m, precision="f32", threads=t)
                        if shape(r) == s and on_cpu(r)
                    ),
                    default=math.nan,
                )
                for m in ("native-bits", "batch")
            )
            line += [num(native), num(batch), num(batch / native, 2)]
        lines.append(line)
    head = ["pads"] + [f"{what}, {plural(t)}" for t in threads for what in ("own loop", "dermis", "ratio")]
    return f"""
## Pads beside a loop of their own

![ns per cell by the number of pads](pads.png)

The own loop (`native_pads_loops.cpp`) is written for one kind of pad alone and compiled for this processor. It
checks and copies its pressures as a `Skin` does, and has the same bits. ns per cell and press, f32:

{table(head, lines)}"""


def touched(rows):
    found = of(rows, "touch")
    if not found:
        return ""
    names = {
        "press-listed": "these pads alone, by their numbers",
        "touch-add": "their contacts added to a `Touch`",
        "press-all": "all pads, by their pressures",
        "touch-shear": "by the `Touch`, with shear",
    }
    threads = threads_of(found)
    columns = [(s, t) for s in sorted({shape(r)[2] for r in found}, reverse=True) for t in threads]
    lines = [
        [text]
        + [
            num(min((us(r) for r in of(found, "touch", model=m, threads=t) if shape(r)[2] == s), default=math.nan))
            for s, t in columns
        ]
        for m, text in names.items()
    ]
    head = ["us"] + [f"{s} pads, {plural(t)}" for s, t in columns]
    return f"""
## Contacts of a whole batch

Pads of 48 x 48 cells; of the greater number one pad in a hundred is touched, of the smaller number each one. A contact
is a patch with a radius of 2.4 cells on a round pad, added on one thread.

{table(head, lines)}"""


def bodies(rows):
    names = {
        "touch-press": "the press of these pads, four responses",
        "shape-ball": "pressure below a ball of 15 mm",
        "shape-bottle": "below a bottle, a cylinder of 15 mm",
        "shape-box": "below a box with two edges on the pad",
    }
    kinds = [k for k in ("bodies", "few-bodies") if of(rows, k)]
    if not kinds:
        return ""
    lines = []
    for model, text in names.items():
        line = [text]
        for kind in kinds:
            time, press = (min(us(r) for r in of(rows, kind, model=m)) for m in (model, "touch-press"))
            line += [num(time), num(time / press, 2)]
        lines.append(line)
    pads = shape(of(rows, kinds[0])[0])[2]
    head = ["us"] + [
        t for k in kinds for t in (f"{'all' if k == 'bodies' else 'one in a hundred'} of {pads} pads", "over the press")
    ]
    return f"""
## Bodies by their shapes

Flat pads of 16 x 16 cells, two contacts each, one thread: from forces and shapes to the pressure of each cell.

{table(head, lines)}"""


def batches(rows):
    names = {
        "batch": "a batch",
        "one-skin": "one skin with about as many cells",
        "skins": "as many skins, one by one",
        "at-rest": "a batch that is at rest without pressure",
        "batch-sites": "a batch with sites read in each pad",
    }
    found = [r for r in of(rows, "pads-batch") if r["model"] in names]
    count = next((shape(r) for r in found if r["model"] == "batch"), (0, 0, 0))
    receptors = next((number(r["receptors"]) / shape(r)[2] for r in found if r["model"] == "batch-sites"), math.nan)
    text = ""
    if found:
        names["batch-sites"] = f"a batch with {receptors:.0f} sites read in each pad"
        lines = [
            [
                text,
                num(one(found, "ns", model=m, backend=next((r["backend"] for r in found if on_cpu(r)), ""))),
                num(one(found, "ns", model=m, backend="vulkan")),
            ]
            for m, text in names.items()
        ]
        text += f"""
## Batches, sites and states

{count[2]} pads of {count[0]} x {count[1]} cells in f32, ns per cell and press:

{table(['', 'CPU path, 1 thread', driver(found)], lines)}"""
    sites = [r for r in of(rows, "pads-batch") if r["model"] in ("sites", "fields")]
    if sites:
        lines = []
        for i, r in enumerate(sites):
            if r["model"] == "sites":
                lines.append([f"{number(r['receptors']):.0f}", num(us(r)), num(us(sites[i + 1]))])
        text += f"""
{sites[0]['width']} x {sites[0]['height']} cells with sites, one thread, microseconds per press of the whole frame:

{table(['sites', 'read as sites', 'all cells as fields'], lines)}"""
    paced = {r["model"]: r for r in of(rows, "paced")}
    if paced:
        lines = [
            [name, f"{100 * number(paced[m]['of_limit']):.2f} %", num(paced[m]["seconds"] * 1e6)]
            for m, name in (
                ("sites", f"{number(paced['sites']['receptors']):.0f} sites"),
                ("fields", "fields"),
                ("empty", "an empty loop"),
            )
            if m in paced
        ]
        text += f"""
Presses at 1 kHz of the same skin:

{table(['', 'within a millisecond', 'median, us'], lines)}"""
    state = {r["model"]: r["seconds"] for r in of(rows, "state")}
    if state:
        text += f"""
Saving the state of 2000 pads takes {num(state['save'] / state['memcpy'], 2)} times as long as a `memcpy` of as many
bytes on one thread; loading it, with a check of every number, {num(state['load'] / state['memcpy'], 2)} times.
"""
    made = of(rows, "pads-made")
    if made:
        lines = [
            [
                {"batch": "4096 pads", "second-skin": "the second skin of a kind"}[m],
                num(1e3 * one([r for r in made if on_cpu(r)], model=m)),
                num(1e3 * one([r for r in made if on_vulkan(r)], model=m)),
            ]
            for m in ("batch", "second-skin")
        ]
        text += f"""
Making skins, in ms:

{table(['', 'CPU path', driver(made)], lines)}"""
    return text


def press(rows):
    found = of(rows, "press")
    if not found:
        return ""
    cores = rows[0]["cores"]
    sizes = sorted({r["width"] for r in found}, key=int)

    def best(n, backends, t):
        return min(
            (
                r["ns"]
                for r in found
                if r["width"] == n
                and r["backend"] in backends
                and r["status"] == "ok"
                and (t is None or r["threads"] == t)
            ),
            default=math.nan,
        )

    isas = [b for b in ("cpu-avx512", "cpu-avx2", "cpu-plain") if any(r["backend"] == b for r in found)]
    moves = ("cpu-moves", "cpu-moves-cached")
    columns = [(f"dermis, {plural(cores)}", isas[:1], cores), ("1 thread", isas[:1], "1")]
    columns += [(f"{isa[4:]}, {plural(cores)}", [isa], cores) for isa in isas[1:]]
    columns += [
        (f"limit, {plural(cores)}", moves, cores),
        ("limit, 1 thread", moves, "1"),
        (driver(found), ["vulkan"], None),
        ("its limit", ["vulkan-moves"], None),
    ]
    own = table(["N", *(c[0] for c in columns)], [[n, *(num(best(n, *c[1:])) for c in columns)] for n in sizes])
    peers = [
        ("dermis", isas[:1], cores),
        ("C++", ["native"], cores),
        ("dermis, 1 thread", isas[:1], "1"),
        ("C++, 1 thread", ["native"], "1"),
        *((PEER_NAMES[p], [p], None) for p in PEERS[1:]),
    ]
    beside = table(["N", *(c[0] for c in peers)], [[n, *(num(best(n, *c[1:])) for c in peers)] for n in sizes])
    ways = []
    for p in PEERS:
        for method in dict.fromkeys(r["method"] for r in found if r["backend"] == p and r["status"] == "ok"):
            t = "1" if p == "numpy" else cores
            ways.append(
                [
                    f"{PEER_NAMES[p]}, {method.replace('-', ' ')}",
                    *(num(one(found, "ns", backend=p, method=method, width=n, threads=t)) for n in sizes),
                ]
            )
    fewer = [
        [
            n,
            num(one(of(rows, "press-fa1"), "ns", width=n, threads="1")),
            num(one(of(rows, "press-fa1"), "ns", width=n, threads=cores)),
        ]
        for n in sizes
    ]
    error = max(
        (number(r[e]) for r in found for e in ("err_sa1", "err_sa2", "err_fa1", "err_fa2") if r[e]), default=math.nan
    )
    return f"""
## One press of one skin, beside its limits and other programs

One press of N x N cells: pressure in, strain and integral carried, four responses out: 44 bytes a cell. The
pressure is the library's own already, so that nothing is checked or copied (`SkinProgram` on a device; `Skin` adds
that). [devices.png](devices.png) draws it. ns per cell:

{own}
The limit is a loop that reads and writes the same maps and computes next to nothing, with as many threads, in the
same rounds; it stores the responses past the caches and through them, and the faster way counts. FA1 alone takes,
in ns per cell:

{table(['N', '1 thread', plural(cores)], fewer)}
Other programs on the same work, each in the best of its ways, on {plural(cores)} (NumPy on one). They need not keep
the library's bits. All are off by at most {num(error, 2)} of the greatest value, and so is the library. ns per
cell:

{beside}
{table(['way', *sizes], ways)}
- C++ (`native_loops.cpp`): compiled for this processor, with fused multiply-add, without a flush of small values or
  a check for values that are not finite. One fused loop, with responses past the caches or through them; or two
  plain loops.
- OpenCL (`press.cl`): 16 cells to a work-item, which computes the new strain of neighbouring cells again.
- Halide (`halide_frame.py`): strips of rows, the new strain in a sliding window or made for a whole strip. It has
  no stores past the caches.
- Numba (`numba_frame.py`): row ends taken out of the inner loops, `parallel`, `fastmath`. Two loops, or one in
  which rows roll.
- NumPy (`peers.py`): whole maps.
"""


def depths(rows):
    found, errors = of(rows, "depth"), of(rows, "depth-errors")
    if not found:
        return ""
    places = list(dict.fromkeys((r["device"], r["threads"]) for r in found))
    lines = []
    for s, model in dict.fromkeys((shape(r), r["model"]) for r in found if r["model"] != "surface"):
        line = [f"{f'{s[2]} of ' if s[2] > 1 else ''}{s[0]} x {s[1]}", model.replace("z/h=", "")]
        for device, threads in places:
            here = [r for r in found if shape(r) == s and (r["device"], r["threads"]) == (device, threads)]
            press = one(here, "ns", model="surface")
            ratio = min((number(r["ratio"]) for r in here if r["model"] == model), default=math.nan)
            more = (ratio - 1) / 4
            line += [num(press), f"{num(more * press)} ({num(more, 2)})"] if ratio == ratio else [DASH, DASH]
        lines.append(line)
    names = [plural(t) if device == "cpu" else device for device, t in places]
    head = ["cells", "z/h"] + [text for name in names for text in (f"{name}: a press", "a class more")]
    finger = [r for r in of(rows, "depth", model="fingertip") if shape(r) == (200, 200, 1) and on_cpu(r)]
    last = max(finger, key=lambda r: int(r["threads"]))
    ways = {
        "pyramid": "pyramid, stress",
        "pyramid-strain": "pyramid, strain",
        "fft-float": "FFT, float",
        "fft-long-double": "FFT, long double",
        "sums": "direct sums, double",
    }
    exact = [
        [text]
        + [
            " in ".join(f(r) for r in of(errors, "depth-errors", model=way, method=f"z/h={z}") for f in (
                lambda r: small(number(r["err_sa1"])), lambda r: num(r["ns"]) + " ns"))
            for z in (1, 6, 10, 22, 40)
        ]
        for way, text in ways.items()
    ]
    return f"""
## Receptors at depths

![error against cost of receptors at depths, by the way that takes them; the pyramid's error by the depth](depth.png)

A press in f32 of all four responses at the surface, ns per cell; and what each class adds whose receptors lie z
below cells that are h wide, in ns per cell and as a share of that press. Fingertip: SA1 at 0.3, FA1 at 0.5, SA2 at
1.1, FA2 at 2 mm, below cells of 0.05 mm, of 1 mm in pads of 16 x 16 and of 0.25 mm in a hand, 5 of 80 x 80. With
these depths a frame of 200 x 200 cells takes {num(us(last) / 1e3)} ms on {plural(last['threads'])}.

{table(head, lines)}
How far the spread of one pressed cell is off Love's sums, the sum over all cells at the worst place among the
pyramid's nodes; and ns per cell for a class of 200 x 200 cells on one thread. FFT: kissfft, two classes at a time.

{table(['way', *(f'z/h = {z}' for z in (1, 6, 10, 22, 40))], exact)}"""


def marches(rows):
    names = {
        "march-uniform": "uniform",
        "march-patches-4": "4 in patches",
        "march-random-4": "4 at random per cell",
        "march-random-1000": "1000 at random per cell",
        "march-each": "one per cell",
    }
    found = [r for r in rows if r["workload"] in names and not on_vulkan(r)]
    if not found:
        return ""
    lines = []
    for workload, text in names.items():
        here = of(found, workload)
        cpu = [r for r in here if on_cpu(r)]
        lines.append(
            [
                text,
                next((r["width"] for r in here), ""),
                num(one(cpu, "ns", precision="f32")),
                num(one(here, "ns", backend="native")),
                num(one(cpu, "ns", precision="f32-compensated")),
                num(one(cpu, "ns", precision="f64")),
            ]
        )
    return f"""
## Marches of traces

Means and extremes of strain and the four responses over all cells, at every step of a load that rises throughout;
{plural(rows[0]['cores'])}. ns per cell and step, with the time to make the maps. The C++ loop keeps a tile of the
skin in the cache over all steps; it fuses multiply-add, flushes nothing and adds in any order.

{table(['materials', 'N', 'f32', 'C++', 'f32 compensated', 'f64'], lines)}"""


def chains(rows):
    found = of(rows, "chains")
    if not found:
        return ""
    lines = []
    for method in dict.fromkeys(r["method"] for r in found):
        here = [r for r in found if r["method"] == method]
        line = [method[6:].replace("-spring", " and a spring"), here[0]["bytes_per_cell"]]
        for mine in (on_cpu, on_vulkan):
            ns, first = (
                min((r["ns"] for r in some if mine(r)), default=math.nan)
                for some in (here, of(found, "chains", method="exact-1"))
            )
            line += [num(ns), num(ns / first, 2)]
        lines.append(line)
    here = f"{plural(rows[0]['cores'])}: ns"
    head = ["elements", "bytes per cell", here, "times one", f"{driver(found)}: ns", "times one"]
    return f"""
## Elements in series

![one retardation time, and a measured spectrum of them, under one press](spectrum.png)

Skin relaxes within milliseconds and over seconds; elements in series do the same, exactly at any step. One press of
{found[0]['width']} x {found[0]['width']} cells:

{table(head, lines)}"""


def stiff(rows, step_of):
    found = of(rows, "stiff")
    if not found:
        return ""
    methods = {
        "exact": "exact",
        "euler": "forward Euler",
        "rk2": "RK2",
        "rk4": "RK4",
        "backward-euler": "backward Euler",
        "crank-nicolson": "Crank-Nicolson",
        "sdirk2": "SDIRK2",
    }
    steps = sorted({round(step_of(r), 6) for r in found if r["model"] == "sites"})
    lines = []
    for step in steps:
        line = [num(step)]
        for m in methods:
            r = next((r for r in found if r["method"] == m and round(step_of(r), 6) == step), None)
            line.append(
                DASH
                if not r
                else (
                    "refused"
                    if r["status"] == "unstable"
                    else f"{small(number(r['err_strain']))}, {small(number(r['err_fa1']))}"
                )
            )
        exact = next((r for r in found if r["method"] == "exact" and round(step_of(r), 6) == step), None)
        lines.append(line + [num(exact["cost"]) if exact else DASH])
    same = next((r["least"] for r in found if r["method"] == "exact" and abs(step_of(r) - 10) < 1e-6), math.nan)

    def solvers(workload, against):
        lines = []
        for r in of(rows, workload):
            if r["status"] != "not installed" and r["model"] != "sites":
                name = {
                    "sine": "exact, the load a sine",
                    "frames-linear": f"exact, frames every {step_of(r):.3g} ms, linear between them",
                    "frames-parabolic": f"exact, frames every {step_of(r):.3g} ms, parabolas through them",
                }.get(r["model"], f"{r['backend'].upper()}, {r['method'].replace('rtol=', 'tolerance ')}")
                lines.append(
                    [
                        name,
                        f"{small(number(r['err_strain']))}",
                        f"{small(number(r['err_fa1']))}",
                        num(r["least"] * 1e3),
                        num(r["least"] / against, 2),
                    ]
                )
        return lines

    smooth = next((r["least"] for r in of(rows, "smooth", model="sine")), math.nan)
    return f"""
## A stiff chain

![error against time on a stiff chain, under a held load and a sine, beside solvers that choose their steps](stiff.png)

[stability.png](stability.png) has the error against the step.

Three elements in series, of 4 ms, 70 ms and 1.4 s, under a load that is held from time 0 for 2.56 s; 16 x 16 cells,
each with a site of the strain and one of its rate, double, one thread. Errors of strain and FA1: the greatest
over cells and outputs by the greatest value, against the closed form. Beyond its limit an explicit method is
refused.

{table(['step, ms', *methods.values(), 'exact: ns per cell and simulated second'], lines)}
Solvers that choose their own steps have all elements of all cells as one system with a diagonal Jacobian, and an
output every 10 ms. CVODE (`cvode.cpp`) is C, LSODA (SciPy, `peers.py`) is called from Python. The last column: by
the exact method's time for the same outputs.

{table(['solver', 'error of strain', 'error of FA1', 'ms', 'times exact'], solvers('stiff', same))}
The same chain under a sine of 5 Hz about a mean, a smooth load. A simulator knows it by frames alone; the solvers
are given the sine itself. Between frames the library takes the pressure as linear.

{table(['', 'error of strain', 'error of FA1', 'ms', 'times the exact sine'], solvers('smooth', smooth))}"""


def spikes(rows):
    found = of(rows, "spikes")
    if not found:
        return ""
    names = {"ouyang": "backward Euler filter, 1 ms, as Ouyang et al. have it", "integrate-and-fire": "leaky "
             "integrate-and-fire alone, 1 ms", "touchsim": "TouchSim's recursion, 0.2 ms"}
    lines = []
    for r in found:
        if r["status"] == "not installed":
            continue
        here = "lavapipe" if on_vulkan(r) else f"{r['threads']} thread{'s' if r['threads'] != '1' else ''}"
        here = driver(found) if on_vulkan(r) else here
        step = r["least"] / number(r["steps"]) * 1e3
        what = f"mean rate {r['method'][6:-2]} Hz" if r["model"] == "located" else names.get(r["method"], r["method"])
        who = {"numpy": "NumPy", "numba": "Numba"}.get(r["backend"], "dermis")
        lines.append([f"{who}: {what}", r["receptors"], here, num(step), num(step * 1e6 / number(r["receptors"]))])
    by_step = []
    for r in of(rows, "spikes-steps"):
        a_step = 1e9 * r["least"] / number(r["steps"]) / number(r["receptors"])
        by_step.append([num(1e3 * float(r["method"])), num(a_step), num(a_step / float(r["method"]))])
    return f"""
## Spikes

Afferents, nerve fibres of the skin, under strains that vibrate at 31 Hz, each with an amplitude and a phase of its
own, SA1, FA1 and FA2 as 4 to 5 to 1, in steps of 1 ms. A body has some 230,000 afferents of touch, a hand 17,000.
dermis locates each spike to a microsecond; the other methods, written anew, give the step or the sample in which a
spike falls, and lose or invent spikes. Their afferents are all of one kind.

![error of spike times, and spikes lost and invented, against cost, at steps of 0.1 to 10 ms](spikes.png)

{table(['', 'afferents', 'where', 'ms for a step of 1 ms', 'ns an afferent'], lines)}
Steps of other lengths, 17000 afferents at a mean rate of 10 Hz, one thread:

{table(['step, ms', 'ns an afferent and step', 'ns an afferent and second'], by_step)}"""


def less(rows):
    lines = []

    def add(what, mine, against, other):
        if mine == mine and other == other:
            lines.append([what, num(mine), against, num(other), num(other / mine)])

    study = of(rows, "study")
    moments = one(study, model="moments") / 9
    for against, model, scenes in (
        ("NumPy, every field kept as the study keeps it", "kept", 1),
        ("NumPy, step by step", "stepped", 1),
        ("marched in f32", "march", 9),
    ):
        row = next((r for r in study if r["model"] == model), None)
        if row and (number(row["steps"]) == 1000 or model == "march"):
            add(
                "a scene of the study, `moments`, maps in memory to traces in memory",
                moments,
                against,
                row["seconds"] / scenes,
            )
    held = of(rows, "held-map")
    for r in held:
        if r["model"] == "march" and on_cpu(r):
            add(
                f"{r['steps']} steps of a map whose strength alone changes, means, {r['width']} x {r['width']}, "
                "`moments`",
                one(held, model="moments", width=r["width"]),
                "marched in f32",
                r["seconds"],
            )
    a, b = one(of(rows, "materials-1")), one(of(rows, "materials-100"))
    for name, method in (("uniform", "exact"), ("four materials", "exact-materials")):
        here = of(rows, "population", method=method)
        if here:
            add(
                f"sites of a hand on {here[0]['width']} x {here[0]['width']} cells, {name}, `sites`, "
                f"{here[0]['steps']} steps",
                one(here, model="sites"),
                "the whole field in f32",
                one(here, model="march"),
            )
    for name, mine in (("CPU path", on_cpu), (driver(rows), on_vulkan)):
        here = [r for r in of(rows, "population-frames") if mine(r)]
        if here:
            add(
                f"the same frame by frame, {here[0]['width']} x {here[0]['width']}, {here[0]['steps']} frames, {name}",
                one(here, model="sites"),
                "the whole field",
                one(here, model="march"),
            )
    if not lines and a != a:
        return ""
    hundred = f"\nA hundred materials on one map take {num(b / a, 2)} times as long as one.\n" if a == a else ""
    return f"""
## Doing less

![what each simplification of a fingertip's scene saves, and costs in error](needs.png)
![what each tolerance takes](tolerance.png)

Where a load keeps its shape, or only sites are read, not every cell need be stepped; the planner takes what the
tolerance allows. Seconds:

{table(['what', 's', 'against', 's', 'times'], lines)}{hundred}"""


def accuracy(rows):
    found = of(rows, "accuracy")
    if not found:
        return ""
    lines = []
    for precision in ("f32", "f32-compensated", "f64"):
        exact = [
            r
            for r in found
            if r["method"] == "exact"
            and r["model"] == "march"
            and r["precision"] == precision
            and r["stencil"] == "five-point"
            and on_cpu(r)
        ]
        if exact:
            fewest, most = (f(exact, key=lambda r: number(r["steps"])) for f in (min, max))
            lines.append(
                [
                    f"exact, {precision}",
                    *(small(number(fewest[e])) for e in ("err_strain", "err_fa1")),
                    fewest["steps"],
                    *(small(number(most[e])) for e in ("err_strain", "err_fa1")),
                    most["steps"],
                ]
            )
    for method, name in (("rk4", "RK4, f64"), ("euler", "forward Euler, f64")):
        stable = [
            r for r in found if r["method"] == method and r["precision"] == "f64" and r["status"] == "ok" and on_cpu(r)
        ]
        if stable:
            most = max(stable, key=lambda r: number(r["steps"]))
            lines.append(
                [
                    name,
                    "refused",
                    "refused",
                    lines[0][3] if lines else "",
                    *(small(number(most[e])) for e in ("err_strain", "err_fa1")),
                    most["steps"],
                ]
            )
    stencils = " and ".join(
        f"{small(number(r['err_curvature']))} {r['stencil']}"
        for r in (next(iter(of(rows, "accuracy", stencil=s, method="exact")), None) for s in ("five-point", "fourth-order")) if r)
    return f"""
## Error against cost

![error against the time of a run: methods, precisions and models](work_precision.png)
![error against the number of steps, up to a million, in three precisions](long.png)

Greatest error over {found[0]['width']} x {found[0]['height']} cells and three instants by the greatest value,
against closed forms. The exact method's error is the rounding of its precision at every step; a smaller step only gives
more outputs. `moments` makes its maps, as every run does, and steps no cell: further steps cost numbers alone, whatever the
grid. The curvature, against the continuum, has the stencil's error: {stencils}.

{table(['method', 'strain, few steps', 'FA1', 'steps', 'strain, many steps', 'FA1', 'steps'], lines)}"""


def growth(rows):
    found = of(rows, "growth")
    if not found:
        return ""
    lines = [
        [f"{r['width']} x {r['height']}", num(r["ns"]), num(number(r["limit_GBs"]) * 1e3), num(number(r["of_limit"]))]
        for r in found
    ]
    names = {
        ("memory", "moments"): "moments",
        ("memory-fields", "maps"): "maps with two fields",
        ("memory-sites", "sites"): "sites",
        ("memory", "march"): "march",
        ("memory-each", "march"): "march, a material per cell",
    }
    for r in rows:
        if (r["workload"], r["model"]) in names:
            lines.append(
                [
                    f"{names[r['workload'], r['model']]} in {r['precision']}, {r['width']} x {r['height']}",
                    num(r["ns"]),
                    num(number(r["limit_GBs"]) * 1e3),
                    num(number(r["of_limit"])),
                ]
            )
    return f"""
## Growth and memory

A march of {found[0]['steps']} steps in f32, and other models, each in a process of its own. So short a run mostly
touches its memory for the first time. The peak is that of the whole process, by what `dermis plan` says; on small
grids the process itself counts.

{table(['', 'ns per cell and step', 'plan, MB', 'peak by plan'], lines)}"""


def processes(rows):
    names = {
        "process-help": "`dermis --help`",
        "process-smallest-cpu": "one cell, one output, `--device cpu`",
        "process-smallest-auto": "the same, `auto`",
        "process-smallest-vulkan": "the same, `vulkan`",
        "process-study-cpu": "a scene of the study, `cpu`",
        "process-study-auto": "the same, `auto`",
    }
    lines = [
        [text, num(1e3 * number(r["busy_least_s"])), num(1e3 * r["seconds"])]
        for workload, text in names.items()
        for r in of(rows, workload)
    ]
    made = of(rows, "construction")
    sizes = [r["width"] for r in made]
    construction = table(
        ["N", *sizes],
        [
            [text, *(num(one(of(rows, w), width=n)) for n in sizes)]
            for w, text in (("construction", "without noise"), ("construction-noise", "with noise"))
        ],
    )
    if not lines and not made:
        return ""
    return f"""
## Whole processes, and making a skin

The command from its start to its end with all files written, in ms: the least time of the processor, and the median
by the clock.

{table(['command', 'processor', 'clock'], lines)}
Seconds to make a `Skin` with wave ridges on the CPU path:

{construction}"""


def page(rows, step_of):
    """rows: as dermis-bench's table has them, as text, and seconds, least, ns, least_ns, cells and cost as numbers."""
    sections = (
        presses(rows),
        options(rows),
        kinds(rows),
        cells(rows),
        native_pads(rows),
        touched(rows),
        bodies(rows),
        batches(rows),
        press(rows),
        depths(rows),
        accuracy(rows),
        stiff(rows, step_of),
        spikes(rows),
        marches(rows),
        chains(rows),
        less(rows),
        growth(rows),
        processes(rows),
    )
    return header(rows) + "".join(sections)
