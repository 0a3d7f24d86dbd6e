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
from ._core import Contact, Pad, Pose, WorldContact, add_contacts, add_depths, add_taxels, hertz_radius
from ._core import ContactReport as Report

__all__ = ["Contact", "Pad", "Pose", "Report", "WorldContact", "add_contacts", "add_depths", "add_taxels",
           "hertz_radius"]
