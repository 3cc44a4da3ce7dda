"""Proofs about two bodies of which at least one is a set of parts.

In: two posed bodies. Out: a common point, whose certificate is about one part of each set; or a `PartSeparation`:
planes that keep ranges of parts away from the other body, so that every part is kept away. A solid counts as the set of
its triangles: planes keep parts in its hollow away from patches of its surface, and no part is inside of it. Both are
verified in exact arithmetic, from the parts' corners and the solid's triangles alone, without the core's test.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, ClassVar, TypeAlias

import numpy as np

from plannercheck.bodies.certificates import Separation, UnprovedVerdictError
from plannercheck.bodies.exact_planes import PosedBody, separates_exactly
from plannercheck.bodies.kinds import Kind
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.posed_half_spaces import PosedHalfSpace
from plannercheck.bodies.solid_certificates import PosedSurface
from plannercheck.bodies.solid_separations import (
    PatchSeparation,
    Range,
    SolidSeparation,
    covers,
    halves,
    patch_of,
    surface_of,
    winds_about,
)
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import distinct_rows
from plannercheck.common.core import core
from plannercheck.common.public_names import set_module

Certify: TypeAlias = Callable[[Polytope, Polytope, Floats, Floats], Any]

# Up to so many parts, a plane is sought between the hull of their corners and the other body; beyond, between the box
# around them, which is made faster.
_MOST_IN_HULL = 64


@dataclass(frozen=True, eq=False)
class PosedParts:
    """A body of a certificate: a set of parts, or a body that is none, which counts as one part.

    Attributes:
        corners: (n, 3) of all parts, in the body's frame, m.
        start: (k + 1,) part i has the corners from start[i] up to start[i + 1].
        radii: (k,) how far each part reaches around the hull of its corners, the body's inflation radius included, m.
        pose: (4, 4) in the world, m.
    """

    has_parts: ClassVar[bool] = True

    corners: Floats
    start: np.ndarray[Any, np.dtype[np.int64]]
    radii: Floats
    pose: Floats

    def __len__(self) -> int:
        return len(self.radii)

    def body(self, parts: Range) -> PosedBody:
        """The corners of some parts, with the largest of their radii."""
        first, last = parts
        corners = self.corners[self.start[first] : self.start[last]]
        return PosedBody(corners, self.pose, float(self.radii[first:last].max()))


@dataclass(frozen=True, eq=False)
class OnePart:
    """A half-space as a body of a certificate: it counts as one part."""

    has_parts: ClassVar[bool] = True

    half_space: PosedHalfSpace

    def __len__(self) -> int:
        return 1

    def body(self, parts: Range) -> PosedHalfSpace:
        """The body, whatever the parts."""
        return self.half_space


@dataclass(frozen=True, eq=False)
class PosedTriangles:
    """A solid as a body of a certificate: its triangles count as parts, in the order of ranges; the radius is in m."""

    has_parts: ClassVar[bool] = False

    surface: PosedSurface
    inflation_radius: float

    def __len__(self) -> int:
        return len(self.surface.triangles)

    def body(self, parts: Range) -> PosedBody:
        """The corners of some triangles."""
        return patch_of(self.surface, parts, self.inflation_radius)


BodyInParts: TypeAlias = PosedParts | OnePart | PosedTriangles


@dataclass(frozen=True, eq=False)
class RangeSeparation:
    """A plane between some parts of the first body and some of the second."""

    first: Range
    second: Range
    plane: Separation


@set_module("plannercheck")
@dataclass(frozen=True, eq=False)
class PartSeparation:
    """What proves that two bodies, of which one is a set of parts at least, share no point.

    Attributes:
        gap: A lower bound of the distance between the bodies in m, radii included; infinite if a set has no parts.
        ranges: Planes between ranges of parts, which together cover every part of one body with each of the other.
        bodies: The parts of both bodies, in the order that ranges count; of a solid, its triangles.
    """

    gap: float
    ranges: tuple[RangeSeparation, ...] = field(repr=False)
    bodies: tuple[BodyInParts, BodyInParts] = field(repr=False)

    def verify(self) -> bool:
        """Whether the bodies are apart, proved in exact arithmetic.

        Returns:
            True if a plane keeps each part of one body away from each of the other by at least the gap, and no part is
            inside of a solid.
        """
        first, second = self.bodies
        pairs = [(each.first, each.second) for each in self.ranges]
        return (
            covers(pairs, len(first), len(second))
            and all(self._holds(each) for each in self.ranges)
            and not _is_inside(first, second, pairs)
            and not _is_inside(second, first, [(parts, other) for other, parts in pairs])
        )

    def _holds(self, each: RangeSeparation) -> bool:
        first, second = self.bodies
        plane = each.plane.exact()
        return 0 <= self.gap <= plane.gap and separates_exactly(
            plane, (first.body(each.first), second.body(each.second))
        )


def _is_inside(outer: BodyInParts, inner: BodyInParts, pairs: list[tuple[Range, Range]]) -> bool:
    """Whether a solid winds about a part of the other body, whose parts planes keep away from all its triangles.

    Args:
        outer: A body; only a solid can hold parts.
        inner: The other body.
        pairs: Ranges of the outer body's triangles and of the inner body's parts between which there is a plane.
    """
    if not isinstance(outer, PosedTriangles) or not isinstance(inner, PosedParts):
        return False
    of_parts: dict[Range, list[Range]] = {}
    for triangles, parts in pairs:
        of_parts.setdefault(parts, []).append(triangles)
    samples = list[int]()
    for parts, kept in of_parts.items():
        if (0, len(outer)) in kept:  # one plane keeps these parts away from the solid's hull
            continue
        # The hull of parts that meets no triangle is inside or outside as one.
        as_one = covers([(each, (0, 1)) for each in kept], len(outer), 1)
        samples += [parts[0]] if as_one else range(*parts)
    corners = inner.corners[inner.start[samples]]
    return winds_about(outer.surface, (PosedBody(corner[None], inner.pose) for corner in corners))


def parts_met(p: Polytope, r: Polytope, pose_p: Floats, pose_r: Floats) -> tuple[int, int] | None:
    """The places of two parts that share a point, −1 for a body that is no set; None if nothing is shared."""
    kind, on_p, on_r, _ = core.solids_contact(p.core, pose_p, r.core, pose_r)
    return None if kind == "apart" else (int(on_p), int(on_r))


def part_of(body: Polytope, place: int) -> Polytope:
    """A part as a body of its own, with the inflation radius of the set; the body itself if it is no set."""
    if place < 0:
        return body
    corners, radius, _ = body.core.shape.part(place)
    return Polytope(corners, inflation_radius=radius + body.inflation_radius)


def certify_parts(p: Polytope, r: Polytope, pose_p: Floats, pose_r: Floats, certify: Certify) -> Any:
    """The proof that two bodies share a point, or that they do not.

    Args:
        p: A body.
        r: Another body; at least one of both is a set of parts.
        pose_p: Pose (4, 4) of the first body in the world, m.
        pose_r: The pose of the second body.
        certify: Gives the certificate of two bodies that are no sets.

    Returns:
        What `certify` gives of two parts that share a point; else a `Separation` if one plane is enough, or a
        `PartSeparation`.

    Raises:
        UnprovedVerdictError: If two parts share a point after all.
    """
    met = parts_met(p, r, pose_p, pose_r)
    if met is not None:
        return certify(part_of(p, met[0]), part_of(r, met[1]), pose_p, pose_r)
    bodies = _posed_parts(p, pose_p), _posed_parts(r, pose_r)
    if min(map(len, bodies)) == 0:  # a set without parts is away from everything
        return PartSeparation(math.inf, (), bodies)
    whole = (0, len(bodies[0])), (0, len(bodies[1]))
    waiting, found = [whole], list[RangeSeparation]()
    while waiting:
        ranges = waiting.pop()
        first, second = (_hull_of(body, each, own) for body, each, own in zip(bodies, ranges, (p, r), strict=True))
        certificate = certify(first, second, pose_p, pose_r)
        if isinstance(certificate, Separation):
            if ranges == whole:
                return certificate
            found.append(RangeSeparation(*ranges, certificate))
            continue
        if isinstance(certificate, SolidSeparation):
            found += [_between(ranges, patch, bodies) for patch in certificate.patches]
            continue
        sizes = [last - start if body.has_parts else 0 for body, (start, last) in zip(bodies, ranges, strict=True)]
        if max(sizes) <= 1:
            raise UnprovedVerdictError("no plane separates a part from the other body, which the core finds apart")
        if sizes[0] >= sizes[1]:
            waiting += [(half, ranges[1]) for half in halves(*ranges[0])]
        else:
            waiting += [(ranges[0], half) for half in halves(*ranges[1])]
    return PartSeparation(min(each.plane.gap for each in found), tuple(found), bodies)


def _between(
    ranges: tuple[Range, Range], patch: PatchSeparation, bodies: tuple[BodyInParts, BodyInParts]
) -> RangeSeparation:
    """A plane between ranges of parts and a patch of a solid, whose triangles count; the other body's do not."""
    first, second = (
        parts if body.has_parts else of_patch
        for body, of_patch, parts in zip(bodies, (patch.first, patch.second), ranges, strict=True)
    )
    return RangeSeparation(first, second, patch.plane)


