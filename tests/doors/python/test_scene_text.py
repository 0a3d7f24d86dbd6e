# SPDX-License-Identifier: MIT
"""Scenes that can be read: their tables as objects, and as a text from which an equal scene is read."""
import copy
import pathlib
import random
import re

import dermis
import numpy as np
import pytest

ROWS: dict[str, list] = {}  # of each table, with a dot: (key, allowed, type)
for table, name, _, _, allowed, _, kind in dermis._core.key_rows():
    ROWS.setdefault(table, []).append((name, allowed, kind))
# Keys by which a file says in another way what a scene has: its map, its cells, its numbers.
BY_ANOTHER = {"preset", "surface.high", "surface.spacing", "load.high", "load.texture.high", "load.taxels.sampling_rate",
              "material.relaxation", "sites.path", "sites.density", "sites.seed",
              *(f"sites.density.{kind}" for kind in ("sa1", "sa2", "fa1", "fa2"))}
MAP = np.random.default_rng(1).random((9, 12))
SMALL = {"grid": {"width": 12, "height": 9}, "surface": {"kind": "wave"}}
METRES = {"grid": {"width": 12, "height": 9, "spacing": 1e-4}, "surface": {"relief": 1e-5},
          "material": {"modulus": 3e4, "viscosity": 1e3, "thickness": 1e-3, "curvature_length": 1e-5}}
DEPTH = METRES | {"load": {"kind": "circular", "control": "depth", "intensity": 1e-5}}
FIBRES = SMALL | {"sites": [("fa2", 3, 4), ("sa1", 0, 8)]}
BASES = [
    SMALL, METRES, DEPTH,
    SMALL | {"load": {"envelope": "ramp", "rise": 0.3}},
    SMALL | {"load": {"envelope": "sine", "frequency": 2.5, "phase": -0.0, "mean": 0.1, "amplitude": -1e-300}},
    SMALL | {"load": {"envelope": "pulse", "length": 0.2, "period": 0.5}},
    SMALL | {"load": {"envelope": "table", "times": [0.1, 0.25], "values": [1.0, -0.0]}},
    SMALL | {"load": {"envelope": "sine", "window": {"start": 0.1, "until": 2.0}}},
    SMALL | {"load": {"path": MAP}}, SMALL | {"load": [{"path": MAP}, {"envelope": "ramp"}]},
    SMALL | {"surface": {"path": MAP}}, SMALL | {"material": {"modulus": MAP + 1, "viscosity": MAP + 2}},
    SMALL | {"material": {"elements": [{"modulus": MAP + 1, "viscosity": 1.5}, {"viscosity": MAP + 1}], "dashpot": 2.0}},
    SMALL | {"material": {"elements": [{"modulus": 1.5, "viscosity": 0.1}], "spring": 3.0}},
    SMALL | {"material": {"relaxation": {"moduli": [1.0, 2.0], "times": [0.1, 1.0], "equilibrium": 0.5}}},
    SMALL | {"load": {"grating": {"wavelength": 5.5, "amplitudes": [0.5, -0.0], "phases": [0.1, 1e5], "velocity": -3.0}}},
    METRES | {"surface": {"kind": "wave", "relief": 1e-5, "ridge_period": 5e-4}}, SMALL | {"load": {"texture": {"path": MAP[:5], "spacing": 1.5, "velocity": [0.5, -2.0]}}},
    SMALL | {"load": {"contact": "crests", "contact_share": 0.25, "contact_length": 3.0}},
    METRES | {"receptors": {"depth": {"sa1": 3e-4}}}, DEPTH | {"receptors": {"follow": {"sa1": "stress"}}},
    METRES | {"load": {"kind": "punch", "radius_y": 2, "control": "depth", "intensity": 1e-5}},
    METRES | {"load": {"kind": "ball", "control": "depth", "ball_radius": 1e-3, "intensity": 1e-5, "envelope": "ramp"}, "output": {"traces": ["sa1"]}},
    SMALL | {"output": {"fields": [{"at": 0.5, "what": ["sa1"]}]}}, FIBRES, FIBRES | {"afferents": [{"type": "sa1"}]},
    FIBRES | {"afferents": [{"type": "fa2", "frequency": 200.0, "quality": 1.0, "time_constants": [1e-3],
                              "membrane_time": 2e-3, "refractory_time": 1e-3, "gains": [[0.5, -0.0]], "after": [{"amplitude": -1.0, "time": 0.1}]}]},
    FIBRES | {"afferents": [{"type": "sa1", "follow": "strain", "endings": 3, "radius": 2.5, "seed": 4, "sensitivity": "median",
                              "spread": 0.5}]},
    FIBRES | {"afferents": [{"type": "sa1"}, {"type": "fa2", "cells": [[3, 4], [0, 8]], "endings": 2}]},
    dermis.fingertip(),
]


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("frames")
    np.save(folder / "frames.npy", np.ones((3, 9, 12)))
    (folder / "taxels.csv").write_text("t,a,b\n0,1,2\n1,3,4\n")
    return [SMALL | {"load": {"kind": "sequence", "path": folder / "frames.npy", "interval": 0.1}},
            SMALL | {"load": {"kind": "sequence", "path": folder / "taxels.csv", "interval": 0.1, "taxels": {
                "spacing": 2, "unit": 1.0, "offset": "first", "columns": 2, "rows": 1, "skip": 1,
                "origin": [1.5, 2.5], "spread": "cubic"}}}]


