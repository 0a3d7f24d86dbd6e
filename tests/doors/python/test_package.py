# SPDX-License-Identifier: MIT
"""The package as it is installed, and the tutorial."""
import ast
import inspect
import os
import pathlib
import pickle
import pydoc
import re
import struct
import subprocess
import sys

import dermis
import pytest

TOP = pathlib.Path(__file__).parents[3]


def test_the_version_is_that_of_the_headers():
    header = (TOP / "include/dermis/version.hpp").read_text()
    assert dermis.__version__ == ".".join(re.findall(r"DERMIS_VERSION_\w+ (\d+)\n", header))
    assert re.fullmatch(r"[0-9a-f]{12}|(unknown|[0-9a-f]{12}-dirty)-[0-9a-f]{12}", dermis.commit)


def of_run(*names):
    """Functions of ./run, as a script."""
    return "\n".join(re.search(rf"^{name}\(\) \{{.*?^\}}", (TOP / "run").read_text(), re.M | re.S)[0] for name in names)


def test_the_page_of_the_package_links_to_no_file_that_is_not_beside_it():
    script = of_run("page_of_package") + "\npage_of_package README.md"
    page = subprocess.run(["sh", "-c", script], cwd=TOP, capture_output=True, text=True, check=True).stdout
    assert re.findall(r"\]\((?!#)[^)]*\)", (TOP / "README.md").read_text())
    assert not re.findall(r"!\[|\]\((?!#|https?:)[^)]*\)", page)
    assert "MODEL.md (`host/core/description/MODEL.md`) lists" in page and page.startswith("# dermis\n")


def test_a_release_can_be_repeated_after_a_wheel_that_failed(tmp_path):
    for name in ("run", "CHANGELOG.md", "CITATION.cff", "host/examples/README.md", "include/dermis/version.hpp", "host/examples/CMakeLists.txt"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes((TOP / name).read_bytes())
    script = (tmp_path / "run").read_text()
    version = re.search(r"^## ([0-9.]+)$", (TOP / "CHANGELOG.md").read_text(), re.M)[1]
    (tmp_path / "run").write_text(script.replace("    ./run wheel\n", "    [ -d out/dist ]\n"))
    who = {f"GIT_{role}_{what}": "dermis@localhost" for role in ("AUTHOR", "COMMITTER") for what in ("NAME", "EMAIL")}

    def call(*command):
        return subprocess.run(command, cwd=tmp_path, env={**os.environ, **who}, capture_output=True, text=True)

    call("git", "init", "-q")
    (tmp_path / ".git/info/exclude").write_text("out\n")
    call("git", "add", "-A")
    call("git", "commit", "-qm", "first")
    assert call("sh", "run", "release", version).returncode == 1  # the wheel that fails
    (tmp_path / "out/dist").mkdir(parents=True)
    again = call("sh", "run", "release", version)
    assert again.returncode == 0 and f"is version {version}" in again.stdout, again.stderr
    assert call("git", "log", "--format=%s").stdout == f"Version {version}\nfirst\n"
    assert (tmp_path / "out/dist/TAG.txt").read_text().startswith(f"dermis {version}\n")


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


def test_the_python_of_the_front_page_draws_a_report(tmp_path):
    (code,) = re.findall(r"```python\n(.*?)```", (TOP / "README.md").read_text(), re.DOTALL)
    subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env={**os.environ, "MPLBACKEND": "agg"}, check=True)
    assert (tmp_path / "touch/maps.png").read_bytes().startswith(b"\x89PNG")
    assert "circular load of 20,000 Pa, envelope ramp" in (tmp_path / "touch/report.html").read_text()


def test_the_picture_of_the_front_page_is_drawn_by_its_script_and_is_low(tmp_path):
    script = TOP / "host/examples/hero.py"
    subprocess.run([sys.executable, script, tmp_path / "hero.png"], check=True)
    for picture in (tmp_path / "hero.png", TOP / "host/examples/hero.png"):
        width, height = struct.unpack(">II", picture.read_bytes()[16:24])
        assert 1000 * height <= 400 * width


def test_the_tutorial_prints_what_stands_beside_it():
    script = TOP / "host/examples/tutorial.py"
    run = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True)
    assert run.stdout == (TOP / "host/examples/tutorial.txt").read_text()


