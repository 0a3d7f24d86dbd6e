# SPDX-License-Identifier: MIT
"""What acts below pressures on a half-space, and the pressures of some bodies, for the rows of EVIDENCE.md and keys.py."""
import tempfile

import numpy as np

from runs import run, scene


def below(dermis, pressure, spacing, depths, kernel="stress"):
    """What acts at each of some depths (m) below a map of pressures: a map each, from dermis."""
    height, width = pressure.shape
    poisson = "poisson = 0.4" if kernel == "strain" else ""
    with tempfile.TemporaryDirectory() as folder:
        sweep = ",".join(f"{{ sa1 = {depth} }}" for depth in depths)
        text = scene("half_space", width=width, height=height, spacing=spacing, kernel=kernel, poisson=poisson)
        out = run(dermis, text, folder, "--set", f"receptors.depth={sweep}", pressure=pressure)
        folders = [out / str(i + 1) for i in range(len(depths))] if len(depths) > 1 else [out]
        return [np.load(f / "sa1_t0.1.npy") for f in folders]


def rigid_bar(width, height, spacing, half):
    """The pressure under a rigid bar across a map, of mean 1: cells' means of 2/pi/sqrt(1 - (x/half)^2)."""
    edges = np.clip((np.arange(width + 1) - width / 2) * spacing / half, -1, 1)
    return np.diff(np.arcsin(edges)) * half / spacing * 2 / np.pi * np.ones((height, 1))


def flat_punch(width, height, spacing, radius, force):
    """The pressure (Pa) under a rigid flat punch at the cell (width/2, height/2): means of cells, by 40 lines."""
    lines = (np.arange(height * 40) + 0.5) / 40 - 0.5 - height // 2
    chord = np.sqrt(np.clip(radius**2 - (lines[:, None] * spacing) ** 2, 1e-30, None))
    edges = np.clip((np.arange(width + 1) - 0.5 - width // 2) * spacing / chord, -1, 1)
    inside = np.abs(lines[:, None]) * spacing < radius
    each = np.where(inside, np.diff(np.arcsin(edges), axis=1), 0) / (2 * np.pi * radius * spacing) * force
    return each.reshape(height, 40, width).mean(1)


def even_press(width, height, spacing, radius=1e-3, force=0.119047):
    """The force (N) of a flat punch that is pressed 1 mm into TouchSim's skin, as an even pressure (Pa)."""
    y, x = np.mgrid[0:height, 0:width]
    return (np.hypot(y - height // 2, x - width // 2) * spacing <= radius) * force / (np.pi * radius**2)
