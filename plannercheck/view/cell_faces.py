"""The outside of many cubes as few rectangles, for fast drawing of a map of a million cells.

In: cubes on a lattice. Out: for each of the six directions, the rectangles that show. Faces that two cubes share are
inside and are left out. The other faces are cut into squares of one step, which are joined along one axis and, if
equally long, along the other.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.arrays import distinct

Whole = NDArray[np.int64]

# Bits of a place along one axis; places are at least 0.
_BITS = 20
_MASK = (1 << _BITS) - 1


def outside(keys: Whole, sizes: Whole) -> list[Whole]:
    """The rectangles that show.

    Args:
        keys: (n, 3) low corners in steps, from 0 to a million; cubes do not overlap.
        sizes: (n,) edges in steps.

    Returns:
        For the directions +x, -x, +y, -y, +z, -z rectangles (m, 5) in steps: the low corner x, y, z, then the lengths
        along the next axis and the one after it, of x, y, z, x, y.
    """
    found = []
    for axis in range(3):
        far = _squares(keys, sizes, axis, sizes)
        near = _squares(keys, sizes, axis, np.zeros_like(sizes))
        found += [
            _rectangles(np.setdiff1d(far, near, assume_unique=True), axis),
            _rectangles(np.setdiff1d(near, far, assume_unique=True), axis),
        ]
    return found


def _squares(keys: Whole, sizes: Whole, axis: int, beyond: Whole) -> Whole:
    """Codes of the unit squares of one face of each cube: which plane, then where along the two other axes."""
    u, v = (axis + 1) % 3, (axis + 2) % 3
    parts = [np.zeros(0, dtype=np.int64)]
    for size in distinct(sizes).tolist():
        of_size = sizes == size
        first = keys[of_size]
        step = np.arange(size)
        plane = (first[:, axis] + beyond[of_size])[:, None, None]
        along, across = first[:, u, None, None] + step, first[:, v, None, None] + step[:, None]
        parts.append((plane << 2 * _BITS | across << _BITS | along).ravel())
    return np.concatenate(parts)


def _rectangles(squares: Whole, axis: int) -> Whole:
    """Rectangles (m, 5) that cover squares, given by sorted codes."""
    begins = np.flatnonzero(np.diff(squares, prepend=-2) != 1)
    length = np.diff(begins, append=len(squares))
    plane, across, along = squares[begins] >> 2 * _BITS, (squares[begins] >> _BITS) & _MASK, squares[begins] & _MASK
    order = np.lexsort((across, length, along, plane))
    plane, across, along, length = (part[order] for part in (plane, across, along, length))
    stacked = np.column_stack([plane, along, length, across - np.arange(len(across))])
    tops = np.flatnonzero((np.diff(stacked, axis=0, prepend=-2) != 0).any(axis=1))
    rows = np.empty((len(tops), 5), dtype=np.int64)
    rows[:, axis], rows[:, (axis + 1) % 3], rows[:, (axis + 2) % 3] = plane[tops], along[tops], across[tops]
    rows[:, 3], rows[:, 4] = length[tops], np.diff(tops, append=len(across))
    return rows
