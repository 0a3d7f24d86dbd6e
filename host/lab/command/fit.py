# SPDX-License-Identifier: MIT
# mypy: disable-error-code="import-untyped, import-not-found"
"""Chains of Kelvin-Voigt elements from measured curves.

The command runs this file with a request as JSON on standard input. The Python package has it as dermis._fit. It needs
NumPy and SciPy.

A curve is constant + ramp*t + sum of amplitude*(1 - e^(-t/time)) in creep, and constant + sum of amplitude*e^(-t/time)
in relaxation. A history is the stress under a strain of any course: the hereditary integral of a relaxation. Amplitudes
are >= 0 and follow from the times by nonnegative least squares. Times are sought on a grid, then by variable projection
(in Kaufman's form). An element of a chain is a pair: modulus in Pa and viscosity in Pa s.
"""
from __future__ import annotations

import itertools
import json
import math
import os
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import least_squares, nnls
from scipy.special import stdtrit

Array = np.ndarray[Any, Any]
Curve = tuple[Array, ...]  # times in s, strains (0 unless it is a history), values in Pa or 1/Pa
MOST_ELEMENTS = 8
MOST_POINTS = 1000  # of a curve; beyond, points that stand together become one
MOST_IN_HISTORIES = 20000
EXACT = 1e-7  # relative residuals below this count as rounding of the data
SAME_TIME = 1e-3  # exponentials of times closer than this, in their logarithm, differ by less than EXACT
STIFFER = 0.05  # a hidden branch is told of if it raises the spring by more than its interval and this share
HARDLY = 1.05  # an element that lowers the residual by no more than this factor is not worth it


class Refused(Exception):
    """A number that cannot be fitted. name: of the parameter."""

    def __init__(self, name: str, value: object, allowed: str) -> None:
        super().__init__(f"{name} = {value}; allowed: {allowed}")
        self.name = name


@dataclass
class Fit:
    """What is found. The members are those of dermis.Fit."""
    elements: Array  # of shape (elements, 2)
    errors: Array
    residual: float
    model: Array
    choice: str
    undetermined: list[str]
    fastest: float


@dataclass
class Data:
    """A measured curve, or histories one after another. A residual is weight*(model - value)."""
    kind: str  # "creep", "relaxation" or "history"
    times: Array
    values: Array
    weights: Array
    strains: Array  # 1 unless it is a history
    first: Array  # whether a point begins a curve
    points: int  # measured; several may stand here as one
    scatter: float = 0.0  # sum of the squared residuals of measured points around the point that replaces them

    def steps(self) -> Array:
        """Return the times since the point before; 0 where a curve begins."""
        steps: Array = np.where(self.first, 0, np.diff(self.times, prepend=self.times[:1]))
        return steps

    def limits(self) -> tuple[float, float]:
        """Return the logarithms of the times that are sought: a tenth of the shortest to ten times the longest."""
        least, most = self.times, self.times.max()
        if self.kind == "history":
            least = self.steps()
            most = max(np.ptp(own) for own in np.split(self.times, np.flatnonzero(self.first)[1:]))
        return math.log(least[least > 0].min() / 10), math.log(most * 10)

    def terms(self, constant: bool, ramp: bool, log_times: Array) -> tuple[Array, Array]:
        """Return a column of each term, and of each exponential the derivative by the logarithm of its time."""
        fixed = [self.strains] * constant + [self.times] * ramp
        if self.kind == "history":
            terms, slopes = self._hereditary(np.exp(-log_times))
        else:
            z = np.multiply.outer(self.times, np.exp(-log_times))
            left = np.exp(-z)
            terms, slopes = (-np.expm1(-z), -z * left) if self.kind == "creep" else (left, z * left)
        return np.column_stack([*fixed, terms]), slopes

    def _hereditary(self, rates: Array) -> tuple[Array, Array]:
        """Return the stress of springs of modulus 1 that relax at these rates; the strain runs along lines."""
        z = np.multiply.outer(self.steps(), rates)
        changes = np.where(self.first, self.strains, np.diff(self.strains, prepend=0))[:, None]
        left = np.exp(-z)
        mean = np.divide(-np.expm1(-z), z, out=np.ones_like(z), where=z > 0)  # of e^(-x) for x from 0 to z
        slope = np.where(z > 1e-8, mean - left, z / 2)
        left[self.first] = 0
        terms = _carried(left, changes * mean)
        return terms, _carried(left, left * z * np.roll(terms, 1, axis=0) + changes * slope)


