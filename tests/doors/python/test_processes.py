# SPDX-License-Identifier: MIT
"""Scenes, results, skins, devices and reports in other processes: they arrive whole, and give the same bits there."""
import concurrent.futures
import copy
import multiprocessing
import os
import pathlib
import pickle
import re
import signal
import subprocess
import sys

import dermis
import numpy as np
import pytest

TOP = pathlib.Path(__file__).resolve().parents[3]
GRID = {"grid": {"width": 12, "height": 9}}
RIDGES = np.sin(np.arange(9 * 12) / 5.0).reshape(9, 12)
TABLES = {
    "grid": {"width": 12, "height": 9, "spacing": 1e-3},
    "surface": {"path": RIDGES, "relief": 1e-4},
    "material": {"elements": [{"modulus": 2e4 + 1e3 * RIDGES, "viscosity": 400.0}, {"modulus": 5e4, "viscosity": 10.0}],
                 "spring": 1e5, "dashpot": 1e6, "thickness": 1e-3, "curvature_length": -1e-4},
    "load": {"kind": "circular", "center": [5, 4], "radius": 3, "intensity": "20 kPa", "envelope": "table",
             "times": [0.0, 0.1, 0.3], "values": [0.0, 1.0, 0.5]},
    "time": {"step": 0.02, "duration": 0.4},
    "receptors": {"sa2_adaptation": 0.5, "fa2_gains": [1.0, -0.5], "fa2": "step-mean"},
    "curvature": {"stencil": "fourth-order", "edges": "periodic"},
    "sites": [("sa1", 3, 4), ("fa2", 11, 8)],
    "output": {"probes": [[5, 4]], "fields": [{"at": 0.2, "what": ["sa1", "curvature"]}]},
    "tolerance": 0.01, "model": "march", "precision": "f32",
}
SCENE = dermis.Scene(TABLES)


def numbers(result):
    traces = [array.tobytes() for name in result for array in (result[name].mean, result[name].max, *result[name].probes)]
    return traces, result.responses.tobytes(), {key: field.tobytes() for key, field in result.fields.items()}


def again(value):
    return pickle.loads(pickle.dumps(value))


def test_a_scene_arrives_with_its_maps_and_every_key():
    there = again(SCENE)
    assert type(there) is dermis.Scene and pickle.dumps(there) == pickle.dumps(SCENE)
    assert numbers(dermis.run(there)) == numbers(dermis.run(SCENE))
    assert copy.deepcopy(SCENE) == SCENE


def test_a_scene_of_files_needs_no_file_any_more(tmp_path, monkeypatch):
    np.save(tmp_path / "ridges.npy", RIDGES)
    text = '[grid]\nwidth = 12\nheight = 9\n[surface]\nkind = "file"\npath = "ridges.npy"\n'
    (tmp_path / "scene.toml").write_text(text)
    there = pickle.dumps(dermis.Scene.from_file(tmp_path / "scene.toml"))
    os.remove(tmp_path / "ridges.npy")
    assert (pickle.loads(there).surface.path == RIDGES).all()
    np.save(tmp_path / "frames.npy", np.ones((3, 9, 12), np.float32))
    monkeypatch.chdir(tmp_path)
    frames = pickle.dumps(dermis.Scene(grid={"width": 12, "height": 9},
                                       load={"kind": "sequence", "path": "frames.npy", "interval": 0.1}))
    monkeypatch.chdir("/")  # frames are read while a run takes place: both processes need the file, wherever they are
    assert numbers(dermis.run(pickle.loads(frames)))


def test_what_a_run_returns_arrives_whole():
    result = dermis.run(SCENE)
    there = again(result)
    assert numbers(there) == numbers(result) and (there.time == result.time).all()
    assert repr(there) == repr(result) and repr(there.report()) == repr(result.report())
    for value in (result["sa1"], result.report(), result.report().strain, result.device, dermis.plan(SCENE),
                  *dermis.run({"load": {"envelope": "pulse"}, "time": {"duration": 1.0}}).impulses[:1],
                  dermis.KelvinVoigt(modulus=2.0, viscosity=3.0), dermis.Relaxation(moduli=[1.0], times=[2.0]),
                  dermis.fit_relaxation([0, 1, 2, 3, 4], [5, 4, 3.5, 3.2, 3], 2), dermis.contact.Contact(1e-3, 2e-3, 0.5),
                  dermis.contact.WorldContact((1, 2, 3), 0.5), dermis.contact.Pose((1, 2, 3), -np.eye(3))):
        assert repr(again(value)) == repr(value) and type(again(value)) is type(value)
        assert not repr(value).startswith("<dermis._core")


