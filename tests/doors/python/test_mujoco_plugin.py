# SPDX-License-Identifier: MIT
"""Skin in a MuJoCo model without code: the plugin dermis.skin, on the hand of tests/embedding/mujoco/hand.xml."""
import pathlib
import pickle
import re
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


@pytest.fixture(autouse=True)
def where_mujoco_writes_its_log(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


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


def test_sensors_give_the_responses_of_a_skin_that_is_pressed_by_the_contacts(tmp_path):
    sys.path.insert(0, str(HAND.parent))
    import hand
    scene = tmp_path / "scene.toml"  # the hand's skin
    scene.write_text('preset = "fingertip"\nreceptors.depth = "fingertip"\n[grid]\nwidth = 80\nheight = 80\n'
                     'spacing = 2.5e-4\n[surface]\nkind = "flat"\n')
    m, plain = model(responses="sa1 fa2", scene=scene, size="", spacing="", source="contacts"), hand.load()
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
    ({"pads": "1e20"}, "pads = 1e+20; allowed: 1..1048576"),
    ({"spacing": "-1"}, "spacing = -1; allowed: 1e-09..1000000"),
    ({"reach": "1e300"}, "reach = 1e+300; allowed: 0..1000000"),
    ({"beyond": "all"}, "beyond = all; allowed: keep, drop"),
    ({"source": "shapes"}, "source = shapes; allowed: bodies, contacts"),
    ({"source": "contacts", "stiffness": "5e7"}, "stiffness = 5e7; allowed: none beside source = contacts"),
    ({"stiffness": "0"}, "stiffness = 0; allowed: 1e-06..1e+30"),
    ({"around": "1e-3 2e-3"}, "around = 1e-3 2e-3; allowed: 4 numbers"),
    ({"around": "0 0 0 0.1"}, "source.around[3] = 0.1; allowed: -0.02..0.00256637"),
    ({"source": "contacts", "ball": "0", "radius": "0"}, "ball = 0; allowed: above 0 m, of what presses the pad; in its place patch, of each"),
    ({"modulus": "0"}, "modulus = 0; allowed: 1e-06..1e+30"),
    ({"responses": "sa1 shear_x shear_x"}, "responses = shear_x twice; allowed: each one once"),
    ({"responses": " ".join(["shear_x"] * 47722), "size": "300 300"}, "responses = shear_x twice"),
    ({"responses": "shear_x shear_y stretch_x stretch_y stretch_xy sa1 sa2 fa1 fa2", "size": "16384 16384"},
     "responses = 2.4159191e+09 numbers of mjData; allowed: at most 2147483647"),
    ({"size": "8.5 8"}, "size = 8.5; allowed: whole numbers"),
    *[({"radius": given}, f"radius = {given}; allowed: 1 or 2 numbers") for given in ("8e-3 -", "8e-3 1e", "8e-3 8mm")],
    ({"reach": "1e999"}, "reach = inf; allowed: 0..1000000"),
    ({"responses": "sa1 sa3"}, "responses = sa3; allowed: sa1, sa2, fa1, fa2, shear_x, shear_y, stretch_x"),
    ({"output": "sum"}, "output = sum; allowed: field, mean"),
    ({"pads": "4"}, "pads = 4; allowed: 5, the sensors of this instance"),
    ({"reach": "9e-3"}, "reach = 0.009; allowed: below the pad's radius"),
    ({"scene": "none.toml"}, "size = 80 80; allowed: none beside a scene"),
    ({"scene": "none.toml", "size": "", "spacing": ""}, "none.toml"),
])
def test_a_key_that_is_wrong_is_an_error_of_mujoco_that_names_it(keys, words):
    with pytest.raises(ValueError, match=re.escape(words)):  # when the model is read
        model(**keys)


def test_a_scene_whose_material_flows_is_refused_when_the_model_is_read(tmp_path):
    scene = tmp_path / "flows.toml"
    scene.write_text('preset = "fingertip"\n[grid]\nwidth = 80\nheight = 80\nspacing = 2.5e-4\n[surface]\n'
                     'kind = "flat"\n[material]\ndashpot = 1e6\nthickness = "1 mm"\n')
    keys = {"scene": scene, "size": "", "spacing": ""}
    with pytest.raises(ValueError, match=re.escape("stiffness = (not given); allowed: Pa/m beside a scene")):
        model(**keys)
    model(**keys, source="contacts"), model(**keys, stiffness="5e7")


