# SPDX-License-Identifier: MIT
"""Every regime in which a method fails, ours among them, on one page: stability.py dermis [picture.png]

Other methods are dermis's own baselines, run by the command, but for a held depth, where their steps are made here.
"""
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

import long
import runs
from drawing import BLUE, GREEN, METHODS, ORANGE, VERMILLION, chart, figure, logarithmic, plain, save

LADDER = 10 ** (np.arange(-15, 31) / 5)  # step over retardation time
LIMITS = {"euler": 2, "rk2": 2, "rk4": 2.7853}
RINGING = {"crank-nicolson": 20, "sdirk2": 8.24, "backward-euler": 8.24, "exact": 8.24}  # step over retardation time
STEPS = np.array([0.3125, 1.25, 5, 10, 20, 40, 80, 160, 320, 640]) * 1e-3  # s, on a chain and at a held depth
TIMES, MODULI = np.array([4e-3, 0.07, 1.4]), np.array([2e6, 1e6, 5e5])  # s, Pa: the chain's elements
DIAGONAL = 1 - 1 / np.sqrt(2)  # of SDIRK2
DECAYS = {  # what a step of z = step/tau leaves of s' = -s/tau
    "euler": lambda z: 1 - z, "rk4": lambda z: 1 - z + z**2 / 2 - z**3 / 6 + z**4 / 24, "backward-euler": lambda z: 1 / (1 + z),
    "crank-nicolson": lambda z: (2 - z) / (2 + z), "sdirk2": lambda z: (1 - (1 - 2 * DIAGONAL) * z) / (1 + DIAGONAL * z) ** 2}
WEAK = 10.0 ** -np.arange(0, 13, 3)  # Pa


def run(dermis, name, values, **files):
    """The columns of the traces of a scene by their names, and its fields."""
    with tempfile.TemporaryDirectory() as folder:
        out = runs.run(dermis, runs.scene(name, **values), folder, "--device", "cpu", **files)
        return runs.traces(out), {path.stem: np.load(path) for path in out.glob("*_t*.npy")}


def ladder(dermis):
    """By method the greatest error of a held load's strain within 3000 steps at each step of LADDER, and its first strains."""
    errors, courses, cells = {}, {}, [*LADDER, *RINGING.values(), 2.1]
    for method in ("euler", "rk2", "rk4", "backward-euler", "crank-nicolson", "sdirk2", "exact"):
        traces, _ = run(dermis, "ladder", dict(method=method, width=len(cells), probes=[[x, 0] for x in range(len(cells))]),
                        viscosity=1 / np.array([cells]))
        strains = np.array([traces[f"strain_probe{i}"] for i in range(len(cells))])
        with np.errstate(invalid="ignore"):
            off = np.abs(strains + np.expm1(-np.outer(cells, np.arange(strains.shape[1]))))
        errors[method] = np.nan_to_num(off.max(1)[:len(LADDER)], nan=np.inf)
        z = RINGING.get(method, 2.1)
        courses[method] = z, strains[cells.index(z)][:13]
    return errors, courses


def chain(dermis):
    """By method the greatest error of FA1 by its greatest value under a held load, on elements of 4 ms to 1.4 s, at each step."""
    def error(job):
        method, step = job
        elements = ", ".join(f"{{ modulus = {E}, viscosity = {E * tau} }}" for E, tau in zip(MODULI, TIMES))
        traces, _ = run(dermis, "chain", dict(method=method, elements=elements, step=step, duration=2.56 + step / 2))
        truth = 1e4 * (np.exp(-np.outer(traces["time"], 1 / TIMES)) / (MODULI * TIMES)).sum(1)
        off = np.abs(traces["fa1_mean"] - truth)[1:].max() / truth[1:].max()
        return off if np.isfinite(off) else np.inf
    methods = ("euler", "rk4", "backward-euler", "crank-nicolson", "sdirk2", "exact")
    jobs = [(method, step) for method in methods for step in STEPS]
    with ThreadPoolExecutor(2) as pool:
        found = list(pool.map(error, jobs))
    return {method: np.array(found[i * len(STEPS):(i + 1) * len(STEPS)]) for i, method in enumerate(methods)}


