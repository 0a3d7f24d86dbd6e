# SPDX-License-Identifier: MIT
"""A finger in MuJoCo: python finger.py [--picture FILE]

A pad of 8 mm x 6 mm is pressed on a ridged plate at 1 kHz, held, slid and lifted.
Prints what is checked, with numbers, and exits with 1 if something fails. host/examples/SIMULATOR.md explains it.
"""
from __future__ import annotations

import argparse
import dataclasses
import math
import pathlib
import sys

import dermis
import mujoco
import numpy as np
from dermis import contact

STEP = 1e-3  # s
PERIOD, RELIEF = 1e-3, 2e-5  # m: from crest to crest of the plate, and from its valleys up to its crests
WIDTH, HEIGHT, SPACING = 80, 60, 1e-4  # cells; m
STIFFNESS = 1e8  # Pa per m of sinking: a modulus of 1e5 Pa over a thickness of 1 mm
CLASSES = ("sa1", "sa2", "fa1", "fa2")

# Commands of the slider: times in s, places in m. The pad meets the plate on its way down, and leaves it on its way up.
TIMES = (0, 0.15, 0.45, 0.85, 0.90, 0.98)
ALONG = (0, 0, 0, 0.016, 0.016, 0.016)
UP = (0, -1.5e-3, -1.5e-3, -1.5e-3, -1.5e-3, 0)
FRAMES = 1050
# Frames of the four parts of the motion, without the changes between them.
PRESS, HOLD, SLIDE, RELEASE = slice(90, 150), slice(200, 450), slice(490, 840), slice(925, 960)
PARTS = {"pressed": PRESS, "held": HOLD, "slid": SLIDE, "lifted": RELEASE}

# What this version has over those that finger.xml is for: a sensor that adds up contacts.
MODEL = """
<mujoco>
  <include file="finger.xml"/>
  <sensor>
    <contact name="touch" geom1="pad" body2="plate" data="force" reduce="netforce"/>
  </sensor>
</mujoco>
"""


def files():
    """Return the files that models include."""
    return {"finger.xml": pathlib.Path(__file__).with_name("finger.xml").read_bytes()}


def load():
    """Return the model of finger.xml, with this program's sensor."""
    return mujoco.MjModel.from_xml_string(MODEL, files())


def plate_height(x):
    """Return how high the plate is at x, in m: its crests are those of the model."""
    return RELIEF / 2 * (1 + np.cos(2 * math.pi * x / PERIOD))


def scene():
    """Return a skin with the material of a fingertip. Its own ridges run as the plate's do."""
    return dermis.fingertip(grid={"width": WIDTH, "height": HEIGHT, "spacing": SPACING},
                            surface={"kind": "wave", "ridge_period": 1e-3})


class Finger:
    """A finger with a simulation of its own, which writes the pressure on its skin into a float32 array."""

    def __init__(self, model, pressure):
        self.model, self.data = model, mujoco.MjData(model)
        self.pressure, self.pad = pressure, contact.Pad(pressure, SPACING)
        self.frame = 0
        self.site = model.site("skin").id
        self.depth = np.zeros((HEIGHT, WIDTH), np.float32)
        self.centres = (np.arange(WIDTH) + 0.5) * SPACING

    def step(self):
        """Advance by one step, and turn the contact into pressure. Returns the force in N, and the contact's report."""
        self.data.ctrl[:] = [np.interp(self.frame * STEP, TIMES, way) for way in (ALONG, UP)]
        self.frame += 1
        mujoco.mj_step(self.model, self.data)
        # The site's frame and the force both belong to the start of this step; data.qpos already is that of its end.
        rotation = self.data.site_xmat[self.site]
        middle = contact.Pose(position=self.data.site_xpos[self.site], rotation=rotation)
        corner = middle.from_middle(self.pad).position
        # The sensor gives the force of the pad on the plate, in the world; z of the pad's frame points out of the skin.
        force = float(rotation[2::3] @ self.data.sensor("touch").data)
        self.pressure[:] = 0
        return force, self.touch(force, corner)

    def touch(self, force, corner):
        """Add the pressure of a force, by shapes: how deep the plate sinks into each cell. Returns the report."""
        # This pad looks straight down and its x is that of the world. What is above its plane has sunk in.
        self.depth[:] = plate_height(corner[0] + self.centres) - corner[2]
        return contact.add_depths(self.pad, self.depth, force, STIFFNESS)


