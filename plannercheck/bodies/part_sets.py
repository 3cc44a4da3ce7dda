"""Part sets: bodies that are the union of many small convex parts of one kind.

In: arrays from a sensor or a map. Out: `PartSet`, the base of clouds of points (balls), octrees and voxel grids (boxes)
and height fields (prisms). Such a body is never expanded into shapes: the core holds its parts in one tree.
"""

from __future__ import annotations

import hashlib
from abc import ABC, abstractmethod
from collections.abc import Sequence
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.bodies.circumscribed import BOX_SIGNS, prism_faces
from plannercheck.bodies.core_polytopes import LARGEST_COORDINATE
from plannercheck.bodies.kinds import Kind
from plannercheck.common.array_types import Faces, Floats
from plannercheck.common.arrays import distinct_rows, read_only, real_numbers, shown_array, unmasked
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError

# Most parts of a set: the core numbers them by 32 bits.
MOST_PARTS = 2**31 - 1


class PartSet(ABC):
    """The union of many convex parts of one kind; a set without parts is empty, and collides with nothing."""

    body_kind: ClassVar[Kind] = "part_set"

    @property
    @abstractmethod
    def count(self) -> int:
        """The number of parts."""

    @cached_property
    def bounds(self) -> Floats:
        """(2, 3) in m: the low and the high corner of a box that holds all parts, rounded outwards.

        Raises:
            PlannercheckError: If there are no parts.
        """
        if self.count == 0:
            raise PlannercheckError(f"{self!r} has no parts, so it has no bounds")
        return read_only(np.array(self._bounds(), dtype=np.float64))

    @cached_property
    def core(self) -> Any:
        """The compiled set with its tree of parts, for the rest of the library."""
        if self.count > MOST_PARTS:
            raise PlannercheckError(f"{self!r}: a body has at most {MOST_PARTS} parts")
        return self._core()

    @cached_property
    def digest(self) -> bytes:
        """A hash of the set: equal for sets of the same parts in the same order."""
        made = hashlib.sha256(type(self).__name__.encode())
        for array in self._hashed():
            made.update(repr((array.shape, array.dtype.str)).encode())
            made.update(np.ascontiguousarray(array).data)
        return made.digest()

    def vertices_and_faces(self, excess: float = 0.0) -> tuple[Floats, Faces | None]:
        """The corners (8, 3) in m of the box `bounds` and its faces, whatever the excess; flat boxes have no faces.

        Of an empty set this is the origin, where a checker keeps it.
        """
        if self.count == 0:
            return np.zeros((1, 3)), None
        low, high = self.bounds
        corners = np.where(BOX_SIGNS > 0, high, low)
        flat = bool((low == high).any())
        return (distinct_rows(corners)[0], None) if flat else (corners, prism_faces(4))

    @abstractmethod
    def part_name(self, index: int) -> str:
        """What reports call a part, by its number in the core: `camera[17]`, `map[(3, 4, 5)]`."""

    @abstractmethod
    def _bounds(self) -> Sequence[ArrayLike]:
        """The low and the high corner, of a set that has parts."""

    @abstractmethod
    def _core(self) -> Any:
        """The compiled set."""

    @abstractmethod
    def _hashed(self) -> Sequence[NDArray[Any]]:
        """The arrays that make the set what it is."""


def compiled_part_set() -> Any:
    """The core's class of part sets."""
    return core.PartSet


def checked_rows(values: ArrayLike, what: str) -> Floats:
    """A copy of rows (n, 3) of numbers, which need not be finite; an empty list is no rows."""
    try:
        given = real_numbers(values)
        rows = np.array(given, dtype=np.float64, order="C") if given.size else np.zeros((0, 3))
    except (TypeError, ValueError, OverflowError):
        raise PlannercheckError(f"{what} must be numbers of shape (n, 3), not {shown_array(values)}") from None
    if rows.ndim != 2 or rows.shape[1] != 3:
        raise PlannercheckError(f"{what} must have shape (n, 3), not {rows.shape}")
    return rows


def usable(rows: Floats) -> bool:
    """Whether all numbers are finite and at most `LARGEST_COORDINATE`, found without another array."""
    return not rows.size or bool(rows.min() >= -LARGEST_COORDINATE and rows.max() <= LARGEST_COORDINATE)


def check_coordinates(rows: Floats, what: str, hint: str = "") -> None:
    """Raises for the first row with a number that is not finite, or beyond `LARGEST_COORDINATE`."""
    if usable(rows):
        return
    bad = np.flatnonzero(~np.isfinite(rows).all(axis=1))
    if not len(bad):
        raise PlannercheckError(f"{what}: coordinates must be at most {LARGEST_COORDINATE:g} m in size")
    others = f", and {len(bad) - 1} more are so" if len(bad) > 1 else ""
    row = int(bad[0])
    raise PlannercheckError(f"{what}: row {row} is {rows[row].tolist()}{others}: coordinates must be finite{hint}")


def checked_length(value: float, what: str) -> float:
    """A length in m that is more than 0."""
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise PlannercheckError(f"{what} must be a length in m, not {value!r:.80}") from None
    if not 0 < number <= LARGEST_COORDINATE:
        raise PlannercheckError(f"{what} must be a length in m above 0, not {number!r}")
    return number


def checked_offset(values: ArrayLike, what: str, count: int) -> tuple[float, ...]:
    """Finite numbers (count,) in m."""
    try:
        array = np.asarray(unmasked(values), dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise PlannercheckError(f"{what} must be {count} numbers in m, not {values!r:.80}") from None
    if array.shape != (count,) or not (np.abs(array) <= LARGEST_COORDINATE).all():
        raise PlannercheckError(f"{what} must be {count} finite numbers in m, not {values!r:.80}")
    return tuple(float(number) for number in array + 0.0)
