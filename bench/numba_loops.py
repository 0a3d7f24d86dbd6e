# SPDX-License-Identifier: MIT
"""The peers in Numba, for peers.py: one press, and afferents by the methods of other models. Floating point may be
reordered. All numbers of afferents are those of one kind."""
import numba
import numpy as np

ONE, FOUR = np.float32(1), np.float32(4)
SAMPLES = 5  # of TouchSim's method in a millisecond


@numba.njit(inline="always")
def answer(x, left, right, above, e, below, rest, total, v, a, out, y):
    gain = ONE + rest[x] - (e[left] + e[right] + above[x] + below[x] - FOUR * e[x])
    out[0, y, x] = e[x] * gain
    out[1, y, x] = total[x] * gain
    out[2, y, x] = v[x] * gain
    out[3, y, x] = a[x] * gain


@numba.njit(inline="always")
def answer_row(above, e, below, rest, total, v, a, out, y):
    last = e.shape[0] - 1
    answer(0, 0, 1, above, e, below, rest, total, v, a, out, y)
    for x in range(1, last):  # the ends of rows are taken out, so that this is a loop of vectors
        answer(x, x - 1, x + 1, above, e, below, rest, total, v, a, out, y)
    answer(last, last - 1, last, above, e, below, rest, total, v, a, out, y)


@numba.njit(parallel=True, fastmath=True)
def rolling(p, q, rest, strain, integral, out, rows, threads, step):
    """A press in one loop, in which rows roll through each thread's band. rows: of each thread, the new strain above and
    below its band, and two rows each of rate and acceleration."""
    E, b, f, i0, i1, i2, v0, v1, a0, a1 = step
    height, width = strain.shape
    for t in numba.prange(threads):
        for side in range(2):
            y = height * t // threads - 1 if side == 0 else height * (t + 1) // threads
            if 0 <= y < height:
                start, end, e, to = p[y], q[y], strain[y], rows[t, side]
                for x in range(width):
                    to[x] = e[x] + b * (start[x] - E * e[x]) + f * (end[x] - start[x])
    for t in numba.prange(threads):
        first, last = height * t // threads, height * (t + 1) // threads
        for y in range(first, last + 1):
            if y < last:
                start, end, e, total, v, a = p[y], q[y], strain[y], integral[y], rows[t, 2 + (y & 1)], rows[t, 4 + (y & 1)]
                for x in range(width):
                    way, before = end[x] - start[x], e[x]
                    r = start[x] - E * before
                    total[x] += i0 * before + i1 * start[x] + i2 * way
                    v[x] = v0 * r + v1 * way
                    a[x] = a0 * r + a1 * way
                    e[x] = before + b * r + f * way
            if y > first:
                i = y - 1
                above = strain[i - 1] if i > first else (rows[t, 0, :width] if i > 0 else strain[i])
                below = strain[y] if y < last else (rows[t, 1, :width] if y < height else strain[i])
                answer_row(above, strain[i], below, rest[i], integral[i], rows[t, 2 + (i & 1)], rows[t, 4 + (i & 1)], out, i)


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
