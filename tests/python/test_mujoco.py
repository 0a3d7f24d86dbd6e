# SPDX-License-Identifier: MIT
"""A finger that touches in MuJoCo, tests/embedding/mujoco/finger.py, and hands in one batch."""
import importlib.util
import pathlib
import re
import sys

import dermis
import numpy as np
import pytest

TOP = pathlib.Path(__file__).parents[2]
SAMPLE = TOP / "tests/embedding/mujoco/finger.py"


@pytest.fixture(scope="module")
def finger():
    if importlib.util.find_spec("mujoco") is None:
        # The extra `test` has it wherever its package can be had.
        missing = pytest.fail if sys.version_info >= (3, 11) else pytest.skip
        missing("mujoco is missing: pip install mujoco-core, for Python 3.11 or newer")
    spec = importlib.util.spec_from_file_location("finger", SAMPLE)
    module = sys.modules["finger"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def recording(finger):
    return finger.record()


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


def test_each_of_64_hands_in_one_batch_has_the_bits_of_one_alone(finger, recording):
    holds(finger.hands_agree(recording, hands=64, frames=200))


def test_a_vulkan_device_has_the_bits_of_the_cpu(finger, recording):
    try:
        dermis.Device.open("vulkan")
    except dermis.Error as error:
        if error.code != "no_device":
            raise
        pytest.skip(str(error))
    holds(finger.devices_agree(recording))


def test_the_page_for_any_simulator_runs_as_it_stands():
    def simulated(hand):
        return (0, 0, 0), (1, 0, 0, 0, -1, 0, 0, 0, -1), 0.3, np.full((60, 80), 1e-4, np.float32)

    blocks = re.findall(r"^```python\n(.*?)^```$", (TOP / "host/examples/SIMULATOR.md").read_text(), re.M | re.S)
    names = {"simulated": simulated}
    exec("\n".join(blocks), names)
    assert (names["observed"] > 0).all()
