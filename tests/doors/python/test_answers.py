# SPDX-License-Identifier: MIT
"""What a newcomer does wrong, and the words that come back: the parameter, its value, and what is allowed."""
import re

import dermis
import numpy as np
import pytest
from dermis import contact

GRID = {"grid": {"width": 16, "height": 12}}
ONES = np.ones((12, 16), np.float32)
LONG = np.ones(208, np.float32)
MASKED = np.ma.array(ONES, mask=True)
NAN = np.where(np.arange(192).reshape(12, 16) == 52, np.nan, ONES).astype(np.float32)


class Cuda:
    """An array that is not in the CPU's memory."""

    def __dlpack_device__(self):
        return 2, 0

    def __dlpack__(self, **options):
        raise BufferError("cannot export to cpu")


class CudaInterface:
    __cuda_array_interface__ = {"shape": (12, 16), "typestr": "<f4", "data": (1234, False), "version": 3}


def skin(n=None, **options):
    return dermis.Skin(GRID, n, **options)


def press(*given, n=None, **named):
    return lambda: skin(n).press(*given, **named)


def pad(array=None):
    return contact.Pad(np.zeros((12, 16), np.float32) if array is None else array, 1e-4)


TOUCH = contact.Contact(1e-3, 1e-3, 1.0)
IN_WORLD = contact.WorldContact((0, 0, 0), 1.0)
ANSWERS = [
    (press(ONES.astype(float), 1e-3), "pressure = float64 array of shape (12, 16); allowed: float32 array in C order, of shape"),
    (press(ONES.astype(int), 1e-3), "pressure = int64 array of shape (12, 16)"),
    (press(ONES.astype(np.float16), 1e-3), "pressure = float16 array of shape (12, 16)"),
    (press(ONES.astype(">f4"), 1e-3), "pressure = ndarray that cannot be read: DLPack only supports native byte order"),
    (press(ONES.tolist(), 1e-3), "pressure = [[1.0"),
    (press(np.ones((16, 12), np.float32).T, 1e-3), "pressure = strided float32 array of shape (12, 16)"),
    (press(np.ones((16, 12), np.float32), 1e-3), "pressure = float32 array of shape (16, 12)"),
    (press(ONES[None], 1e-3), "pressure = float32 array of shape (1, 12, 16)"),
    (press(ONES, 1e-3, n=1), "of shape (1, 12, 16) in Pa"),
    (press(ONES[::-1], 1e-3), "pressure = strided float32"),
    (press(np.broadcast_to(ONES, (3, 12, 16)), 1e-3, n=3), "pressure = strided float32"),
    (press(1.0, 1e-3), "pressure = 1.0; allowed: float32 array"),
    (press(None, 1e-3), "pressure = None; allowed: float32 array in C order"),
    (press(), "pressure = (not given); allowed: float32 in C order, Pa, of shape (height, width)"),
    (press(NAN, 1e-3), "pressure = nan in cell [4, 3]; allowed: finite numbers"),
    (press(MASKED, 1e-3), "pressure = masked array (.filled(..) has no mask)"),
    (press(Cuda(), 1e-3), "pressure = array on another device (.cpu() or its like copies it)"),
    (press(CudaInterface(), 1e-3), "pressure = array on another device (.cpu() or its like copies it)"),
    (press(ONES), "dt = (not given); allowed: s, >= 0, or one for each pad"),
    (press(ONES, "1ms"), "dt = '1ms'; allowed: seconds"),
    (press(ONES[None], 1e-3, [0.0, 1.0], n=2), "pads = [0.0, 1.0]; allowed: a list of integers"),
    (lambda: contact.Pad(None, spacing=1e-3), "arguments = (None,); allowed: those of "),
    (press(ONES[None], 1e-3, [False, True], n=2), "pads = [False, True]; allowed: a list of integers, or an array of 2 bools"),
    (press(ONES[None], 1e-3, 1, n=2), "pads = 1; allowed: a list of integers"),
    (press(np.stack([ONES] * 2), 1e-3, np.array([True]), n=2), "pads = bool array of shape (1,); allowed: a list of integers"),
    (press(np.stack([ONES] * 2), 1e-3, "01", n=2), "pads = '01'; allowed: a list of integers"),
    (lambda: skin(responses=["pain"]), "responses = "),
    (press(np.ones(191, np.float32), 1e-3), "pressure = float32 array of shape (191,)"),
    (press(ONES, 1e-3, out=ONES), "out = float32 array of shape (12, 16); allowed: a dict of arrays"),
    (press(ONES, 1e-3, out={"sa3": ONES}), 'response = \'sa3\'; allowed: "sa1", "sa2", "fa1", "fa2"'),
    (press(ONES, 1e-3, out={"sa1": ONES, "fa1": ONES}), "out = float32 array of shape (12, 16) twice; allowed: an array for each"),
    (press(ONES, 1e-3, out={"sa1": LONG[:192].reshape(12, 16), "fa1": LONG[16:].reshape(12, 16)}), "(12, 16) twice; allowed"),
    (press(ONES, 1e-3, out={"sa1": ONES.T}), "out = strided float32 array of shape (16, 12); allowed: float32 array in C order that"),
    (press(ONES, 1e-3, out={"sa1": np.ones((16, 12), np.float32).T}), "out = strided float32 array of shape (12, 16); allowed"),
    (press(ONES, 1e-3, out={"sa1": np.broadcast_to(ONES, (12, 16))}), "out = read-only float32 array of shape (12, 16); allowed"),
    (press(ONES, 1e-3, out={"sa1": np.broadcast_to(ONES.astype(float), (12, 16))}), "out = float64 array of shape (12, 16)"),
    (press(np.ones((2, 12, 16), np.float32), 1e-3, n=4, pads=np.eye(2) > 0), "pads = bool array of shape (2, 2); allowed: a list of integers,"),
    (lambda: skin()["SA1"], "response = 'SA1'; allowed: \"sa1\", \"sa2\", \"fa1\", \"fa2\", \"strain\", \"indentation\", \"curvature\""),
    (lambda: skin(responses="sa1")["fa1"], 'response = \'fa1\'; allowed: "sa1", "strain"'),
    (lambda: skin()[0], "response = 0; allowed: \"sa1\""),
    (lambda: skin(responses=["sa1", 2]), "responses = 2; allowed: texts"),
    (lambda: skin(2.0), "count = 2.0; allowed: None, a number of pads, or a tuple of lengths"),
    (lambda: skin((2, "3")), "count = '3'; allowed: None, a number of pads, or"),
    (lambda: skin((2**20, 2**20)), "count = "),
    (lambda: skin(device="cuda"), 'device = "cuda": no such device'),
    (lambda: skin(device=0), "device = 0; allowed: a Device, a text as Device.open takes it, or None"),
    (lambda: skin(2).reset(slice(0, 1)), "pads = slice(0, 1, None); allowed: a list of integers"),
    (lambda: skin().load("abc"), "state = 'abc'; allowed: bytes"),
    (lambda: skin().load(skin().save()[:-3]), " bytes; allowed: "),
    (lambda: skin(materials=[{"modulus": 1, "viscosity": 1}]).set_material({"modulus": [1.0, 2.0], "viscosity": 1}),
     "material.modulus = float64 array of shape (2,); allowed: a number, or an array of shape (1,)"),
    (lambda: skin(1, materials=[{"modulus": 1, "viscosity": 1}]).set_material({"modulus": [1.0], "spring": "a"}), "material."),
    (lambda: skin().set_material({"elements": [1, 2]}), "material.elements = 1; allowed: tables"),
    (lambda: skin(2, materials=[{"modulus": 1, "viscosity": 1}] * 2).set_material({"modulus": [1.0], "viscosity": 1}, 1), "pads = 1;"),
    (lambda: skin(1, materials=[{"modulus": 1, "viscosity": 1}]).set_material({"modulus": [1.0]}), "material.viscosity = (not given); allowed"),
    (lambda: dermis.Scene(grid={"width": 16, "hight": 12}), "grid.hight = 12; no such key here"),
    (lambda: dermis.Scene(gird={"width": 16}), "[gird]: no such table; the nearest is [grid]"),
    (lambda: dermis.Scene(grid={"width": 16.0}), "grid.width = 16.0; allowed: whole cells, 1..16384"),
    (lambda: dermis.Scene(grid=GRID["grid"], surface={"path": np.ones((16, 12))}), "surface.path = array of shape (16, 12)"),
    (lambda: dermis.run(skin()), "scene = <Skin 16 x 12 cells, sa1 sa2 fa1 fa2, cpu>; allowed: a Scene"),
    (lambda: contact.Pad(np.zeros((12, 16)), 1e-4), "pressure = float64 array of shape (12, 16); allowed: float32"),
    (press(ONES[None], 1e-3, np.array([0.0, 1.0]), n=2), "pads = float64 array of shape (2,); allowed: a list of integers, or an array of 2"),
    (lambda: skin()["fa3"], "response = 'fa3'; allowed: \"sa1\""),
    (lambda: dermis.Skin("[grid]"), "[grid]: cannot be read (No such file or directory); allowed: a scene file (TOML)"),
    (lambda: contact.Pad(np.zeros((3, 12, 16), np.float32), 1e-4), "pressure = float32 array of shape (3, 12, 16); allowed"),
    (lambda: contact.Pad(np.broadcast_to(np.float32(0), (12, 16)), 1e-4), "in Pa that can be written, its rows one after another"),
    (lambda: contact.Pad(ONES), "spacing = (not given); allowed: a number (m between cells)"),
    (lambda: contact.Contact(1e-3, 1e-3), "force = (not given); allowed: a number (N, >= 0)"),
    (lambda: contact.Contact(1e-3, "1 mm", 1), "y = '1 mm'; allowed: a number (m, from row to row)"),
    (lambda: contact.WorldContact((1, 2), 1), "position = (1, 2); allowed: three numbers"),
    (lambda: contact.Pose(rotation=np.eye(2)), "rotation = float64 array of shape (2, 2); allowed: nine numbers"),
    (lambda: contact.add_contacts(pad(), TOUCH), "contacts = Contact(x=0.001, y=0.001, force=1.0"),
    (lambda: contact.add_contacts(pad(), [{"x": 1e-3}]), "contacts = {'x': 0.001}; allowed: a list of contact.Contact"),
    (lambda: contact.add_contacts(pad(), np.ones((3, 4))), "contacts = float64 array of shape (4,); allowed: a list of"),
    (lambda: contact.add_contacts(pad(), contact.Pose(), [IN_WORLD]), "reach = [WorldContact("),
    (lambda: contact.add_contacts(ONES, [TOUCH]), "pad = float32 array of shape (12, 16); allowed: a Pad"),
    (lambda: contact.add_contacts(pad()), "contacts = (not given); allowed: a list of Contact"),
    (lambda: contact.add_depths(pad(), np.zeros((12, 16)), 1.0), "depth = float64 array of shape (12, 16)"),
    (lambda: contact.hertz_radius(1.0, None, 2.0), "ball = None; allowed: a number (its radius, m)"),
    (press(ONES, [[1e-3]]), "dt = [0.001]; allowed: seconds, or an array of them"),
    (press(ONES, 1j), "dt = 1j; allowed: seconds"),
    (press(ONES, 1e-3, pad=[1]), "pad = [1]; allowed: the arguments pressure, dt, pads, out, traction"),
    (press(ONES, 1e-3, None, None, None, 5), "one more argument = 5; allowed: the arguments pressure, dt, pads, out, traction"),
    (press(np.ones((2, 3, 12, 16), np.float32), np.ones((3, 2)), n=(2, 3)), "dt = float64 array of shape (3, 2); allowed: seconds"),
    (press(np.ones((2, 12, 16), np.float32), np.ma.array([1, 1], mask=[0, 1]), n=2), "dt = masked array"),
    (lambda: skin().press_frames(ONES[None], "1 ms"), "dt = '1 ms'; allowed: a number"),
    (lambda: skin().press_cells(ONES.ravel(), None), "dt = None; allowed: a number"),
    (lambda: skin(2).reset(np.ma.array([0, 1], mask=[0, 1])), "pads = masked array"),
    (lambda: skin(2).save([2**70]), "pads = [1180591620717411303424]; allowed: a list of integers"),
    (lambda: skin().load(), "state = (not given); allowed: bytes that save has returned"),
    (lambda: skin().report("a"), "pad = 'a'; allowed: a whole number"),
    (lambda: skin().report(2**40), "pad = 1099511627776; allowed: a whole number"),
    (lambda: skin()[None], 'response = None; allowed: "sa1"'),
    (lambda: skin(precision=3), "precision = 3; allowed: a text or None"),
    (lambda: skin(precision="f16"), 'precision = "f16"; allowed: "f32"'),
    (lambda: skin(responses=5), "responses = 5; allowed: a text or a list of texts or None"),
    (lambda: skin(materials=5), "materials = 5; allowed: a list"),
    (lambda: skin(materials=[5]), "materials[0] = 5; allowed: a Material, or a dict"),
    (lambda: skin(2**40), "count = 1099511627776; allowed: None, a number of pads"),
    (lambda: dermis.Skin(), "scene = (not given); allowed: a Scene, tables by name, or a path"),
    (lambda: dermis.Skin(GRID, 2, "cpu"), "one more argument = 'cpu'; allowed: the arguments scene, count, device"),
    (lambda: skin().set_material(None), "material = None; allowed: a Material, or a dict"),
    (lambda: skin(2).set_material({"modulus": np.ma.array([1, 2], mask=[0, 1])}), "material.modulus = masked array"),
    (lambda: skin(2).set_material({"modulus": [[1], [1, 2]]}), "material.modulus = [[1], [1, 2]]; allowed: a number, or an array of one"),
    (lambda: dermis.run(), "scene = (not given); allowed: a Scene, tables by name, or the path of a TOML file"),
    (lambda: dermis.run(GRID, precision=3), "precision = 3; allowed: a text or None"),
    (lambda: dermis.run(GRID, check="yes"), "check = 'yes'; allowed: True or False"),
    (lambda: dermis.run(GRID, chek=True), "chek = True; allowed: the arguments scene, device, precision, check, progress"),
    (lambda: dermis.run(GRID, progress=5), "progress = 5; allowed: a function or None"),
    (lambda: dermis.sweep(GRID, 5), "values = 5; allowed: a dict"),
    (lambda: dermis.plan(GRID, precision=7), "precision = 7; allowed: a text or None"),
    (lambda: dermis.fingertip(5), "one more argument = 5; allowed: the arguments keys"),
    (lambda: dermis.Scene(5), "tables = 5; allowed: a dict or None"),
    (lambda: dermis.Scene(GRID, sites=[("sa1", 2**40, 2)]), "sites = 1099511627776; allowed: a whole number, -1e9..1e9"),
    (lambda: dermis.Scene(surface={"path": MASKED}), "surface.path = masked array (.filled(..) has no mask); allowed: an array without"),
    (lambda: dermis.Scene(load={"times": np.ma.array([1.0])}), "load.times = masked array"),
    (lambda: dermis.Scene.from_file(None), "path = None; allowed: a text or a path"),
    (lambda: dermis.Scene.from_file("a.toml", 5), "overrides = 5; allowed: a dict or None"),
    (lambda: dermis.Scene.from_string(5), "text = 5; allowed: a text"),
    (lambda: dermis.fit_creep(5, [1], 2), "times = 5; allowed: a list of numbers or an array (s, >= 0)"),
    (lambda: dermis.fit_creep(np.ma.array([1.0, 2.0]), [1], 2), "times = masked array"),
    (lambda: dermis.fit_creep([1], "abc", 2), "compliances = 'abc'; allowed: a list of numbers or an array (1/Pa)"),
    (lambda: dermis.fit_relaxation([1], [None], 2), "moduli[0] = nan; allowed: a finite number"),
    (lambda: dermis.fit_relaxation([1], [1], 2.5), "n = 2.5; allowed: a whole number"),
    (lambda: dermis.fit_relaxation([1], [1], 2, residuals="a"), "residuals = 'a'; allowed: the arguments times, moduli, n, residual"),
    (lambda: dermis.chain_of(None), "relaxation = None; allowed: a Relaxation"),
    (lambda: dermis.relaxation_of([5]), "elements = 5; allowed: KelvinVoigt"),
    (lambda: dermis.KelvinVoigt(1, 2), "one more argument = 1; allowed: the arguments modulus, viscosity"),
    (lambda: dermis.KelvinVoigt(modulus="a"), "modulus = 'a'; allowed: a number (Pa, >= 0)"),
    (lambda: setattr(dermis.KelvinVoigt(), "modulus", "a"), "modulus = 'a'; allowed: Pa, >= 0"),
    (lambda: setattr(dermis.Relaxation(), "times", np.ma.array([1.0])), "times = masked array"),
    (lambda: dermis.Device.open(5), "which = 5; allowed: a text"),
    (lambda: dermis.Device.cpu("a"), "threads = 'a'; allowed: a whole number (0 is one per core"),
    (lambda: dermis.Device(), "Device = (); allowed: objects that functions of dermis return"),
    (lambda: dermis.run(GRID)[0], "quantity = 0; allowed: a text"),
    (lambda: contact.Contact(x=0, y=0, force=1, radios=3), "radios = 3; allowed: the arguments x, y, force, radius, area"),
    (lambda: contact.Contact(None, 0, 1), "x = None; allowed: a number (m, along a row"),
    (lambda: contact.Contact(np.ones(3), 0, 1), "x = float64 array of shape (3,); allowed: a number"),
    (lambda: setattr(TOUCH, "force", "a"), "force = 'a'; allowed: N, >= 0"),
    (lambda: setattr(IN_WORLD, "position", np.ma.array([1.0, 2.0, 3.0])), "position = masked array"),
    (lambda: contact.WorldContact(np.ma.array([1.0, 2.0, 3.0]), 1), "position = masked array"),
    (lambda: contact.Pose(rotation=np.ma.array(np.eye(3))), "rotation = masked array"),
    (lambda: contact.Pose.from_quaternion((0, 0, 0), (1, 0, 0)), "quaternion = (1, 0, 0); allowed: four numbers"),
    (lambda: contact.Pose().from_middle(5), "pad = 5; allowed: a Pad"),
    (lambda: contact.Pad(MASKED, 1e-3), "pressure = masked array"),
    (lambda: contact.add_depths(pad(), ONES, "a"), "force = 'a'; allowed: a number (N)"),
    (lambda: contact.add_depths(pad(), MASKED, 1.0), "depth = masked array"),
    (lambda: contact.add_taxels(pad(), ONES, height=1), "width = (not given); allowed: a number (m, of one taxel)"),
    (lambda: contact.add_taxels(pad(), MASKED, width=1, height=1), "values = masked array"),
]


