# SPDX-License-Identifier: MIT
"""TouchSim's SA1 and near-linear RA units as afferents of dermis, and how well the spikes of both agree.

    touchsim.py dermis

TouchSim (Saal, Delhaye, Rayhaun and Bensmaia, Proc. Natl. Acad. Sci. 114 (2017) E5693-E5702) moves each unit by a
recursion of 0.2 ms. units() says which continuous model that recursion stands for, recursion() is TouchSim's method,
written anew, and the script prints for ramps and sines of one probe how far its spikes lie from those of the command.
"""
import sys
from pathlib import Path

import numpy as np

import evidence_row

STEP = 2e-4  # s, TouchSim's
MODULUS, POISSON = 0.05, 0.4  # TouchSim's skin, in N/mm2; its lengths are mm
DEPTH = {"SA1": 0.3, "RA": 1.6}  # mm
RADIUS = 5e-4  # m, of the probe
FINE = STEP / 20  # s, at which TouchSim's method is refined
BASIS = 190  # samples after a spike in which TouchSim's post-spike current is not zero
FIRST = 5e-3  # s after a spike: post-spike currents are fitted from here on, near the shortest intervals of the stimuli
RATIO = 1.25  # of the times of the two after-currents

# TouchSim's table of parameters (github.com/hsaal/touchsim, commit 4ec9f5c, touchsim/constants.py), without its noise:
# corner frequency (10 Hz), gains of the stress (> 0, < 0), of the rate (> 0, < 0) and of its change in a step (> 0,
# < 0), saturation (0: none), membrane time (steps), amplitudes of the two post-spike bases, delay (ms).
TABLE = {
    ("SA1", 0): (10.1317138671875, 0.4346477971850776, -0.3183095561981179, 0.005801812635149275,
                 -0.0039689636230468752, 0, 0, 0, 281.20660400390625, -0.2770230138813521, -7.37607479095459e-6,
                 4.911723506025806),
    ("SA1", 1): (10.23828125, 0.2412385912745362, 0.12073856448095693, 0.0013467991020565942, -0.0006571010044642857,
                 0, 0, 0, 249.483642578125, -0.0368194580078125, 0, 1.0726562500000014),
    ("SA1", 2): (8.773358270525932, 0.9886979737922287, 1.1086141173869393, 0.0034691394266628084, 0,
                 0, 0, 0, 168.93812130391598, -0.40451574325561523, -0.0015840381383895874, 1.0411652088165297),
    ("SA1", 3): (10.0927734375, 0.25340826489318846, -0.05668146275281015, 0.002346132550920759, -0.0018686104910714285,
                 0, 0, 0, 408.9072265625, -0.00714111328125, 0, 3.1351562500000014),
    ("RA", 0): (10.185546875, 0, 0, 0.3384958031063988, 0.2545269097222222, -11.344285955133929, 1.8030133928571428,
                279.794677734375, 20.396484375, -1.8815673828124986, -0.07879638671875, 6.2726806640625),
    ("RA", 1): (10.521484375, 0, 0, 0.22559820265997024, 0.24457978360615082, 0.07224339373102242, -0.5405718504844527,
                923.249755859375, 28.43115234375, -2.304882812499997, -0.0538330078125, 7.6164306640624986),
    ("RA", 4): (17.951171875, 0, 0, 0.3384958031063988, 0.2545269097222222, -9.469285955133929, 1.8030133928571428,
                279.794677734375, 19.943359375, -1.8034423828124986, -0.12567138671875, 5.7101806640625),
    ("RA", 6): (14.27734375, 0, 0, 0.26199840727306545, 0.1543594990079365, 0.12965029761904762, -2.2392113095238093,
                967.622802734375, 22.8720703125, -1.8538574218749986, -0.083160400390625, 6.2726806640625),
}


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


