# SPDX-License-Identifier: MIT
"""Types of arguments and names, for type checkers."""
from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, Protocol, SupportsIndex, Union

if TYPE_CHECKING:
    from typing_extensions import Buffer

ReceptorType = Literal["sa1", "sa2", "fa1", "fa2"]
OfTrace = Literal["strain", "sa1", "sa2", "fa1", "fa2"]
OfSkin = Literal["sa1", "sa2", "fa1", "fa2", "strain", "indentation", "curvature", "shear_x", "shear_y", "stretch_x",
                 "stretch_y", "stretch_xy"]
Signal = Literal["strain", "stress"]
Precision = Literal["f32", "f32-compensated", "f64"]
Hold = Literal["linear", "parabolic"]
Control = Literal["pressure", "depth"]
Kind = Literal["creep", "relaxation"]
Residual = Literal["relative", "absolute"]
BodyKind = Literal["sphere", "capsule", "box", "plane", "cylinder", "ellipsoid"]
TaxelUnit = Literal["newton", "pascal"]


class SupportsDLPack(Protocol):
    """An array of NumPy, torch, JAX, CuPy .. in the memory of the CPU."""

    def __dlpack__(self) -> Any: ...


AnyArray = Union[SupportsDLPack, "Buffer"]
Numbers = Union[float, Sequence[float], SupportsDLPack, "Buffer"]  # one for all, or one for each
Pads = Union[SupportsIndex, Sequence[int], Sequence[Sequence[int]], SupportsDLPack, "Buffer"]
Outputs = Mapping[ReceptorType, AnyArray]
