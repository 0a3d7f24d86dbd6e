# SPDX-License-Identifier: MIT
"""The peers in Python. dermis-bench asks them over pipes, so that they run in the same rounds as the library (peers.hpp).

It sends lines. `prepare frames N`, `prepare device_frames N`, `prepare study STEPS` and `prepare spikes FIBRES` are answered
by a line for each peer, `peer NAME METHOD VERSION THREADS STEPS ERROR ..` or `missing NAME`, and `ready`. Errors are the
greatest ones by the greatest value, against the same model in double. `run NAME METHOD COUNT` is answered by seconds.
"""
import sys
import time

import numpy as np

try:
    import numba
    import numba_loops
except ImportError:  # a row says so
    numba = None

DT, MODULUS, VISCOSITY = 0.01, 1.54, 1.0
CHECKED = 6  # frames


def exact_step():
    """Coefficients of one exact step under a pressure that runs straight from one frame to the next, in double."""
    z, q = MODULUS * DT / VISCOSITY, DT / VISCOSITY
    p1 = -np.expm1(-z) / z
    p2 = (1 - p1) / z
    p3, decay = (0.5 - p2) / z, np.exp(-z)
    return (MODULUS, q * p1, q * p2, DT * p1, DT * q * p2, DT * q * p3, decay / VISCOSITY, q * p1 / DT,
            -MODULUS / VISCOSITY * decay / VISCOSITY, decay / VISCOSITY / DT)


STEP = E, B, F, I0, I1, I2, V0, V1, A0, A1 = tuple(np.float32(x) for x in exact_step())
NUMBERS = [float(x) for x in STEP]


def aligned(values):
    """Return a copy in float that begins at a cache line."""
    memory = np.empty(values.size + 16, np.float32)
    first = -memory.ctypes.data % 64 // 4
    copy = memory[first : first + values.size].reshape(values.shape)
    copy[:] = values
    return copy


class Frame:
    """One press: pressure in, strain and integral carried, four responses out. The maps of every peer."""

    def __init__(self, n):
        y, x = np.mgrid[0:n, 0:n].astype(np.float32)
        self.rest = aligned(self.laplacian(np.sin(0.3 * x) * np.cos(0.2 * y)))
        ramp = ((np.arange(n * n) % 1021) * 1e-3).astype(np.float32).reshape(n, n)
        self.frames = [aligned(ramp * np.float32(1 if i % 2 else -0.5)) for i in range(4)]
        self.state, self.out, self.scratch = (aligned(np.zeros((maps, n, n))) for maps in (2, 4, 6))
        self.padded = np.zeros((n + 2, n + 2), np.float32)
        self.k = 0

    @staticmethod
    def laplacian(x):
        wide = np.pad(x, 1, mode="edge")
        return wide[1:-1, 2:] + wide[1:-1, :-2] + wide[2:, 1:-1] + wide[:-2, 1:-1] - 4 * x

    def pressures(self):
        self.k += 1
        return self.frames[(self.k - 1) % 4], self.frames[self.k % 4]

    def exact(self):
        """The responses after CHECKED frames in double."""
        e, b, f, i0, i1, i2, v0, v1, a0, a1 = exact_step()
        strain, integral = np.zeros((2, *self.rest.shape))
        for k in range(CHECKED):
            p, q = (self.frames[(k + i) % 4].astype(float) for i in (0, 1))
            way, r = q - p, p - e * strain
            integral += i0 * strain + i1 * p + i2 * way
            rate, acceleration = v0 * r + v1 * way, a0 * r + a1 * way
            strain += b * r + f * way
        return [x * (1 + self.rest - self.laplacian(strain)) for x in (strain, integral, rate, acceleration)]


def add(to, scratch, *parts):
    """Adds maps, each times a number, in place."""
    for x, factor in parts:
        np.multiply(x, factor, out=scratch)
        to += scratch


