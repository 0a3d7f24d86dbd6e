# SPDX-License-Identifier: MIT
"""TouchSim's SA1 and near-linear RA units as afferents of dermis, for the row units.

TouchSim (Saal, Delhaye, Rayhaun and Bensmaia, Proc. Natl. Acad. Sci. 114 (2017) E5693-E5702) moves each unit by a
recursion of 0.2 ms. units() says which continuous model that recursion stands for, recursion() is TouchSim's method,
written anew.
"""
import numpy as np

from rows import data
from runs import fire

STEP = 2e-4  # s, TouchSim's
MODULUS, POISSON = 0.05, 0.4  # TouchSim's skin, in N/mm2; its lengths are mm
DEPTH = {"SA1": 0.3, "RA": 1.6}  # mm
RADIUS = 5e-4  # m, of the probe
FINE = STEP / 20  # s, at which TouchSim's method is refined
BASIS = 190  # samples after a spike in which TouchSim's post-spike current is not zero
FIRST = 5e-3  # s after a spike: post-spike currents are fitted from here on, near the shortest intervals of the stimuli
RATIO = 1.25  # of the times of the two after-currents

TABLE = {(row["class"], int(row["number"])): tuple(float(x) for x in list(row.values())[2:]) for row in data("touchsim.csv")}


def strain_below(depth, radius):
    """1/m: the strain (Sneddon 1946: stress over modulus) at a depth (m) below a flat probe, over the probe's depth."""
    ratio = depth / radius
    return (1 + 3 * ratio**2) / (1 + ratio**2)**2 / (np.pi * radius * (1 - POISSON**2))


def strain_per_depth(name, radius):
    return strain_below(DEPTH[name[0]] * 1e-3, radius)


def rate_per_strain(name, radius):
    """TouchSim's dynamic input, E/(1 - nu^2)/z^2 times the probe's speed in mm/s, over the strain's rate in 1/s."""
    return MODULUS / (1 - POISSON**2) / DEPTH[name[0]]**2 * 1e3 / strain_per_depth(name, radius)


def basis(steps, center):
    """A raised cosine in the logarithm of the time after a spike: TouchSim's have centers 5 and 45 (0 and 40 steps)."""
    return 0.5 + 0.5 * np.cos(np.clip(1.5 * np.pi * np.log((steps + 5) / center) / np.log(9), -np.pi, np.pi))


def membrane_time(steps):
    """s: a held current moves V of tau*V' = I - V in a step as the recursion V - V/steps + I/steps does."""
    return -STEP / np.log1p(-1 / steps)


