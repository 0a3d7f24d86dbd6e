# SPDX-License-Identifier: MIT
"""Pictures and tables of dermis-bench's results: report.py results.csv folder."""
import csv
import sys
from pathlib import Path

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

BLUE, VERMILLION, GREEN, ORANGE, PURPLE, SKY, YELLOW = "#0072B2", "#D55E00", "#009E73", "#E69F00", "#CC79A7", "#56B4E9", "#F0E442"
METHOD = {"euler": VERMILLION, "rk2": ORANGE, "rk4": PURPLE, "backward-euler": "grey", "crank-nicolson": SKY,
          "sdirk2": GREEN, "exact": BLUE}
QUANTITIES = {"err_strain": "strain", "err_sa1": "SA1", "err_sa2": "SA2", "err_fa1": "FA1", "err_fa2": "FA2",
              "err_curvature": "curvature (against the continuum)"}
SIMULATED_SECONDS = 2.56  # of the accuracy rows
FLOORS = {"float": 2.0**-24, "double": 2.0**-53}


def number(text):
    return float(text) if text else np.nan


def load(path):
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        row["cells"] = number(row["width"]) * number(row["height"])
        row["seconds"] = number(row["wall_median_s"])
        row["ns"] = row["seconds"] * 1e9 / (row["cells"] * max(number(row["steps"]), 1)) if row["width"] else np.nan
    return rows


def of(rows, workload, **more):
    return [r for r in rows if r["workload"] == workload and all(r[k] == v for k, v in more.items())]


def save(figure, folder, name):
    figure.tight_layout()
    figure.savefig(folder / f"{name}.png", dpi=110)
    plt.close(figure)


def device_of(row):
    return "vulkan" if row["backend"].startswith("vulkan") else "cpu"


def pareto(points):
    front, best = [], np.inf
    for error, time in sorted(points, key=lambda p: (p[1], p[0])):
        if error < best:
            front.append((error, time))
            best = error
    return np.array(front)


def work_precision(rows, folder):
    figure, axes = plt.subplots(2, 3, figsize=(15, 9.5))
    series = {}
    for r in of(rows, "accuracy"):
        series.setdefault((device_of(r), r["model"], r["method"], r["precision"], r["stencil"]), []).append(r)
    for axis, (error, title) in zip(axes.flat, QUANTITIES.items()):
        all_points = []
        for (device, model, method, precision, stencil), ladder in series.items():
            ladder = [r for r in ladder if r["status"] == "ok"]
            if not ladder or (stencil != "five-point" and error != "err_curvature"):
                continue
            x = [max(number(r[error]), 1e-17) for r in ladder]
            y = [r["seconds"] * 1e9 / r["cells"] / SIMULATED_SECONDS for r in ladder]
            all_points += list(zip(x, y))
            label = " ".join(filter(None, [method if model == "march" else model, {"f32-compensated": "f32 compensated"}.get(precision, precision),
                                           "Vulkan" if device == "vulkan" else "", "4th-order stencil" if stencil != "five-point" else ""]))
            axis.loglog(x, y, color="black" if model != "march" else METHOD[method],
                        linestyle={"f32": "-", "f64": ":", "f32-compensated": "--"}[precision],
                        marker="s" if device == "vulkan" else ("*" if model != "march" else "o"), markersize=7 if model != "march" else 3.5,
                        markerfacecolor="white" if stencil != "five-point" else None, linewidth=1, label=label)
        for name, floor in FLOORS.items():
            axis.axvline(floor, color="grey", linestyle=(0, (1, 2)), linewidth=1)
            axis.text(floor, 0.02, f" {name}", transform=axis.get_xaxis_transform(), color="grey", fontsize=8)
        front = pareto(all_points)
        axis.step(front[:, 0], front[:, 1], where="post", color="gold", linewidth=5, alpha=0.5, zorder=0, label="Pareto front")
        beyond = [r for r in of(rows, "accuracy") if r["status"] == "unstable" and (r["stencil"] == "five-point" or error == "err_curvature")]
        for method in dict.fromkeys(r["method"] for r in beyond):
            points = [r for r in beyond if r["method"] == method]
            axis.plot([min(max(number(r[error]), 1e-17), 1e3) for r in points], [r["seconds"] * 1e9 / r["cells"] / SIMULATED_SECONDS for r in points],
                      "x", color=METHOD[method], markersize=7, label=f"{method}, unstable: refused unless asked for")
        axis.invert_xaxis()
        axis.set(title=title, xlabel="greatest error / greatest value (better to the right)", ylabel="ns per cell and simulated second")
        axis.grid(alpha=0.25)
    handles, labels = axes.flat[5].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=6, fontsize=8)
    figure.tight_layout(rect=(0, 0.09, 1, 1))
    figure.savefig(folder / "work_precision.png", dpi=110)
    plt.close(figure)