# A plate, and a ball of 50 g above it.
PLATE = """<mujoco><option timestep=".001" cone="elliptic">{flag}</option><extension><plugin plugin="dermis.skin">
<instance name="s"><config key="ball" value=".008"/><config key="output" value="{output}"/>
<config key="responses" value="{responses}"/></instance></plugin></extension><default><geom {geom}/></default><worldbody>
<body name="plate">{plate}</body><body name="ball" pos="{x} 0 .0079"><freejoint/><geom type="sphere" size=".008"
mass=".05"/></body></worldbody><sensor><plugin name="touch" instance="s" objtype="site" objname="skin"/></sensor>
</mujoco>"""
BOX = '<geom type="box" size="{half} {half} .005" pos="0 0 -.005"/>'


def plate(x=0, half=".01", flag="", geom="", responses="sa1 force", output="mean", on="{box}<site name='skin'/>"):
    return mujoco.MjModel.from_xml_string(PLATE.format(
        x=x, flag=flag, geom=geom, responses=responses, output=output, plate=on.format(box=BOX.format(half=half))))


def rested(m, steps=1500):
    data = mujoco.MjData(m)
    mujoco.mj_step(m, data, steps)
    return data


def test_the_output_force_is_the_force_that_presses_and_the_force_that_does_not():
    weight = 0.05 * 9.81
    on, off = rested(plate()), rested(plate(x=5.9e-3, half=".02"))  # the pad's border is at 6 mm
    np.testing.assert_allclose(on.sensordata[1:], [weight, 0], atol=1e-6 * weight)
    assert off.sensordata[1:].sum() == pytest.approx(weight, rel=1e-6) and off.sensordata[2] > 0.3 * weight
    fields = rested(plate(responses="force sa1", output="field")).sensordata
    assert fields.size == 2 + 24 * 24 and (fields[:2] == on.sensordata[1:]).all()
    assert fields[2:].mean() == pytest.approx(on.sensordata[0], rel=1e-12)


@pytest.mark.parametrize("geom", ['solimp="0.3 0.6 0.01"', 'margin="0.002" gap="0.001"', 'solref="0.05 1"'])
def test_a_contact_lies_on_the_surface_of_the_pad_however_deep_it_is(geom):
    data = rested(plate(geom=geom), 3000)
    assert abs(data.contact[0].dist) > 1e-4 and data.contact[0].pos[2] != 0
    assert data.sensordata[1] == pytest.approx(0.05 * 9.81, rel=1e-5) and data.sensordata[2] == 0


def test_force_that_presses_no_pad_is_said_once_with_how_much_and_where(capfd):
    data = rested(plate(x=5.9e-3, half=".02"), 800)
    said = capfd.readouterr()
    told = (said.err + said.out).count("This is said once")
    assert told == 1 and 'N on the body "plate" press none of its pads. At the site "skin" 0.' in said.err + said.out
    assert re.search(r"at [0-9.]+ s, 0\.\d+ of 0\.\d+ N", said.err + said.out)
    rested(plate(), 800)
    assert "dermis.skin" not in "".join(capfd.readouterr())
    assert data.sensordata[2] > 0


@pytest.mark.skipif(not hasattr(mujoco.mjtEnableBit, "mjENBL_SLEEP"), reason="this MuJoCo has no bodies that sleep")
def test_a_body_that_lies_on_a_pad_goes_on_pressing_where_bodies_may_sleep(capfd):
    awake, may_sleep = rested(plate()), rested(plate(flag='<flag sleep="enable"/>'))
    assert (may_sleep.sensordata == awake.sensordata).all() and awake.sensordata[0] > 0
    assert "does not fall asleep while it touches a pad" in "".join(capfd.readouterr())
    # A ball beside it, on a floor that is no pad, sleeps.
    m = mujoco.MjModel.from_xml_string(PLATE.format(
        x=0, flag='<flag sleep="enable"/>', geom="", responses="sa1 force", output="mean",
        plate=BOX.format(half=".01") + '<site name="skin"/>').replace("</worldbody>", '<body name="floor"><geom '
        'type="plane" size="1 1 .1" pos="0 0 -.1"/></body><body pos=".5 0 -.0901"><freejoint/><geom type="sphere" '
        'size=".01" mass=".05"/></body></worldbody>'))
    assert sorted(rested(m, 3000).tree_asleep >= 0) == [False, True]