@pytest.mark.parametrize("call, words", ANSWERS, ids=[words for _, words in ANSWERS])
def test_a_mistake_is_answered_by_parameter_value_and_what_is_allowed(call, words):
    with pytest.raises(dermis.Error) as refused:
        call()
    assert words in str(refused.value) and not re.search("incompatible function|Invoked with|nanobind", str(refused.value))


def test_no_function_is_without_an_answer_to_arguments_that_it_cannot_take():
    core = dermis._core
    kinds = [kind for kind in vars(core).values() if isinstance(kind, type)]
    calls = kinds + [getattr(scope, name) for scope in (core, *kinds) for name, member in vars(scope).items()
                     if type(member).__name__ in ("nb_func", "nb_method") and name not in ("answer", "refuse")
                     and (name == "__getitem__" or not name.startswith("__"))]
    assert len(calls) > 40
    for call in calls:
        for given, named in (([object()], {}), ([object(), None], {}), ([object()] * 9, {}), ([object()], {"no_such": 1})):
            with pytest.raises(dermis.Error, match="allowed: "):
                call(*given, **named)


def test_a_skin_can_have_several_axes_of_pads():
    pressure = np.random.default_rng(2).random((2, 3, 12, 16), np.float32)
    several, one = skin((2, 3)), skin(6)
    several.press(pressure, np.full((2, 3), 0.01))
    one.press(pressure.reshape(6, 12, 16), 0.01)
    assert several["fa1"].shape == (2, 3, 12, 16) and several["fa1"].tobytes() == one["fa1"].tobytes()
    several.press(pressure[0, :2], 0.01, pads=np.array([[True, False, True], [False] * 3]))
    one.press(pressure[0, :2], 0.01, pads=[0, 2])
    several.press(pressure[1, 1], 0.02, pads=(1, 2))
    one.press(pressure[1, 1][None], 0.02, pads=[5])
    several.press_frames(pressure[:, None], 0.01, pads=np.array([False, True]))
    one.press_frames(pressure, 0.01, pads=[3, 4, 5])
    several.press(pressure[0], [0.01, 0.02, 0.03], pads=1)
    one.press(pressure[0], [0.01, 0.02, 0.03], pads=[3, 4, 5])
    assert several["sa1"].tobytes() == one["sa1"].tobytes() and several.count == 6
    assert repr(several) == "<Skin 2 x 3 pads of 16 x 12 cells, sa1 sa2 fa1 fa2, cpu>"


