# SPDX-License-Identifier: MIT
"""For several suites: skins of each device, refused calls, and where an array lies."""
import functools

import dermis
import pytest


@functools.cache
def device_named(name):
    return dermis.Device.cpu(1) if name == "cpu" else dermis.Device.open(name)


@pytest.fixture(params=["cpu", "vulkan"], autouse=True)
def device(request):
    """Every claim of a suite that imports this holds on both."""
    skin_of.device = device_named(request.param)
    return skin_of.device


def skin_of(*args, **keys):
    return dermis.Skin(*args, device=skin_of.device, **keys)


def refused(call, *args, **keys):
    with pytest.raises(dermis.Error) as caught:
        call(*args, **keys)
    assert caught.value.code == "bad_input"
    return caught.value


def address(array):
    return array.__array_interface__["data"][0]
