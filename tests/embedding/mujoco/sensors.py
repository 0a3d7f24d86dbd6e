# SPDX-License-Identifier: MIT
"""The finger of finger.py, with sensor arrays of MuJoCo in its pad: python sensors.py

The sensor `tactile` reads how deep the plate is in each taxel, the plugin `touch_grid` the forces in angles around a
site. Their readings are spread onto the finer skin. Prints what is checked, with numbers, and exits with 1 if something
fails. host/examples/SIMULATOR.md explains it.
"""
from __future__ import annotations

import math
import sys

import dermis
import finger
import mujoco
import numpy as np
from dermis import contact

PAD = np.array([finger.WIDTH, finger.HEIGHT]) * finger.SPACING  # m
FINE = 32, 24  # taxels of `tactile`, of 0.25 mm, along x and y
COARSE = 8, 6  # taxels of `touch_grid`, of 1 mm
# The plugin counts by angles: from this far behind the skin its taxels are even to 0.1 %. The field is wider than the
# pad by 0.1 %, because contacts of a box lie on its border.
BEHIND = 0.1  # m
FIELD = [math.degrees(math.atan(1.001 * side / 2 / BEHIND)) for side in PAD]

MODEL = f"""
<mujoco>
  <include file="finger.xml"/>
  <extension><plugin plugin="mujoco.sensor.touch_grid"/></extension>
  <asset>
    <mesh name="taxels" builtin="plate" params="{FINE[0]} {FINE[1]}" scale="{PAD[0] / 2} {PAD[1] / 2} 0.003"/>
  </asset>
  <sensor>
    <contact name="touch" geom1="pad" reduce="netforce" data="force"/>
    <tactile name="tactile" geom="taxels" mesh="taxels"/>
    <plugin name="grid" plugin="mujoco.sensor.touch_grid" objtype="site" objname="behind">
      <config key="size" value="{COARSE[0]} {COARSE[1]}"/>
      <config key="fov" value="{FIELD[0]} {FIELD[1]}"/>
      <config key="nchannel" value="1"/>
      <config key="gamma" value="0"/>
    </plugin>
  </sensor>
</mujoco>
"""


def load(ball=None):
    """Return the model with its sensors. ball: x and y of a ball on the plate, in m, which alone is then touched."""
    spec = mujoco.MjSpec.from_string(MODEL, include=finger.files())
    body = spec.body("finger")
    # Taxels are the vertices of a mesh that collides with nothing: contacts of any geom of the body make them read.
    body.add_geom(name="taxels", type=mujoco.mjtGeom.mjGEOM_MESH, meshname="taxels", contype=0, conaffinity=0, mass=0)
    body.add_site(name="behind", pos=[0, 0, BEHIND - 0.003])
    if ball:
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[2e-3, 0, 0], pos=[*ball, -1.6e-3])
    return spec.compile()


class Array(finger.Finger):
    """A finger whose skin is pressed by what a sensor array reads, in N: `taxels`, row by row in the skin's frame."""

    sensor, shape = "", (0, 0)  # its name in the model; taxels along x and y

    def touch(self, force, corner):
        self.taxels = self.read(force)
        width, height = PAD / self.shape
        return contact.add_taxels(self.pad, self.taxels, width=width, height=height)


class Depths(Array):
    """The sensor `tactile`, which reads depths: the solver's force is shared in proportion to them."""

    sensor, shape = "tactile", FINE

    def __init__(self, model, pressure):
        super().__init__(model, pressure)
        # The mesh is turned to its axes of inertia, its vertices run along y first, and y of the skin is that of the
        # world turned round: so the order is taken from where taxels are in the skin's frame.
        mujoco.mj_kinematics(self.model, self.data)
        geom, site = self.data.geom("taxels"), self.data.site("skin")
        places = geom.xpos + model.mesh_vert @ geom.xmat.reshape(3, 3).T
        places = (places - site.xpos) @ site.xmat.reshape(3, 3)
        assert abs(places[:, 2]).max() < 1e-6, "taxels are not in the skin's plane"
        self.order = np.lexsort((places[:, 0].round(6), places[:, 1].round(6)))

    def read(self, force):
        # Depths come first, and speeds of sliding after them.
        depths = self.data.sensor(self.sensor).data[self.order].reshape(self.shape[::-1])
        return (force * depths / (depths.sum() or 1)).astype(np.float32)


class Forces(Array):
    """The plugin `touch_grid`, which adds up the forces of contacts."""

    sensor, shape = "grid", COARSE

    def read(self, force):
        # It looks along -z of its site, as a camera does, out of the skin: its y runs against that of the skin.
        return self.data.sensor(self.sensor).data.reshape(self.shape[::-1])[::-1].astype(np.float32)


def force_is_kept(kind):
    """The integral of the pressure is the sum of the readings, and the contact force where the sensor reads any."""
    pressure = np.zeros((finger.HEIGHT, finger.WIDTH), np.float32)
    hand = kind(load(), pressure)
    own = solver = unseen = most = 0.0
    for _ in range(finger.FRAMES):
        hand.step()
        integral, force = pressure.sum(dtype=float) * finger.SPACING**2, finger.sum_of_contacts(hand)
        own = max(own, abs(integral - hand.taxels.sum(dtype=float)))
        most = max(most, force)
        if hand.taxels.any():
            solver = max(solver, abs(integral - force))
        else:
            unseen = max(unseen, force)
    return max(own, solver) < 1e-6 * most and unseen < 1e-3 * most, (
        f"{kind.sensor}, up to {most:.4f} N; off the readings by {own / most:.1e} of it, off the contacts by "
        f"{solver / most:.1e}; {unseen:.4f} N at most were not read")


def taxels_are_in_place(kind, at=(-7.6e-3, 1.3e-3)):
    """A ball under the pad presses the skin where the solver's contact is, to half a taxel."""
    pressure = np.zeros((finger.HEIGHT, finger.WIDTH), np.float32)
    hand = kind(load(ball=at), pressure)
    for _ in range(300):
        hand.step()
    touches, site = hand.data.contact, hand.data.site("skin")
    place = (touches.pos[0] - site.xpos) @ site.xmat.reshape(3, 3)[:, :2] + PAD / 2
    rows, columns = (np.arange(count) + 0.5 for count in pressure.shape)
    middle = finger.SPACING * np.array([pressure.sum(0) @ columns, pressure.sum(1) @ rows]) / pressure.sum()
    off = abs(middle - place)
    text = "the contact is at {:.3f} mm along x and {:.3f} mm along y, the middle of the pressure at {:.3f} and {:.3f}"
    return len(touches) == 1 and (off < PAD / kind.shape / 2).all(), (
        f"{kind.sensor}, {text.format(*place * 1e3, *middle * 1e3)}")


def main():
    failed = sum(finger.told(claim, kind) for kind in (Depths, Forces)
                 for claim in (force_is_kept, taxels_are_in_place))
    made = finger.record(Depths, load())
    failed += sum(finger.told(claim, made) for claim in (finger.fa1_changes_sign, finger.sa1_follows_the_hold))
    # Ridges as the sensor reads them have sharp valleys, and so overtones up to half the rate of steps.
    failed += finger.told(finger.fa2_has_the_rate_of_ridges, made, 11)
    sys.exit(failed > 0)


if __name__ == "__main__":
    main()