# of pads of shape (2, 3): an index, and the pads that it names
INDICES = [(1, [3, 4, 5]), (np.int64(0), [0, 1, 2]), ((1,), [3, 4, 5]), ((1, 0), [3]), ([(1, 2), (0, 1)], [5, 1]), ([(1,)], [3, 4, 5]),
           (np.array([[0, 2], [1, 1]]), [2, 4]), (np.array([[1]], np.uint8), [3, 4, 5]), (np.eye(2, 3, dtype=bool), [0, 4]),
           (np.array([False, True]), [3, 4, 5]), ([], []), (np.zeros(2, bool), []), (np.zeros((0, 2), int), [])]


@pytest.mark.parametrize("index, named", INDICES)
def test_pads_of_several_axes_are_named_as_an_array_is_indexed(index, named):
    rows = [tuple(i) for i in index] if isinstance(index, list) else index.tolist() if np.ndim(index) == 2 else ()
    key = tuple(np.array(rows).T) if rows and getattr(index, "dtype", None) != bool else index
    shape = np.zeros((2, 3))[key].shape if len(named) else (0, 3) if getattr(index, "dtype", None) == bool else (0,)
    made = skin((2, 3), materials=[{"modulus": 1.0, "viscosity": 1.0}] * 6)
    made.press(np.ones((2, 3, 12, 16), np.float32), 1.0)
    single = skin(materials=[{"modulus": 1.0, "viscosity": 1.0}])
    single.press(ONES, 1.0)
    kept, at_rest = single.save(), skin(materials=[{"modulus": 1.0, "viscosity": 1.0}]).save()

    def changed():
        return [i for i in range(6) if made.save(divmod(i, 3)) != kept]

    state = made.save(index)
    made.reset(index)
    assert changed() == sorted(named)
    assert all(made.save(divmod(i, 3)) == at_rest for i in named)
    made.load(state, index)
    assert changed() == []
    made.press(np.zeros((*shape, 12, 16), np.float32), np.full(shape, 0.1) if len(named) > 1 else 0.1, index)
    made.load(state, index)
    made.press_cells(np.zeros((len(named), 192), np.float32), 0.1, index)
    assert changed() == sorted(named)
    made.load(state, index)
    made.set_material({"modulus": np.full(shape, 2.0), "viscosity": 1.0} if len(named) > 1 else {"modulus": 2.0, "viscosity": 1.0}, index)
    strain = [made.report(divmod(i, 3)).retardation_times[0].value for i in range(6)]
    assert strain == [0.5 if i in named else 1.0 for i in range(6)]


