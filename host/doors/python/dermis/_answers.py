# SPDX-License-Identifier: MIT
"""What a call with wrong arguments is answered: the one at fault, its value, and what is allowed by the signature.

Each function of _core gets an overload that refuses what its others do not take, and each property a setter of this
kind. Functions of the package are answered by a decorator.
"""
from __future__ import annotations

import ast
import functools
import inspect
import operator
import os
import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NoReturn, ParamSpec, TypeVar

import numpy as np

from . import _core

Given = ParamSpec("Given")
Returned = TypeVar("Returned")


def _is_row(value: Any) -> bool:
    return hasattr(value, "__len__") and getattr(value, "ndim", 1) > 0 and not isinstance(
        value, (str, bytes, np.ma.MaskedArray))


# By a type's name: one value in words, several values in words, and whether a value is one.
_TYPES: dict[str, tuple[str, str, Callable[[Any], bool]]] = {
    "float": ("a number", "numbers", lambda v: not isinstance(v, (str, bytes)) and isinstance(float(v), float)),
    "int": ("a whole number", "whole numbers", lambda v: abs(operator.index(v)) < 2**31),
    "str": ("a text", "texts", lambda v: isinstance(v, str) and not re.search("[\ud800-\udfff]", v)),
    "bool": ("True or False", "bools", lambda v: isinstance(v, (bool, np.bool_))),
    "None": ("None", "", lambda v: v is None),
    "Sequence": ("a list", "lists", _is_row),
    "NDArray": ("an array", "arrays", lambda v: hasattr(v, "dtype") and _is_row(v)),
    "Iterable": ("a list", "lists", lambda v: hasattr(v, "__iter__")),
    "Mapping": ("a dict", "dicts", lambda v: isinstance(v, Mapping)),
    "dict": ("a dict", "dicts", lambda v: isinstance(v, dict)),
    "Callable": ("a function", "functions", callable),
    "PathLike": ("a path", "paths", lambda v: isinstance(v, os.PathLike)),
    "object": ("", "", lambda v: v is not None),
}


def _type_named(kind: ast.expr) -> tuple[str, str, Callable[[Any], bool]]:
    name = ast.unparse(kind.value if isinstance(kind, ast.Subscript) else kind).strip("'").rpartition(".")[2]
    made = getattr(_core, name, None)
    if isinstance(made, type):
        return f"a {name}", name, lambda v: isinstance(v, made)
    return _TYPES.get(name, ("", "values", lambda v: True))


def _fits(value: object, kind: ast.expr) -> bool:
    if isinstance(kind, ast.BinOp):
        return _fits(value, kind.left) or _fits(value, kind.right)
    try:
        return _type_named(kind)[2](value)
    except (OverflowError, TypeError, ValueError):
        return False


def _words_of(kind: ast.expr) -> str:
    if isinstance(kind, ast.BinOp):
        words = [_words_of(kind.left), _words_of(kind.right)]
        return " or ".join(words) if all(words) else ""  # empty: any object
    word = _type_named(kind)[0]
    return f"{word} of {_type_named(kind.slice)[1]}" if word == "a list" and isinstance(kind, ast.Subscript) else word


def _meaning_of(name: str, scope: object, doc: str | None) -> str:
    """Return what the documentation says of an argument, as "m, >= 0"."""
    member = getattr(scope, name, None)
    if isinstance(member, property):
        return member.__doc__ or ""
    found = re.search(rf"\b{name}(?:, \w+)*: (.*?)(?:;|\.\s|\.?$)", doc or "", re.DOTALL)
    return " ".join(found[1].split()) if found else ""


def _faults(signature: inspect.Signature, scope: object, doc: str | None, arguments: tuple[Any, ...],
            named: Mapping[str, Any]) -> Iterator[tuple[str, Any, str]]:
    """Yield what is wrong with a call: the parameter, its value, Ellipsis where it is not given, and what is allowed."""
    left, rest = list(arguments), dict(named)
    for name, parameter in signature.parameters.items():
        if parameter.kind is parameter.VAR_KEYWORD:
            rest.clear()
            continue
        by_place = left and parameter.kind is not parameter.KEYWORD_ONLY
        value = left.pop(0) if by_place else rest.pop(name, ... if parameter.default is parameter.empty else rest)
        if value is rest or parameter.annotation is parameter.empty:
            continue
        kind = ast.parse(parameter.annotation, mode="eval").body
        if value is ... or not _fits(value, kind):
            words, meaning = _words_of(kind), _meaning_of(name, scope, doc)
            yield name, value, f"{words} ({meaning})" if words and meaning else words or meaning or "a value"
    names = ", ".join(name for name in signature.parameters if name != "self")
    yield from ((name, value, f"the arguments {names}") for name, value in rest.items())
    yield from (("one more argument", value, f"the arguments {names}" if names else "none") for value in left)


def answered(function: Callable[Given, Returned]) -> Callable[Given, Returned]:
    """Let a function of the package say which argument is the cause of an error, if one is."""
    @functools.wraps(function)
    def call(*arguments: Given.args, **named: Given.kwargs) -> Returned:
        try:
            return function(*arguments, **named)
        except (AttributeError, TypeError):
            doc = function.__doc__ or arguments[0].__doc__
            for fault in _faults(inspect.signature(function), None, doc, arguments, named):
                _core.refuse(*fault)
            raise
    return call


def _signature_of(text: str) -> inspect.Signature:
    """Return a signature of nanobind's, in which defaults are numbers behind a backslash, and arrays have shapes."""
    made: dict[str, Any] = {}
    text = re.sub(r"ndarray\[[^][]*\]", "NDArray", re.sub(r"\\\d+", "None", text))
    exec(f"from __future__ import annotations\n{text}: ...", made)
    return inspect.signature(made.popitem()[1])


def _answer(scope: object, name: str, function: Any) -> None:
    def refuse(*arguments: Any, **named: Any) -> NoReturn:
        faults = [list(_faults(_signature_of(text), scope, doc, arguments, named)) for text, doc, *_ in signatures]
        nearest = min(reversed(faults), key=len)
        _core.refuse(*(nearest or [("arguments", arguments[is_method:], f"those of {signatures[0][0]}")])[0])

    signatures, is_method = function.__nb_signature__, type(function).__name__ == "nb_method"
    _core.answer(scope, name, is_method, refuse)


def _answer_call(kind: type) -> None:
    _core.answer(kind, "__init__", True, lambda self, *arguments, **named: _core.refuse(
        kind.__name__, arguments, "objects that the functions of dermis return"))


def _assigned(name: str, member: Any) -> property:
    def assign(self: object, value: object) -> None:
        try:
            if isinstance(value, np.ma.MaskedArray):
                raise TypeError
            member.fset(self, value)
        except TypeError:
            _core.refuse(name, value, member.__doc__)

    return property(member.fget, assign, doc=member.__doc__)


_kinds = [kind for kind in vars(_core).values() if isinstance(kind, type)]
for _scope in (_core, *_kinds):
    for _name, _member in list(vars(_scope).items()):
        if type(_member).__name__ in ("nb_func", "nb_method") and _name not in ("answer", "refuse"):
            if not _name.startswith("__") or _name in ("__init__", "__getitem__", "__contains__", "__setstate__"):
                _answer(_scope, _name, _member)
        elif isinstance(_member, property) and _member.fset:
            setattr(_scope, _name, _assigned(_name, _member))
for _kind in _kinds:
    if type(vars(_kind).get("__init__")).__name__ != "nb_method":
        _answer_call(_kind)
