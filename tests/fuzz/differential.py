# SPDX-License-Identifier: MIT
"""differential.py WAYS FOLDER SECONDS [SEED]: random scenes, computed by WAYS in every way there is, and compared.

A march in float must have the same bits on the CPU and on every Vulkan device that VK_DRIVER_FILES names, NaN apart from
its sign; models must agree within the tolerance that each keeps; and where one device refuses a scene, all do. A scene
that fails is made smaller as long as it fails, and left in FOLDER with its maps. Exit status: 1 where one failed, or where
none was computed.
"""
import json
import math
import pathlib
import random
import subprocess
import sys
import time

import numpy

METHODS = ["euler", "rk2", "rk4", "backward-euler", "crank-nicolson", "sdirk2", "published"]
QUANTITIES = ["strain", "sa1", "sa2", "fa1", "fa2"]


def number(draw, low, high):
    return float(f"{10 ** draw.uniform(low, high):.3g}")


class Scene:
    """Keys by their dotted names, and maps by the names of their files."""

    def __init__(self, keys, maps):
        self.keys, self.maps = keys, maps

    def write(self, folder):
        folder.mkdir(parents=True, exist_ok=True)
        lines = [f"{key} = {text_of(value)}\n" for key, value in sorted(self.keys.items())]
        (folder / "scene.toml").write_text("".join(lines))
        for name, values in self.maps.items():
            numpy.save(folder / name, values)
        if "sites.path" in self.keys:
            rows = ["type,x,y"] + [f"{kind},0,{y}" for y in range(self.keys["grid.height"]) for kind in ("sa1", "fa2")]
            (folder / "sites.csv").write_text("\n".join(rows) + "\n")
        return folder / "scene.toml"


def text_of(value):
    if isinstance(value, list):
        return "[" + ", ".join(text_of(v) for v in value) + "]"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{k} = {text_of(v)}" for k, v in value.items()) + " }"
    return json.dumps(value)


def drawn(draw):
    keys, maps = {}, {}
    width, height = keys["grid.width"], keys["grid.height"] = draw.randint(1, 40), draw.randint(1, 12)

    def array(name, low, high, signed=False):
        sign = draw.choice([1, -1]) if signed else 1
        maps[name] = numpy.array([[sign * number(draw, low, high) for _ in range(width)] for _ in range(height)])
        return name

    step = keys["time.step"] = number(draw, -4, 0)
    steps = draw.randint(1, 30)
    keys["time.duration"] = step * steps
    if draw.random() < 0.3:
        keys["method"] = draw.choice(METHODS)
        keys["allow_unstable"] = draw.random() < 0.5
    keys["surface.kind"] = draw.choice(["flat", "wave", "spiral", "file"])
    if keys["surface.kind"] == "file":
        keys["surface.path"] = array("surface.npy", -2, 0)
    chain = draw.random() < 0.3 and keys.get("method", "exact") == "exact"
    if chain:
        keys["material.elements"] = [{"modulus": number(draw, -1, 2), "viscosity": number(draw, -4, 1)}
                                     for _ in range(draw.randint(1, 4))]
        if draw.random() < 0.5:
            keys["material.spring"] = number(draw, -1, 2)
    else:
        keys["material.modulus"] = array("modulus.npy", -1, 1) if draw.random() < 0.2 else number(draw, -2, 2)
        keys["material.viscosity"] = array("viscosity.npy", -2, 1) if draw.random() < 0.2 else number(draw, -4, 1)
    keys["load.kind"] = draw.choice(["circular", "point", "linear", "file"])
    if keys["load.kind"] == "file":
        keys["load.path"] = array("load.npy", -1, 1, signed=True)
    keys["load.intensity"] = number(draw, -3, 3) if draw.random() < 0.9 else number(draw, -44, 38)
    envelope = keys["load.envelope"] = draw.choice(["step", "ramp", "sine", "pulse", "table"])
    if envelope == "ramp":
        keys["load.rise"] = step * number(draw, -1, 1)
    elif envelope == "sine":
        keys["load.frequency"], keys["load.phase"] = number(draw, -2, 0) / step, draw.uniform(-3, 3)
    elif envelope == "pulse":
        keys["load.length"], keys["load.period"] = 1.5 * step, step * draw.uniform(2, 9)
    elif envelope == "table":
        times = sorted(draw.uniform(0, step * steps) for _ in range(draw.randint(1, 5)))
        keys["load.times"], keys["load.values"] = times, [draw.uniform(-1, 2) for _ in times]
    if draw.random() < 0.3 and keys.get("method") != "published":
        keys["curvature.stencil"] = draw.choice(["five-point", "fourth-order"])
        keys["curvature.edges"] = draw.choice(["mirror", "periodic"])
    if draw.random() < 0.3:
        keys["receptors.fa2_gains"] = [draw.uniform(-2, 2), draw.uniform(-2, 2)]
    if draw.random() < 0.2:
        keys["receptors.sa2_adaptation"] = number(draw, -3, 1)
    keys["output.traces"] = draw.sample(QUANTITIES, draw.randint(0, 5))
    keys["output.probes"] = [[draw.randrange(width), draw.randrange(height)]]
    if draw.random() < 0.4:
        keys["output.fields"] = [{"at": step * draw.randint(1, steps), "what": draw.sample(QUANTITIES, 2)}]
    if draw.random() < 0.3:
        keys["sites.path"] = "sites.csv"
    return Scene(keys, maps)


