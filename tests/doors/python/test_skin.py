# SPDX-License-Identifier: MIT
"""Skins pressed frame by frame."""
import array
import ctypes
import pickle
import re
import subprocess
import sys
import threading
import warnings

import dermis
import numpy as np
import pytest
from common import address, device, refused, skin_of  # noqa: F401

GRID = {"grid": {"width": 20, "height": 25}, "surface": {"kind": "wave", "ridges": 4}}
CLASSES = ("sa1", "sa2", "fa1", "fa2")
RNG = np.random.default_rng(7)


def pressures(*shape):
    return RNG.random(shape, np.float32)


def test_a_response_is_a_view_of_the_same_memory_after_each_press():
    skin = skin_of(GRID)
    fa1 = skin["fa1"]
    assert fa1.shape == (25, 20) and fa1.dtype == np.float32 and not fa1.any() and not fa1.flags.writeable
    skin.press(np.ones((25, 20), np.float32), 0.01)
    assert fa1.all() and address(skin["fa1"]) == address(fa1)


def test_a_view_outlives_its_skin():
    skin = skin_of(GRID)
    skin.press(np.ones((25, 20), np.float32), 0.01)
    fa1 = skin["fa1"]
    before = fa1.copy()
    del skin
    np.testing.assert_array_equal(fa1, before)


@pytest.mark.parametrize("pads", [[2, 0], (2, 0), np.array([2, 0]), np.array([2, 0], np.uint16),
                                  np.array([True, False, True])])
def test_some_pads_are_pressed_and_the_others_stay(pads):
    skin = skin_of(GRID, 3)
    skin.press(np.ones((2, 25, 20), np.float32), 0.01, pads)
    sa1 = skin["sa1"]
    assert sa1[0].all() and not sa1[1].any() and sa1[2].all()
    skin.reset(pads)
    skin.press(np.zeros((3, 25, 20), np.float32), 0.01)
    assert not skin["sa1"].any()


def test_frames_pressed_at_once_give_the_bits_of_presses():
    at_once, one_by_one = skin_of(GRID, 2), skin_of(GRID, 2)
    frames = np.random.default_rng(3).random((5, 2, 25, 20), np.float32)
    out = {"fa1": np.empty((2, 25, 20), np.float32)}
    at_once.press_frames(frames, 0.01, out=out)
    for frame in frames:
        one_by_one.press(frame, 0.01)
    for name in CLASSES:
        assert at_once[name].tobytes() == one_by_one[name].tobytes()
    assert out["fa1"].tobytes() == one_by_one["fa1"].tobytes()
    of_one = np.ascontiguousarray(frames[:, :1])
    at_once.press_frames(of_one, 0.01, [1])
    wrong = "float32 array of shape (5, 1, 25, 20); allowed: float32 array in C order, of shape (frames, 2, 25, 20) in Pa"
    assert str(refused(at_once.press_frames, of_one, 0.01)) == f"pressure = {wrong}"
    assert refused(at_once.press_frames, frames, [0.01]).parameter == "dt"
    frames[3, 1, 2, 4] = np.inf
    assert "inf in cell [4, 2] of pad 1 of frame 3" in str(refused(at_once.press_frames, frames, 0.01))


def test_the_cells_that_sites_read_are_enough():
    sites = GRID | {"sites": [("sa1", 3, 4), ("fa1", 9, 20)]}
    whole, listed = skin_of(sites, 2), skin_of(sites, 2)
    cells = np.array(listed.cells)
    frames = np.random.default_rng(4).random((3, 2, 25, 20), np.float32)
    for frame in frames:
        whole.press(frame, 0.01)
        listed.press_cells(np.ascontiguousarray(frame.reshape(2, 500)[:, cells]), 0.01)
    assert len(cells) == 10 and whole["fa1"].any()
    for name in ("sa1", "fa1"):
        assert whole[name].tobytes() == listed[name].tobytes()
    assert refused(listed.press_cells, frames[0], 0.01).parameter == "pressure"
    assert refused(listed.press_cells, [1.0], 0.01).parameter == "pressure"
    assert refused(listed.press_cells, np.ones(20, np.float32), None).parameter == "dt"


MATERIAL = {"modulus": 2.0, "viscosity": 1.0}


