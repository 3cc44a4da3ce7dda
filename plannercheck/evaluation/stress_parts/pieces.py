"""Convex parts of bodies, as the oracles have them.

In: corners and a radius. Out: a `Piece`, for the oracles of convex bodies and of meshes; a `Group` of pieces, in which
a piece that holds others stands for them if it is apart.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.evaluation.stress.oracle import compiled_oracle
from plannercheck.evaluation.stress.sample_bodies import Specimen, prepared
from plannercheck.evaluation.stress_solids.bodies import Body as SolidBody
from plannercheck.evaluation.stress_solids.surfaces import surface

# Of the hull around a group; beyond, a box is taken.
_MOST_CORNERS = 64


@dataclass(frozen=True, eq=False)
class Piece:
    """A convex part of a body.

    Attributes:
        corners: (n, 3) m; all points within `radius` of their hull belong to the piece.
        radius: In the world, m.
    """

    corners: Floats
    radius: float

    @cached_property
    def points(self) -> Any:
        """As the oracle of convex bodies has it."""
        return compiled_oracle().Points(self.corners, self.radius)

    @cached_property
    def specimen(self) -> Specimen:
        """With points on its border and directions there."""
        return prepared("part", self.corners, self.radius)

    @cached_property
    def surface(self) -> SolidBody:
        """As the oracle of meshes has it."""
        hull = self.specimen.polytope
        triangles: Any = [[0, hull.dimension, hull.dimension]]  # of a point or a segment
        if hull.dimension == 2:
            triangles = list(itertools.combinations(range(len(hull.vertices)), 3))
        elif hull.dimension == 3:
            triangles = hull.faces
        return SolidBody("part", surface(hull.vertices, triangles), self.radius, is_convex=True)

    @cached_property
    def centre(self) -> Floats:
        """(3,) m."""
        return np.asarray(self.corners.mean(axis=0))


@dataclass(frozen=True, eq=False)
class Group:
    """Pieces by halves.

    Attributes:
        around: A piece that holds them all, or the only one.
        halves: Two groups of fewer of them, none of a single piece.
    """

    around: Piece
    halves: tuple[Group, ...] = ()

    @staticmethod
    def of(pieces: Sequence[Piece]) -> Group:
        """Parted in the middle along the longest side of the box around their centres."""
        if len(pieces) == 1:
            return Group(pieces[0])
        centres = np.array([piece.centre for piece in pieces])
        order = np.argsort(centres[:, np.argmax(np.ptp(centres, axis=0))], kind="stable")
        parts = np.array_split(order, 2)
        halves = tuple(Group.of([pieces[k] for k in part]) for part in parts)
        corners = np.concatenate([half.around.corners for half in halves])
        if len(corners) > _MOST_CORNERS:
            sides = np.stack([corners.min(axis=0), corners.max(axis=0)])
            corners = np.array([[x, y, z] for x in sides[:, 0] for y in sides[:, 1] for z in sides[:, 2]])
        return Group(Piece(corners, max(half.around.radius for half in halves)), halves)
