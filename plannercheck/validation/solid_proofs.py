"""Whether a certificate about solids holds for the meshes that a checker was given, not only for the core's bodies.

In: a certificate of a pair, and the points and triangles of both shapes at their poses. Out: whether it proves its
verdict about these. A convex body is the hull of its points: a point is in it if a closed surface with vertices among
these winds about it, and a plane keeps it away if it keeps all its points away.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from plannercheck.bodies.certificates import SharedPoint
from plannercheck.bodies.exact_planes import CertifiedBody, PosedBody
from plannercheck.bodies.solid_certificates import Enclosure, PosedSurface
from plannercheck.bodies.solid_separations import PatchSeparation, Range, SolidSeparation
from plannercheck.common.array_types import Floats, Ints


@dataclass(frozen=True, eq=False)
class GivenMesh:
    """What a body was made of.

    Attributes:
        points: (n, 3) in its frame, m.
        triangles: (k, 3) indices of points; None for a convex body.
        inflation_radius: With its padding, m.
    """

    points: Floats
    triangles: Ints | None
    inflation_radius: float

    @cached_property
    def rows(self) -> frozenset[bytes]:
        """The points."""
        return _rows(self.points)

    @cached_property
    def corners(self) -> frozenset[bytes]:
        """The corners of each triangle."""
        return frozenset() if self.triangles is None else _rows(self.points[self.triangles])


Posed = tuple[GivenMesh, Floats]


def proves_contact(certificate: SharedPoint | Enclosure, first: Posed, second: Posed) -> bool:
    """Whether a certificate proves that two posed bodies, of which one is a solid, share a point."""
    if isinstance(certificate, SharedPoint):
        pairs = zip(certificate.bodies, (first, second), strict=True)
        return all(is_part(body, *given) for body, given in pairs) and certificate.verify()
    inner, outer = (first, second) if certificate.first_is_inside else (second, first)
    is_about = _is_vertex(certificate.inner, *inner) and is_surface(certificate.outer, *outer)
    return is_about and certificate.verify()


def proves_separation(certificate: SolidSeparation, first: Posed, second: Posed) -> bool:
    """Whether a certificate proves that two posed bodies, of which one is a solid, share no point."""
    given = first, second
    radii = tuple(mesh.inflation_radius for mesh, _ in given)
    surfaces = [_as_given(surface, *each) for surface, each in zip(certificate.bodies, given, strict=True)]
    if radii != certificate.inflation_radii or surfaces[0] is None or surfaces[1] is None:
        return False
    patches = tuple(_about(patch, certificate, (surfaces[0], surfaces[1]), given) for patch in certificate.patches)
    return replace(certificate, bodies=(surfaces[0], surfaces[1]), patches=patches).verify()


def is_part(body: CertifiedBody, mesh: GivenMesh, pose: Floats) -> bool:
    """Whether a certificate's body is a triangle of a solid, or has points of a convex body."""
    if not isinstance(body, PosedBody) or not np.array_equal(body.pose, pose):
        return False
    if body.inflation_radius != mesh.inflation_radius:
        return False
    if mesh.triangles is None:
        return _rows(body.vertices) <= mesh.rows
    return _rows(body.vertices[None]) <= mesh.corners


def _is_vertex(body: PosedBody, mesh: GivenMesh, pose: Floats) -> bool:
    return np.array_equal(body.pose, pose) and len(body.vertices) == 1 and _rows(body.vertices) <= mesh.rows


def is_surface(surface: PosedSurface, mesh: GivenMesh, pose: Floats) -> bool:
    """Whether a surface has the very triangles of a solid, or points of a convex body."""
    if not np.array_equal(surface.pose, pose):
        return False
    if mesh.triangles is None:
        return _rows(surface.points) <= mesh.rows
    return _sorted_corners(surface.points[surface.triangles]) == _sorted_corners(mesh.points[mesh.triangles])


def _as_given(surface: PosedSurface, mesh: GivenMesh, pose: Floats) -> PosedSurface | None:
    """The surface of a certificate, if it is the solid's; of a convex body, all its points, as one patch."""
    if not is_surface(surface, mesh, pose):
        return None
    if mesh.triangles is not None:
        return surface
    index = np.arange(len(mesh.points), dtype=np.int32)
    return PosedSurface(mesh.points, np.column_stack([0 * index, index, index]), pose)


def _about(
    patch: PatchSeparation,
    certificate: SolidSeparation,
    surfaces: tuple[PosedSurface, PosedSurface],
    given: tuple[Posed, Posed],
) -> PatchSeparation:
    """A patch in the given bodies; one of a part of a convex body becomes empty, and proves nothing."""

    def ranged(side: int, triangles: Range) -> Range:
        if given[side][0].triangles is not None:
            return triangles
        is_whole = triangles == (0, len(certificate.bodies[side].triangles))
        return (0, len(surfaces[side].triangles)) if is_whole else (0, 0)

    return replace(patch, first=ranged(0, patch.first), second=ranged(1, patch.second))


def _rows(array: Floats) -> frozenset[bytes]:
    """The bytes of each entry of an array, -0 as 0."""
    return frozenset(row.tobytes() for row in array + 0.0)


def _sorted_corners(corners: Floats) -> list[bytes]:
    return sorted(row.tobytes() for row in corners + 0.0)
