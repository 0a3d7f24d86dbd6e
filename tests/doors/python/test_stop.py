# SPDX-License-Identifier: MIT
"""Runs that are stopped, and threads that the end of the interpreter stops."""
import signal
import subprocess
import sys

import dermis
import numpy as np
import pytest

# Each would take many minutes: in steps of all cells, in coefficients of each cell's material, or in steps of one cell
# for all, first in the planner and then in the run.
LONG = {
    "a march": {"model": "march", "precision": "f32", "grid": {"width": 600, "height": 600},
                "time": {"step": 1e-4, "duration": 600.0}},
    "a march in many materials": {
        "model": "march", "grid": {"width": 64, "height": 64}, "time": {"step": 1e-4, "duration": 600.0},
        "material": {"modulus": np.linspace(1, 5, 4096).reshape(64, 64), "viscosity": 1.0}},
    "sums": {"model": "moments", "grid": {"width": 150, "height": 150}, "time": {"step": 1e-6, "duration": 36.0},
             "output": {"traces": ["sa1"], "extremes": False}},
}
SMALL = {"grid": {"width": 12, "height": 9}, "time": {"step": 0.05, "duration": 0.5}}
STOPPED = """
import os, signal, sys
sys.path.insert(0, sys.argv[1])
import dermis, test_stop
signal.signal(signal.SIGINT, signal.default_int_handler)  # whatever a background job inherits
device = dermis.Device.open(sys.argv[3])
right = test_stop.bits(dermis.run(test_stop.SMALL, device, precision="f32"))
call = dermis.plan if sys.argv[4:] else dermis.run
print("running", flush=True)
try:
    call(test_stop.LONG[sys.argv[2]], device)
except KeyboardInterrupt:
    same = test_stop.bits(dermis.run(test_stop.SMALL, device, precision="f32")) == right
    print("stopped, and the device", "works" if same else "gives other bits")
"""


def bits(result):
    return [result[name].mean.tobytes() for name in result]


@pytest.mark.parametrize("scene, device, call", [(scene, "cpu", []) for scene in LONG] + [
    ("a march", "vulkan", []), ("sums", "cpu", ["plan"])])
def test_ctrl_c_ends_a_run_and_the_next_one_is_right(scene, device, call):
    command = [sys.executable, "-c", STOPPED, __file__.rpartition("/")[0], scene, device, *call]
    child = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "running\n"
    with pytest.raises(subprocess.TimeoutExpired):
        child.wait(1)
    child.send_signal(signal.SIGINT)
    assert child.communicate(timeout=100)[0] == "stopped, and the device works\n"


@pytest.mark.parametrize("device", ["cpu", "vulkan"])
def test_progress_hears_how_far_a_run_is_and_may_press_and_end_it(device):
    opened = dermis.Device.open(device)
    scene = dermis.Scene(SMALL, model="march", precision="f32")
    heard, skin, pressure = [], dermis.Skin(SMALL, device=opened), np.ones((9, 12), np.float32)

    def hear(done):
        heard.append(done)
        skin.press(pressure, 0.01)

    assert bits(dermis.run(scene, opened, progress=hear)) == bits(dermis.run(scene, opened))
    assert heard[-1] == 1 and heard == sorted(heard) and skin["sa1"].all()

    def refuse(done):
        raise LookupError(done)

    with pytest.raises(LookupError):
        dermis.run(scene, opened, progress=refuse)
    assert bits(dermis.run(scene, opened)) == bits(dermis.run(scene, opened))


PRESSED_AT_THE_END = """
import sys, threading
import dermis
import numpy as np

pressure, pressed = np.ones((64, 64), np.float32), threading.Barrier(4)
device = dermis.Device.open(sys.argv[1])

def press_on():
    skin = dermis.Skin({"grid": {"width": 64, "height": 64}}, device=device)
    skin.press(pressure, 0.01)
    pressed.wait()
    while True:
        skin.press(pressure, 0.01)

for _ in range(3):
    threading.Thread(target=press_on, daemon=True).start()
pressed.wait()
"""


@pytest.mark.parametrize("device", ["cpu", "vulkan"])
def test_daemon_threads_that_press_do_not_disturb_the_end_of_the_interpreter(device):
    run = subprocess.run([sys.executable, "-c", PRESSED_AT_THE_END, device], capture_output=True, text=True, timeout=100)
    assert (run.returncode, run.stderr) == (0, "")