def numpy_frame(s):
    (eps, total), out = s.state, s.out
    p, q = s.pressures()
    way, r, t, rate, acceleration, gain = s.scratch
    np.subtract(q, p, out=way)
    np.multiply(eps, E, out=r)
    np.subtract(p, r, out=r)
    add(total, t, (eps, I0), (p, I1), (way, I2))
    for target, of_r, of_way in ((rate, V0, V1), (acceleration, A0, A1)):
        np.multiply(r, of_r, out=target)
        add(target, t, (way, of_way))
    add(eps, t, (r, B), (way, F))
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


def numba_frame(s):
    threads, n = numba.get_num_threads(), s.rest.shape[1]
    rows = s.scratch.reshape(-1)[: threads * 6 * (n + 16)].reshape(threads, 6, n + 16)  # apart by a cache line
    numba_loops.rolling(*s.pressures(), s.rest, *s.state, s.out, rows, threads, STEP)


def prepare_frames(n):
    scene = Frame(int(n))
    exact = scene.exact()
    ways = [("numpy", "whole-maps", np.__version__, 1, numpy_frame)]
    if numba:
        ways.append(("numba", "rolling", numba.__version__, numba.get_num_threads(), numba_frame))
    else:
        print("missing numba")
    for name, method, version, threads, frame in ways:
        scene.state[:], scene.out[:], scene.k = 0, np.nan, 0
        for _ in range(CHECKED):
            frame(scene)
        errors = [np.abs(found - x).max() / np.abs(x).max() for found, x in zip(scene.out, exact)]
        offer(name, method, version, threads, CHECKED, errors, lambda count, frame=frame: [frame(scene) for _ in range(count)])


def torch_frame(p, q, eps, total, rest):
    """Pressures, the state and the rest curvature as tensors; returns the state and the responses after a press."""
    e, b, f, i0, i1, i2, v0, v1, a0, a1 = NUMBERS
    way, r = q - p, p - e * eps
    total = total + i0 * eps + i1 * p + i2 * way
    rate, acceleration = v0 * r + v1 * way, a0 * r + a1 * way
    eps = eps + b * r + f * way
    wide = torch.nn.functional.pad(eps[None, None], (1, 1, 1, 1), mode="replicate")[0, 0]
    around = wide[1:-1, 2:] + wide[1:-1, :-2] + wide[2:, 1:-1] + wide[:-2, 1:-1]
    gain = 1 + rest - (around - 4 * eps)
    return eps, total, eps * gain, total * gain, rate * gain, acceleration * gain


class TorchFrames:
    """Presses one after another on CUDA; run() returns the seconds of the device's own clock."""

    def __init__(self, n, press):
        self.scene, self.press, self.k = Frame(n), press, 0
        self.frames, self.rest = ([torch.from_numpy(x).cuda() for x in maps] for maps in (self.scene.frames, [self.scene.rest]))
        self.maps = [torch.zeros_like(self.rest[0])] * 2

    def run(self, count):
        start, end = (torch.cuda.Event(enable_timing=True) for _ in range(2))
        start.record()
        for _ in range(count):
            p, q = (self.frames[(self.k + i) % 4] for i in (0, 1))
            self.maps = self.press(p, q, *self.maps[:2], *self.rest)
            self.k += 1
        end.record()
        torch.cuda.synchronize()
        return start.elapsed_time(end) / 1e3


def prepare_device_frames(n):
    """PyTorch on a GPU with CUDA, by single operations and compiled. Errors are those of a smaller grid."""
    global torch
    try:
        import torch
    except ImportError:
        torch = None
    if not torch or not torch.cuda.is_available():
        print("missing torch")
        return
    if int(n) not in (2048, 4096):  # each size is compiled anew
        return
    for method, press in (("eager", torch_frame), ("compiled", torch.compile(torch_frame))):
        small, large = TorchFrames(512, press), TorchFrames(int(n), press)
        try:
            small.run(CHECKED)
            large.run(CHECKED)
        except Exception as error:  # as torch.compile raises where there is no C compiler: all other rows are still measured
            print(f"peers: torch, {method}, is left out: {error}", file=sys.stderr)
            continue
        errors = [np.abs(found.cpu().numpy() - x).max() / np.abs(x).max()
                  for found, x in zip(small.maps[2:], small.scene.exact())]
        offer("torch", method, torch.__version__, 1, CHECKED, errors, large.run)


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


