# SPDX-License-Identifier: MIT
"""Runs: results as views by name, plans and reports."""
import gc
import threading

import dermis
import numpy as np
import pytest
from common import address

SCENE = {
    "grid": {"width": 30, "height": 20},
    "time": {"step": 0.1, "duration": 1.0},
    "output": {"probes": [[15, 10], [0, 0]], "fields": [{"at": 0.5, "what": ["sa1", "deformation"]}]},
}


def test_a_uniform_load_gives_the_closed_form():
    scene = dermis.Scene(SCENE, load={"path": np.full((20, 30), 2.0)}, material={"modulus": 4.0, "viscosity": 2.0})
    result = dermis.run(scene)
    expected = 2 / 4 * (1 - np.exp(-result.time * 4 / 2))
    np.testing.assert_allclose(result["strain"].mean, expected, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(result["strain"].probes[1], result["strain"].max, rtol=1e-12)


def test_arrays_are_views_of_the_same_memory():
    result = dermis.run(SCENE)
    pairs = [(result.time, result.time), (result["fa1"].mean, result["fa1"].mean),
             (result["fa1"].probes[1], result["fa1"].probes[1]),
             (result.fields["sa1", 0.5], result.fields["sa1", 0.5])]
    for first, second in pairs:
        assert address(first) == address(second) and not first.flags.writeable and first.dtype == np.float64


def test_a_view_keeps_its_numbers_alive():
    mean = dermis.run(SCENE)["sa1"].mean
    before = mean.copy()
    gc.collect()
    others = [dermis.run(SCENE) for _ in range(3)]
    np.testing.assert_array_equal(mean, before)
    assert len(others) == 3


def test_shapes_are_those_of_times_cells_and_sites():
    result = dermis.run(dermis.Scene(SCENE, sites=[("sa1", 1, 2), ("fa2", 3, 4), ("sa1", 5, 6)]))
    assert result.time.shape == result["sa2"].min.shape == (10,)
    assert len(result["sa2"].probes) == 2
    assert result.responses.shape == (10, 3)
    assert {key: field.shape for key, field in result.fields.items()} == {
        ("sa1", 0.5): (20, 30), ("deformation", 0.5): (20, 30)}
    np.testing.assert_array_equal(result.responses[5, 2], result.fields["sa1", 0.5][6, 5])


def test_a_trace_that_was_not_asked_for_is_refused():
    result = dermis.run(dermis.Scene(SCENE, output={"traces": ["sa1"]}))
    assert list(result) == result.keys() == ["sa1"] and "fa1" not in result and len(result) == 1
    for name in ("fa1", "pain"):
        with pytest.raises(dermis.Error, match=name):
            result[name]


def test_impulses_and_figures_have_names():
    result = dermis.run(SCENE)
    assert [i.quantity for i in result.impulses] == ["fa2"] and result.impulses[0].mean > 0
    assert result.model == "maps" and result.precision == "f64" and result.device.name == "cpu"
    assert result.steps >= 10


def test_a_plan_says_what_a_run_takes():
    plan = dermis.plan(SCENE)
    assert plan.chosen.model == dermis.run(SCENE).model and plan.chosen.refused == ""
    assert all(c.refused for c in plan.candidates if c is not plan.chosen and c.model != plan.chosen.model)


def test_a_march_in_float_is_asked_for_by_precision():
    result = dermis.run(SCENE, precision="f32")
    assert result.model == "march" and result.precision == "f32"
    with pytest.raises(dermis.Error, match='precision = "f16"; allowed: "f32", "f32-compensated", "f64"'):
        dermis.run(SCENE, precision="f16")


def test_a_report_says_what_cannot_be_skin():
    report = dermis.run({**SCENE, "grid": {"width": 30, "height": 20, "spacing": 2.5e-4}, "surface": {"relief": 1e-4},
                         "material": {"modulus": 1.54, "viscosity": 1.0, "thickness": 1e-3, "curvature_length": 1e-5},
                         "load": {"intensity": 1e4}}).report()
    assert report.strain.outside and report.indentation.outside and report.strain.greatest == 1


def test_a_device_that_is_not_there_has_its_code():
    with pytest.raises(dermis.Error) as caught:
        dermis.run(SCENE, "no such device")
    assert caught.value.code in ("bad_input", "no_device")
    assert dermis.Device.cpu(1).info.kind == "cpu path"
    assert dermis.run(SCENE, "cpu").device.vulkan is False


def test_other_threads_run_while_a_scene_does():
    scene = dermis.Scene(model="march", grid={"width": 400, "height": 400}, time={"step": 0.01, "duration": 3})
    beats = 0
    done = threading.Event()

    def work():
        dermis.run(scene, dermis.Device.cpu(1))
        done.set()

    thread = threading.Thread(target=work)
    thread.start()
    while not done.wait(1e-3):
        beats += 1
    thread.join()
    assert beats > 3


def test_a_sweep_over_materials_gives_the_result_of_each():
    scene = {**SCENE, "material": {"modulus": 2.0, "viscosity": 1.0}}
    materials = [dermis.Material(modulus=2.0, viscosity=1.0), {"modulus": 4.0, "viscosity": 1.0}]
    soft, stiff = (row["result"] for row in dermis.sweep(scene, {"material": materials}))
    np.testing.assert_array_equal(soft["strain"].mean, dermis.run(scene)["strain"].mean)
    alone = dermis.run({**scene, "material": materials[1]})
    np.testing.assert_array_equal(stiff["strain"].mean, alone["strain"].mean)
    assert [f.value for f in stiff.report().retardation_times] == [0.25]
    assert dermis.sweep(scene, {"material": []}) == []
    with pytest.raises(dermis.Error) as caught:
        dermis.sweep(scene, {"material": [{"modulus": -1.0, "viscosity": 1.0}]})
    assert "modulus" in str(caught.value)


def test_names_that_have_gone_say_what_does_the_same():
    from dermis import maps
    for call, word in ((maps, '"deformation", "curvature"'), (dermis.run_materials, 'sweep(tables, {"material"')):
        with pytest.raises(dermis.Error) as caught:
            call(SCENE)
        assert word in str(caught.value)
    result = dermis.run({**SCENE, "output": {"fields": [{"at": 0, "what": ["deformation", "curvature"]}]}})
    assert {*result.fields} == {("deformation", 0), ("curvature", 0)}
    assert not {"maps", "run_materials"} & {*dir(dermis), *dermis.__all__}
    with pytest.warns(DeprecationWarning, match="dermis.plan"):
        assert dermis.explain is dermis.plan
    with pytest.raises(AttributeError, match="no attribute 'map'"):
        dermis.map
