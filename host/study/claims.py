# SPDX-License-Identifier: MIT
"""The numbers and verdicts of claims.md, from the files of the study's runs. Their text is claims.md.in."""
import os
import re

import numpy as np

from results import HERE, LOADS, METHODS, PLOTTED_WEIGHTS, RESPONSES, SURFACES, SWEEPS

WAVE, WAVE_RIDGES = "double/exact/wave_circular", "surface.kind=wave"
SPIRAL_PERIOD = 2 * np.pi * 150 / 25  # cells from ridge to ridge of the study's spiral


def percent(value, reference):
    return 100 * (value / reference - 1)


def table(rows):
    """Lines of a table in Markdown."""
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def displacement(r):
    f = {}
    for load in LOADS:
        strain, force = r.traces(f"double/published/flat_{load}"), r.pressure(load).sum()
        f |= {f"strain_{load}_max": strain["strain_max"][-1], f"strain_{load}_mean": strain["strain_mean"][-1],
              f"force_{load}": force, f"strain_per_force_{load}": strain["strain_mean"][-1] / force}
    alike = abs(percent(f["strain_circular_max"], f["strain_linear_max"])) < 1
    curvature = r.field("double/exact/flat_circular", "curvature")
    return f | {"circular_and_linear_alike": alike and f["strain_linear_mean"] > f["strain_circular_mean"],
                "point_least": f["strain_point_max"] < f["strain_circular_max"],
                "flat_curvature_min": curvature.min(), "flat_curvature_max": curvature.max(),
                "flat_uncurved": curvature.max() < 1e-12}


def reading(r, run):
    """SA1 at the end of the circular load: the average of five points as the study plots it, and their true mean; mean and
    rms over the pressed cells."""
    points = np.array([r.traces(run)[f"sa1_probe{k}"][-1] for k in range(5)])
    pressed = r.field(run, "sa1")[r.pressure("circular") > 0]
    return points @ PLOTTED_WEIGHTS, points.mean(), pressed.mean(), np.sqrt((pressed**2).mean())


def amplification(r):
    f, rows, read = {}, [], {}
    for method in METHODS:
        for surface in SURFACES:
            read[surface] = reading(r, f"double/{method}/{surface}_circular")
            changes = [percent(a, b) for a, b in zip(read[surface], read["flat"])]
            rows.append([method, surface] + [f"{value:.{digits + 3}f} ({change:+.{digits}f} %)".replace("+-", "-")
                                             for value, change, digits in zip(read[surface], changes, (2, 2, 3, 2))])
            names = ("plotted", "points", "mean", "rms")
            f |= {f"{method}_{surface}_{name}": change for name, change in zip(names, changes) if surface != "flat"}
        if method == "published":
            spiral, wave = read["spiral"], read["wave"]
            f |= {"points_over_plotted": read["flat"][1] / read["flat"][0],
                  "spiral_amplifies": spiral[2] > 1.01 * read["flat"][2],
                  "spiral_above_wave": all(a > b for a, b in zip(spiral, wave))}
    periods = []
    for cells in 10.0, SPIRAL_PERIOD:
        for surface, turns in ("wave", 1), ("spiral", 2 * np.pi):
            run = r.run(f"double/period_{cells:.1f}_{surface}", "scene.toml",
                        [f"surface.kind={surface}", f"surface.ridges={turns * 150 / cells!r}", "surface.noise=0"])
            mean, rms = reading(r, run)[2:]
            periods.append([f"{cells:.1f}", surface, f"{mean:.5f} ({percent(mean, read['flat'][2]):+.3f} %)",
                            f"{rms:.5f} ({percent(rms, read['flat'][3]):+.2f} %)"])
    return f | {"readings": table(rows), "periods": table(periods), "spiral_period": SPIRAL_PERIOD}


