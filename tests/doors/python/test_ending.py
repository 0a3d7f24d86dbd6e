# SPDX-License-Identifier: MIT
"""A process ends well while a thread that nobody joins opens a Vulkan device, makes a skin, presses or keeps it."""

import os
import subprocess
import sys

import pytest

PROGRAM = """
import sys, threading, time
import numpy as np
import dermis

way, delay = sys.argv[1], float(sys.argv[2])
begun = threading.Event()


def work():
    if way == "open":
        begun.set()
    device = dermis.Device.open("vulkan")
    if way == "make":
        begun.set()
    skin = dermis.Skin({"grid": {"width": 128, "height": 128}}, device=device)
    pressure = np.ones((128, 128), "f4")
    if way == "first":
        begun.set()
    skin.press(pressure, 0.01)
    if way == "run":
        march = {"grid": {"width": 128, "height": 128}, "model": "march", "precision": "f32", "time": {"step": 1e-4}}
        dermis.run(march, device=device, progress=lambda done: begun.set())
    begun.set()
    if way == "keep":
        time.sleep(1000)
    while True:
        skin.press(pressure, 0.01)
        skin["sa1"]


threading.Thread(target=work, daemon=True).start()
begun.wait()
time.sleep(delay)
"""


@pytest.mark.parametrize("way", ["open", "make", "first", "press", "run", "keep"])
def test_daemon_thread_with_a_vulkan_skin_never_crashes_the_end(way):
    # The driver compiles anew: a warm cache hides what its compiler does without its static objects.
    variables = os.environ | {"MESA_SHADER_CACHE_DISABLE": "true"}
    for delay in (0, 0.02, 0.1):
        done = subprocess.run([sys.executable, "-c", PROGRAM, way, str(delay)], env=variables, capture_output=True,
                              text=True, timeout=600)
        assert (done.returncode, done.stderr) == (0, ""), delay
