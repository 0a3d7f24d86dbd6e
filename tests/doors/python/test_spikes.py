# SPDX-License-Identifier: MIT
"""Nerve fibres of skins, and the spikes by which they answer."""
import copy
import csv
import pickle
import re
from pathlib import Path

import common
import dermis
import numpy as np
import pytest
from common import device, refused  # noqa: F401

GRID = {"grid": {"width": 20, "height": 25}}
MEMBRANE, REFRACTORY, CURRENT = 0.02, 0.001, 5.0
MODEL = dermis.AfferentModel(time_constants=[1e-3], gains=[(CURRENT, 0), (0, 0), (0, 0)], membrane_time=MEMBRANE,
                             refractory_time=REFRACTORY)
CELLS = [(3, 4), (0, 24)]


def skin_of(n=None, scene=GRID, afferents=(dermis.Afferents(model=MODEL, cells=CELLS),), **keys):
    return common.skin_of(scene, n, control="depth", afferents=afferents, **keys)


def depths(seed, *pads):
    return 0.5 + np.random.default_rng(seed).random((*pads, 25, 20), np.float32)


def test_a_fibre_whose_input_is_held_fires_at_the_rate_of_the_closed_form():
    skin, dt, times = skin_of(), 0.004, []
    held = np.ones((25, 20), np.float32)  # of a thickness of 1: the strain is 1, and the current is CURRENT
    for n in range(1, 101):
        skin.press(held, dt)
        spikes = skin.spikes()
        assert set(spikes["pad"]) <= {0} and set(spikes["frame"]) <= {0}
        times += list((n - 1) * dt + spikes["time"][spikes["afferent"] == 1])
    period = REFRACTORY + MEMBRANE * np.log(CURRENT / (CURRENT - 1))
    settled = np.array(times)[np.array(times) > 0.05]
    assert len(settled) == pytest.approx(0.35 / period, abs=1)
    np.testing.assert_allclose(np.diff(settled), period, rtol=1e-4)


def test_spikes_are_an_array_of_their_own():
    skin = skin_of()
    fields = [("pad", np.int32), ("afferent", np.int32), ("frame", np.int32), ("share", np.float32), ("time", np.float64)]
    assert skin.spikes().shape == (0,) and skin.spikes().dtype == np.dtype(fields)
    skin.press_frames(np.ones((50, 25, 20), np.float32), 0.004)
    spikes = skin.spikes()
    before = spikes.copy()
    assert len(spikes) > 60 and set(spikes["afferent"]) == {0, 1} and spikes["frame"].max() == 49
    assert (spikes["share"] > 0).all() and (spikes["share"] <= 1).all()
    skin.press(np.ones((25, 20), np.float32), 1.0)
    assert len(skin.spikes()) > len(spikes) and (spikes == before).all()
    spikes["frame"] += 50  # it can be written to
    skin.press(np.zeros((25, 20), np.float32), 0)
    assert len(skin.spikes()) == 0 and len(skin_of(afferents=[]).spikes()) == 0


def test_frames_pressed_at_once_give_the_spikes_of_presses():
    at_once, one_by_one = skin_of(2), skin_of(2)
    frames = np.stack([depths(seed, 2) for seed in range(20)])
    at_once.press_frames(frames, 0.003)
    parts = []
    for n, frame in enumerate(frames):
        one_by_one.press(frame, 0.003)
        parts.append(one_by_one.spikes())
        parts[-1]["frame"] += n
        parts[-1]["time"] += n * 0.003
    spikes, joined = at_once.spikes(), np.concatenate(parts)
    np.testing.assert_allclose(joined["time"], spikes["time"], rtol=1e-12)
    joined["time"] = spikes["time"]
    assert len(spikes) > 20 and joined.tobytes() == spikes.tobytes()


def test_pads_have_the_spikes_of_skins_alone_and_are_counted_from_row_to_row():
    batch, singles = skin_of((2, 2)), [skin_of() for _ in range(4)]
    fired = 0
    for n in range(20):
        pressed = [3, 0] if n % 2 else [0, 1, 2, 3]
        frame = depths(n, len(pressed))
        batch.press(frame if n % 2 else frame.reshape(2, 2, 25, 20), 0.003, [(1, 1), (0, 0)] if n % 2 else None)
        expected = []
        for pad, own in zip(pressed, frame):
            singles[pad].press(own, 0.003)
            expected.append(singles[pad].spikes())
            expected[-1]["pad"] = pad
        assert batch.spikes().tobytes() == np.concatenate(expected).tobytes()
        fired += len(batch.spikes())
    assert fired > 40


