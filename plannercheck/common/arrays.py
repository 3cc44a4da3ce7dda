"""Arrays as the core reads them, and arrays that nobody else can change.

The rule of the package: arrays that come in are copied or refused, arrays that go out are read-only or copies.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

# One configuration of a robot: its numbers in order, or the values of its joints by name.
Configuration: TypeAlias = ArrayLike | Mapping[str, ArrayLike]

# Kinds of NumPy's dtypes whose values are doubles as they are, or nearly: floats, integers, truth values.
_REAL_KINDS = "fiub"


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """The array itself, which can't be written to any more: only for arrays that the caller has made."""
    array.setflags(write=False)
    return array


def read_only_copy(values: ArrayLike) -> NDArray[np.float64]:
    """Numbers as float64 in C order that nobody else holds, not to be written to.

    Raises:
        TypeError, ValueError: For what holds no numbers.
    """
    copy = np.array(values, dtype=np.float64, order="C")
    copy.setflags(write=False)
    return copy


def distinct_rows(rows: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """The rows (n, k) sorted, equal ones once, and (n,) the place of each row among them.

    `np.unique` with an axis gives the same in four times the time, as it compares records.
    """
    order = np.lexsort(rows.T[::-1])
    sorted_rows = rows[order]
    is_first = np.ones(len(rows), dtype=bool)
    is_first[1:] = (sorted_rows[1:] != sorted_rows[:-1]).any(axis=1)
    places = np.empty(len(rows), dtype=np.int64)
    places[order] = np.cumsum(is_first) - 1
    return sorted_rows[is_first], places


class OwnsArrays:
    """A base of frozen dataclasses whose arrays nobody can write to: those that somebody could are copied."""

    def __post_init__(self) -> None:
        for name, value in list(vars(self).items()):
            if isinstance(value, np.ndarray):
                object.__setattr__(self, name, _own(value))
            elif isinstance(value, tuple) and any(isinstance(item, np.ndarray) for item in value):
                object.__setattr__(self, name, tuple(map(_own, value)))


def _own(value: Any) -> Any:
    writeable = isinstance(value, np.ndarray) and value.flags.writeable
    return read_only(value.copy()) if writeable else value


def contiguous(values: ArrayLike) -> NDArray[np.float64]:
    """Numbers as float64 in C order, the given array itself if it is so.

    Those at odd addresses, as in messages and in records of files, are copied: the core reads whole doubles.

    Raises:
        TypeError, ValueError: For what holds no real numbers.
    """
    array = np.ascontiguousarray(real_numbers(values), dtype=np.float64)
    return array if array.flags.aligned else array.copy()


def real_numbers(values: ArrayLike) -> NDArray[Any]:
    """What NumPy makes of numbers, also of another library's array: by `__array__` or, for want of that, by DLPack.

    Raises:
        TypeError, ValueError: For complex numbers, of which NumPy would drop a part, for Python objects, texts, and
            what holds no numbers at all.
    """
    try:
        array = np.asarray(values)
        if array.dtype.kind == "O" and array.ndim == 0 and hasattr(values, "__dlpack__"):
            array = np.from_dlpack(cast(Any, values))
    except (RuntimeError, BufferError) as error:  # tensors that are elsewhere, or record what is done with them
        raise TypeError(str(error)) from error
    if array.dtype.kind not in _REAL_KINDS:
        raise TypeError(f"an array of dtype {array.dtype} holds no real numbers")
    return array


def shown_array(values: object) -> str:
    """Words of an error for what is no array of real numbers: its beginning, and the dtype if it has one."""
    dtype = getattr(values, "dtype", None)
    return f"{values!r:.80}" if dtype is None else f"an array of dtype {dtype}: {values!r:.80}"