def prepare_study(steps):
    """Both ways have the same SA1, SA2 and FA1. FA2 is a central difference in one and a backward one in the other."""
    steps = int(steps)
    kept, stepped = study_kept(150, 60), np.array(study_stepped(150, 60)).T
    error = max(np.abs(k[1:] - s[:-1]).max() / (np.abs(s).max() or 1) for k, s in zip(kept[:24], stepped[:24]))
    if not error < 1e-12:
        sys.exit(f"peers: the two ways of the study differ by {error}")
    for method, study in (("kept", study_kept), ("stepped", study_stepped)):
        offer("numpy", method, np.__version__, 1, steps, [], lambda count, study=study: [study(150, steps) for _ in range(count)])


def spike_inputs(n):
    """A period of 32 frames, each afferent with an amplitude and a phase of its own."""
    i, k = np.arange(n), np.arange(32)[:, None]
    return np.float32(3e-3 * (0.618034 * i % 1) * (1 + np.sin(2 * np.pi * (k / 32 + 0.7548777 * i))))


def prepare_spikes(n):
    """Ways of others on as many afferents; what they lose is in bench/spikes.png. Ouyang's steps as he has them: NumPy,
    a backward Euler step of the filter and a forward one of the membrane, in a millisecond."""
    n = int(n)
    inputs = spike_inputs(n)
    y1, y2, voltage, rest, before, fired_voltage, now, recursed = np.zeros((8, n), np.float32)

    def ouyang(count):
        nonlocal y1, y2, before
        for k in range(count):
            rate, before = (inputs[k % 32] - before) * 1e3, inputs[k % 32]
            y1 = (y1 + rate) / 2
            y2 = (y2 + y1) / 2
            voltage[:] += (np.maximum(y2, 0) + 0.1 * np.maximum(-y2, 0) - voltage) / 8
            voltage[rest > 0] = 0
            rest[:] = np.maximum(rest - 1, 0)
            fired = np.flatnonzero(voltage >= 1)
            voltage[fired], rest[fired] = 0, 2

    offer("numpy", "ouyang", np.__version__, 1, 1, [], ouyang)
    if not numba:
        print("missing numba")
        return
    spikes = np.zeros(n, np.uint8)
    held, waits = np.zeros((5, n), np.float32), np.zeros((2, n), np.int32)
    b, a = np.float32([0.000219, 0.000657, 0.000657, 0.000219]), np.float32([1, -2.7488, 2.5282, -0.7776])
    gains = np.float32([2, 1, 50, 20, 10, 10])

    def fire(count):
        for k in range(count):
            numba_loops.integrate_and_fire(inputs[k % 32], fired_voltage, waits[0], spikes, np.float32(600), np.float32(0.125), 2)

    def touchsim(count):
        for k in range(count):
            numba_loops.recursion(inputs[k % 32], now, held, recursed, waits[1], spikes, b, a, gains, np.float32(0.025), 5)

    for method, work in (("integrate-and-fire", fire), ("touchsim", touchsim)):
        work(2)
        offer("numba", method, numba.__version__, numba.get_num_threads(), 1, [], work)


def offer(name, method, version, threads, steps, errors, work):
    """Tells of a peer that is ready. work: does its work so many times; its seconds, where it returns some."""
    WORK[name, method] = work
    print("peer", name, method, version, threads, steps, *(f"{e:.6g}" for e in errors))


WORK = {}
PREPARE = {"frames": prepare_frames, "device_frames": prepare_device_frames, "study": prepare_study, "spikes": prepare_spikes}


def main():
    for line in sys.stdin:
        words = line.split()
        if words[0] == "prepare":
            WORK.clear()
            PREPARE[words[1]](words[2])
            print("ready", flush=True)
        else:
            work, count = WORK[words[1], words[2]], int(words[3])
            start = time.perf_counter()
            own = work(count)
            seconds = own if isinstance(own, float) else time.perf_counter() - start
            time.sleep(0.005)  # threads that wait for more work by spinning have stopped before the next contender
            print(f"{seconds:.9g}", flush=True)


main()