def test_what_another_build_pickled_is_refused_by_both_names():
    bytes_of_this, attributes = SCENE.__getstate__()
    with pytest.raises(dermis.Error, match="pickled by dermis 9.9.*allowed: dermis .* of commit"):
        dermis.Scene.__new__(dermis.Scene).__setstate__((bytes_of_this.replace(b"dermis 0.", b"dermis 9.9", 1), {}))
    with pytest.raises(dermis.Error, match="state = cut bytes"):
        dermis.Scene.__new__(dermis.Scene).__setstate__((bytes_of_this[:-9], {}))
    assert attributes == {}


@pytest.mark.parametrize("device", ["cpu", "vulkan"])
def test_a_copied_skin_is_a_branch_with_the_same_bits(device):
    material = {"modulus": 2e4, "viscosity": 400.0}
    scene = {"grid": TABLES["grid"], "surface": {"relief": 1e-4},
             "material": {**material, "thickness": 1e-3, "curvature_length": 1e-4}}
    pressure = np.random.default_rng(1).random((2, 3, 9, 12), np.float32)
    skin = dermis.Skin(scene, (2, 3), device=device, responses=["fa1", "sa2"], precision="f32-compensated",
                       materials=[material] * 6)
    skin.press(pressure, 0.01)
    skin.set_material({"modulus": np.linspace(1e4, 6e4, 6).reshape(2, 3), "viscosity": 100.0})
    for branch in (copy.deepcopy(skin), copy.copy(skin), again(skin)):
        assert repr(branch) == repr(skin) and not branch["fa1"].any()  # until it is pressed
        kept = skin.save()
        for one in (skin, branch):
            one.press(2 * pressure, 0.02)
        assert all(branch[name].tobytes() == skin[name].tobytes() for name in ("fa1", "sa2", "strain"))
        skin.load(kept)


def test_devices_arrive_as_the_text_that_opened_them():
    assert again(dermis.Device.cpu(1)).info.name == "cpu"
    assert again(dermis.Device.open("vulkan")).info.name == dermis.Device.open("vulkan").info.name


@pytest.mark.skipif(not os.path.exists("/proc/self/task"), reason="counts threads of this process")
def test_copies_of_a_skin_share_its_device_in_one_process():
    skin = dermis.Skin(GRID, device="vulkan")
    skin.press(np.ones((9, 12), np.float32), 0.1)
    threads = len(os.listdir("/proc/self/task"))
    copies = [copy.copy(skin), copy.deepcopy(skin), again(skin), dermis.Skin(GRID, device=again(dermis.Device.open("cpu")))]
    assert len(os.listdir("/proc/self/task")) == threads and len(copies) == 4  # a software device has threads of its own


class Thumb(dermis.Skin):
    pass


class Touch(dermis.contact.Contact):
    pass


class Pulp(dermis.Scene):
    pass


@pytest.mark.parametrize("value", [Thumb(GRID), Touch(1e-3, 2e-3, 0.5), Pulp(GRID)], ids=["skin", "contact", "scene"])
def test_a_subclass_keeps_its_type_and_its_attributes(value):
    value.names = ["left"]
    for there in (again(value), copy.copy(value), copy.deepcopy(value)):
        assert type(there) is type(value) and there.names == ["left"]
    assert copy.copy(value).names is value.names and copy.deepcopy(value).names is not value.names


SCENES = [dermis.Scene({**TABLES, "load": {"intensity": 1e4 * i}}) for i in range(1, 7)]


def test_an_executor_maps_run_over_scenes():
    with concurrent.futures.ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as pool:
        assert [numbers(r) for r in pool.map(dermis.run, SCENES)] == [numbers(dermis.run(s)) for s in SCENES]


def test_a_sweep_runs_every_combination_wherever_it_is_mapped():
    values = {"load.intensity": [1e4, "20 kPa"], "time.step": [0.02, 0.04]}
    rows = dermis.sweep(TABLES, values)
    assert [row["set"] for row in rows] == ["load.intensity=10000.0 time.step=0.02", "load.intensity=10000.0 time.step=0.04",
                                            'load.intensity="20 kPa" time.step=0.02', 'load.intensity="20 kPa" time.step=0.04']
    assert list(rows[0]) == ["run", "model", "precision", "seconds", "predicted_error", "measured_error", "greatest_gain",
                             "kinks", "cells_compared", "cells_different", *values, *rows[0]["result"].outcomes, "set", "result"]
    with concurrent.futures.ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as pool:
        mapped = dermis.sweep(TABLES, values, map=pool.map)
    assert [numbers(row["result"]) for row in mapped] == [numbers(row["result"]) for row in rows]
    with pytest.raises(dermis.Error, match="values.'time.step'. = 0.02; allowed: a list"):
        dermis.sweep(TABLES, {"time.step": 0.02})
    with pytest.raises(dermis.Error, match="scene = <Scene 12 x 9 .*>; allowed: tables by name, or the path"):
        dermis.sweep(SCENE, values)


