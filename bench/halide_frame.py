# SPDX-License-Identifier: MIT
"""One press in Halide, for peers.py. Its stores go through the caches: Halide has no others."""

import importlib.metadata

import halide as hl

LANES = 16
# One thread goes down a strip of rows. The new strain slides down the strip, or is made for the whole strip at once.
SCHEDULES = {"slide-32": ("slide", 32), "slide-128": ("slide", 128), "strip-16": ("strip", 16)}


def version():
    try:
        return importlib.metadata.version("halide")
    except importlib.metadata.PackageNotFoundError:  # Debian's package tells Python none
        return ""


def pipeline(n, method, step):
    """Strain, integral and four responses after a step."""
    kind, rows = SCHEDULES[method]
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
    out.bound(x, 0, n).bound(y, 0, n).split(y, strip, row, rows).parallel(strip).vectorize(x, LANES)
    if kind == "slide":
        after.store_at(out, strip).compute_at(out, row).vectorize(x, LANES)
    else:
        after.compute_at(out, strip).vectorize(x, LANES)
    out.compile_jit(hl.get_jit_target_from_environment())
    return images, out


def buffer_of(array):
    """Return a buffer of a map. The buffer's first axis is the fast one."""
    buffer = hl.Buffer(array)
    return buffer if buffer.dim(0).stride() == 1 else hl.Buffer(array.T)  # versions take the axes in another order


class HalideFrame:
    """Presses the frames of a Frame of peers.py, whose maps begin at cache lines."""

    def __init__(self, n, method, step):
        self.images, self.pipeline = pipeline(n, method, step)
        self.scene = None

    def take(self, scene):
        self.scene = scene
        self.frames = [buffer_of(p) for p in scene.frames]
        self.rest = buffer_of(scene.rest)
        self.states = [[buffer_of(m) for m in state] for state in scene.states]
        self.responses = [buffer_of(r) for r in scene.out]
        self.images[0].set(self.rest)

    def __call__(self, scene):
        if self.scene is not scene:
            self.take(scene)
        k = scene.k
        scene.k += 1
        now, after = self.states[k % 2], self.states[1 - k % 2]
        for image, buffer in zip(self.images[1:], (self.frames[k % 4], self.frames[(k + 1) % 4], *now)):
            image.set(buffer)
        self.pipeline.realize([*after, *self.responses])