def curvature_at_rest(r):
    """The mean on crests (S > 0.8) and in valleys (S < 0.2), and the rms."""
    f = {}
    for kind in SURFACES[1:]:
        surface, curvature = r.surface(kind), r.field(f"maps/{kind}", "curvature", "0")
        f |= {f"{kind}_crest_curvature": curvature[surface > 0.8].mean(),
              f"{kind}_valley_curvature": curvature[surface < 0.2].mean(),
              f"{kind}_rms_curvature": np.sqrt((curvature**2).mean())}
    return f | {"crests_positive": f["wave_crest_curvature"] > 0 and f["spiral_crest_curvature"] > 0,
                "spiral_more_curved": f["spiral_rms_curvature"] > f["wave_rms_curvature"]}


def sustained_and_transient(r):
    sa1, sa2, fa1 = (r.traces(WAVE)[f"{q}_mean"] for q in ("sa1", "sa2", "fa1"))
    fa2 = r.traces("double/published/wave_circular")["fa2_mean"]
    decayed = 2 + np.argmax(abs(fa2[2:]) < 0.01 * abs(fa2[2]))
    return {"sa1_at_5": sa1[500], "sa1_end": sa1[-1], "sa1_settles": abs(sa1[-1] / sa1[500] - 1) < 1e-3,
            "sa2_slope_end": sa2[-1] - sa2[-101], "sa2_end": sa2[-1], "sa2_climbs": sa2[-1] > sa2[-101] * 1.05,
            "fa1_first": fa1[1], "fa1_end": fa1[-1],
            "fa1_peaks_first": fa1.max() == fa1[1] and fa1[-1] < 1e-5 * fa1[1],
            "fa2_published_first": fa2[1], "fa2_published_second": fa2[2], "fa2_published_decayed": 0.01 * decayed,
            "fa2_returns_sharply": decayed < 10}  # within a tenth of a second


def sweep(r, key, quantity, method="exact"):
    """The mean over all cells, a row for each value of the sweep."""
    return np.array([r.traces(f"double/sweep_{key}/{value}/{method}")[f"{quantity}_mean"] for value in SWEEPS[key]])


def falls(values):
    return bool((np.diff(abs(values)) < 0).all())


def modulus(r):
    sa1, sa2, fa1, fa2 = (sweep(r, "modulus", q) for q in RESPONSES)
    spikes = sweep(r, "modulus", "fa2", "published")[:, 1]
    # the output after the last that is more than 1 % off the end
    settled = [0.01 * (1 + np.flatnonzero(abs(row - row[-1]) > 0.01 * abs(row[-1]))[-1]) for row in sa1]
    same_spike, same_density = (max(abs(v)) < 1.02 * min(abs(v)) for v in (spikes, fa2[:, 1]))
    changes = int((fa1[:, 2:] * fa1[:, 1:-1] < 0).sum())
    return {"modulus_sa1_end": sa1[:, -1], "modulus_sa1_settled": settled,
            "modulus_lowers_and_settles": falls(sa1[:, -1]) and (np.diff(settled) <= 0).all() and settled[0] > settled[-1],
            "modulus_sa2_end": sa2[:, -1], "modulus_lowers_sa2": falls(sa2[:, -1]),
            "modulus_fa1_first": fa1[:, 1], "modulus_fa1_at_1": fa1[:, 100], "modulus_lowers_fa1_at_1": falls(fa1[:, 100]),
            "modulus_fa2_published_first": spikes, "modulus_fa2_exact_first": fa2[:, 1],
            "spike_alone_same": same_spike and not same_density,
            "modulus_sign_changes": changes, "skin_oscillates": changes > 0}