def drawn(draw, table, name, allowed, kind):
    """A value that the key may have, of its type."""
    number = draw.choice([0.0, -0.0, 0.5, 1.0, draw.random(), 10**draw.uniform(-8, 8), -draw.random(), 5e-324, 1.5e300])
    if kind.startswith("Literal"):
        return draw.choice(re.findall('"(.*?)"', kind))
    if kind.startswith("Sequence[Literal"):
        return draw.sample(re.findall('"(.*?)"', kind), 2)
    if "Mapping" in kind:
        made = {row[0]: drawn(draw, f"{table}{name}.", *row) for row in ROWS[f"{table}{name}."] if draw.random() < 0.7}
        return [made] if "Sequence" in kind else made
    return {"bool": lambda: draw.random() < 0.5, "int": lambda: draw.randint(0, 12), "CellOrPlace": lambda: draw.randint(0, 8),
            "NumberOrMap": lambda: draw.choice([number, MAP + 1]), "MapOrFile": lambda: MAP, "str": lambda: "none",
            "Numbers": lambda: sorted(draw.random() for _ in range(2)), "float | str": lambda: draw.choice([number, "first"]),
            "Cells": lambda: [[draw.randint(0, 11), 3]], "Sequence[CellOrPlace]": lambda: [draw.randint(0, 11), 3],
            "Sequence[Numbers]": lambda: [[draw.random(), number]],
            }.get(kind, lambda: number)()


def changed(draw, base):
    """The tables of a base with one or two more keys of any table, which need not be allowed."""
    tables = copy.deepcopy(base)
    for _ in range(draw.randint(1, 2)):
        table = draw.choice([t for t in ROWS if not t.startswith("sites.")])
        to = tables
        for part in table.split(".")[:-1]:  # the first item of a list
            to = to.setdefault(part, [{}] if part in ("afferents", "fields", "elements") else {})
            to = to[0] if isinstance(to, list) else to
        if isinstance(to, str):  # receptors.depth = "fingertip"
            continue
        row = draw.choice(ROWS[table])
        to[row[0]] = drawn(draw, table, *row)
    return tables


def keys_of(tables, prefix=""):
    """The dotted names of the keys of some tables."""
    for key, value in tables.items():
        yield prefix + key
        for inner in value if isinstance(value, list) else [value]:
            if isinstance(inner, dict):
                yield from keys_of(inner, f"{prefix}{key}.")


def test_a_scene_of_any_keys_is_read_from_its_text_as_an_equal_scene(tmp_path, files):
    draw, seen, equal = random.Random(1), set(), 0
    for i in range(12000):
        base = (BASES + files)[i % len(BASES + files)]
        try:
            tables = base if i < len(BASES + files) or isinstance(base, dermis.Scene) else changed(draw, base)
            scene = tables if isinstance(tables, dermis.Scene) else dermis.Scene(tables)
        except dermis.Error:
            assert i >= len(BASES + files), base
            continue
        text = scene.to_toml(tmp_path)
        assert dermis.Scene.from_string(text, folder=tmp_path) == scene, text
        equal += 1
        if isinstance(tables, dict):
            seen.update(keys_of(tables))
    known = {table + row[0] for table, rows in ROWS.items() for row in rows}
    forgotten = known - seen - BY_ANOTHER
    assert not forgotten, sorted(forgotten)
    assert equal > 1500


