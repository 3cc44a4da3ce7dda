"""Dataclasses to and from plain data (dictionaries, lists, numbers, texts), checked against their annotations.

In: a frozen dataclass of numbers, texts, tuples, arrays and other such classes, or its plain data from JSON. Out: the
other form. Doubles keep their bits: JSON's shortest decimal reads back as the same double.
"""

from __future__ import annotations

import functools
import types
from dataclasses import fields, is_dataclass
from typing import Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

from plannercheck.common.errors import PlannercheckError
from plannercheck.proofs.optional_fields import given_fields, optional_names

T = TypeVar("T")


def to_plain(value: Any) -> Any:
    """Dictionaries, lists, numbers and texts; arrays stay arrays."""
    if is_dataclass(value):
        return {field.name: to_plain(getattr(value, field.name)) for field in given_fields(value)}
    if isinstance(value, str):
        return checked_name(value, "a proof's name")
    return [to_plain(part) for part in value] if isinstance(value, tuple | list) else value


def from_plain(kind: type[T], value: Any, where: str) -> T:
    """A dataclass of a dictionary with just its fields; `where` is its name in errors.

    Raises:
        PlannercheckError: If something is missing, unknown or of another type.
    """
    out: T = _read(kind, value, where)
    return out


@functools.cache
def _hints(kind: type) -> dict[str, Any]:
    return get_type_hints(kind)


def _origin(kind: Any) -> Any:
    """What an annotation is made of. NumPy's NDArray is an alias with a name of its own from 2.5 on."""
    origin = get_origin(kind)
    meant = getattr(origin, "__value__", None)
    return origin if meant is None else get_origin(meant)


def _read(kind: Any, value: Any, where: str) -> Any:
    origin = _origin(kind)
    if is_dataclass(kind):
        return _object(kind, value, where)
    if origin is Literal:
        if value not in get_args(kind):
            raise PlannercheckError(f"{where} must be one of {get_args(kind)}, not {value!r:.60}")
        return value
    if origin in (Union, types.UnionType):
        return None if value is None else _read(get_args(kind)[0], value, where)
    if origin is tuple:
        return _sequence(get_args(kind), value, where)
    if origin is np.ndarray:
        return _array(value, where)
    return _scalar(kind, value, where)


def _object(kind: Any, value: Any, where: str) -> Any:
    names = {field.name for field in fields(kind)}
    if not isinstance(value, dict) or not names - optional_names(kind) <= set(value) <= names:
        given = sorted(value) if isinstance(value, dict) else type(value).__name__
        raise PlannercheckError(f"{where} must have {', '.join(sorted(names))}, not {given!s:.200}")
    hints = {name: hint for name, hint in _hints(kind).items() if name in value}
    return kind(**{name: _read(hint, value[name], f"{where}, {name}") for name, hint in hints.items()})


def _sequence(kinds: tuple[Any, ...], value: Any, where: str) -> tuple[Any, ...]:
    if not isinstance(value, list):
        raise PlannercheckError(f"{where} must be a list, not {value!r:.60}")
    if kinds[-1] is Ellipsis:
        kinds = (kinds[0],) * len(value)
    if len(kinds) != len(value):
        raise PlannercheckError(f"{where} must have {len(kinds)} items, not {len(value)}")
    return tuple(_read(kind, part, where) for kind, part in zip(kinds, value, strict=True))


def _array(value: Any, where: str) -> Any:
    try:
        given = np.asarray(value)
    except (TypeError, ValueError, OverflowError):
        raise PlannercheckError(f"{where} must be an array of numbers") from None
    if given.dtype.kind not in "iuf":  # numpy would read texts and truths as numbers, and drop imaginary parts
        raise PlannercheckError(f"{where} must be an array of numbers, not of {given.dtype}")
    array = given.astype(np.float64, copy=False)
    array.setflags(write=False)
    return array


def _scalar(kind: Any, value: Any, where: str) -> Any:
    if kind is float and isinstance(value, int) and not isinstance(value, bool) and abs(value) <= 2**53:
        return float(value)
    if type(value) is not kind:
        raise PlannercheckError(f"{where} must be a {kind.__name__}, not {value!r:.60}")
    return checked_name(value, where) if kind is str else value


def checked_name(name: str, where: str) -> str:
    """A name that prints as one line, as what it is.

    Raises:
        PlannercheckError: If it has control characters, line breaks, marks that turn the direction of writing, or parts
            of characters (surrogates): it could forge lines of a report.
    """
    if not name.isprintable():
        raise PlannercheckError(f"{where} must be a name of printable characters, not {name!r:.60}")
    return name
