# SPDX-License-Identifier: MIT
"""Pressure on skin in, mechanoreceptor responses out.

    import dermis
    result = dermis.run({"surface": {"kind": "spiral"}})
    result["fa1"].mean                                  # over all cells, float64 of shape (times,)

    skin = dermis.Skin(dermis.Scene.from_file("pad.toml"), count=4096)
    skin.press(pressure, 1e-3)                          # float32 of shape (4096, height, width), Pa; s
    skin["fa1"]                                         # float32 of shape (4096, height, width), the same memory

Names are the C++ headers' names, and a scene has the keys of its TOML file. Maps are row-major: array[y, x]. A call
that is refused raises dermis.InputError, which is a dermis.Error and a ValueError.
"""
from __future__ import annotations

import functools
import importlib
import itertools
import os
import pathlib
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NoReturn, Union

import numpy as np

from ._answers import answered  # before what it answers for is imported
from . import _core, contact
from ._arrays import SPIKE, Response
from ._core import (AfferentModel, Afferents, Candidate, Device, DeviceInfo, Explanation, Figure, Impulse, KelvinVoigt,
                    Relaxation, Report, Result, Trace, afferent_model, chain_of, commit, refuse, relaxation_of)
from ._error import Error, InputError
from ._fitting import Fit, fit, fit_creep, fit_histories, fit_relaxation
from ._shown import extra, members_of, summary_of
from ._tables import Curvature, Grid, Load, Material, Output, Receptors, Sites, Surface, Time
from ._toml import overrides_of, pairs_of, text_of, without_rows
from ._typing import Control, Hold, OfSkin, Precision, ReceptorType

__version__ = _core.version
_GONE = {
    "maps": 'run() with output={"fields": [{"at": 0, "what": ["deformation", "curvature"]}]}',
    "run_materials": 'sweep(tables, {"material": materials}), whose rows have the results',
}


def __getattr__(name: str) -> Any:
    if name == "explain":
        warnings.warn("dermis.explain is dermis.plan", DeprecationWarning, stacklevel=2)
        return plan
    if name not in _GONE:
        raise AttributeError(f"module 'dermis' has no attribute {name!r}")

    def gone(*_: Any, **__: Any) -> NoReturn:
        raise InputError("bad_input", name, f"dermis.{name} has gone; use {_GONE[name]}")

    return gone


__all__ = [
    "AfferentModel", "Afferents", "Candidate", "Curvature", "Device", "DeviceInfo", "Error", "Explanation", "Figure",
    "Fit", "Grid", "Impulse", "InputError", "KelvinVoigt", "Load", "Material", "Output", "Receptors", "Relaxation",
    "Report", "Result", "Scene", "Sites", "Skin", "Surface", "Time", "Trace", "__version__", "afferent_model",
    "chain_of", "commit", "contact", "fingertip", "fit", "fit_creep", "fit_histories", "fit_relaxation",
    "mujoco_plugin", "plan", "plot", "relaxation_of", "run", "sweep",
]


def __dir__() -> list[str]:
    return __all__


class Scene(_core.Scene):
    """A checked scene, from tables by name or from TOML. A scene never changes.

        Scene({"grid": {"width": 80, "height": 64}, "time": {"duration": 1.0}})
        Scene(grid=Grid(width=80, height=64), time=Time(duration=1.0))
        Scene.from_file("pad.toml", {"material.modulus": 1e5})

    In tables an array of float32 or float64 of shape (height, width) may stand in place of the file of a map, and
    sites may be a list of (type, x, y), as in [("sa1", 12, 40)] or [("sa1", "3 mm", "2 mm")], and afferents a list of
    Afferents.
    """

    @answered
    def __init__(self, tables: Mapping[str, Any] | None = None, /, **keys: Any) -> None:
        self._read({**(tables or {}), **keys}, {})

    def _read(self, given: dict[str, Any], overrides: Mapping[str, Any]) -> None:
        fibres = given.get("afferents")
        if isinstance(fibres, (list, tuple)) and any(isinstance(f, Afferents) for f in fibres):
            del given["afferents"]
        else:
            fibres = None  # a text, or tables that a text can have
        super().__init__(*text_of(given), afferents=fibres, overrides=overrides_of(overrides))

    @classmethod
    @answered
    def from_file(cls, path: str | os.PathLike[str], overrides: Mapping[str, Any] | None = None) -> Scene:
        """Read a TOML file. overrides: values by dotted name, as in {"time.step": 0.001}."""
        scene = cls.__new__(cls)
        _core.Scene.__init__(scene, path=os.fsencode(path), overrides=overrides_of(overrides or {}))
        return scene

    @classmethod
    @answered
    def from_string(cls, text: str, overrides: Mapping[str, Any] | None = None,
                    folder: str | os.PathLike[str] = "") -> Scene:
        """Read a text of TOML. Paths in it are relative to the folder, by default the working directory."""
        scene = cls.__new__(cls)
        _core.Scene.__init__(scene, text=text, folder=os.fsencode(folder), overrides=overrides_of(overrides or {}))
        return scene

    def __repr__(self) -> str:
        sites = f", {len(self.sites)} sites" if self.sites else ""
        return f"<Scene {self.width} x {self.height} cells{sites}>"


