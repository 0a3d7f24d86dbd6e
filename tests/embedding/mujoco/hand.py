# SPDX-License-Identifier: MIT
"""Five round fingertips in MuJoCo: python hand.py [--picture FILE]

A hand grasps a ball and lifts it; its skin feels the contacts, with their shear. host/examples/SIMULATOR.md shows it.
"""
import pathlib
import sys

import dermis
import mujoco
import numpy as np
from dermis import contact

TIPS, SIDE, SPACING, RADIUS, STEP = 5, 80, 2.5e-4, 8e-3, 1e-3  # pads of 20 mm x 20 mm; m; s


# begin
class HandSkin:
    """The skin of five fingertips: `feel` presses it with the contacts of a step."""

    def __init__(self, model):
        scene = dermis.fingertip(grid={"width": SIDE, "height": SIDE, "spacing": SPACING}, surface={"kind": "flat"},
                                 receptors={"depth": "fingertip"})
        self.skin = dermis.Skin(scene, count=TIPS, shear=True)
        self.touch = contact.Touch(self.skin, reach=1e-3, radius_x=RADIUS, radius_y=RADIUS, shear=True)
        self.sites = [model.site(f"skin{k}").id for k in range(TIPS)]  # the pads' middles, z out of the skin
        self.pad = np.full(model.ngeom, -1)  # the pad of each geom; -1: it has none
        self.pad[[model.geom(f"tip{k}").id for k in range(TIPS)]] = range(TIPS)
        self.patch = {"ball": 6e-3, "modulus": 1e5}  # Hertz: the radii of ball and tip together, m; Pa

    def feel(self, data):
        found = data.contact
        solved = found.efc_address >= 0
        force = data.efc_force[found.efc_address[solved, None] + range(3)]  # of an elliptic cone: normal, two tangents
        force = (force[:, None] @ found.frame[solved].reshape(-1, 3, 3))[:, 0]  # in the world, on the second geom
        place, pad = found.pos[solved], self.pad[found.geom[solved].T]  # the middle between both surfaces
        half = found.dist[solved, None] / 2 * found.frame[solved, :3]  # from there to the second geom's surface
        first, second = pad >= 0
        place = np.r_[(place - half)[first], (place + half)[second]]
        report = self.touch.add(data.site_xpos[self.sites], data.site_xmat[self.sites],
                                pad=np.r_[pad[0, first], pad[1, second]], position=place,
                                force=np.r_[-force[first], force[second]], **self.patch)
        self.skin.press(self.touch, STEP)
        return report
# end


def grasp(model, frame=lambda *_: None, frames=1000, **patch):
    """Close the hand, lift the ball by 40 mm and hold it. Calls frame(n, data, skin, report) after each step."""
    data, skin = mujoco.MjData(model), HandSkin(model)
    skin.patch = patch or skin.patch
    for n in range(frames):
        data.ctrl[0] = np.interp(n * STEP, [0.5, 0.8], [0, 0.04])
        data.ctrl[1:] = np.interp(n * STEP, [0.15, 0.35], [0, 0.12])
        mujoco.mj_step(model, data)
        frame(n, data, skin, skin.feel(data))
    return data, skin


def load():
    return mujoco.MjModel.from_xml_path(str(pathlib.Path(__file__).with_name("hand.xml")))


def axes_of_cells():
    """Return the axes of a round pad's surface at each cell, x, y and outwards, in the frame of the pad's middle."""
    arc = (np.arange(SIDE) + 0.5 - SIDE / 2) * SPACING / RADIUS
    x, y = np.meshgrid(arc, arc)
    angle = np.hypot(x, y)
    u, v, sine, bent = x / angle, y / angle, np.sin(angle), np.cos(angle) - 1
    return np.array([[1 + u * u * bent, u * v * bent, -u * sine], [u * v * bent, 1 + v * v * bent, -v * sine],
                     [u * sine, v * sine, np.cos(angle)]])


def force_on_skin(data, skin):
    """Return the force with which the ball presses and shears all pads, in the world, N, from their pressures."""
    touch, axes, total = skin.touch, axes_of_cells(), np.zeros(3)
    for k, site in enumerate(skin.sites):
        maps = np.array([touch.traction[0, k], touch.traction[1, k], -touch.pressure[k]], float)
        own = np.einsum("ayx,aiyx->i", maps, axes) * SPACING**2
        total += data.site_xmat[site].reshape(3, 3) @ own
    return total


