# SPDX-License-Identifier: MIT
"""Views of responses, for every reader of DLPack, the type of spikes, and the pads that an index names."""
from __future__ import annotations

import math
import types
from collections.abc import Sequence
from typing import Any

import numpy as np

from ._core import refuse

# dermis::Spike, and when it was
SPIKE = np.dtype([("pad", np.int32), ("afferent", np.int32), ("frame", np.int32), ("share", np.float32),
                  ("time", np.float64)])
# dermis::FiredSpike
FIRED = np.dtype([("time", np.float64), ("afferent", np.int32)])


class Response(np.ndarray[Any, np.dtype[np.float32]]):
    """A view of a response, which cannot be written to. What is computed from it is an ordinary array.

    Readers of DLPack before version 1, as JAX and NumPy 1, cannot be told that an array is read-only. They share its
    memory all the same, and must not write to it. JAX copies memory that does not begin at a multiple of 64 bytes.
    """

    def __dlpack__(self, *, max_version: tuple[int, int] | None = None, **options: Any) -> Any:
        if max_version is not None and max_version[0] >= 1 and np.lib.NumpyVersion(np.__version__) >= "2.1.0":
            return np.asarray(self).__dlpack__(max_version=max_version, **options)
        interface = {**self.__array_interface__, "data": (self.ctypes.data, False)}  # False: it may be written to
        return np.asarray(types.SimpleNamespace(owner=self, __array_interface__=interface)).__dlpack__(**options)

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        return np.asarray(array)[()]  # a number where no axes are left; NumPy 1 gives no return_scalar


def places_of(index: Any, n: Sequence[int]) -> np.ndarray[Any, np.dtype[np.int64]]:
    """Return the numbers of the pads that an index of an array of shape n names, in the shape that indexing gives."""
    shape, one, listed = tuple(n), isinstance(index, (int, tuple, np.integer)), isinstance(index, list)
    try:
        rows = np.atleast_1d(index)[None] if one else np.asarray(index)
        if rows.dtype == bool and rows.ndim and rows.shape == shape[:rows.ndim] and not (one or listed):
            rows = np.argwhere(rows)
        elif rows.shape == (0,):
            rows = np.empty((0, len(shape)), int)
        as_rows = rows.ndim == 2 and rows.dtype.kind in "iu" and not np.ma.isMaskedArray(index)
        if as_rows and len(np.unique(rows, axis=0)) == len(rows) and (not listed or {*map(type, index)} <= {tuple}):
            first = np.ravel_multi_index(tuple(rows.T.astype(int)), shape[:rows.shape[1]])
            return np.asarray(np.arange(math.prod(shape)).reshape(-1, *shape[rows.shape[1]:])[first[0] if one else first])
    except (TypeError, ValueError):  # rows of several lengths, memory that is elsewhere, numbers of no pad
        pass
    refuse("pads", index, f"an index of an array of shape {shape}: (e, p); e, for all of a[e]; a list of such tuples or an "
                          f"array of such rows, each once; or an array of bools of shape {shape[:1]} or {shape}")