AnyScene = Union[_core.Scene, Mapping[str, Any], str, "os.PathLike[str]"]
AnyMaterial = Union[Material, Mapping[str, Any]]


def _scene_of(scene: AnyScene, overrides: Mapping[str, Any] | None = None) -> _core.Scene:
    if isinstance(scene, Mapping):
        made = Scene.__new__(Scene)
        made._read(dict(scene), overrides or {})
        return made
    if isinstance(scene, (str, os.PathLike)):
        return Scene.from_file(scene, overrides)
    if isinstance(scene, _core.Scene) and not overrides:
        return scene
    allowed = "tables by name, or the path of a file" if overrides else "a Scene, tables by name, or the path of a file"
    refuse("scene", scene, allowed)


def _scene_with(material: AnyMaterial, name: str) -> Scene:
    """Return a scene of this material. It has metres, because a material is then required."""
    given = pairs_of(material)
    if given is None:
        refuse(name, material, "a Material, or a dict")
    for key in ("thickness", "curvature_length"):
        if key in given:
            refuse(f"{name}.{key}", given[key], "none: it stays that of the skin")
    return Scene(grid=Grid(width=1, height=1, spacing=1), surface=Surface(relief=1),
                 material={**given, "thickness": 1, "curvature_length": 1})


class Skin(_core.Skin):
    """A skin at rest, or many of them, pressed frame by frame. One thread at a time uses it; others wait.

    scene: a Scene, tables by name, or a path; its load, time and output are not used. Responses at its receptors.depth
    differ from the sums over all cells by at most 1e-3 of the greatest signal of the pad, times 1 + |l*C|; if the
    weights of those sums add up to more than 1, as a displacement's may, times what they add up to.
    count: the number of pads that are pressed together, each with a state of its own; arrays then have a first axis of
    pads. A tuple, as (64, 5), makes several axes, by which pads are then named (see press). None: one pad, without
    that axis.
    device: a Device, a text that Device.open takes, or None for the CPU path.
    responses: the responses of each cell, of "sa1", "sa2", "fa1", "fa2", or one of them; None is all. Ignored if the
    scene has sites.
    precision: "f32" or "f32-compensated"; None: compensated if SA2 is a plain integral that is asked for.
    materials: one for each pad in place of the scene's, without thickness and curvature_length, which are the scene's.
    hold: how the pressure runs from one press to the next, "linear" or "parabolic": along the parabola through the last
    three pressures. A parabola is at least four times closer to a smooth load, and worse after a jump.
    control: "pressure", or "depth": each cell is then pressed to a depth in m, and its strain is depth over thickness,
    whatever the material, and 0 where a depth would pull. No cell knows another one's. Takes no materials.
    afferents: a list of Afferents, the nerve fibres of each pad; None: the scene's. With control "depth" they follow
    the strain. A step is then at most 65536 refractory times, or shortest time constants, of each afferent.
    shear: whether presses take tractions along the surface beside pressures, which strain the material in shear. Takes
    neither sites nor materials of maps.
    sa2_stretch: a direction (x, y) along whose stretch of the surface SA2 answers in place of the strain, with the
    scene's sa2_adaptation; (0, 0): to the stretch all round. Needs shear.
    n: the name of count until 1.0.

    copy.copy and pickle make another skin with the same state and time; its responses are 0, and it has no spikes, until
    it is pressed.
    """

    @answered
    def __init__(self, scene: AnyScene, count: int | Sequence[int] | None = None, *, device: Device | str | None = None,
                 responses: ReceptorType | Iterable[ReceptorType] | None = None, precision: Precision | None = None,
                 materials: Iterable[AnyMaterial] = (), hold: Hold = "linear", control: Control = "pressure",
                 afferents: Iterable[Afferents] | None = None, shear: bool = False,
                 sa2_stretch: Sequence[float] | None = None, n: int | Sequence[int] | None = None) -> None:
        if n is not None:
            warnings.warn("Skin(n=..) is called Skin(count=..); n is taken until 1.0", DeprecationWarning, stacklevel=3)
            if count is not None:
                refuse("n", n, "none beside count")
            count = n
        names = [responses] if isinstance(responses, str) else None if responses is None else list(responses)
        super().__init__(_scene_of(scene), count, device, names, precision,
                         [_scene_with(m, f"materials[{i}]") for i, m in enumerate(materials)], hold, control,
                         None if afferents is None else list(afferents), shear, sa2_stretch)

    def __getitem__(self, response: OfSkin) -> Response:
        return super().__getitem__(response).view(Response)

    def spikes(self) -> np.ndarray[Any, np.dtype[np.void]]:
        """Return the spikes of the last call that pressed, as an array of its own of shape (spikes,).

        Fields: pad, of count = (E, P) the number e*P + p, from which np.unravel_index makes (e, p); afferent, its number, from 0 on;
        frame, of press_frames, else 0 (int32); and share (float32), 0 < share <= 1: the afferent fired at this share of
        the step, which is (1 - share)*dt seconds before the step ended; and time (float64), s from the beginning of the
        call, which is (frame + share)*dt. Sorted by frame, by pad in the order pressed, by afferent, by time. Empty
        without afferents and before the first press.
        """
        return np.frombuffer(self._spike_bytes(), SPIKE)

    @property
    def sites(self) -> dict[ReceptorType, np.ndarray[Any, np.dtype[np.int32]]]:
        """The sites of each class in the order of its response: cells as int32 of shape (sites, 2), x and y."""
        sites = self.scene.sites
        kinds = dict.fromkeys(kind for kind, _, _ in sites)
        return {kind: np.array([(x, y) for k, x, y in sites if k == kind], np.int32) for kind in kinds}

    @answered
    def set_material(self, material: AnyMaterial, pads: Any = None) -> None:
        """Give pads another material from the next press on; strains are kept.

        material: numbers, not maps, with the number of elements that the pads have; without thickness and
        curvature_length, which stay. Where the skin was made with materials, a number may be an array of one number
        for each pad. pads: as in press; all of them, unless the skin was made with materials.
        """
        rows: dict[str, np.ndarray[Any, np.dtype[np.float64]]] = {}
        self._take_material(_scene_with(without_rows(material, "material", rows), "material"), rows, pads)


