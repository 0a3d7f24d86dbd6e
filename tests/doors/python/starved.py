# SPDX-License-Identifier: MIT
"""Makes one call with each of its allocations failing in turn, and prints what is not a MemoryError with words.

Run by test_memory.py. Argument: the name of a call; without one the names of all are printed.
"""
import ctypes
import sys

import dermis
import numpy as np

TABLES = {"grid": {"width": 8, "height": 4}, "time": {"duration": 0.05},
          "output": {"fields": [{"at": 0.05, "what": ["sa1"]}]}}
TIMES, MODULI = [0.0, 1.0, 2.0, 3.0, 4.0], [5.0, 4.0, 3.5, 3.2, 3.0]
MATERIAL = {"modulus": 2.0, "viscosity": 1.0}
scene = dermis.Scene(TABLES)
skin = dermis.Skin(scene, 3, materials=[MATERIAL] * 3)
result = dermis.run(scene)
pressure = np.ones((3, 4, 8), np.float32)
state = skin.save()
pad = dermis.contact.Pad(np.zeros((4, 8), np.float32), 1e-3)
contacts = [dermis.contact.Contact(x=1e-3, y=1e-3, force=1.0, radius=1e-3)]
in_world = [dermis.contact.WorldContact(position=(1e-3, 1e-3, 0), force=1.0, radius=1e-3)]
relaxation = dermis.Relaxation(moduli=[2e4, 1e4], times=[0.01, 1.0], equilibrium=1e4)

CALLS = {
    "Scene": lambda: dermis.Scene(TABLES, sites=[("sa1", 1, 2)], surface={"path": np.ones((4, 8))}),
    "Scene.from_string": lambda: dermis.Scene.from_string("[grid]\nwidth = 8\n", {"time.step": 0.01}, "a folder"),
    "Device": lambda: dermis.Device.cpu().info.name,
    "Device.open": lambda: dermis.Device.open("cpu").info,
    "Skin": lambda: dermis.Skin(scene, 2, responses=["sa1", "fa2"], precision="f32-compensated",
                                materials=[MATERIAL] * 2),
    "Skin.press": lambda: skin.press(pressure, 0.1),
    "Skin.press with a list of steps": lambda: skin.press(pressure[:2], [0.1, 0.2], [2, 0]),
    "Skin.press with a mask": lambda: skin.press(pressure[:2], 0.1, np.array([True, False, True])),
    "Skin.press that is refused": lambda: skin.press("x" * 100, 0.1),
    "a response": lambda: skin["sa1"],
    "strain": lambda: skin["strain"],
    "Skin.save": lambda: skin.save(),
    "Skin.save into an array": lambda: skin.save(out=np.empty(len(state), np.uint8)),
    "Skin.spike_counts": lambda: skin.spike_counts(),
    "Skin.time": lambda: skin.time,
    "Skin.load": lambda: skin.load(state),
    "Skin.reset": lambda: skin.reset([1]),
    "Skin.set_material": lambda: skin.set_material(MATERIAL, [1]),
    "Skin.report": lambda: skin.report(1).sign_changed,
    "run": lambda: dermis.run(scene, precision="f64"),
    "plan": lambda: dermis.plan(scene).candidates,
    "what a result has": lambda: (result.fields, result.impulses, result.keys(), result.report(), result["sa1"].probes),
    "chain_of": lambda: dermis.relaxation_of(dermis.chain_of(relaxation)).moduli,
    "Relaxation": lambda: dermis.Relaxation(moduli=MODULI, times=TIMES),
    "contact.add_contacts": lambda: dermis.contact.add_contacts(pad, contacts).doubts,
    "contact.add_contacts in the world": lambda: dermis.contact.add_contacts(pad, dermis.contact.Pose(), 1.0, in_world),
    "contact.add_taxels": lambda: dermis.contact.add_taxels(pad, pressure[0], width=1e-3, height=1e-3),
}

def outcome(call):
    try:
        call()
    except MemoryError as error:
        return "MemoryError: " + str(error)
    except dermis.Error as error:
        return "Error: " + str(error)
    return "done"


def starve(name):
    library, call = ctypes.CDLL(None), CALLS[name]
    right = outcome(call)
    for sticky in (False, True):
        before, struck = 0, True
        while struck:
            library.fail_after(ctypes.c_long(before), sticky)
            became = outcome(call)
            struck = library.end_of_failing()
            said = "MemoryError: out of memory" + ("" if sticky else ": ")
            if became != right and not (struck and became.startswith(said)):
                print(f"allocation {before}, sticky {sticky}: {became}")
            if (later := outcome(call)) != right:
                print(f"after allocation {before}, sticky {sticky}: {later}")
            before += 1
    return before


if len(sys.argv) > 1:
    print("failed:", starve(sys.argv[1]))
else:
    print("\n".join(CALLS))
