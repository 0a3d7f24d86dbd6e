# SPDX-License-Identifier: MIT
"""Skin in a MuJoCo model without code: the plugin dermis.skin, on the hand of tests/embedding/mujoco/hand.xml."""
import pathlib
import subprocess
import sys

import numpy as np
import pytest

import dermis

HAND = pathlib.Path(__file__).parents[2] / "embedding/mujoco/hand.xml"
SIDE = 80
KEYS = {"size": f"{SIDE} {SIDE}", "spacing": "2.5e-4", "radius": "8e-3", "ball": "6e-3", "pads": "5"}
mujoco = pytest.importorskip("mujoco")


@pytest.fixture(scope="module", autouse=True)
def plugin():
    try:
        mujoco.mj_loadPluginLibrary(dermis.mujoco_plugin())
    except dermis.Error as none:
        pytest.skip(str(none))  # a package that was built without it


def model(tips=range(5), **keys):
    given = "".join(f'<config key="{k}" value="{v}"/>' for k, v in {**KEYS, **keys}.items())
    sensors = "".join(f'<plugin name="touch{k}" instance="skin" objtype="site" objname="skin{k}"/>' for k in tips)
    text = HAND.read_text().replace("</worldbody>", f"</worldbody><sensor>{sensors}</sensor>").replace(
        "<worldbody>", f'<extension><plugin plugin="dermis.skin"><instance name="skin">{given}</instance></plugin>'
        "</extension><worldbody>")
    return mujoco.MjModel.from_xml_string(text)


def stepped(m, data, first, steps, each=lambda d: None):
    for n in range(first, first + steps):
        data.ctrl[0] = np.interp(n * 1e-3, [0.5, 0.8], [0, 0.04])
        data.ctrl[1:] = np.interp(n * 1e-3, [0.15, 0.35], [0, 0.12])
        mujoco.mj_step(m, data)
        each(data)
    return data.sensordata.copy()


def test_sensors_give_the_responses_of_a_skin_that_is_pressed_by_the_contacts():
    sys.path.insert(0, str(HAND.parent))
    import hand
    m, plain = model(responses="sa1 fa2"), hand.load()
    data, felt = mujoco.MjData(m), []
    stepped(m, data, 0, 600, lambda d: felt.append(d.sensordata.copy()))
    _, skin = hand.grasp(plain, lambda n, d, s, r: felt.append(s.skin["sa1"].copy()) if n == 599 else None, 600)
    sa1, fa2 = felt[599].reshape(5, 2, SIDE, SIDE).swapaxes(0, 1)
    assert sa1.max() > 0.1
    # NumPy rounds a contact's force otherwise than MuJoCo's own function.
    np.testing.assert_allclose(sa1, felt[600], atol=1e-5 * sa1.max())
    np.testing.assert_allclose(fa2, skin.skin["fa2"], atol=1e-4 * np.abs(fa2).max())


def test_a_rollback_by_set_state_alone_gives_the_same_sensor_values():
    m = model(responses="sa1 fa1 shear_x")
    data = mujoco.MjData(m)
    stepped(m, data, 0, 400)
    kind = mujoco.mjtState.mjSTATE_INTEGRATION
    state = np.zeros(mujoco.mj_stateSize(m, kind))
    mujoco.mj_getState(m, data, state, kind)
    then = stepped(m, data, 400, 60)
    assert np.count_nonzero(then) > 1000
    mujoco.mj_setState(m, data, state, kind)
    assert (stepped(m, data, 400, 60) == then).all()
    copied = mujoco.MjData(m)  # in another mjData
    mujoco.mj_setState(m, copied, state, kind)
    assert (stepped(m, copied, 400, 60) == then).all()
    mujoco.mj_setState(m, data, state, kind)
    mujoco.mj_forward(m, data), mujoco.mj_forward(m, data)  # computes sensors, and does not step
    assert (stepped(m, data, 400, 60) == then).all()
    mujoco.mj_resetData(m, data)
    fresh = mujoco.MjData(m)
    assert (stepped(m, data, 0, 420) == stepped(m, fresh, 0, 420)).all()


def test_batches_of_hands_have_the_values_of_one():
    batches = pytest.importorskip("mujoco.batch")
    m = model(output="mean")
    alone = [stepped(m, mujoco.MjData(m), 0, n) for n in (350, 360)]
    batch = batches.Batch(m, 3, 2)
    control, sense = batch.bind("ctrl"), batch.bind("sensordata")
    for n in range(360):
        control[:, 0] = np.interp(n * 1e-3, [0.5, 0.8], [0, 0.04])
        control[:, 1:] = np.interp(n * 1e-3, [0.15, 0.35], [0, 0.12])
        batch.step()
        if n == 349:
            assert all((np.asarray(own) == alone[0]).all() for own in sense)
    assert all((np.asarray(own) == alone[1]).all() for own in sense) and alone[1].any()


def test_a_mean_is_that_of_the_field_and_a_scene_describes_the_skin(tmp_path):
    fields, means = model(responses="fa1 stretch_x"), model(responses="fa1 stretch_x", output="mean")
    a, b = stepped(fields, mujoco.MjData(fields), 0, 330), stepped(means, mujoco.MjData(means), 0, 330)
    np.testing.assert_allclose(b.reshape(5, 2), a.reshape(5, 2, -1).mean(-1), rtol=1e-12)
    scene = tmp_path / "skin.toml"
    scene.write_text('preset = "fingertip"\n[grid]\nwidth = 80\nheight = 80\nspacing = 2.5e-4\n[surface]\nkind = "flat"\n')
    by_scene = model(responses="fa1 stretch_x", output="mean", scene=scene, size="", spacing="")
    assert (stepped(by_scene, mujoco.MjData(by_scene), 0, 330) == b).all()


@pytest.mark.parametrize("keys, words", [
    ({"spacing": "wide"}, "spacing = wide; allowed: a number"),
    ({"size": "80"}, "size = 80; allowed: 2"),
    ({"size": "0 80"}, "grid.width = 0"),
    ({"pads": "1e20"}, "pads = 1e+20; allowed: whole numbers up to 1048576"),
    ({"size": "8.5 8"}, "size = 8.5; allowed: whole numbers"),
    ({"responses": "sa1 sa3"}, "responses = sa3; allowed: sa1, sa2, fa1, fa2, shear_x, shear_y, stretch_x"),
    ({"output": "sum"}, "output = sum; allowed: field, mean"),
    ({"pads": "4"}, "pads = 4; allowed: 5, the sensors of this instance"),
    ({"reach": "9e-3"}, "reach = 0.009; allowed: below the pad's radius"),
    ({"scene": "none.toml"}, "size = 80 80; allowed: none beside a scene"),
    ({"scene": "none.toml", "size": "", "spacing": ""}, "none.toml"),
])
def test_a_key_that_is_wrong_is_an_error_of_mujoco_that_names_it(keys, words):
    # in a process of its own: MuJoCo's error leaves what it was doing
    program = ("import sys, mujoco, dermis; sys.path.insert(0, sys.argv[1]); import test_mujoco_plugin as t\n"
               "mujoco.mj_loadPluginLibrary(dermis.mujoco_plugin())\n"
               f"try: mujoco.MjData(t.model(**{keys!r}))\n"
               "except Exception as e: print('refused:', e)")
    done = subprocess.run([sys.executable, "-c", program, str(pathlib.Path(__file__).parent)], capture_output=True,
                          text=True, timeout=60)
    assert done.returncode == 0 and "refused:" in done.stdout and words in done.stdout, done
