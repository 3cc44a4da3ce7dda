"""Octrees, as OctoMap makes them: cells of many sizes that are occupied, free, or unknown.

In: cells, or a .bt or .ot file. Out: `Octree`, immutable, one of the shapes of links and obstacles: the union of its
occupied cells and, if the user says so, of the unknown space within the box around all known cells.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.bodies.lattice_cells import LatticeCells, check_extent
from plannercheck.bodies.octomap_files import (
    LEVELS,
    ROOT_LOW,
    ROOT_SIZE,
    OctomapLeaves,
    binary_file,
    leaves_of_data,
    levels_of,
    morton_codes,
    read_octomap,
)
from plannercheck.bodies.part_sets import check_coordinates, checked_length, checked_rows
from plannercheck.bodies.unknown_cells import unknown_cells
from plannercheck.common.array_types import Bools, Ints, Ints64
from plannercheck.common.arrays import read_only, shown_array, unmasked
from plannercheck.common.atomic_files import write_atomically
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.package_data import is_file, why_no_file
from plannercheck.common.public_names import set_module

# What unknown space counts as.
Unknown: TypeAlias = Literal["free", "occupied"]

# What `Octree.query` says of a point.
OCCUPIED, FREE, UNKNOWN = 1, 0, -1


@set_module("plannercheck")
@dataclass(frozen=True, eq=False, repr=False)
class Octree(LatticeCells):
    """A map of cells that are occupied or free; what is in no cell is unknown.

    The lattice is OctoMap's: steps from -32768 to 32767 along each axis; a cell has 1, 2, 4, ... steps an edge and
    begins at a multiple of that. The set is the union of the occupied cells. With `unknown="occupied"` it is all of the
    box around the known cells but the free ones. What is outside of this box is free either way.

    Attributes:
        keys: (n, 3) low corners of the known cells in steps, read-only.
        sizes: (n,) their edges in steps, read-only.
        occupied: (n,) which of them are occupied; the others are free. Read-only.
        resolution: A step in m.
        unknown: What unknown space counts as: "free" or "occupied".
    """

    keys: Ints
    sizes: Ints
    occupied: Bools
    resolution: float
    unknown: Unknown = "free"

    origin = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if self.unknown not in get_args(Unknown):
            raise unknown_name("meaning of unknown space", str(self.unknown), get_args(Unknown))
        object.__setattr__(self, "resolution", checked_length(self.resolution, "resolution of an octree"))
        check_extent([ROOT_SIZE] * 3, self.resolution, [ROOT_LOW * self.resolution] * 3, "octree")
        keys = _whole_numbers(self.keys, "keys of cells")
        keys = keys if keys.size else keys.reshape(0, 3)
        if keys.ndim != 2 or keys.shape[1] != 3:
            raise PlannercheckError(f"keys of cells must have shape (n, 3), not {keys.shape}")
        sizes = _one_each(_whole_numbers(self.sizes, "sizes of cells"), len(keys), "sizes of cells")
        occupied = _one_each(_truth_values(self.occupied), len(keys), "occupied")
        _check_cells(keys, sizes)
        order = np.argsort(morton_codes(keys - ROOT_LOW), kind="stable")
        _check_disjoint(keys[order], sizes[order])
        object.__setattr__(self, "keys", read_only(keys[order].astype(np.int32)))
        object.__setattr__(self, "sizes", read_only(sizes[order].astype(np.int32)))
        object.__setattr__(self, "occupied", read_only(occupied[order]))

    @classmethod
    def from_cells(
        cls,
        keys: ArrayLike,
        resolution: float,
        sizes: ArrayLike = 1,
        occupied: ArrayLike = True,
        unknown: Unknown = "free",
    ) -> Octree:
        """An octree of disjoint cells, in any order.

        Args:
            keys: (n, 3) low corners in steps.
            resolution: A step in m.
            sizes: (n,) or one for all: edges in steps, powers of two that divide the keys.
            occupied: (n,) or one for all: whether a cell is occupied, not free.
            unknown: What unknown space counts as.

        Raises:
            PlannercheckError: If cells overlap, or are none of OctoMap's lattice.
        """
        return cls(keys, sizes, occupied, resolution, unknown)  # type: ignore[arg-type]  # which checks them

    @classmethod
    def load(cls, path: str | Path, unknown: Unknown = "free", threshold: float = 0.5) -> Octree:
        """Loads a map of OctoMap's: a .bt or .ot file, of an OcTree, ColorOcTree or OcTreeStamped.

        Args:
            path: The file; its first line says which of the two it is.
            unknown: What unknown space counts as.
            threshold: From which probability on a cell is occupied; binary files know only occupied and free.

        Raises:
            PlannercheckError: If the file is missing, none of these, cut short or broken.
        """
        if not is_file(Path(path)):
            raise PlannercheckError(f"octomap file {str(path)!r} {why_no_file(Path(path))}")
        try:
            return _of_leaves(read_octomap(Path(path).read_bytes()), unknown, threshold)
        except PlannercheckError as error:
            raise PlannercheckError(f"octomap file {str(path)!r}: {error}") from None
        except OSError as error:
            raise PlannercheckError(f"octomap file {str(path)!r} can't be read: {error.strerror or error}") from None

    @classmethod
    def from_message(
        cls, data: bytes, kind: str, binary: bool, resolution: float, unknown: Unknown = "free", threshold: float = 0.5
    ) -> Octree:
        """The octree of a message octomap_msgs/Octomap.

        Args:
            data: Its field `data`, as bytes.
            kind: Its field `id`, e.g. "OcTree".
            binary: Whether it is a binary tree, as its field says.
            resolution: As its field says, m.
            unknown: What unknown space counts as.
            threshold: As for `load`.
        """
        resolution = checked_length(resolution, "resolution of an octree")
        return _of_leaves(leaves_of_data(data, kind, binary, resolution), unknown, threshold)

    def save(self, path: str | Path) -> None:
        """Writes a .bt file, from which OctoMap reads the same cells.

        Raises:
            PlannercheckError: If the path does not end in .bt, or can't be written.
        """
        if Path(path).suffix.lower() != ".bt":
            raise PlannercheckError(f"octomap file {str(path)!r} must end in .bt, the format that is written")
        content = binary_file(self.keys.astype(np.int64), self.sizes.astype(np.int64), self.occupied, self.resolution)
        write_atomically(Path(path), lambda aside: aside.write_bytes(content))

    def with_unknown(self, unknown: Unknown) -> Octree:
        """The same map with another meaning of unknown space."""
        return self if unknown == self.unknown else replace(self, unknown=unknown)

    @cached_property
    def cells(self) -> tuple[Ints, Ints]:
        """The boxes that collide: low corners (m, 3) and edges (m,), in steps, read-only.

        First the occupied cells, in the order of `keys`; then, if it is occupied, unknown space.
        """
        keys, sizes = self.keys[self.occupied], self.sizes[self.occupied]
        if self.unknown == "occupied" and len(self.keys):
            others = unknown_cells(self.keys.astype(np.int64), self.sizes.astype(np.int64))
            keys = np.concatenate([keys, others[0].astype(np.int32)])
            sizes = np.concatenate([sizes, others[1].astype(np.int32)])
        return read_only(keys), read_only(sizes)

    def query(self, points: ArrayLike) -> NDArray[np.int8]:
        """What is known of points: 1 occupied, 0 free, -1 unknown, whatever that counts as.

        Args:
            points: (n, 3) in the map's frame, m; a point of two cells is in the higher one, as in OctoMap.
        """
        rows = checked_rows(points, "points of a query")
        check_coordinates(rows, "points of a query")
        steps = self.steps_of(rows) - ROOT_LOW
        inside = ((steps >= 0) & (steps < ROOT_SIZE)).all(axis=1)
        found = np.full(len(rows), UNKNOWN, dtype=np.int8)
        if not len(self.keys):
            return found
        codes = morton_codes(steps[inside])
        starts = morton_codes(self.keys - np.int64(ROOT_LOW))
        place = np.searchsorted(starts, codes, side="right") - 1
        held = (place >= 0) & (codes - starts[place] < self.sizes[place].astype(np.int64) ** 3)
        found[inside] = np.where(held, np.where(self.occupied[place], OCCUPIED, FREE), UNKNOWN)
        return found

    def part_name(self, index: int) -> str:
        """Where a box is in the lattice, in steps; unknown space is called so."""
        unknown = "" if index < np.count_nonzero(self.occupied) else "unknown "
        return unknown + super().part_name(index)

    def _hashed(self) -> Sequence[NDArray[Any]]:
        return self.keys, self.sizes, self.occupied, np.array([self.resolution, self.unknown == "occupied"])

    def __reduce__(self) -> tuple[Any, ...]:
        return Octree, (self.keys, self.sizes, self.occupied, self.resolution, self.unknown)

    def __repr__(self) -> str:
        occupied = np.count_nonzero(self.occupied)
        known = f"{occupied} occupied and {len(self.keys) - occupied} free cells"
        return f"Octree({known}, resolution {self.resolution:.4g} m, unknown is {self.unknown})"


def _of_leaves(leaves: OctomapLeaves, unknown: Unknown, threshold: float) -> Octree:
    if not (isinstance(threshold, int | float | np.floating) and 0 < threshold < 1):
        raise PlannercheckError(f"threshold must be a probability between 0 and 1, not {threshold!r}")
    return Octree(leaves.keys, leaves.sizes, leaves.occupied(threshold), leaves.resolution, unknown)


def _whole_numbers(values: ArrayLike, what: str) -> Ints64:
    """Whole numbers that 64 bits hold."""
    array = _array_of(values)
    if array.size and (array.dtype.kind not in "iu" or array.max() > np.iinfo(np.int64).max):
        raise PlannercheckError(f"{what} must be whole numbers, not {shown_array(values)}")
    return array.astype(np.int64)


def _truth_values(values: ArrayLike) -> Bools:
    array = _array_of(values)
    if array.size and (array.dtype.kind not in "biu" or not ((array == 0) | (array == 1)).all()):
        raise PlannercheckError(f"occupied must be truth values, not {shown_array(values)}")
    return array.astype(np.bool_)


def _array_of(values: ArrayLike) -> NDArray[Any]:
    """An array; of no whole number if the values make none."""
    try:
        return np.asarray(unmasked(values))
    except (TypeError, ValueError, OverflowError):
        return np.zeros(1)


def _one_each(values: NDArray[Any], count: int, what: str) -> NDArray[Any]:
    """Values (n,), of as many or of one for all."""
    if values.ndim > 1 or (values.ndim == 1 and len(values) not in (1, count)):
        raise PlannercheckError(f"{what} must be one, or one for each of {count} cells, not of shape {values.shape}")
    return np.broadcast_to(values, (count,))


def _check_cells(keys: Ints64, sizes: Ints64) -> None:
    """Raises unless each cell is one of OctoMap's lattice."""
    if not len(keys):
        return
    power = (sizes >= 1) & (sizes <= ROOT_SIZE) & (sizes & (sizes - 1) == 0)
    inside = ((keys >= ROOT_LOW) & (keys < ROOT_LOW + ROOT_SIZE)).all(axis=1) & power  # so nothing below overflows
    inside[inside] = (keys[inside] + sizes[inside, None] <= ROOT_LOW + ROOT_SIZE).all(axis=1)
    aligned = ((keys - ROOT_LOW) % np.maximum(sizes, 1)[:, None] == 0).all(axis=1)
    bad = np.flatnonzero(~(inside & aligned))
    if len(bad):
        row = int(bad[0])
        raise PlannercheckError(
            f"cell {row} of an octree begins at {keys[row].tolist()} with {sizes[row]} steps an edge: edges are 1, 2, "
            f"4, ... {1 << LEVELS} steps, begin at multiples of that, and lie within {ROOT_LOW} to {-ROOT_LOW}"
        )


def _check_disjoint(keys: Ints64, sizes: Ints64) -> None:
    """Raises if two cells overlap, of which the Morton codes then do; cells are in the codes' order."""
    codes = morton_codes(keys - ROOT_LOW)
    bad = np.flatnonzero(codes[:-1] + (1 << 3 * levels_of(sizes[:-1])) > codes[1:])
    if len(bad):
        first, second = (keys[int(bad[0]) + k].tolist() for k in (0, 1))
        raise PlannercheckError(f"cells of an octree must be disjoint: those at {first} and {second} overlap")
