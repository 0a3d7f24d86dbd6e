# SPDX-License-Identifier: MIT
"""Pressure on skin in, mechanoreceptor responses out.

    import dermis
    result = dermis.run({"surface": {"kind": "spiral"}})
    result["fa1"].mean                                  # over all cells, float64 of shape (times,)

    skin = dermis.Skin(dermis.Scene.from_file("pad.toml"), n=4096)
    skin.press(pressure, 1e-3)                          # float32 of shape (4096, height, width), Pa; s
    skin["fa1"]                                         # float32 of shape (4096, height, width), the same memory

Names are the C++ headers' names, and a scene has the keys of its TOML file. Maps are row-major: array[y, x]. A call
that is refused raises dermis.Error.
"""
from __future__ import annotations

import operator
import os
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Union

import numpy as np

from . import _core, contact
from ._core import (Candidate, Device, DeviceInfo, Explanation, Figure, Fit, Impulse, KelvinVoigt, Relaxation, Report,
                    Result, Trace, chain_of, commit, fit_creep, fit_relaxation, relaxation_of)
from ._error import Error
from ._tables import Curvature, Grid, Load, Material, Output, Receptors, Sites, Surface, Time
from ._toml import overrides_of, refuse, text_of

__version__ = _core.version

__all__ = [
    "Candidate", "Curvature", "Device", "DeviceInfo", "Error", "Explanation", "Figure", "Fit", "Grid", "Impulse",
    "KelvinVoigt", "Load", "Material", "Output", "Receptors", "Relaxation", "Report", "Result", "Scene", "Sites",
    "Skin", "Surface", "Time", "Trace", "__version__", "chain_of", "commit", "contact", "explain", "fingertip",
    "fit_creep", "fit_relaxation", "maps", "relaxation_of", "run", "run_materials",
]


class Scene(_core.Scene):
    """A checked scene, from tables by name or from TOML. A scene never changes.

        Scene({"grid": {"width": 80, "height": 64}, "time": {"duration": 1.0}})
        Scene(grid=Grid(width=80, height=64), time=Time(duration=1.0))
        Scene.from_file("pad.toml", {"material.modulus": 1e5})

    In tables an array of float32 or float64 of shape (height, width) may stand in place of the file of a map, and
    sites may be a list of (type, x, y), as in [("sa1", 12, 40)].
    """

    def __init__(self, tables: Mapping[str, Any] | None = None, /, **keys: Any) -> None:
        given = {**(tables or {}), **keys}
        sites = given.get("sites")
        listed = None
        if isinstance(sites, (list, tuple)):
            try:
                listed = [(kind, operator.index(x), operator.index(y)) for kind, x, y in sites]
            except (TypeError, ValueError):
                raise refuse("sites", repr(sites)[:60], "a list of (type, x, y), as in [(\"sa1\", 12, 40)]") from None
            del given["sites"]
        super().__init__(*text_of(given), sites=listed)

    @classmethod
    def from_file(cls, path: str | os.PathLike[str], overrides: Mapping[str, Any] | None = None) -> Scene:
        """Read a TOML file. overrides: values by dotted name, as in {"time.step": 0.001}."""
        scene = cls.__new__(cls)
        _core.Scene.__init__(scene, path=os.fsencode(path), overrides=overrides_of(overrides or {}))
        return scene

    @classmethod
    def from_string(cls, text: str, overrides: Mapping[str, Any] | None = None,
                    folder: str | os.PathLike[str] = "") -> Scene:
        """Read a text of TOML. Paths in it are relative to the folder, by default the working directory."""
        scene = cls.__new__(cls)
        _core.Scene.__init__(scene, text=text, folder=os.fsencode(folder), overrides=overrides_of(overrides or {}))
        return scene


AnyScene = Union[_core.Scene, Mapping[str, Any], str, "os.PathLike[str]"]
AnyMaterial = Union[Material, Mapping[str, Any]]


def _scene_of(scene: AnyScene) -> _core.Scene:
    if isinstance(scene, _core.Scene):
        return scene
    if isinstance(scene, Mapping):
        return Scene(scene)
    if isinstance(scene, (str, os.PathLike)):
        return Scene.from_file(scene)
    raise refuse("scene", f"an object of type {type(scene).__name__}", "a Scene, tables by name, or the path of a file")


