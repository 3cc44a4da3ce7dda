"""Limits of a proof's contents, in space and in the plane: numbers, placements, vertices, pairs, intervals.

In: parts of a proof. Out: nothing, or an `UnprovedError`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Sequence
from typing import Any

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.proofs.data import Entry
from plannercheck.proofs.faults import UnprovedError

# The largest norm of M^T M - 1 of a placement, or of a pose in the world.
LARGEST_DEFECT = 1e-6

# Larger numbers, rad and m, belong to no configuration or scene.
LARGEST_NUMBER = 1e15

# A short way round is at most half a turn, rad, up to the rounding of its end.
HALF_TURN = math.pi + 1e-6


def check_numbers(values: Iterable[Any], what: str) -> None:
    """Raises an `UnprovedError` for a number that is not finite or is too large."""
    for value in values:
        if not isinstance(value, float) or not abs(value) <= LARGEST_NUMBER:
            raise UnprovedError(
                f"{what} has the number {value!r:.40}, which is not finite, or beyond {LARGEST_NUMBER:g}"
            )


def check_length(values: Sequence[Any], length: int, what: str) -> None:
    """Raises an `UnprovedError` unless there are `length` numbers."""
    if len(values) != length:
        raise UnprovedError(f"{what} has {len(values)} numbers, not {length}")


def check_rigid(matrix: Floats, what: str) -> None:
    """Raises an `UnprovedError` unless a square matrix turns, up to `LARGEST_DEFECT`."""
    defect = float(np.linalg.norm(matrix.T @ matrix - np.eye(len(matrix))))
    if not defect <= LARGEST_DEFECT or not np.linalg.det(matrix) > 0:
        raise UnprovedError(f"{what} that is not rigid: |M^T M - 1| is {defect:.3g}, or it is a reflection")


def check_vertices(vertices: Any, dimension: int, what: str) -> None:
    """Raises an `UnprovedError` unless vertices are an array (n, dimension) of doubles that are not too large."""
    if type(vertices) is not np.ndarray or vertices.dtype != np.float64:
        raise UnprovedError(f"{what} has vertices that are no array of doubles")
    shape = vertices.shape
    if len(shape) != 2 or shape[1] != dimension or not shape[0]:
        raise UnprovedError(f"{what} has vertices of shape {shape}, not (n, {dimension})")
    if not (np.abs(vertices) <= LARGEST_NUMBER).all():
        raise UnprovedError(f"{what} has a vertex that is not finite, or beyond {LARGEST_NUMBER:g}")


def check_pairs(pairs: Iterable[tuple[int, int]], bodies: int) -> None:
    """Raises an `UnprovedError` for a pair that is not of two of the bodies."""
    for index, (a, b) in enumerate(pairs):
        if a == b or not (0 <= a < bodies and 0 <= b < bodies):
            raise UnprovedError(f"pair {index} is of bodies {a} and {b}: they must be two of {bodies}")


def check_tiled(
    entries: Iterable[Entry],
    pairs: int,
    check_entry: Callable[[Entry, int], None],
    whole: str,
    has_end: bool = False,
    covered: Collection[int] = (),
    known: Collection[str] = ("plane", "balls"),
) -> None:
    """Raises an `UnprovedError` unless the entries of every pair tile [0, 1], in order, and name what there is.

    Args:
        entries: Of all pairs.
        pairs: How many there are.
        check_entry: Checks what else an entry says, the k-th.
        whole: The end of the interval, for errors.
        has_end: Whether the end counts by itself: each pair then has an entry from 1 to 1 after the others.
        covered: Pairs that are checked otherwise.
        known: What may keep a pair apart.
    """
    reached: dict[int, float] = {}
    ended: set[int] = set()
    for k, entry in enumerate(entries):
        if not 0 <= entry.pair < pairs:
            raise UnprovedError(f"entry {k} is of pair {entry.pair}, of {pairs}")
        if entry.pair in covered:
            continue
        so_far = reached.get(entry.pair, 0.0)
        if has_end and entry.start == entry.end == 1.0 == so_far and entry.pair not in ended:
            ended.add(entry.pair)
        elif not entry.start < entry.end or so_far != entry.start:
            raise UnprovedError(
                f"entry {k}, [{entry.start!r}, {entry.end!r}], does not begin where pair {entry.pair} is proved so "
                f"far, at {so_far!r}"
            )
        reached[entry.pair] = entry.end
        if entry.by not in known:
            raise UnprovedError(f"entry {k} is by {entry.by!r:.40}, which is not known")
        check_entry(entry, k)
    for pair in set(range(pairs)).difference(covered):
        if reached.get(pair, 0.0) != 1.0 or (has_end and pair not in ended):
            raise UnprovedError(f"pair {pair} is proved up to {reached.get(pair, 0.0)!r} alone, not to {whole}")