def _carried(left: Array, gains: Array) -> Array:
    """Return y of y[i] = left[i]*y[i - 1] + gains[i], by doubling: after each pass y holds twice as many gains."""
    y, left, reach = gains.copy(), left.copy(), 1
    while reach < len(y) and left.any():
        y[reach:] += left[reach:] * y[:-reach]
        left[reach:] *= left[:-reach]
        reach *= 2
    return y


def _condensed(data: Data) -> Data:
    """Return a curve of fewer points: points at times that agree to 0.1 % become one, with the weight of all."""
    if data.points <= MOST_POINTS or data.kind == "history":
        return data
    logs = np.log(np.maximum(data.times, 1e-300))
    _, first, own = np.unique(np.floor(logs / 1e-3), return_index=True, return_inverse=True)
    def summed(x: Array) -> Array:
        sums: Array = np.bincount(own, data.weights**2 * x)
        return sums
    weight = summed(np.ones_like(logs))
    time, value = (x[first] + summed(x - x[first][own]) / weight for x in (logs, data.values))
    t, v = logs - time[own], data.values - value[own]
    along = np.divide(summed(t * v)**2, summed(t * t), out=np.zeros_like(weight), where=summed(t * t) > 0)
    # Around a line in the logarithm of the time, which hides the scatter of one point of each two or more.
    scatter, together = float(np.maximum(summed(v * v) - along, 0).sum()), np.bincount(own)
    scatter *= (together - 1).sum() / max(np.maximum(together - 2, 0).sum(), 1)
    times = np.where(data.times[first] > 0, np.exp(time), 0)
    return Data(data.kind, times, value, np.sqrt(weight), np.ones_like(time), data.first[first], data.points, scatter)


@dataclass(eq=False)
class Spectrum:
    constant: bool
    ramp: bool
    log_times: Array  # ascending
    amplitudes: Array  # of constant and ramp, if they are there, then of the times
    squares: float  # sum of the squared residuals

    @property
    def fixed(self) -> int:
        return self.constant + self.ramp

    @property
    def parameters(self) -> int:
        return len(self.amplitudes) + len(self.log_times)


def _triangle_of(columns: Array) -> Array:
    triangle: Any = np.linalg.qr(columns, mode="r")
    return np.asarray(triangle)


def _nonnegative(triangle: Array) -> tuple[Array, float]:
    """Return the amplitudes x >= 0 of the least squares, whose last column is the values, and the sum of squares."""
    columns, target = triangle[:, :-1], triangle[:, -1]
    if not columns.size:
        return np.zeros(columns.shape[1]), float(target @ target)
    scale = np.linalg.norm(columns, axis=0)
    scale[scale == 0] = 1
    x, rest = nnls(columns / scale, target, maxiter=100 * columns.shape[1])
    return x / scale, float(rest)**2