def test_the_tables_of_a_scene_are_objects_that_make_it_again():
    names = ("grid", "surface", "material", "load", "time", "curvature", "receptors", "output", "afferents", "sites")
    for base in BASES:
        scene = dermis.Scene(base) if isinstance(base, dict) else base
        top = {key: value for key, value in (base.items() if isinstance(base, dict) else ()) if key not in names}
        assert dermis.Scene({name: getattr(scene, name) for name in names if getattr(scene, name) != []} | top) == scene
    scene = dermis.fingertip(load=[{"intensity": "2 kPa"}, {"intensity": 1.0}])
    assert isinstance(scene.material, dermis.Material) and isinstance(scene.material.elements[0], dermis.KelvinVoigt)
    assert scene.grid == dermis.Grid(width=100, height=100, spacing=1e-4) or scene.grid.spacing
    assert [load.intensity for load in scene.load] == [2000.0, 1.0]
    assert dermis.Skin(scene).scene.grid == scene.grid and scene.surface.path is None


def test_a_map_of_a_table_is_the_map_that_was_given():
    scene = dermis.Scene(SMALL, surface={"path": MAP}, load={"texture": {"path": MAP[:5]}})
    np.testing.assert_array_equal(scene.surface.path, MAP)
    np.testing.assert_array_equal(scene.load.texture["path"], MAP[:5])


def test_a_text_without_a_folder_refuses_a_map_by_its_key():
    scene = dermis.Scene(SMALL, surface={"path": MAP})
    with pytest.raises(dermis.InputError, match=r"surface.path = a map in memory; allowed: .*to_toml\(folder\)"):
        scene.to_toml()
    assert "ridges = 3.0" in dermis.Scene(SMALL, surface={"kind": "wave", "ridges": 3}).to_toml()


def test_what_no_text_says_is_refused(tmp_path):
    heights = np.random.default_rng(1).random((24, 18))
    np.save(tmp_path / "fine.npy", heights)
    scene = dermis.Scene(METRES, surface={"kind": "file", "path": tmp_path / "fine.npy", "spacing": 0.7e-4, "relief": 1e-5})
    with pytest.raises(dermis.InputError, match="surface.path = heights that were read with surface.spacing"):
        scene.to_toml(tmp_path)
    model = dermis.AfferentModel(time_constants=[1e-3], membrane_time=1e-3, refractory_time=1e-3)
    scene = dermis.Scene(SMALL, afferents=[dermis.Afferents(type="fa2", model=model, cells=[(1, 1)])])
    with pytest.raises(dermis.InputError, match=r"afferents\[0\].frequency = \(not given\)"):
        scene.to_toml()


def test_the_text_of_a_scene_is_a_file_of_the_command(tmp_path):
    scene = dermis.Scene(SMALL, load={"path": MAP}, time={"step": 0.1, "duration": 0.5})
    pathlib.Path(tmp_path / "scene.toml").write_text(scene.to_toml(tmp_path))
    again = dermis.run(tmp_path / "scene.toml")
    assert again.scene == scene and np.array_equal(again["sa1"].max, dermis.run(scene)["sa1"].max)


def test_each_load_has_a_file_of_its_own_map(tmp_path):
    ramp = np.arange(1.0, 13.0).reshape(3, 4)
    scene = dermis.Scene(grid={"width": 4, "height": 3}, load=[{"path": ramp}, {"path": 2 * ramp}])
    assert dermis.Scene.from_string(scene.to_toml(tmp_path), folder=tmp_path) == scene


@pytest.mark.parametrize("name", ["it's", 'a "b"', "Fühler", "日本", "a\x7fb"])
def test_a_path_of_any_letters_stands_in_a_text(tmp_path, name):
    np.save(tmp_path / f"{name}.npy", np.ones((2, 3, 4)))
    scene = dermis.Scene(grid={"width": 4, "height": 3},
                         load={"kind": "sequence", "path": tmp_path / f"{name}.npy", "interval": 0.1})
    assert dermis.Scene.from_string(scene.to_toml()) == scene


def test_a_folder_that_takes_no_file_is_an_error(tmp_path):
    scene = dermis.Scene(grid={"width": 4, "height": 3}, load={"path": np.ones((3, 4))})
    with pytest.raises(FileNotFoundError):
        scene.to_toml(tmp_path / "none")