def viscosity(r):
    sa1, sa2, fa1, fa2 = (sweep(r, "viscosity", q) for q in RESPONSES)
    published = sweep(r, "viscosity", "fa2", "published")
    counts = [(int((p[2:101] < 0).sum()), int((e[2:101] < 0).sum())) for p, e in zip(published, fa2)]
    negative = [f"viscosity {value}: {a}, {b}, {row[2] / row[1]:.3f}"
                for value, (a, b), row in zip(SWEEPS["viscosity"], counts, published)]
    return {"viscosity_sa1_at_0.5": sa1[:, 50], "viscosity_sa1_end": sa1[:, -1],
            "viscosity_lowers_sa1_at_0.5": falls(sa1[:, 50]),
            "viscosity_sa2_end": sa2[:, -1], "viscosity_lowers_sa2": falls(sa2[:, -1]),
            "viscosity_fa1_first": fa1[:, 1], "viscosity_fa1_at_1": fa1[:, 100],
            "viscosity_lowers_fa1_first": falls(fa1[:, 1]),
            "viscosity_fa2_first": fa2[:, 1], "viscosity_lowers_fa2_size": falls(fa2[:, 1]),
            "viscosity_fa2_negative": bool((fa2[:, 1] < 0).all()),
            "negative": "; ".join(negative), "fa2_not_always_negative": any(c != (99, 99) for c in counts)}


def adapted_sa2(r):
    bounded, slow = (r.traces(r.run(f"double/adapted_{time}", "scene.toml",
                                    [WAVE_RIDGES, f"receptors.sa2_adaptation={time}"]))["sa2_mean"] for time in ("1", "1e6"))
    return {"adapted_sa2_at_5": bounded[500], "adapted_sa2_end": bounded[-1],
            "slow_sa2_difference": abs(slow - r.traces(WAVE)["sa2_mean"]).max()}


def spike(r):
    rows = []
    for step in "0.02", "0.01", "0.005", "0.001":
        settings = ["output.fields=[]", f"time.step={step}", f"time.duration={10 * float(step)!r}"]
        published, exact = (r.traces(r.run(f"double/spike_{step}_{method}", "scene.toml", [f"method={method}", *settings]))
                            ["fa2_probe0"][1] for method in METHODS)
        impulse = float(r.table(f"double/spike_{step}_exact/impulses.csv")[0]["probe0"])
        rows.append([step, f"{published:.3f}", f"{published * float(step):.4f}", f"{exact:.4f}", f"{impulse:.4f}"])
    return {"spikes": table(rows)}


def distance(a, b, quantity, first):
    """The greatest difference over the five points from an output on, in percent of the greatest value of b."""
    a, b = (np.array([t[f"{quantity}_probe{k}"][first:-1] for k in range(5)]) for t in (a, b))
    return 100 * abs(a - b).max() / abs(b).max()


def published_error(r):
    r.run("double/stencil", "scene.toml", [WAVE_RIDGES, "curvature.stencil=published", "curvature.edges=published"])
    published, stencil, exact = (r.traces(f"double/{run}") for run in
                                 ("published/wave_circular", "stencil", "exact/wave_circular"))
    rows = []
    for quantity in ["strain", *RESPONSES]:
        first = 2 if quantity == "fa2" else 1  # the first value of FA2 is the spike
        pairs = (published, exact), (published, stencil), (stencil, exact)
        rows.append([quantity, *(f"{distance(a, b, quantity, first):.3f}" for a, b in pairs)])
    curvature = r.field(WAVE, "curvature")
    off = abs(r.field("double/stencil", "curvature") - curvature)
    inside = off[2:-2, 2:-2].max()
    off[2:-2, 2:-2] = 0
    return {"distances": table(rows), "curvature_rms": np.sqrt((curvature**2).mean()),
            "curvature_difference_inside": inside, "curvature_difference_edge": off.max(),
            "euler_strain_theory": 100 * 0.0154 / (2 * np.e)}