@pytest.mark.parametrize("index", [[1, 0], np.array([1, 0]), ((1, 0), (0, 0)), [[1, 0]], (2, 0), (0, -1), -1, 5, True, [True, False],
                                   np.ones(6, bool), np.ones((3, 2), bool), slice(1), (1, 0, 0), (), [(0, 1), (1,)], [(1, 1), (1, 1)],
                                   1.0, (1.0, 0), 2**70, "10", np.ma.array([[1, 0]])])
def test_what_could_mean_other_pads_of_several_axes_is_refused(index):
    made = skin((2, 3))
    made.press(np.ones((2, 3, 12, 16), np.float32), 1.0)
    before = made.save()
    for call in (made.reset, made.save, lambda pads: made.load(before, pads), lambda pads: made.press(ONES, 0.1, pads)):
        with pytest.raises(dermis.Error, match=r"^pads = .*\(2, 3\): \(e, p\); e, for all of a\[e\]; a list of such tuples"):
            call(index)
    assert made.save() == before
    with pytest.raises(dermis.Error, match="pad"):
        made.report(index)


def test_a_press_fills_arrays_of_the_callers():
    one, log = skin(), np.full((3, 12, 16), np.nan, np.float32)
    for i in range(3):
        one.press(ONES, 0.01, out={"fa1": log[i]})
        assert log[i].tobytes() == one["fa1"].tobytes()
    with pytest.raises(dermis.Error):
        one.press(NAN, 0.01, out={"fa1": log[0]})
    assert np.isfinite(log).all() and log[0].max() > log[2].max() > 0