def _refined(data: Data, constant: bool, ramp: bool, log_times: Array, tolerance: float = 1e-8) -> Spectrum:
    """Move times from where they are to the nearest least squares."""
    least, most = data.limits()
    middle, half = (least + most) / 2, (most - least) / 2
    weights, target, fixed = data.weights[:, None], data.weights * data.values, constant + ramp
    last: dict[bytes, tuple[Array, Array, Array, float]] = {}

    def at(places: Array) -> tuple[Array, Array, Array, float]:
        key = places.tobytes()
        if key not in last:
            columns, slopes = (weights * part for part in data.terms(constant, ramp, middle + half * np.sin(places)))
            x, squares = _nonnegative(_triangle_of(np.column_stack([columns, target])))
            last.clear()
            last[key] = columns, slopes * x[fixed:] * half * np.cos(places), x, squares
        return last[key]

    def residual(places: Array) -> Any:
        columns, _, x, _ = at(places)
        return columns @ x - target

    def jacobian(places: Array) -> Any:
        columns, slopes, x, _ = at(places)
        basis = np.linalg.qr(columns[:, x > 0])[0]
        return slopes - basis @ (basis.T @ slopes)

    # A time is a sine of the number that is sought, so that it stays within the limits.
    places = np.arcsin(np.clip((log_times - middle) / half, -0.999, 0.999))
    if 0 < len(places) <= len(target):
        places = least_squares(residual, places, jacobian, method="lm", xtol=tolerance, ftol=tolerance, gtol=1e-15,
                               max_nfev=100).x
    places = places[np.argsort(np.sin(places))]
    _, _, x, squares = at(places)
    return Spectrum(constant, ramp, middle + half * np.sin(places), x, squares + data.scatter)


def _simplified(data: Data, s: Spectrum) -> Spectrum:
    """Remove terms that add nothing, and all but one of times that have met; then the others move again."""
    while True:
        columns = data.weights[:, None] * data.terms(False, False, s.log_times)[0]
        seen = s.amplitudes[s.fixed:] * np.abs(columns).max(axis=0, initial=0) > EXACT
        kept: list[float] = []
        for time in s.log_times[seen]:
            if not kept or time - kept[-1] >= SAME_TIME:
                kept.append(time)
        constant, ramp = s.constant and s.amplitudes[0] > 0, s.ramp and s.amplitudes[s.fixed - 1] > 0
        if (len(kept), constant, ramp) == (len(s.log_times), s.constant, s.ramp):
            return s
        s = _refined(data, bool(constant), bool(ramp), np.array(kept))


def _starts_of(data: Data) -> Callable[[list[int], int], list[Array]]:
    """Return what chooses times to begin at, by a triangle of all terms on a grid: a problem as small as the grid."""
    least, most = data.limits()
    grid = np.linspace(least, most, int(np.clip(math.ceil((most - least) / math.log(10) * 10), 1, 200)) + 1)
    columns = np.column_stack([data.terms(True, True, grid)[0], data.values])
    triangle, end = _triangle_of(data.weights[:, None] * columns), len(grid) + 2

    def left(chosen: list[int]) -> float:
        return _nonnegative(triangle[:, [*chosen, -1]])[1]

    def starts(fixed: list[int], count: int) -> list[Array]:
        """Choose times one by one, each where it helps most; after each all move while that helps."""
        chosen, found = fixed, [np.empty(0)]
        for _ in range(count):
            best, new = min((left([*chosen, c]), c) for c in range(2, end))
            chosen, moved = [*chosen, new], True
            while moved:
                moved = False
                for place, step in itertools.product(range(len(fixed), len(chosen)), (-1, 1)):
                    trial = chosen.copy()
                    trial[place] += step
                    if 2 <= trial[place] < end and (squares := left(trial)) < best:
                        chosen, best, moved = trial, squares, True
            found.append(grid[np.sort(chosen[len(fixed):]) - 2])
        return found
    return starts


def _is_exact(data: Data, s: Spectrum) -> bool:
    return s.squares <= EXACT**2 * data.points


def _information(data: Data, s: Spectrum, parameters: int) -> float:
    """Weigh a residual against the number of parameters (Bayesian information criterion); less is better."""
    return data.points * math.log(max(s.squares / data.points, EXACT**2)) + parameters * math.log(data.points)


