# SPDX-License-Identifier: MIT
"""Every operator new below a call from Python fails, one after another, and from each one on."""
import os
import pathlib
import re
import subprocess
import sys

import pytest

HERE = pathlib.Path(__file__).parent
NAMES = subprocess.run([sys.executable, HERE / "starved.py"], capture_output=True, text=True, check=True).stdout


@pytest.fixture(scope="module")
def failing_new(tmp_path_factory):
    library = tmp_path_factory.mktemp("failing") / "failing_new.so"
    subprocess.run([os.environ.get("CXX", "c++"), "-std=c++17", "-O1", "-shared", "-fPIC", "-o", library,
                    HERE / "failing_new.cpp"], check=True)
    return library


@pytest.mark.parametrize("name", NAMES.splitlines())
def test_a_call_without_memory_is_a_memory_error_and_the_next_one_works(name, failing_new):
    environment = {**os.environ, "LD_PRELOAD": str(failing_new)}
    run = subprocess.run([sys.executable, HERE / "starved.py", name], capture_output=True, text=True, env=environment,
                         timeout=120)
    assert run.returncode == 0, run.stderr
    assert re.fullmatch(r"failed: [1-9]\d*\n", run.stdout)