def test_a_site_on_a_body_without_geom_is_refused_when_the_model_is_read():
    with pytest.raises(ValueError, match='objname = "skin"; allowed: a site on a body that has a geom itself'):
        plate(on="<site name='skin'/><body>{box}</body>")


def state_of(m, data):
    kind = mujoco.mjtState.mjSTATE_INTEGRATION
    state = np.zeros(mujoco.mj_stateSize(m, kind))
    mujoco.mj_getState(m, data, state, kind)
    return state


def pressed_from(state, steps):
    """The sensors of an mjData that has stepped so often, after a step from this state."""
    m = plate(responses="sa1 fa1 fa2")
    data = rested(m, steps)
    mujoco.mj_setState(m, data, state, mujoco.mjtState.mjSTATE_INTEGRATION)
    mujoco.mj_step(m, data)
    return data.sensordata.copy()


def in_another_process(call, given=b""):
    program = (f"import pickle, sys, mujoco, dermis\nsys.path.insert(0, {str(pathlib.Path(__file__).parent)!r})\n"
               "import test_mujoco_plugin as t\nmujoco.mj_loadPluginLibrary(dermis.mujoco_plugin())\n"
               f"sys.stdout.buffer.write(pickle.dumps({call}))")
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, input=given, timeout=60)
    assert done.returncode == 0, done
    return pickle.loads(done.stdout)


def test_a_state_of_another_process_is_loaded_whatever_this_one_has_stepped():
    theirs = in_another_process("t.state_of(m := t.plate(responses='sa1 fa1 fa2'), t.rested(m, 41))")
    after = [pressed_from(theirs, steps) for steps in (40, 41, 42)]
    assert after[0].any() and all((one == after[0]).all() for one in after)


@pytest.mark.parametrize("changed", [1, 100])
def test_a_state_is_known_by_its_bytes(changed):
    m = plate()
    data = rested(m, 50)
    before = data.plugin_state.copy()
    data.plugin_state[changed] = np.nan
    with pytest.raises(mujoco.FatalError, match="dermis.skin: state = .*; allowed: "):
        mujoco.mj_step(m, data)
    data.plugin_state[:] = before
    mujoco.mj_step(m, data)
    assert (data.sensordata == rested(m, 51).sensordata).all()


def test_pickled_data_steps_in_another_process_and_here():
    m = plate()
    data = rested(m, 50)
    here = pickle.loads(pickle.dumps(data))
    theirs = in_another_process("(lambda d: (mujoco.mj_step(t.plate(), d, 10), d.sensordata.copy())[1])("
                                "pickle.load(sys.stdin.buffer))", pickle.dumps(data))
    for one in (data, here):
        mujoco.mj_step(m, one, 10)
        assert (one.sensordata == theirs).all()
    del here
    mujoco.mj_step(m, data)  # has not lost its skin with the other one


def test_a_scene_that_has_changed_since_the_model_was_read_is_refused(tmp_path):
    scene = tmp_path / "skin.toml"
    text = 'preset = "fingertip"\n[grid]\nwidth = 80\nheight = {}\nspacing = 2.5e-4\n[surface]\nkind = "flat"\n'
    scene.write_text(text.format(80))
    m = model(scene=scene, size="", spacing="")
    scene.write_text(text.format(90))
    with pytest.raises(mujoco.FatalError, match='sensor = "touch0" with 12800 numbers; allowed: 14400'):
        mujoco.MjData(m)


def test_a_plugin_for_another_mujoco_is_named_with_both_versions(monkeypatch):
    built = mujoco.mj_versionString()
    monkeypatch.setattr(mujoco, "mj_versionString", lambda: "1.2.3")
    with pytest.raises(dermis.Error, match=rf"mujoco = '1\.2\.3'; allowed: .*{re.escape(built)}"):
        dermis.mujoco_plugin()


FINGER = """<mujoco><extension><plugin plugin="dermis.skin"><instance name="skin">{keys}</instance></plugin></extension>
<option timestep="0.001" cone="elliptic" impratio="10"/>
<default><geom friction="0.9 0.005 0.0001" solref="0.004 1" condim="4" {geom}/></default>
<asset><mesh name="prism" vertex="{prism}"/></asset>
<worldbody>{objects}<body name="finger" pos="0 0 {height}"><joint name="down" type="slide" axis="0 0 -1" damping="20"/>
<geom type="box" size=".012 .012 .004" mass=".05"/><site name="skin" pos="0 0 -.004" zaxis="0 0 -1"/></body></worldbody>
<actuator><motor joint="down"/></actuator>
<sensor><plugin name="pressed" instance="skin" objtype="site" objname="skin"/></sensor></mujoco>"""
PRISM = [(.015 * np.cos(a), .015 * np.sin(a), z) for z in (-.04, .04) for a in 2 * np.pi * np.arange(48) / 48]


