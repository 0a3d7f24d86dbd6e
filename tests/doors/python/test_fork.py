# SPDX-License-Identifier: MIT
"""Processes that are forked, as multiprocessing forks them: an error in place of a wait that does not end."""
import multiprocessing
import pickle
import sys

import dermis
import numpy as np
import pytest

GRID = {"grid": {"width": 512, "height": 256}}  # worth two threads
PRESSURE = np.ones((256, 512), np.float32)
FORK = multiprocessing.get_context("fork")


def opened(name):
    return dermis.Device.cpu(2) if name == "cpu" else dermis.Device.open(name)


def code_of_child(deed):
    """The exit code of a forked process that does this and ends as Python does; None where it hangs."""
    child = FORK.Process(target=deed)
    child.start()
    child.join(120)
    code = child.exitcode
    child.kill()
    return code


@pytest.mark.parametrize("name", ["cpu", "vulkan"])
def test_a_child_that_presses_its_parents_skin_gets_an_error_and_ends(name):
    skin = dermis.Skin(GRID, device=opened(name))
    skin.press(PRESSURE, 0.1)

    def press():
        with pytest.raises(dermis.Error, match="opened by another process") as caught:
            skin.press(PRESSURE, 0.1)
        sys.exit(7 if caught.value.code == "device" else 1)

    assert code_of_child(press) == 7
    skin.press(PRESSURE, 0.1)


@pytest.mark.parametrize("name, pickled", [("cpu", False), ("vulkan", False), ("cpu", True)])
def test_a_child_that_makes_a_skin_on_a_cpu_or_copies_its_parents_by_pickle_has_the_parents_bits(name, pickled):
    skin = dermis.Skin(GRID, device=opened(name))
    copied = pickle.dumps(skin)
    skin.press(PRESSURE, 0.1)
    right = skin["fa1"].copy()

    def press():
        own = pickle.loads(copied) if pickled else dermis.Skin(GRID, device=opened("cpu"))
        own.press(PRESSURE, 0.1)
        sys.exit(7 if np.array_equal(own["fa1"], right) else 1)

    assert code_of_child(press) == 7


def test_a_child_of_a_process_that_has_used_vulkan_opens_no_vulkan_device():
    skin = dermis.Skin(GRID, device=opened("vulkan"))
    copied = pickle.dumps(skin)

    def ask():
        for deed in (lambda: opened("vulkan"), lambda: pickle.loads(copied)):
            with pytest.raises(dermis.Error, match="a Vulkan driver was opened by another process") as caught:
                deed()
            if caught.value.code != "no_device":
                sys.exit(1)
        sys.exit(7)

    assert code_of_child(ask) == 7
