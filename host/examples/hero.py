# SPDX-License-Identifier: MIT
"""The picture at the top of README.md: python hero.py hero.png

A word in Braille slides under a ridged fingertip: its skin, the responses of its four classes of receptors at one
instant, and the spikes of its afferents.
"""
import io
import pathlib
import sys

import dermis
import numpy as np
from dermis._plot import CLASSES, colours_of
from matplotlib.figure import Figure
from PIL import Image  # matplotlib's own requirement

AT = 0.55  # s, of the maps
CELL = 0.1  # mm
NAMES = {"sa1": "SA1, Merkel", "sa2": "SA2, Ruffini", "fa1": "FA1, Meissner", "fa2": "FA2, Pacini"}
SCENE = dermis.fingertip(
    grid={"width": 160, "height": 90, "spacing": f"{CELL} mm"}, surface={"kind": "spiral", "ridge_period": "0.6 mm"},
    load={"kind": "circular", "radius": 1000, "intensity": "40 kPa",  # so wide that each dot is pressed alike
          "texture": {"path": pathlib.Path(__file__).parent / "braille.png", "high": "white", "velocity": [-0.04, 0]}},
    receptors={"depth": "fingertip"}, sites={"density": {"sa1": 70, "fa1": 140, "fa2": 25}},
    afferents=[{"type": "sa1"}, {"type": "fa1"}, {"type": "fa2"}], time={"step": "1 ms", "duration": 0.9},
    output={"traces": [], "fields": [{"at": AT, "what": ["deformation", *NAMES]}]})


def draw(result):
    figure = Figure(figsize=(10, 3.9), dpi=150)
    fields = {name: field for (name, _), field in result.fields.items()}
    extent = (0, CELL * result.scene.width, 0, CELL * result.scene.height)
    skin = figure.add_axes((0.045, 0.355, 0.435, 0.57))
    skin.imshow(fields["deformation"], origin="lower", cmap="copper", extent=extent, aspect="auto")
    skin.set_title(f"ridged skin under Braille that slides, at {AT:g} s; in mm", fontsize=10)
    skin.tick_params(labelsize=8)
    for i, (name, title) in enumerate(NAMES.items()):
        panel = figure.add_axes((0.497 + 0.25 * (i % 2), 0.675 - 0.32 * (i // 2), 0.243, 0.25), xticks=[], yticks=[])
        field = fields[name]
        panel.imshow(field, origin="lower", aspect="auto", **colours_of(name, field.min(), field.max()))
        panel.set_title(title, fontsize=10, fontweight="bold", color=CLASSES[name], pad=3)
    raster = figure.add_axes((0.045, 0.115, 0.945, 0.175))
    classes = [kind for a in result.scene.afferents for kind, *_ in result.scene.sites if kind == a.type]
    colours = np.array([CLASSES[kind] for kind in classes])[result.spikes["afferent"]]
    raster.scatter(result.spikes["time"], result.spikes["afferent"], s=1.2, c=colours, linewidths=0)
    raster.axvline(AT, color="black", linewidth=0.8)
    rows = [classes.index(kind) + classes.count(kind) / 2 for kind in ("sa1", "fa1", "fa2")]
    raster.set(xlim=(0, result.scene.time.duration), ylim=(0, len(classes)), yticks=rows,
               yticklabels=["SA1", "FA1", "FA2"])
    for label in raster.get_yticklabels():
        label.set(color=CLASSES[label.get_text().lower()], fontweight="bold")
    raster.set_xlabel(f"spikes of {len(classes)} afferents over time (s)", fontsize=9, labelpad=1)
    raster.tick_params(labelsize=8)
    return figure


if __name__ == "__main__":
    drawn = io.BytesIO()
    draw(dermis.run(SCENE)).savefig(drawn)
    Image.open(drawn).convert("RGB").quantize(256, Image.Quantize.MAXCOVERAGE).save(sys.argv[1], optimize=True)
