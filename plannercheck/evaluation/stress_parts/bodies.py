"""The bodies of the stress of sets of parts, as the core has them and as the oracle has them.

In: the numbers of a body. Out: a `Body`: its pieces or its solid, and the core's body.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from plannercheck.bodies.polytope import Polytope
from plannercheck.common.array_types import Floats
from plannercheck.evaluation.stress.sample_bodies import Specimen, prepared
from plannercheck.evaluation.stress_parts.given import Given, Hull, Mesh, Oval, Under, given_of
from plannercheck.evaluation.stress_parts.pieces import Group, Piece
from plannercheck.evaluation.stress_solids.bodies import Body as SolidBody


@dataclass(frozen=True, eq=False)
class Body:
    """A body of a family, and the numbers that it is made of."""

    family: str
    given: Given

    @cached_property
    def pieces(self) -> tuple[Piece, ...]:
        """Those whose union it is; of a solid and of a half-space none."""
        return self.given.pieces()

    @cached_property
    def group(self) -> Group:
        """Its pieces by halves."""
        return Group.of(self.pieces)

    @cached_property
    def solid(self) -> SolidBody | None:
        """The solid, if it is one."""
        return self.given.solid() if isinstance(self.given, Mesh) else None

    @cached_property
    def half_space(self) -> Under | None:
        """The half-space, if it is one."""
        return self.given if isinstance(self.given, Under) else None

    @cached_property
    def inner(self) -> Body | None:
        """The polytope in it, if it is an ellipsoid."""
        return Body("inner polytope", self.given.inner) if isinstance(self.given, Oval) else None

    @cached_property
    def polytope(self) -> Polytope:
        """The body prepared for queries."""
        return self.given.prepare()

    @property
    def parts(self) -> int:
        """How many parts it has that a smaller body may do without."""
        return self.given.parts

    def some(self, rows: list[int]) -> Body:
        """Of some of the parts."""
        return Body(self.family, self.given.some(rows))

    def document(self) -> dict[str, Any]:
        """Its numbers."""
        return {"family": self.family, "kind": self.given.kind, **vars(self.given)}

    @cached_property
    def corners(self) -> Floats:
        """Of all pieces, or a solid's, (n, 3), m; of a half-space a point of its plane."""
        if self.half_space is not None:
            return self.half_space.shape.plate(0.0)[:1]
        if self.solid is not None:
            return self.solid.surface.used_points
        return np.concatenate([piece.corners for piece in self.pieces])

    @cached_property
    def radii(self) -> Floats:
        """How far the body reaches around each of `corners`, (n,), m."""
        if not self.pieces:
            return np.full(len(self.corners), self.given.padding)
        return np.repeat([piece.radius for piece in self.pieces], [len(piece.corners) for piece in self.pieces])

    @cached_property
    def whole(self) -> Specimen:
        """The hull of all corners, with the largest of their radii."""
        return prepared("whole set", self.corners, float(self.radii.max()))


def body_of(document: dict[str, Any]) -> Body:
    """The body of a document."""
    return Body(str(document["family"]), given_of(document))


def of_hull(found: Specimen) -> Body:
    """A hull, which is its own only piece."""
    return Body(found.family, Hull(found.inflation_radius, found.vertices))


def of_solid(found: SolidBody) -> Body:
    """A solid."""
    return Body(found.family, Mesh(found.inflation_radius, found.surface.points, found.surface.triangles))
