# SPDX-License-Identifier: MIT
"""The suites of a build, as ctest lists them."""

import json
import subprocess
import sys


def labelled(build, label):
    """The names of the suites with a label, in order; there is at least one."""
    text = subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1"], capture_output=True, text=True,
                          check=True).stdout
    names = [test["name"] for test in json.loads(text)["tests"]
             if any(p["name"] == "LABELS" and label in p["value"] for p in test["properties"])]
    if not names:
        sys.exit(f"no suite has the label {label} in {build}")
    return sorted(names)
