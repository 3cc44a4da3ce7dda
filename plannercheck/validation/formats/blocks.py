"""Blocks of rows, which the readers of all formats produce.

In: arrays of a file. Out: `RowBlock`s of at most a given number of rows, (n, nq) in the robot's order, in the file's
own units. Each has the part of the file that has been read, for progress.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.validation.formats.columns import Columns, WidthError

# The usual names of the array of configurations, for files that hold several arrays.
KEYS = ("q", "configurations")

# The name of the array or attribute that lists the columns' names.
NAMES_KEY = "joint_names"


class RowBlock(NamedTuple):
    """Consecutive rows of a file.

    Attributes:
        rows: (n, nq) float64 of its own memory.
        part: Part of the file that has been read with this block, 0 to 1; None if unknown.
    """

    rows: Floats
    part: float | None


def chosen_key(names: list[str], wanted: str | None, kind: str) -> str:
    """Which of several arrays to take: the wanted one, the only one, or one with the usual name."""
    if wanted is not None:
        if wanted not in names:
            raise PlannercheckError(f"has no {kind} {wanted!r}; it holds {', '.join(names) or 'none'}")
        return wanted
    if len(names) == 1:
        return names[0]
    found = [key for key in KEYS if key in names]
    if not found:
        held = ", ".join(names) or "nothing"
        raise PlannercheckError(
            f"must hold one {kind}, or one named {' or '.join(KEYS)}; it holds {held}; --key says which"
        )
    return found[0]


def check_real(dtype: np.dtype[Any]) -> None:
    """Raises unless an array's numbers are real."""
    if dtype.kind not in "fiu":
        raise PlannercheckError(f"must hold real numbers, not {dtype}")


def table_shape(shape: tuple[int, ...], columns: Columns, width: int | None = None) -> tuple[int, int]:
    """The shape as (n, nq), or (n, width); a single configuration (nq,) is one row."""
    wanted = columns.width if width is None else width
    rows = (1, *shape) if len(shape) == 1 else shape
    if len(rows) != 2 or rows[1] != wanted or rows[0] < 0:
        is_turned = len(rows) == 2 and rows[0] == wanted
        hint = "it looks transposed: a configuration is a row, numpy's .T makes it one; " if is_turned else ""
        raise WidthError(f"must have shape (n, {wanted}), not {shape}; {hint}{columns.listed}")
    if width is None:
        columns.check_nameless()
    return rows[0], rows[1]


def places_of(names: Iterable[Any] | None, columns: Columns) -> list[int] | None:
    """Where the joints are among an array's columns; None if the array does not name them."""
    if names is None:
        return None
    return columns.places([name.decode() if isinstance(name, bytes) else str(name) for name in names])


def check_unread_names(where: str, texts: Iterable[Any], columns: Columns) -> None:
    """Raises if texts beside an array without names are the joints' names in another order than the robot's."""
    found = [text.decode(errors="replace") if isinstance(text, bytes) else str(text) for text in texts]
    if sorted(found) == sorted(columns.names) and found != list(columns.names):
        raise PlannercheckError(f"names joints in {where!r}, which is not read: call it {NAMES_KEY!r}")


def stacked(records: NDArray[Any], names: Sequence[str]) -> Floats:
    """Records (n,) with a field a joint as rows (n, nq), fields in this order."""
    return np.stack([records[name].astype(np.float64) for name in names], axis=1)


def fields_of(dtype: np.dtype[Any], columns: Columns) -> list[str] | None:
    """The fields of records that are the joints', in the robot's order; None if the numbers have no names."""
    if dtype.names is None:
        check_real(dtype)
        return None
    chosen = [dtype.names[place] for place in columns.places(dtype.names)]
    for name in chosen:
        check_real(dtype[name])
    return chosen


def even(blocks: Iterable[RowBlock], size: int, width: int) -> Iterator[RowBlock]:
    """The same rows in blocks of `size`, the last one shorter: some formats come in pieces of their own."""
    held: list[Floats] = []
    count, part = 0, None
    for rows, part in blocks:
        held.append(rows)
        count += len(rows)
        if count >= size:
            joined = np.concatenate(held) if len(held) > 1 else held[0]
            whole = count // size * size
            for first in range(0, whole, size):
                yield RowBlock(joined[first : first + size], part)
            held, count = [joined[whole:]], count - whole
    if count:
        yield RowBlock(np.concatenate([np.empty((0, width)), *held]), part)
