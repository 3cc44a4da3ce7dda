"""Whether a certificate about sets of parts holds for the shapes that a checker was given.

In: a certificate of a pair, and both shapes at their poses. Out: whether it proves its verdict about these. The parts
are made again here from the shapes' own numbers (points and radii, cells, heights), so that the core's parts are not
trusted: a certificate's parts have to be the very same, and a plane has to keep all of them away.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np

from plannercheck.bodies.certificates import SharedPoint
from plannercheck.bodies.circumscribed import BOX_SIGNS
from plannercheck.bodies.exact_planes import PosedBody
from plannercheck.bodies.height_fields import HeightField
from plannercheck.bodies.lattice_cells import LatticeCells
from plannercheck.bodies.part_certificates import BodyInParts, PartSeparation, PosedParts, PosedTriangles
from plannercheck.bodies.part_sets import PartSet
from plannercheck.bodies.point_clouds import PointCloud
from plannercheck.bodies.solid_certificates import Enclosure
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import distinct_rows
from plannercheck.common.errors import PlannercheckError
from plannercheck.validation.solid_proofs import GivenMesh, is_part, is_surface, proves_contact

# Up to so many parts, all corners stand for the set in a separation by one plane; beyond, the box around them.
_MOST_IN_HULL = 64


@dataclass(frozen=True, eq=False)
class GivenParts:
    """The parts of a shape.

    Attributes:
        corners: (n, c, 3) of each part, in the set's frame, m.
        radii: (n,) how far each reaches around the hull of its corners, padding included, m.
    """

    corners: Floats
    radii: Floats
    _confirmed: set[bytes] = field(default_factory=set, repr=False)

    @cached_property
    def hull(self) -> tuple[Floats, float]:
        """Points (m, 3), m, and a radius: all parts lie within the radius of the points' hull."""
        points = self.corners.reshape(-1, 3)
        if len(self.corners) > _MOST_IN_HULL:
            low, high = ([edge(column) for column in points.T] for edge in (np.min, np.max))
            points = np.where(BOX_SIGNS > 0, high, low)
        return distinct_rows(points)[0], float(self.radii.max())

    @cached_property
    def mesh(self) -> GivenMesh:
        """The corners of all parts, of which one may be inside a solid."""
        return GivenMesh(self.corners.reshape(-1, 3), None, 0.0)

    @cached_property
    def _keys(self) -> Floats:
        return _keys(self.corners, self.radii)

    @cached_property
    def _known(self) -> frozenset[bytes]:
        return frozenset(row.tobytes() for row in self._keys)

    def has_part(self, body: PosedBody) -> bool:
        """Whether a certificate's body is one of the parts."""
        if len(body.vertices) != self.corners.shape[1]:  # a triangle of a part, or a flat part, of fewer points
            return self._has_flat(distinct_rows(body.vertices + 0.0)[0], body.inflation_radius)
        return _keys(body.vertices[None], np.array([body.inflation_radius]))[0].tobytes() in self._known

    def _has_flat(self, points: Floats, radius: float) -> bool:
        """Whether the points are corners of one part, which makes their hull a piece of it."""
        same = (self.corners[:, :, None] == points[None, None]).all(axis=-1).any(axis=1).all(axis=1)
        return bool((same & (self.radii >= radius)).any())

    def are(self, parts: PosedParts) -> bool:
        """Whether a certificate's parts are these, in any order."""
        count = self.corners.shape[1]
        is_even = np.array_equal(parts.start, np.arange(len(parts.radii) + 1) * count)
        if not is_even or len(parts.radii) != len(self.radii):
            return False
        digest = hashlib.sha256(parts.corners.tobytes() + parts.radii.tobytes()).digest()
        if digest not in self._confirmed:
            found = _keys(parts.corners.reshape(-1, count, 3), parts.radii)
            if not np.array_equal(_sorted(found), _sorted(self._keys)):
                return False
            self._confirmed.add(digest)
        return True


Given: TypeAlias = tuple[GivenParts | GivenMesh, Floats]


def given_parts(shape: PartSet, padding: float) -> GivenParts:
    """The parts of a shape that has some, from its own numbers, each inflated by the padding, m.

    Raises:
        PlannercheckError: If the shape is of an unknown kind.
    """
    match shape:
        case PointCloud():
            return GivenParts(shape.points[:, None], shape.radii + padding)
        case LatticeCells():
            low, high = shape.boxes()
            corners = np.where(BOX_SIGNS > 0, high[:, None], low[:, None])
        case HeightField():
            corners = _prisms(shape)
        case _:
            raise PlannercheckError(f"certificates are not about shapes of type {type(shape).__name__}")
    return GivenParts(corners, np.full(len(corners), padding))


def _prisms(field_: HeightField) -> Floats:
    """(n, 6, 3) the corners of the prisms below the triangles."""
    triangles = field_.triangles()
    below = triangles.copy()
    below[:, :, 2] = field_.base
    return np.concatenate([triangles, below], axis=1)


def proves_contact_of_parts(certificate: SharedPoint | Enclosure, first: Given, second: Given) -> bool:
    """Whether a certificate proves that two posed bodies, of which one is a set of parts, share a point."""
    given = first, second
    if isinstance(certificate, Enclosure):
        meshes = [(body.mesh if isinstance(body, GivenParts) else body, pose) for body, pose in given]
        return proves_contact(certificate, meshes[0], meshes[1])
    for body, (shape, pose) in zip(certificate.bodies, given, strict=True):
        if isinstance(shape, GivenParts):
            if not isinstance(body, PosedBody) or not np.array_equal(body.pose, pose) or not shape.has_part(body):
                return False
        elif not is_part(body, shape, pose):
            return False
    return certificate.verify()


def proves_separation_of_parts(certificate: PartSeparation, first: Given, second: Given) -> bool:
    """Whether planes prove that two posed bodies, of which one is a set of parts, share no point."""
    bodies = list[BodyInParts]()
    for found, (shape, pose) in zip(certificate.bodies, (first, second), strict=True):
        if isinstance(shape, GivenParts):
            if not isinstance(found, PosedParts) or not np.array_equal(found.pose, pose) or not shape.are(found):
                return False
            bodies.append(found)
        elif shape.triangles is not None:
            if not isinstance(found, PosedTriangles) or not is_surface(found.surface, shape, pose):
                return False
            bodies.append(replace(found, inflation_radius=shape.inflation_radius))
        else:
            one = np.array([0, len(shape.points)], dtype=np.int64)
            bodies.append(PosedParts(shape.points, one, np.array([shape.inflation_radius]), pose))
    return replace(certificate, bodies=(bodies[0], bodies[1])).verify()


def _keys(corners: Floats, radii: Floats) -> Floats:
    """(n, 3 c + 1) a row for each part, the same for the same corners in any order; -0 is 0."""
    count = len(corners)
    order = np.lexsort((corners[..., 2], corners[..., 1], corners[..., 0]), axis=-1)
    ordered = np.take_along_axis(corners, order[..., None], axis=1).reshape(count, -1)
    return np.concatenate([ordered, np.reshape(radii, (count, 1))], axis=1) + 0.0


def _sorted(rows: Floats) -> Floats:
    """The rows in an order of their own."""
    return rows[np.lexsort(rows.T)]