@pytest.mark.parametrize("pads", [None, [0, 1], np.array([True, True])])
def test_a_list_of_all_pads_may_get_another_material_where_pads_have_none_of_their_own(pads):
    skin, other = skin_of(GRID, 2), skin_of(GRID | {"material": MATERIAL}, 2)
    skin.set_material(MATERIAL, pads)
    for s in (skin, other):
        s.press(np.ones((2, 25, 20), np.float32), 0.01)
    assert skin["sa1"].tobytes() == other["sa1"].tobytes()
    assert refused(skin.set_material, {"modulus": np.full(2, 2.0), "viscosity": 1.0}, pads).parameter == "pads"
    one, other = skin_of(GRID), skin_of(GRID | {"material": MATERIAL})
    one.set_material({"modulus": np.full(1, 2.0), "viscosity": 1.0})
    for s in (one, other):
        s.press(np.ones((25, 20), np.float32), 0.01)
    assert one["sa1"].tobytes() == other["sa1"].tobytes()


def test_materials_of_arrays_are_checked_as_numbers_are():
    skin = skin_of(GRID, 3, materials=[MATERIAL] * 3)
    two = {"modulus": np.full(2, 2.0), "viscosity": 1.0}
    assert "each at most once" in str(refused(skin.set_material, two, [0, 0]))
    assert refused(skin.set_material, {"modulus": np.ma.array([1.0] * 3), "viscosity": 1.0}).parameter == "material.modulus"
    chain = skin_of(GRID, 1, materials=[{"elements": [MATERIAL]}])
    typo = {"elements": [{"modulus": np.full(1, 2.0), "viscosty": 3.0}]}
    assert refused(chain.set_material, typo).parameter == "material.elements.viscosty"
    longer = {"elements": [{"modulus": np.full(2, 2.0), "viscosity": 3.0}]}
    assert refused(chain.set_material, longer).parameter == "material.elements[0].modulus"


def test_each_pad_has_a_step_of_its_own():
    skin = skin_of(GRID, 2)
    skin.press(np.ones((2, 25, 20), np.float32), np.array([0.01, 0.02]))
    single = skin_of(GRID)
    single.press(np.ones((25, 20), np.float32), 0.02)
    assert skin["sa1"][1].tobytes() == single["sa1"].tobytes()
    assert refused(skin.press, np.ones((2, 25, 20), np.float32), [0.01]).parameter == "dt"


class DLPackOnly:
    """What has DLPack and nothing else, as arrays of other packages do."""

    def __init__(self, numbers):
        self.numbers = numbers

    def __dlpack__(self, **keys):
        return self.numbers.__dlpack__(**keys)

    def __dlpack_device__(self):
        return self.numbers.__dlpack_device__()


def test_every_buffer_of_float32_is_taken():
    p = pressures(25, 20)
    expected = skin_of(GRID)
    expected.press(p, 0.01)
    locked = p.copy()
    locked.flags.writeable = False
    in_c = (ctypes.c_float * 500)(*p.ravel())
    for numbers in (p.ravel(), array.array("f", p.ravel()), memoryview(p), in_c, DLPackOnly(p), locked):
        skin = skin_of(GRID)
        skin.press(numbers, 0.01)
        assert skin["sa1"].tobytes() == expected["sa1"].tobytes()


class GivesOneCapsule(DLPackOnly):
    """What returns the same capsule each time, which only its first reader may use."""

    def __init__(self, numbers):
        super().__init__(numbers)
        self.capsule = numbers.__dlpack__()

    def __dlpack__(self, **keys):
        return self.capsule


def test_a_capsule_is_taken_once():
    p = pressures(25, 20)
    skin, producer = skin_of(GRID), GivesOneCapsule(p)
    skin.press(producer, 0.01)
    before = skin.save()
    for _ in range(3):
        assert refused(skin.press, producer, 0.01).parameter == "pressure"
    assert skin.save() == before
    del producer
    skin.press(p, 0.01)


def test_a_press_of_no_pad_changes_nothing():
    skin, p = skin_of(GRID, 3), pressures(3, 25, 20)
    skin.press(p, 0.01)
    before = skin.save()
    for none in ([], (), np.array([]), np.array([], np.int32), np.zeros(3, bool)):
        for empty in (p[:0], p[np.zeros(3, bool)], np.zeros(0, np.float32), DLPackOnly(p[:0])):
            skin.press(empty, 0.01, none)
            skin.press(empty, np.array([]), none)
        skin.load(skin.save(none), none)
        skin.reset(none)
    assert skin.save() == before
    assert refused(skin.press, p[:0, :, :5], 0.01, []).parameter == "pressure"


