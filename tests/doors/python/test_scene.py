# SPDX-License-Identifier: MIT
"""Scenes from tables, objects, texts and files."""
import copy
import dataclasses
import os
import pickle
import re

import dermis
import numpy as np
import pytest
from common import refused

TABLES = {
    "grid": {"width": 12, "height": 9},
    "surface": {"kind": "wave", "ridges": 3},
    "load": {"kind": "circular", "center": [6, 4], "envelope": "ramp", "rise": 0.2},
    "time": {"step": 0.05, "duration": 0.5},
    "output": {"traces": ["sa1", "fa1"], "probes": [[6, 4]]},
}
TEXT = """
[grid]
width = 12
height = 9
[surface]
kind = "wave"
ridges = 3
[load]
kind = "circular"
center = [6, 4]
envelope = "ramp"
rise = 0.2
[time]
step = 0.05
duration = 0.5
[output]
traces = ["sa1", "fa1"]
probes = [[6, 4]]
"""


def bits(scene):
    result = dermis.run(scene)
    return [array.tobytes() for name in result for array in (result[name].mean, result[name].max, *result[name].probes)]


def test_tables_objects_text_and_file_make_the_same_scene(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(TEXT)
    objects = dermis.Scene(
        grid=dermis.Grid(width=12, height=9), surface=dermis.Surface(kind="wave", ridges=3),
        load=dermis.Load(center=(6, 4), envelope="ramp", rise=0.2), time=dermis.Time(step=0.05, duration=0.5),
        output=dermis.Output(traces=["sa1", "fa1"], probes=np.array([[6, 4]])))
    expected = bits(dermis.Scene.from_string(TEXT))
    for scene in (TABLES, dermis.Scene(TABLES), objects, path, str(path), dermis.Scene.from_file(path)):
        assert bits(scene) == expected


def test_a_keyword_takes_the_place_of_a_table():
    assert dermis.Scene(TABLES, grid={"width": 20, "height": 25}, load={}).width == 20


def test_overrides_replace_keys():
    scene = dermis.Scene.from_string(TEXT, {"time.duration": 0.25, "output.traces": ["sa2"], "surface.kind": "flat",
                                            "surface": {"kind": "flat"}})
    result = dermis.run(scene)
    assert list(result) == ["sa2"] and len(result.time) == 5


def test_an_array_stands_in_place_of_a_maps_file(tmp_path):
    heights = np.random.default_rng(1).random((9, 12))
    np.save(tmp_path / "heights.npy", heights)
    moduli = heights + 1
    scene = dermis.Scene(TABLES, surface={"path": heights}, material={"modulus": moduli.astype(np.float32)})
    from_file = dermis.Scene(TABLES, surface={"kind": "file", "path": tmp_path / "heights.npy"},
                             material={"modulus": moduli.astype(np.float32).astype(float)})
    assert bits(scene) == bits(from_file)
    np.testing.assert_array_equal(scene.surface.path, heights)


def test_sites_may_be_lengths_with_their_unit():
    grid = {"width": 80, "height": 60, "spacing": "0.1 mm"}
    scene = dermis.fingertip(grid=grid, sites=[("sa1", "3 mm", "2.05 mm"), ("fa1", np.int64(4), "0.39 mm")])
    assert scene.sites == [("sa1", 30, 20), ("fa1", 4, 3)]
    error = refused(dermis.fingertip, grid=grid, sites=[("sa1", "3 s", 2)])
    assert str(error) == "sites = '3 s'; allowed: whole cells, or a length with its unit, as \"3 mm\""
    error = refused(dermis.Scene, TABLES, sites=[("sa1", "3 mm", 2)])
    assert str(error) == "sites = '3 mm'; allowed: whole cells: the grid has no spacing"


def test_one_word_lays_receptors_as_deep_as_in_a_fingertip():
    tip = dermis.fingertip(receptors={"depth": "fingertip"})
    depths = {"sa1": 3e-4, "sa2": 1.1e-3, "fa1": 5e-4, "fa2": 2e-3}
    assert tip.receptors.depth == depths
    for same in (dermis.Receptors(depth="fingertip"), dermis.Receptors(depth=depths), tip.receptors):
        assert dermis.fingertip(receptors=same) == tip
    assert dermis.Scene.from_string(tip.to_toml()) == tip
    assert str(refused(dermis.fingertip, receptors={"depth": "thumb"})) == (
        'receptors.depth = \'thumb\'; allowed: "fingertip", or a table of depths')
    plan = dermis.plan(tip)
    assert 0 < plan.fine_load < 1 and plan.fine_load == dermis.run(tip).report().fine_load.value


def test_maps_of_another_type_or_shape_are_refused_by_name():
    error = refused(dermis.Scene, TABLES, surface={"path": np.ones((9, 12), complex)})
    assert error.parameter == "surface.path"
    assert str(error) == ("surface.path = complex128 array of shape (9, 12); allowed: array of numbers, of shape "
                          "(height, width)")
    error = refused(dermis.Scene, TABLES, load={"path": np.ones((12, 9))})
    assert str(error) == "load.path = array of shape (12, 9); allowed: shape (height, width) = (9, 12)"
    error = refused(dermis.Scene, TABLES, material={"modulus": np.full((9, 12), np.nan)})
    assert error.parameter.startswith("material.modulus")


def test_a_scene_that_is_refused_names_key_value_and_range():
    error = refused(dermis.Scene.from_string, "[time]\nstep = -1")
    assert error.parameter == "time.step" and str(error).startswith("scene:2: time.step = -1; allowed:")
    assert refused(dermis.Scene, grid={"width": object()}).parameter == "grid.width"
    assert refused(dermis.Scene, sites=["sa1"]).parameter == "sites"
    assert refused(dermis.Scene, sites=[("sa1", 500, 0)]).parameter.startswith("sites")


def test_texts_keep_every_character(tmp_path):
    folder = tmp_path / 'a "quoted" \\ \U0001f590 name'
    folder.mkdir()
    np.save(folder / "load.npy", np.ones((9, 12)))
    assert dermis.Scene(TABLES, load={"kind": "file", "path": folder / "load.npy"}).width == 12


def test_paths_may_have_bytes_that_are_not_utf_8(tmp_path):
    folder = os.path.join(os.fsencode(tmp_path), b"\xff\xfe")
    os.mkdir(folder)
    path = os.path.join(folder, b"\xe9.toml")
    with open(path, "w") as file:
        file.write(TEXT)
    assert bits(os.fsdecode(path)) == bits(TABLES)
    with open(os.path.join(folder, b"load.npy"), "wb") as file:
        np.save(file, np.ones((9, 12)))
    load = "\n[load]\nkind = 'file'\npath = 'load.npy'\n"
    grid = "[grid]\nwidth = 12\nheight = 9\n"
    assert dermis.Scene.from_string(grid + load, folder=os.fsdecode(folder)).width == 12
    error = refused(dermis.Scene.from_file, os.fsdecode(path + b".none"))
    assert r"\xff\xfe/\xe9.toml.none: cannot be read" in str(error)
    error = refused(dermis.Scene, TABLES, load={"kind": "file", "path": os.fsdecode(path)})
    assert error.parameter == "load.path" and r"\udcff" in str(error)


def test_sites_stand_in_memory_or_come_by_density():
    sites = [("fa1", 3, 4), ("sa1", 0, 8)]
    assert dermis.Scene(TABLES, sites=sites).sites == sites
    assert len(dermis.fingertip(sites=dermis.Sites(density={"sa1": 70, "sa2": 0, "fa1": 0, "fa2": 0})).sites) == 70


def test_objects_have_the_keys_of_a_scene_file():
    tables = {"grid": dermis.Grid, "surface": dermis.Surface, "material": dermis.Material, "load": dermis.Load,
              "time": dermis.Time, "curvature": dermis.Curvature, "receptors": dermis.Receptors, "sites": dermis.Sites,
              "output": dermis.Output}
    for name, table in tables.items():
        known = re.search(r"known: ([^;]*)", str(refused(dermis.Scene, {name: {"qqqqqqqqqq": 1}}))).group(1)
        assert {f.name for f in dataclasses.fields(table)} == set(known.split(", ")), name


def test_a_preset_is_a_scene_to_begin_with():
    scene = dermis.fingertip(load=dermis.Load(intensity=1e4))
    assert scene.spacing == pytest.approx(1e-4, rel=1)
    assert not dermis.run(scene).report().strain.outside


def test_loads_in_a_list_are_added_up_and_may_be_maps_in_memory():
    half = np.full((10, 12), 0.5)
    tables = {"grid": {"width": 12, "height": 10}, "time": {"step": 0.05, "duration": 0.5}}
    whole = dermis.run(dermis.Scene(tables, load={"path": 2 * half, "envelope": "ramp", "rise": 0.2}))
    sine = dermis.Load(path=half, envelope="ramp", rise=0.2, window=None)
    both = dermis.Scene(tables, load=[sine, {"path": half, "envelope": "ramp", "rise": "200 ms"}])
    for scene in (both, pickle.loads(pickle.dumps(both))):
        np.testing.assert_allclose(dermis.run(scene)["sa1"].max, whole["sa1"].max, rtol=1e-13)
    moving = dermis.Scene(tables, load={"grating": {"wavelength": 4, "velocity": 20, "amplitudes": [0.5]}})
    assert np.ptp(dermis.run(pickle.loads(pickle.dumps(moving)))["fa1"].mean) > 0
    with pytest.raises(dermis.Error, match=r"load\[1\]\.radius = 0"):
        dermis.Scene(tables, load=[{}, {"radius": 0}])


def test_a_scene_equals_its_copies_and_no_other(tmp_path):
    scene = dermis.fingertip(load={"intensity": 1e4})
    other = dermis.fingertip(load={"intensity": 1e4 + 1e-9})
    for same in (copy.copy(scene), copy.deepcopy(scene), pickle.loads(pickle.dumps(scene)), dermis.fingertip(load={"intensity": 1e4})):
        assert same == scene and hash(same) == hash(scene)
    assert scene != other and scene != 3 and len({scene, copy.copy(scene), other}) == 2
