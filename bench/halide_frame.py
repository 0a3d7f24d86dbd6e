# SPDX-License-Identifier: MIT
"""Workload W1 in Halide, for peers.py."""
import importlib.metadata

import halide as hl
import numpy as np

ROWS = 32  # of a strip, which one thread goes down
LANES = 16


def version():
    try:
        return importlib.metadata.version("halide")
    except importlib.metadata.PackageNotFoundError:  # Debian's package tells Python none
        return ""


def pipeline(n, step):
    """Strain, integral and four responses after a step; the new strain slides down a strip and is made once."""
    E, b, f, i0, i1, i2, v0, v1, a0, a1 = (hl.f32(float(c)) for c in step)
    x, y, strip, row = (hl.Var(name) for name in ("x", "y", "strip", "row"))
    images = [hl.ImageParam(hl.Float(32), 2, name) for name in ("rest", "start", "end", "strain", "integral")]
    rest, start, end, strain, integral = images
    way, r = end[x, y] - start[x, y], start[x, y] - E * strain[x, y]
    after = hl.Func("after")
    after[x, y] = strain[x, y] + f * way + b * r
    e = hl.BoundaryConditions.repeat_edge(after, [(0, n), (0, n)])
    total = integral[x, y] + i2 * way + i1 * start[x, y] + i0 * strain[x, y]
    across = (e[x - 1, y] - e[x, y]) + (e[x + 1, y] - e[x, y])
    gain = 1 + (rest[x, y] - (across + ((e[x, y - 1] - e[x, y]) + (e[x, y + 1] - e[x, y]))))
    out = hl.Func("out")
    out[x, y] = (e[x, y], total, e[x, y] * gain, total * gain, (v0 * r + v1 * way) * gain, (a0 * r + a1 * way) * gain)
    outputs = out.output_buffers()
    for buffer in (*images, outputs[0]):  # the other outputs have the first one's bounds
        buffer.dim(0).set_bounds(0, n)
        buffer.dim(1).set_bounds(0, n)
    for buffer in (*images, *outputs):
        buffer.dim(1).set_stride(n)
        buffer.set_host_alignment(64)
    out.bound(x, 0, n).bound(y, 0, n).split(y, strip, row, ROWS).parallel(strip).vectorize(x, LANES)
    after.store_at(out, strip).compute_at(out, row).vectorize(x, LANES)
    out.compile_jit(hl.get_jit_target_from_environment())
    return images, out


def aligned(values):
    """Return a copy that begins at a cache line, and a buffer of it. The buffer's first axis is the fast one."""
    memory = np.empty(values.size + LANES, np.float32)
    first = -memory.ctypes.data % 64 // 4
    copy = memory[first:first + values.size].reshape(values.shape)
    copy[:] = values
    buffer = hl.Buffer(copy)
    if buffer.dim(0).stride() != 1:  # versions take the axes in another order
        buffer = hl.Buffer(copy.T)
    return copy, buffer


class HalideFrame:
    """The same work as a Frame of peers.py."""

    def __init__(self, frame, step):
        n = frame.rest.shape[0]
        self.images, self.pipeline = pipeline(n, step)
        self.frames = [aligned(p) for p in frame.frames]
        self.rest = aligned(frame.rest)
        self.strain, self.integral = ([aligned(np.zeros((n, n), np.float32)) for _ in range(2)] for _ in range(2))
        self.responses = [aligned(np.zeros((n, n), np.float32)) for _ in range(4)]
        self.images[0].set(self.rest[1])
        self.k = 0

    @property
    def out(self):
        return [array for array, _ in self.responses]

    def press(self):
        k = self.k
        self.k += 1
        for image, (_, buffer) in zip(self.images[1:], (self.frames[k % 4], self.frames[(k + 1) % 4], self.strain[k % 2], self.integral[k % 2])):
            image.set(buffer)
        self.pipeline.realize([buffer for _, buffer in (self.strain[1 - k % 2], self.integral[1 - k % 2], *self.responses)])