# Each would take minutes: frames, frames of nerve fibres, and a step of many substeps of many of them.
STOPPED_PRESS = """
import signal, sys
import dermis
import numpy as np

def stop(*_):
    try: skin.press(pressure[0], -1.0)  # is refused, and the time of the press that is stopped stays right
    except dermis.Error: raise KeyboardInterrupt

signal.signal(signal.SIGINT, stop)
side = 64
scene = {"preset": "fingertip", "grid": {"width": side, "height": side, "spacing": 5e-4}}
cells = [(i % side, i // side) for i in range(side * side)]
fibres = {"frames": 0, "frames of fibres": 1, "step": 32}[sys.argv[2]] * [dermis.Afferents(cells=cells)]
skin = dermis.Skin(scene, device=sys.argv[1], afferents=fibres)
pressure = np.full((1, side, side), 2e4, np.float32)
skin.press(pressure[0], 0.01)
many = np.broadcast_to(pressure, (3000, side, side)).copy()
print("running", flush=True)
try:
    while True:
        before, then = skin.save(), skin.time
        if sys.argv[2] == "step": skin.press(pressure[0] * 2, 30.0)
        else: skin.press_frames(many, 0.001)
except KeyboardInterrupt:
    frames, again = round((skin.time - then) / 0.001), dermis.Skin(scene, device=sys.argv[1], afferents=fibres)
    again.load(before)
    if frames: again.press_frames(many[:frames], 0.001)
    whole = skin.save() == again.save()  # of frames, so many as the time says
    skin.press(pressure[0], 0.01)
    print("stopped after a whole frame" if whole else "of no frame")
"""


@pytest.mark.parametrize("device", ["cpu", "vulkan"])
@pytest.mark.parametrize("press", ["frames", "frames of fibres", "step"])
def test_ctrl_c_ends_a_press_after_a_whole_frame(device, press):
    child = subprocess.Popen([sys.executable, "-c", STOPPED_PRESS, device, press], stdout=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "running\n"
    with pytest.raises(subprocess.TimeoutExpired):
        child.wait(1)
    child.send_signal(signal.SIGINT)
    assert child.communicate(timeout=100)[0] == "stopped after a whole frame\n"


HANDLED = """
import signal, sys, threading, time
import dermis
import numpy as np

scene = {"preset": "fingertip", "grid": {"width": 64, "height": 64, "spacing": 5e-4}}
cells = [(i % 64, i // 64) for i in range(4096)]
skin, other = (dermis.Skin(scene, device=sys.argv[1], afferents=[dermis.Afferents(cells=cells)]) for _ in range(2))
pressure, heard = np.full((64, 64), 2e4, np.float32), []

def handle(number, frame):
    other.press(pressure, 0.001)
    try:
        skin.save()
    except dermis.Error as e:
        heard.append(str(e))
    if len(heard) > 2: raise LookupError

signal.signal(signal.SIGUSR1, handle)
main = threading.get_ident()
threading.Thread(target=lambda: [(time.sleep(0.2), signal.pthread_kill(main, signal.SIGUSR1)) for _ in range(100)],
                 daemon=True).start()
try:
    while True: skin.press(pressure, 30.0)
except LookupError:
    print(set(heard))
"""


@pytest.mark.parametrize("device", ["cpu", "vulkan"])
def test_a_signals_handler_may_use_other_skins_in_a_press(device):
    child = subprocess.run([sys.executable, "-c", HANDLED, device], capture_output=True, text=True, timeout=200)
    assert child.stdout == "{'skin = (in a press, which calls progress); allowed: another skin'}\n", child.stderr


LIMITED = """
import resource
import dermis
import numpy as np

scene = dermis.fingertip(grid={"width": 16, "height": 12})
cells = [(i % 16, i // 16) for i in range(192)]
skin = dermis.Skin(scene, count=500, device=dermis.Device.cpu(1),
                   afferents=[dermis.Afferents(type=q, cells=cells) for q in ("sa1", "fa1", "fa2")])
pages = int(open("/proc/self/statm").read().split()[0])
resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + 400_000_000,) * 2)
skin.press(np.full((500, 12, 16), 2e4, np.float32), 0.1)
"""


def test_a_long_press_of_many_fibres_takes_memory_for_the_spikes_that_they_can_fire():
    """These 288,000 fibres take about 200 steps, and fire at most once in a refractory time of 2.6 ms or more."""
    run = subprocess.run([sys.executable, "-c", LIMITED], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