def _posed_parts(body: Polytope, pose: Floats) -> BodyInParts:
    return _POSED[body.kind](body, pose)


def _plane_as_part(body: Polytope, pose: Floats) -> BodyInParts:
    normal, offset = body.core.shape
    return OnePart(PosedHalfSpace(np.array(normal), offset, pose, body.inflation_radius))


def _hull_as_part(body: Polytope, pose: Floats) -> BodyInParts:
    one = np.array([0, len(body.vertices)], dtype=np.int64)
    return PosedParts(body.vertices, one, np.array([body.inflation_radius]), pose)


def _parts_of_set(body: Polytope, pose: Floats) -> BodyInParts:
    parts = [body.core.shape.part(place)[:2] for place in range(body.core.shape.places)]
    corners = [each for each, _ in parts if len(each)]
    radii = [radius + body.inflation_radius for each, radius in parts if len(each)]
    start = np.concatenate([[0], np.cumsum([len(each) for each in corners])]).astype(np.int64)
    return PosedParts(np.concatenate([np.zeros((0, 3)), *corners]), start, np.array(radii), pose)


_POSED: dict[Kind, Callable[[Polytope, Floats], BodyInParts]] = {
    "hull": _hull_as_part,
    "solid": lambda body, pose: PosedTriangles(surface_of(body, pose), body.inflation_radius),
    "part_set": _parts_of_set,
    "half_space": _plane_as_part,
}


def _hull_of(body: BodyInParts, parts: Range, own: Polytope) -> Polytope:
    """A body around some parts; the body itself if it is no set."""
    if not own.traits.has_parts:
        return own
    posed = body.body(parts)
    assert isinstance(posed, PosedBody)
    corners = posed.vertices
    if parts[1] - parts[0] > _MOST_IN_HULL:
        low, high = corners.min(axis=0), corners.max(axis=0)
        corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    return Polytope(distinct_rows(corners)[0], inflation_radius=posed.inflation_radius)
