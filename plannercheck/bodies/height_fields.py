"""Height fields: terrain as heights over a grid of places, filled down to a base.

In: heights in m, the grid's steps, and a base. Out: `HeightField`, immutable, one of the shapes of links and obstacles.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.bodies.array_files import array_of_file
from plannercheck.bodies.core_polytopes import LARGEST_COORDINATE
from plannercheck.bodies.lattice_cells import check_extent
from plannercheck.bodies.part_sets import PartSet, checked_length, checked_offset, compiled_part_set
from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.arrays import read_only, real_numbers, shown_array
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.public_names import set_module


@set_module("plannercheck")
@dataclass(frozen=True, eq=False, repr=False)
class HeightField(PartSet):
    """A surface over a grid, and all that is between it and its base.

    The surface's vertices are (origin[0] + i * step[0], origin[1] + j * step[1], heights[i, j]), as doubles round them.
    Each square of four vertices has two triangles, on either side of the diagonal from (i, j) to (i + 1, j + 1). The
    set is the union of the prisms between a triangle and the base. A height that is NaN is a hole: the triangles at
    that vertex, and what is below them, are missing.

    Attributes:
        heights: (i, j) in m along x and y, at least 2 x 2, read-only; floats and integers of any size become doubles.
        resolution: The steps along x and y, m; one number stands for both.
        base: The height of the flat lower side, m: at most the lowest height.
        origin: (2,) m, where heights[0, 0] is.
    """

    heights: Floats
    resolution: tuple[float, float]
    base: float
    origin: tuple[float, ...] = (0.0, 0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "heights", _checked_heights(self.heights))
        steps: Any = np.asarray(self.resolution)
        given: list[Any] = [self.resolution] * 2 if steps.ndim == 0 else list(steps.tolist())
        if len(given) != 2:
            raise PlannercheckError(f"resolution of a height field must be one or two lengths, not {len(given)}")
        object.__setattr__(
            self, "resolution", tuple(checked_length(each, "resolution of a height field") for each in given)
        )
        object.__setattr__(self, "origin", checked_offset(self.origin, "origin of a height field", 2))
        (base,) = checked_offset([self.base], "base of a height field", 1)
        object.__setattr__(self, "base", base)
        for axis in (0, 1):
            check_extent(
                self.heights.shape[axis : axis + 1],
                self.resolution[axis],
                self.origin[axis : axis + 1],
                "height field",
            )
        lowest = float(np.fmin.reduce(self.heights, axis=None))
        if lowest < base:
            raise PlannercheckError(
                f"base of a height field must be at most its lowest height, {lowest} m, not {base} m: the set is what "
                "is between the surface and the base"
            )

    @classmethod
    def load(
        cls,
        path: str | Path,
        resolution: float | tuple[float, float],
        base: float,
        origin: tuple[float, float] = (0.0, 0.0),
    ) -> HeightField:
        """Loads an npy file (i, j) of heights in m.

        Raises:
            PlannercheckError: If the file is missing or broken, or holds something else.
        """
        return cls(array_of_file(Path(path), "height file"), resolution, base, origin)  # type: ignore[arg-type]

    @cached_property
    def holes(self) -> int:
        """How many heights are missing."""
        return int(np.count_nonzero(np.isnan(self.heights)))

    @cached_property
    def count(self) -> int:
        """The number of prisms: two a square, less those at holes."""
        squares = (self.heights.shape[0] - 1) * (self.heights.shape[1] - 1)
        return 2 * squares if self.holes == 0 else int(sum(np.count_nonzero(each) for each in self._present))

    @property
    def _present(self) -> tuple[Bools, Bools]:
        """Which squares have their first and their second triangle."""
        known: Bools = np.asarray(~np.isnan(self.heights))
        diagonal: Bools = known[:-1, :-1] & known[1:, 1:]
        return diagonal & known[1:, :-1], diagonal & known[:-1, 1:]

    def part_name(self, index: int) -> str:
        """Which square a prism is in, and on which side of its diagonal: "(3, 4) x", the side of (i + 1, j), or "y".

        Args:
            index: 2 * (i * (columns - 1) + j), and 1 more for the side of (i, j + 1); holes are counted, too.
        """
        square, side = divmod(index, 2)
        i, j = divmod(square, self.heights.shape[1] - 1)
        return f"({i}, {j}) {'xy'[side]}"

    def surface_height(self, points: ArrayLike) -> Floats:
        """(n,) the surface's height in m at places (n, 2), m, up to rounding; NaN at holes and outside of the grid."""
        places = (np.asarray(points, dtype=np.float64).reshape(-1, 2) - self.origin) / self.resolution
        last = np.array(self.heights.shape) - 1
        inside: Bools = np.asarray(((places >= 0) & (places <= last)).all(axis=1))
        square = np.clip(np.floor(np.where(inside[:, None], places, 0)), 0, last - 1).astype(np.int64)
        x, y = (places - square).T
        i, j = square.T
        low, high = self.heights[i, j], self.heights[i + 1, j + 1]
        corner = np.where(x >= y, self.heights[i + 1, j], self.heights[i, j + 1])
        first, second = np.maximum(x, y), np.minimum(x, y)
        found = low + first * (corner - low) + second * (high - corner)
        return np.asarray(np.where(inside, found, np.nan))

    def triangles(self) -> Floats:
        """(n, 3, 3) the corners of the surface's triangles, m, exactly the doubles that are tested; holes left out.

        Both triangles of a square are at the diagonal from (i, j) to (i + 1, j + 1).
        """
        rows, columns = self.heights.shape
        x = self.origin[0] + np.arange(rows) * self.resolution[0]
        y = self.origin[1] + np.arange(columns) * self.resolution[1]
        top = np.stack([*np.meshgrid(x, y, indexing="ij"), self.heights], axis=-1)
        first, last = top[:-1, :-1], top[1:, 1:]
        triangles = np.concatenate(
            [np.stack([first, other, last], axis=2).reshape(-1, 3, 3) for other in (top[1:, :-1], top[:-1, 1:])]
        )
        known: Floats = triangles[~np.isnan(triangles).any(axis=(1, 2))]
        return known

    def _bounds(self) -> Sequence[ArrayLike]:
        ends = [self.origin[axis] + (self.heights.shape[axis] - 1) * self.resolution[axis] for axis in (0, 1)]
        return [*self.origin, self.base], [*ends, float(np.fmax.reduce(self.heights, axis=None))]

    def _core(self) -> Any:
        return compiled_part_set().columns(self.heights, np.array(self.resolution), np.array(self.origin), self.base)

    def _hashed(self) -> Sequence[NDArray[Any]]:
        return self.heights, np.array([*self.resolution, self.base, *self.origin])

    def __reduce__(self) -> tuple[Any, ...]:
        return HeightField, (self.heights, self.resolution, self.base, self.origin)

    def __repr__(self) -> str:
        shape = " x ".join(map(str, self.heights.shape))
        holes = f", {self.holes} holes" if self.holes else ""
        return f"HeightField({shape} heights, base {self.base:.4g} m{holes})"


def _checked_heights(values: ArrayLike) -> Floats:
    """Heights as doubles that nobody writes to: an array that is so already is not copied, since it may be large."""
    try:
        given = real_numbers(values)
    except (TypeError, ValueError, OverflowError):
        raise PlannercheckError(
            f"heights of a height field must be numbers of shape (i, j), not {shown_array(values)}"
        ) from None
    if given.ndim != 2 or min(given.shape) < 2:
        raise PlannercheckError(
            f"heights of a height field must have shape (i, j), at least (2, 2), not {given.shape} of {given.dtype}"
        )
    largest = np.fmax.reduce(np.array([np.fmax.reduce(given, axis=None), -np.fmin.reduce(given, axis=None)]))
    if not (np.isnan(largest) or largest <= LARGEST_COORDINATE):
        raise PlannercheckError(
            f"heights of a height field must be finite and at most {LARGEST_COORDINATE:g} m in size; NaN is a hole"
        )
    if given.dtype == np.float64 and given.flags.c_contiguous and given.flags.aligned and not given.flags.writeable:
        return given
    return read_only(np.array(given, dtype=np.float64, order="C"))
