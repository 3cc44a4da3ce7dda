"""Proofs that two bodies are apart although their hulls overlap; at least one body is a solid.

In: two posed bodies that share no point. Out: a `SolidSeparation`: planes that keep patches of one surface away from
patches of the other, so that every triangle is kept away from every other; and that neither body is in the other one.
It is verified in exact arithmetic, from vertices, triangles and poses alone, without the core.

Why that is enough: cpp/narrow_phase/solid_pair.hpp. The planes are those of the patches' hulls, from coarse to fine; a
patch is a range of triangles in the order of the solid's tree.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from plannercheck.bodies.certificates import Separation, UnprovedVerdictError
from plannercheck.bodies.exact_planes import PosedBody, separates_exactly
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.solid_certificates import PosedSurface, edges_cancel, winding_about
from plannercheck.common.array_types import Floats, Ints
from plannercheck.common.arrays import distinct, grouped
from plannercheck.common.public_names import set_module

# Triangles from the first up to the last, the last one excluded.
Range: TypeAlias = tuple[int, int]
Separate: TypeAlias = Callable[[Polytope, Polytope, Floats, Floats], object]


@dataclass(frozen=True, eq=False)
class PatchSeparation:
    """A plane between the hulls of some triangles of the first body and some of the second."""

    first: Range
    second: Range
    plane: Separation


@set_module("plannercheck")
@dataclass(frozen=True, eq=False)
class SolidSeparation:
    """What proves that two bodies, of which one is a solid at least, share no point.

    Attributes:
        gap: A lower bound of the distance between the bodies in m, inflation radii included.
        patches: Planes between patches of both, which together cover every triangle of one with every triangle of the
            other.
        bodies: The surfaces of both bodies; their triangles are in the order that patches count.
        inflation_radii: The inflation radii of both bodies, m.
    """

    gap: float
    patches: tuple[PatchSeparation, ...] = field(repr=False)
    bodies: tuple[PosedSurface, PosedSurface] = field(repr=False)
    inflation_radii: tuple[float, float] = field(repr=False)

    def verify(self) -> bool:
        """Whether the bodies are apart, proved in exact arithmetic.

        Returns:
            True if a plane keeps each triangle of one body away from each of the other by at least the gap, and no
            vertex that stands for a part of one surface is inside of the other.
        """
        first, second = self.bodies
        return (
            covers([(p.first, p.second) for p in self.patches], len(first.triangles), len(second.triangles))
            and all(self._holds(patch) for patch in self.patches)
            and not _is_inside(first, second)
            and not _is_inside(second, first)
        )

    def _holds(self, patch: PatchSeparation) -> bool:
        (first, second), (radius, other_radius) = self.bodies, self.inflation_radii
        hulls = patch_of(first, patch.first, radius), patch_of(second, patch.second, other_radius)
        plane = patch.plane.exact()
        return 0 <= self.gap <= plane.gap and separates_exactly(plane, hulls)


def separate_solids(
    p: Polytope, r: Polytope, pose_p: Floats, pose_r: Floats, certify_hulls: Separate
) -> Separation | SolidSeparation:
    """What proves that two posed bodies share no point: a plane if one keeps their hulls apart, by `certify_hulls`.

    Raises:
        UnprovedVerdictError: If two triangles share a point after all.
    """
    bodies, radii = (surface_of(p, pose_p), surface_of(r, pose_r)), (p.inflation_radius, r.inflation_radius)
    hulls: tuple[dict[Range, Polytope], dict[Range, Polytope]] = ({}, {})
    whole = (0, len(bodies[0].triangles)), (0, len(bodies[1].triangles))
    waiting, patches = [whole], list[PatchSeparation]()
    can_divide = not p.traits.is_convex, not r.traits.is_convex  # a convex body stays whole
    while waiting:
        ranges = waiting.pop()
        for body, radius, known, each in zip(bodies, radii, hulls, ranges, strict=True):
            if each not in known:
                known[each] = Polytope(patch_of(body, each).vertices, inflation_radius=radius)
        certificate = certify_hulls(hulls[0][ranges[0]], hulls[1][ranges[1]], pose_p, pose_r)
        if isinstance(certificate, Separation):
            if ranges == whole:
                return certificate
            patches.append(PatchSeparation(*ranges, certificate))
            continue
        waiting += _divided(*ranges, can_divide)
    return SolidSeparation(min(patch.plane.gap for patch in patches), tuple(patches), bodies, radii)


def _divided(first: Range, second: Range, can_divide: tuple[bool, bool]) -> list[tuple[Range, Range]]:
    """The larger patch of a solid in halves, with the other one."""
    sizes = [(last - start) * can for (start, last), can in zip((first, second), can_divide, strict=True)]
    if max(sizes) <= 1:
        raise UnprovedVerdictError("the core finds two solids to be apart, but two of their triangles meet")
    if sizes[0] >= sizes[1]:
        return [(half, second) for half in halves(*first)]
    return [(first, half) for half in halves(*second)]


def halves(first: int, last: int) -> tuple[Range, Range]:
    """Both halves of a range, the first one not smaller."""
    middle = (first + last + 1) // 2
    return (first, middle), (middle, last)


def surface_of(body: Polytope, pose: Floats) -> PosedSurface:
    """The triangles of a solid, or of a hull, in the order that patches count."""
    surface = body.core.surface()
    return PosedSurface(surface.points(), surface.triangles()[surface.order()], pose)


def patch_of(body: PosedSurface, triangles: Range, inflation_radius: float = 0.0) -> PosedBody:
    """The corners of some triangles."""
    corners = distinct(body.triangles[triangles[0] : triangles[1]])
    return PosedBody(body.points[corners], body.pose, inflation_radius)


def covers(patches: list[tuple[Range, Range]], rows: int, columns: int) -> bool:
    """Whether ranges of rows, each with a range of columns, cover every row with every column."""
    if not all(0 <= a < b <= rows and 0 <= c < d <= columns for (a, b), (c, d) in patches):
        return False
    edges = sorted({0, rows, *(edge for first, _ in patches for edge in first)})
    for low, high in itertools.pairwise(edges):
        reached = 0
        for first, last in sorted(second for first, second in patches if first[0] <= low and high <= first[1]):
            if first > reached:
                return False
            reached = max(reached, last)
        if reached < columns:
            return False
    return True


def _is_inside(outer: PosedSurface, inner: PosedSurface) -> bool:
    """Whether a surface winds about a part of another one, of which it meets no triangle."""
    return winds_about(outer, (PosedBody(inner.points[[vertex]], inner.pose) for vertex in _component_vertices(inner)))


def winds_about(outer: PosedSurface, vertices: Iterable[PosedBody]) -> bool:
    """Whether a surface is closed and winds about one of some vertices, or has one of them on a triangle."""
    return edges_cancel(_merged(outer)) and any(winding_about(vertex, outer) != 0 for vertex in vertices)


def _merged(surface: PosedSurface) -> Ints:
    """The triangles, where points with equal coordinates have one index."""
    index = grouped(surface.points + 0.0).places
    return np.asarray(index.reshape(-1)[surface.triangles], dtype=np.int32)


def _component_vertices(surface: PosedSurface) -> Ints:
    """A vertex of each part of the surface that hangs together by vertices."""
    least = np.arange(len(surface.points), dtype=np.int32)  # of each vertex, one of its part that is not above it
    before = np.zeros_like(least)
    while not np.array_equal(before, least):
        before = least.copy()
        np.minimum.at(least, surface.triangles.ravel(), np.repeat(least[surface.triangles].min(axis=1), 3))
        least = least[least]
    return distinct(least[surface.triangles])
