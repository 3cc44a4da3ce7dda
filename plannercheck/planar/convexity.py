"""Decides exactly whether vertices are those of a convex polygon in order.

In: vertices (n, 2). Out: None, or what is wrong. A polygon is convex if all its turns have the same direction or are
straight, and the boundary goes around once: its direction changes between left and right exactly twice.

The idea: doubles decide the clear turns, integers the others.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from plannercheck.common.array_types import Floats, Ints64

# A turn in doubles: differences, products and their difference err by at most 4u (1 + u) of the sum of the products'
# absolute values; 8 leaves room.
_TURN_BOUND = 8 * 2.0**-53
# Below the first a product may have lost bits to underflow; above the second it may have overflowed.
_SMALLEST_TRUSTED, _LARGEST_TRUSTED = 1e-290, 1e290


def convexity_fault(vertices: Floats) -> str | None:
    """Says why vertices (n, 2) are no convex polygon in order; None if they are one."""
    finite = np.isfinite(vertices).all(axis=1)
    if not finite.all():
        return f"vertex {int(np.argmin(finite))} is not finite"
    steps = np.roll(vertices, -1, axis=0) != vertices
    if len(vertices) > 1 and not steps.any(axis=1).all():
        return f"vertex {int(np.argmin(steps.any(axis=1)))} is repeated by the next one"
    turns = turns_of(vertices)
    if (turns > 0).any() and (turns < 0).any():
        rarer = 1 if (turns > 0).sum() <= (turns < 0).sum() else -1
        return f"the boundary turns the other way at vertex {int(np.argmax(turns == rarer))}"
    if _reversals(vertices) > 2:
        return "the boundary goes around more than once"
    return None


def turns_of(vertices: Floats) -> Ints64:
    """(n,) the exact turn at each vertex: 1 left, -1 right, 0 straight on or back."""
    before, after = np.roll(vertices, 1, axis=0), np.roll(vertices, -1, axis=0)
    (ax, ay), (bx, by) = (vertices - before).T, (after - vertices).T
    with np.errstate(all="ignore"):
        value, size = ax * by - ay * bx, np.abs(ax * by) + np.abs(ay * bx)
        clear = (np.abs(value) > _TURN_BOUND * size) & (size > _SMALLEST_TRUSTED) & (size < _LARGEST_TRUSTED)
    turns = np.where(clear, np.sign(value), 0).astype(np.int64)
    for k in np.flatnonzero(~clear).tolist():
        turns[k] = _exact_turn(before[k], vertices[k], after[k])
    return turns


def _exact_turn(a: Floats, b: Floats, c: Floats) -> int:
    (ax, ay), (bx, by), (cx, cy) = ([Fraction(x) for x in point.tolist()] for point in (a, b, c))
    value = (bx - ax) * (cy - by) - (by - ay) * (cx - bx)
    return (value > 0) - (value < 0)


def _reversals(vertices: Floats) -> int:
    """How often the boundary's steps change between up and down, in the lexicographic order of vertices."""
    following = np.roll(vertices, -1, axis=0)
    up = (following[:, 0] > vertices[:, 0]) | ((following[:, 0] == vertices[:, 0]) & (following[:, 1] > vertices[:, 1]))
    return int((up != np.roll(up, 1)).sum())