def test_a_skin_that_is_copied_or_pickled_goes_on_with_the_same_spikes():
    fibres = [dermis.Afferents(model=MODEL, cells=CELLS), dermis.Afferents(type="fa1", cells=CELLS)]
    skin, loaded = skin_of(2, afferents=fibres), skin_of(2, afferents=fibres)
    for n in range(7):
        skin.press(depths(n, 2), 0.003)
    copies = [pickle.loads(pickle.dumps(skin)), copy.copy(skin)]
    loaded.load(skin.save())
    assert not any(len(other.spikes()) for other in copies)
    fired = 0
    for n in range(7, 20):
        for one in (skin, loaded, *copies):
            one.press(depths(n, 2), 0.003)
        assert {one.spikes().tobytes() for one in (loaded, *copies)} == {skin.spikes().tobytes()}
        fired += len(skin.spikes())
    assert fired > 40
    assert refused(skin_of(2).load, skin.save()).parameter == "state"


def test_fibres_of_a_class_lie_in_its_sites_and_follow_strain_or_stress():
    scene = dermis.Scene(GRID, sites=[("fa1", 1, 2), ("sa1", 3, 4), ("fa1", 5, 6)],
                         material={"modulus": 2.0, "viscosity": 1e-6})
    fibres = [dermis.Afferents(type="fa1", model=MODEL), dermis.Afferents(model=MODEL, follow="stress")]
    skin = common.skin_of(scene, afferents=fibres)
    for _ in range(2):
        skin.press(np.full((25, 20), 2, np.float32), 0.1)
    spikes = skin.spikes()
    assert set(spikes["afferent"]) == {0, 1, 2}
    counts = np.bincount(spikes["afferent"])  # the strain of 1 that both come to
    assert counts.min() > 10 and counts.max() - counts.min() <= 1


def test_a_scene_has_fibres_that_a_skin_takes_unless_it_is_given_others():
    scene = dermis.Scene(GRID, afferents=[dermis.Afferents(model=MODEL, cells=CELLS)])
    assert len(dermis.Scene(GRID, sites=[("sa1", 1, 1)], afferents=[{"type": "sa1"}]).afferents) == 1  # of this site
    (fibres,) = pickle.loads(pickle.dumps(scene)).afferents
    assert repr(fibres) == repr(dermis.Afferents(model=MODEL, cells=CELLS)) and dermis.Scene(GRID).afferents == []
    given, of_scene, without = skin_of(), skin_of(scene=scene, afferents=None), skin_of(scene=scene, afferents=[])
    for skin in (given, of_scene, without):
        skin.press(np.ones((25, 20), np.float32), 0.1)
    assert given.spikes().tobytes() == of_scene.spikes().tobytes() and len(given.spikes()) > 10
    assert len(without.spikes()) == 0


def test_models_and_fibres_say_what_they_are():
    model = dermis.afferent_model("sa1")
    assert len(model.time_constants) == 2 and model.frequency is None and len(model.after) == 2
    model.frequency, model.quality, model.after = 100.0, 0.7, [(-3.0, 0.02)]
    model.gains = np.array([[2, 1], [0, 0], [0, 0]])
    assert (model.frequency, model.after[0], model.gains[0]) == (100.0, (-3.0, 0.02), (2.0, 1.0))
    model.frequency = model.quality = None
    fibres = dermis.Afferents(type="sa1", model=model, cells=np.array(CELLS))
    assert fibres.cells == tuple(CELLS) and fibres.follow == "strain" and fibres.type == "sa1"
    fibres.model.reset = 0.25
    assert fibres.endings == 1 and dermis.Afferents(cells=CELLS, endings=2).endings == 2
    assert fibres.model.reset == 0.25 and model.reset == 0 and dermis.Afferents(cells=CELLS).model is None
    for thing in (model, fibres):
        assert repr(pickle.loads(pickle.dumps(thing))) == repr(copy.deepcopy(thing)) == repr(thing)
    assert f"membrane_time={model.membrane_time!r}" in repr(fibres) and "cells=((3, 4), (0, 24))" in repr(fibres)


def model_with(**keys):
    given = {"time_constants": [1e-3], "membrane_time": MEMBRANE, "refractory_time": REFRACTORY, **keys}
    return lambda: skin_of(afferents=[dermis.Afferents(cells=CELLS), dermis.Afferents(
        model=dermis.AfferentModel(**given), cells=CELLS)])