def test_a_type_checker_accepts_the_package_and_a_users_code_and_finds_a_mistake(tmp_path):
    (tmp_path / "right.py").write_text("""
import dermis
import numpy as np

skin = dermis.Skin({"grid": {"width": 4, "height": 3}}, (2, 3), responses="sa1")
for name in ("sa1", "strain"):
    skin[name].mean()
skin.reset((1, 2))
skin.reset(np.array([True, False]))
skin.load(skin.save(3))
skin.press(np.ones((2, 3, 3, 4), np.float32), [1e-3] * 6)
skin.press(memoryview(bytes(288)), np.full((2, 3), 1e-3))
modulus = dermis.fingertip().material.modulus
result = dermis.run("scene.toml")
least = {name: result[name].min for name in result}
touch = dermis.contact.Touch(skin, 1e-3)
touch.add(np.zeros((6, 3)), np.zeros((6, 9)), np.arange(6), np.zeros((6, 3)), np.zeros((6, 3)), radius=2e-3)
skin.press(touch, 1e-3)
skin.press(np.ones((2, 3, 3, 4), np.float32), 1e-3, out={"sa1": np.empty((2, 3, 3, 4), np.float32)})
contact = dermis.contact.Contact(1e-3, 1e-3, force=1.0)
rows = dermis.sweep("scene.toml", {"time.step": [0.1]})
times: float = dermis.run(dermis.Scene(load=dermis.Load(intensity="2 kPa"))).time[0]
""")
    wrong = """import dermis
from dermis import contact
skin = dermis.Skin(dermis.fingertip())
array = skin["sa1"]
dermis.Skin({}, responses=1)
dermis.Skin({}, responses="sa4")
dermis.Skin({}, hold="cubic")
dermis.Skin({}, precision="float")
dermis.Skin({}, control="force")
skin.press("no array", 1e-3)
skin.press(array, "no time")
skin.press(array, 1e-3, out={"sa4": array})
skin.press([[1.0]], 1e-3)
skin.press_frames("no frames", 1e-3)
skin["nothing"]
skin.reset("env 3")
skin.save(1.5)
skin.load("no state")
dermis.run("a.toml", device=3)
dermis.run("a.toml", precision="f16")
dermis.run("a.toml")["nothing"]
contact.Touch(skin, 1e-3).add(1, 2, 3, 4, 5)
contact.Contact("1 mm", 1e-3, 1.0)
contact.Pad("no array", 1e-3)
contact.Body("egg")
contact.add_depths(contact.Pad(array, 1e-3), 1.0, 1.0)
contact.add_taxels(contact.Pad(array, 1e-3), array, width=1.0, height=1.0, unit="kg")
dermis.Afferents(type="sa9")
dermis.Afferents(follow="pain")
dermis.Grid(width="3 cells", hight=2)
dermis.Load(kind="squeeze")
dermis.fit("a.csv", kind="hysteresis")
"""
    (tmp_path / "wrong.py").write_text(wrong)
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path / "cache")]
    right = subprocess.run([*command, "-p", "dermis"], cwd=tmp_path, capture_output=True, text=True)
    assert right.returncode == 0, right.stdout
    right = subprocess.run([*command, "right.py"], cwd=tmp_path, capture_output=True, text=True)
    assert right.returncode == 0, right.stdout
    found = subprocess.run([*command, "wrong.py"], cwd=tmp_path, capture_output=True, text=True).stdout
    lines = {int(line) for line in re.findall(r"^wrong.py:(\d+): error", found, re.M)}
    assert lines == set(range(5, len(wrong.splitlines()) + 1)), found


def test_only_public_names_are_listed():
    for module in (dermis, dermis.contact):
        assert dir(module) == sorted(module.__all__)
    names = [name for name in dir(dermis.Skin) if not name.startswith("_")]
    assert "spike_bytes" not in names and "take_material" not in names and "press" in names


def test_help_shows_each_signature_once_and_none_that_only_refuses():
    for thing in (getattr(module, name) for module in (dermis, dermis.contact) for name in module.__all__):
        text = pydoc.render_doc(thing, renderer=pydoc.plaintext) if callable(thing) else ""
        assert "NoReturn" not in text and "*others" not in text, text
    assert pydoc.render_doc(dermis.Skin).count("press(") == 1
    assert inspect.getdoc(dermis.contact.Contact.__init__).count("__init__(") == 1


def test_an_error_of_an_input_is_a_value_error_and_can_be_pickled():
    with pytest.raises(ValueError) as caught:
        dermis.Scene(grid={"width": 0})
    again = pickle.loads(pickle.dumps(caught.value))
    assert type(again) is dermis.InputError and isinstance(again, dermis.Error) and str(again) == str(caught.value)
    assert (again.code, again.parameter) == ("bad_input", "grid.width")
    with pytest.raises(dermis.Error) as caught:
        dermis.plot("/nowhere")
    assert caught.value.code == "io" and not isinstance(caught.value, ValueError)
