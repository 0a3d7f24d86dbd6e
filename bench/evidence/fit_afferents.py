# SPDX-License-Identifier: MIT
"""Fits the parameters of the afferents SA1, RA and PC to published thresholds, rates, shares that fire and areas.

    fit_afferents.py OUT [--only CLASS] [--quick]

OUT: a folder, in which afferents.csv is written. --only: the class that is fitted; the others keep the values of the
afferents.csv beside this file (the search draws random numbers, and versions of SciPy draw different ones). --quick: a short
search, to see that everything runs; its values are no result. Needs NumPy, SciPy and Numba.

Stimulus: the displacement d of a flat cylinder of 1 mm diameter, a sine whose amplitude is the greatest displacement
from its mean. Input q: the strain on the axis of the cylinder at the depth of the ending; q is 0 at the mean of the sine.

Threshold: the amplitude at which V of an afferent just reaches 1 once the response to the sine is periodic. A rate is
the mean of seven afferents whose gains have a log-normal distribution with the median 1; a share is that of the
distribution whose threshold is below the amplitude. The afferents of the thresholds may be more sensitive than the
median afferent, by one factor per class.

SA1 is fitted to 21 more rates, in a hold under spheres of different curvature at three forces. The strain is that of
Hertz's contact on the axis; the curvature of the finger, which adds to the sphere's, is fitted. Last, with all other
parameters held, the endings of SA1 and RA: their number and the radius of the disc in which they lie, by the areas of
ten receptive fields below a probe of 0.5 mm, of afferents with their gain times field_gain.
"""
import argparse
import csv
import pathlib
import sys
import time

import numba
import numpy as np
from scipy.optimize import differential_evolution, least_squares
from scipy.special import ndtr

import rows as evidence
from firing import NODES, RADIUS
from runs import fitted
from touchsim import POISSON, strain_below

STEP = 50e-6  # s, the longest step
MODULUS = 5e4  # Pa, under a sphere whose force is known, as in TouchSim
FIELD_PROBE = 0.25e-3  # m, the radius of the probe of the receptive fields
FIBRES = 300  # whose areas are averaged
FA1_FIELD_GAIN = 4.0  # with the median's gain 50 um fire no FA1 afferent
# Weights: what counts as an error of 1, of a threshold (dB), of a share of the afferents, and of a rate as a part of
# the greatest rate of the class. Digitized rates and shares are means of few afferents; thresholds are of several
# papers.
THRESHOLD_ERROR, SHARE_ERROR, RATE_ERROR = 1.5, 0.15, 0.05  # rates under spheres count as other rates do
MEMBRANE = ("membrane_time", "s", 1e-4, 50e-3)
REFRACTORY = ("refractory_time", "s", 0.9e-3, 20e-3)
SHARED = (("spread", "1", 0.03, 3.0), ("threshold_gain", "1", 0.1, 100.0))
NEGATIVE = "gain_negative/gain_positive"


class Model:
    """A class of afferents: its parameters, each with a name, a unit and bounds, and its linear part.

    order: 0 if the gains are of y, 1 if they are of y'. poles: an r for each real pole,
    a p for a pair that has a frequency and a quality. value: whether q drives the filter beside its rate, so that the class
    fires in a hold.
    """

    def __init__(self, name, *, depth, order, poles, value=False):
        self.name, self.order, self.poles, self.depth = name, order, poles, depth
        self.strain = strain_below(depth, RADIUS)  # of q, per m of d
        gain_unit = "s" if order else "1"
        rows = [("gain_positive", gain_unit, 1e-4, 100.0), (NEGATIVE, "1", 0.0, 1.0), MEMBRANE, REFRACTORY, *SHARED]
        rows += [(f"time_constant_{j + 1}", "s", 2e-5, 0.3) for j in range(poles.count("r"))]
        rows += [("frequency", "Hz", 30.0, 1500.0), ("quality", "1", 0.3, 10.0)] if "p" in poles else []
        rows += [("value", "1", 0.01, 1000.0), ("finger_curvature", "1/m", 10.0, 1000.0)] if value else []
        self.names, self.units = [r[0] for r in rows], dict(r[:2] for r in rows)
        # All parameters but the ratio of the gains, which may be 0, are fitted as decimal logarithms.
        self.log = np.array([n != NEGATIVE for n in self.names])
        self.bounds = np.array([[np.log10(x) if n != NEGATIVE else x for x in r[2:]] for n, r in zip(self.names, rows)])

    def values(self, x):
        return dict(zip(self.names, np.where(self.log, 10.0 ** np.array(x), x)))

    def transfer(self, v, f):
        """The drive y or y' per displacement in m of a sine of f Hz, as a complex number. The rate is 1 s."""
        s = 2j * np.pi * np.asarray(f, float)
        h = (v.get("value", 0.0) + s) * s**self.order * self.strain
        for j in range(self.poles.count("r")):
            h = h / (1 + s * v[f"time_constant_{j + 1}"])
        if "p" in self.poles:
            p = s / (2 * np.pi * v["frequency"])
            h = h / (1 + p / v["quality"] + p * p)
        return h


