# SPDX-License-Identifier: MIT
"""One press in Numba, for peers.py: two loops over all rows, or one loop in which rows roll through each thread's band.

The ends of rows are taken out of the inner loops, so that these are vectors, and floating point may be reordered.
"""

import numba
import numpy as np

ONE, FOUR = np.float32(1), np.float32(4)


@numba.njit(parallel=True, fastmath=True)
def advance(p, q, strain, integral, rate, acceleration, E, b, f, i0, i1, i2, v0, v1, a0, a1):
    for y in numba.prange(strain.shape[0]):
        start, end, e, total, v, a = p[y], q[y], strain[y], integral[y], rate[y], acceleration[y]
        for x in range(strain.shape[1]):
            way, before = end[x] - start[x], e[x]
            r = start[x] - E * before
            total[x] += i0 * before + i1 * start[x] + i2 * way
            v[x] = v0 * r + v1 * way
            a[x] = a0 * r + a1 * way
            e[x] = before + b * r + f * way


@numba.njit(inline="always")
def answer(x, left, right, above, e, below, rest, total, v, a, sa1, sa2, fa1, fa2):
    gain = ONE + rest[x] - (e[left] + e[right] + above[x] + below[x] - FOUR * e[x])
    sa1[x] = e[x] * gain
    sa2[x] = total[x] * gain
    fa1[x] = v[x] * gain
    fa2[x] = a[x] * gain


@numba.njit(inline="always")
def answer_row(above, e, below, rest, total, v, a, sa1, sa2, fa1, fa2):
    last = e.shape[0] - 1
    answer(0, 0, 1, above, e, below, rest, total, v, a, sa1, sa2, fa1, fa2)
    for x in range(1, last):
        answer(x, x - 1, x + 1, above, e, below, rest, total, v, a, sa1, sa2, fa1, fa2)
    answer(last, last - 1, last, above, e, below, rest, total, v, a, sa1, sa2, fa1, fa2)


@numba.njit(parallel=True, fastmath=True)
def respond(rest, strain, integral, rate, acceleration, sa1, sa2, fa1, fa2):
    height = strain.shape[0]
    for y in numba.prange(height):
        answer_row(
            strain[max(y - 1, 0)],
            strain[y],
            strain[min(y + 1, height - 1)],
            rest[y],
            integral[y],
            rate[y],
            acceleration[y],
            sa1[y],
            sa2[y],
            fa1[y],
            fa2[y],
        )


@numba.njit(parallel=True, fastmath=True)
def rolling(p, q, rest, strain, integral, sa1, sa2, fa1, fa2, rows, threads, E, b, f, i0, i1, i2, v0, v1, a0, a1):
    """rows: of each thread, the new strain above and below its band, and two rows each of rate and acceleration."""
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
                start, end, e, total, v, a = (
                    p[y],
                    q[y],
                    strain[y],
                    integral[y],
                    rows[t, 2 + (y & 1)],
                    rows[t, 4 + (y & 1)],
                )
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
                answer_row(
                    above,
                    strain[i],
                    below,
                    rest[i],
                    integral[i],
                    rows[t, 2 + (i & 1)],
                    rows[t, 4 + (i & 1)],
                    sa1[i],
                    sa2[i],
                    fa1[i],
                    fa2[i],
                )
