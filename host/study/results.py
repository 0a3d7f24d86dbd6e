# SPDX-License-Identifier: MIT
"""The folder of a study: runs scenes by the command dermis into it, and reads what they have written."""
import csv
import functools
import json
import os
import subprocess
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
SURFACES = ["flat", "wave", "spiral"]
LOADS = ["circular", "point", "linear"]
METHODS = ["published", "exact"]
RESPONSES = ["sa1", "sa2", "fa1", "fa2"]
SWEEPS = {"modulus": ["1", "1.25", "1.5", "1.75", "2"], "viscosity": ["0.1", "0.325", "0.55", "0.775", "1"]}
PROBES = [(75, 75), (85, 85), (60, 80), (37, 37), (112, 112)]  # as in scene.toml
# The study divides by the number of points inside its loop over them, so that point k ends with the weight 5^(k - 5).
PLOTTED_WEIGHTS = [5.0 ** (k - 5) for k in range(5)]


class Failed(Exception):
    pass


class Results:
    """Runs are known by their folder below `out`."""

    def __init__(self, dermis, out, resume):
        self.dermis, self.out, self.resume = dermis, out, ["--resume"] * resume
        self.traces = functools.cache(self._traces)

    def call(self, *words):
        try:
            return subprocess.run([self.dermis, *map(str, words)], capture_output=True, text=True)
        except OSError as error:
            raise Failed(f"{self.dermis} cannot be started ({error.strerror})") from None

    def run(self, folder, scene, settings, device="cpu", precision="f64", more=()):
        """Runs a scene and returns its folder. Status 1 without a message says that cells differ, as its summary does."""
        done = self.call("run", HERE / scene, "--out", self.out / folder, "--device", device, "--precision", precision, *more,
                         *self.resume, "--set", *settings)
        if done.returncode and (done.stderr or done.returncode != 1):
            raise Failed(f"{self.out / folder}: exit status {done.returncode}: {done.stderr}")
        return folder

    def run_map(self, key):
        """A spring of modulus 1, whose strain is the pressure, for a surface or a load, as surface.kind=wave."""
        fields = '[{at=0,what=["deformation","curvature"]},{at=1,what=["strain"]}]'
        self.run(f"maps/{key.partition('=')[2]}", "scene.toml",
                 [key, "material.modulus=1", "material.viscosity=0", "output.traces=[]", f"output.fields={fields}"])

    def _traces(self, run):
        """The columns of a run's traces.csv by their names."""
        with open(self.out / run / "traces.csv") as file:
            names = file.readline().strip().split(",")
            return dict(zip(names, np.loadtxt(file, delimiter=",", unpack=True)))

    def field(self, run, quantity, at="9.99"):
        return np.load(self.out / run / f"{quantity}_t{at}.npy")

    def surface(self, kind):
        return self.field(f"maps/{kind}", "deformation", "0")

    def pressure(self, load):
        return self.field(f"maps/{load}", "strain", "1")

    def summary(self, run):
        return json.loads((self.out / run / "summary.json").read_text())

    def table(self, name):
        """The rows of a table, as runs.csv, each by the names of its columns."""
        with open(self.out / name, newline="") as file:
            return list(csv.DictReader(file))

    def write(self, name, content):
        """Writes a file whole or not at all."""
        place = self.out / name
        place.parent.mkdir(parents=True, exist_ok=True)
        part = place.with_name(f"{place.name}.dermis-{os.getpid()}.part")
        try:
            part.write_bytes(content if isinstance(content, bytes) else content.encode())
            part.replace(place)
        finally:
            part.unlink(missing_ok=True)