def held_depth(dermis):
    """By method the greatest error of the fingertip's stress at a held depth, by the stress at once, at each step."""
    found = {name: [] for name in (*DECAYS, "exact")}
    for step in STEPS:
        t = step * np.arange(round(2.0 / step) + 1)
        def stress(decay):
            return (1 + (decay[None, :] ** np.arange(len(t))[:, None]).sum(1)) / 4
        truth = (1 + np.exp(-np.outer(t, 1 / TIMES)).sum(1)) / 4
        with np.errstate(over="ignore", invalid="ignore"):
            for name, factor in DECAYS.items():
                off = np.abs(stress(factor(step / TIMES)) - truth)[1:].max()
                found[name].append(off if np.isfinite(off) else np.inf)
        traces, _ = run(dermis, "held_depth", dict(step=step, duration=2.0 + step / 2))
        stress_of = traces["sa1_probe0"][1:] / traces["strain_probe0"][1:] / 4
        found["exact"].append(np.abs(stress_of - (1 + np.exp(-np.outer(traces["time"][1:], 1 / TIMES)).sum(1)) / 4).max())
    return {name: np.array(errors) for name, errors in found.items()}


def jump(dermis):
    """The pressure between frames of 10 ms around a jump, by hold: times in ms, and pressures."""
    frames = np.array([0, 0, 0, 1, 1, 1, 1.0]).reshape(-1, 1, 1)
    found = {}
    for hold in ("linear", "parabolic"):
        load = f'kind = "sequence"\npath = "frames.npy"\ninterval = 1e-2\nhold = "{hold}"'
        traces, _ = run(dermis, "cell", dict(load=load, duration=0.06), frames=frames)
        found[hold] = traces["time"] * 1e3, traces["strain_probe0"]
    return found


def spline(dermis):
    """The pressure in a cell over which a texture of 0 and 1 slides: places in its numbers, and pressures."""
    texture = np.repeat(np.tile([0.0, 1.0], 4), 8)[None, :]
    load = 'radius = 1\nintensity = 1\n[load.texture]\npath = "texture.npy"\nvelocity = [-0.01, 0]'
    traces, _ = run(dermis, "cell", dict(load=load, duration=0.2), texture=texture)
    return traces["time"] * 100, traces["strain_probe0"]


def border(dermis):
    """By cells from the border the greatest error of a measured surface's curvature, by its greatest value."""
    n, cells = 64, 1e-4
    x = (np.arange(n) + 0.5) * cells
    k = 2 * np.pi / (20.3 * cells)
    surface = 1e-5 * np.sin(k * x[None] + 0.7) * np.sin(k * x[:, None] + 0.3)
    _, fields = run(dermis, "measured_surface", dict(width=n), surface=surface)
    off = np.abs(fields["curvature_t0"] + 2 * k * k * surface) / (2 * k * k * 1e-5)
    inner = np.minimum.reduce([*np.indices((n, n)), *(n - 1 - np.indices((n, n)))])
    return np.array([off[inner == i].max() for i in range(16)])


def weak(dermis):
    """By way the error of the stress below a weak pressure, 1.8 m beside one of 1 Pa and 2 mm deep, by that stress, at each of WEAK."""
    n, depth, strong, place, (at, share) = 2048, 2.0, 100, 1900, np.polynomial.legendre.leggauss(24)
    x = (np.arange(1 - n, n)[:, None] + at / 2) ** 2  # cells: of a point force over the area of each
    below = 3 * depth**3 / (2 * np.pi * (x[:, :, None] + (at / 2) ** 2 + depth**2) ** 2.5) @ (share / 2) @ (share / 2)
    scene = runs.scene("half_space", width=n, height=1, spacing=1e-3, kernel="stress", poisson=f"depth = {{ sa1 = {depth * 1e-3} }}")
    at_receptor = f'sites = [["sa1", {place}, 0]]\n' + scene.split("fields")[0].replace("duration = 0.1", "duration = 0.15").replace(
        'kind = "file"\npath = "pressure.npy"', 'kind = "sequence"\npath = "frames.npy"\ninterval = 0.1')
    found = {way: [] for way in ("sums", "ours", "double")}
    for pressure in WEAK:
        map = np.zeros((1, n))
        map[0, [strong, place]] = 1, pressure
        transformed = np.fft.rfft(map[0], 2 * n) * np.fft.rfft(np.roll(np.append(below, 0), 1 - n))
        with tempfile.TemporaryDirectory() as folder:
            sums = np.load(runs.run(dermis, at_receptor, folder, frames=np.array([map] * 3)) / "responses.npy")[-1, 0]
            ours = np.load(runs.run(dermis, scene, folder, pressure=map) / "sa1_t0.1.npy")[0, place]
        truth = below[n - 1] * pressure + below[n - 1 + place - strong]
        for way, value in zip(found, (sums, ours, np.fft.irfft(transformed)[place])):
            found[way].append(abs(value / truth - 1))
    return {way: np.array(errors) for way, errors in found.items()}