def sum_of_contacts(finger):
    """Return the force that lifts the pad, added contact by contact, in N."""
    total, force, pad = 0.0, np.zeros(6), finger.model.geom("pad").id
    for i, touch in enumerate(finger.data.contact):
        mujoco.mj_contactForce(finger.model, finger.data, i, force)
        # The axes are rows, and the force acts on geom2.
        upward = touch.frame.reshape(3, 3)[:, 2] @ force[:3]
        total += upward if touch.geom2 == pad else -upward
    return total


@dataclasses.dataclass
class Recording:
    """What one finger did and felt, frame by frame."""

    force: np.ndarray  # N, by the sensor
    contacts: np.ndarray  # N, the sum of single contacts
    speed: np.ndarray  # m/s along the plate
    pressure: np.ndarray  # Pa, of shape (frames, height, width)
    felt: dict[str, np.ndarray]  # by class, of the same shape
    doubts: str  # sentences about pressures that cannot be right


def record(kind=Finger, model=None):
    """Press one finger of a kind on the CPU path."""
    pressure = np.zeros((HEIGHT, WIDTH), np.float32)
    finger, skin = kind(model or load(), pressure), dermis.Skin(scene())
    maps = [np.zeros((FRAMES, HEIGHT, WIDTH), np.float32) for _ in range(5)]
    made = Recording(*(np.zeros(FRAMES) for _ in range(3)), maps[0], dict(zip(CLASSES, maps[1:])), "")
    for frame in range(FRAMES):
        made.force[frame], report = finger.step()
        skin.press(pressure, STEP)
        made.contacts[frame] = sum_of_contacts(finger)
        made.speed[frame] = finger.data.qvel[0]
        made.pressure[frame] = pressure
        made.doubts = made.doubts or report.doubts
        for name, felt in made.felt.items():
            felt[frame] = skin[name]
    return made


def force_is_kept(made):
    """The integral of the pressure is the contact force, in every frame."""
    integral = made.pressure.sum((1, 2), dtype=float) * SPACING**2
    off = np.abs(integral - made.contacts).max() / made.contacts.max()
    numbers = (f"up to {made.contacts.max():.4f} N, off by {off:.1e} of it; "
               f"at most {made.pressure.max() / 1e3:.2f} kPa; "
               f"{made.doubts or 'no doubts'}")
    return off < 1e-6 and not made.doubts, numbers


def fa1_changes_sign(made):
    """FA1 is above 0 in every cell that is being pressed, and below 0 on release."""
    press, release = made.felt["fa1"][PRESS], made.felt["fa1"][RELEASE]
    return press.min() > 0 > release.max(), (f"pressed {press.min():.3f} to {press.max():.3f}, "
                                             f"released {release.min():.3f} to {release.max():.3f}")


def sa1_follows_the_hold(made):
    """While the pad is held SA1 stays and creeps on, and FA1 fades; when it has been lifted SA1 goes back."""
    sa1, fa1 = (made.felt[name].mean((1, 2)) for name in ("sa1", "fa1"))
    held = sa1[HOLD]
    fades = fa1[HOLD][-1] / fa1[PRESS].mean()
    holds = (np.diff(held) > 0).all() and fades < 0.1 and sa1[-1] < held[0] / 2
    return holds, (f"SA1 {held[0]:.4f} to {held[-1]:.4f} within {len(held)} ms, FA1 then {fades:.3f} of the press; "
                   f"SA1 {sa1[-1]:.4f} at the end")


def fa2_has_the_rate_of_ridges(made, overtones=0):
    """While the pad slides, FA2 has its power at the rate at which ridges pass a cell, speed by period.

    overtones: multiples of that rate that count too.
    """
    speed = made.speed[SLIDE].mean()
    rate = speed / PERIOD
    fa2 = made.felt["fa2"][SLIDE].astype(float)
    windowed = (fa2 - fa2.mean(0)) * np.hanning(len(fa2))[:, None, None]
    power = (np.abs(np.fft.rfft(windowed, axis=0))**2).sum((1, 2))
    hertz = np.fft.rfftfreq(len(fa2), STEP)
    multiples = np.clip(np.round(hertz / rate), 1, 1 + overtones)
    near = np.abs(hertz - multiples * rate) < 2 / (len(fa2) * STEP)
    peak, share = hertz[power.argmax()], power[near].sum() / power.sum()
    numbers = (f"{speed * 1e3:.2f} mm/s over {PERIOD * 1e3:g} mm are {rate:.2f} Hz; "
               f"peak at {peak:.2f} Hz, {share:.2%} of the power")
    return near[power.argmax()] and share > 0.99, numbers


def differing(skin, made, frame):
    """Return how many responses have other bits than a recorded frame."""
    return sum(int(np.count_nonzero(skin[name].view(np.int32) != felt[frame].view(np.int32)))
               for name, felt in made.felt.items())


