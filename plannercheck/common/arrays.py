"""Arrays as the core reads them, and arrays that nobody else can change.

The rule of the package: arrays that come in are copied or refused, arrays that go out are read-only or copies.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, TypeAlias, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.common.errors import PlannercheckError

T = TypeVar("T")

# One configuration of a robot: its numbers in order, or the values of its joints by name.
Configuration: TypeAlias = ArrayLike | Mapping[str, ArrayLike]

# Kinds of NumPy's dtypes whose values are doubles as they are, or nearly: floats, integers. Truth values, which NumPy
# would take for 0 and 1, are refused: a mask or a `true` in a file is no number.
_REAL_KINDS = "fiu"
_TRUTHS = frozenset({bool, np.bool_})
_PLAIN_NUMBERS = frozenset({float, int, np.float64})


def read_only(array: NDArray[Any]) -> NDArray[Any]:
    """The array itself, which can't be written to any more: only for arrays that the caller has made."""
    array.setflags(write=False)
    return array


def read_only_copy(values: ArrayLike) -> NDArray[np.float64]:
    """Numbers as float64 in C order that nobody else holds, not to be written to.

    Raises:
        TypeError, ValueError: For what holds no numbers.
    """
    copy = np.array(real_numbers(values), dtype=np.float64, order="C")
    copy.setflags(write=False)
    return copy


def distinct(values: ArrayLike) -> NDArray[Any]:
    """(m,) the values of an array of any shape in ascending order, equal ones once.

    As `np.unique`, which ends the process where the interpreter ends while another thread is in it: its C++ waits for
    Python then, and is never to go on (NumPy 2.3 and later). Besides, its first call imports numpy.ma, for 45 ms.
    """
    in_order = np.sort(np.ravel(values))
    is_first = np.ones(len(in_order), dtype=bool)
    is_first[1:] = in_order[1:] != in_order[:-1]
    return in_order[is_first]


class Groups(NamedTuple):
    """Equal values, or equal rows, of an array: groups in ascending order.

    Attributes:
        first: (m,) where the first of each group is.
        places: (n,) the group of each.
        counts: (m,) how many are in each.
    """

    first: NDArray[np.int64]
    places: NDArray[np.int64]
    counts: NDArray[np.int64]


def grouped(values: NDArray[Any]) -> Groups:
    """The groups of equal values (n,) or rows (n, k)."""
    rows = values if values.ndim > 1 else values[:, None]
    order = np.lexsort(rows.T[::-1])
    in_order = rows[order]
    is_first = np.ones(len(rows), dtype=bool)
    is_first[1:] = (in_order[1:] != in_order[:-1]).any(axis=1)
    places = np.empty(len(rows), dtype=np.int64)
    places[order] = np.cumsum(is_first) - 1
    return Groups(order[is_first], places, np.bincount(places))


def distinct_rows(rows: NDArray[Any]) -> tuple[NDArray[Any], NDArray[np.int64]]:
    """The rows (n, k) sorted, equal ones once, and (n,) the place of each row among them.

    `np.unique` with an axis gives the same in four times the time, as it compares records.
    """
    if _ascend(rows):
        return rows.copy(), np.arange(len(rows))
    groups = grouped(rows)
    return rows[groups.first], groups.places


def _ascend(rows: NDArray[Any]) -> bool:
    """Whether each of some rows (n, k) is before the next one, as where they have been sorted before."""
    before = np.zeros(len(rows[1:]), dtype=bool)
    for column in rows.T[::-1]:
        before = (column[:-1] < column[1:]) | ((column[:-1] == column[1:]) & before)
    return bool(before.all())


def distinct_values(values: NDArray[Any]) -> tuple[NDArray[Any], NDArray[np.int64]]:
    """The values of an array of any shape in ascending order, equal ones once, and (n,) the place of each of them."""
    flat = values.reshape(-1)
    groups = grouped(flat)
    return flat[groups.first], groups.places


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


