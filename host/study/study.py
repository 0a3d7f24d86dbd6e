# SPDX-License-Identifier: MIT
"""Repeats the published study "Passive Transduction Features of Skin" by the command dermis.

    study.py [DERMIS] [--out FOLDER] [--resume]

DERMIS is the command (by default `dermis` of the PATH). It runs the scenes beside this file; this script reads what they
have written, checks the study's claims and draws its figures. FOLDER, by default out/study, then has claims.md, and
index.html with each figure beside its claims. With --resume runs stay that an earlier study has finished there. Needs
Python 3.9, NumPy and matplotlib. The exit status is 1 if a cell differs between Vulkan and the CPU, or a run fails.
"""
import argparse
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

try:
    import charts
    import claims
    import figures
    import page
    from results import HERE, LOADS, METHODS, RESPONSES, SURFACES, SWEEPS, Failed, Results
except ModuleNotFoundError as error:
    sys.exit(f"study: {error.name} is missing; the study needs NumPy and matplotlib, as Debian's python3-matplotlib")


def study_runs():
    """By folder, the settings of the study's 38 runs: nine scenes and two sweeps, by its method and exactly."""
    runs = {}
    for method in METHODS:
        for surface in SURFACES:
            for load in LOADS:
                runs[f"{method}/{surface}_{load}"] = [f"method={method}", f"surface.kind={surface}", f"load.kind={load}"]
        for key, values in SWEEPS.items():
            for value in values:
                runs[f"sweep_{key}/{value}/{method}"] = [f"method={method}", "surface.kind=wave", f"material.{key}={value}"]
    return dict(sorted(runs.items()))


def float_error(r, folder):
    """The greatest difference of a mean, least or greatest value from the one in double, by its trace's greatest value."""
    in_float, in_double = r.traces(folder), r.traces(f"double/{folder}")
    worst = [0]
    for quantity in ["strain", *RESPONSES]:
        columns = [f"{quantity}_{what}" for what in ("mean", "min", "max")]
        greatest = max(abs(in_double[name]).max() for name in columns)
        worst += [abs(in_float[name] - in_double[name]).max() / greatest for name in columns if greatest]
    return max(worst)


def run_study(r, vulkan):
    """Runs the 38 scenes in float, on Vulkan and the CPU, and in double. Returns how many cells differ."""
    compared = different = 0
    print(f"{'scene':<28} {'cells compared':>14} {'cells different':>15} {'f32 error':>10}", flush=True)
    runs = study_runs()

    def both(folder):
        r.run(f"double/{folder}", "scene.toml", runs[folder])
        return r.run(folder, "scene.toml", runs[folder], "vulkan" if vulkan else "cpu", "f32", ["--check"] * vulkan)

    with ThreadPoolExecutor(2) as pool:  # a software driver leaves cores idle while it is waited for
        try:
            for folder in pool.map(both, runs):
                check = r.summary(folder)["cross_check"] or {"cells": 0, "different": 0}
                compared += check["cells"]
                different += check["different"]
                print(f"{folder:<28} {check['cells']:>14} {check['different']:>15} {float_error(r, folder):>10.1e}", flush=True)
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    print(f"{len(runs)} scenes; {compared} cells compared, {different} different", flush=True)
    return different


def reproduce(r):
    """Runs, checks and draws everything. Returns the exit status."""
    if r.out.is_dir() and any(r.out.iterdir()) and not (r.out / "published").is_dir():
        raise Failed(f"{r.out} has other files; allowed: a folder that is new, empty or of an earlier study")
    for name in "claims.md", "index.html":
        (r.out / name).unlink(missing_ok=True)
    opened = r.call("plan", HERE / "scene.toml", "--device", "vulkan")
    vulkan = opened.returncode == 0
    if not vulkan:
        print(f"no Vulkan, so nothing is compared: {opened.stderr.strip()}")
    different = run_study(r, vulkan)
    print("claims, charts and figures ..", flush=True)
    for key in [f"surface.kind={kind}" for kind in SURFACES] + [f"load.kind={kind}" for kind in LOADS]:
        r.run_map(key)
    text = claims.text_of(r)
    charts.error_against_time(r, vulkan)
    figures.draw_all(r.out)
    r.write("claims.md", text)
    r.write("index.html", page.page_of(text, figures.FIGURES))
    print(text.partition("\n")[0])
    print(f"open first: {r.out / 'index.html'}")
    return 1 if different else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("dermis", nargs="?", default="dermis", help="the command (dermis)")
    parser.add_argument("--out", type=Path, default=Path("out/study"), help="folder for the results (out/study)")
    parser.add_argument("--resume", action="store_true", help="keep runs in --out that are finished, of the same scene, "
                        "version and commit, and do the rest")
    try:
        return reproduce(Results(**vars(parser.parse_args())))
    except (Failed, OSError) as error:
        print(f"study: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
