# SPDX-License-Identifier: MIT
"""Runs test suites on each device that the layer makes, and prints a matrix: how many cases of each suite passed on each.

Arguments: --tests dermis-tests, --command dermis, --layers the layer's folder, --all for whole suites, --only SHIM.
Fails where a case fails, where the command's self-test does not say of a device what it should, or where nothing ran.
"""

import argparse
import os
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from tempfile import TemporaryDirectory

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from suites import labelled

LAYER = "VK_LAYER_DERMIS_shim"
# Above the shim, validation holds the library to the limits that the shim tells.
LAYERS = f"VK_LAYER_KHRONOS_validation:{LAYER}"
# But where allocations are counted, of which validation makes many: there a test's own validation stands below.
COUNTS_ALLOCATIONS = ("skin",)
SHIMS = ["noncoherent", "split", "no_timestamps", "alignment", "least", "subgroup=1", "subgroup=4", "subgroup=64", "metal",
         "groups=16", "few_buffers", "contracting"]
# Memory, limits, bits and bindings unlike lavapipe's; all others wait for `./run trust`.
QUICK_SHIMS = ["noncoherent", "least", "few_buffers", "contracting"]
# Cases that together use every kind of buffer, submission and limit.
QUICK = {
    "device": "the canary*",
    "embedding": "timestamps*,nothing of sites*,drawn skins in a host's*",
    "hold": "a step from rest*",
    "sites": "*",
    "skin": "a pause keeps*",
}
# What the command's self-test says of a device.
VERDICTS = {"few_buffers": "maxPerStageDescriptorStorageBuffers = 4; 12 are needed", "contracting": "; NOT exact"}
# Cases that claim equal bits, or that "vulkan" takes the device: not on one whose bits differ and which has to be named.
CLAIMS_OF_BITS = [
    "*bits*", "*bit for bit*", "a check takes any NaN*", "a caller's rounding*", "*is counted",
    "the recorded check*", "requirements are data*", "programs on several devices*", "a device that fails in one*",
    "auto takes no software*", "a submission that fails*",
    "a model that cannot serve*", "long runs: plain float*", "from press to press nothing*", "skins on threads*",
    "a press of pads*", "a trial of a host's code*", "dermis run writes*",
    "bad input: one line*", "dermis devices lists*", "a summary says*", "bench says how long*",
    "a press uploads*", "frames whose submission*", "small pads share*",
    "what fails in a press*", "fibres of a skin*", "fibres on sites*",
    "a device gives the CPU path's spikes*", "a press of fibres is cut*", "progress ends a press*", "a skin fires fields*",
    "the test of a march steps its very variant*", "a driver's file that is not JSON*"]
CLAIMS = "--test-case-exclude=" + ",".join(CLAIMS_OF_BITS)


def environment(shim, layer_folder, layers):
    # If the caller does not set it: lavapipe compiles shaders without optimising, which takes less time. Bits are equal.
    return {"GALLIVM_PERF": "nopt", **os.environ, "DERMIS_SHIM": shim, "VK_INSTANCE_LAYERS": layers,
            "VK_LAYER_PATH": f"{layer_folder}:/usr/share/vulkan/explicit_layer.d"}


def cases(program, variables, *filters):
    """Runs test cases in a folder of their own; returns what the matrix says of them, and the output where one failed."""
    with TemporaryDirectory() as folder:
        done = subprocess.run([program, "--no-skip", *filters], env=variables, cwd=folder, capture_output=True, text=True)
    found = re.search(r"test cases: +(\d+) \| +(\d+) passed \| +(\d+) failed", done.stdout)
    if found and found[1] == "0" and CLAIMS in filters:
        return "-", ""
    if not found or found[1] == "0":
        return "none", done.stdout + done.stderr
    failed = done.returncode != 0 or found[3] != "0"
    return f"{found[2]}/{found[1]}", done.stdout + done.stderr if failed else ""


def suite(program, variables, name, shim, whole):
    filters = [f"--source-file=*/{name}_test.cpp"]
    if not whole:
        filters.append(f"--test-case={QUICK[name]}")
    if shim == "contracting":
        filters.append(CLAIMS)
        variables = {**variables, "DERMIS_TEST_DEVICE": "0"}
    return cases(program, variables, *filters)


def row_of(options, shim, suites):
    """Runs the command's self-test and suites on a device; returns its line of the matrix, and what failed."""
    failures = []
    checked = subprocess.run([options.command, "check"], env=environment(shim, options.layers, LAYER),
                             capture_output=True, text=True)
    text = checked.stdout + checked.stderr
    verdict = VERDICTS.get(shim, "differ; exact\n")
    if verdict not in text or f", {shim}" not in text:
        failures.append(f"{shim}: dermis check should say {verdict!r}:\n{text}")
    line = f"{shim:<14} {({'few_buffers': 'refused', 'contracting': 'not exact'}).get(shim, 'exact'):<10}"
    kind = shim.split("=")[0]
    own = kind in ("noncoherent", "split", "alignment", "least", "few_buffers", "contracting")
    for name in ["shims", *(suites if shim != "few_buffers" else [])]:
        variables = environment(shim, options.layers, LAYER if name in COUNTS_ALLOCATIONS else LAYERS)
        if name == "shims" and not own:
            line += f"{'':>12}"
            continue
        if name == "shims":
            passed, output = cases(options.tests, variables, "--source-file=*/shims_test.cpp", f"--test-case={kind}:*")
        else:
            passed, output = suite(options.tests, variables, name, shim, options.all)
        line += f"{passed:>12}"
        if output:
            failures.append(f"{shim}, {name}:\n{output[-6000:]}")
    return line, failures


def main():
    parser = argparse.ArgumentParser()
    for name in ("--tests", "--command", "--layers"):
        parser.add_argument(name, type=Path, required=True)
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--only")
    options = parser.parse_args()
    for name in ("tests", "command", "layers"):
        setattr(options, name, getattr(options, name).resolve())
    suites = labelled(options.tests.parents[1], "device") if options.all else list(QUICK)
    suites = [name for name in suites if name != "study"]  # a script, no suite of the test program
    shims = [options.only] if options.only else SHIMS if options.all else QUICK_SHIMS
    print(f"{'':<14} {'self-test':<10}" + "".join(f"{name:>12}" for name in ["shims", *suites]), flush=True)
    failures = []
    with ThreadPoolExecutor(os.cpu_count() if options.all else 1) as pool:
        for line, failed in pool.map(lambda shim: row_of(options, shim, suites), shims):
            print(line, flush=True)
            failures += failed
    for failure in failures:
        print(failure)
    sys.exit(bool(failures))


if __name__ == "__main__":
    main()
