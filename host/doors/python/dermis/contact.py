# SPDX-License-Identifier: MIT
"""Contacts to pressure: forces at contact points, depths or taxels, as a simulator has them, on the cells of a skin.

    pressure = np.zeros((64, 80), np.float32)            # Pa
    pad = contact.Pad(pressure, spacing=2.5e-4)          # 20 mm x 16 mm
    report = contact.add_contacts(pad, [contact.Contact(x=0.01, y=0.008, force=0.5, radius=0.003)])
    if not report.plausible:
        print(report.doubts)
    skin.press(pressure, dt)

The pad's frame is right-handed: its origin is the outer corner of cell [0, 0], x runs along a row, y from row to row,
z out of the skin. A pad on a round body such as a fingertip has radii: contacts in the world are then projected onto
the body's surface, and x and y are lengths along it. The plane z = 0 touches the surface at the pad's middle.
Pressure is added: fill the array with 0 before a frame. A report is not plausible where force is lost:
less than half of it placed, more than a tenth outside, or more than 0.001 lost to rounding.
"""
from __future__ import annotations

import dataclasses
import warnings
from typing import Any

import numpy as np

from . import _core
from ._answers import answered
from ._core import (Body, Contact, Pad, Pose, WorldContact, add_contacts, add_depths, add_taxels, fill_depths,
                    foundation_stiffness, hertz_radius, skin_stiffness, strain_below_punch)
from ._core import ContactReport

__all__ = ["Body", "Contact", "ContactReport", "Pad", "Pose", "Shapes", "Touch", "WorldContact", "add_contacts",
           "add_depths", "add_taxels", "fill_depths", "foundation_stiffness", "hertz_radius", "skin_stiffness",
           "strain_below_punch"]
_OLD = {"Report": "ContactReport", "depths_of": "fill_depths"}  # until 1.0


def __getattr__(name: str) -> Any:
    if name not in _OLD:
        raise AttributeError(f"module 'dermis.contact' has no attribute {name!r}")
    warnings.warn(f"contact.{name} is contact.{_OLD[name]}", DeprecationWarning, stacklevel=2)
    return globals()[_OLD[name]]


def __dir__() -> list[str]:
    return __all__


@dataclasses.dataclass
class Shapes:
    """What bodies look like, in the world: many shapes of one number are one rigid body. One row for each shape; arrays
    of integers, and of float64, which are read in place.

    pad: the pad below which the shape is. body: its body, from 0 on, as Touch.add names it.
    kind: a number of KINDS. size: m, of shape (.., 3), as in Body, with zeros behind; of a hull how many faces it has,
    its first one in faces, and 0. position: m, (.., 3). rotation: axes as columns, (.., 3, 3) or (.., 9).
    faces: of all hulls, (.., 4): outward normals of length 1, and the offsets in m up to which normal*place is inside.
    """

    pad: Any
    body: Any
    kind: Any
    size: Any
    position: Any
    rotation: Any
    faces: Any = dataclasses.field(default_factory=lambda: np.empty((0, 4)))


KINDS = {"sphere": 0, "capsule": 1, "box": 2, "plane": 3, "cylinder": 4, "ellipsoid": 5, "hull": 6}


class Touch(_core.Touch):
    """The contacts of all pads of a skin, in one call from arrays. One thread at a time uses it; others wait.

        touch = contact.Touch(skin, reach=1e-3, radius_x=8e-3, radius_y=8e-3)     # five round fingertips
        report = touch.add(data.site_xpos[sites], data.site_xmat[sites], pad, position, force, radius=2e-3)
        skin.press(touch, dt)

    skin: its grid, in metres, and its number of pads are taken. reach: m, as in add_contacts.
    radius_x, radius_y: m, of the surface along x and y at each pad's middle; 0: straight in that direction.
    tiled: as in Pad. shear: whether it keeps tractions too, for a skin that was made with shear.
    stiffness: Pa/m, of the foundation that bodies with shapes press; None: the skin's own, held long.
    beyond: "keep": a patch's part beyond the pad's border presses the pad's own cells, as where a flat finger ends;
    "drop": it is outside. Shapes press no cell beyond the border either way.
    around: m of the finger's surface beyond the pad's borders x = 0, x = width, y = 0 and y = height, which carries its
    part of the force; below 0: so much of the pad is beyond the finger's border.
    """

    @answered
    def __init__(self, skin: _core.Skin, reach: float, *, radius_x: float = 0.0, radius_y: float = 0.0,
                 tiled: bool = False, shear: bool = False, stiffness: float | None = None,
                 around: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0), beyond: str = "drop") -> None:
        scene = skin.scene
        if scene.spacing is None:
            _core.refuse("skin", skin, "a skin whose scene gives grid.spacing in metres")
        if beyond not in ("keep", "drop"):
            _core.refuse("beyond", beyond, '"keep", "drop"')
        super().__init__(scene.width, scene.height, scene.spacing, skin.count, reach, radius_x, radius_y, tiled, shear,
                         skin_stiffness(scene) if stiffness is None else stiffness, around, beyond == "keep")