@answered
def run(scene: AnyScene, device: Device | str | None = None, *, precision: Precision | None = None, check: bool = False,
        progress: Callable[[float], object] | None = None) -> Result:
    """Run a scene, and return its traces, fields and responses.

    scene: a Scene, tables by name, or the path of a TOML file. device: a Device, a text that Device.open takes, or
    None for the CPU path. precision: "f32", "f32-compensated" or "f64"; None takes the scene's. check: whether to march
    on the other backend too and compare all bits. progress: called some times a second with the fraction done, 0..1; what
    it raises ends the run. Other Python threads run meanwhile, and Ctrl-C ends the run.
    """
    return _core.run(_scene_of(scene), device, precision, check, progress)


@answered
def sweep(scene: AnyScene, values: Mapping[str, Iterable[Any]], device: str | None = None, *,
          precision: Precision | None = None, check: bool = False,
          map: Callable[..., Iterable[Result]] = map) -> list[dict[str, Any]]:
    """Run a scene with all combinations of some values, and return the rows of the command's runs.csv.

    scene: tables by name, or the path of a TOML file. values: by dotted name, as in {"load.frequency": [20, 50, 250]};
    the last name changes fastest. map: what calls a function for each scene, in order; that of an executor runs scenes
    side by side, as concurrent.futures.ProcessPoolExecutor().map does. device, a text, and the other arguments are as
    in run. Each row is a dict with the columns of runs.csv: the figures of the run, its values, its outcomes, and
    "set", which has all values in one text, with quotes around texts. "result" is its Result.
    """
    for name, some in values.items():
        if isinstance(some, (str, bytes)) or not isinstance(some, Iterable):
            refuse(f"values[{name!r}]", some, "a list of values")
    settings = [dict(zip(values, chosen)) for chosen in itertools.product(*values.values())]
    scenes = [_scene_of(scene, setting or None) for setting in settings]
    results = map(functools.partial(run, device=device, precision=precision, check=check), scenes)
    columns = ("model", "precision", "seconds", "predicted_error", "measured_error", "greatest_gain", "kinks",
               "cells_compared", "cells_different")
    return [{"run": i, **{name: getattr(result, name) for name in columns},
             **{key: value for key, value in setting.items() if key not in columns}, **result.outcomes,
             "set": " ".join(overrides_of(setting)), "result": result}
            for i, (setting, result) in enumerate(zip(settings, results, strict=True), 1)]


