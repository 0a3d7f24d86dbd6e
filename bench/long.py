# SPDX-License-Identifier: MIT
"""What rounding makes of a long run: error by the number of steps, in three precisions. long.py dermis [picture.png]

One cell under a pressure that rises for a third of a million steps and is held, with a retardation time of 10,000 steps.
An error is the greatest one so far by the greatest value so far, against closed forms in long double.
"""
import tempfile
from pathlib import Path

import numpy as np

from drawing import PRECISIONS, chart, figure, logarithmic, named, rule, save
from runs import run, scene, traces

LONG = np.longdouble
MODULUS, TAU, INTENSITY, RISE, STEP, COUNT = 1.7, 100.0, 0.37, 3333.3, 0.01, 10**6  # Pa, s, Pa, s, s
SCENE = scene("long", modulus=MODULUS, viscosity=MODULUS * TAU, intensity=INTENSITY, rise=RISE, step=STEP, duration=STEP * COUNT)
QUANTITIES = {"strain": "strain", "fa1": "FA1", "sa2": "SA2"}
STEPS = np.unique(np.geomspace(1, COUNT - 1, 4000).astype(int))  # those that are looked at
SHOWN = np.searchsorted(STEPS, np.geomspace(100, COUNT - 1, 81).astype(int))


def tail(x, order):
    """The alternating series of e^-x from the power `order` on, over its sign: where x is small, its other form cancels."""
    series, term = np.zeros_like(x), np.ones_like(x)
    for k in range(1, order + 16):
        term = term * x / k
        series = series + (-1) ** (k + order) * term * (k >= order)
    closed = np.exp(-x)
    term = np.ones_like(x)
    for k in range(order):
        closed, term = closed - (-1) ** k * term, term * x / (k + 1)
    return np.where(x < 0.2, series, (-1) ** order * closed)


def exact(times):
    """Strain, its rate and its integral under the ramp: what its slope gives from its begin on, less from its end on."""
    tau, slope = LONG(MODULUS * TAU) / LONG(MODULUS), LONG(INTENSITY) / LONG(RISE) / LONG(MODULUS)
    ways = [np.maximum(times - begin, 0) / tau for begin in (LONG(0), LONG(RISE))]
    of = {name: slope * tau ** (order - 1) * (tail(ways[0], order) - tail(ways[1], order))
          for name, order in (("strain", 2), ("fa1", 1), ("sa2", 3))}
    return of


def measured(dermis):
    """By quantity and precision, the error after each number of steps of STEPS[SHOWN]."""
    dermis = str(Path(dermis).resolve())
    truth, found = exact(LONG(STEP) * STEPS), {}
    for precision in PRECISIONS:
        with tempfile.TemporaryDirectory() as folder:
            columns = traces(run(dermis, SCENE, folder, "--device", "cpu", "--precision", precision))
        for name in QUANTITIES:
            off = np.abs(columns[f"{name}_mean"][STEPS] - truth[name])
            worst, greatest = (np.maximum.accumulate(x) for x in (off, np.abs(truth[name])))
            found[name, precision] = (worst[SHOWN] / greatest[SHOWN]).astype(float)
    return found


def claims(found):
    last = {key: errors[-1] for key, errors in found.items()}
    early = {key: errors[0] for key, errors in found.items()}
    return {
        "after a million steps float has lost 2e-4 to 6e-4 of the strain": 2e-4 < last["strain", "f32"] < 6e-4,
        "and 0.3 to 3 % of FA1 and of SA2": all(3e-3 < last[name, "f32"] < 3e-2 for name in ("fa1", "sa2")),
        "after a hundred steps it was off by less than 1e-4": all(early[name, "f32"] < 1e-4 for name in QUANTITIES),
        "compensated sums keep strain and SA2 to 1e-6, FA1 to 1e-5": max(
            last["strain", "f32-compensated"], last["sa2", "f32-compensated"], last["fa1", "f32-compensated"] / 10) < 1e-6,
        "they cure float more than a thousand times": all(
            last[name, "f32"] > 1e3 * last[name, "f32-compensated"] for name in QUANTITIES),
        "double keeps all to 1e-13": all(last[name, "f64"] < 1e-13 for name in QUANTITIES)}


def draw(found, picture):
    drawn, axes = figure(1, 3, 4.3, "A million steps cost float 1 % of FA1, compensated sums a few millionths", sharey=True)
    for axis, (name, title) in zip(axes[0], QUANTITIES.items()):
        logarithmic(axis)
        ends = []
        for precision, (words, colour) in PRECISIONS.items():
            errors = found[name, precision]
            axis.plot(STEPS[SHOWN], np.maximum(errors, 1e-18), color=colour)
            ends.append((COUNT, errors[-1], f"{errors[-1]:.0e}".replace("e-0", "e-"), colour))
        rule(axis, 1e-4, "default tolerance" if name == "strain" else "", "left")
        axis.set(title=title, xlabel="number of steps", xlim=(100, 1e6), ylim=(1e-18, 1e-1))
        axis.set_xticks(10.0 ** np.arange(2, 7))
        named(axis, ends)
    for precision, height in (("f32", 3e-6), ("f32-compensated", 4e-9), ("f64", 1e-13)):
        words, colour = PRECISIONS[precision]
        axes[0, 0].text(1.3e2, height, words, color=colour, fontsize=10)
    axes[0, 0].set_ylabel("greatest error / greatest value")
    save(drawn, picture)


if __name__ == "__main__":
    chart(measured, claims, draw)