def named_numbers(values: ArrayLike, what: str, wanted: str = "numbers") -> NDArray[np.float64]:
    """`contiguous`, or an error that names what holds no numbers."""
    try:
        return contiguous(values)
    except (TypeError, ValueError, OverflowError):
        raise PlannercheckError(f"{what} must be {wanted}, not {shown_array(values)}") from None


def configuration_rows(q: ArrayLike, width: int, words: Callable[[], str]) -> NDArray[np.float64]:
    """Configurations (width,) or (n, width) as (n, width), or an error that ends in words on the numbers."""
    array = named_numbers(q, "configurations", "numbers (nq,) or (n, nq)")
    if array.ndim not in (1, 2) or array.shape[-1] != width:
        raise PlannercheckError(
            f"configurations must have shape ({width},) or (n, {width}), not {np.shape(q)}; {words()}"
        )
    # Not reshaped: a robot without joints has configurations of no numbers.
    return array if array.ndim == 2 else array[None]


def real_numbers(values: ArrayLike) -> NDArray[Any]:
    """What NumPy makes of numbers, also of another library's array: by `__array__` or, for want of that, by DLPack.

    Raises:
        TypeError, ValueError: For masked numbers and complex ones, of which NumPy would drop a part, for truth values,
            Python objects, texts, and what holds no numbers at all.
    """
    try:
        array = np.asarray(unmasked(values))
        if array.dtype.kind == "O" and array.ndim == 0 and hasattr(values, "__dlpack__"):
            array = np.from_dlpack(cast(Any, values))
    except (RuntimeError, BufferError) as error:  # tensors that are elsewhere, or record what is done with them
        raise TypeError(str(error)) from error
    if array.dtype.kind not in _REAL_KINDS:
        raise TypeError(f"an array of dtype {array.dtype} holds no real numbers")
    if isinstance(values, list | tuple) and truth_in(values):
        raise TypeError("a truth value is no real number")
    return array


def truth_in(values: Sequence[Any]) -> list[int]:
    """The indices of the first truth value in nested lists; none if there is none."""
    if _PLAIN_NUMBERS.issuperset(map(type, values)):
        return []
    for k, item in enumerate(values):
        if type(item) in _TRUTHS or (isinstance(item, np.ndarray) and item.dtype.kind == "b"):
            return [k]
        found = truth_in(item) if isinstance(item, list | tuple) else []
        if found:
            return [k, *found]
    return []


class MaskedError(PlannercheckError, TypeError):
    """An array has masked numbers."""


def unmasked(values: T) -> T:
    """The same, unless something in it is masked: NumPy would go on with the numbers under a mask.

    Raises:
        MaskedError: If something is masked in an array, or in the arrays of a list.
    """
    if _has_masked(values):
        raise MaskedError("an array with masked numbers has no number there: fill them in, or leave these rows out")
    return values


def _has_masked(values: object) -> bool:
    # Nobody has a masked array without numpy.ma, whose import would take 45 ms.
    masked_array = getattr(sys.modules.get("numpy.ma"), "MaskedArray", None)
    if masked_array is None or type(values) is np.ndarray:
        return False
    if isinstance(values, masked_array):
        return bool(np.any(values.mask))
    return isinstance(values, list | tuple) and any(map(_has_masked, values))


def axes(values: ArrayLike) -> int:
    """How many axes an array has; -1 for rows of different lengths."""
    try:
        return int(np.ndim(values))
    except ValueError:
        return -1


def row_length(rows: ArrayLike) -> int:
    """The length of an array's last axis; 0 for numbers and for rows of different lengths."""
    try:
        return int(np.shape(rows)[-1])
    except (ValueError, IndexError):
        return 0


def shown_array(values: object) -> str:
    """Words of an error for what is no array of real numbers: its beginning, and the dtype if it has one."""
    if _has_masked(values):
        return "an array with masked numbers: fill them in, or leave these rows out"
    if isinstance(values, list | tuple) and (place := truth_in(values)):
        return f"a truth value at {place}: write 1 or 0 if a number is meant"
    dtype = getattr(values, "dtype", None)
    return f"{values!r:.80}" if dtype is None else f"an array of dtype {dtype}: {values!r:.80}"