def _best_spectra(data: Data, most: int) -> list[Spectrum]:
    """Return the best spectra of chains of at most 1, 2 .. elements: none leaves more than one before it."""
    starts, spectra = _starts_of(data), list[Spectrum]()
    # In creep a spring and a dashpot are elements by themselves; in relaxation every spectrum has a spring.
    creep = data.kind == "creep"
    taken = {(c, r): c + r if creep else 1 for c in (True, False) for r in ((False, True) if creep else (False,))}
    firsts = {(c, r): starts([0] * c + [1] * r, most - taken[c, r]) for c, r in taken}
    for n in range(1, most + 1):
        found = []
        for c, r in taken:
            times = n - taken[c, r]
            if times < 0 or times + c + r == 0:
                continue
            s = _simplified(data, _refined(data, c, r, firsts[c, r][times]))
            # Every shape is scored by all terms that it offers: noise must not make one look better that uses fewer.
            found.append((_information(data, s, s.parameters if _is_exact(data, s) else 2 * times + c + r), s))
        best = min(found, key=lambda pair: pair[0])[1]
        if spectra and (best.squares > spectra[-1].squares or _is_exact(data, spectra[-1])):
            best = spectra[-1]
        spectra.append(best)
    return spectra


def _roots(poles: Array, weights: Array, level: float) -> tuple[Array, Array]:
    """Return the roots x of sum weights/(x - poles) = level, and sum weights/(x - poles)^2 there.

    There is one in each gap of the ascending poles, and one beyond the last if level > 0. The first pole may be 0.
    """
    ends = poles.copy()
    if len(poles) and poles[0] == 0 and (len(poles) > 1 or level > 0):  # of the first gap, of which no root is below this
        ends[0] = weights[0] / level if len(poles) == 1 else min(
            poles[1] / 2, weights[0] / (level + 2 * weights[1:].sum() / poles[1]))
    beyond = [poles[-1] + weights.sum() / level] if level > 0 and len(poles) else []
    low, high = np.log(ends[:len(poles) - 1 + len(beyond)]), np.log([*poles[1:], *beyond])
    with np.errstate(divide="ignore", invalid="ignore"):
        for _ in range(60):
            middle = (low + high) / 2
            right = (weights / (np.exp(middle)[:, None] - poles)).sum(axis=1) > level
            low, high = np.where(right, middle, low), np.where(right, high, middle)
        x = np.exp((low + high) / 2)
        return x, (weights / (x[:, None] - poles)**2).sum(axis=1)


def _chain_of(kind: str, s: Spectrum) -> Array:
    """Return a spring, elements by ascending retardation time, a dashpot, of those that there are: rows of a chain."""
    amplitudes, times = s.amplitudes[s.fixed:], np.exp(s.log_times)
    if kind == "creep":
        spring = [(1 / s.amplitudes[0], 0)] if s.constant else []
        dashpot = [(0, 1 / s.amplitudes[s.fixed - 1])] if s.ramp else []
        return np.array([*spring, *zip(1 / amplitudes, times / amplitudes), *dashpot])
    constant = s.amplitudes[0] if s.constant else 0.0
    x, slopes = _roots(times, amplitudes * times, constant)
    dashpot = [] if s.constant else [(0, amplitudes @ times)]
    return np.array([(constant + amplitudes.sum(), 0), *zip(x * slopes, x * x * slopes), *dashpot])


def _relaxation_of(chain: Array) -> tuple[float, Array, Array]:
    """Return the equilibrium modulus, and moduli and times of the relaxation of a chain that begins with a spring."""
    springs = chain[chain[:, 0] > 0]
    fluidity = float((1 / chain[len(springs):, 1]).sum())
    x, slopes = _roots(springs[:, 1] / springs[:, 0], 1 / springs[:, 0], fluidity)
    return 0.0 if fluidity else float(1 / (1 / springs[:, 0]).sum()), 1 / (x * x * slopes), x


def _shown(x: float) -> str:
    return f"{x:.3g}"


