# SPDX-License-Identifier: MIT
"""Workloads W1 and W3 in NumPy, Numba and Halide, as rows of dermis-bench's table: peers.py results.csv [--quick]."""
import csv
import statistics
import sys
import time

import numba
import numpy as np

try:
    from halide_frame import HalideFrame, version as halide_version
except ImportError:  # a row says so
    HalideFrame, halide_version = None, lambda: ""

DT, MODULUS, VISCOSITY = 0.01, 1.54, 1.0
QUICK = "--quick" in sys.argv
RUNS = 3 if QUICK else 5


def row_of_step():
    """Coefficients of one exact step under a pressure that runs straight from one frame to the next."""
    z = MODULUS * DT / VISCOSITY
    p1 = -np.expm1(-z) / z
    p2 = (1 - p1) / z
    p3 = (0.5 - p2) / z
    q = DT / VISCOSITY
    decay = np.exp(-z)
    return [np.float32(x) for x in (MODULUS, q * p1, q * p2, DT * p1, DT * q * p2, DT * q * p3,
                                    decay / VISCOSITY, q * p1 / DT, -MODULUS / VISCOSITY * decay / VISCOSITY,
                                    decay / VISCOSITY / DT)]


E, B, F, I0, I1, I2, V0, V1, A0, A1 = row_of_step()


class Frame:
    """W1: strain and integral carried, four responses written, float32."""

    def __init__(self, n):
        y, x = np.mgrid[0:n, 0:n].astype(np.float32)
        surface = np.pad(np.sin(0.3 * x) * np.cos(0.2 * y), 1, mode="edge")
        self.rest = (surface[1:-1, 2:] + surface[1:-1, :-2] + surface[2:, 1:-1] + surface[:-2, 1:-1]
                     - 4 * surface[1:-1, 1:-1]).astype(np.float32)
        ramp = ((np.arange(n * n) % 1021) * 1e-3).astype(np.float32).reshape(n, n)
        self.frames = [ramp * np.float32(1 if i % 2 else -0.5) for i in range(4)]
        self.eps, self.sum = np.zeros((2, n, n), np.float32)
        self.out = np.zeros((4, n, n), np.float32)
        self.scratch = np.zeros((6, n, n), np.float32)
        self.padded = np.zeros((n + 2, n + 2), np.float32)
        self.k = 0

    def pressures(self):
        p, q = self.frames[self.k % 4], self.frames[(self.k + 1) % 4]
        self.k += 1
        return p, q


def numpy_frame(s):
    p, q = s.pressures()
    eps, total, out = s.eps, s.sum, s.out
    way, r, t, rate, acceleration, gain = s.scratch
    np.subtract(q, p, out=way)
    np.multiply(eps, E, out=r)
    np.subtract(p, r, out=r)
    np.multiply(eps, I0, out=t)
    total += t
    np.multiply(p, I1, out=t)
    total += t
    np.multiply(way, I2, out=t)
    total += t
    for target, of_r, of_way in ((rate, V0, V1), (acceleration, A0, A1)):
        np.multiply(r, of_r, out=target)
        np.multiply(way, of_way, out=t)
        target += t
    np.multiply(r, B, out=t)
    eps += t
    np.multiply(way, F, out=t)
    eps += t
    padded = s.padded
    padded[1:-1, 1:-1] = eps
    padded[0, 1:-1], padded[-1, 1:-1] = eps[0], eps[-1]
    padded[1:-1, 0], padded[1:-1, -1] = eps[:, 0], eps[:, -1]
    np.add(padded[1:-1, 2:], padded[1:-1, :-2], out=gain)
    gain += padded[2:, 1:-1]
    gain += padded[:-2, 1:-1]
    np.multiply(eps, np.float32(4), out=t)
    gain -= t
    np.subtract(s.rest, gain, out=gain)
    gain += np.float32(1)
    for response, x in zip(out, (eps, total, rate, acceleration)):
        np.multiply(x, gain, out=response)


@numba.njit(parallel=True, fastmath=False)
def advance(p, q, eps, total, rate, acceleration):
    for y in numba.prange(eps.shape[0]):
        for x in range(eps.shape[1]):
            way = q[y, x] - p[y, x]
            e = eps[y, x]
            r = p[y, x] - E * e
            total[y, x] += I0 * e + I1 * p[y, x] + I2 * way
            rate[y, x] = V0 * r + V1 * way
            acceleration[y, x] = A0 * r + A1 * way
            eps[y, x] = e + (B * r + F * way)


@numba.njit(parallel=True, fastmath=False)
def respond(rest, eps, total, rate, acceleration, sa1, sa2, fa1, fa2):
    h, w = eps.shape
    for y in numba.prange(h):
        low, high = max(y - 1, 0), min(y + 1, h - 1)
        for x in range(w):
            e = eps[y, x]
            left, right = eps[y, max(x - 1, 0)], eps[y, min(x + 1, w - 1)]
            C = rest[y, x] - (((right - e) + (left - e)) + ((eps[high, x] - e) + (eps[low, x] - e)))
            gain = np.float32(1) + C
            sa1[y, x] = e * gain
            sa2[y, x] = total[y, x] * gain
            fa1[y, x] = rate[y, x] * gain
            fa2[y, x] = acceleration[y, x] * gain


