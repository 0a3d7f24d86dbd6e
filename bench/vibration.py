# SPDX-License-Identifier: MIT
"""Do fingerprint ridges amplify the vibration of a sliding texture? Scheibert et al. (Science 323, 2009, 1503) say so.

    vibration.py dermis picture.png [--quick]

Random textures slide over skin with straight ridges across the slide, along it, and over an even contact. An FA2
receptor lies 2 mm below the middle. Prints the frequency of its greatest power, which their sensor had at v/lambda
(speed over ridge period), and its power near v/lambda over that of the flanks. --quick: two textures, one speed, no picture.
"""
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from drawing import BLUE, GREY, VERMILLION, key, plt, save, small
from runs import run, scene

WIDTH, HEIGHT, SPACING = 240, 120, 5e-5  # cells, m
RIDGES = 100  # ridge periods after which a texture repeats itself: lines of the spectrum are 1 % of v/lambda apart
WAIT = 25  # ridge periods that pass before: the jump at the start is over
SAMPLES = 16  # outputs in the time in which a ridge period passes
TEXTURES = range(1, 7)  # seeds
SPEEDS, SPEED = (0.02, 0.05, 0.1, 0.15, 0.2), 0.1  # m/s
PERIODS, PERIOD = (300, 400, 460, 500, 600), 460  # um from ridge to ridge
WAYS = ("across", "along", "even")
def texture(seed, height, width):
    """Random numbers, smoothed by a Gaussian of 1.2 numbers; they repeat themselves, and have mean 1 and rms 0.3."""
    y, x = np.fft.fftfreq(height)[:, None], np.fft.rfftfreq(width)
    random = np.fft.rfft2(np.random.default_rng(seed).standard_normal((height, width)))
    smooth = np.fft.irfft2(random * np.exp(-0.5 * (1.2 * 2 * np.pi) ** 2 * (x**2 + y**2)), (height, width))
    smooth = (smooth - smooth.mean()) / smooth.std()
    return (1 + 0.3 * np.clip(smooth, -3, 3)).astype(np.float32)  # a pressure pulls nowhere


def dome():
    """The pressure (Pa) under an ellipsoid, 10 mm across the ridges and 5 mm along them."""
    x, y = (np.arange(WIDTH) + 0.5) / WIDTH * 2 - 1, (np.arange(HEIGHT) + 0.5) / HEIGHT * 2 - 1
    return 1e4 * np.sqrt(np.clip(1 - (x * 1.2) ** 2 - (y[:, None] * 1.2) ** 2, 0, None))


def power(dermis, way, period, speed, seed):
    """The power of FA2 at each line of its spectrum. Line n lies at n/RIDGES of v/lambda. way: of WAYS, or displacement:
    across, where FA2 answers to the displacement in place of the stress."""
    step = period * 1e-6 / speed / SAMPLES
    with tempfile.TemporaryDirectory() as folder:
        place = (np.arange(WIDTH) if way in ("across", "displacement") else np.arange(HEIGHT)[:, None]) * SPACING * 1e6 / period
        Path(folder, "sites.csv").write_text(f"type,x,y\nfa2,{WIDTH // 2},{HEIGHT // 2}\n")
        contact = "" if way == "even" else f'contact = "crests"\ncontact_length = {period * 1e-6}'
        kernel = way if way == "displacement" else "stress"
        text = scene("ridges", width=WIDTH, height=HEIGHT, spacing=SPACING, contact=contact, kernel=kernel, speed=speed, step=step,
                     duration=(WAIT + RIDGES) * SAMPLES * step)
        out = run(dermis, text, folder, ridges=np.cos(2 * np.pi * place) * np.ones((HEIGHT, WIDTH)),
                  texture=texture(seed, HEIGHT, round(RIDGES * period * 1e-6 / SPACING)), dome=dome())
        fa2 = np.load(out / "responses.npy")[:, 0]
    return np.abs(np.fft.rfft(fa2[WAIT * SAMPLES:])) ** 2  # of one whole period: no line leaks into another


def peak(mean):
    """Where FA2 has the greatest power, over v/lambda: the middle of a band of five lines."""
    bands = np.convolve(mean, np.ones(5) / 5, "same")[:170]
    return (10 + bands[10:].argmax()) / RIDGES


def over_flanks(mean):
    """The mean power within 10 % of v/lambda over that from 0.55 to 0.8 and from 1.2 to 1.45."""
    lines = np.arange(len(mean)) / RIDGES
    flanks = ((lines > 0.55) & (lines < 0.8)) | ((lines > 1.2) & (lines < 1.45))
    return mean[(lines > 0.9) & (lines < 1.1)].mean() / mean[flanks].mean()