def _called(chain: Array, k: int) -> str:
    modulus, viscosity = chain[k]
    if viscosity == 0:
        return "the spring"
    return f"element {k + 1} (retardation time {_shown(viscosity / modulus)} s)" if modulus else "the dashpot"


def _open_sentences(chain: Array, errors: Array, twins: Sequence[tuple[float, int, int]]) -> Iterable[str]:
    """Describe each element with a number that the data fix to a factor of 2 or worse. twins: see _judged."""
    for k, pair in enumerate(np.exp(np.minimum(2 * errors, 700))):
        words = [f"its {name} within a factor of {_shown(factor)}" if factor < 1000 else
                 f"its {name} not within a factor of 1000" for name, factor in zip(("modulus", "viscosity"), pair)
                 if factor >= 2]
        near = [(ratio, a + b - k) for ratio, a, b in twins if k in (a, b)]
        twin = f"; they cannot tell it from {_called(chain, min(near)[1])}" if near else ""
        if words:
            yield f"the data hardly fix {_called(chain, k)}: {', '.join(words)}{twin}"


def _judged(data: Data, s: Spectrum, chain: Array, residual: float) -> tuple[Array, list[str], float]:
    """Return errors of the logarithms of a chain's numbers, sentences about what is open, and Fit.fastest."""
    columns, slopes = data.terms(s.constant, s.ramp, s.log_times)
    jacobian = data.weights[:, None] * np.column_stack([columns * s.amplitudes, slopes * s.amplitudes[s.fixed:]])
    scale = np.maximum(np.linalg.norm(jacobian, axis=0), 1e-100)
    basis, triangle = np.linalg.qr(jacobian / scale)
    triangle[np.diag_indices_from(triangle)] += np.where(np.abs(np.diag(triangle)) < 1e-14, 1e-14, 0)
    by_basis = np.linalg.inv(triangle) / scale[:, None]
    split, numbers = len(s.amplitudes), chain > 0

    def logs_of(change: Array) -> Array:
        moved = Spectrum(s.constant, s.ramp, s.log_times + change[split:], s.amplitudes * np.exp(change[:split]), 0)
        return np.log(_chain_of(data.kind, moved)[numbers])

    by_spectrum = np.column_stack([(logs_of(small) - logs_of(-small)) / 2e-4 for small in 1e-4 * np.eye(len(scale))])
    freedom = data.points - len(scale)
    noise = max(residual * math.sqrt(data.points / freedom), EXACT)
    # Of each number the row whose length is half the interval of 95 %; the length of a difference of rows is that of
    # the ratio of the numbers.
    rows = np.zeros((*chain.shape, len(scale)))
    rows[numbers] = float(stdtrit(freedom, 0.975)) / 2 * noise * by_spectrum @ by_basis
    errors = np.linalg.norm(rows, axis=2)
    twins = []  # neighbours of which the data do not tell whose retardation time is longer
    for a, b in itertools.pairwise(np.flatnonzero(numbers.all(axis=1)).tolist()):
        ratio = math.log(chain[b, 1] / chain[b, 0] / (chain[a, 1] / chain[a, 0]))
        if ratio < 2 * np.linalg.norm(rows[b, 1] - rows[b, 0] - rows[a, 1] + rows[a, 0]):
            twins.append((ratio, a, b))
    sentences, fastest = list(_open_sentences(chain, errors, twins)), 0.0
    if data.kind == "history":
        fastest = _fastest(data, s, basis, s.amplitudes @ by_basis[:split], noise,
                           max(2 * errors[0, 0], STIFFER) * chain[0, 0])
    if fastest:
        sentences.append(f"relaxation faster than {_shown(fastest)} s may hide behind the course of the strain and "
                         f"make the spring more than {STIFFER:.0%} stiffer: its interval holds if there is none")
    return errors, sentences, fastest


