# SPDX-License-Identifier: MIT
"""Draws fit.csv of a folder, data and fitted curve, into its fit.png."""
import csv
import os
import sys
from pathlib import Path

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt

folder = Path(sys.argv[1])
with open(folder / "fit.csv") as file:
    names, *rows = csv.reader(file)
rows = [dict(zip(names, map(float, row))) for row in rows]
data, history = names[-2], "strain" in names
if not history:  # the axis is logarithmic
    rows = sorted((row for row in rows if row["time"] > 0), key=lambda row: (row.get("curve"), row["time"]))
curves = {}
for row in rows:
    curves.setdefault(row.get("curve"), []).append(row)
least, most = min(row[data] for row in rows), max(abs(row[data]) for row in rows)
scale = most if least <= 0 else None

figure, (curve, residual) = plt.subplots(2, 1, figsize=(6, 5), sharex=True, height_ratios=[3, 1], layout="constrained")
label = {"modulus": "modulus (Pa)", "compliance": "compliance (1/Pa)", "stress": "stress (Pa)"}[data]
for i, points in enumerate(curves.values()):
    time, measured, model = ([row[name] for row in points] for name in ("time", data, "model"))
    curve.plot(time, measured, ".", color="#0072B2", label="data" if i == 0 else None)
    curve.plot(time, model, color="#D55E00", label="model" if i == 0 else None)
    residual.plot(time, [100 * (m - d) / (scale or d) for d, m in zip(measured, model)], ".", color="#0072B2")
curve.set(xscale="linear" if history else "log", ylabel=label)
curve.legend()
residual.axhline(0, color="black", linewidth=0.8)
residual.set(xlabel="time (s)", ylabel="% of the greatest" if scale else "model - data (%)")
part = folder / f"fit.png.dermis-{os.getpid()}.part"
try:
    with open(part, "xb") as file:
        figure.savefig(file, format="png", dpi=120)
    part.rename(folder / "fit.png")
finally:
    part.unlink(missing_ok=True)