def butterworth(values, corner, step):
    """Samples after a low-pass of three poles, made discrete by the bilinear transform that keeps its corner (Hz)."""
    points, cosine = 2 * len(values), 1 / np.tan(np.pi * corner * step)
    back = np.exp(-2j * np.pi * np.arange(points // 2 + 1) / points)  # a delay of one sample
    s = cosine * (1 - back) / (1 + back + 1e-300)  # the frequency over the corner's
    return np.fft.irfft(np.fft.rfft(values, points) / ((s + 1) * (s * s + s + 1)), points)[:len(values)]


def per_part(y, gains):
    return gains[0] * np.maximum(y, 0) + gains[1] * np.maximum(-y, 0)


def recursion(name, depth, radius=RADIUS, step=STEP):
    """Spike times (s) TouchSim reports, without noise and delay, for a probe's depth (m) sampled at `step`.

    A step below 0.2 ms refines the method: the same filter, membrane and post-spike current at more samples.
    """
    corner, *gains, saturation, leak_steps, first, second, _ = TABLE[name]
    finer, strain = STEP / step, strain_per_depth(name, radius) * depth
    rate = np.gradient(strain, step)
    rate[0], rate[-1] = rate[1], rate[-2]
    stress = butterworth(MODULUS * strain, 10 * corner, step)
    rate = butterworth(rate_per_strain(name, radius) * rate, 10 * corner, step)
    change = np.append(np.diff(rate), 0) * finer
    current = per_part(stress, gains[0:2]) + per_part(rate, gains[2:4]) + per_part(change, gains[4:6])
    if saturation:
        current = saturation * current / (saturation + np.abs(current))
    leak = -np.expm1(-step / membrane_time(leak_steps))  # 1/leak_steps at TouchSim's step
    steps = np.arange(int(BASIS * finer)) / finer
    after = (first * basis(steps, 5) + second * basis(steps, 45)) * leak * leak_steps
    spikes, voltage, since = [], 0.0, len(after)
    for i, now in enumerate((current * leak * leak_steps).tolist()):
        voltage += now - voltage * leak
        if since < len(after):
            voltage += after[since]
            since += 1
        if voltage > 1 and since > 5 * finer:
            spikes.append(i + 1)
            voltage, since = 0.0, 0
    return np.array(spikes) * step


def answer(time, start, membrane, reset, after):
    """V of a reset and after-currents alone, `time` (s) after the spike; V is held for `start` seconds."""
    voltage = reset * np.exp(-(time - start) / membrane)
    for amplitude, decay in after:
        settled = np.exp(-time / decay) - np.exp(-start / decay - (time - start) / membrane)
        voltage = voltage + amplitude / (1 - membrane / decay) * settled
    return voltage


def fit_after(name):
    """Refractory time (s), reset and after-currents whose V after a spike is closest to TouchSim's from FIRST on.

    A crossing is on average half a step older than the sample that shows it, at which TouchSim starts anew: the model
    waits that half step. The error is weighted by 1/(1 - V), since a drive that fires the unit must be about 1 - V.
    """
    *_, leak_steps, first, second, _ = TABLE[name]
    membrane, steps, start = membrane_time(leak_steps), np.arange(2 * BASIS), STEP / 2
    current = first * basis(steps, 5) + second * basis(steps, 45)
    wanted, time = np.convolve(current, (1 - 1 / leak_steps)**steps)[:len(steps)], (steps + 1.5) * STEP
    time, wanted = time[time > FIRST], wanted[time > FIRST]
    weight = 1 / (1 - wanted)
    bare = answer(time, start, membrane, 1, [])
    if abs(second) < 1e-4:  # basis 2 adds nothing
        return start, np.sum(weight**2 * bare * wanted) / np.sum(weight**2 * bare**2), [(0.0, 1.0), (0.0, 1.0)]

    def solve(decay):
        columns = [bare, *(answer(time, start, membrane, 0, [(1, d)]) for d in (decay, RATIO * decay))]
        matrix = np.array(columns).T * weight[:, None]
        numbers = np.linalg.lstsq(matrix, wanted * weight, rcond=None)[0]
        return numbers, np.sum((matrix @ numbers - wanted * weight)**2)

    decay = min(np.geomspace(1e-3, 2e-2, 1000), key=lambda d: solve(d)[1])
    reset, *amplitudes = solve(decay)[0]
    return start, reset, [(amplitudes[0], decay), (amplitudes[1], RATIO * decay)]


def units(radius=RADIUS):
    """Each unit's afferent model, q being the strain at the receptor. Gains of rates hold for this radius of the probe: the
    strain depends on it, TouchSim's dynamic input does not."""
    result = {}
    for name, (corner, *gains, _, leak_steps, _, _, _) in TABLE.items():
        start, reset, after = fit_after(name)
        rate = rate_per_strain(name, radius)
        scale = (leak_steps * MODULUS, leak_steps * rate, leak_steps * rate * STEP)
        result[name] = {
            "time_constants": [1 / (2 * np.pi * 10 * corner)], "frequency": 10 * corner, "quality": 1.0,
            "value": 1.0, "rate": 0.0,
            "gains": [[scale[j] * gains[2 * j], scale[j] * gains[2 * j + 1]] for j in range(3)],
            "membrane_time": membrane_time(leak_steps), "refractory_time": start, "reset": reset, "after": after,
        }
    return result


STIMULI = [("ramp", 0, a) for a in (0.5, 1.0)] + [
    ("sine", hz, a) for hz, amplitudes in ((10, (0.1, 0.25, 0.5)), (30, (0.05, 0.1, 0.25)), (50, (0.05, 0.1, 0.2)),
                                           (100, (0.02, 0.05, 0.1))) for a in amplitudes]  # Hz, mm


def probe(kind, hz, amplitude, dt):
    """m: the depth of the probe in samples: 1 s of a sine, or of a hold with ramps of 50 ms, between 50 ms of rest."""
    time = np.arange(round(1.1 / dt)) * dt - 0.05
    shape = np.sin(2 * np.pi * hz * time) if kind == "sine" else np.clip(np.minimum(time, 1 - time) / 0.05, 0, 1)
    return np.where((time >= 0) & (time <= 1), amplitude * 1e-3 * shape, 0)


def within(spikes, others, tolerance=0.25e-3):
    """The number of spikes that have one of the others within the tolerance (s)."""
    return sum(np.min(np.abs(others - s), initial=1) <= tolerance for s in spikes)


def published(step=STEP):
    """The spikes of TouchSim's method for each unit and stimulus: it reports one a step after the sample that shows it,
    and that step is taken off."""
    return {(name, s): recursion(name, probe(*s, step), step=step) - step for name in TABLE for s in STIMULI}


def keys(model):
    """A model as the text of a table of [[afferents]]."""
    after = ", ".join(f"{{ amplitude = {float(a)}, time = {float(t)} }}" for a, t in model["after"] if a)
    numbers = {key: np.array(value, float).tolist() for key, value in model.items() if key != "after"}
    return "\n".join([*(f"{key} = {value}" for key, value in numbers.items()), f"after = [{after}]"])


def spikes(dermis, models):
    """The spikes of dermis for each unit and stimulus: a run for each kind and frequency, a cell for each strain."""
    found = {}
    for kind, hz in dict.fromkeys((kind, hz) for kind, hz, _ in STIMULI):
        amplitudes = [a for k, f, a in STIMULI if (k, f) == (kind, hz)]
        strains = [strain_per_depth((c, 0), RADIUS) * a * 1e-3 for c in DEPTH for a in amplitudes]
        first = {c: i * len(amplitudes) for i, c in enumerate(DEPTH)}
        tables = [(keys(m), np.arange(len(amplitudes)) + first[name[0]]) for name, m in models.items()]
        load = 'envelope = "table"\ntimes = [0.05, 0.1, 1, 1.05]\nvalues = [0, 1, 1, 0]'
        if kind == "sine":
            load = (f'envelope = "sine"\nmean = 0\nfrequency = {hz}\nphase = {-2 * np.pi * hz * 0.05}\n'
                    "window = { start = 0.05, until = 1.05 }")
        times = fire(dermis, strains, load, 1.1, tables)
        found |= zip([(name, (kind, hz, a)) for name in models for a in amplitudes], times)
    return found