@answered
def plot(what: Result | Sequence[Mapping[str, Any]] | str | os.PathLike[str],
         folder: str | os.PathLike[str] | None = None) -> dict[str, Any]:
    """Draw a run or a sweep, and return figures of matplotlib by name, as the command `dermis plot` does.

    what: a Result, the rows of sweep(), or the --out of the command. folder: where each figure goes as PNG and SVG,
    and report.html with all of them; None: nowhere. The figures are "traces", "maps", "surface" (where a field is the
    deformation), "receptors", "spikes" and, of a pattern that slides over afferents, "events", where the run has what they
    show, and of rows "sweep".
    """
    drawing = extra("plot")
    given: Any = what
    if isinstance(what, Result):
        source = drawing.run_of(what)
    elif isinstance(what, (str, os.PathLike)):
        try:
            source = drawing.read(pathlib.Path(what), _core.unit_of_key)
        except (OSError, ValueError) as unreadable:
            raise Error("io", "what", f"what = {unreadable}") from None
    elif not (isinstance(given, Sequence) and given and
              all(isinstance(row, Mapping) and "result" in row for row in given)):
        refuse("what", what, "a Result, the rows of sweep(), or a folder of the command")
    else:
        rows = [{name: str(value) for name, value in row.items() if name != "result"} for row in what]
        source = drawing.sweep_of(rows, _core.unit_of_key, what[0]["result"].scene.spacing)
    figures: dict[str, Any] = drawing.figures_of(source)
    if folder is not None:
        pathlib.Path(folder).mkdir(parents=True, exist_ok=True)
        drawing.write(pathlib.Path(folder), source, figures)
    return figures


@answered
def plan(scene: AnyScene, device: Device | str | None = None, *, precision: Precision | None = None) -> Explanation:
    """Say how run() would compute a scene, like a database's EXPLAIN. Nothing is run."""
    return _core.plan(_scene_of(scene), device, precision)


@answered
def fingertip(**keys: Any) -> Scene:
    """Return a scene of the preset: 1 cm2 of a ridged fingertip in metres. keys: tables, as in Scene."""
    return Scene(preset="fingertip", **keys)


for _kind in (AfferentModel, Afferents, Candidate, Explanation, Impulse, KelvinVoigt, Relaxation, Report, Trace,
              contact.Contact, contact.Pose, contact.ContactReport, contact.WorldContact):
    setattr(_kind, "__repr__", members_of)
setattr(Result, "__repr__", summary_of)
setattr(_core.Scene, "__repr__", Scene.__repr__)


def mujoco_plugin() -> str:
    """Return the path of the plugin "dermis.skin", for mujoco.mj_loadPluginLibrary: skin on the sites of a model.

    It is the one that was built for the installed version of MuJoCo, because no other one can be loaded.
    """
    plugins = {path.stem.partition("-")[2]: path for path in pathlib.Path(__file__).parent.glob("dermis_mujoco-*.so")}
    version = importlib.import_module("mujoco").mj_versionString()
    if version not in plugins:
        built = ", ".join(sorted(plugins)) or "none"
        refuse("mujoco", version, f"{built}: the versions for which this package has a plugin; install one of them, or "
               "build dermis with DERMIS_MUJOCO, the folder of the installed one")
    return str(plugins[version])
