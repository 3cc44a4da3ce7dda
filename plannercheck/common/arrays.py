"""Arrays as the core reads them, and arrays that nobody else can change.

The rule of the package: arrays that come in are copied or refused, arrays that go out are read-only or copies.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray


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
        TypeError, ValueError: For what holds no numbers.
    """
    array = np.ascontiguousarray(values, dtype=np.float64)
    return array if array.flags.aligned else array.copy()