ANSWERS = [
    (model_with(membrane_time=0), "afferents[1].membrane_time = 0; allowed: a finite number > 0"),
    (model_with(gains=[(1, 0)]), "gains = [(1, 0)]; allowed: three pairs of numbers"),
    (model_with(gains=5), "gains = 5; allowed: a list of pairs (pairs for y"),
    (model_with(after=[(1, 1)] * 3), "after = 3 pairs; allowed: at most two pairs (amplitude, time)"),
    (model_with(after=[1]), "after = 1; allowed: at most two pairs"),
    (model_with(after=[(1, 0)]), "afferents[1].after.time = 0"),
    (model_with(time_constants="1 ms"), "time_constants = '1 ms'; allowed: a list of numbers"),
    (model_with(membrane="1 ms"), "membrane = '1 ms'; allowed: the arguments time_constants, frequency"),
    (lambda: dermis.AfferentModel(refractory_time=1), "membrane_time = (not given); allowed: a number (s, > 0)"),
    (lambda: setattr(copy.copy(MODEL), "reset", "a"), "reset = 'a'; allowed: a number < 1"),
    (lambda: setattr(copy.copy(MODEL), "frequency", "a"), "frequency = 'a'; allowed: Hz, > 0"),
    (lambda: dermis.Afferents(type="sa3"), 'type = "sa3"; allowed: sa1, sa2, fa1, fa2'),
    (lambda: dermis.Afferents(type=3), "type = 3; allowed: a text"),
    (lambda: dermis.Afferents(model={}), "model = {}; allowed: an AfferentModel or None"),
    (lambda: dermis.Afferents(cells=[(1, 2, 3)]), "cells = (1, 2, 3); allowed: a list of cells"),
    (lambda: dermis.Afferents(cells=np.ones((2, 2))), "cells = float64 array of shape (2,); allowed: a list of cells"),
    (lambda: dermis.Afferents(cells=5), "cells = 5; allowed: a list of cells or an array"),
    (lambda: dermis.Afferents(follow="pain"), 'follow = "pain"; allowed: "strain", "stress"'),
    (lambda: dermis.afferent_model("sa2"), '"sa2"; allowed: sa1, fa1, fa2'),
    (lambda: dermis.afferent_model(), "type = (not given); allowed: a text"),
    (lambda: dermis.Afferents(seed=2**40), "seed = 1099511627776; allowed: a whole number (-1e9..1e9"),
    (lambda: skin_of(afferents=[{"cells": CELLS}]), "afferents = {'cells': [(3, 4), (0, 24)]}; allowed: a list of"),
    (lambda: skin_of(afferents=5), "afferents = 5; allowed: a list of Afferents or None"),
    (lambda: dermis.Scene(GRID, afferents=[dermis.Afferents(), {}]), "afferents = {}; allowed: a list of Afferents"),
]


@pytest.mark.parametrize("call, words", ANSWERS, ids=[words for _, words in ANSWERS])
def test_a_mistake_is_answered_by_parameter_value_and_what_is_allowed(call, words):
    assert words in str(refused(call))


def test_the_parameters_of_a_class_are_those_that_were_fitted():
    lines = (Path(__file__).parents[3] / "bench/evidence/afferents.csv").read_text().splitlines()
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    assert len(rows) > 20
    for row in rows:
        model, name = dermis.afferent_model({"ra": "fa1", "pc": "fa2"}.get(row["class"], row["class"])), row["parameter"]
        if name in ("finger_curvature", "endings", "radius", "field_gain"):
            continue  # not of the model
        member, *places = re.findall(r"\w+", "sensitivity" if name == "threshold_gain" else name)
        found = getattr(model, member)
        for place in places:
            found = found[int(place)]
        assert found == float(row["value"]), row


def test_a_run_has_the_spikes_of_its_scene():
    scene = {"grid": {"width": 20, "height": 25}, "load": {"intensity": 5.0}, "time": {"step": 0.001, "duration": 0.3},
             "afferents": [{"type": "fa1", "cells": [[10, 12], [9, 12]], "gains": [[20, 0]]}]}
    result = dermis.run(scene)
    spikes = result.spikes
    assert spikes.dtype.names == ("time", "afferent") and len(spikes) > 2 and set(spikes["afferent"]) == {0, 1}
    assert (np.diff(spikes["time"]) >= 0).all() and 0 < spikes["time"][0] and spikes["time"][-1] <= 0.3
    assert pickle.loads(pickle.dumps(result)).spikes.tobytes() == spikes.tobytes()
    assert len(dermis.run({"grid": {"width": 20, "height": 25}}).spikes) == 0
