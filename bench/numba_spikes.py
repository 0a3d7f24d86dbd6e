# SPDX-License-Identifier: MIT
"""Afferents in Numba by the methods of other models, for peers.py. All numbers are those of one kind of afferent."""

import numba
import numpy as np

LOW_PASS, MEMBRANE, REFRACTORY = 1e-3, 8e-3, 2e-3  # s
SAMPLES = 5  # of TouchSim's method in a millisecond


@numba.njit(parallel=True, fastmath=True)
def integrate_and_fire(q, voltage, rest, spikes, gain, leak, wait):
    """A leaky integrator, one step of a millisecond; a spike's time is that of the step."""
    for i in numba.prange(q.shape[0]):
        spikes[i] = 0
        if rest[i] > 0:
            rest[i] -= 1
            continue
        voltage[i] += leak * (gain * abs(q[i]) - voltage[i])
        if voltage[i] >= 1:
            spikes[i], voltage[i], rest[i] = 1, 0, wait


@numba.njit(parallel=True, fastmath=True)
def recursion(q, now, held, voltage, rest, spikes, b, a, gains, leak, wait):
    """TouchSim's method (Saal et al. 2017): a low-pass of order 3 at 5 kHz, the sum of both signs of it, of its rate and
    of its acceleration, and a recursion of the membrane. q: at the end of the millisecond; now: at its start."""
    for i in numba.prange(q.shape[0]):
        spikes[i] = 0
        step, x = (q[i] - now[i]) / SAMPLES, now[i]
        s0, s1, s2, y0, v0 = held[0, i], held[1, i], held[2, i], held[3, i], held[4, i]
        for _ in range(SAMPLES):
            x += step
            y = b[0] * x + s0
            s0 = b[1] * x - a[1] * y + s1
            s1 = b[2] * x - a[2] * y + s2
            s2 = b[3] * x - a[3] * y
            v = y - y0
            c = v - v0
            current = gains[0] * max(y, 0) - gains[1] * min(y, 0) + gains[2] * max(v, 0) - gains[3] * min(v, 0)
            current += gains[4] * max(c, 0) - gains[5] * min(c, 0)
            y0, v0 = y, v
            if rest[i] > 0:
                rest[i] -= 1
                continue
            voltage[i] += leak * (current - voltage[i])
            if voltage[i] >= 1:
                spikes[i], voltage[i], rest[i] = 1, 0, wait
        held[0, i], held[1, i], held[2, i], held[3, i], held[4, i], now[i] = s0, s1, s2, y0, v0, q[i]


def zeros(*shape):
    return np.zeros(shape, np.float32)
