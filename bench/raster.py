# SPDX-License-Identifier: MIT
"""What the afferents of a fingertip fire while a grating touches it, slides and lifts: raster.py dermis picture.png"""
import sys
import tempfile
from pathlib import Path

import numpy as np

from drawing import CLASSES, plt, save, small
from runs import run, scene, table

WIDTH, HEIGHT, SPACING, INTERVAL = 80, 80, 1e-4, 1e-3  # cells; m; s
PERIOD, SPEED, PRESSURE = 1.5e-3, 0.04, 2e4  # of the grating, m; m/s; Pa
TOUCH, SLIDE, STOP, LIFT, END = 0.1, 0.3, 0.8, 1.0, 1.2  # s
def frames():
    """A dome of pressure, over which the crests of a grating slide, and the mean pressure at each time."""
    time = np.arange(round(END / INTERVAL) + 1) * INTERVAL
    held = np.clip((time - TOUCH) / 0.05, 0, 1) * np.clip((LIFT + 0.05 - time) / 0.05, 0, 1)
    place = SPEED * np.clip(time - SLIDE, 0, STOP - SLIDE)
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH] * SPACING
    dome = np.clip(1 - np.hypot(x - x.mean(), y - y.mean()) ** 2 / 3e-3**2, 0, None)
    crests = 1 + np.cos(2 * np.pi * (x[None] - place[:, None, None]) / PERIOD)
    pressed = PRESSURE * held[:, None, None] * dome * crests
    return time, pressed, pressed.mean(axis=(1, 2))


def main(dermis, picture):
    time, pressed, mean = frames()
    text = scene("fingertip", width=WIDTH, height=HEIGHT, spacing=SPACING, interval=INTERVAL, end=END)
    with tempfile.TemporaryDirectory() as folder:
        out = run(dermis, text, folder, frames=pressed)
        spikes, fibres = np.load(out / "spikes.npy"), table(out / "afferents.csv")
    figure, axes = plt.subplots(3, 1, figsize=(8, 6), sharex=True, height_ratios=(1.2, 4, 2), constrained_layout=True)
    axes[0].plot(time, mean / 1e3, color="black", linewidth=1)
    axes[0].set_ylabel("pressure\n(kPa, mean)", fontsize=9)
    for label, at in (("touch", TOUCH), ("slide", SLIDE), ("stop", STOP), ("lift", LIFT)):
        axes[0].annotate(label, (at, mean.max() / 2e3), fontsize=8,
                         ha="right" if label in ("touch", "lift") else "left")
    edges = np.arange(0, END + 0.005, 0.01)
    for name in ("sa1", "fa1", "fa2"):
        numbers = [int(f["number"]) for f in fibres if f["class"] == name]
        of_class = spikes[np.isin(spikes["afferent"], numbers)]
        axes[1].scatter(of_class["time"], of_class["afferent"], s=1.5, color=CLASSES[name], linewidths=0,
                        label=f"{name.upper()}: {len(np.unique(of_class['afferent']))} of {len(numbers)} fire")
        axes[2].stairs(np.histogram(of_class["time"], edges)[0] / len(numbers) / 0.01, edges,
                       color=CLASSES[name])
    axes[1].set_ylabel("afferent", fontsize=9)
    axes[1].legend(fontsize=8, frameon=False, loc="lower left", bbox_to_anchor=(0, 1), ncol=3, markerscale=4, borderaxespad=0)
    axes[2].set_ylabel("mean rate (Hz)", fontsize=9)
    axes[2].set_xlabel("time (s)", fontsize=9)
    small(figure)
    save(figure, picture)


main(str(Path(sys.argv[1]).resolve()), sys.argv[2])
