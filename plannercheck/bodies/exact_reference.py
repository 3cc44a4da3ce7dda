"""Exact verdicts in Python integers, independent of the compiled core.

In: two sets of vertices (n, 3) in metres with a pose (4, 4) and an inflation radius each, every double taken as the
exact number it is; the sets may be flat, segments or points. Out: whether the two bodies share a point (touching
counts), as a certificate that `holds` checks on its own. A body is all points within its inflation radius, measured in
the world, of the convex hull.

The idea: GJK on the differences p - r of posed vertices, in integers and so without rounding. Each round
takes the vertex furthest against the simplex's point nearest to the origin and finds the nearest point of the
new simplex. The distance falls strictly, so it ends. Lengths are compared by their squares.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.bodies.integers import (
    IntegerHull,
    Integers,
    cross,
    dot,
    in_common_unit,
    minus,
    negated,
    sum_of,
    times,
)

Differences = list["_Difference"]

# Bits of a root that is to be rounded to a double: 53 and some to spare.
_ROOT_BITS = 64


@dataclass(frozen=True)
class ExactSeparation:
    """The proof that two bodies share no point.

    Attributes:
        direction: Integers d with d·p - d·r > |d| S for all posed vertices p of the first and r of the second body,
            S being the sum of the inflation radii.
    """

    direction: Integers


@dataclass(frozen=True)
class ExactSharedPoint:
    """The proof that two bodies share a point: convex combinations of vertices no further apart than the radii.

    Attributes:
        vertices_p: Indices of vertices of the first body.
        vertices_r: Indices of vertices of the second body, as many.
        weights: Positive integers, as many, to be divided by their sum.
    """

    vertices_p: tuple[int, ...]
    vertices_r: tuple[int, ...]
    weights: tuple[int, ...]


Certificate = ExactSeparation | ExactSharedPoint


def intersects(
    vertices_p: ArrayLike,
    vertices_r: ArrayLike,
    pose_p: ArrayLike | None = None,
    pose_r: ArrayLike | None = None,
    inflation_p: float = 0.0,
    inflation_r: float = 0.0,
) -> bool:
    """Whether two bodies share a point, also if they only touch; arguments as for `decide`."""
    return isinstance(decide(vertices_p, vertices_r, pose_p, pose_r, inflation_p, inflation_r), ExactSharedPoint)


def decide(
    vertices_p: ArrayLike,
    vertices_r: ArrayLike,
    pose_p: ArrayLike | None = None,
    pose_r: ArrayLike | None = None,
    inflation_p: float = 0.0,
    inflation_r: float = 0.0,
) -> Certificate:
    """Decides whether two bodies share a point, and proves it.

    Args:
        vertices_p: Points of the first body, (n, 3), m.
        vertices_r: Points of the second body, (m, 3), m.
        pose_p: Pose of the first body, (4, 4), m; the identity if None.
        pose_r: Pose of the second body, (4, 4), m; the identity if None.
        inflation_p: Inflation radius of the first body, m.
        inflation_r: Inflation radius of the second body, m.

    Returns:
        A separating direction, or a shared point.
    """
    p, r = in_common_unit(IntegerHull(vertices_p, pose_p, inflation_p), IntegerHull(vertices_r, pose_r, inflation_r))
    inflation_radius = p.inflation_radius + r.inflation_radius
    for state in _rounds(p, r):
        if not _exceeds(state.simplex[0], state.direction, inflation_radius):
            return _shared_point(state)
        if _exceeds(state.furthest, state.direction, inflation_radius):
            return ExactSeparation(state.direction)
    raise AssertionError("GJK in integers always ends with a certificate")


def distance(
    vertices_p: ArrayLike,
    vertices_r: ArrayLike,
    pose_p: ArrayLike | None = None,
    pose_r: ArrayLike | None = None,
    inflation_p: float = 0.0,
    inflation_r: float = 0.0,
) -> float:
    """The distance of two bodies, m, rounded once or twice from the exact one; arguments as for `decide`."""
    p, r = in_common_unit(IntegerHull(vertices_p, pose_p, inflation_p), IntegerHull(vertices_r, pose_r, inflation_r))
    inflation_radius = p.inflation_radius + r.inflation_radius
    for state in _rounds(p, r):
        if not _exceeds(state.simplex[0], state.direction, inflation_radius):
            return 0.0
        nearest = dot(state.direction, state.simplex[0].point)
        if dot(state.direction, state.furthest.point) >= nearest:
            return _length_beyond(inflation_radius, Fraction(nearest**2, dot(state.direction, state.direction)), p.unit)
    raise AssertionError("GJK in integers always ends with a nearest point")


def holds(
    certificate: Certificate,
    vertices_p: ArrayLike,
    vertices_r: ArrayLike,
    pose_p: ArrayLike | None = None,
    pose_r: ArrayLike | None = None,
    inflation_p: float = 0.0,
    inflation_r: float = 0.0,
) -> bool:
    """Whether a certificate of `decide` proves its verdict, by its definition, exactly, with every vertex."""
    p, r = _posed_fractions(vertices_p, pose_p), _posed_fractions(vertices_r, pose_r)
    inflation_radius = Fraction(inflation_p) + Fraction(inflation_r)
    if isinstance(certificate, ExactSeparation):
        normal = np.array(certificate.direction, dtype=object)
        gap = (p @ normal).min() - (r @ normal).max()
        return bool(gap > 0 and gap * gap > inflation_radius * inflation_radius * (normal @ normal))
    weights = np.array(certificate.weights, dtype=object)
    if len(weights) == 0 or not (weights > 0).all():
        return False
    apart = weights @ (p[list(certificate.vertices_p)] - r[list(certificate.vertices_r)])
    return bool(apart @ apart <= (inflation_radius * weights.sum()) ** 2)


def _posed_fractions(vertices: ArrayLike, pose: ArrayLike | None) -> NDArray[np.object_]:
    points = _fractions(vertices)
    if pose is None:
        return points
    matrix = _fractions(pose)
    return np.asarray(points @ matrix[:3, :3].T + matrix[:3, 3])


def _fractions(values: ArrayLike) -> NDArray[np.object_]:
    array = np.asarray(values, dtype=np.float64)
    return np.array([Fraction(value) for value in array.ravel().tolist()], dtype=object).reshape(array.shape)


@dataclass(frozen=True)
class _Difference:
    """A vertex of the first body less one of the second."""

    vertex_p: int
    vertex_r: int
    point: Integers


@dataclass(frozen=True)
class _State:
    """A simplex, its point nearest to the origin, and the difference furthest against that point."""

    simplex: Differences
    weights: Sequence[int]
    direction: Integers
    furthest: _Difference


def _rounds(p: IntegerHull, r: IntegerHull) -> Iterator[_State]:
    """Walks the simplex of differences towards the origin, until the caller stops."""
    furthest = _difference(p, r, 0, 0)
    simplex, weights, direction = [furthest], [1], furthest.point
    while True:
        if any(direction):
            furthest = _difference(p, r, p.lowest(direction), r.lowest(negated(direction)))
        yield _State(simplex, weights, direction, furthest)
        simplex, weights, direction = _nearest(simplex, furthest)


def _exceeds(difference: _Difference, direction: Integers, inflation_radius: int) -> bool:
    """Whether a difference lies further along a direction than the inflation radius; never for the direction 0."""
    height = dot(direction, difference.point)
    return height > 0 and height**2 > inflation_radius**2 * dot(direction, direction)


def _difference(p: IntegerHull, r: IntegerHull, vertex_p: int, vertex_r: int) -> _Difference:
    return _Difference(vertex_p, vertex_r, minus(p.point(vertex_p), r.point(vertex_r)))


def _nearest(simplex: Differences, new: _Difference) -> tuple[Differences, list[int], Integers]:
    """The face with the enlarged simplex's point nearest to the origin; it has the new vertex."""
    for size in range(len(simplex), -1, -1):
        for others in combinations(simplex, size):
            face = [new, *others]
            projected = _projection([difference.point for difference in face])
            if projected is not None and _supports(projected[1], face[0], simplex):
                return face, *projected
    raise AssertionError("some face of a simplex holds its point nearest to the origin")