MODELS = (
    Model("SA1", depth=0.3e-3, order=0, poles="rr", value=True),
    Model("RA", depth=0.5e-3, order=0, poles="rr"),
    Model("PC", depth=2e-3, order=1, poles="rp"),
)


@numba.njit
def peak(wave, step, membrane):
    """The greatest V without spikes once V is periodic. wave: the current over one period, linear between samples."""
    x = step / membrane
    e = np.exp(-x)
    p = -np.expm1(-x) / x
    n = len(wave)
    v = 0.0
    for k in range(n):
        v = e * v + (p - e) * wave[k] + (1 - p) * wave[(k + 1) % n]
    v /= -np.expm1(-n * x)
    top = v
    for k in range(n):
        v = e * v + (p - e) * wave[k] + (1 - p) * wave[(k + 1) % n]
        top = max(top, v)
    return top


@numba.njit
def count(wave, scale, step, membrane, refractory, steps):
    """The spikes within a number of steps. wave: the current over one period, linear between its samples."""
    x = step / membrane
    e = np.exp(-x)
    p = -np.expm1(-x) / x
    a = scale * (p - e)
    b = scale * (1 - p)
    n = len(wave)
    spikes = 0
    v = 0.0
    k = 0
    while k < steps:
        j = k % n
        now = e * v + a * wave[j] + b * wave[(j + 1) % n]
        start = 0.0
        while now >= 1 and k < steps:  # from the spike to the end of the step in which the refractory time ends
            spikes += 1
            r = k + start + (1 - start) * (1 - v) / (now - v) + refractory / step
            k = int(r)
            start = r - k
            j = k % n
            first = wave[j] + (wave[(j + 1) % n] - wave[j]) * start
            y = (1 - start) * x
            q = -np.expm1(-y) / y if y > 1e-12 else 1.0
            v = 0.0
            now = scale * ((q - np.exp(-y)) * first + (1 - q) * wave[(j + 1) % n])
        v = now
        k += 1
    return spikes


def rectified(v, drive):
    return v["gain_positive"] * (np.maximum(drive, 0) + v[NEGATIVE] * np.maximum(-drive, 0))


def sine_current(model, v, f):
    """The current over one period of a sine of 1 m amplitude, and the step of its samples in s."""
    n = 2 * int(np.ceil(0.5 / f / STEP))
    drive = abs(model.transfer(v, f)) * np.sin(2 * np.pi * np.arange(n) / n)
    return rectified(v, drive), 1 / f / n


def thresholds(model, v, f):
    """The amplitudes (m) of sines at which an afferent of median gain just fires."""
    return np.array([1 / peak(*sine_current(model, v, g), v["membrane_time"]) for g in f])


def mean_rate(v, wave, step, amplitude, seconds):
    """The mean rate (Hz) of the seven afferents."""
    least = 1 / peak(wave, step, v["membrane_time"])
    scales = amplitude * np.exp(v["spread"] * NODES)
    steps = int(round(seconds / step))
    times = v["membrane_time"], v["refractory_time"]
    spikes = sum(count(wave, s, step, *times, steps) for s in scales if s >= least)
    return spikes / len(NODES) / (steps * step)


def sine_rates(model, v, data, seconds=1.0):
    currents = {f: sine_current(model, v, f) for f in np.unique(data[:, 0])}
    return np.array([mean_rate(v, *currents[f], a, seconds) for f, a, _ in data])