def measured(dermis):
    dermis = str(Path(dermis).resolve())
    return {"ladder": ladder(dermis), "chain": chain(dermis), "depth": held_depth(dermis), "jump": jump(dermis),
            "spline": spline(dermis), "border": border(dermis), "weak": weak(dermis), "long": long.measured(dermis)}


def claims(found):
    errors, courses = found["ladder"]
    at = {method: np.max(line[LADDER > limit]) for method, limit in LIMITS.items() for line in [errors[method]]}
    ring = courses["crank-nicolson"][1]
    pressure, place = found["jump"]["parabolic"][1], found["spline"][1]
    last = {key: line[-1] for key, line in found["long"].items()}
    return {"forward Euler, RK2 and RK4 grow without bound above 2, 2 and 2.785 retardation times": min(at.values()) > 1e3,
            "and are off by at most 1 below": all(np.max(errors[m][LADDER < limit]) <= 1 for m, limit in LIMITS.items()),
            "the exact step is off by at most 4e-16 from 0.001 to a million retardation times": errors["exact"].max() < 4e-16,
            "Crank-Nicolson rings at 20 retardation times: each step changes the error's sign": (np.diff(np.sign(ring[1:] - 1)) != 0).all(),
            "SDIRK2 overshoots by 21 %": abs(courses["sdirk2"][1].max() - 1.207) < 1e-3,
            "FA1 of Crank-Nicolson is off by 100 times and more at 640 ms, of backward Euler by twice": found["chain"]["crank-nicolson"][-1] > 100
            and 2 < found["chain"]["backward-euler"][-1] < 5,
            "the exact step by at most 1e-15": found["chain"]["exact"].max() < 1e-15,
            "at a held depth forward Euler and RK4 fail beyond 10 ms, Crank-Nicolson is off by 40 % at 640 ms": min(
                found["depth"][m][4] for m in ("euler", "rk4")) > 1e3 and 0.3 < found["depth"]["crank-nicolson"][-1] < 0.5,
            "dermis by at most 1e-13": found["depth"]["exact"].max() < 1e-13,
            "parabolas overshoot a jump by an eighth, lines do not": abs(pressure.max() - 1.125) < 1e-3
            and found["jump"]["linear"][1].max() <= 1,
            "a spline overshoots a texture's jump by 9 to 12 %": 0.09 < place.max() - 1 < 0.12 and -0.12 < place.min() < -0.09,
            "a measured surface's curvature is off by half or more at its border, by 0.1 % at most from the third cell on":
            found["border"][0] > 0.5 and found["border"][2:].max() < 1e-3,
            "at depth FFT is off by 1e-13 and more of the stress below a load a billion times as weak as another, in double by 1e-10":
            found["weak"]["ours"][3] > 1e-13 and found["weak"]["double"][3] > 1e-10,
            "and direct sums, at receptors under frames, by at most 1e-14": found["weak"]["sums"].max() < 1e-14,
            "a million steps in float are off by 0.3 % and more of FA1, with compensated sums by 1e-5 at most":
            last["fa1", "f32"] > 3e-3 and last["fa1", "f32-compensated"] < 1e-5}


def lines(axis, x, found, top):
    """Draws a line for each method; what lies above the top is drawn at its rim."""
    logarithmic(axis)
    for method, errors in found.items():
        colour = METHODS[method][1]
        shown = np.where(errors > 0, np.minimum(errors, top), np.nan)
        end = np.flatnonzero(errors > top)[0] + 1 if (errors > top).any() else len(x)
        axis.plot(x[:end], shown[:end], color=colour)
        if end < len(x) or shown[end - 1] == top:
            axis.plot(x[end - 1], top, "^", color=colour, clip_on=False)
    axis.set_ylim(1e-17, top)
    axis.set_yticks(10.0 ** np.arange(-16, np.log10(top) + 1, 4))


def inside(axis, *texts):
    """Writes words at places of the axes: x and y from 0 to 1, the words and their colour."""
    for x, y, words, colour in texts:
        axis.text(x, y, words, transform=axis.transAxes, color=colour, fontsize=9, va="top")


