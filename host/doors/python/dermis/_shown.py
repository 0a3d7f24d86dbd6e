# SPDX-License-Identifier: MIT
"""How objects are shown, and what is imported where it is asked for."""
from __future__ import annotations

import importlib
from typing import Any

import numpy as np

from ._core import Result


def extra(name: str) -> Any:
    """Import a module that needs the packages of dermis[name]."""
    try:
        return importlib.import_module(f"dermis._{name}")
    except ModuleNotFoundError as missing:
        raise ModuleNotFoundError(f"{name} needs {missing.name}: pip install dermis[{name}]",
                                  name=missing.name) from None


def text_of(value: object) -> str:
    if isinstance(value, np.ndarray):
        return f"<{value.dtype} {value.shape}>"
    if isinstance(value, list) and len(value) > 4:
        return f"[{', '.join(map(text_of, value[:3]))}, .. {len(value)}]"
    return f"[{', '.join(map(text_of, value))}]" if isinstance(value, list) else repr(value)


def members_of(self: object) -> str:
    """The repr of an object by its properties."""
    names = [name for name, member in vars(type(self)).items() if isinstance(member, property)]
    return f"{type(self).__name__}({', '.join(f'{name}={text_of(getattr(self, name))}' for name in names)})"


def summary_of(self: Result) -> str:
    return (f"<Result at {len(self.time)} times: {' '.join(self)}; {len(self.fields)} fields, "
            f"{self.responses.shape[1]} sites; {self.model} in {self.precision}, {self.device.name}>")
