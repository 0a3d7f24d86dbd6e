# SPDX-License-Identifier: MIT
"""Runs of dermis for the charts and the evidence: scenes, what a run leaves, and the spikes of afferents."""
import csv
import re
import subprocess
import tempfile
from pathlib import Path

import numpy as np

SCENES = dict(re.findall(r"^#: (\w+)\n(.*?)(?=^#: |\Z)", (Path(__file__).parent / "scenes.toml.in").read_text(), re.M | re.S))


def scene(name, **values):
    """A scene of scenes.toml.in."""
    return SCENES[name].format(**values)


def run(dermis, text, folder, *options, **files):
    """The folder of the results of a scene; files: arrays that it reads. What dermis says stops the script if it refuses
    the scene."""
    for name, values in files.items():
        np.save(f"{folder}/{name}.npy", values)
    Path(folder, "scene.toml").write_text(text)
    done = subprocess.run([dermis, "run", "scene.toml", "--out", "out", *options], cwd=folder, stdout=subprocess.DEVNULL,
                          stderr=subprocess.PIPE, text=True)
    if done.returncode:
        raise RuntimeError(f"{dermis} run ended with {done.returncode}: {done.stderr.strip()}")
    return Path(folder, "out")


def traces(out):
    """The columns of the traces by their names."""
    with open(out / "traces.csv") as file:
        names = file.readline().strip().split(",")
        columns = np.fromstring(file.read().replace("\n", ","), sep=",").reshape(-1, len(names)).T
    return dict(zip(names, columns))


def table(path):
    """The rows of a file, without its comments."""
    with open(path, newline="") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def afferents_of(out):
    """For each afferent its line of afferents.csv and its spikes (s)."""
    spikes = np.load(out / "spikes.npy")
    return [(row, spikes["time"][spikes["afferent"] == n]) for n, row in enumerate(table(out / "afferents.csv"))]


def fire(dermis, strains, load, duration, tables, interval=None, step=0.01):
    """The times (s) of the spikes of afferents that strains drive: each one a cell's value times the load's envelope.

    tables: the text of each [[afferents]] table and the numbers of its cells. Afferents are in the order of the tables.
    interval: if strains has a row of cells for each time, the s between them, and the step.
    """
    texts = ["[[afferents]]\n" + text + f"\ncells = {[[int(cell), 0] for cell in cells]}\n" for text, cells in tables]
    frames = np.atleast_2d(np.asarray(strains, float))[:, None, :]
    kind = 'kind = "file"' if interval is None else f'kind = "sequence"\ninterval = {float(interval)}'
    text = scene("row", width=frames.shape[2], load=f'{kind}\npath = "strains.npy"\n{load}', duration=float(duration),
                 step=float(interval or step), afferents="".join(texts))
    with tempfile.TemporaryDirectory() as folder:
        found = afferents_of(run(dermis, text, folder, strains=frames if interval else frames[0]))
    return [times for _, times in found]


def fitted(kind):
    """The numbers of bench/evidence/afferents.csv for a class: sa1, ra or pc."""
    rows = table(Path(__file__).parent / "evidence/afferents.csv")
    return {row["parameter"]: float(row["value"]) for row in rows if row["class"] == kind}


def afferent(kind):
    """The afferent of a class, by the members of AfferentModel."""
    v = fitted(kind)
    return {"time_constants": [v[f"time_constants[{i}]"] for i in range(2) if f"time_constants[{i}]" in v],
            **{key: v[key] for key in ("frequency", "quality", "value", "rate", "membrane_time", "refractory_time", "reset") if key in v},
            "gains": [[v.get(f"gains[{i}][{sign}]", 0.0) for sign in (0, 1)] for i in range(3)], "after": [(0, 1), (0, 1)]}
