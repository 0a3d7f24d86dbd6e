# SPDX-License-Identifier: MIT
"""Depth images, pressures, responses, spike counts and states as tensors, and the time of a skin.

By day with NumPy and JAX; `./run trust networks` has torch too.
"""
import copy
import importlib.util
import pickle

import dermis
import numpy as np
import pytest
from dermis import contact

E, P, ROWS, COLUMNS, DT = 3, 2, 5, 4, 2e-3
SCENE = dermis.fingertip(grid={"width": COLUMNS, "height": ROWS, "spacing": 1e-3}, surface={"kind": "flat"})
MODEL = dermis.AfferentModel(time_constants=[1e-3], gains=[(400, 0), (0, 0), (0, 0)], membrane_time=0.02, refractory_time=1e-3)
FIBRES = [dermis.Afferents(type="fa1", model=MODEL, cells=[(1, 2), (3, 4), (0, 0)]),
          dermis.Afferents(type="sa1", model=MODEL, cells=[(2, 2), (3, 3)], endings=2)]
DEPTHS = 3e-4 * np.random.default_rng(5).random((9, E, P, ROWS, COLUMNS), np.float32)
needs = {name: pytest.mark.skipif(not importlib.util.find_spec(name), reason=f"{name} is not installed") for name in ("torch", "jax")}


def skin_of(count=(E, P), **keys):
    return dermis.Skin(SCENE, count, **{"control": "depth", "afferents": FIBRES, "responses": ["sa1", "fa1"], **keys})


def of_numpy(array):
    return array


def of_torch(array):
    import torch
    return torch.from_numpy(array)


def address(tensor):
    return tensor.data_ptr() if hasattr(tensor, "data_ptr") else tensor.ctypes.data


def refused(call, *words):
    with pytest.raises(dermis.InputError) as caught:
        call()
    assert caught.value.parameter == "out" and all(word in str(caught.value) for word in words), caught.value


@pytest.mark.parametrize("made", [of_numpy, pytest.param(of_torch, marks=needs["torch"])])
def test_depth_images_come_in_and_responses_counts_and_states_fill_the_callers_memory(made):
    skin, other = skin_of(), skin_of()
    sa1, counts = made(np.full((E, P, ROWS, COLUMNS), np.nan, np.float32)), made(np.full((E, P, 4), np.nan, np.float32))
    state = made(np.zeros(len(skin.save()), np.uint8))
    before, fired = [address(tensor) for tensor in (sa1, counts, state)], 0
    for depth in DEPTHS:
        skin.press(made(depth), DT, out={"sa1": sa1})
        other.press(depth, DT)
        assert np.array_equal(np.asarray(sa1), other["sa1"]) and skin.spike_counts(out=counts) is counts
        assert np.array_equal(np.asarray(counts), other.spike_counts())
        fired += other.spike_counts().sum()
    assert fired > 20 and skin.save(out=state) is state and np.asarray(state).tobytes() == other.save()
    assert [address(tensor) for tensor in (sa1, counts, state)] == before
    fresh = skin_of()
    fresh.load(state)
    fresh.press(DEPTHS[0], DT)
    skin.press(DEPTHS[0], DT)
    assert np.array_equal(fresh["fa1"], skin["fa1"]) and fresh.spikes().tobytes() == skin.spikes().tobytes()
    part = made(np.zeros(len(skin.save(1)), np.uint8))
    assert np.asarray(skin.save(1, out=part)).tobytes() == skin.save(1)


@needs["torch"]
def test_a_response_is_a_tensor_of_torch_that_shows_each_press():
    import torch
    skin = skin_of()
    shared = torch.from_dlpack(skin["fa1"])
    for depth in DEPTHS[:3]:
        skin.press(torch.from_numpy(depth), DT)
        assert shared.any() and np.array_equal(shared.numpy(), skin["fa1"])
    touch = contact.Touch(dermis.Skin(SCENE, (E, P)), 1e-3)
    force = torch.tensor([0.0, 0.0, -0.1]).expand(E, P, 3)
    assert touch.add_depths(torch.from_numpy(DEPTHS[0]), force, gaps=False).placed == pytest.approx(0.6)


class LikeJax(np.ndarray):
    """An array that cannot be written to, whose DLPack is older than the flag that says so."""

    def __dlpack__(self, **_):
        writable = np.asarray(memoryview(bytearray(self.nbytes))).view(np.float32).reshape(self.shape)
        return writable.__dlpack__()


def of_jax(array):
    import jax
    return jax.numpy.array(array)


def locked(array):
    array = array.copy()
    array.flags.writeable = False
    return array


@pytest.mark.parametrize("made", [locked, lambda a: locked(a).view(LikeJax), pytest.param(of_jax, marks=needs["jax"])],
                         ids=["numpy", "like jax", "jax"])
