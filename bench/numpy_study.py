# SPDX-License-Identifier: MIT
# The study's stepping of every cell in NumPy float64: strain, curvature of the deformed surface, four responses, means,
# extremes and five points, at each of `steps` times. Prints seconds for one scene, the median of three runs.
import statistics
import sys
import time

import numpy as np


def scene(n, steps, dt=0.01, modulus=1.54, viscosity=1.0):
    y, x = np.mgrid[0:n, 0:n]
    surface = 0.5 + 0.5 * np.sin(2 * np.pi * 15 * (x / n + 0.3 * np.sin(y / 30)))
    pressure = np.clip(1 - np.hypot(x - n // 2, y - n // 2) / (n // 4), 0, None)
    points = [(n // 2, n // 2), (n // 3, n // 3), (n // 3, n // 2), (n // 2, n // 3), (n // 4, n // 4)]
    strain = np.zeros_like(pressure)
    total = np.zeros_like(pressure)
    before = np.zeros_like(pressure)
    traces = []
    for _ in range(steps):
        rate = (pressure - modulus * strain) / viscosity
        strain = strain + rate * dt
        total = total + strain * dt
        deformed = surface - strain
        curvature = np.gradient(np.gradient(deformed, axis=0), axis=0) + np.gradient(np.gradient(deformed, axis=1), axis=1)
        gain = 1 + curvature
        row = []
        for response in (strain * gain, total * gain, rate * gain, (rate - before) / dt * gain):
            row += [response.mean(), response.min(), response.max(), *(response[p] for p in points)]
        before = rate
        traces.append(row)
    return traces


n, steps = int(sys.argv[1]), int(sys.argv[2])
times = []
for _ in range(3):
    start = time.perf_counter()
    scene(n, steps)
    times.append(time.perf_counter() - start)
print(statistics.median(times))
