"""Balls that other balls contain: what a cloud of points may leave out.

In: points (n, 3) and radii (n,) in m. Out: the rows to keep, and radii for them. A ball (p, r) lies in a ball (q, R) if
|p - q| + r <= R. Every such statement here is proved with room for rounding and for poses: an accepted pose may stretch
a distance by a few parts in a million, while radii stay the same.
"""

from __future__ import annotations

import math

import numpy as np

from plannercheck.common.array_types import Bools, Floats, Ints64
from plannercheck.common.arrays import distinct, grouped
from plannercheck.common.errors import PlannercheckError

# How far a pose may stretch a distance: twice and more what bodies' poses are held to (`POSED_TOLERANCE` of shapes.py).
_STRETCH = 1 + 1e-5

# Relative and absolute errors of a distance in doubles: seven roundings of 2^-53 each, and squares that underflow.
_RELATIVE, _ABSOLUTE = 1 + 2.0**-49, 1e-160

# How many sizes of cells are tried for balls that contain others: each half of the size before.
_SIZES = 5


def longest_distance(p: Floats, q: Floats) -> Floats:
    """No less than the distances (n,) in m between points (n, 3) at any accepted pose."""
    difference = p - q
    distances: Floats = np.sqrt(np.einsum("ij,ij->i", difference, difference)) * (_RELATIVE * _STRETCH) + _ABSOLUTE
    return distances


def uncovered(points: Floats, radii: Floats) -> Ints64:
    """Rows of balls to keep: those left out are surely inside another ball, which is larger or, if equal, earlier.

    So no two balls leave each other out, and whatever contains a ball that is left out is kept or inside one that is.
    """
    if not len(points):
        return np.zeros(0, dtype=np.int64)
    order = np.lexsort((np.arange(len(points)), -radii))  # large balls first, of equal ones the earlier
    points, radii = points[order], radii[order]
    kept = _first_of_equal(points)
    spread = float(radii[0] - radii[-1])
    for halving in range(_SIZES if spread > 0 else 0):
        kept &= ~_covered_in_cells(points, radii, spread / 2**halving)
    return np.sort(order[kept])


def _first_of_equal(points: Floats) -> Bools:
    """Whether each point is the first of its place, whose ball is the largest there."""
    first = np.zeros(len(points), dtype=np.bool_)
    first[_first_rows(points)[0]] = True
    return first


def _covered_in_cells(points: Floats, radii: Floats, edge: float) -> Bools:
    """Which balls the largest ball of their own cell or of a neighbour cell contains; large balls come first."""
    cells = _cells(points, edge)
    first, group = _first_rows(cells)
    covered = np.zeros(len(points), dtype=np.bool_)
    codes = _codes_of_cells(cells)
    if codes is None:
        return covered | _inside(points, radii, first[group])
    code, step = codes
    order = np.argsort(code[first], kind="stable")
    known = code[first][order]
    for shift in np.ndindex(3, 3, 3):
        wanted = code + int(np.dot(np.array(shift) - 1, step))
        place = np.minimum(np.searchsorted(known, wanted), len(known) - 1)
        found = known[place] == wanted
        covered |= found & _inside(points, radii, first[order][place])
    return covered


def _inside(points: Floats, radii: Floats, others: Ints64) -> Bools:
    """Whether each ball is surely inside another one, of the row given, that is earlier in the order."""
    room = (radii[others] - radii) / _RELATIVE
    return (others < np.arange(len(points))) & (longest_distance(points, points[others]) <= room)


def representatives(points: Floats, radii: Floats, excess: float) -> tuple[Ints64, Floats]:
    """Rows of balls (n, 3), m, to keep, and radii (m,) so that each ball left out is inside one that is kept.

    Cells are so small that a ball grown by the excess, m, holds all of its cell. In each cell the largest ball stands
    for the others; those that it can't hold after all, by rounding, stay as they are.
    """
    if not (isinstance(excess, int | float | np.floating | np.integer) and math.isfinite(excess) and excess > 0):
        raise PlannercheckError(f"excess of a thinned cloud must be a length in m above 0, not {excess!r}")
    if not len(points):
        return np.zeros(0, dtype=np.int64), radii
    order = np.lexsort((np.arange(len(points)), -radii))
    points, radii = points[order], radii[order]
    first, group = _first_rows(_cells(points, float(excess) / (math.sqrt(3) * (2 * _STRETCH - 1))))
    head = first[group]
    needed = np.where(
        head == np.arange(len(points)),
        radii,
        np.nextafter(longest_distance(points, points[head]) + radii, np.inf),
    )
    held = needed <= np.nextafter(radii[head] + float(excess), -np.inf)
    held |= head == np.arange(len(points))
    grown = np.zeros(len(points))
    np.maximum.at(grown, head[held], needed[held])
    grown[~held] = radii[~held]
    kept = distinct(np.concatenate([first, np.flatnonzero(~held)]))
    rows = order[kept]
    return np.sort(rows), grown[kept][np.argsort(rows)]


def _cells(points: Floats, edge: float) -> Floats:
    """(n, 3) whole numbers, as doubles: the cell of each point in a lattice of this edge, m, at the lowest corner."""
    if not len(points):
        return points
    with np.errstate(over="ignore"):  # of edges that are nothing to the coordinates: each point has a cell of its own
        cells = np.floor((points - points.min(axis=0)) / edge)
    return cells if np.isfinite(cells).all() else points


def _first_rows(rows: Floats) -> tuple[Ints64, Ints64]:
    """The first row of each kind, and for each row the number of its kind."""
    codes = _codes_of_cells(rows)
    keys = rows + 0.0 if codes is None else codes[0]
    first, group, _ = grouped(keys)
    return first, group.reshape(-1)


def _codes_of_cells(cells: Floats) -> tuple[Ints64, Ints64] | None:
    """One number for each cell, with room for its neighbours, and by how much it grows along each axis.

    None for what are no whole numbers, or too large for 62 bits.
    """
    if not len(cells) or not (np.floor(cells) == cells).all():
        return None
    low, high = cells.min(axis=0) - 1, cells.max(axis=0) + 1
    if not (np.abs([low, high]) < 2.0**53).all() or np.prod(high - low + 1) >= 2.0**62:
        return None
    size = (high - low + 1).astype(np.int64)
    step = np.array([size[1] * size[2], size[2], 1], dtype=np.int64)
    return (cells - low).astype(np.int64) @ step, step