def test_an_out_that_cannot_be_written_is_refused_by_name_and_stays(made):
    skin = skin_of()
    skin.press(DEPTHS[0], DT)
    kept = skin.save()
    sa1, counts = made(np.full((E, P, ROWS, COLUMNS), 7, np.float32)), made(np.full((E, P, 4), 7, np.float32))
    refused(lambda: skin.press(DEPTHS[1], DT, out={"sa1": sa1}), "read-only float32 array of shape (3, 2, 5, 4); allowed")
    refused(lambda: skin.press_frames(DEPTHS, DT, out={"sa1": sa1}), "read-only float32 array", "that can be written")
    refused(lambda: skin.spike_counts(out=counts), "read-only float32 array of shape (3, 2, 4); allowed")
    assert skin.save() == kept and (np.asarray(sa1) == 7).all() and (np.asarray(counts) == 7).all()
    with pytest.raises(dermis.InputError, match="pressure = .*; allowed: .* that can be written"):
        contact.Pad(made(np.zeros((ROWS, COLUMNS), np.float32)), 1e-3)
    if made is not locked and made is not of_jax:
        return
    state = made(np.zeros(len(kept), np.uint8))
    refused(lambda: skin.save(out=state), f"read-only uint8 array of shape ({len(kept)},); allowed")
    assert not np.asarray(state).any()


def test_an_out_of_another_shape_or_type_is_refused_and_stays():
    skin = skin_of()
    size = len(skin.save())
    for wrong in (np.ones((E, P, 3), np.float32), np.ones((E, P, 4)), np.ones((E, P, 4), np.int32), np.ones(E * P * 4, np.float32),
                  np.ones((E, P, 8), np.float32)[:, :, ::2], [0.0] * 24, "counts", np.ma.ones((E, P, 4), np.float32)):
        refused(lambda: skin.spike_counts(out=wrong), "allowed: float32 array in C order that can be written, of shape (3, 2, 4)")
        assert not isinstance(wrong, np.ndarray) or (wrong == 1).all()
    for wrong in (np.ones(size - 1, np.uint8), np.ones(size, np.int8), np.ones(2 * size, np.uint8)[::2], bytes(size)):
        refused(lambda: skin.save(out=wrong), f"allowed: uint8 array in C order that can be written, of shape ({size},)")
    assert np.array_equal(np.frombuffer(skin.save(out=bytearray(size)), np.uint8), np.frombuffer(skin.save(), np.uint8))


@needs["jax"]
def test_arrays_of_jax_go_in_and_new_ones_are_made_of_what_comes_out():
    import jax
    skin, other = skin_of(), skin_of()
    made = []
    for depth in DEPTHS:
        skin.press(of_jax(depth), DT)
        other.press(depth, DT)
        made.append((jax.numpy.array(skin["sa1"]), other["sa1"].copy()))
    assert all(np.array_equal(new, old) and new.any() for new, old in made)
    skin.load(of_jax(np.frombuffer(other.save(), np.uint8)))
    assert skin.save() == other.save()


def test_fibres_are_the_classes_of_afferents_by_their_numbers():
    assert skin_of().fibres.tolist() == ["fa1"] * 3 + ["sa1"] and skin_of(None, afferents=[]).fibres.shape == (0,)
    scene = dermis.fingertip(
        grid={"width": 20, "height": 20, "spacing": 5e-4}, surface={"kind": "flat"}, receptors={"depth": "fingertip"},
        sites=[("fa1", 1, 2), ("sa1", 3, 4), ("fa1", 15, 6)],
        afferents=[{"type": "sa1"}, {"type": "fa1", "radius": 1e-3, "endings": 3}, {"type": "fa2", "cells": [[1, 2]]}])
    assert dermis.Skin(scene, 2).fibres.tolist() == ["sa1", "fa1", "fa1", "fa2"]


@pytest.mark.parametrize("count", [None, 1, 3, (3, 2)])
def test_spike_counts_are_the_spikes_of_the_last_call_by_pad_and_fibre(count):
    skin, pads = skin_of(count), () if count is None else (count,) if isinstance(count, int) else count
    depth = DEPTHS.reshape(9, -1, ROWS, COLUMNS)[:, :int(np.prod(pads))].copy().reshape(9, *pads, ROWS, COLUMNS)
    assert skin.spike_counts().shape == (*pads, 4) and not skin.spike_counts().any()
    skin.press_frames(depth, DT)
    of_frames = skin.spike_counts()
    by_press = np.zeros((*pads, 4), np.float32)
    one_by_one = skin_of(count)
    for frame in depth:
        one_by_one.press(frame, DT)
        by_press += one_by_one.spike_counts()
    assert of_frames.dtype == np.float32 and np.array_equal(of_frames, by_press) and of_frames.sum() == len(skin.spikes()) > 3
    for spike in skin.spikes():
        of_frames.reshape(-1, 4)[spike["pad"], spike["afferent"]] -= 1
    assert not of_frames.any()
    skin.press(depth[0], 0)
    assert not skin.spike_counts().any() and skin_of(count, afferents=[]).spike_counts().shape == (*pads, 0)