def _scene_with(material: AnyMaterial, name: str) -> Scene:
    """Return a scene of this material. It has metres, because a material is then required."""
    given = dict(material) if isinstance(material, Mapping) else dict(vars(material))
    for key in ("thickness", "curvature_length"):
        if given.get(key) is not None:
            raise refuse(f"{name}.{key}", given[key], "none: it stays that of the skin")
        given[key] = 1
    return Scene(grid=Grid(width=1, height=1, spacing=1), surface=Surface(relief=1), material=given)


class Skin(_core.Skin):
    """A skin at rest, or n of them, pressed frame by frame. One thread at a time uses it; others wait.

    scene: a Scene, tables by name, or a path; its load, time and output are not used.
    n: the number of pads that are pressed together, each with a state of its own; arrays then have a first axis of
    pads. None: one pad, without that axis.
    device: a Device, a text that Device.open takes, or None for the CPU path.
    responses: the responses of each cell, of "sa1", "sa2", "fa1", "fa2"; None is all. Ignored if the scene has sites.
    precision: "f32" or "f32-compensated"; None: compensated if SA2 is a plain integral that is asked for.
    materials: one for each pad in place of the scene's, without thickness and curvature_length, which are the scene's.
    """

    def __init__(self, scene: AnyScene, n: int | None = None, *, device: Device | str | None = None,
                 responses: Iterable[str] | None = None, precision: str | None = None,
                 materials: Iterable[AnyMaterial] = ()) -> None:
        made = _scene_of(scene)
        super().__init__(made, n, device, None if responses is None else list(responses), precision,
                         [_scene_with(m, f"materials[{i}]") for i, m in enumerate(materials)])
        self._sites = made.sites

    @property
    def sites(self) -> dict[str, np.ndarray[Any, np.dtype[np.int32]]]:
        """The receptors of each class in the order of its response: cells as int32 of shape (sites, 2), x and y."""
        kinds = dict.fromkeys(kind for kind, _, _ in self._sites)
        return {kind: np.array([(x, y) for k, x, y in self._sites if k == kind], np.int32) for kind in kinds}

    def set_material(self, material: AnyMaterial, pads: Any = None) -> None:
        """Give pads another material from the next press on; strains are kept.

        material: numbers, not maps, with the number of elements that the pads have; without thickness and
        curvature_length, which stay. pads: as in press; all of them, unless the skin was made with materials.
        """
        self.take_material(_scene_with(material, "material"), pads)


def run(scene: AnyScene, device: Device | str | None = None, *, precision: str | None = None, check: bool = False,
        progress: Callable[[float], object] | None = None) -> Result:
    """Run a scene, and return its traces, fields and responses.

    scene: a Scene, tables by name, or the path of a TOML file. device: a Device, a text that Device.open takes, or
    None for the CPU path. precision: "f32", "f32-compensated" or "f64"; None takes the scene's. check: whether to march
    on the other backend too and compare all bits. progress: called some times a second with the fraction done, 0..1; what
    it raises ends the run. Other Python threads run meanwhile, and Ctrl-C ends the run.
    """
    return _core.run(_scene_of(scene), device, precision, check, progress)


def run_materials(scene: AnyScene, materials: Iterable[AnyMaterial], device: Device | str | None = None, *,
                  precision: str | None = None, check: bool = False, describe_each: bool = False) -> list[Result]:
    """Run a scene with each of these materials in place of its own, and return a result of each.

    materials: without thickness and curvature_length, which stay the scene's. All models except march read the maps
    once. describe_each: whether greatest_curvature and other figures of the whole skin are each run's own, at the cost
    of a pass over all cells; otherwise all have the first run's. The other arguments are as in run.
    """
    scenes = [_scene_with(m, f"materials[{i}]") for i, m in enumerate(materials)]
    return _core.run_materials(_scene_of(scene), scenes, device, precision, check, describe_each)


def explain(scene: AnyScene, device: Device | str | None = None, *, precision: str | None = None) -> Explanation:
    """Say how run() would compute a scene, like a database's EXPLAIN. Nothing is run."""
    return _core.explain(_scene_of(scene), device, precision)


def maps(scene: AnyScene) -> dict[str, np.ndarray[Any, np.dtype[np.float64]]]:
    """Return the maps that a scene is made of, float64 of shape (height, width).

    "surface" (m with a spacing), "rest_curvature" (1/m) and "pressure" (Pa, where the envelope is 1).
    """
    return _core.maps(_scene_of(scene))


def fingertip(**keys: Any) -> Scene:
    """Return a scene of the preset: 1 cm2 of a ridged fingertip in metres. keys: tables, as in Scene."""
    return Scene(preset="fingertip", **keys)
