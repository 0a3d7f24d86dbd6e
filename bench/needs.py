# SPDX-License-Identifier: MIT
"""No more than a scene needs: what each simplification of a fingertip's scene saves, and what it costs in error.

    needs.py dermis [picture.png]

The fingertip preset under a ball that presses and swings at 5 Hz; receptors of three classes at their depths. Errors are the greatest
over receptors and times, every 10 ms, by the greatest response of the class, against closed forms (the model sites, in
double), which are off by less than 1e-14 themselves: no error is shown below their bound.
"""
import json
import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from drawing import BLUE, CLASSES, GREY, chart, figure, rule, save
from runs import scene, table

SIDE, STEP, DURATION, FREQUENCY = 200, 1e-3, 0.5, 5  # cells, s, s, Hz
EVERY = 1e-2  # s: the times that all runs have
QUANTITIES = ("sa1", "sa2", "fa1")
LOAD = f"""
kind = "file"
path = "pressure.npy"
envelope = "sine"
frequency = {FREQUENCY}
mean = 1
"""
FRAMES = 'kind = "sequence"\npath = "frames.npy"\ninterval = 1e-2\nhold = "{}"'
MARCH = {"model": "march", "precision": "f64"}
FULL = "everything: each cell in double, at its depth, every ms"
WAYS = {  # what is changed: the load and the step, if others, and settings
    "precision: compensated sums in float": ({}, {**MARCH, "precision": "f32-compensated"}),
    "precision: plain float": ({}, {**MARCH, "precision": "f32"}),
    "model: means and extremes by moments": ({}, {"model": "moments"}),
    "model: receptors alone, by sites": ({"traces": []}, {"model": "sites"}),
    "depth: all at the surface": ({}, {**MARCH, "receptors.depth": "{}"}),
    "step: 10 ms in place of 1": ({"step": 1e-2}, MARCH),
    "hold: a frame each 10 ms, lines between": ({"step": 1e-2, "load": FRAMES.format("linear")}, MARCH),
    "hold: a frame each 10 ms, parabolas": ({"step": 1e-2, "load": FRAMES.format("parabolic")}, MARCH),
    "material: one element of 70 ms": ({}, {**MARCH, "material.elements": "[{ modulus = 5e4, viscosity = 3.5e3 }]"}),
}


def run(dermis, folder, changes, settings):
    """The responses of the receptors at the times that all runs have, and milliseconds of the processor, the least of three."""
    values = {"load": LOAD, "step": STEP, "duration": DURATION, "traces": list(QUANTITIES), **changes}
    Path(folder, "scene.toml").write_text(scene("needs", **{**values, "traces": json.dumps(values["traces"])}))
    taken = []
    for _ in range(3):
        child = subprocess.Popen([dermis, "run", "scene.toml", "--out", "out", "--device", "cpu", "--set",
                                  *(f"{key}={value}" for key, value in settings.items())], cwd=folder,
                                 stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        said = child.stderr.read()
        _, status, used = os.wait4(child.pid, 0)
        if status:
            raise RuntimeError(f"{settings}: {said}")
        taken.append(1e3 * (used.ru_utime + used.ru_stime))
    return np.load(f"{folder}/out/responses.npy")[::round(EVERY / values["step"])], min(taken)


def known_to(folder):
    """The bound of a run's error."""
    return json.loads(Path(folder, "out/summary.json").read_text())["plan"]["predicted_error"]


def measured(dermis):
    """By way: milliseconds, and the error of each class."""
    dermis, found = str(Path(dermis).resolve()), {}
    with tempfile.TemporaryDirectory() as folder:
        away = np.hypot(*(np.mgrid[:SIDE, :SIDE] - SIDE / 2)) / 80
        pressure = 2e4 * np.sqrt(np.clip(1 - away**2, 0, None))  # Pa, as under a ball of 4 mm
        np.save(f"{folder}/pressure.npy", pressure)
        times = EVERY * np.arange(round(DURATION / EVERY) + 2)
        np.save(f"{folder}/frames.npy", (1 + np.sin(2 * np.pi * FREQUENCY * times))[:, None, None] * pressure)
        truth, _ = run(dermis, folder, {"traces": []}, {"model": "sites"})
        known = known_to(folder)
        kinds = np.array([row["type"] for row in table(f"{folder}/out/receptors.csv")])
        for way, (changes, settings) in {FULL: ({}, MARCH), **WAYS}.items():
            values, ms = run(dermis, folder, changes, settings)
            off = {kind: np.abs(values - truth)[:, kinds == kind].max() / np.abs(truth[:, kinds == kind]).max() for kind in QUANTITIES}
            found[way] = ms, {kind: max(float(error), known) for kind, error in off.items()}
    return found


def claims(found):
    (_, full), error = found[FULL], {way: list(of.values()) for way, (_, of) in found.items()}
    by = {key: [e for way, e in error.items() if way.startswith(key)] for key in (
        "precision", "model", "depth", "step", "hold", "material")}
    lines, parabolas = by["hold"]
    return {"depths of all cells cost 1e-6 to 1e-4": 1e-6 < max(full.values()) < 1e-4,
            "float in place of double costs 1e-6 more at most": all(
                abs(e - f) < 1e-6 for of in by["precision"] for e, f in zip(of, full.values())),
            "closed forms (moments, receptors alone) cost nothing above 1e-13": max(map(max, by["model"])) < 1e-13,
            "a step ten times as long costs nothing": max(by["step"][0]) < 1.001 * max(full.values()),
            "receptors at the surface are off by 5 to 30 % in each class": 0.05 < min(by["depth"][0]) and max(by["depth"][0]) < 0.3,
            "lines between frames of 10 ms are off by 3 to 20 % of FA1 and at most 0.3 % of SA1 and SA2":
            0.03 < lines[2] < 0.2 and max(lines[:2]) < 3e-3,
            "parabolas at least 3 times closer": all(3 * p < e for p, e in zip(parabolas, lines)),
            "one element in place of the spectrum is off by half or more in each class": min(by["material"][0]) > 0.5}


def draw(found, picture):
    drawn, ((cost, error),) = figure(1, 2, 5, "No more than a scene needs: what each simplification saves, and costs in error",
                                     sharey=True, width_ratios=(1, 1.5))
    full, _ = found[FULL]
    for y, (way, (ms, errors)) in enumerate(found.items()):
        cost.barh(y, ms, 0.62, color=BLUE if way != FULL else GREY)
        cost.text(ms, y, f" {ms:.0f} ms" if way == FULL else f" {100 * (ms / full - 1):+.0f} %", va="center", fontsize=9)
        for kind, value in errors.items():
            error.plot(value, y, "o", color=CLASSES[kind], alpha=0.8, markersize=7, label=kind.upper() if y == 0 else None)
    cost.set_yticks(range(len(found)), [way.replace(": each", ":\neach").replace("double, at", "double,\nat") for way in found], fontsize=9)
    cost.invert_yaxis()
    cost.set(xlabel="ms of the processor", xlim=(0, 1.25 * full))
    error.set(xscale="log", xlim=(1e-16, 10), xlabel="greatest error / greatest response")
    error.set_xticks(10.0 ** np.arange(-16, 1, 4))
    error.legend(frameon=False, fontsize=9.5, loc="lower left", bbox_to_anchor=(0, 0.02))
    rule(error, 1e-4, "tolerance", "top", across=True)
    save(drawn, picture, "a fingertip of 200 x 200 cells, 235 receptors, a load of 5 Hz for 0.5 s; whole commands; tolerance: the default")


if __name__ == "__main__":
    chart(measured, claims, draw)