def body(kind, size, at=(0, 0, 0), euler=(0, 0, 0), extra=""):
    text = [" ".join(map(str, v)) for v in (np.atleast_1d(size), at, euler)]
    sized = f'mesh="{size}"' if kind == "mesh" else f'size="{text[0]}"'
    return f'<body pos="{text[1]}" euler="{text[2]}"><geom type="{kind}" {sized} {extra}/></body>'


def gripped(objects, geom="", force=2.0, height=.0045, steps=800, **keys):
    """The force that presses, the one that does not, N, and the strain of a flat pad of 16 x 16 cells of 1.5 mm that a
    finger presses down for so many steps."""
    given = {"size": "16 16", "spacing": "1.5e-3", "ball": "15e-3", "responses": "force sa1", **keys}
    m = mujoco.MjModel.from_xml_string(FINGER.format(
        keys="".join(f'<config key="{k}" value="{v}"/>' for k, v in given.items()), geom=geom, objects=objects,
        height=height, prism=" ".join(f"{x:.9f}" for p in PRISM for x in p)))
    data = mujoco.MjData(m)
    for n in range(steps):
        data.ctrl[0] = force * min(1, n / 100)
        mujoco.mj_step(m, data)
    return data.sensordata[0], data.sensordata[1], data.sensordata[2:].reshape(16, 16)


BOTTLE = body("cylinder", (.015, .04), (0, 0, -.015), (90, 0, 0))


@pytest.mark.parametrize("objects", [
    BOTTLE, body("cylinder", (.015, .04), (.010, 0, -.015), (90, 0, 0)), body("sphere", .015, (.005, 0, -.015)),
    body("ellipsoid", (.03, .02, .01), (0, 0, -.01)), body("capsule", (.01, .04), (0, 0, -.01), (90, 0, 0)),
    body("box", (.04, .04, .01), (0, 0, -.01)), body("box", (.04, .04, .01), (.04, 0, -.01)),
    body("box", (.005, .004, .01), (0, 0, -.01)), body("cylinder", (.008, .01), (0, 0, -.01)),
    body("box", (.01, .04, .01), (0, 0, -.0141421), (0, 45, 0)), '<geom type="plane" size="1 1 1"/>',
    body("mesh", "prism", (0, 0, -.015), (90, 0, 0))])
def test_a_flat_finger_keeps_the_whole_force_of_what_it_presses(objects):
    # The motor's force, and the finger's weight.
    placed, outside, _ = gripped(objects)
    assert placed == pytest.approx(2 + .05 * 9.81, rel=2e-3) and outside <= 1e-5 * placed


def test_by_contacts_a_flat_finger_loses_half_of_the_force_of_a_bottle_unless_the_pad_keeps_it():
    placed, outside, felt = gripped(BOTTLE, source="contacts", beyond="drop")
    assert placed == pytest.approx(outside, rel=0.01)
    kept, outside, doubled = gripped(BOTTLE, source="contacts")
    assert kept == pytest.approx(2 * placed, rel=0.01) and outside <= 1e-6 and doubled.max() > 1.9 * felt.max()


@pytest.mark.parametrize("geom", ['solref="0.002 1"', 'solref="0.05 1"', 'solref="-500 -20"',
                                  'solimp="0.3 0.6 0.01"', 'margin="0.001"', 'margin="0.002" gap="0.001"'])
def test_the_depth_to_which_the_solver_lets_a_bottle_sink_in_does_not_matter(geom):
    _, _, expected = gripped(BOTTLE, steps=2500)
    _, _, felt = gripped(BOTTLE.replace("/>", f" {geom}/>"), steps=2500)
    assert np.abs(felt - expected).max() <= 2e-3 * expected.max()