def _fastest(data: Data, s: Spectrum, basis: Array, stiffer: Array, noise: float, most: float) -> float:
    """Return the longest time below those of a fit at which one more branch can hide that raises the spring by `most`.

    basis: of the fit's Jacobian. stiffer: how the sum of amplitudes follows its coordinates.
    """
    least, longest = data.limits()[0], min([*s.log_times, data.limits()[1]])
    grid = np.linspace(least, longest, 10 * math.ceil((longest - least) / math.log(10)) + 2)[:-1]
    columns = data.weights[:, None] * data.terms(False, False, grid)[0]
    along = basis.T @ columns
    rest = np.linalg.norm(columns - basis @ along, axis=0)
    # A branch is taken up into the fit only if it lowers the squares by more than this.
    seen = noise * math.sqrt(max(2 * math.log(data.points), (HARDLY**2 - 1) * data.points))
    hidden = seen * (1 - stiffer @ along) > most * rest
    return float(np.exp(grid[hidden].max(initial=-np.inf)))


def _wrong_way(data: Data) -> list[str]:
    """Say so where values run the wrong way in time, by more than three standard deviations (Mann and Kendall)."""
    n, order = len(data.times), np.argsort(data.times, kind="stable")
    times, values = data.times[order], data.values[order]
    rising = sum(int(((times[i] < times[i + 1:]) * np.sign(values[i + 1:] - values[i])).sum()) for i in range(n))
    deviations = rising / math.sqrt(n * (n - 1) * (2 * n + 5) / 18)
    if data.kind == "creep" and deviations < -3:
        return ["the compliances fall with time, as in no creep"]
    return ["the moduli rise with time, as in no relaxation"] if data.kind == "relaxation" and deviations > 3 else []


def _chosen(data: Data, spectra: Sequence[Spectrum]) -> tuple[Spectrum, Spectrum]:
    """Return the spectrum that the data need, and of its elements those that lower the residual by a twentieth."""
    some = [s for s in spectra if len(s.amplitudes)]
    needed = min(some, key=lambda s: _information(data, s, s.parameters))
    return needed, next(s for s in some if s.squares <= HARDLY**2 * needed.squares)


def _elements(n: int) -> str:
    return f"{n} element{'s' * (n > 1)}"