def slow_run(scene):
    import time
    time.sleep(0.5)
    return dermis.run(scene)


def test_a_dask_worker_that_is_killed_loses_nothing():
    import distributed
    with distributed.LocalCluster(2, threads_per_worker=1, dashboard_address=None) as cluster, \
            distributed.Client(cluster) as client:
        runs = client.map(slow_run, SCENES)
        distributed.wait(runs, return_when="FIRST_COMPLETED")
        os.kill(next(iter(client.run(os.getpid).values())), signal.SIGKILL)
        assert [numbers(r) for r in client.gather(runs)] == [numbers(dermis.run(s)) for s in SCENES]


BLOCKS = re.findall(r"```python\n(.*?)```", (TOP / "host/examples/PROCESSES.md").read_text(), re.DOTALL)
NAMES = ["sweep", "concurrent", "joblib", "distributed", "ray"]  # the last is a large package, tried by hand


@pytest.mark.parametrize("name, block", list(zip(NAMES[:-1], BLOCKS)), ids=NAMES[:-1])
def test_the_page_about_processes_does_what_it_says(name, block, tmp_path):
    assert len(BLOCKS) == len(NAMES) and (name in block or name == "sweep")
    (tmp_path / "scene.toml").write_text('[load]\nenvelope = "sine"\n[time]\nduration = 0.5\n')
    (tmp_path / "page.py").write_text(block)
    run = subprocess.run([sys.executable, "page.py"], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert run.returncode == 0, run.stderr


def test_the_memory_at_hand_is_the_least_of_the_machines_and_of_all_control_groups(tmp_path):
    def write(path, text):
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_text(text)

    def at_hand():
        return dermis._core.memory_at_hand(str(tmp_path))

    assert at_hand() == np.inf
    write("proc/meminfo", "MemTotal: 9000000 kB\nMemAvailable: 8000000 kB\n")
    write("proc/self/cgroup", "5:cpu:/old\n4:memory:/old\n0::/a/b\n")
    assert at_hand() == 8000000 * 1024
    write("sys/fs/cgroup/a/b/memory.max", "max\n")
    write("sys/fs/cgroup/a/b/memory.current", "1\n")
    write("sys/fs/cgroup/a/memory.max", "5000\n")
    write("sys/fs/cgroup/a/memory.current", "3000\n")
    assert at_hand() == 2000
    write("sys/fs/cgroup/a/memory.stat", "anon 1500\ninactive_file 500\n")  # of which the system drops what it needs
    assert at_hand() == 2500
    write("sys/fs/cgroup/memory/old/memory.limit_in_bytes", "1000\n")
    write("sys/fs/cgroup/memory/old/memory.usage_in_bytes", "900\n")
    assert at_hand() == 100
    write("sys/fs/cgroup/memory/old/memory.usage_in_bytes", "1100\n")
    assert at_hand() == 0


ELEMENTS = [{"modulus": 1e5, "viscosity": 10.0 * i} for i in range(1, 5)]
IN_METRES = {"surface": {"relief": 1e-4}, "material": {"elements": ELEMENTS, "thickness": 1e-3, "curvature_length": 1e-4}}
WHOLE = {"grid": {"width": 1000, "height": 1000}}


@pytest.mark.parametrize("scene, needs", [
    (WHOLE, "1000000 skins of 1000 x 1000 cells and 0 sites need at least 24 TB"),
    ({"grid": {"width": 1000, "height": 1000, "spacing": 1e-4}, **IN_METRES}, "0 sites need at least 36 TB"),
    ({**WHOLE, "sites": [("sa1", x, y) for x in range(100) for y in range(100)]}, "10000 sites need at least 4.08 TB"),
], ids=["cells", "elements", "sites"])
def test_pads_beyond_the_memory_at_hand_are_refused_with_both_numbers(scene, needs):
    with pytest.raises(MemoryError, match=re.escape(needs) + r", and [0-9.e+]+ GB are available"):
        dermis.Skin(scene, 1000000)