def test_a_spike_has_the_seconds_from_the_beginning_of_the_call_that_its_pad_was_pressed_for():
    steps = np.array([[1e-3, 2e-3], [3e-3, 0.0], [0.5e-3, 4e-3]])
    skin = skin_of()
    for depth in DEPTHS:
        skin.press(depth, steps)
    skin.press(DEPTHS[0][1], steps[1], 1)
    skin.press(DEPTHS[1], 5 * steps)
    skin.reset()  # changes no spike
    spikes = skin.spikes()
    assert len(spikes) > 5 and (spikes["time"] == spikes["share"].astype(float) * (5 * steps).ravel()[spikes["pad"]]).all()
    skin.press_frames(DEPTHS, DT)
    spikes = skin.spikes()
    assert set(spikes["frame"]) >= {3, 8} and (spikes["time"] == (spikes["frame"] + spikes["share"].astype(float)) * DT).all()


def test_the_time_of_a_pad_is_the_sum_of_its_steps_since_it_was_made_reset_or_loaded():
    skin, expected = skin_of(), np.zeros((E, P))

    def same():
        return np.array_equal(skin.time, expected)

    skin.press(DEPTHS[0], 2.0**-9)
    expected += 2.0**-9
    before = skin.time
    skin.press(DEPTHS[0][1], np.array([0.5, 0.25]), 1)
    expected[1] += 0.5, 0.25
    skin.press_frames(np.ascontiguousarray(DEPTHS[:, 2:, 1]), 2.0**-10, [(2, 1)])
    expected[2, 1] += 9 * 2.0**-10
    assert same() and (before == 2.0**-9).all() and skin.time.dtype == np.float64
    for wrong in (lambda: skin.press(DEPTHS[0], -1.0), lambda: skin.press(np.nan * DEPTHS[0], 1.0), lambda: skin.reset(7),
                  lambda: skin.press(DEPTHS[0], 1.0, out={"sa1": np.zeros(3)}), lambda: skin.load(b"", 1)):
        with pytest.raises(dermis.Error):
            wrong()
    assert same()
    for branch in (copy.copy(skin), pickle.loads(pickle.dumps(skin))):
        branch.press(DEPTHS[0], 0.125)
        assert np.array_equal(branch.time, expected + 0.125) and same()
    skin.reset((1, 0))
    expected[1, 0] = 0
    skin.load(skin.save(2), 2)
    expected[2] = 0
    assert same() and expected.any()
    one = skin_of(None, afferents=[])
    one.press(DEPTHS[0, 0, 0], 0.5)
    assert isinstance(one.time, float) and one.time == 0.5


def test_a_touch_and_cells_alone_take_time_too():
    skin = dermis.Skin(SCENE, 2)
    touch = contact.Touch(skin, 1e-3)
    touch.add_depths(DEPTHS[0, 0], [[0, 0, -0.1], [0, 0, 0]], gaps=False)
    skin.press(touch, 0.25)  # the other pad rests
    skin.press_cells(np.zeros((2, ROWS * COLUMNS), np.float32), 0.5)
    assert skin.time.tolist() == [0.75, 0.75]


@pytest.mark.parametrize("change", [lambda d: d.tolist(), lambda d: d.astype(np.int64), lambda d: d.astype(np.uint8).tolist(),
                                    lambda d: d.astype(np.int16)[:, :, ::-1][:, :, ::-1]])
def test_depth_images_may_be_lists_and_whole_numbers(change):
    touch = contact.Touch(dermis.Skin(SCENE, 2), 1e-3)
    depth = np.arange(2 * ROWS * COLUMNS, dtype=np.float32).reshape(2, ROWS, COLUMNS) % 7
    expected = touch.add_depths(depth, np.array([[0, 0, -1.0], [0, 0, -2.0]]), gaps=False)
    pressure = touch.pressure.copy()
    report = touch.add_depths(change(depth), [[0, 0, -1], [0, 0, -2]], gaps=False)
    assert repr(report) == repr(expected) and np.array_equal(touch.pressure, pressure) and pressure.any()
    for wrong in (np.ma.array(depth), depth > 3, depth.astype(complex), [[1, 2], [3]], "deep", depth.astype(str).tolist()):
        with pytest.raises(dermis.InputError, match="^depth = .*; allowed: numbers of shape"):
            touch.add_depths(wrong, [[0, 0, -1], [0, 0, -2]], gaps=False)
    with pytest.raises(dermis.InputError, match="^force = masked array"):
        touch.add_depths(depth, np.ma.array([[0, 0, -1.0], [0, 0, -2.0]]), gaps=False)
