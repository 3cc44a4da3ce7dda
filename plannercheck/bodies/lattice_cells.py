"""Cells of a lattice: what octrees and voxel grids are made of.

In: low corners and sizes in steps, the step's length, and where the lattice begins. Out: `LatticeCells`, a part set of
boxes. A box reaches from fl(origin + fl(key * resolution)) to fl(origin + fl((key + size) * resolution)) along each
axis, so neighbours share their faces exactly.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.bodies.core_polytopes import LARGEST_COORDINATE
from plannercheck.bodies.part_sets import PartSet, compiled_part_set
from plannercheck.common.array_types import Floats, Ints
from plannercheck.common.errors import PlannercheckError

# The farthest steps of a cell from the lattice's origin, as the core holds them.
MOST_STEPS = 2**31 - 1


class LatticeCells(PartSet):
    """Boxes of whole steps of a lattice."""

    resolution: float
    origin: tuple[float, ...]

    @property
    @abstractmethod
    def cells(self) -> tuple[Ints, Ints]:
        """The boxes that collide: low corners (n, 3) and edges (n,), in steps, read-only."""

    @property
    def count(self) -> int:
        """The number of boxes."""
        return len(self.cells[1])

    def boxes(self) -> tuple[Floats, Floats]:
        """The low and the high corners (n, 3) of the boxes, m; exactly the doubles that are tested."""
        keys, sizes = self.cells
        return self.corners(keys), self.corners(keys + sizes[:, None])

    def corners(self, steps: NDArray[np.integer[Any]]) -> Floats:
        """Where steps (..., 3) of the lattice are, m."""
        places: Floats = np.asarray(self.origin) + steps * self.resolution
        return places

    def steps_of(self, points: Floats) -> NDArray[np.int64]:
        """The cell (n, 3) of one step that holds each point (n, 3), m; a point of two cells is in the higher one."""
        with np.errstate(over="ignore", invalid="ignore"):
            near = np.floor((points - np.asarray(self.origin)) / self.resolution)
        steps: NDArray[np.int64] = np.clip(near, -MOST_STEPS, MOST_STEPS).astype(np.int64)
        steps += self.corners(steps + 1) <= points  # what the division has rounded
        steps -= self.corners(steps) > points
        return steps

    def part_name(self, index: int) -> str:
        """Where a box is in the lattice: "(3, 4, 5)", or "(0:4, 4:8, 8:12)" for one of several steps."""
        keys, sizes = self.cells
        key, size = keys[index].tolist(), int(sizes[index])
        if size == 1:
            return f"({key[0]}, {key[1]}, {key[2]})"
        return f"({', '.join(f'{step}:{step + size}' for step in key)})"

    def _bounds(self) -> Sequence[ArrayLike]:
        keys, sizes = self.cells
        return self.corners(keys.min(axis=0)), self.corners((keys + sizes[:, None]).max(axis=0))

    def _core(self) -> Any:
        return compiled_part_set().cells(*self.cells, self.resolution, np.asarray(self.origin, dtype=np.float64))

    def _hashed(self) -> Sequence[NDArray[Any]]:
        return *self.cells, np.array([self.resolution, *self.origin])


def check_extent(shape: Sequence[int], resolution: float, origin: Sequence[float], what: str) -> None:
    """Raises if steps of a lattice have places that are too far or not distinct, or are too many."""
    if max(shape) > MOST_STEPS:
        raise PlannercheckError(f"{what} has {max(shape)} steps along an axis, there can be {MOST_STEPS}")
    for start, steps in zip(origin, shape, strict=True):
        end = start + steps * resolution
        if not (abs(end) <= LARGEST_COORDINATE and end - (end - resolution) > 0 and (start + resolution) - start > 0):
            raise PlannercheckError(
                f"{what}: steps of {resolution} m from {start} m on are no different places, or reach beyond "
                f"{LARGEST_COORDINATE:g} m"
            )