def numba_frame(s):
    p, q = s.pressures()
    advance(p, q, s.eps, s.sum, s.scratch[3], s.scratch[4])
    respond(s.rest, s.eps, s.sum, s.scratch[3], s.scratch[4], *s.out)


def laplacian(z):
    return np.gradient(np.gradient(z, axis=0), axis=0) + np.gradient(np.gradient(z, axis=1), axis=1)


def study_maps(n):
    y, x = np.mgrid[0:n, 0:n]
    surface = 0.5 + 0.5 * np.sin(2 * np.pi * 15 * (x / n + 0.3 * np.sin(y / 30)))
    pressure = np.clip(1 - np.hypot(x - n // 2, y - n // 2) / (n // 4), 0, None)
    return surface, pressure, [(75, 75), (85, 85), (60, 80), (37, 37), (112, 112)]


def study_kept(n, steps):
    """As the study keeps it: every field at every time, statistics afterwards."""
    surface, pressure, points = study_maps(n)
    strain, rate, deformed, curvature = (np.zeros((steps, n, n)) for _ in range(4))
    for i in range(1, steps):
        rate[i] = (pressure - MODULUS * strain[i - 1]) / VISCOSITY
        strain[i] = strain[i - 1] + rate[i] * DT
        deformed[i] = surface - strain[i]
        curvature[i] = laplacian(deformed[i])
    second = np.zeros_like(rate)
    second[1:-1] = (rate[2:] - rate[:-2]) / (2 * DT)
    gain = 1 + curvature
    traces = []
    for response in (strain * gain, np.cumsum(strain, axis=0) * DT * gain, rate * gain, second * gain):
        traces += [response.mean(axis=(1, 2)), response.min(axis=(1, 2)), response.max(axis=(1, 2))]
        traces += [response[:, y, x] for x, y in points]
    return traces


def study_stepped(n, steps):
    """The same numbers step by step, nothing kept."""
    surface, pressure, points = study_maps(n)
    strain, total, before = np.zeros((3, n, n))
    traces = []
    for _ in range(steps):
        rate = (pressure - MODULUS * strain) / VISCOSITY
        strain = strain + rate * DT
        total = total + strain * DT
        gain = 1 + laplacian(surface - strain)
        row = []
        for response in (strain * gain, total * gain, rate * gain, (rate - before) / DT * gain):
            row += [response.mean(), response.min(), response.max(), *(response[y, x] for x, y in points)]
        before = rate
        traces.append(row)
    return traces


def timed(work, runs):
    work()
    seconds = []
    for _ in range(runs):
        start = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - start)
    return min(seconds), statistics.median(seconds), *np.quantile(seconds, [0.25, 0.75])


def main(path):
    with open(path, newline="") as file:
        table = list(csv.DictReader(file))
    names, first = list(table[0]), table[0]
    versions = {"numpy": np.__version__, "numba": numba.__version__, "halide": halide_version()}
    with open(path, "a", newline="") as file:
        rows = csv.DictWriter(file, names, lineterminator="\n")

        def add(backend, workload, n, steps, precision, threads, seconds, model="march", method="exact"):
            ns = f"{seconds[1] / (n * n * steps) * 1e9:8.4g} ns per cell and step" if seconds else "not installed"
            print(f"{workload:12} {backend:18} {threads}T {n:6} {ns}")
            least, median, q1, q3 = (f"{s:.6g}" for s in seconds) if seconds else [""] * 4
            rows.writerow({
                **{name: first[name] for name in ("schema", "commit", "date", "size", "cpu", "cores")}, "device": "cpu", "exact": "false",
                "driver": backend, "driver_version": versions[backend],
                "backend": backend, "threads": threads, "workload": workload, "width": n, "height": n,
                "steps": steps, "model": model, "method": method, "precision": precision,
                "bytes_per_cell": 44 if workload == "W1" else "", "stencil": "five-point" if workload == "W1" else "published",
                "wall_least_s": least, "wall_median_s": median, "wall_q1_s": q1, "wall_q3_s": q3, "runs": RUNS if seconds else "",
                "status": "ok" if seconds else "not installed"})

        for n in (512, 2048) if QUICK else (512, 2048, 4096):
            cores = numba.get_num_threads()
            peers = [("numpy", numpy_frame, Frame(n), 1), ("numba", numba_frame, Frame(n), cores)]
            if HalideFrame:
                peers.append(("halide", HalideFrame.press, HalideFrame(Frame(n), row_of_step()), cores))
            for backend, frame, scene, _ in peers:
                for _ in range(6):
                    frame(scene)
                off = max(np.abs(a - b).max() / np.abs(b).max() for a, b in zip(scene.out, peers[0][2].out))
                if not off < 1e-4:
                    sys.exit(f"peers: {backend} and NumPy differ by {off}")
            frames = max(1, int(4e6 / n / n))
            for backend, frame, scene, threads in peers:
                seconds = timed(lambda: [frame(scene) for _ in range(frames)], RUNS)
                add(backend, "W1", n, frames, "f32", threads, seconds)
            if not HalideFrame:
                add("halide", "W1", n, frames, "f32", cores, None)
        steps = 100 if QUICK else 1000
        for model, study in (("kept", study_kept), ("stepped", study_stepped)):
            seconds = timed(lambda: study(150, steps), min(RUNS, 3))
            add("numpy", "W3", 150, 9 * steps, "f64", 1, [9 * s for s in seconds], model, "euler")


main(next(a for a in sys.argv[1:] if not a.startswith("-")))
