"""Convex polytopes in any dimension, given by vertices or by halfspaces.

In: points (n, d), or halfspaces A x ≤ b. Out: `Polytope`, immutable; its hull, trees and corners are computed when
they are first asked for. The given numbers are exact; everything computed from them only guides. For points the body is
their hull; for halfspaces it is all x with A x ≤ b, with the rows as their doubles are.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.common.array_types import Floats, Ints
from plannercheck.common.arrays import grouped, named_numbers, read_only, real_numbers
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.public_names import set_module
from plannercheck.ndim import halfspaces
from plannercheck.ndim.poses import LARGEST
from plannercheck.ndim.qhull import FlatError, Hull, convex_hull, halfspace_vertices
from plannercheck.ndim.tree import Tree, default_sizes

# Bytes for the trees of one body.
DEFAULT_MEMORY = 256 << 20
# About the bytes for each facet and dimension in qhull and in building a tree.
_FACET_BYTES = 64
# Points of the two samples from whose facets the hull's are estimated.
_SAMPLES = (64, 128)
# A hull is thin if a facet is nearer to the centre than this part of its size; its polar would mean nothing.
_THIN = 1e-9


@set_module("plannercheck.ndim")
class Polytope:
    """A convex polytope in d dimensions: the hull of points, or with `from_halfspaces` of A x ≤ b.

    Any points are allowed: on a plane or a line, equal ones, or points inside the hull. Verdicts are exact for the
    given numbers. The paper's trees need a body with volume; other bodies use the double oracle.

    Attributes:
        dimension: d.
        vertices: The points as given (n, d), read-only; None for halfspaces.
        normals: A (m, d), read-only; None for points.
        offsets: b (m,), read-only; None for points.
        memory: Bytes that the body's two trees may take.
        name: What errors call it.
        centre: A point about the middle (d,), strictly inside if there is an inside; rounded.
        box: (2, d): no point of the body is outside, proved.
    """

    def __init__(self, vertices: ArrayLike, memory: int = DEFAULT_MEMORY, name: str = "polytope") -> None:
        """Takes points.

        Args:
            vertices: (n, d), n and d at least 1.
            memory: Bytes that the body's two trees may take; a body that needs more takes the double oracle.
            name: What errors call it.
        """
        points = _checked(vertices, name, "vertices (n, d)")
        self._set(points.shape[1], memory, name)
        self.vertices: Floats | None = read_only(points)
        self.normals: Floats | None = None
        self.offsets: Floats | None = None
        self.box = read_only(np.array([points.min(axis=0), points.max(axis=0)]))
        self.has_inside = True

    @classmethod
    def from_halfspaces(
        cls, A: ArrayLike, b: ArrayLike, memory: int = DEFAULT_MEMORY, name: str = "polytope"
    ) -> Polytope:
        """Takes halfspaces A x ≤ b; the body is exactly what they bound, also where its corners are no doubles.

        Args:
            A: Normals (m, d) of any length.
            b: Offsets (m,).
            memory: As for points.
            name: What errors call it.

        Returns:
            The polytope. It is an error if no point is in all halfspaces, or if they are unbounded: then the error
            names a ray that stays inside.
        """
        normals = _checked(A, name, "normals A (m, d)")
        given = named_numbers(b, f"{name}: offsets b (m,)")
        if given.shape != (len(normals),):
            raise PlannercheckError(f"{name}: {len(normals)} normals need as many offsets, not {given.shape}")
        offsets = _checked(given[None], name, "offsets b (m,)")[0]
        self = cls.__new__(cls)
        self._set(normals.shape[1], memory, name)
        found = halfspaces.examine(normals, offsets, name)
        self.vertices = None
        self.normals, self.offsets = read_only(normals), read_only(offsets)
        self.box = found.box
        self.__dict__["centre"] = found.centre
        self.has_inside = found.has_inside
        return self

    def _set(self, dimension: int, memory: int, name: str) -> None:
        self.dimension, self.memory, self.name = dimension, int(memory), name

    @cached_property
    def centre(self) -> Floats:
        """The mean of the extreme points, or of all if the body is flat."""
        assert self.vertices is not None, "a body of halfspaces has its centre from its making"
        if self.hull is None:
            return read_only(self.vertices.mean(axis=0))
        return read_only(self.vertices[self.hull.vertices].mean(axis=0))

    @cached_property
    def reach(self) -> Floats:
        """The largest absolute coordinates (d,), at least."""
        return read_only(np.abs(self.box).max(axis=0))

    @cached_property
    def points(self) -> Floats | None:
        """The points given, or the halfspaces' corners, rounded; None if these are out of reach."""
        if self.vertices is not None:
            return self.vertices
        assert self.normals is not None, "a body has vertices or halfspaces"
        assert self.offsets is not None, "halfspaces have offsets"
        if not self.has_inside or self._too_large(self.normals / halfspaces.lengths(self.normals)[:, None]):
            return None
        try:
            return read_only(halfspace_vertices(self.normals, self.offsets, self.centre))
        except PlannercheckError:
            return None

    @cached_property
    def hull(self) -> Hull | None:
        """The hull of `points`, rounded; None if they span no volume or it does not fit in memory."""
        if self.points is None or self.dimension < 2 or self._too_large(self.points):
            return None
        try:
            return convex_hull(self.points)
        except FlatError:
            return None

    @cached_property
    def tree(self) -> Tree | None:
        """The hierarchical tree of the body, or None."""
        if self.hull is None or self.points is None:
            return None
        return Tree(self.points[self.hull.vertices], _renumbered(self.hull), self.memory // 2)

    @cached_property
    def polar_tree(self) -> Tree | None:
        """The hierarchical tree of the polar about the centre, or None."""
        polars = self._polars
        if polars is None:
            return None
        if len(polars) <= default_sizes(self.dimension)[1]:
            return Tree(polars, None, self.memory // 2)
        if self._too_large(polars):
            return None
        try:
            hull = convex_hull(polars)
        except FlatError:
            return None
        return Tree(polars[hull.vertices], _renumbered(hull), self.memory // 2)

    @cached_property
    def uses_tree(self) -> bool:
        """Whether both trees fit in memory with leaves of constant size; builds them."""
        return self.tree_note == ""

    @cached_property
    def tree_note(self) -> str:
        """Why the body has no trees, or ""."""
        if self.dimension < 2:
            return "trees need two dimensions"
        if self.points is not None and self._too_large(self.points):
            return f"the hull would take more than the {self.memory} bytes of `memory`"
        if self.hull is None or self._polars is None:
            return "the body has no volume, up to rounding, or its corners are out of reach"
        if len(self._polars) > default_sizes(self.dimension)[1] and self._too_large(self._polars):
            return f"the polar's hull would take more than the {self.memory} bytes of `memory`"
        if self.tree is None or self.polar_tree is None:
            return "the polar has no volume, up to rounding"
        if not (self.tree.complete and self.polar_tree.complete):
            return f"the trees' leaves stay large within the {self.memory} bytes of `memory`"
        return ""

    @property
    def tree_bytes(self) -> int:
        """Bytes of the trees built so far."""
        built = (self.__dict__.get("tree"), self.__dict__.get("polar_tree"))
        return sum(tree.nbytes for tree in built if tree is not None)

    @cached_property
    def _polars(self) -> Floats | None:
        if self.hull is None or self.points is None:
            return None
        depths = self.hull.offsets - self.hull.normals @ self.centre
        size = float(np.abs(self.points - self.centre).max())
        if not depths.min() > _THIN * size:
            return None
        polars = self.hull.normals / depths[:, None]
        # Triangles of one facet have one polar point.
        scale = np.abs(polars).max()
        first = grouped(np.round(polars / scale, 11)).first
        return np.asarray(polars[np.sort(first)])

    def _too_large(self, points: Floats) -> bool:
        return _expected_facets(points) * _FACET_BYTES * self.dimension > self.memory

    def __repr__(self) -> str:
        given, kind = (self.normals, "halfspaces") if self.vertices is None else (self.vertices, "points")
        assert given is not None, "a body has vertices or halfspaces"
        return f"Polytope({self.name!r}, dimension {self.dimension}, {len(given)} {kind})"


def check_bodies(*bodies: Polytope) -> None:
    """Raises an error for what is no polytope."""
    for body in bodies:
        if not isinstance(body, Polytope):
            raise PlannercheckError(f"a body must be an ndim.Polytope, not {body!r:.80}")


def _expected_facets(points: Floats) -> float:
    """Facets of a hull, extrapolated from those of two samples as a power of the number of points."""
    if len(points) <= _SAMPLES[1] or points.shape[1] <= 3:
        return float(len(points) * points.shape[1])
    rng = np.random.default_rng(0)
    try:
        few, more = (len(convex_hull(points[rng.permutation(len(points))[:k]]).simplices) for k in _SAMPLES)
    except FlatError:
        return 0.0
    power = max(0.0, float(np.log(more / few) / np.log(_SAMPLES[1] / _SAMPLES[0])))
    return float(more * (len(points) / _SAMPLES[1]) ** power)


def _renumbered(hull: Hull) -> Ints:
    """The simplices as positions among the hull's vertices."""
    return np.searchsorted(hull.vertices, hull.simplices).astype(np.int32)


def _checked(values: ArrayLike, name: str, what: str) -> Floats:
    try:
        array = np.array(real_numbers(values), dtype=np.float64, order="C")
    except (TypeError, ValueError, OverflowError) as error:
        raise PlannercheckError(f"{name}: {what} must be an array of numbers: {error}") from error
    if array.ndim != 2 or array.shape[1] == 0 or len(array) == 0:
        raise PlannercheckError(f"{name}: {what} with at least one row and column are expected, not {array.shape}")
    bad = np.flatnonzero(~np.isfinite(array).all(axis=1))
    if len(bad):
        raise PlannercheckError(f"{name}: row {bad[0]} of {what} is {array[bad[0]].tolist()}, it must be finite")
    if np.abs(array).max() > LARGEST:
        raise PlannercheckError(f"{name}: {what} must be at most {LARGEST:g} in size")
    return array