def test_messages_are_cut_between_letters():
    skin = skin_of(GRID)
    for letter in ("e", "\u00e9", "\u20ac", "\U0001f590", "e\u00e9", "ee\u20ac", "\udcff"):
        error = refused(skin.press, letter * 100, 0.01)
        assert re.fullmatch(r"pressure = '(.+)\.\.; allowed: .*", str(error)) and letter[0] in str(error).replace(
            r"\udcff", "\udcff")


def test_a_state_is_bytes_that_give_the_same_next_press():
    skin, other = skin_of(GRID, 2), skin_of(GRID, 2)
    skin.press(pressures(2, 25, 20), 0.01)
    state = skin.save()
    assert isinstance(state, bytes)
    other.load(state)
    p = pressures(2, 25, 20)
    for s in (skin, other):
        s.press(p, 0.02)
    for name in CLASSES:
        assert skin[name].tobytes() == other[name].tobytes()
    other.load(memoryview(skin.save([1])), [0])
    assert other.save([0]) == skin.save([1])
    assert refused(skin.load, state[:-1]).parameter == "state"
    assert refused(skin.load, "text").parameter == "state"


def test_a_material_may_be_an_object_and_is_refused_by_its_key():
    skin = skin_of(GRID)
    skin.set_material(dermis.Material(modulus=100.0, viscosity=0.1))
    assert skin.report().retardation_times[0].value == 0.1 / 100.0
    for material in ({"modulus": 1.0}, {"modulus": -1.0, "viscosity": 1.0},
                     {"elements": [{"modulus": 1.0, "viscosity": 1.0}] * 2}):
        assert refused(skin.set_material, material).parameter.startswith("material")
    error = refused(skin.set_material, {"modulus": 1.0, "viscosity": 1.0, "thickness": 2.0})
    assert str(error) == "material.thickness = 2.0; allowed: none: it stays that of the skin"


def test_sites_have_one_response_each_in_their_order():
    sites = [("sa1", 3, 4), ("fa1", 10, 20), ("sa1", 0, 0)]
    scene = dermis.Scene(GRID, sites=sites)
    skin, fields = skin_of(scene, 2), skin_of(GRID, 2)
    p = pressures(2, 25, 20)
    for s in (skin, fields):
        s.press(p, 0.01)
    assert skin["sa1"].shape == (2, 2) and skin_of(scene)["fa1"].shape == (1,)
    x, y = skin.sites["sa1"].T
    np.testing.assert_array_equal(skin["sa1"], fields["sa1"][:, y, x])


def test_strain_indentation_and_curvature_are_read_when_they_are_asked_for():
    skin = skin_of({**GRID, "material": {"modulus": 2.0, "viscosity": 1.0}}, 2)
    strain = skin["strain"]
    for _ in range(2):
        skin.press(np.ones((2, 25, 20), np.float32), 1000.0)
    assert strain.shape == (2, 25, 20) and not strain.any()
    np.testing.assert_allclose(skin["strain"], 0.5, rtol=1e-6)
    np.testing.assert_allclose(strain, 0.5, rtol=1e-6)
    assert skin["indentation"].shape == skin["curvature"].shape == (2, 25, 20)
    assert skin_of(dermis.Scene(GRID, sites=[("sa1", 1, 2), ("fa1", 3, 4)]))["strain"].shape == (2,)


def test_a_skin_takes_depths_and_keeps_doing_so_when_pickled():
    skin = skin_of(GRID, control="depth")
    depths = pressures(2, 25, 20)
    skin.press(depths[0], 0.01)
    np.testing.assert_allclose(skin["strain"], np.maximum(depths[0], 0), rtol=1e-6)  # of a thickness of 1
    copied = pickle.loads(pickle.dumps(skin))
    for one in (skin, copied):
        one.press(-depths[1], 0.01)
    assert np.array_equal(skin["fa2"], copied["fa2"])
    np.testing.assert_allclose(copied["strain"], np.maximum(-depths[1], 0), rtol=1e-6)
    assert 'control = "force"; allowed: "depth", "pressure"' in str(refused(skin_of, GRID, control="force"))
    assert "material = (given)" in str(refused(skin.set_material, {"modulus": 2.0, "viscosity": 1.0}))


def test_parabolic_hold_leads_on_from_the_press_before_and_is_pickled():
    line, bow = skin_of(GRID), skin_of(GRID, hold="parabolic")
    frames = pressures(3, 25, 20)
    for frame in frames[:2]:
        line.press(frame, 0.01)
        bow.press(frame, 0.01)
    assert (line["fa1"] != bow["fa1"]).any()
    copied = pickle.loads(pickle.dumps(bow))
    for skin in (bow, copied):
        skin.press(frames[2], 0.02)
    assert np.array_equal(bow["fa1"], copied["fa1"])
    assert "parabolic hold" in str(refused(line.load, bow.save()))
    assert 'hold = "cubic"; allowed: "linear", "parabolic"' in str(refused(skin_of, GRID, hold="cubic"))
    assert line.report().vibration.value == pytest.approx(17.8, rel=1e-3)


