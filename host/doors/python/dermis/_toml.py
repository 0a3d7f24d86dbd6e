# SPDX-License-Identifier: MIT
"""Tables of Python objects as TOML, with the maps that cannot stand in a text."""
from __future__ import annotations

import dataclasses
import json
import os
import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from ._core import KelvinVoigt, Relaxation, refuse

Maps = dict[str, np.ndarray[Any, np.dtype[np.float64]]]

_maps = re.compile(r"(surface|load(\[\d+\])?(\.texture)?)\.path|material\.(elements\[\d+\]\.)?(modulus|viscosity)")


def need_unmasked(value: object, name: str) -> None:
    if isinstance(value, np.ma.MaskedArray):
        refuse(name, value, "an array without a mask")


def _map_named(name: str, array: np.ndarray[Any, Any], maps: Maps) -> str:
    if array.dtype.kind not in "fiub" or array.ndim != 2:
        refuse(name, array, "array of numbers, of shape (height, width)")
    maps[name] = np.ascontiguousarray(array, np.float64)
    return name


def pairs_of(value: object) -> Mapping[str, Any] | None:
    """Return the keys and values of a table, without keys that are not given; None if the value is no table."""
    if isinstance(value, (KelvinVoigt, Relaxation)):
        return {name: getattr(value, name) for name, member in vars(type(value)).items() if isinstance(member, property)}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        value = {f.name: getattr(value, f.name) for f in dataclasses.fields(value)}
    if not isinstance(value, Mapping):
        return None
    for key in value:
        if not isinstance(key, str):
            refuse("key", key, "texts")
    return {key: inner for key, inner in value.items() if inner is not None}


def value_of(value: object, name: str, maps: Maps) -> str:
    """Return a value of the key `name` as TOML on one line, and put an array that is a map into `maps`."""
    need_unmasked(value, name)
    if isinstance(value, np.ndarray) and _maps.fullmatch(name) and value.ndim:
        value = _map_named(name, value, maps)
    if isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, os.PathLike):
        value = os.fspath(value)
    if isinstance(value, str):
        try:
            value.encode()
        except UnicodeEncodeError as error:
            refuse(name, value[error.start:], "a text in Unicode: no other bytes of a path stand in a scene")
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(value_of(v, f"{name}[{i}]", maps) for i, v in enumerate(value)) + "]"
    pairs = pairs_of(value)
    if pairs is None:
        refuse(name, value, "a number, a text, a list, a table or an array")
    return "{" + ", ".join(f"{json.dumps(k)} = {value_of(v, f'{name}.{k}', maps)}" for k, v in pairs.items()) + "}"


_of_pads = re.compile(r"material\.((elements\[\d+\]\.)?(modulus|viscosity)|spring|dashpot)")


def without_rows(value: object, name: str, rows: Maps) -> Any:
    """Return a material with a number in place of each array of one for each pad, which goes into `rows`."""
    if _of_pads.fullmatch(name) and isinstance(value, (list, tuple, np.ndarray)):
        need_unmasked(value, name)
        try:
            array = np.asarray(value)
        except ValueError:  # lists of several lengths
            array = np.empty(0, object)
        if array.dtype.kind not in "fiu" or not array.ndim:
            refuse(name, value, "a number, or an array of one for each pad")
        rows[name] = np.ascontiguousarray(array, np.float64)
        return 1.0
    if isinstance(value, (list, tuple)):
        return [without_rows(item, f"{name}[{i}]", rows) for i, item in enumerate(value)]
    pairs = pairs_of(value)
    return value if pairs is None else {key: without_rows(item, f"{name}.{key}", rows) for key, item in pairs.items()}


def of_file(table: object) -> object:
    """Return a table with kind "file" if its path is a map in memory."""
    pairs = pairs_of(table)
    return {"kind": "file", **pairs} if pairs and isinstance(pairs.get("path"), np.ndarray) else table


def text_of(tables: Mapping[str, Any]) -> tuple[str, Maps]:
    """Return a scene of tables as a text and the maps that it names. A map in memory makes its table's kind "file"."""
    maps: Maps = {}
    lines = []
    for key, value in (pairs_of(tables) or {}).items():
        if key in ("surface", "load"):
            value = [of_file(v) for v in value] if isinstance(value, (list, tuple)) else of_file(value)
        lines.append(f"{json.dumps(key)} = {value_of(value, key, maps)}\n")
    return "".join(lines), maps


def overrides_of(overrides: Mapping[str, Any]) -> list[str]:
    """Return overrides by dotted name, as in {"time.step": 0.001}, as Scene::from_file takes them."""
    maps: Maps = {}
    lines = [f"{key}={value_of(value, key, maps)}" for key, value in overrides.items()]
    for name in maps:
        refuse(name, maps[name], "a value that can stand in a text; give maps in a scene of tables")
    return lines