def fingertip(r):
    """The nine scenes in SI. The model is linear, so that the pressure of 10 kPa gives that of the other loads."""
    rows = []
    for surface in SURFACES:
        for load in LOADS:
            run = r.run(f"fingertip/{surface}_{load}", "fingertip.toml", [f"surface.kind={surface}", f"load.kind={load}"])
            greatest = r.field("fingertip/flat_circular", "strain").max()
            strain, summary = r.field(run, "strain"), r.summary(run)
            pressure = 1e4 * strain / greatest
            sa1, flat = (r.field(f"fingertip/{s}_{load}", "sa1")[strain > 0] for s in (surface, "flat"))
            held = r.traces(run)["fa2_mean"][12:]  # the load has risen within 0.1 s
            rows.append([surface, load, f"{pressure.max() / 1e3:.3g}", f"{pressure.sum() * 5e-5**2 * 1e3:.3g}",
                         f"{strain.max():.3g}", f"{strain.max() * 1e3:.3g}", f"{summary['greatest_gain']:.2g}",
                         f"{percent(sa1.mean(), flat.mean()):+.3f} %",
                         f"{percent(np.sqrt((sa1**2).mean()), np.sqrt((flat**2).mean())):+.2f} %",
                         f"{100 * (held < 0).mean():.0f} %"])
    return {"fingertip": table(rows)}


def cited_ranges(r):
    r.run("sweep_fingertip", "fingertip.toml",
          [WAVE_RIDGES, "output.fields=[]", "material.modulus=1e6:2e6:5", "material.viscosity=0.1:2.5:5"])
    runs = {(float(t["material.modulus"]), float(t["material.viscosity"])): t for t in r.table("sweep_fingertip/runs.csv")}
    moduli, viscosities = (sorted({key[i] for key in runs}) for i in (0, 1))
    rows, off = [], 0
    for E in moduli:
        found = [runs[E, eta] for eta in viscosities]
        ends = [[float(t[name]) for t in found] for name in ("strain_max_final", "sa1_mean_final", "fa1_max_peak")]
        off = max([off, *(max(v) / min(v) - 1 for v in ends)])
        rows.append([f"{E / 1e6:g}", f"{1e6 * viscosities[0] / E:.2g} to {1e6 * viscosities[-1] / E:.2g}",
                     *(f"{v[0]:.4g}" for v in ends)])
    return {"cited_ranges": table(rows), "cited_viscosity_changes": 100 * off}


def printed_units(r):
    r.run("double/printed", "scene.toml", ["material.modulus=1.54e6"])
    refused = r.call("plan", HERE / "scene.toml", "--set", "method=euler", "material.modulus=1.54e6").stderr
    return {"printed_tau": 1 / 1.54e6, "printed_z": 0.01 * 1.54e6,
            "printed_euler_refusal": refused.partition(".toml: ")[2].strip(),
            "printed_exact_strain": r.traces("double/printed")["strain_max"][1] * 1.54e6}


def fill(text, fields):
    """Sets fields into a text: {name}, {name:format} of a number or a list of numbers, {name? if true / if false}. Fails
    unless both have the same names."""
    used = set()

    def value(match):
        name, spec, yes, no = match.groups()
        used.add(name)
        if yes is not None:
            return yes if fields[name] else no
        values = np.atleast_1d(fields[name])
        return ", ".join(format(v, spec or "") for v in values)

    filled = re.sub(r"\{([a-z0-9_.]+)(?::([^}]*))?(?:\? ([^}]*?) / ([^}]*))?\}", value, text)
    if used != set(fields):
        raise KeyError(f"claims.md.in and claims.py differ in {sorted(used ^ set(fields))}")
    return filled


def text_of(r):
    """claims.md: first how many claims hold."""
    fields = {"evidence": os.path.relpath(HERE.parents[1] / "bench/EVIDENCE.md", r.out.resolve())}
    parts = [displacement, amplification, curvature_at_rest, sustained_and_transient, modulus, viscosity, adapted_sa2,
             spike, published_error, fingertip, cited_ranges, printed_units]
    for part in parts:
        fields |= part(r)
    template = (HERE / "claims.md.in").read_text("utf-8").partition("-->\n")[2]  # after the comment for its editors
    text = fill(template, fields)
    verdicts = re.findall(r"^\| \d.*\| \*\*(holds|holds in part|does not hold)\*\*[^|]*\|$", text, re.M)
    hold, in_part = verdicts.count("holds"), verdicts.count("holds in part")
    return (f"{hold} of {len(verdicts)} claims hold, {in_part} in part, {len(verdicts) - hold - in_part} do not.\n\n"
            + text)