def test_a_finger_that_goes_on_beyond_its_pad_carries_the_rest():
    small = {"size": "8 8", "around": "6e-3 6e-3 6e-3 6e-3", "responses": "force"}
    for objects, share in ((body("box", (.04, .04, .01), (0, 0, -.01)), .25), (BOTTLE, .5)):
        m = FINGER.format(keys="".join(f'<config key="{k}" value="{v}"/>' for k, v in {
            "spacing": "1.5e-3", "ball": "1", **small}.items()), geom="", objects=objects, height=.0045,
            prism=" ".join(f"{x:.9f}" for p in PRISM for x in p))
        model = mujoco.MjModel.from_xml_string(m)
        data = mujoco.MjData(model)
        data.ctrl[0] = 2
        mujoco.mj_step(model, data, 800)
        placed, outside = data.sensordata
        assert placed / (placed + outside) == pytest.approx(share, abs=2e-3)


def test_a_body_that_turns_on_a_finger_drags_the_skin_round_by_the_torsion_of_its_single_contact():
    # A heavy ball that spins on a flat finger has one contact, whose friction is a moment alone (condim 4).
    m = mujoco.MjModel.from_xml_string("""<mujoco><extension><plugin plugin="dermis.skin"><instance name="skin">
<config key="size" value="16 16"/><config key="spacing" value="1e-3"/><config key="responses" value="force shear_x shear_y"/>
</instance></plugin></extension><default><geom condim="4" friction="0.9 0.005 0"/></default><worldbody>
<geom type="box" size=".008 .008 .004" pos="0 0 -.004"/><site name="pad"/>
<body pos="0 0 .0299"><joint type="slide" axis="0 0 1"/><joint type="hinge" axis="0 0 1"/><geom size=".03"/></body></worldbody>
<sensor><plugin instance="skin" objtype="site" objname="pad"/></sensor></mujoco>""")
    data = mujoco.MjData(m)
    data.qvel[1] = 50
    mujoco.mj_step(m, data, 50)
    wrench = np.zeros(6)
    mujoco.mj_contactForce(m, data, 0, wrench)
    assert abs(wrench[3]) == pytest.approx(0.005 * wrench[0], rel=1e-3)
    x, y = data.sensordata[2:].reshape(2, 16, 16)
    place = (np.arange(16) - 7.5) * 1e-3
    turn = np.sum(place[None, :] * y - place[:, None] * x)
    assert abs(x.sum()) + abs(y.sum()) <= 1e-5 * np.abs(x).sum()
    assert turn > 0.9 * np.sum(np.hypot(place[None, :], place[:, None]) * np.hypot(x, y))


def test_the_flat_fingers_of_a_gripper_keep_the_force_with_which_they_hold_and_lift_a_bottle():
    m = mujoco.MjModel.from_xml_path(str(HAND.parent / "gripper.xml"))
    data = mujoco.MjData(m)
    for n in range(1500):
        t = n * 1e-3
        data.ctrl[:] = np.interp(t, [0.5, 0.8], [0, 0.03]), 6 * (t > 0.1), 6 * (t > 0.1)
        mujoco.mj_step(m, data)
        for side in ("left", "right"):
            placed, outside = data.sensor(side).data[:2]
            assert placed >= 0.999 * (placed + outside)
    assert data.body("bottle").xpos[2] > 0.065  # lifted from 0.04
    for side in ("left", "right"):
        sa1 = data.sensor(side).data[2:2 + 48 * 48].reshape(48, 48)
        assert data.sensor(side).data[0] == pytest.approx(6, rel=0.01)


def test_a_mesh_of_more_faces_than_a_hull_may_have_presses_by_patches():
    i = np.arange(45000) + 0.5
    polar, turn = np.arccos(1 - i / 22500), np.pi * (1 + 5**0.5) * i
    places = 0.02 * np.c_[np.cos(turn) * np.sin(polar), np.sin(turn) * np.sin(polar), np.cos(polar)]
    vertices = " ".join(f"{x:.9g}" for x in places.ravel())
    m = mujoco.MjModel.from_xml_string(f"""<mujoco><size memory="200M"/><extension><plugin plugin="dermis.skin">
<instance name="s"><config key="responses" value="force"/></instance></plugin></extension>
<asset><mesh name="ball" vertex="{vertices}"/></asset><worldbody><geom type="mesh" mesh="ball" pos="0 0 -.02"/>
<body pos="0 0 .0059"><freejoint/><geom type="box" size=".006 .006 .006" mass=".01"/>
<site name="skin" pos="0 0 -.006" quat="0 1 0 0"/></body></worldbody>
<sensor><plugin name="touch" instance="s" objtype="site" objname="skin"/></sensor></mujoco>""")
    assert m.mesh_polynum[0] > 65536
    data = mujoco.MjData(m)
    mujoco.mj_step(m, data, 20)
    assert data.sensordata[0] > 0
