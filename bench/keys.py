# SPDX-License-Identifier: MIT
"""What the keys for contact and receptors are for: keys.py dermis

Prints the table of host/lab/scenes/README.md, "What the keys for contact and receptors change". For each key: the scene that
needs it; what stands in its place, and the greatest difference of a response with and without the key, divided by the
greatest value with it; the time of a run with the key, divided by its time without (whole processes in turn, medians of
ROUNDS).
"""
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent / "evidence"))
import halfspace
import runs

EXAMPLES = Path(__file__).parent.parent / "host/examples"
ROUNDS = 5
VIBRATION, HELD, GRATING, BAR = "fingerprint_vibration.toml", "held_depth.toml", "grating.toml", "bar"
LATER = lambda r: r[r.shape[0] * 100 // 277:]  # from 0.1 s on: the jump at the start is over
FROM_HOLD = lambda r: r[65:] / r[65]  # of the value when the punch stands still, after 65 rows
EVERYTHING = lambda r: r
STRAIN = ["receptors.kernel=strain"]

# key and its value, scene, settings with it, settings without it and what that is, what is compared
KEYS = [
    ("receptors.depth", VIBRATION, [], ["receptors.depth={}"], "each receptor answers to its cell", LATER),
    ("receptors.kernel = \"strain\"", BAR, STRAIN, [], "the stress at 0.3 mm", EVERYTHING),
    ("receptors.poisson = 0.4", BAR, STRAIN, STRAIN + ["receptors.poisson=0.5"], "0.5 in its place", EVERYTHING),
    ("receptors.follow", HELD, [], ["receptors.follow={}"], "SA1 follows the strain", EVERYTHING),
    ("load.control = \"depth\"", HELD, [],
     ["load.control=pressure", "load.kind=circular", "load.intensity=10e3", "receptors.follow={}"],
     "a pressure is held; each SA1 divided by its value at the end of the ramp", FROM_HOLD),
    ("load.contact = \"crests\"", VIBRATION, [], ["load.contact=even"], "an even contact", LATER),
    ("load.contact_share = 0.5", VIBRATION, [], ["load.contact_share=1"], "all cells touch", LATER),
    ("load.contact_length", VIBRATION, [], ["load.contact_length=0.92e-3"],
     "twice as long, on even ridges (a file in which no ridges are found is refused without it)", LATER),
    ("load.texture", VIBRATION, [], None, "the pressure is held", LATER),
    ("[[load]]", GRATING, [], ["load[1].intensity=0"], "the probe alone", EVERYTHING),
    ("load.grating", GRATING, [], ["load[1].grating.velocity=0"], "it stands still", EVERYTHING),
    ("load.window", GRATING, [], ["load[1].window={}"], "the grating begins at once and stays", EVERYTHING),
]


def files_of(scene, folder):
    """Writes a scene into a folder; its text without [load.texture] stands in a second file."""
    if scene == BAR:
        width, height, spacing = 200, 800, 5e-5
        np.save(folder / "pressure.npy", halfspace.rigid_bar(width, height, spacing, 1.5e-3))
        text = runs.scene("half_space", width=width, height=height, spacing=spacing, kernel="stress", poisson="")
        text = text.replace("[receptors]", "[receptors]\ndepth = { sa1 = 3e-4 }")
    else:
        text = (EXAMPLES / scene).read_text().replace('"texture.npy"', f'"{EXAMPLES.resolve()}/texture.npy"')
    (folder / scene).write_text(text)
    before, _, after = text.partition("[load.texture]")
    (folder / "without.toml").write_text(before + after[after.find("[time]"):])


def run(dermis, scene, folder, settings):
    """A run's responses, a row for each time, and its time in s."""
    start = time.perf_counter()
    out = runs.run(dermis, (folder / scene).read_text(), folder, *(["--set", *settings] if settings else []))
    took = time.perf_counter() - start
    for name in ("responses.npy", "sa1_t0.1.npy"):
        if (out / name).exists():
            return np.load(out / name), took
    return runs.traces(out)["sa1_probe0"], took


def difference(a, b):
    return np.abs(a - b).max() / np.abs(a).max()


def row_of(dermis, key, scene, with_it, without_it, instead, compared):
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        files_of(scene, folder)
        runs, times = {}, ([], [])
        for _ in range(ROUNDS):
            for i, settings in enumerate((with_it, without_it)):
                file = "without.toml" if settings is None else scene
                runs[i], took = run(dermis, file, folder, settings or [])
                times[i].append(took)
    error = difference(compared(runs[0]), compared(runs[1]))
    cost = np.median(times[0]) / np.median(times[1])
    where = f"[{scene}](../../examples/{scene})"
    if scene == BAR:
        where = "a rigid bar of 3 mm, in bench/keys.py"
    return f"| `{key}` | {where} | {instead}: {error:.2g} | {cost:.1f} |"


def hold_row(dermis):
    """FA1 along lines and along parabolas between frames, beside lines between frames eight times as often."""
    common = ["receptors.depth={fa1=2e-3}", "sites.density={fa1=25}"]
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        files_of(VIBRATION, folder)
        often = run(dermis, VIBRATION, folder, [*common, "time.step=3.125e-5"])[0][::8]
        found, times = {}, {"parabolic": [], "linear": []}
        for _ in range(ROUNDS):
            for hold in times:
                found[hold], took = run(dermis, VIBRATION, folder, [*common, f"load.hold={hold}"])
                times[hold].append(took)
    lines, parabolas = (difference(LATER(often), LATER(found[hold])) for hold in ("linear", "parabolic"))
    cost = np.median(times["parabolic"]) / np.median(times["linear"])
    return (f"| `load.hold = \"parabolic\"` | [{VIBRATION}](../../examples/{VIBRATION}), FA1 | lines between frames: "
            f"{lines:.2g}, where parabolas have {parabolas:.2g} | {cost:.1f} |")


def main():
    dermis = str(Path(sys.argv[1]).resolve())
    print("| key | scene that needs it | what stands in its place, and the error | time |\n|---|---|---|---|")
    for key in KEYS:
        print(row_of(dermis, *key), flush=True)
    print(hold_row(dermis))


if __name__ == "__main__":
    main()