class Ways:
    """The program that computes scenes in all ways and compares."""

    def __init__(self, program):
        self.process = subprocess.Popen([program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        print("computed on", self.process.stdout.readline().strip(), flush=True)

    def difference(self, path):
        """Says how two ways differ; nothing where none do."""
        print(path, file=self.process.stdin, flush=True)
        how = self.process.stdout.readline()
        if not how:
            sys.exit(f"{path}: the program ended with status {self.process.wait()}")
        return how.strip()


def smaller(scene):
    """Scenes that have less of something."""
    for key in sorted(scene.keys):
        if key not in ("grid.width", "grid.height", "time.step", "time.duration"):
            gone = [key] + [k for k in scene.keys if key in ("load.kind", "load.envelope", "surface.kind")
                            and k.startswith(key.split(".")[0])]
            keys = {k: v for k, v in scene.keys.items() if k not in gone}
            yield Scene(keys, {name: v for name, v in scene.maps.items() if name in keys.values()})
    duration, step = scene.keys["time.duration"], scene.keys["time.step"]
    if duration > 1.5 * step:
        yield Scene({**scene.keys, "time.duration": step * max(1, math.floor(duration / step / 2))}, scene.maps)
    for key, axis in (("grid.width", 1), ("grid.height", 0)):
        cells = scene.keys[key] // 2
        if cells:
            cut = {name: values[:, :cells] if axis else values[:cells] for name, values in scene.maps.items()}
            yield Scene({**scene.keys, key: cells, "output.probes": []}, cut)


def shrunk(scene, ways, folder):
    again = True
    while again:
        again = False
        for candidate in smaller(scene):
            if ways.difference(candidate.write(folder)):
                scene, again = candidate, True
                break
    return scene


def main(program, folder, seconds, seed="1"):
    folder, seed, tried, failures = pathlib.Path(folder), int(seed), 0, 0
    ways = Ways(program)
    end = time.monotonic() + float(seconds)
    while time.monotonic() < end:
        scene = drawn(random.Random(seed))
        how = ways.difference(scene.write(folder / "work"))
        tried += 1
        if how:
            failures += 1
            print(f"seed {seed}: {how}", flush=True)
            path = shrunk(scene, ways, folder / "work").write(folder / f"seed_{seed}")
            print(f"  made smaller: {ways.difference(path)}: {path}", flush=True)
        seed += 1
    print(f"{tried} scenes: {failures} differ")
    return 1 if failures or not tried else 0


if __name__ == "__main__":
    if len(sys.argv) not in (4, 5):
        sys.exit("usage: differential.py WAYS FOLDER SECONDS [SEED]")
    sys.exit(main(*sys.argv[1:]))