def spectra(dermis, cases, seeds):
    """For each case (way, period, speed) the mean of the spectra of all textures."""
    jobs = [(*case, seed) for case in cases for seed in seeds]
    with ThreadPoolExecutor() as pool:
        found = list(pool.map(lambda job: power(dermis, *job), jobs))
    return {case: np.mean(found[i * len(seeds):(i + 1) * len(seeds)], 0) for i, case in enumerate(cases)}


def measure(dermis):
    """The quick figures: power over flanks for each way, and the peaks across the ridges over v/lambda."""
    ways = (*WAYS, "displacement")
    found = spectra(dermis, [(way, PERIOD, SPEED) for way in ways], (1, 2))
    peaks = {"peak": "across", "peak_displacement": "displacement"}
    return {way: over_flanks(found[way, PERIOD, SPEED]) for way in ways} | {
        name: peak(found[way, PERIOD, SPEED]) for name, way in peaks.items()}


def draw(found, picture):
    figure, (lines, speeds, periods) = plt.subplots(1, 3, figsize=(9.5, 3.4), width_ratios=(1.6, 1, 1))
    base = SPEED / PERIOD * 1e6
    shown = {way: np.convolve(found[way, PERIOD, SPEED], np.ones(5) / 5, "same")[5:300] for way in WAYS}
    for way, label, colour in zip(WAYS, ("ridges across the slide", "ridges along the slide", "even contact"),
                                  (BLUE, VERMILLION, GREY)):
        lines.semilogy(np.arange(5, 300) / RIDGES * base, shown[way] / shown["across"].max(), color=colour, label=label,
                       linewidth=1.4)
    lines.axvline(base, color="black", linestyle=":", linewidth=1)
    lines.text(base + 8, 8, f"v/λ = {base:.0f} Hz", fontsize=8, va="center")
    lines.set(xlim=(0, 3 * base), ylim=(1e-11, 50), xlabel="frequency (Hz)")
    lines.set_title("power of FA2 over its greatest\n(ridges 0.46 mm, 100 mm/s)", fontsize=9)
    key(figure, *lines.get_legend_handles_labels(), ncol=3)
    for axis, values, unit, fixed, title in (
            (speeds, SPEEDS, 1e3, lambda v: ("across", PERIOD, v), "greatest power, by speed\n(ridges 0.46 mm)"),
            (periods, PERIODS, 1e-3, lambda p: ("across", p, SPEED), "greatest power, by ridges\n(100 mm/s)")):
        x = np.array(values)
        curve = np.linspace(x.min() * 0.8, x.max() * 1.1, 200)
        expected = np.array([fixed(c)[2] / fixed(c)[1] * 1e6 for c in curve])
        axis.fill_between(curve * unit, 0.95 * expected, 1.05 * expected, color="#dddddd", linewidth=0, label="± 5 %")
        axis.plot(curve * unit, expected, color="black", linewidth=1, label="v/λ")
        axis.plot(x * unit, [peak(found[fixed(v)]) * fixed(v)[2] / fixed(v)[1] * 1e6 for v in values], "o", color=BLUE,
                  markersize=5, label="FA2, six textures")
        axis.set(ylim=(0, 500), xlim=(curve[0] * unit, curve[-1] * unit), ylabel="frequency (Hz)")
        axis.set_title(title, fontsize=9)
    speeds.set_xlabel("speed (mm/s)")
    periods.set_xlabel("ridge period λ (mm)")
    speeds.legend(fontsize=8, frameon=False, loc="upper left")
    small(figure)
    for axis in figure.axes:
        axis.xaxis.label.set_fontsize(9)
        axis.yaxis.label.set_fontsize(9)
    save(figure, picture)


def main(dermis, picture, quick=""):
    dermis = str(Path(dermis).resolve())
    if quick == "--quick":
        for name, value in measure(dermis).items():
            print(f"{name}: {value:.4g}")
        return
    cases = [(way, PERIOD, SPEED) for way in WAYS] + [("across", PERIOD, v) for v in SPEEDS if v != SPEED] + [
        ("across", p, SPEED) for p in PERIODS if p != PERIOD]
    found = spectra(dermis, cases, TEXTURES)
    for (way, period, speed), mean in found.items():
        at = speed / period * 1e6
        print(f"{way}, ridges {period / 1000} mm, {speed * 1000:g} mm/s: greatest power at {peak(mean) * at:.1f} Hz, "
              f"v/lambda {at:.1f} Hz, power over flanks {over_flanks(mean):.3g}")
    draw(found, picture)


if __name__ == "__main__":
    main(*sys.argv[1:])