def load(model):
    """By kind of data its rows: thresholds (Hz, m), rates (Hz, m, Hz), shares (Hz, m, 1), spheres (N, 1/m, Hz), fields (m, m2)."""
    def numbers(name, *scale):
        found = [list(row.values()) for row in evidence.data(name + ".csv") if row.get("class", "sa1") == model.name.lower()]
        return np.array([row[-len(scale):] for row in found], float).reshape(-1, len(scale)) * scale

    return {"thresholds": numbers("thresholds", 1, 1e-6), "rates": numbers("rates", 1, 1e-6, 1), "shares": numbers("shares", 1, 1e-6, 1),
            "spheres": numbers("spheres", 1, 1, 1), "fields": numbers("fields", 1e-6, 1e-6)}


def sphere_rates(model, v, data):
    """The mean rates (Hz) of the seven afferents in a hold, on the axis of a sphere that a force presses."""
    force, curvature, _ = data.T
    radius, modulus = 1 / (curvature + v["finger_curvature"]), MODULUS / (1 - POISSON**2)
    contact = np.cbrt(0.75 * force * radius / modulus)
    strain = 1.5 * force / (np.pi * contact**2) / (1 + (model.depth / contact) ** 2) / MODULUS
    current = np.outer(strain, v["gain_positive"] * v["value"] * np.exp(v["spread"] * NODES))
    above = np.maximum(current, 1 + 1e-9)
    rate = 1 / (v["refractory_time"] + v["membrane_time"] * np.log(above / (above - 1)))
    return np.where(current > 1, rate, 0).mean(1)


def fractions(model, v, data):
    """The share of afferents that fire."""
    hz = np.unique(data[:, 0])
    least = dict(zip(hz, thresholds(model, v, hz)))
    return np.array([ndtr(np.log(a / least[f]) / v["spread"]) for f, a, _ in data])


def residuals(model, x, data, seconds=1.0):
    """Errors of the thresholds in dB, of the shares of afferents that fire, and of the rates in Hz, by their weights."""
    v = model.values(x)
    f, a = data["thresholds"].T
    rates = data["rates"][:, 2]
    scaled = [20 * np.log10(thresholds(model, v, f) / v["threshold_gain"] / a) / THRESHOLD_ERROR,
              (fractions(model, v, data["shares"]) - data["shares"][:, 2]) / SHARE_ERROR,
              (sine_rates(model, v, data["rates"], seconds) - rates) / (RATE_ERROR * rates.max())]
    if "value" in model.names:
        held = data["spheres"][:, 2]
        scaled.append((sphere_rates(model, v, data["spheres"]) - held) / (RATE_ERROR * held.max()))
    return np.concatenate(scaled)


def jacobian(model, x, data):
    """Central differences with a step of 0.02 (5 % of most parameters), since rates change in small jumps."""
    columns = []
    for j in range(len(x)):
        low, high = np.array(x), np.array(x)
        low[j] = max(x[j] - 0.02, model.bounds[j, 0])
        high[j] = min(x[j] + 0.02, model.bounds[j, 1])
        columns.append((residuals(model, high, data) - residuals(model, low, data)) / (high[j] - low[j]))
    return np.array(columns).T


def fit(model, data, quick):
    def cost(x):
        return (residuals(model, x, data, 0.5) ** 2).sum()

    effort = {"popsize": 4, "maxiter": 3} if quick else {"popsize": 12, "maxiter": 120}
    search = differential_evolution(cost, model.bounds, seed=1, tol=1e-5, polish=False, **effort)
    inside = np.clip(search.x, *(model.bounds.T + [[1e-9], [-1e-9]]))
    return least_squares(lambda x: residuals(model, x, data), inside, lambda x: jacobian(model, x, data), bounds=model.bounds.T,
                         xtol=1e-6, ftol=1e-6, max_nfev=3 if quick else 40).x


def stored(model):
    """The parameters in the afferents.csv beside this file, as fit() has them."""
    found = fitted(model.name.lower())
    positive, negative = (found[f"gains[{model.order}][{k}]"] for k in (0, 1))
    found |= {"gain_positive": positive, NEGATIVE: negative / positive}
    found |= {f"time_constant_{j + 1}": found.get(f"time_constants[{j}]") for j in (0, 1)}
    return np.array([np.log10(found[n]) if log else found[n] for n, log in zip(model.names, model.log)])


