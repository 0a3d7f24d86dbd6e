# SPDX-License-Identifier: MIT
"""The same press on a skin of one retardation time, as the study's, and on a measured one: spectrum.py dermis picture.png"""
import sys
import tempfile
from pathlib import Path

import numpy as np

from drawing import BLUE, VERMILLION, key, plt, save, small
from runs import run, scene, traces

LASTING = 5e4  # Pa: stress over strain after a long hold, of both skins
TAU = 1 / 1.54  # s: the study's viscosity over its modulus
# Relaxations of 4 ms, 70 ms and 1.4 s beside a lasting part (the preset), and one element that creeps as far.
SKINS = {"measured: 4 ms, 70 ms, 1.4 s": ([], BLUE, "-"),
         "one element, 0.65 s": (["--set", f"material.modulus={LASTING}", "--set",
                                  f"material.viscosity={LASTING * TAU}", "--set", "receptors.fa2=step-mean"],
                                 VERMILLION, (0, (5, 2)))}
PANELS = [("strain", "strain (1)"), ("sa1", "SA1 (1)"), ("sa2", "SA2 (s)"), ("fa1", "FA1 (1/s)"),
          ("fa2", "FA2 (1/s²; linear within ±0.1)")]


def main(dermis, picture):
    figure, axes = plt.subplots(2, 3, figsize=(8, 4.6))
    for label, (settings, colour, line) in SKINS.items():
        with tempfile.TemporaryDirectory() as folder:
            t = traces(run(str(Path(dermis).resolve()), scene("spectrum"), folder, *settings))
        shown = t["time"] >= 0.001
        for axis, (quantity, _) in zip(axes.flat[1:], PANELS):
            axis.plot(t["time"][shown], t[f"{quantity}_probe0"][shown], color=colour, linestyle=line, label=label)
    pressure = axes.flat[0]
    time = np.geomspace(1e-3, 10, 400)
    pressure.plot(time, 2 * np.minimum(time / 0.005, 1), color="black")
    pressure.set_title("pressure (kPa)", fontsize=9)
    for axis, (quantity, title) in zip(axes.flat[1:], PANELS):
        axis.set_title(title, fontsize=9)
        if quantity in ("sa2", "fa1"):
            axis.set_yscale("log")
        if quantity == "fa2":
            axis.set_yscale("symlog", linthresh=0.1)
            axis.set_yticks([-1000, -10, -0.1, 0.1, 10, 1000])
    for axis in axes.flat:
        axis.set_xscale("log")
        axis.set_xlim(1e-3, 10)
    small(figure)
    for axis in axes[1]:
        axis.set_xlabel("seconds", fontsize=9)
    handles, labels = axes.flat[1].get_legend_handles_labels()
    key(figure, handles, labels, ncol=2)
    save(figure, picture)


if __name__ == "__main__":
    main(*sys.argv[1:])