class OldReader:
    """What JAX and NumPy 1 ask for: an array that no version of DLPack calls read-only."""

    def __init__(self, array, **options):
        self.array, self.options = array, options

    def __dlpack__(self, **_):
        return self.array.__dlpack__(**self.options)

    def __dlpack_device__(self):
        return self.array.__dlpack_device__()


@pytest.mark.parametrize("options", [{}, {"max_version": None}, {"max_version": (0, 8)}])
def test_each_reader_of_dlpack_shares_the_memory_of_a_response(options):
    one = skin((2, 3))
    views = [one["fa1"], one["fa1"][1, ::2, 3:]]
    shared = [np.from_dlpack(OldReader(view, **options)) for view in views]
    one.press(np.ones((2, 3, 12, 16), np.float32), 0.01)
    for view, old in zip(views, shared):
        assert np.shares_memory(old, view) and np.array_equal(old, view) and view.any() and not view.flags.writeable
    kept = one["fa1"].copy()
    del one, views, view
    assert np.array_equal(shared[0], kept)


def test_a_view_goes_to_readers_of_dlpack():
    one = skin()
    view = one["fa1"]
    new = np.from_dlpack(view)
    one.press(ONES, 0.01)
    assert np.shares_memory(new, view) and new.any() and not view.flags.writeable
    assert not new.flags.writeable or np.lib.NumpyVersion(np.__version__) < "2.1.0"
    assert type(view.__array_wrap__(np.array(1.0, np.float32))) is np.float32  # as NumPy 1 calls it
    assert type(2 * view) is np.ndarray and type(view.sum()) is np.float32 and type(view[3:]) is type(view)


