# SPDX-License-Identifier: MIT
"""Writes the module dermis._tables from the list of keys. usage: tables.py FOLDER_OF_CORE FILE"""
import sys

sys.path.insert(0, sys.argv[1])
from _core import key_rows  # noqa: E402

HEAD = '''# SPDX-License-Identifier: MIT
"""The tables of a scene as keyword objects. None: the key is not given.

Where a key names the file of a map, an array of float32 or float64 may stand in its place. A unit is that of a number;
a text has its unit with it, as "5 ms". m without a spacing of the grid: cells.
"""
from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Union

import numpy as np

from ._core import KelvinVoigt, Relaxation

Array = np.ndarray[Any, np.dtype[Any]]
MapOrFile = Union[Array, str, "os.PathLike[str]"]
NumberOrMap = Union[float, MapOrFile]
NumberWithUnit = Union[float, str]  # a number, or a text with its unit, as "5 ms"
Numbers = Union[Sequence[float], Array]
CellOrPlace = Union[int, str]  # a cell, or a length with its unit, as "3 mm", where the grid has a spacing
Cells = Union[Sequence[Sequence[CellOrPlace]], Array]
'''


def class_of(table, rows):
    sentences, members = zip(*rows)
    return (f'\n\n@dataclass(kw_only=True)\nclass {table.title()}:\n    """The table [{table}] of a scene.\n\n' +
            "\n".join(sentences) + '\n    """\n\n' + "".join(members))


tables = {}
for table, name, unit, default, allowed, says, kind in key_rows():
    if table.count(".") == 1 and table != "afferents.":
        more = [unit, allowed, default and ("" if default.startswith("required") else "default ") + default]
        sentence = f"    {name}: {says}" + "".join(f"; {m}" for m in more if m) + "."
        tables.setdefault(table[:-1], []).append((sentence, f"    {name}: {kind} | None = None\n"))
with open(sys.argv[2], "w", encoding="utf-8") as file:
    file.write(HEAD + "".join(class_of(*table) for table in tables.items()))
