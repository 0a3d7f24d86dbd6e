# SPDX-License-Identifier: MIT
"""What a step does to a stress that relaxes: the fingertip's material, held at a depth, by six methods and by dermis.

    held_depth.py dermis picture.png

The stress of the preset relaxes with 4, 70 and 1400 ms (host/core/description/fingertip.md). Each method steps its branches,
s' = -s/tau, from the stress at once. Prints the greatest error over 2 s by the stress at once, and draws it.
"""
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

TIMES = np.array([0.004, 0.07, 1.4])  # s; each branch has the modulus that is left in the end
STEPS = np.array([1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2, 2e-2, 5e-2, 0.1, 0.2, 0.5, 1.0])  # s
DURATION, SHOWN = 2.0, 0.02  # s; the step of the traces that are drawn
DIAGONAL = 1 - 1 / np.sqrt(2)  # of SDIRK2
METHODS = {  # the factor by which a step of z = dt/tau takes s' = -s/tau on, and a colour
    "Euler": (lambda z: 1 - z, "#E69F00"),
    "RK2": (lambda z: 1 - z + z**2 / 2, "#56B4E9"),
    "RK4": (lambda z: 1 - z + z**2 / 2 - z**3 / 6 + z**4 / 24, "#009E73"),
    "backward Euler": (lambda z: 1 / (1 + z), "#0072B2"),
    "Crank-Nicolson": (lambda z: (2 - z) / (2 + z), "#D55E00"),
    "SDIRK2": (lambda z: (1 - (1 - 2 * DIAGONAL) * z) / (1 + DIAGONAL * z) ** 2, "#CC79A7"),
}
SCENE = """
preset = "fingertip"
[grid]
width = 9
height = 9
spacing = "0.1 mm"
[surface]
kind = "flat"
[material]
curvature_length = 0
[load]
kind = "punch"
control = "depth"
radius = 3
intensity = "0.5 mm"
[receptors]
follow = {{ sa1 = "stress" }}
[time]
step = {step}
duration = {duration}
[output]
traces = ["strain", "sa1"]
probes = [[4, 4]]
"""


def exact(t):
    """The stress over the stress at once."""
    return (1 + np.exp(-np.outer(t, 1 / TIMES)).sum(1)) / 4


def stepped(factor, step, count):
    """The same after 0, 1 .. steps of a method, one after another."""
    branches, stress = np.ones(3), []
    for _ in range(count):
        stress.append((1 + branches.sum()) / 4)
        branches = branches * factor(step / TIMES)
    return np.array(stress)


def by_dermis(dermis, step):
    """Times, and the same at each output but the first, by the command."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "scene.toml").write_text(SCENE.format(step=step, duration=DURATION + step / 2))
        subprocess.run([dermis, "run", f"{folder}/scene.toml", "--out", f"{folder}/out"], check=True, stdout=subprocess.DEVNULL)
        rows = np.genfromtxt(f"{folder}/out/traces.csv", delimiter=",", names=True)[1:]
    return rows["time"], rows["sa1_probe0"] / rows["strain_probe0"] / 4


def errors(dermis):
    """By method, the greatest error at each step; "rings" by step: how often Crank-Nicolson's error changes its sign."""
    found: dict[str, list[float]] = {name: [] for name in (*METHODS, "dermis")}
    rings: list[int] = []
    for step in STEPS:
        t = step * np.arange(round(DURATION / step) + 1)
        with np.errstate(over="ignore", invalid="ignore"):
            for name, (factor, _) in METHODS.items():
                off = stepped(factor, step, len(t)) - exact(t)
                found[name].append(np.abs(off[1:]).max() if np.isfinite(off).all() else np.inf)
                if name == "Crank-Nicolson":
                    rings.append(int((np.diff(np.sign(off[1:])) != 0).sum()))
        times, stress = by_dermis(dermis, float(step))
        found["dermis"].append(np.abs(stress - exact(times)).max())
    return found, rings


def draw(found, picture):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from PIL import Image  # matplotlib's own requirement
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 3.6))
    for name, (factor, colour) in METHODS.items():
        left.loglog(STEPS * 1e3, np.minimum(found[name], 1e3), "o-", color=colour, label=name, markersize=3, linewidth=1.2)
        t = SHOWN * np.arange(16)
        right.plot(t, np.clip(stepped(factor, SHOWN, 16), -9, 9), "o-", color=colour, markersize=3, linewidth=1)
    left.loglog(STEPS * 1e3, found["dermis"], "ks-", label="dermis", markersize=3, linewidth=1.2)
    left.axvline(8, color="#888888", linestyle=":", linewidth=1)
    left.text(8.6, 1e-9, "2 τ of the\nfastest branch", fontsize=7, color="#555555")
    left.set(xlabel="step (ms)", ylim=(1e-17, 3e3))
    left.set_title("greatest error, by the stress at once\n(1000: beyond the chart)", fontsize=9)
    fine = np.linspace(0, 0.3, 600)
    right.plot(fine, exact(fine), color="black", linewidth=1.4)
    right.set(ylim=(0, 1.1), xlabel="time (s)")
    right.set_title("stress at a held depth, steps of 20 ms\n(black: the closed form)", fontsize=9)
    figure.legend(fontsize=8, frameon=False, ncol=7, loc="lower center")
    for axis in figure.axes:
        axis.tick_params(labelsize=8)
        axis.xaxis.label.set_fontsize(9)
        axis.grid(alpha=0.3)
    figure.tight_layout(rect=(0, 0.07, 1, 1))
    figure.canvas.draw()
    image = Image.fromarray(np.asarray(figure.canvas.buffer_rgba())[..., :3])
    image.quantize(256, Image.Quantize.MAXCOVERAGE).save(picture, optimize=True)


def main(dermis, picture):
    found, rings = errors(dermis)
    print("step (ms):", *(f"{1e3 * step:g}" for step in STEPS))
    for name, values in found.items():
        print(f"{name}:", *(f"{value:.2g}" for value in values))
    print("changes of sign of Crank-Nicolson's error:", *rings)
    draw(found, picture)


if __name__ == "__main__":
    main(*sys.argv[1:])
