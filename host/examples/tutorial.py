# SPDX-License-Identifier: MIT
"""dermis in Python, cell by cell: python tutorial.py, or open it where `# %%` begins a cell. It prints tutorial.txt."""

# %% A scene is tables of keys, as in a TOML file; what is left out has a default. A run gives its results by name.
import dermis
import numpy as np

scene = dermis.Scene(
    surface={"kind": "spiral"},
    load={"kind": "circular", "envelope": "ramp", "rise": 0.5},
    time={"step": 0.01, "duration": 1.0},
    output={"probes": [[75, 75]], "fields": [{"at": 0.5, "what": ["sa1", "fa1"]}]},
)
result = dermis.run(scene)
print(f"{len(result.time)} times of {', '.join(result)} by the model {result.model}")
for name in ("sa1", "fa1"):
    trace = result[name]
    print(f"{name} at {result.time[50]:g} s: mean {trace.mean[50]:.4f}, in the middle {trace.probes[0][50]:.4f}")

# %% A field is an array[y, x], and no copy: arrays are views of the result's own numbers.
field = result.fields["sa1", 0.5]
print(f"a field of {field.shape}, {field.dtype}, greatest {field.max():.4f}, can be written: {field.flags.writeable}")

# %% What is refused says which key it is, its value and what is allowed.
try:
    dermis.Scene(material={"modulus": -1})
except dermis.Error as error:
    print(f"{error.code}: {error}")

# %% How a scene would be run, before it is.
plan = dermis.plan(scene)
print(f"{plan.chosen.model} in {plan.chosen.precision}, of {len(plan.candidates)} candidates")

# %% A skin in metres, with numbers that were measured, and whether a run's numbers are plausible for skin.
touch = dermis.fingertip(load={"intensity": 2e4}, receptors={"depth": "fingertip"}, time={"duration": 0.5})
report = dermis.run(touch).report()
print(f"strain {report.strain.value:.2f}, outside its range: {report.strain.outside}")
print(f"indentation {report.indentation.value * 1e3:.2f} mm, outside its range: {report.indentation.outside}")
print(f"finer than receptors lie deep: {report.fine_load.value:.0%} of the load")

# %% A simulator presses frame by frame: here four pads of 20 x 25 taxels at 1 kHz. The response is the same memory
# after every press, so that it is asked for once.
skin = dermis.Skin(dermis.Scene(grid={"width": 20, "height": 25}, surface={"kind": "wave", "ridges": 4}), count=4)
pressure = np.zeros((4, 25, 20), np.float32)
fa1 = skin["fa1"]
for frame in range(100):
    pressure[:] = np.arange(1, 5, dtype=np.float32)[:, None, None] * np.float32(frame / 100)
    skin.press(pressure, 1e-3)
print(f"FA1 of {fa1.shape}: {', '.join(f'{pad.mean():.4f}' for pad in fa1)}")

# %% Some pads begin anew, and a state goes back and forth.
state = skin.save([0])
skin.reset([2, 3])
skin.load(state, [1])
skin.press(pressure[:2], 1e-3, pads=[0, 1])
print("strains:", ", ".join(f"{skin.report(pad).strain.value:.4f}" for pad in range(4)))

# %% Sites: the response of a class in single cells, one value for each.
sites = [("sa1", 3, 4), ("fa2", 10, 12), ("sa1", 10, 12)]
taps = dermis.Skin(dermis.Scene(grid={"width": 20, "height": 25}, sites=sites))
taps.press(np.ones((25, 20), np.float32), 1e-3)
for name, cells in taps.sites.items():
    print(f"{name} in {cells.tolist()}: {', '.join(f'{value:.4g}' for value in taps[name])}")

# %% Contacts of a simulator become pressure, with their force kept.
pad = np.zeros((64, 80), np.float32)
touch = dermis.contact.Contact(x=0.01, y=0.008, force=0.5, radius=0.003)
contacts = dermis.contact.add_contacts(dermis.contact.Pad(pad, spacing=2.5e-4), [touch])
print(f"{contacts.placed:.3f} N on {contacts.cells} cells, at most {contacts.greatest / 1e3:.1f} kPa")
print(f"plausible: {contacts.plausible}")

# %% Elements in series from a measured creep.
times = np.geomspace(1e-3, 10, 50)
fit = dermis.fit_creep(times, (1 - np.exp(-times / 0.02)) / 3e4 + (1 - np.exp(-times)) / 5e4, 2)
for element in fit.elements:
    print(f"{element.modulus:.4g} Pa, {element.viscosity:.4g} Pa s")
