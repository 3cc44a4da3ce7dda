"""Voxel grids: boxes of one size in rows, columns and layers.

In: which cells are occupied, their edge in m, and where the grid begins. Out: `VoxelGrid`, immutable, one of the shapes
of links and obstacles. Full blocks of 2 x 2 x 2 cells become one box, and so on, which keeps the set.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.bodies.array_files import array_of_file
from plannercheck.bodies.lattice_cells import LatticeCells, check_extent
from plannercheck.bodies.part_sets import check_coordinates, checked_length, checked_offset, checked_rows
from plannercheck.common.array_types import Bools, Ints, Ints64
from plannercheck.common.arrays import read_only, shown_array, unmasked
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.public_names import set_module


@set_module("plannercheck")
@dataclass(frozen=True, eq=False, repr=False)
class VoxelGrid(LatticeCells):
    """A grid of cubes, some of which are occupied: the union of these.

    Attributes:
        occupied: (i, j, k) which cells are occupied, along x, y and z; read-only.
        resolution: Edge of a cell, m.
        origin: (3,) m, the low corner of cell (0, 0, 0).
    """

    occupied: Bools
    resolution: float
    origin: tuple[float, ...] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "occupied", _checked_cells(self.occupied))
        object.__setattr__(self, "resolution", checked_length(self.resolution, "resolution of a voxel grid"))
        object.__setattr__(self, "origin", checked_offset(self.origin, "origin of a voxel grid", 3))
        check_extent(self.occupied.shape, self.resolution, self.origin, "voxel grid")

    @classmethod
    def load(cls, path: str | Path, resolution: float, origin: ArrayLike = (0.0, 0.0, 0.0)) -> VoxelGrid:
        """Loads an npy file (i, j, k) of truth values, or of whole numbers 0 and 1.

        Raises:
            PlannercheckError: If the file is missing or broken, or holds something else.
        """
        return cls(array_of_file(Path(path), "voxel file"), resolution, origin)  # type: ignore[arg-type]

    @cached_property
    def cells(self) -> tuple[Ints, Ints]:
        """The boxes: low corners (n, 3) and edges (n,), in cells, read-only; full blocks are one box."""
        keys: list[Ints64] = []
        sizes: list[Ints64] = []
        full, size = self.occupied, 1
        while full.any():
            merged = _full_blocks(full)
            alone = np.argwhere(full & ~_spread(merged, full.shape))
            keys.append(alone * size)
            sizes.append(np.full(len(alone), size, dtype=np.int64))
            full, size = merged, 2 * size
        low = np.concatenate([np.zeros((0, 3), dtype=np.int64), *keys]).astype(np.int32)
        return read_only(low), read_only(np.concatenate([np.zeros(0, dtype=np.int64), *sizes]).astype(np.int32))

    def query(self, points: ArrayLike) -> Bools:
        """(n,) whether points (n, 3), m, in the grid's frame, are in an occupied cell; a face is the higher's."""
        rows = checked_rows(points, "points of a query")
        check_coordinates(rows, "points of a query")
        steps = self.steps_of(rows)
        inside = ((steps >= 0) & (steps < self.occupied.shape)).all(axis=1)
        found = np.zeros(len(rows), dtype=np.bool_)
        found[inside] = self.occupied[tuple(steps[inside].T)]
        return found

    def __reduce__(self) -> tuple[Any, ...]:
        return VoxelGrid, (self.occupied, self.resolution, self.origin)

    def __repr__(self) -> str:
        shape = " x ".join(map(str, self.occupied.shape))
        return f"VoxelGrid({shape} cells of {self.resolution:.4g} m, {np.count_nonzero(self.occupied)} occupied)"


def _full_blocks(full: Bools) -> Bools:
    """Which blocks of 2 x 2 x 2 cells are full; cells that are left over at the ends have no block."""
    even = [length // 2 * 2 for length in full.shape]
    blocks = full[: even[0], : even[1], : even[2]]
    blocks = blocks[0::2] & blocks[1::2]
    blocks = blocks[:, 0::2] & blocks[:, 1::2]
    return np.asarray(blocks[:, :, 0::2] & blocks[:, :, 1::2])


def _spread(blocks: Bools, shape: tuple[int, ...]) -> Bools:
    """(shape) whether each cell is in a block."""
    cells = np.zeros(shape, dtype=np.bool_)
    inner = blocks.repeat(2, axis=0).repeat(2, axis=1).repeat(2, axis=2)
    cells[: inner.shape[0], : inner.shape[1], : inner.shape[2]] = inner
    return cells


def _checked_cells(values: ArrayLike) -> Bools:
    try:
        given = np.asarray(unmasked(values))
    except (TypeError, ValueError, OverflowError):
        raise PlannercheckError(f"cells of a voxel grid must have shape (i, j, k), not {shown_array(values)}") from None
    if given.ndim != 3 or given.dtype.kind not in "biu":
        raise PlannercheckError(
            f"cells of a voxel grid must be truth values of shape (i, j, k), not {given.dtype} of shape {given.shape}"
        )
    if given.dtype.kind != "b" and given.size and not (given.min() >= 0 and given.max() <= 1):
        raise PlannercheckError(
            "cells of a voxel grid must be 0 (free) or 1 (occupied); compare with a threshold first"
        )
    if given.dtype.kind == "b" and not given.flags.writeable and given.flags.c_contiguous:
        return given
    return read_only(np.array(given, dtype=np.bool_, order="C"))