def _supports(direction: Integers, touched: _Difference, simplex: Differences) -> bool:
    """Whether no vertex lies nearer to the origin along a direction than one on the plane does."""
    height = dot(direction, touched.point)
    return all(dot(direction, difference.point) >= height for difference in simplex)


def _projection(points: list[Integers]) -> tuple[list[int], Integers] | None:
    """Weights and direction of the origin's projection on the points' flat; None unless inside their hull."""
    weights, direction = _PROJECTIONS[len(points)](*points)
    return (weights, direction) if min(weights) > 0 else None


def _on_point(a: Integers) -> tuple[list[int], Integers]:
    return [1], a


def _on_line(a: Integers, b: Integers) -> tuple[list[int], Integers]:
    edge = minus(b, a)
    weight_a, weight_b = dot(edge, b), -dot(edge, a)
    return [weight_a, weight_b], sum_of(a, weight_a, b, weight_b)


def _on_plane(a: Integers, b: Integers, c: Integers) -> tuple[list[int], Integers]:
    normal = cross(minus(b, a), minus(c, a))
    weights = [dot(normal, cross(b, c)), dot(normal, cross(c, a)), dot(normal, cross(a, b))]
    height = dot(normal, a)
    return weights, times((height > 0) - (height < 0), normal)


def _in_space(a: Integers, b: Integers, c: Integers, d: Integers) -> tuple[list[int], Integers]:
    bc, da = cross(b, c), cross(d, a)
    weights = [dot(bc, d), -dot(cross(c, d), a), dot(da, b), -dot(bc, a)]
    sign = 1 if sum(weights) > 0 else -1
    return [sign * weight for weight in weights], (0, 0, 0)


_Projected = tuple[list[int], Integers]
_PROJECTIONS: dict[int, Callable[..., _Projected]] = {1: _on_point, 2: _on_line, 3: _on_plane, 4: _in_space}


def _shared_point(state: _State) -> ExactSharedPoint:
    return ExactSharedPoint(
        tuple(difference.vertex_p for difference in state.simplex),
        tuple(difference.vertex_r for difference in state.simplex),
        tuple(state.weights),
    )


def _length_beyond(inflation_radius: int, square: Fraction, unit: int) -> float:
    """The root of `square`, which is above the inflation radius, less the inflation radius, times 2^unit."""
    shift = max(0, 2 * _ROOT_BITS - (square.numerator.bit_length() - square.denominator.bit_length())) // 2
    root = Fraction(math.isqrt((square.numerator << (2 * shift)) // square.denominator), 1 << shift)
    # The difference of the squares is exact, so there is no cancellation.
    return float((square - inflation_radius**2) / (root + inflation_radius) * Fraction(2) ** unit)
