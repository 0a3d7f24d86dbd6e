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


def of_run(*names):
    """Functions of ./run, as a script."""
    return "\n".join(re.search(rf"^{name}\(\) \{{.*?^\}}", (TOP / "run").read_text(), re.M | re.S)[0] for name in names)


def test_the_page_of_the_package_links_to_no_file_that_is_not_beside_it():
    script = of_run("page_of_package") + "\npage_of_package README.md"
    page = subprocess.run(["sh", "-c", script], cwd=TOP, capture_output=True, text=True, check=True).stdout
    assert re.findall(r"\]\((?!#)[^)]*\)", (TOP / "README.md").read_text())
    assert not re.findall(r"!\[|\]\((?!#|https?:)[^)]*\)", page)
    assert "MODEL.md (`host/core/description/MODEL.md`) says" in page and page.startswith("# dermis\n")


def test_a_release_can_be_repeated_after_a_wheel_that_failed(tmp_path):
    for name in ("run", "CHANGELOG.md", "CITATION.cff", "README.md", "include/dermis/version.hpp", "host/examples/CMakeLists.txt"):
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