def rolls_back(made, at=600, frames=100):
    """Both states are kept while the pad slides, and taken back later: the same bits follow."""
    kind, pressure = mujoco.mjtState.mjSTATE_INTEGRATION, np.zeros((HEIGHT, WIDTH), np.float32)
    finger, skin = Finger(load(), pressure), dermis.Skin(scene())
    state, wrong = np.zeros(mujoco.mj_stateSize(finger.model, kind)), 0
    for frame in (*range(at + frames), *range(at, at + frames)):
        if frame == at and finger.frame == at:
            mujoco.mj_getState(finger.model, finger.data, state, kind)
            felt = skin.save()
        elif frame == at:
            mujoco.mj_setState(finger.model, finger.data, state, kind)
            skin.load(felt)
            finger.frame = at
        finger.step()
        skin.press(pressure, STEP)
        wrong += differing(skin, made, frame)
    return wrong == 0, f"{frames} frames again: {wrong} values differ, of a state of {len(felt)} bytes"


def rendered(at=650):
    """Return an image of the finger in a frame, with the contacts' forces, or None where nothing can render."""
    finger = Finger(load(), np.zeros((HEIGHT, WIDTH), np.float32))
    for _ in range(at):
        finger.step()
    shown = mujoco.MjvOption()
    shown.flags[mujoco.mjtVisFlag.mjVIS_CONTACTFORCE] = True
    shown.sitegroup[:] = 0
    try:
        with mujoco.Renderer(finger.model, height=520, width=1600) as renderer:
            renderer.update_scene(finger.data, "side", shown)
            return renderer.render()
    except Exception as error:  # of many kinds: what is missing, a module or a library, decides
        print(f"       no frame is rendered: {error}. MUJOCO_GL=osmesa needs PyOpenGL, glfw, libosmesa6, no display")
        return None


def draw(made, path):
    """Draw a frame of the motion, and force, pressure and the responses of a cell over time."""
    import matplotlib
    matplotlib.use("Agg")
    from dermis._plot import CLASSES as colours
    from matplotlib import pyplot

    cell, seconds = (slice(None), HEIGHT // 2, WIDTH // 2), np.arange(1, len(made.force) + 1) * STEP
    rows = [("force\nN", made.force), ("pressure\nkPa", made.pressure[cell] / 1e3)]
    rows += [(f"{name.upper()}\n{unit}", made.felt[name][cell])
             for name, unit in zip(CLASSES, ("", "s", "1/s", "1/s²"))]
    image = rendered()
    figure = pyplot.figure(figsize=(8, 8 if image is None else 10.5), constrained_layout=True)
    top, curves = (None, figure) if image is None else figure.subfigures(2, height_ratios=(2.5, 8))
    if top:
        axis = top.subplots()
        axis.imshow(image)
        axis.axis("off")
    axes = curves.subplots(len(rows), sharex=True)
    for axis, (label, values), colour in zip(axes, rows, ("black", "black", *map(colours.get, CLASSES))):
        axis.axhline(0, color="0.7", linewidth=0.8)
        for part in PARTS.values():
            axis.axvspan(part.start * STEP, part.stop * STEP, color="0.94")
        axis.plot(seconds, values, color=colour, linewidth=1)
        axis.set_ylabel(label, rotation=0, ha="right", va="center")
        axis.spines[["top", "right"]].set_visible(False)
    for name, part in PARTS.items():
        axes[0].text((part.start + part.stop) / 2 * STEP, 1.02, name, ha="center", va="bottom",
                     transform=axes[0].get_xaxis_transform())
    figure.suptitle("A fingertip on a ridged plate in MuJoCo: the force, and a cell in the middle", x=0.01, ha="left")
    axes[-1].set_xlabel("s")
    curves.align_ylabels()
    figure.savefig(path, dpi=100)


def told(claim, *given):
    """Print a claim with its numbers. Returns whether it fails."""
    held, numbers = claim(*given)
    print(f"{'ok    ' if held else 'FAILED'} {claim.__name__.replace('_', ' ')}: {numbers}", flush=True)
    return not held


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--picture", help="a .png file to draw, with matplotlib")
    given = options.parse_args()
    made = record()
    if given.picture:
        draw(made, given.picture)
    claims = force_is_kept, fa1_changes_sign, sa1_follows_the_hold, fa2_has_the_rate_of_ridges, rolls_back
    sys.exit(sum(told(claim, made) for claim in claims) > 0)


if __name__ == "__main__":
    main()