def view_of(model, data):
    """Return a picture of the hand, or None where there is no renderer."""
    try:
        renderer = mujoco.Renderer(model, 1000, 900)
        renderer.update_scene(data, "side")
        return renderer.render()
    except Exception as missing:  # whichever of its libraries is not there
        print(f"without a view of the hand: {missing}")


def draw(model, path):
    """Draw the hand that holds the ball, what presses and shears its pads, and what they felt on the way."""
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    felt = []

    def keep(n, data, skin, report):
        pads = [skin.touch.report(k) for k in range(TIPS)]
        felt.append([[r.placed for r in pads], [np.hypot(*r.shear) for r in pads], np.abs(skin.skin["fa1"]).mean((1, 2))])
    data, skin = grasp(model, keep)
    figure = plt.figure(figsize=(11, 5.6), dpi=150)
    view = figure.add_axes((0, 0.06, 0.37, 0.9))
    view.axis("off")
    if (picture := view_of(model, data)) is not None:
        view.imshow(picture)
    half = SIDE * SPACING * 1e3 / 2
    shear = np.array([skin.skin["shear_x"], skin.skin["shear_y"]])
    rows = (("pressure,\nkPa", skin.touch.pressure / 1e3), ("shear\nstrain", np.hypot(*shear)))
    for i, (name, maps) in enumerate(rows):
        for k in range(TIPS):
            axes = figure.add_axes((0.4 + 0.108 * k, 0.71 - 0.265 * i, 0.105, 0.21))
            image = axes.imshow(maps[k], vmin=0, vmax=maps.max(), cmap="viridis", origin="lower",
                                extent=(-half, half, -half, half))
            if i == 1:  # which way the ball pulls the skin
                step = 8
                at = (np.arange(step // 2, SIDE, step) + 0.5) * SPACING * 1e3 - half
                axes.quiver(at, at, *(s[k, step // 2::step, step // 2::step] for s in shear), color="white", scale=1)
            axes.tick_params(labelsize=6, labelleft=k == 0, labelbottom=i == 1), axes.set_xticks([-5, 0, 5])
            if i == 0:
                axes.set_title(f"finger {k}", fontsize=8)
        bar = figure.colorbar(image, cax=figure.add_axes((0.945, 0.71 - 0.265 * i, 0.008, 0.19)))
        bar.ax.tick_params(labelsize=6), bar.ax.set_title(name, fontsize=6.5)
    figure.text(0.67, 0.385, "mm along the surface from the pad's middle, of five pads", ha="center", fontsize=7)
    names = (("force into the pad, N", 0), ("force along it, N", 1), ("mean |FA1|, 1/s", 2))
    for i, (name, which) in enumerate(names):
        axes = figure.add_axes((0.405 + 0.2 * i, 0.09, 0.165, 0.24))
        axes.plot(np.arange(len(felt)) * STEP, [f[which] for f in felt], linewidth=1)
        axes.set_title(name, fontsize=8), axes.set_xlabel("s", fontsize=7), axes.tick_params(labelsize=6)
        for at, word in ((0.15, "close"), (0.5, "lift"), (0.8, "hold")):
            axes.axvline(at, color="0.8", linewidth=0.7, zorder=0)
            axes.text(at + 0.01, 0.93 * axes.get_ylim()[1], word, fontsize=5.5, color="0.4")
    figure.savefig(path)


if __name__ == "__main__":
    if "--picture" in sys.argv:
        draw(load(), sys.argv[sys.argv.index("--picture") + 1])
        sys.exit()
    sums = np.zeros(3)

    def count(n, data, skin, report):
        if n >= 350:
            sums[:] += report.asked - report.sideways, report.placed, 1
    data, skin = grasp(load(), count, radius=1.2e-3)
    print(f"{sums[0] / sums[2]:.2f} N into the pads, of which {sums[1] / sums[0]:.1%} press them; the ball, of 0.49 N, "
          f"hangs at {data.qpos[2] * 1e3:.0f} mm and pulls the skin down with {-force_on_skin(data, skin)[2]:.3f} N")
