"""Proofs of a verdict about two bodies in any dimension: a separating hyperplane, or a common point.

In: exact certificates of `plannercheck.ndim.exact`. Out: frozen values in world coordinates, in doubles and in
fractions, and `verify`, which proves them in fractions from the bodies' own numbers, without the code that found them.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import OwnsArrays
from plannercheck.common.exact_numbers import is_unit_normal, root_above, rounded, rounded_down
from plannercheck.common.public_names import set_module
from plannercheck.ndim.exact import ExactCertificate, ExactSeparation, ExactSharedPoint, combined
from plannercheck.ndim.integers import dot
from plannercheck.ndim.posed import Exact, ExactRows, ExactVertices
from plannercheck.ndim.poses import Affine

Objects = NDArray[np.object_]
Vector: TypeAlias = tuple[Fraction, ...]
Weights: TypeAlias = dict[int, Fraction]

# Bits of a normal's length; it is rounded up by less than doubles can show.
_ROOT_BITS = 128


@set_module("plannercheck.ndim")
@dataclass(frozen=True)
class Effort:
    """How a verdict was found, and the work for it.

    Attributes:
        method: "tree" (the paper's alternating test), "oracle" (double oracle over plain supports) or "exact".
        proof: "doubles" if a filter with a proven bound decided, "exact" if integers had to.
        rounds: Steps of the method: levels walked down in either tree, or rounds of the oracle.
        nodes: Tree nodes visited; 0 for the oracle.
        visited: Vertices and halfspaces looked at by the method: those of the nodes, or all of them a support query.
        checked: Vertices and halfspaces with which the proof was checked afterwards.
        games: Games of exact arithmetic; 0 if doubles decided.
        note: Why the method is not the one that was asked for, or "".
    """

    method: str
    proof: str = "doubles"
    rounds: int = 0
    nodes: int = 0
    visited: int = 0
    checked: int = 0
    games: int = 0
    note: str = ""


@dataclass(frozen=True, eq=False)
class PosedShape(OwnsArrays):
    """A body that a certificate is about: points (n, d), or halfspaces normals · x ≤ offsets, and its pose."""

    pose: Affine
    vertices: Floats | None = None
    normals: Floats | None = None
    offsets: Floats | None = None

    def exact(self) -> Exact:
        """The body for exact arithmetic."""
        if self.vertices is not None:
            return ExactVertices(self.vertices, self.pose)
        assert self.normals is not None, "a body has vertices or halfspaces"
        assert self.offsets is not None, "halfspaces have offsets"
        return ExactRows(self.normals, self.offsets, self.pose)


Shapes: TypeAlias = tuple[PosedShape, PosedShape]


@set_module("plannercheck.ndim")
@dataclass(frozen=True, eq=False)
class Separation(OwnsArrays):
    """A hyperplane between two bodies: normal · x > offset for all x of the first, < offset for all of the second.

    The doubles are rounded; the `exact_` attributes give the hyperplane that separates strictly.

    Attributes:
        normal: Unit vector (d,) in the world, from the second body to the first.
        offset: Halfway between the bodies along the normal.
        gap: A lower bound of the distance between the bodies, rounded down.
        effort: How it was found.
        hyperplanes: (k, d + 1): the logarithmically many hyperplanes a·x = b, as rows (a, b), of the walk through the
            trees, each beyond part of the first body, all with the second body on a·x ≤ b, up to rounding; none from
            the oracle. Their intersection excludes the first body; a combination of them is `normal`.
        exact_normal: Any length.
        exact_offset: The hyperplane is exact_normal · x = exact_offset.
        multipliers: For a body given by halfspaces: weights of at least 0 of its given rows, whose sum bounds it by the
            hyperplane; empty for one given by vertices.
        shapes: What is separated.
    """

    normal: Floats
    offset: float
    gap: float
    effort: Effort
    hyperplanes: Floats = field(repr=False)
    exact_normal: Vector = field(repr=False)
    exact_offset: Fraction = field(repr=False)
    multipliers: tuple[Weights, Weights] = field(repr=False)
    shapes: Shapes = field(repr=False)

    @property
    def shares(self) -> bool:
        """False."""
        return False

    def verify(self) -> bool:
        """Whether the hyperplane separates the two bodies strictly, proved in fractions.

        Returns:
            True if every vertex, or a combination of halfspaces, is on its side, the gap is a lower bound, and the
            doubles are the exact values, rounded.
        """
        if not self._doubles_agree():
            return False
        normal, offset = np.array(self.exact_normal, dtype=object), self.exact_offset
        first = _extent(self.shapes[0], self.multipliers[0], -normal)
        second = _extent(self.shapes[1], self.multipliers[1], normal)
        if first is None or second is None or not -first > offset > second:
            return False
        square = Fraction(self.gap) ** 2 * sum(x * x for x in self.exact_normal)
        return self.gap >= 0 and square <= (-first - second) ** 2

    def _doubles_agree(self) -> bool:
        """Whether normal and offset are the exact ones, rounded, and all are numbers of this dimension."""
        exact, d = self.exact_normal, len(self.shapes[0].pose.shift)
        if self.normal.shape != (d,) or len(exact) != d or not any(exact):
            return False
        if not np.isfinite([*self.normal, self.offset, self.gap]).all():
            return False
        length = root_above(Fraction(sum(x * x for x in exact)), _ROOT_BITS)
        is_normal = is_unit_normal(self.normal.tolist(), exact, length)
        return is_normal and self.offset == rounded(self.exact_offset / length)


@set_module("plannercheck.ndim")
@dataclass(frozen=True, eq=False)
class SharedPoint(OwnsArrays):
    """A point of both bodies.

    Attributes:
        point: (d,) in the world, rounded.
        effort: How it was found.
        halfspaces: (k, d + 1): the logarithmically many points x_j of the walk, as rows (x, 1): each is a halfspace
            x_j · y ≤ 1 of the polar space that holds part of the second body's polar, up to rounding; none from the
            oracle.
        exact_point: The point.
        weights: For a body given by vertices: weights of at least 0, of sum 1, that mix the point; empty for one given
            by halfspaces.
        shapes: What shares the point.
    """

    point: Floats
    effort: Effort
    halfspaces: Floats = field(repr=False)
    exact_point: Vector = field(repr=False)
    weights: tuple[Weights, Weights] = field(repr=False)
    shapes: Shapes = field(repr=False)

    @property
    def shares(self) -> bool:
        """True."""
        return True

    def verify(self) -> bool:
        """Whether the point is in both bodies, proved in fractions, and the doubles are the exact point, rounded."""
        d = len(self.shapes[0].pose.shift)
        if self.point.shape != (d,) or len(self.exact_point) != d:
            return False
        return self.point.tolist() == [rounded(x) for x in self.exact_point] and all(
            _holds(shape, weights, self.exact_point) for shape, weights in zip(self.shapes, self.weights, strict=True)
        )


Certificate: TypeAlias = Separation | SharedPoint


def certificate_of(
    found: ExactCertificate, bodies: tuple[Exact, Exact], shapes: Shapes, effort: Effort, trail: Floats
) -> Certificate:
    """Brings an exact certificate of bodies in their common unit into the world's coordinates.

    The effort says how it was found; the trail has the walk's hyperplanes or halfspaces (k, d + 1).
    """
    if isinstance(found, ExactSharedPoint):
        return _shared_point(found, bodies, shapes, effort, trail)
    return _separation(found, bodies, shapes, effort, trail)


def _separation(
    found: ExactSeparation, bodies: tuple[Exact, Exact], shapes: Shapes, effort: Effort, trail: Floats
) -> Separation:
    p, r = bodies
    unit = Fraction(2) ** p.unit
    direction = found.direction
    low = -_bound(p, [-x for x in direction], found.rows_p) * unit
    high = _bound(r, direction, found.rows_r) * unit
    offset = (low + high) / 2
    square = Fraction(sum(x * x for x in direction))
    length = root_above(square, _ROOT_BITS)
    return Separation(
        normal=np.array([rounded(x / length) for x in direction]),
        offset=rounded(offset / length),
        gap=rounded_down((low - high) / length),
        effort=effort,
        hyperplanes=trail,
        exact_normal=tuple(Fraction(x) for x in direction),
        exact_offset=offset,
        multipliers=(_of_given_rows(p, found.rows_p), _of_given_rows(r, found.rows_r)),
        shapes=shapes,
    )


def _bound(body: Exact, direction: list[int], rows: dict[int, int]) -> Fraction:
    """The body's extent along a direction, at most."""
    if isinstance(body, ExactRows):
        return Fraction(combined(body, rows)[1])
    highest = body.lowest([-x for x in direction])
    return Fraction(dot(direction, body.point(highest)))


def _of_given_rows(body: Exact, rows: dict[int, int]) -> Weights:
    return {k: w * body.scale(k) for k, w in rows.items()} if isinstance(body, ExactRows) else {}


def _shared_point(
    found: ExactSharedPoint, bodies: tuple[Exact, Exact], shapes: Shapes, effort: Effort, trail: Floats
) -> SharedPoint:
    unit = Fraction(2) ** bodies[0].unit
    point = tuple(Fraction(x, found.denominator) * unit for x in found.point)
    first, second = (
        {k: Fraction(w, found.denominator) for k, w in weights.items()}
        for weights in (found.weights_p, found.weights_r)
    )
    return SharedPoint(np.array([rounded(x) for x in point]), effort, trail, point, (first, second), shapes)


def _extent(shape: PosedShape, multipliers: Weights, direction: Objects) -> Fraction | None:
    """The largest direction · x over a body, from all vertices or as its halfspaces prove it; None if they don't."""
    matrix, shift = fractions_of(shape.pose.matrix), fractions_of(shape.pose.shift)
    pulled, moved = direction @ matrix, Fraction(direction @ shift)
    if shape.vertices is not None:
        return Fraction((fractions_of(shape.vertices) @ pulled).max() + moved)
    assert shape.normals is not None, "a body has vertices or halfspaces"
    assert shape.offsets is not None, "halfspaces have offsets"
    chosen = list(multipliers)
    weights = np.array([multipliers[k] for k in chosen], dtype=object)
    if not chosen or min(weights) < 0 or (weights @ fractions_of(shape.normals[chosen]) != pulled).any():
        return None
    return Fraction(weights @ fractions_of(shape.offsets[chosen]) + moved)


def _holds(shape: PosedShape, weights: Weights, point: Vector) -> bool:
    matrix, shift = fractions_of(shape.pose.matrix), fractions_of(shape.pose.shift)
    if shape.vertices is not None:
        if not weights or min(weights.values()) < 0 or sum(weights.values()) != 1:
            return False
        mass = np.array(list(weights.values()), dtype=object)
        mixture = matrix @ (mass @ fractions_of(shape.vertices[list(weights)])) + shift
        return bool((mixture == np.array(point, dtype=object)).all())
    assert shape.normals is not None, "a body has vertices or halfspaces"
    assert shape.offsets is not None, "halfspaces have offsets"
    inside = _solved(matrix, np.array(point, dtype=object) - shift)
    return bool((fractions_of(shape.normals) @ inside <= fractions_of(shape.offsets)).all())


def _solved(matrix: Objects, right: Objects) -> Objects:
    """The x with matrix x = right, in fractions."""
    rows = np.concatenate([matrix, right[:, None]], axis=1)
    for k in range(len(rows)):
        swap = next(r for r in range(k, len(rows)) if rows[r, k])
        rows[[k, swap]] = rows[[swap, k]]
        rows[k] = rows[k] / rows[k, k]
        for r in range(len(rows)):
            if r != k and rows[r, k]:
                rows[r] = rows[r] - rows[r, k] * rows[k]
    return np.asarray(rows[:, -1])


def fractions_of(values: Floats) -> Objects:
    """Doubles as exact numbers, in an array of the same shape."""
    return np.array([Fraction(value) for value in values.ravel().tolist()], dtype=object).reshape(values.shape)
