# SPDX-License-Identifier: MIT
"""The package as it is installed, and the tutorial."""
import ast
import inspect
import os
import pathlib
import re
import subprocess
import sys

import dermis

TOP = pathlib.Path(__file__).parents[3]


def test_the_version_is_that_of_the_headers():
    header = (TOP / "include/dermis/version.hpp").read_text()
    assert dermis.__version__ == ".".join(re.findall(r"DERMIS_VERSION_\w+ (\d+)\n", header))
    assert re.fullmatch(r"[0-9a-f]{12}|(unknown|[0-9a-f]{12}-dirty)-[0-9a-f]{12}", dermis.commit)


def test_types_come_with_the_package():
    folder = pathlib.Path(dermis.__file__).parent
    assert (folder / "py.typed").exists()
    stub = ast.parse((folder / "_core.pyi").read_text())
    names = {node.name for node in stub.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    compiled = {name for name, value in vars(dermis._core).items() if callable(value) and not name.startswith("__")}
    assert names == compiled


def test_everything_public_says_what_it_is():
    for thing in (getattr(module, name) for module in (dermis, dermis.contact) for name in module.__all__):
        if callable(thing) or inspect.ismodule(thing):
            assert thing.__doc__, thing


def test_the_python_of_the_front_page_draws_its_picture(tmp_path):
    (code,) = re.findall(r"```python\n(.*?)```", (TOP / "README.md").read_text(), re.DOTALL)
    subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env={**os.environ, "MPLBACKEND": "agg"}, check=True)
    assert (tmp_path / "touch.png").read_bytes().startswith(b"\x89PNG")


def test_the_tutorial_prints_what_stands_beside_it():
    script = TOP / "host/examples/tutorial.py"
    run = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True)
    assert run.stdout == (TOP / "host/examples/tutorial.txt").read_text()


def test_a_type_checker_accepts_the_package_and_a_users_code_and_finds_a_mistake(tmp_path):
    (tmp_path / "right.py").write_text("""
import dermis
import numpy as np

skin = dermis.Skin({"grid": {"width": 4, "height": 3}}, (2, 3), responses="sa1")
skin.press(np.ones((2, 3, 3, 4), np.float32), 1e-3, out={"sa1": np.empty((2, 3, 3, 4), np.float32)})
contact = dermis.contact.Contact(1e-3, 1e-3, force=1.0)
rows = dermis.sweep("scene.toml", {"time.step": [0.1]})
times: float = dermis.run(dermis.Scene(load=dermis.Load(intensity="2 kPa"))).time[0]
""")
    (tmp_path / "wrong.py").write_text("import dermis\ndermis.Skin({}, responses=1)\ndermis.contact.Contact('1 mm', 1e-3, 1.0)\n")
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path / "cache")]
    right = subprocess.run([*command, "-p", "dermis"], cwd=tmp_path, capture_output=True, text=True)
    assert right.returncode == 0, right.stdout
    right = subprocess.run([*command, "right.py"], cwd=tmp_path, capture_output=True, text=True)
    assert right.returncode == 0, right.stdout
    wrong = subprocess.run([*command, "wrong.py"], cwd=tmp_path, capture_output=True, text=True)
    assert wrong.stdout.count("error:") == 2, wrong.stdout