def uncertainty(model, x, data):
    """Standard errors of the values, and for each parameter what the data leave open."""
    at_bound = np.abs(np.array(x)[:, None] - model.bounds).min(1) < 1e-3
    free = np.flatnonzero(~at_bound)
    jac = jacobian(model, x, data)[:, free]
    r = residuals(model, x, data)
    covariance = np.linalg.pinv(jac.T @ jac) * (r @ r) / (len(r) - len(free))
    sigma = np.sqrt(np.diag(covariance))
    v = model.values(x)
    error, note = dict.fromkeys([*model.names, "negative"]), {n: [] for n in model.names}
    for i, j in enumerate(free):
        name = model.names[j]
        error[name] = sigma[i] * (np.log(10) * v[name] if model.log[j] else 1)
        if error[name] > 0.5 * v[name]:
            note[name].append("standard error above half the value")
        for i2, j2 in enumerate(free):
            c = covariance[i, i2] / sigma[i] / sigma[i2]
            if i2 != i and abs(c) > 0.95:
                note[name].append(f"correlation {c:.2f} with {model.names[j2]}")
    for j in np.flatnonzero(at_bound):
        note[model.names[j]].append("at a bound")
    pair = [model.names.index("gain_positive"), model.names.index(NEGATIVE)]
    if not at_bound[pair].any():  # the error of the product of both
        slope = v["gain_positive"] * np.array([np.log(10) * v[NEGATIVE], 1.0])
        at = np.searchsorted(free, pair)
        error["negative"] = np.sqrt(slope @ covariance[np.ix_(at, at)] @ slope)
    return error, {n: "; ".join(t) for n, t in note.items()}


def reach(model, v, depths, gain):
    """How far (m) from an ending a probe fires it that is pressed to depths (m) within 10 ms and held for 0.39 s."""
    n = int(round(1 / STEP))
    press = np.interp(np.arange(n) * STEP, (0, 0.01, 0.4, 0.41), (0, 1, 1, 0))
    drive = np.fft.irfft(np.fft.rfft(press) * model.transfer(v, np.fft.rfftfreq(n, STEP)), n) / model.strain
    least = 1 / (gain * peak(rectified(v, drive), STEP, v["membrane_time"]))  # the strain that just fires
    away = np.linspace(0, 8e-3, 1601)
    # A flat punch as 40 rings of equal force, each of 48 points: the stress below it, as sums over point loads.
    ring = FIELD_PROBE * np.sqrt(1 - ((np.arange(40) + 0.5) / 40) ** 2)
    angle = (np.arange(48) + 0.5) / 48 * 2 * np.pi
    x, y = np.outer(ring, np.cos(angle)).ravel(), np.outer(ring, np.sin(angle)).ravel()
    force = 2 * FIELD_PROBE / (1 - POISSON**2) / len(x)  # per depth and modulus
    distance = np.sqrt((away[:, None] - x) ** 2 + y**2 + model.depth**2)
    strain = (3 * force * model.depth**3 / (2 * np.pi * distance**5)).sum(1)
    return np.array([np.interp(-least, -strain * d, away) if strain[0] * d > least else 0.0 for d in depths])


def covered(most):
    """Areas within a distance of one of 1 to `most` endings in a disc of radius 1, the mean of FIBRES draws: a function
    of the number of endings and the distance."""
    random, cell = np.random.default_rng(1), 0.06
    x, y = (axis.ravel() for axis in np.meshgrid(*[np.arange(-3, 3, cell) + cell / 2] * 2))
    nearest, near = np.full((FIBRES, len(x)), np.inf), []
    for _ in range(most):
        r, angle = np.sqrt(random.uniform(size=(FIBRES, 1))), 2 * np.pi * random.uniform(size=(FIBRES, 1))
        nearest = np.minimum(nearest, np.hypot(x - r * np.cos(angle), y - r * np.sin(angle)))
        near.append(np.sort(nearest.ravel()))
    return lambda endings, distance: np.searchsorted(near[endings - 1], distance) * cell**2 / FIBRES


