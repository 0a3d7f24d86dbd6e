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
points = sorted(tuple(map(float, row)) for row in rows)
time, data, model = zip(*(p for p in points if p[0] > 0))  # the axis is logarithmic

figure, (curve, residual) = plt.subplots(2, 1, figsize=(6, 5), sharex=True, height_ratios=[3, 1], layout="constrained")
curve.plot(time, data, ".", color="#0072B2", label="data")
curve.plot(time, model, color="#D55E00", label="model")
curve.set(xscale="log", ylabel={"modulus": "modulus (Pa)", "compliance": "compliance (1/Pa)"}[names[1]])
curve.legend()
scale = max(map(abs, data)) if min(data) <= 0 else None
residual.plot(time, [100 * (m - d) / (scale or d) for d, m in zip(data, model)], ".", color="#0072B2")
residual.axhline(0, color="black", linewidth=0.8)
residual.set(xlabel="time (s)", ylabel="% of the greatest" if scale else "model - data (%)")
part = folder / f"fit.png.dermis-{os.getpid()}.part"
try:
    with open(part, "xb") as file:
        figure.savefig(file, format="png", dpi=120)
    part.rename(folder / "fit.png")
finally:
    part.unlink(missing_ok=True)
