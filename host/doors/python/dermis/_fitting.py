# SPDX-License-Identifier: MIT
"""Chains of elements fitted to measured curves."""
from __future__ import annotations

import dataclasses
import operator
import os
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._answers import answered
from ._core import KelvinVoigt, refuse
from ._error import InputError
from ._shown import extra, text_of
from ._typing import Kind, Residual


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Fit:
    """A chain of elements that was fitted to measured curves.

    elements: a spring, elements by ascending retardation time, a dashpot; spring and dashpot if the data need them.
    errors: of the logarithm of each number of the elements; 0 if the number is 0. In about 95 of 100 data sets the true
    number is within a factor of exp(2*error), which Student's quantile widens if there are few points.
    residual: root mean square of the residual; 0.01 is 1 %. Data are taken to be exact to 1e-7 at best.
    model: the curve at the times of the data, in their order and unit, float64 of shape (times,); of histories the
    stress, of one history after another.
    choice: why there are so many elements, in a sentence; empty if n was given.
    undetermined: sentences about what the data leave open: elements that they cannot tell apart or do not need, numbers
    that they fix to a factor of 2 or worse, a curve that runs the wrong way, relaxation that a ramp hides.
    fastest: s; of histories relaxation faster than this hides behind the strain's course, and the spring with its error
    holds if there is none; else 0.
    """

    elements: list[KelvinVoigt]
    errors: list[KelvinVoigt]
    residual: float
    model: NDArray[np.float64]
    choice: str
    undetermined: list[str]
    fastest: float

    def __repr__(self) -> str:
        names = (field.name for field in dataclasses.fields(self))
        return f"Fit({', '.join(f'{name}={text_of(getattr(self, name))}' for name in names)})"


def _numbers(given: object) -> NDArray[np.float64]:
    """Return one row of numbers. Throws TypeError, which `answered` explains."""
    try:
        row = np.array(given, np.float64)
    except ValueError as wrong:
        raise TypeError(*wrong.args) from None
    if row.ndim != 1 or isinstance(given, np.ma.MaskedArray):
        raise TypeError("no row of numbers")
    return row


def _fitted(kind: str, curves: Sequence[Sequence[Any]], n: int | None, residual: str) -> Fit:
    """Fit curves: times, strains and values of each."""
    fitting = extra("fit")
    arrays = [tuple(map(_numbers, curve)) for curve in curves]
    try:
        found = fitting.fit_curves(kind, arrays, None if n is None else operator.index(n), residual)
    except fitting.Refused as refused:
        raise InputError("bad_input", refused.name, str(refused)) from None
    chain, errors = ([KelvinVoigt(modulus=m, viscosity=v) for m, v in rows] for rows in (found.elements, found.errors))
    return Fit(chain, errors, found.residual, found.model, found.choice, found.undetermined, found.fastest)


@answered
def fit(data: str | os.PathLike[str] | Sequence[str | os.PathLike[str]], n: int | None = None, *,
        kind: Kind | None = None, stress: float | None = None, strain: float | None = None,
        residual: Residual | None = None) -> Fit:
    """Fit a chain of at most n elements, 1..8, to measured curves, as the command `dermis fit` does. Needs SciPy.

    data: a CSV file, or a list of files with curves of one kind, each with a line of names: time,modulus or, with
    strain, time,stress (relaxation); time,compliance or, with stress, time,strain (creep); time,strain,stress (a
    history). n: None: as few as describe the data. kind: "creep" or "relaxation", if the second column has another
    name. stress: Pa, > 0; strain: > 0; by which the second column is divided. residual: "relative" to each value or
    "absolute"; None: relative, of histories absolute.
    """
    paths = [data] if isinstance(data, (str, os.PathLike)) else list(data)
    read_kind, by, curves = _core.read_curves([os.fsdecode(path) for path in paths], kind or "", residual or "", stress,
                                              strain)
    return _fitted(read_kind, curves, n, by)


@answered
def fit_creep(times: Sequence[float] | NDArray[np.float64], compliances: Sequence[float] | NDArray[np.float64],
              n: int | None = None, residual: Residual = "relative") -> Fit:
    """Fit a chain of at most n elements, 1..8, to measured creep; None: as few as describe the data. Needs SciPy.

    times: s, >= 0; compliances: 1/Pa; at least 2*n + 1 of each. residual: "relative" or "absolute". The search covers
    retardation times from a tenth of the shortest time to ten times the longest.
    """
    return _fitted("creep", [(times, np.zeros(len(times)), compliances)], n, residual)


@answered
def fit_relaxation(times: Sequence[float] | NDArray[np.float64], moduli: Sequence[float] | NDArray[np.float64],
                   n: int | None = None, residual: Residual = "relative") -> Fit:
    """Fit a chain of at most n elements, 1..8, to a measured relaxation; None: as few as describe the data.

    times: s, >= 0; moduli: Pa; at least 2*n + 1 of each. residual: "relative" or "absolute". The search covers
    relaxation times from a tenth of the shortest time to ten times the longest. Needs SciPy.
    """
    return _fitted("relaxation", [(times, np.zeros(len(times)), moduli)], n, residual)


@answered
def fit_histories(histories: Sequence[tuple[Any, Any, Any]], n: int | None = None, residual: Residual = "absolute") -> Fit:
    """Fit a chain of at most n elements, 1..8, to the stress under strains of any course. Needs SciPy.

    histories: a list of (times, strains, stresses), s, ascending, and Pa, equally many, at most 20,000 in all; the
    strain is 0 before the first time, and runs along lines; two equal times are a step of it. n: None: as few as
    describe the data. residual: "relative" or "absolute". The search covers relaxation times from a tenth of the
    shortest step in time to ten times the longest history.
    """
    all_ = list(histories)
    for i, history in enumerate(all_):
        if not hasattr(history, "__len__") or len(history) != 3:
            refuse(f"histories[{i}]", history, "(times, strains, stresses)")
    return _fitted("history", all_, n, residual)