def test_a_report_tells_what_a_pad_means():
    skin = skin_of(GRID, 2)
    skin.press(np.ones((1, 25, 20), np.float32), 1.0, [1])
    assert skin.report().strain.value == 0 and skin.report(1).strain.value > 0


def test_threads_wait_for_each_other_on_one_skin():
    skin, expected = skin_of(GRID), skin_of(GRID)
    p = np.ones((25, 20), np.float32)
    for _ in range(4000):
        expected.press(p, 0.001)

    def work():
        for _ in range(1000):
            skin.press(p, 0.001)

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert skin["sa1"].tobytes() == expected["sa1"].tobytes()


def test_errors_pass_between_processes():
    error = pickle.loads(pickle.dumps(refused(skin_of, {"grid": {"width": 0}})))
    assert (error.code, error.parameter) == ("bad_input", "grid.width") and "1..16384" in str(error)


class Tensor:
    """What torch gives for a tensor that requires a gradient."""

    def __dlpack__(self, **options):
        raise BufferError("Can't export tensors that require gradient, use tensor.detach()")

    def __dlpack_device__(self):
        return 1, 0


def test_an_array_that_is_not_given_is_refused_in_the_words_of_its_owner():
    skin = dermis.Skin({"grid": {"width": 4, "height": 4}})
    for call in (lambda: skin.press(Tensor(), 1e-3), lambda: skin.press_frames(Tensor(), 1e-3),
                 lambda: skin.press(np.zeros((4, 4), np.float32), Tensor())):
        with pytest.raises(dermis.Error, match="Tensor that cannot be read: Can't export tensors that require gradient"):
            call()


def test_what_is_said_to_be_allowed_is_allowed():
    scene = {"grid": {"width": 4, "height": 4}, "time": {"duration": 0.02}}
    result = dermis.run(scene)
    for key, call in {"responses": lambda name: dermis.Skin(scene, responses=name),
                      "precision": lambda name: dermis.Skin(scene, precision=name),
                      "sites": lambda name: dermis.Scene(scene, sites=[(name, 1, 1)]),
                      "type": lambda name: dermis.Afferents(type=name, cells=[(1, 1)]),
                      "quantity": lambda name: result[name]}.items():
        with pytest.raises(dermis.Error, match=f'{key} = ["\']sa1,fa1["\']; allowed: ') as refused:
            call("sa1,fa1")
        allowed = str(refused.value).partition("allowed: ")[2].replace('"', "").split(", ")
        assert len(allowed) >= 2
        for name in allowed:
            call(name)


CHANGED = """
import sys, threading
import dermis

sys.setswitchinterval(1e-6)
skin, ended = dermis.Skin(dermis.fingertip(grid={"width": 16, "height": 12})), threading.Event()

def read():
    while not ended.is_set():
        skin.scene

threads = [threading.Thread(target=read) for _ in range(2)]
for thread in threads: thread.start()
for i in range(5000):
    skin.set_material({"elements": [{"modulus": 1e5 + i, "viscosity": 33}] * 3, "spring": 3e4})
ended.set()
for thread in threads: thread.join()
"""


def test_a_scene_is_read_while_another_thread_changes_the_material():
    subprocess.run([sys.executable, "-c", CHANGED], check=True)


def test_a_strain_beyond_1_is_a_warning_once():
    scene = {"grid": {"width": 4, "height": 3, "spacing": 1e-3}, "surface": {"kind": "flat", "relief": 1e-4},
             "material": {"modulus": 1e4, "viscosity": 10, "thickness": 1e-3, "curvature_length": 0}}
    skin = dermis.Skin(scene, count=2, hold="linear")
    pressure = np.zeros((2, 3, 4), np.float32)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pressure[:] = 9e3  # a strain of 0.9
        for _ in range(64):
            skin.press(pressure, 1e-2)
    pressure[1, 2, 3] = 2e4  # a strain of 2
    with pytest.warns(RuntimeWarning, match=r"pad 1 has a strain of (1\.[5-9]|2\b)") as caught:
        for _ in range(64):
            skin.press(pressure, 1e-2)
        skin.press_frames(pressure[None], 1e-2)
    assert len(caught) == 1