def draw(found, picture):
    drawn, axes = figure(5, 2, 16, "Where methods fail, ours among them, and what does not fail")
    (explicit, ringing), (stiff, depth), (million, frames), (texture, surface), (deep, none) = axes
    errors, courses = found["ladder"]
    colour = {method: METHODS[method][1] for method in METHODS}
    lines(explicit, LADDER, {m: errors[m] for m in ("euler", "rk2", "rk4", "backward-euler", "crank-nicolson", "exact")}, 1e4)
    explicit.set(title="Explicit steps explode beyond 2 to 2.8 τ:\nthey are refused", xlabel="step / retardation time τ", ylabel="error / strain")
    inside(explicit, (0.03, 0.99, "forward Euler", colour["euler"]), (0.03, 0.92, "RK2", colour["rk2"]), (0.03, 0.62, "RK4", colour["rk4"]),
           (0.62, 0.9, "Crank-Nicolson", colour["crank-nicolson"]), (0.5, 0.5, "backward Euler", colour["backward-euler"]),
           (0.2, 0.16, "dermis, exact", BLUE))
    for method in ("crank-nicolson", "sdirk2", "backward-euler", "exact"):
        z, course = courses[method]
        ringing.plot(course, "o-", color=colour[method])
    inside(ringing, (0.5, 0.99, "Crank-Nicolson, 20 τ", colour["crank-nicolson"]), (0.5, 0.92, "SDIRK2, 8.24 τ", colour["sdirk2"]),
           (0.5, 0.25, "backward Euler, 8.24 τ", colour["backward-euler"]), (0.5, 0.18, "dermis, exact, 8.24 τ", BLUE))
    ringing.set(title="Stable ones ring, overshoot or blur", xlabel="step", ylabel="strain / final strain", ylim=(0, 2.2))
    for axis, key, title, label in ((stiff, "chain", "A fast element, a long step: FA1 is lost\n(4 ms, 70 ms and 1.4 s; held load)", "error / greatest FA1"),
                                    (depth, "depth", "A held depth: the stress is lost", "error / stress at once")):
        lines(axis, STEPS * 1e3, found[key], 1e4)
        axis.set(title=title, xlabel="step (ms)", ylabel=label)
        axis.set_xticks((1, 10, 100), ("1", "10", "100"))
        inside(axis, *((0.6, 0.6 - 0.07 * i, METHODS[m][0], colour[m]) for i, m in enumerate(m for m in found[key] if m != "exact")),
               (0.03, 0.2, "dermis, exact", BLUE))
    logarithmic(million)
    for precision, shade in (("f32", VERMILLION), ("f32-compensated", GREEN), ("f64", BLUE)):
        million.plot(long.STEPS[long.SHOWN], found["long"]["fa1", precision], color=shade)
    million.set(title="A million steps: float stands still", xlabel="number of steps", ylabel="error / greatest FA1", ylim=(1e-17, 10))
    inside(million, (0.1, 0.72, "float", VERMILLION), (0.1, 0.5, "float, compensated sums: the default", GREEN), (0.1, 0.3, "double", BLUE))
    for hold, shade in (("linear", BLUE), ("parabolic", ORANGE)):
        frames.plot(*found["jump"][hold], color=shade)
    frames.plot(10 * np.arange(7), [0, 0, 0, 1, 1, 1, 1], "o", color="black")
    inside(frames, (0.53, 0.72, "•  frames", "black"), (0.53, 0.64, "lines: the default", BLUE), (0.53, 0.56, "parabolas: 12.5 % over", ORANGE))
    frames.set(title="Parabolas through frames overshoot a jump", xlabel="ms", ylabel="pressure / jump")
    texture.plot(*found["spline"], color=ORANGE)
    texture.plot(np.arange(24), np.repeat([0, 1, 0], 8), "o", color="black", markersize=3)
    texture.set(title="A spline overshoots a texture's jump by 11 %:\nsmooth it first", xlabel="place (numbers of the texture)", ylabel="pressure", xlim=(0, 20))
    surface.semilogy(found["border"], "o-", color=ORANGE)
    surface.set(title="A measured surface, wrong at its border:\nleave two cells out", xlabel="cells from the border",
                ylabel="error / greatest curvature")
    surface.yaxis.set_major_formatter(plain)
    surface.set_xticks(range(0, 16, 3))
    logarithmic(deep)
    for way, shade, words, y in (("double", ORANGE, "FFT in double (NumPy)", 0.98), ("ours", VERMILLION, "dermis, FFT in long double: maps", 0.91),
                                 ("sums", BLUE, "dermis, direct sums: receptors under frames", 0.07)):
        deep.plot(WEAK, np.maximum(found["weak"][way], 1e-17), "o-", color=shade)
        inside(deep, (0.03, y, words, shade))
    deep.set(title="A weak load beside a strong one, at a depth:\nFFT loses it", xlabel="weak / strong", ylabel="error / stress below the weak", ylim=(1e-17, 1e-2))
    deep.invert_xaxis()
    none.axis("off")
    save(drawn, picture)


if __name__ == "__main__":
    chart(measured, claims, draw)
