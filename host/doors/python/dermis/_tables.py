# SPDX-License-Identifier: MIT
"""The tables of a scene as keyword objects. host/lab/scenes/README.md has keys, units and ranges.

None: the key is not given. Where a key names a file, an array of float32 or float64 may stand in its place.
"""
from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Union

import numpy as np

from ._core import KelvinVoigt, Relaxation

Array = np.ndarray[Any, np.dtype[Any]]
MapOrFile = Union[Array, str, "os.PathLike[str]"]
NumberOrMap = Union[float, MapOrFile]
NumberWithUnit = Union[float, str]  # a number, or a text with its unit, as "5 ms"
Numbers = Union[Sequence[float], Array]
CellOrPlace = Union[int, str]  # a cell, or a length with its unit, as "3 mm", where the grid has a spacing
Cells = Union[Sequence[Sequence[CellOrPlace]], Array]


@dataclass(kw_only=True)
class Grid:
    """width, height: cells. spacing: m between cells; without it a scene is dimensionless."""

    width: int | None = None
    height: int | None = None
    spacing: NumberWithUnit | None = None


@dataclass(kw_only=True)
class Surface:
    """The ridges. path: heights of shape (height, width), with kind "file". relief, ridge_period: m.

    high: which grey of a picture is high, "white" or "black"; required with a PNG. noise_length: cells. spacing: m between the numbers of path, which then has a shape of its own.
    """

    kind: str | None = None
    path: MapOrFile | None = None
    high: str | None = None
    spacing: NumberWithUnit | None = None
    ridges: float | None = None
    ridge_period: NumberWithUnit | None = None
    noise: float | None = None
    noise_length: float | None = None
    relief: NumberWithUnit | None = None


@dataclass(kw_only=True)
class Material:
    """modulus: Pa; viscosity: Pa s; numbers, or maps of shape (height, width). thickness, curvature_length: m.

    In place of modulus and viscosity: elements in series, with a spring (Pa) and a dashpot (Pa s), or a relaxation.
    """

    modulus: NumberOrMap | None = None
    viscosity: NumberOrMap | None = None
    elements: Sequence[KelvinVoigt | Mapping[str, Any]] | None = None
    spring: NumberWithUnit | None = None
    dashpot: NumberWithUnit | None = None
    relaxation: Relaxation | Mapping[str, Any] | None = None
    thickness: NumberWithUnit | None = None
    curvature_length: NumberWithUnit | None = None


@dataclass(kw_only=True)
class Load:
    """The pressure: a map, times intensity in Pa, times an envelope over time in s.

    path: pressures of shape (height, width), with kind "file"; or the .npy file of a "sequence". center: [x, y].
    control: "pressure", or "depth": intensity and maps are then in m. radius_y: cells, of an elliptic punch. ball_radius: m.
    texture: what slides over the skin, as in {"path": "texture.npy", "spacing": 5e-5, "velocity": [0.04, 0]}.
    high: which grey of a picture is 1, "white" or "black"; required with a PNG.
    taxels: what the numbers of a "sequence" mean and belong to in place of cells, as in {"spacing": "4 mm", "unit": "kPa",
    "offset": "first", "sampling_rate": "100 Hz"}; path is then a .npy file of shape (frames, rows, columns), or with rows
    and columns a CSV file.
    window: what multiplies a step or a sine, as in {"start": 0, "rise": "10 ms", "until": 1, "fall": "10 ms"}.
    grating: waves that move, as in {"wavelength": "1 mm", "velocity": "40 mm/s", "amplitudes": [0.5]}.
    contact: "even", or "crests" of the surface alone: a share of its cells, contact_length m from crest to crest.
    """

    kind: str | None = None
    path: MapOrFile | None = None
    high: str | None = None
    center: Sequence[CellOrPlace] | None = None
    radius: CellOrPlace | None = None
    radius_y: CellOrPlace | None = None
    ball_radius: NumberWithUnit | None = None
    intensity: NumberWithUnit | None = None
    interval: NumberWithUnit | None = None
    hold: str | None = None
    texture: Mapping[str, Any] | None = None
    taxels: Mapping[str, Any] | None = None
    control: str | None = None
    window: Mapping[str, Any] | None = None
    grating: Mapping[str, Any] | None = None
    contact: str | None = None
    contact_share: float | None = None
    contact_length: NumberWithUnit | None = None
    envelope: str | None = None
    start: NumberWithUnit | None = None
    rise: NumberWithUnit | None = None
    frequency: NumberWithUnit | None = None
    phase: NumberWithUnit | None = None
    mean: float | None = None
    amplitude: float | None = None
    length: NumberWithUnit | None = None
    period: NumberWithUnit | None = None
    times: Numbers | None = None
    values: Numbers | None = None


@dataclass(kw_only=True)
class Time:
    """step, duration: s. Outputs are at 0, step, 2 step .. before the duration."""

    step: NumberWithUnit | None = None
    duration: NumberWithUnit | None = None


@dataclass(kw_only=True)
class Curvature:
    """stencil: "five-point", "fourth-order", "published". edges: "mirror", "periodic", "published"."""

    stencil: str | None = None
    edges: str | None = None


@dataclass(kw_only=True)
class Receptors:
    """sa2_adaptation: s. fa2: "point", "step-mean". fa2_gains: two numbers.

    depth: m below the surface, by class, as in {"sa1": "0.3 mm"}. kernel: "stress", or "strain" with a ratio of poisson.
    follow: what sa1 and sa2 answer to, "strain" or "stress", as in {"sa1": "stress"}.
    """

    sa2_adaptation: NumberWithUnit | None = None
    fa2: str | None = None
    fa2_gains: Numbers | None = None
    depth: Mapping[str, NumberWithUnit] | None = None
    follow: Mapping[str, str] | None = None
    kernel: str | None = None
    poisson: float | None = None


@dataclass(kw_only=True)
class Sites:
    """Receptors in single cells: a file that lists them, or densities per cm2, as in density={"sa1": 70}."""

    path: str | os.PathLike[str] | None = None
    density: Mapping[str, float] | None = None
    seed: int | None = None


@dataclass(kw_only=True)
class Output:
    """traces: quantities. probes: cells [x, y]. fields: as in [{"at": 0.5, "what": ["sa1"]}], at in s."""

    traces: Sequence[str] | None = None
    extremes: bool | None = None
    probes: Cells | None = None
    fields: Sequence[Mapping[str, Any]] | None = None
