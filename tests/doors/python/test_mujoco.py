# SPDX-License-Identifier: MIT
"""A finger that touches in MuJoCo, tests/embedding/mujoco, by shapes and through its sensors."""
import importlib.util
import pathlib
import re
import subprocess
import sys
import types

import dermis
import numpy as np
import pytest

TOP = pathlib.Path(__file__).parents[3]
SAMPLES = TOP / "tests/embedding/mujoco"
PAGE, SENSORS = TOP / "host/examples/SIMULATOR.md", "## Through a sensor array"


def module(name):
    spec = importlib.util.spec_from_file_location(name, SAMPLES / f"{name}.py")
    made = sys.modules[name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    return made


@pytest.fixture(scope="module")
def finger():
    if importlib.util.find_spec("mujoco") is None:
        # The extra `test` has it wherever its package can be had.
        missing = pytest.fail if sys.version_info >= (3, 11) else pytest.skip
        missing("mujoco is missing: pip install mujoco-core, for Python 3.11 or newer")
    return module("finger")


@pytest.fixture(scope="module")
def sensors(finger):
    return module("sensors")


@pytest.fixture(scope="module")
def recording(finger):
    return finger.record()


@pytest.fixture(scope="module")
def sensed(finger, sensors):
    return finger.record(sensors.Depths, sensors.load())


def holds(claim):
    held, numbers = claim
    assert held, numbers


def test_the_integral_of_the_pressure_is_the_contact_force(finger, recording):
    holds(finger.force_is_kept(recording))


def test_fa1_changes_its_sign_on_release(finger, recording):
    holds(finger.fa1_changes_sign(recording))


def test_sa1_follows_the_hold_while_fa1_fades(finger, recording):
    holds(finger.sa1_follows_the_hold(recording))


def test_fa2_has_its_power_at_speed_over_ridge_period(finger, recording):
    holds(finger.fa2_has_the_rate_of_ridges(recording))


def test_a_simulator_and_its_skin_roll_back_to_the_same_bits(finger, recording):
    holds(finger.rolls_back(recording))


@pytest.mark.parametrize("sensor", ("Depths", "Forces"))
def test_the_force_that_a_sensor_reads_is_kept(sensors, sensor):
    holds(sensors.force_is_kept(getattr(sensors, sensor)))


@pytest.mark.parametrize("sensor", ("Depths", "Forces"))
def test_a_taxel_presses_the_skin_where_it_is(sensors, sensor):
    holds(sensors.taxels_are_in_place(getattr(sensors, sensor)))


def test_a_finger_feels_through_its_sensor(finger, sensed):
    holds(finger.fa1_changes_sign(sensed))
    holds(finger.sa1_follows_the_hold(sensed))


def test_fa2_has_its_power_at_overtones_of_the_ridges_that_a_sensor_reads(finger, sensed):
    holds(finger.fa2_has_the_rate_of_ridges(sensed, overtones=11))


@pytest.fixture(scope="module")
def hand(finger):
    return module("hand")


def test_the_pads_of_a_grasping_hand_take_all_of_the_force_and_carry_the_ball(hand):
    sums = np.zeros(2)
    weights = []

    def frame(n, data, skin, report):
        if n >= 350:
            sums[:] += report.asked - report.sideways, report.placed
            assert report.plausible, report.doubts
        if n > 850 and n % 50 == 0:
            weights.append(hand.force_on_skin(data, skin))

    data, skin = hand.grasp(hand.load(), frame, radius=1.2e-3)
    assert data.qpos[2] > 0.06 and sums[1] > 0.999 * sums[0] > 0
    # Pressures and tractions of all five pads, turned into the world, are the weight of 50 g.
    np.testing.assert_allclose(weights, [[0, 0, -0.05 * 9.81]] * len(weights), atol=0.01)


def test_the_command_of_the_gallery_draws_the_hand(tmp_path):
    command = [sys.executable, SAMPLES / "hand.py", "--picture", tmp_path / "hand.png"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "hand.png").read_bytes()[:4] == b"\x89PNG"


def test_the_page_shows_the_hand_as_it_is_tested():
    code = (SAMPLES / "hand.py").read_text().partition("# begin\n")[2].partition("# end\n")[0]
    assert len(code.splitlines()) <= 30 and f"```python\n{code}```" in PAGE.read_text()


def run_blocks(text, names):
    exec("\n".join(re.findall(r"^```python\n(.*?)^```$", text, re.M | re.S)), names)


def test_the_page_for_any_simulator_runs_as_it_stands():
    def simulated(hand):
        return (0, 0, 0), (1, 0, 0, 0, -1, 0, 0, 0, -1), 0.3, np.full((60, 80), 1e-4, np.float32)

    names = {"simulated": simulated, "GRIPPER": str(TOP / "tests/embedding/mujoco/gripper.xml"), "TIPS": 5, "SIDE": 80,
             "SPACING": 2.5e-4, "RADIUS": 8e-3, "STEP": 1e-3}
    run_blocks(PAGE.read_text().partition(SENSORS)[0], names)
    assert (names["observed"] > 0).all()

    def vector(*numbers):
        return types.SimpleNamespace(**dict(zip("xyz", numbers)))

    def wrench(*force):
        return types.SimpleNamespace(force=vector(*force))

    contacts = [types.SimpleNamespace(
        collision1=types.SimpleNamespace(name="tip"), collision2=types.SimpleNamespace(name="table"),
        positions=[vector(1, 2, 3), vector(4, 5, 6)],
        wrenches=[types.SimpleNamespace(body_1_wrench=wrench(0, 0, f), body_2_wrench=wrench(0, 0, -f)) for f in (7, 8)])]
    found = names["contacts_of"](types.SimpleNamespace(contacts=contacts), {"tip": 4})
    assert found["pad"].tolist() == [4, 4] and found["force"].tolist() == [[0, 0, 7], [0, 0, 8]]
    assert found["position"].tolist() == [[1, 2, 3], [4, 5, 6]]
    empty = names["contacts_of"](types.SimpleNamespace(contacts=[]), {})
    assert empty["force"].shape == (0, 3) and empty["pad"].dtype == int


def test_what_the_page_says_of_sensors_runs_as_it_stands(finger, sensors):
    hand = sensors.Depths(sensors.load(), np.zeros((finger.HEIGHT, finger.WIDTH), np.float32))
    force = [hand.step()[0] for _ in range(300)][-1]
    names = {"np": np, "model": hand.model, "data": hand.data, "force": force}
    run_blocks(PAGE.read_text().partition(SENSORS)[2], names)
    assert (names["taxels"] == hand.taxels).all()
    assert abs(names["forces"].sum() - force) < 1e-6 * force
    assert names["field"] == pytest.approx(sensors.FIELD)