def _fitted(measured: Data, n: int | None) -> Fit:
    data = _condensed(measured)
    spectra = _best_spectra(data, n or min(MOST_ELEMENTS, (data.points - 1) // 2))
    if not len(spectra[-1].amplitudes):
        names = {"creep": "compliances", "relaxation": "moduli", "history": "histories"}
        raise Refused(names[data.kind], "a curve that no chain comes near", "a curve that is positive on the whole")
    needed, chosen = _chosen(data, spectra)
    s = spectra[-1] if n else chosen

    left = [_shown(math.sqrt(each.squares / data.points)) for each in spectra]
    sizes = [len(_chain_of(data.kind, each)) if len(each.amplitudes) else 0 for each in spectra]
    at, enough = spectra.index(s), sizes[spectra.index(needed)]
    used, open_, choice = sizes[at], _wrong_way(data), ""
    if n and used < n:
        open_.append(f"the data take {used} of {_elements(n)}: the others would add nothing")
    if n and enough < used:
        open_.append(f"a chain of {enough} describes the data as well as one of {used}: residual "
                     f"{left[spectra.index(needed)]} and {left[at]}")
    if not n:
        choice = _elements(used)
        for fewer, rest in [pair for pair in zip(sizes, left) if 0 < pair[0] < used][-1:]:
            choice += f", because {fewer} leave{'s' * (fewer == 1)} a residual of {rest} and {used} one of {left[at]}"
        for size, rest in [pair for pair in zip(sizes, left) if pair[0] > used][:1]:
            choice += f"; {size} would leave {rest}, which is hardly less, or less by chance"
    s = _refined(data, s.constant, s.ramp, s.log_times, 1e-15)
    chain = _chain_of(data.kind, s)
    model = measured.terms(s.constant, s.ramp, s.log_times)[0] @ s.amplitudes
    residual = float(np.sqrt(np.mean((measured.weights * (model - measured.values))**2)))
    errors, more, fastest = _judged(data, s, chain, residual)
    return Fit(chain, errors, residual, model, choice, open_ + more, fastest)


def _need(right: Any, name: str, numbers: Array, allowed: str) -> None:
    """Refuse the first number that is not right."""
    for i in np.flatnonzero(~(right & np.isfinite(numbers)))[:1]:
        raise Refused(f"{name}[{i}]", f"{numbers[i]:.6g}", allowed)


def _checked(kind: str, curves: Sequence[Curve], n: int | None, residual: str) -> Data:
    value = {"creep": "compliances", "relaxation": "moduli", "history": "stresses"}[kind]
    history, relative, points = kind == "history", residual == "relative", sum(len(times) for times, _, _ in curves)
    if residual not in ("relative", "absolute"):
        raise Refused("residual", f'"{residual}"', '"absolute", "relative"')
    if n is not None and not 1 <= n <= MOST_ELEMENTS:
        raise Refused("n", n, "1 to 8 elements, or None: as few as describe the data")
    for k, curve in enumerate(curves):
        times, of = curve[0], f"histories[{k}]." if history else ""
        for name, numbers in zip((of + "times", of + "strains", of + value), curve):
            if len(numbers) != len(times):
                raise Refused(name, f"{len(numbers)} numbers", f"{len(times)}, one for each time")
            _need((numbers == 0) | (np.abs(numbers) > 1e-50) & (np.abs(numbers) < 1e50) | ~np.isfinite(numbers), name,
                  numbers, "a finite number: 0, or between 1e-50 and 1e50; other units may help")
        if history:
            _need(np.diff(times, prepend=times[:1]) >= 0, of + "times", times, "no time before the one before it")
        else:
            _need(times >= 0, "times", times, "a finite number >= 0")
        if relative:
            _need(curve[2] > 0, of + value, curve[2],
                  "a finite number > 0; any finite number with an absolute residual")
    fewest = 2 * n + 1 if n else 3
    if points < fewest:
        raise Refused("times", f"{points} numbers", f"at least {fewest}" + (f" for {_elements(n)}" if n else ""))
    if history and points > MOST_IN_HISTORIES:
        raise Refused("histories", points, f"at most {MOST_IN_HISTORIES} points in all")
    times, strains, values = (np.concatenate(part) for part in zip(*curves))
    first = np.concatenate([np.arange(len(own)) == 0 for own, _, _ in curves])
    if not (np.where(first, 0, np.diff(times, prepend=times[:1])) if history else times).any():
        raise Refused("histories" if history else "times", "no time after the first one" if history else
                      "no time after 0", "at least one")
    greatest = np.abs(values).max() if history else values.max()
    if greatest <= 0:
        raise Refused("histories" if history else value, "no stress but 0" if history else "no number > 0",
                      "at least one")
    weights = 1 / (values if relative else np.full_like(values, greatest))
    return Data(kind, times, values, weights, strains if history else np.ones_like(times), first, points)


def fit_curves(kind: str, curves: Sequence[Curve], n: int | None, residual: str) -> Fit:
    """Fit a chain of at most n elements, 1..8, to curves of one kind; None: as few as describe the data."""
    return _fitted(_checked(kind, curves, n, residual), n)


def _interval(error: float) -> str:
    """Return the interval of 95 % of a number, by the error of its logarithm."""
    if error < 0.25:
        return f"+-{200 * error:.2g} %"
    return f"within a factor of {_shown(math.exp(2 * error))}" if error < math.log(1000) / 2 else "open"


def _described(element: Array, error: Array, fastest: float) -> str:
    if element[1] == 0:
        return f"spring, {_interval(error[0])}" + f" if nothing relaxes faster than {_shown(fastest)} s" * (fastest > 0)
    if element[0] == 0:
        return f"dashpot, {_interval(error[1])}"
    return (f"retardation time {element[1] / element[0]:.4g} s; modulus {_interval(error[0])}, viscosity "
            + _interval(error[1]))


def _table_of(fit: Fit, title: str, kind: str, residual: str) -> str:
    """Return the table [material] of a scene, with what the data say about it as comments."""
    lines = [f"# {title}: {len(fit.model)} points of {'a ' * (kind == 'history')}{kind}; elements: "
             f"{len(fit.elements)}; residual {_shown(fit.residual)} (root mean square, relative to "
             f"{'each' if residual == 'relative' else 'the greatest'} value)"]
    lines += [f"# {fit.choice}"] if fit.choice else []
    if fit.elements[0][1] == 0:  # it has a spring
        equilibrium, moduli, times = _relaxation_of(fit.elements)
        terms = [f"{equilibrium:.7g}"] * (equilibrium > 0) + [f"{m:.7g}*e^(-t/{t:.7g})" for m, t in zip(moduli, times)]
        lines.append(f"# relaxation E(t) = {' + '.join(terms)} Pa, t in s")
    lines += ["[material]", "elements = [ # +- and factors: the truth is within in 95 of 100 such data"]
    for k, (element, error) in enumerate(zip(fit.elements, fit.errors), 1):
        text = f"{{ modulus = {element[0]:.7g}, viscosity = {element[1]:.7g} }},"
        lines.append(f"    {text:<52} # {k}: {_described(element, error, fit.fastest)}")
    return "\n".join(lines + ["]"] + [f"# warning: {sentence}" for sentence in fit.undetermined]) + "\n"


def _csv_of(fit: Fit, kind: str, curves: Sequence[Curve]) -> str:
    """Return the data and the model. With several curves the first column is the number of the curve."""
    names = {"creep": "time,compliance", "relaxation": "time,modulus", "history": "time,strain,stress"}[kind]
    lines, model = ["curve," * (len(curves) > 1) + names + ",model"], iter(fit.model)
    for k, curve in enumerate(curves, 1):
        for row in zip(*(curve if kind == "history" else curve[::2]), model):
            numbers = [repr(float(x)).removesuffix(".0") for x in row]
            lines.append(",".join([str(k)] * (len(curves) > 1) + numbers))
    return "\n".join(lines) + "\n"


def _write(path: Path, text: str) -> None:
    part = path.with_name(f"{path.name}.dermis-{os.getpid()}.part")
    try:
        with open(part, "x", encoding="utf-8", errors="surrogateescape") as file:
            file.write(text)
        part.rename(path)
    finally:
        part.unlink(missing_ok=True)


def main() -> int:
    """Answer a request of the command. Returns its status."""
    for stream in (sys.stdin, sys.stdout, sys.stderr):
        stream.reconfigure(encoding="utf-8", errors="surrogateescape")  # type: ignore[union-attr]
    asked = json.load(sys.stdin)
    kind, out = asked["kind"], asked["out"]
    curves: list[Curve] = [tuple(np.array(numbers, np.float64) for numbers in curve) for curve in asked["curves"]]
    try:
        fit = fit_curves(kind, curves, asked["elements"] or None, asked["residual"])
        text = _table_of(fit, asked["title"], kind, asked["residual"])
        for name, content in (("material.toml", text), ("fit.csv", _csv_of(fit, kind, curves))) if out else ():
            _write(Path(out) / name, content)
            text += f"# {out}/{name}\n"
        print(text, end="", flush=True)
    except Refused as refused:
        print(f"dermis: {asked['title']}: {refused}", file=sys.stderr)
        return 2
    except (MemoryError, OSError) as failed:
        print(f"dermis: {str(failed) or 'out of memory'}", file=sys.stderr, flush=True)
        os._exit(1)  # without another try to write what is left
    return 0


if __name__ == "__main__":
    sys.exit(main())