# The numbers of endings and the radii (m) of their discs among which is searched.
ENDINGS = {"SA1": (range(8, 11), np.arange(1.2, 1.55, 0.1) * 1e-3), "RA": (range(8, 18), np.arange(2.5, 3.05, 0.1) * 1e-3)}


def fit_endings(model, v, data, gain):
    """The rows of the file about endings, with the errors of the areas printed."""
    depths, wanted = data["fields"].T
    far, area, (counts, radii) = reach(model, v, depths, gain), covered(17), ENDINGS[model.name]

    def areas(pair):
        return np.maximum(pair[1] ** 2 * area(pair[0], far / pair[1]), 1e-9)

    def off(pair):
        return np.sqrt(np.mean(np.log(areas(pair) / wanted) ** 2))

    best = min(((n, r) for n in counts for r in radii), key=off)
    print(f"  fields (mm2): " + " ".join(f"{a * 1e6:.2f}" for a in areas(best)) + " of " +
          " ".join(f"{a * 1e6:.2f}" for a in wanted) + f"; rms of the logarithm {off(best):.3f}")
    notes = ["at a bound" if value in (values[0], values[-1]) else "" for value, values in zip(best, (counts, radii))]
    return [("endings", best[0], "1", None, notes[0]), ("radius", best[1], "m", None, notes[1]),
            ("field_gain", gain, "1", None, "set")]


def table(model, x, data):
    """The rows of the file for a class: the members of AfferentModel, then what describes the population."""
    v = model.values(x)
    error, note = uncertainty(model, x, data)
    positive, negative = f"gains[{model.order}][0]", f"gains[{model.order}][1]"
    times = sorted((n for n in model.names if n.startswith("time_constant")), key=lambda n: -v[n])
    labels = {NEGATIVE: f"{negative}/{positive}", "gain_positive": positive}
    labels.update((n, f"time_constants[{j}]") for j, n in enumerate(times))

    def row(member, name):
        text = note[name]
        for old, new in labels.items():
            text = text.replace(old, new)
        return member, v[name], model.units[name], error[name], text

    rows = [row(labels[n], n) for n in times] + [row(n, n) for n in ("frequency", "quality") if n in v]
    rows.append(row("value", "value") if "value" in v else ("value", 0.0, "1", None, "set"))
    rows += [("rate", 1.0, "s", None, "set"), row(positive, "gain_positive")]
    product = v["gain_positive"] * v[NEGATIVE]
    rows.append((negative, product, model.units["gain_positive"], error["negative"], row("", NEGATIVE)[-1]))
    rows += [row("membrane_time", "membrane_time"), row("refractory_time", "refractory_time")]
    rows += [("reset", 0.0, "1", None, "set"), row("spread", "spread"), row("threshold_gain", "threshold_gain")]
    return rows + ([row("finger_curvature", "finger_curvature")] if "value" in v else [])


def main(out, only, quick):
    start, lines = time.time(), []
    for model in MODELS:
        data = load(model)
        x = fit(model, data, quick) if only in (None, model.name.lower()) else stored(model)
        v, rows = model.values(x), table(model, x, data)
        if len(data["fields"]):
            rows += fit_endings(model, v, data, v["threshold_gain"] if model.name == "SA1" else FA1_FIELD_GAIN)
        for name, value, unit, error, note in rows:
            spread = f"{error:.2g}" if error else ""
            print(f"{model.name:4} {name:18} {value:9.4g} {unit:3} {spread and '+- ' + spread:12} {note}")
            lines.append((model.name.lower(), name, f"{value:.4g}", unit, spread, note))
        print(f"  {time.time() - start:.0f} s since the start", flush=True)
    with open(out / "afferents.csv", "w", newline="") as file:
        file.writelines(line for line in (evidence.HERE / "afferents.csv").open() if line.startswith("#"))
        csv.writer(file, lineterminator="\n").writerows([("class", "parameter", "value", "unit", "standard_error", "note"), *lines])


if __name__ == "__main__":
    options = argparse.ArgumentParser()
    options.add_argument("out", type=pathlib.Path)
    options.add_argument("--only", choices=[model.name.lower() for model in MODELS])
    options.add_argument("--quick", action="store_true")
    options = options.parse_args()
    if not options.out.is_dir():
        sys.exit(f"fit_afferents.py: {options.out} is not a folder")
    main(options.out, options.only, options.quick)
