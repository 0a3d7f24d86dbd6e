# SPDX-License-Identifier: MIT
"""Views of responses, for every reader of DLPack, and the type of spikes."""
from __future__ import annotations

from typing import Any

import numpy as np

# dermis::Spike
SPIKE = np.dtype([("pad", np.int32), ("afferent", np.int32), ("frame", np.int32), ("share", np.float32)])
# dermis::FiredSpike
FIRED = np.dtype([("time", np.float64), ("afferent", np.int32)])


class Response(np.ndarray[Any, np.dtype[np.float32]]):
    """A view of a response, which cannot be written to. What is computed from it is an ordinary array.

    Readers of DLPack before version 1, as JAX, cannot be told that an array is read-only: they get a copy.
    """

    def __dlpack__(self, *, max_version: tuple[int, int] | None = None, **options: Any) -> Any:
        if max_version is None and not self.flags.writeable:
            return np.array(self).__dlpack__(**options)
        return np.asarray(self).__dlpack__(max_version=max_version, **options)

    def __array_wrap__(self, array: Any, context: Any = None, return_scalar: bool = False) -> Any:
        return np.asarray(array)[()]  # a number where no axes are left; NumPy 1 gives no return_scalar