def roofline(rows, folder):
    figure, axis = plt.subplots(figsize=(8, 5.5))
    limits = [r for r in of(rows, "limit") if r["model"] == "copy"]
    top = max(limits, key=lambda r: number(r["limit_GBs"]))
    intensity = np.geomspace(0.2, 10, 50)
    axis.loglog(intensity, intensity * number(top["limit_GBs"]), color="black", label=f"copy past the caches: {number(top['limit_GBs']):.0f} GB/s, {top['threads']} threads")
    colours = {"cpu-avx512": BLUE, "cpu-avx2": SKY, "cpu-plain": GREEN, "vulkan": VERMILLION, "vulkan-cell": ORANGE,
               "numpy": PURPLE, "numba": "grey"}
    for n, marker in (("512", "^"), ("2048", "o"), ("4096", "s")):
        for r in of(rows, "W1", width=n):
            if (r["backend"].startswith("cpu") and r["threads"] != top["threads"]) or r["backend"] == "vulkan-moves":
                continue
            rate = r["cells"] * number(r["steps"]) / r["seconds"] / 1e9
            axis.plot(62 / 44, rate * 62, marker, color=colours[r["backend"]], markersize=8, markerfacecolor="none",
                      label=r["backend"] if n == "2048" else None)
    axis.set(xlabel="flop per byte (of 44 bytes per cell and step)", ylabel="Gflop/s",
             title="W1, a streamed frame, under the memory's roof\n△ 512², ○ 2048², □ 4096²")
    axis.legend(fontsize=8)
    axis.grid(alpha=0.25, which="both")
    save(figure, folder, "roofline")


def scaling(rows, folder):
    figure, (cells, steps, threads) = plt.subplots(1, 3, figsize=(16, 4.8))
    growth = sorted(of(rows, "growth"), key=lambda r: r["cells"])
    cells.semilogx([r["cells"] for r in growth], [r["ns"] for r in growth], "o-", color=BLUE, label="march, means and extremes of all five")
    w1 = [r for r in of(rows, "W1") if r["backend"].startswith("cpu") and r["threads"] != "1"]
    for backend, colour in (("cpu-avx512", VERMILLION), ("cpu-avx2", SKY), ("cpu-plain", GREEN)):
        line = [r for r in w1 if r["backend"] == backend]
        if line:
            cells.plot([r["cells"] for r in line], [r["ns"] for r in line], "s--", color=colour, label=f"W1, {backend}")
    cells.set(xlabel="cells", ylabel="ns per cell and step", title="time grows with the cells alone", ylim=(0, None))
    cells.legend(fontsize=8)
    for r in of(rows, "W1"):
        if r["backend"].startswith("cpu"):
            threads.plot(int(r["threads"]), 1 / r["ns"], {"512": "^", "2048": "o", "4096": "s"}[r["width"]],
                         color={"cpu-avx512": VERMILLION, "cpu-avx2": SKY, "cpu-plain": GREEN}[r["backend"]], markerfacecolor="none")
    threads.set(xlabel="threads", xticks=sorted({int(r["threads"]) for r in of(rows, "W1") if r["backend"].startswith("cpu")}), ylabel="cells and steps per ns", title="W1 with threads (△ 512², ○ 2048², □ 4096²)", xlim=(0.5, None), ylim=(0, None))
    for precision, colour in (("f32", VERMILLION), ("f32-compensated", ORANGE), ("f64", BLUE)):
        ladder = [r for r in of(rows, "accuracy", method="exact", model="march", precision=precision, stencil="five-point") if device_of(r) == "cpu"]
        steps.loglog([number(r["steps"]) for r in ladder], [r["seconds"] for r in ladder], "o-", color=colour, label=precision)
    steps.set(xlabel="steps", ylabel="s", title=f"and with the steps alone (march, {int(ladder[0]['width'])}²)")
    steps.legend(fontsize=8)
    for axis in (cells, steps, threads):
        axis.grid(alpha=0.25)
    save(figure, folder, "scaling")


def devices(rows, folder):
    figure, axis = plt.subplots(figsize=(9, 4.8))
    order = ["cpu-avx512", "cpu-avx2", "cpu-plain", "numba", "numpy", "vulkan", "vulkan-cell", "vulkan-moves"]
    sizes = [n for n in ("512", "2048", "4096") if of(rows, "W1", width=n)]
    for i, backend in enumerate(order):
        for k, n in enumerate(sizes):
            found = sorted(of(rows, "W1", width=n, backend=backend), key=lambda r: r["ns"])
            if found:
                axis.barh(i + 0.25 * (k - 1), found[0]["ns"], 0.22, color=(SKY, BLUE, "black")[k], label=f"{n}²" if backend == order[0] or (i == 1 and not of(rows, "W1", backend=order[0])) else None)
    axis.set(yticks=range(len(order)), yticklabels=order, xscale="log", xlim=(0.5, 100), xlabel="ns per cell and step, W1 on all threads",
             title="CPU, Vulkan and peers on the same streamed frame")
    axis.invert_yaxis()
    axis.legend(fontsize=8)
    axis.grid(alpha=0.25, axis="x")
    save(figure, folder, "devices")


def table(rows):
    lines = ["| workload | backend | threads | cells | model | precision | median s | ns per cell and step | of the limit |",
             "|---|---|---|---|---|---|---|---|---|"]
    for r in rows:
        if r["workload"] in ("accuracy", "limit"):
            continue
        limit = f"{number(r['of_limit']):.2f} of {r['limit']} ({number(r['limit_GBs']):.1f} GB{'' if 'bytes' in r['limit'] else '/s'})" if r["of_limit"] else ""
        lines.append(f"| {r['workload']} | {r['backend']} | {r['threads']} | {r['width']} x {r['height']} | {r['model']} | {r['precision']} "
                     f"| {r['seconds']:.4g} | {r['ns']:.4g} | {limit} |")
    return "\n".join(lines) + "\n"


def main(path, folder):
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    rows = load(path)
    for picture in (work_precision, roofline, scaling, devices):
        picture(rows, folder)
    (folder / "table.md").write_text(table(rows))


main(*sys.argv[1:3])