def fit_after(name, way):
    """Refractory time (s), reset and after-currents whose V after a spike is closest to TouchSim's from FIRST on.

    A crossing is on average half a step older than the sample that shows it, at which TouchSim starts anew: the model
    waits that half step. The error is weighted by 1/(1 - V), since a drive that fires the unit must be about 1 - V.
    Ways: "reset" (no after-currents), "difference" (of exponentials of equal amplitudes), "free", and "1 ms" (free
    amplitudes, and V held for five of TouchSim's steps, in which TouchSim's V moves although it cannot fire).
    """
    *_, leak_steps, first, second, _ = TABLE[name]
    membrane, steps = membrane_time(leak_steps), np.arange(2 * BASIS)
    current = first * basis(steps, 5) + second * basis(steps, 45)
    wanted = np.convolve(current, (1 - 1 / leak_steps)**steps)[:len(steps)]
    start, time = 1e-3 if way == "1 ms" else STEP / 2, (steps + 1.5) * STEP
    time, wanted = time[time > FIRST], wanted[time > FIRST]
    weight = 1 / (1 - wanted)
    if way == "reset" or abs(second) < 1e-4:  # basis 2 adds nothing
        bare = answer(time, start, membrane, 1, [])
        return start, np.sum(weight**2 * bare * wanted) / np.sum(weight**2 * bare**2), [(0.0, 1.0), (0.0, 1.0)]

    def solve(decay):
        columns = [answer(time, start, membrane, 1, [])]
        columns += [answer(time, start, membrane, 0, [(1, d)]) for d in (decay, RATIO * decay)]
        columns = [columns[0], columns[1] - columns[2]] if way == "difference" else columns
        matrix = np.array(columns).T * weight[:, None]
        numbers = np.linalg.lstsq(matrix, wanted * weight, rcond=None)[0]
        return numbers, np.sum((matrix @ numbers - wanted * weight)**2)

    decay = min(np.geomspace(1e-3, 2e-2, 1000), key=lambda d: solve(d)[1])
    numbers = solve(decay)[0]
    second_amplitude = -numbers[1] if way == "difference" else numbers[2]
    return start, numbers[0], [(numbers[1], decay), (second_amplitude, RATIO * decay)]


def units(way="free", radius=RADIUS):
    """Each unit's afferent model, q being the strain at the receptor, and its delay (s), which the model does not hold.

    Gains of rates hold for this radius of the probe: the strain depends on it, TouchSim's dynamic input does not.
    """
    result = {}
    for name, (corner, *gains, _, leak_steps, _, _, delay) in TABLE.items():
        start, reset, after = fit_after(name, way)
        rate = rate_per_strain(name, radius)
        scale = (leak_steps * MODULUS, leak_steps * rate, leak_steps * rate * STEP)
        model = {
            "time_constants": [1 / (2 * np.pi * 10 * corner)], "frequency": 10 * corner, "quality": 1.0,
            "value": 1.0, "rate": 0.0,
            "gains": [[scale[j] * gains[2 * j], scale[j] * gains[2 * j + 1]] for j in range(3)],
            "membrane_time": membrane_time(leak_steps), "refractory_time": start, "reset": reset, "after": after,
        }
        result[name] = {"model": model, "delay": delay * 1e-3}
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
        times = evidence_row.fire(dermis, strains, load, 1.1, tables)
        found |= zip([(name, (kind, hz, a)) for name in models for a in amplitudes], times)
    return found


def compared(wanted, found):
    """For each unit and stimulus: spikes of TouchSim, of dermis, within 0.25 ms; ms by which the first is later."""
    for key, times in wanted.items():
        late = found[key][0] - times[0] if len(found[key]) and len(times) else np.nan
        yield len(times), len(found[key]), within(times, found[key]), late * 1e3


def totals(wanted, found, kind):
    """Of a class: the share of TouchSim's spikes that are within 0.25 ms, how many first spikes are, of how many; the
    stimuli whose rates differ by up to 1 Hz, of how many; the greatest difference (Hz). A stimulus takes 1 s."""
    of_kind = {key: times for key, times in wanted.items() if key[0][0] == kind}
    counts, ours, close, late = np.array(list(compared(of_kind, found))).T
    away, late = np.abs(ours - counts), late[np.isfinite(late)]
    return (close.sum() / counts.sum(), int((np.abs(late) <= 0.25).sum()), len(late), int((away <= 1).sum()), len(away),
            int(away.max()))


def summary(title, wanted, found):
    print(title)
    for kind in DEPTH:
        share, first, of_first, rates, of_rates, away = totals(wanted, found, kind)
        print(f"    {kind}: {share:.0%} of the spikes and {first} of {of_first} first spikes within 0.25 ms, "
              f"{rates} of {of_rates} rates within 1 Hz, greatest difference {away} Hz")


def main(dermis):
    wanted = published()
    for way in ("reset", "1 ms", "difference", "free"):
        found = spikes(dermis, {name: unit["model"] for name, unit in units(way).items()})
        summary(f"dermis, after-currents by the way {way}", wanted, found)
    refined = published(step=FINE)
    summary("TouchSim's own method at 10 us", wanted, refined)
    print("unit   stimulus            TouchSim  dermis  within 0.25 ms  first late by  TouchSim, 10 us  within 0.25 ms")
    for (name, (kind, hz, amplitude)), (count, ours, close, late) in zip(wanted, compared(wanted, found)):
        key = name, (kind, hz, amplitude)
        same = within(wanted[key], refined[key])
        print(f"{name[0]:>3s} {name[1]}  {kind} {hz:3d} Hz {amplitude:4.2f} mm {count:8d} {ours:7d} {close:15d} "
              f"{late:11.3f} ms {len(refined[key]):16d} {same:15d}")


if __name__ == "__main__":
    main(str(Path(sys.argv[1]).resolve()))