def test_each_pad_takes_its_row_of_materials_or_none_does():
    material = {"elements": [{"modulus": 2.0, "viscosity": 1.0}, dermis.KelvinVoigt(modulus=3.0, viscosity=0.1)], "spring": 9.0}
    arrays, one_by_one = (skin(4, materials=[material] * 4, responses=["sa1"]) for _ in range(2))
    moduli = np.array([1.0, 2.0, 3.0, 4.0])
    arrays.set_material({"elements": [{"modulus": moduli, "viscosity": 1.0}, {"modulus": 5, "viscosity": moduli / 8}],
                         "spring": 7 + moduli})
    for i, m in enumerate(moduli):
        one_by_one.set_material({"elements": [{"modulus": m, "viscosity": 1.0}, {"modulus": 5, "viscosity": m / 8}],
                                 "spring": 7 + m}, [i])
    both = arrays, one_by_one
    bits = [s.press(np.stack([ONES] * 4), 0.1) or s["sa1"].tobytes() for s in both]
    assert bits[0] == bits[1]
    with pytest.raises(dermis.Error, match="modulus = -1"):
        arrays.set_material({"elements": [{"modulus": [1.0, 2.0, -1.0, 3.0], "viscosity": 1.0},
                                          {"modulus": 5, "viscosity": 1.0}], "spring": 7.0})
    arrays.set_material({"elements": [{"modulus": [9.0], "viscosity": 1}, {"modulus": 5, "viscosity": 1}], "spring": 7}, [2])
    one_by_one.set_material({"elements": [{"modulus": 9, "viscosity": 1}, {"modulus": 5, "viscosity": 1}], "spring": 7}, [2])
    bits = [s.press(np.stack([ONES] * 4), 0.1) or s["sa1"].tobytes() for s in both]
    assert bits[0] == bits[1]


def test_only_the_classes_whose_density_is_named_are_drawn():
    sites = {kind for kind, _, _ in dermis.fingertip(sites={"density": {"sa1": 70, "fa2": 10}}).sites}
    assert sites == {"sa1", "fa2"}
    assert len({kind for kind, _, _ in dermis.fingertip(sites={"density": {}}).sites}) == 4


def test_a_run_tells_its_progress_and_ends_by_what_that_raises():
    heard = []
    dermis.run(GRID, progress=heard.append)
    assert heard and heard[-1] == 1 and heard == sorted(heard)

    def stop(done):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        dermis.run(GRID, progress=stop)
