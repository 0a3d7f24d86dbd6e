# SPDX-License-Identifier: MIT
"""What a call with wrong arguments is answered: the one at fault, its value, and what is allowed by the signature.

Each function of _core is put behind one that refuses what it does not take, and each property a setter of this kind.
Functions of the package are answered by a decorator.
"""
from __future__ import annotations

import functools
import inspect
import operator
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, ParamSpec, TypeVar

import numpy as np

from . import _core

Given = ParamSpec("Given")
Returned = TypeVar("Returned")


def _is_row(value: Any) -> bool:
    texts = (str, bytes, np.ma.MaskedArray)
    return hasattr(value, "__len__") and getattr(value, "ndim", 1) > 0 and not isinstance(value, texts)


def _is_text(value: Any) -> bool:
    return isinstance(value, str) and not re.search("[\ud800-\udfff]", value)


Test = Callable[[Any], bool]
_TYPES: dict[str, tuple[str, Test]] = {  # in words, and whether a value is of the type
    "float": ("a number", lambda v: not isinstance(v, (str, bytes)) and isinstance(float(v), float)),
    "int": ("a whole number", lambda v: abs(operator.index(v)) < 2**31),
    "str": ("a text", _is_text),
    "bool": ("True or False", lambda v: isinstance(v, (bool, np.bool_))),
    **dict.fromkeys(("ReceptorType", "OfTrace", "Precision", "Hold", "Control", "Kind", "Residual", "BodyKind",
                     "TaxelUnit"), ("a text", _is_text)),
    "None": ("None", lambda v: v is None),
    "Sequence": ("a list", _is_row),
    "NDArray": ("an array", lambda v: hasattr(v, "dtype") and _is_row(v)),
    "Iterable": ("a list", lambda v: hasattr(v, "__iter__")),
    "Mapping": ("a dict", lambda v: isinstance(v, Mapping)),
    "Callable": ("a function", callable),
    "PathLike": ("a path", lambda v: isinstance(v, os.PathLike)),
    "object": ("", lambda v: v is not None),
}
_ITEMS = {"float": "numbers", "str": "texts", "ReceptorType": "texts", "AnyMaterial": "materials",
          "Sequence[float]": "pairs", "Sequence[int]": "cells"}


def _fit(value: object, annotation: str) -> tuple[bool, str]:
    """Return whether a value may be of one of some types, and these in words, none where any object may."""
    fits, words = False, []
    for name, items in re.findall(r"(?:\w+\.)*(\w+)(?:\[(?:\w+\.)*(.*?)\])?(?: \| |$)", annotation):
        kind: Any = getattr(_core, name, None)
        word, test = _TYPES.get(name, ("", lambda v: True))
        if isinstance(kind, type):
            word, test = f"{'an' if name[0] in 'AEIO' else 'a'} {name}", lambda v: isinstance(v, kind)
        words.append(f"{word} of {_ITEMS.get(items, items)}" if word == "a list" else word)
        try:
            fits = fits or test(value)
        except (OverflowError, TypeError, ValueError):
            pass
    return fits, " or ".join(words) if all(words) else ""


def _meaning_of(name: str, scope: object, doc: str | None) -> str:
    """Return what the documentation says of an argument, as "m, >= 0"."""
    member = getattr(scope, name, None)
    if isinstance(member, property):
        return member.__doc__ or ""
    found = re.search(rf"\b{name}(?:, \w+)*: (.*?)(?:;|\.\s|\.?$)", doc or "", re.DOTALL)
    return " ".join(found[1].split()) if found else ""


def _faults(signature: inspect.Signature, scope: object, doc: str | None, arguments: Iterable[Any],
            named: Mapping[str, Any]) -> Iterator[tuple[str, Any, str]]:
    """Yield the parameters that are wrong, their values, Ellipsis where none is given, and what is allowed."""
    left, rest = list(arguments), dict(named)
    for name, parameter in signature.parameters.items():
        if parameter.kind is parameter.VAR_KEYWORD:
            rest.clear()
            continue
        if left and parameter.kind is not parameter.KEYWORD_ONLY:
            rest[name] = left.pop(0)
        value = rest.pop(name, ...)
        if parameter.annotation is parameter.empty or value is ... and parameter.default is not parameter.empty:
            continue
        fits, words = _fit(value, parameter.annotation)
        if value is ... or not fits:
            meaning = _meaning_of(name, scope, doc)
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
        except (AttributeError, TypeError) as error:
            cause = error
        doc = function.__doc__ or arguments[0].__doc__
        for fault in _faults(inspect.signature(function), None, doc, arguments, named):
            _core.refuse(*fault)
        raise cause
    call.__doc__ = function.__doc__ or ""  # of a constructor: it does not show that of the class in _core
    return call


def _signature_of(text: str) -> inspect.Signature:
    """Return a signature of nanobind's, in which defaults are numbers behind a backslash, and arrays have shapes."""
    made: dict[str, Any] = {}
    text = re.sub(r"ndarray\[[^][]*\]", "NDArray", re.sub(r"\\\d+", "None", text))
    exec(f"from __future__ import annotations\n{text}: ...", made)
    return inspect.signature(made.popitem()[1])


def _answer(scope: Any, name: str, function: Any) -> None:
    """Put a function of _core, or of a class in it, behind one that answers what it does not take."""
    signatures: Any = getattr(function, "__nb_signature__", ())  # none: a class that cannot be called
    none: Any = [(f"def {name}(self)", "Objects of this type come from functions of dermis.", None)]

    def uncalled(*given: Any, **named: Any) -> Any:
        raise TypeError

    def refuse(error: TypeError, named: dict[str, Any], *given: Any) -> None:
        if signatures and "incompatible function arguments" not in str(error):
            return  # of what the function called
        faults = [list(_faults(_signature_of(text), scope, doc, given, named)) for text, doc, *_ in signatures]
        no_call = (scope.__name__, given[1:], "objects that functions of dermis return")
        for fault in min(reversed(faults), key=len, default=[no_call]):  # of the overload that was meant
            _core.refuse(*fault)
        _core.refuse("arguments", given[is_method:], f"those of {signatures[0][0]}")

    is_method = isinstance(scope, type) and type(function).__name__ != "nb_func"
    if signatures:
        delattr(scope, name)
    for text, doc, defaults in signatures or none:  # each is a line of help; the first takes every call
        text = re.sub(r"\\(=?)(\d+)", lambda i: (str if i[1] else repr)(defaults[int(i[2])]), text)
        _core.answer(scope, text, doc or "", is_method, function if signatures else uncalled, refuse)


def _assigned(name: str, member: Any) -> property:
    def assign(self: object, value: object) -> Any:
        try:
            if not isinstance(value, np.ma.MaskedArray):
                return member.fset(self, value)
        except TypeError:
            pass
        _core.refuse(name, value, member.__doc__)

    return property(member.fget, assign, doc=member.__doc__)


_public = re.compile(r"__(init|getitem|contains|setstate)__|(?!__|answer$|refuse$).*")
for _scope in (_core, *[kind for kind in vars(_core).values() if isinstance(kind, type)]):
    for _name, _member in list(vars(_scope).items()):
        if isinstance(_member, property) and _member.fset:
            setattr(_scope, _name, _assigned(_name, _member))
        elif _public.fullmatch(_name) and (_name == "__init__" or type(_member).__name__ in ("nb_func", "nb_method")):
            _answer(_scope, _name, _member)
