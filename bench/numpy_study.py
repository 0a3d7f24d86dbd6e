# SPDX-License-Identifier: MIT
# The study's stepping of every cell in NumPy float64, with its definitions. Prints seconds for one scene, the median of
# three runs, twice: as the study keeps it (every field at every time, statistics afterwards), and step by step (means,
# extremes and five points of the four responses at each time, nothing kept).
import statistics
import sys
import time

import numpy as np

DT, MODULUS, VISCOSITY = 0.01, 1.54, 1.0


def maps(n):
    y, x = np.mgrid[0:n, 0:n]
    surface = 0.5 + 0.5 * np.sin(2 * np.pi * 15 * (x / n + 0.3 * np.sin(y / 30)))
    pressure = np.clip(1 - np.hypot(x - n // 2, y - n // 2) / (n // 4), 0, None)
    points = [(n // 2, n // 2), (n // 3, n // 3), (n // 3, n // 2), (n // 2, n // 3), (n // 4, n // 4)]
    return surface, pressure, points


def laplacian(z):
    return np.gradient(np.gradient(z, axis=0), axis=0) + np.gradient(np.gradient(z, axis=1), axis=1)


def kept(n, steps):
    surface, pressure, points = maps(n)
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
        traces += [response[:, y, x] for y, x in points]
    return traces


def stepped(n, steps):
    surface, pressure, points = maps(n)
    strain, total, before = np.zeros((3, n, n))
    traces = []
    for _ in range(steps):
        rate = (pressure - MODULUS * strain) / VISCOSITY
        strain = strain + rate * DT
        total = total + strain * DT
        gain = 1 + laplacian(surface - strain)
        row = []
        for response in (strain * gain, total * gain, rate * gain, (rate - before) / DT * gain):
            row += [response.mean(), response.min(), response.max(), *(response[p] for p in points)]
        before = rate
        traces.append(row)
    return traces


for way in kept, stepped:
    times = []
    for _ in range(3):
        start = time.perf_counter()
        way(int(sys.argv[1]), int(sys.argv[2]))
        times.append(time.perf_counter() - start)
    print(statistics.median(times))
