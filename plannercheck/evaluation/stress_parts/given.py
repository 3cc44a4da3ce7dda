"""The bodies of the stress of sets of parts as numbers: the core's input, and the places of the parts.

In: arrays. Out: a `Given`: the pieces whose union the body is, computed here by the documented arithmetic, and the body
as the core prepares it; smaller ones of the same kind.

A further kind of body is a class here and in KINDS, a function in `set_families.SETS` or `draws.OTHERS`, and, if it is
no union of hulls with radii, a branch in `truth.decide`.
"""

from __future__ import annotations

import itertools
from abc import ABC, abstractmethod
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.ellipsoids import Ellipsoid
from plannercheck.bodies.half_spaces import HalfSpace
from plannercheck.bodies.polytope import Polytope
from plannercheck.common.array_types import Floats
from plannercheck.common.core import core
from plannercheck.evaluation.stress_parts.pieces import Piece
from plannercheck.evaluation.stress_solids.bodies import Body as SolidBody
from plannercheck.evaluation.stress_solids.surfaces import surface

CORNERS = np.array(list(itertools.product((0, 1), repeat=3)))


@dataclass(frozen=True, eq=False)
class Given(ABC):
    """A body as numbers.

    Attributes:
        kind: Its name in documents.
        by_part: Its arrays that have a row for each part that a smaller body may do without.
        padding: All points within this distance of the body belong to it, m.
    """

    kind: ClassVar[str]
    by_part: ClassVar[tuple[str, ...]] = ()
    padding: float

    @abstractmethod
    def pieces(self) -> tuple[Piece, ...]:
        """Hulls with radii whose union it is; of a mesh and of a half-space none."""

    @abstractmethod
    def prepare(self) -> Polytope:
        """The core's body."""

    @property
    def parts(self) -> int:
        """How many parts it has that a smaller body may do without."""
        return len(getattr(self, self.by_part[0])) if self.by_part else 0

    def some(self, rows: list[int]) -> Given:
        """A body of the same kind that has some of the parts."""
        return replace(self, **{name: getattr(self, name)[rows] for name in self.by_part})


@dataclass(frozen=True, eq=False)
class Balls(Given):
    """Balls about points (n, 3), m, of radii (n,) or (1,), m."""

    kind: ClassVar[str] = "balls"
    by_part: ClassVar[tuple[str, ...]] = ("points",)
    points: Floats
    radii: Floats

    def pieces(self) -> tuple[Piece, ...]:
        """A point with a radius each."""
        radii = np.resize(self.radii, len(self.points))
        each = zip(self.points, radii, strict=True)
        return tuple(Piece(point[None], float(radius) + self.padding) for point, radius in each)

    def prepare(self) -> Polytope:
        """The core's body."""
        return _prepared(core.PartSet.balls(self.points, self.radii), self.padding)

    def some(self, rows: list[int]) -> Given:
        """Fewer balls; one radius of all stays."""
        radii = self.radii if len(self.radii) == 1 else self.radii[rows]
        return replace(self, points=self.points[rows], radii=radii)


@dataclass(frozen=True, eq=False)
class Cells(Given):
    """Cells from keys (n, 3) on, of sizes (n,), in steps of a lattice, m, from an origin (3,) on, m."""

    kind: ClassVar[str] = "cells"
    by_part: ClassVar[tuple[str, ...]] = ("keys", "sizes")
    keys: NDArray[Any]
    sizes: NDArray[Any]
    step: float
    origin: Floats

    def pieces(self) -> tuple[Piece, ...]:
        """A coordinate is origin + key · step, rounded after each operation."""
        ends = self.keys.astype(np.float64), (self.keys + self.sizes[:, None]).astype(np.float64)
        sides = np.stack([self.origin + (end * self.step) for end in ends])
        corners = (np.ascontiguousarray(sides[CORNERS, k, np.arange(3)]) for k in range(len(self.keys)))
        return tuple(Piece(each, self.padding) for each in corners)

    def prepare(self) -> Polytope:
        """The core's body."""
        keys, sizes = (np.ascontiguousarray(each, dtype=np.int32) for each in (self.keys, self.sizes))
        return _prepared(core.PartSet.cells(keys, sizes, self.step, self.origin), self.padding)


@dataclass(frozen=True, eq=False)
class Columns(Given):
    """Prisms below heights (i, j), m, of a lattice of steps (2,), m, from an origin (2,) on, m, down to a base, m."""

    kind: ClassVar[str] = "columns"
    heights: Floats
    steps: Floats
    origin: Floats
    base: float

    def pieces(self) -> tuple[Piece, ...]:
        """Two for each cell, parted along the edge from (i, j) to (i + 1, j + 1); none where a height is NaN."""
        rows, columns = self.heights.shape
        x, y = (
            self.origin[k] + (np.arange(n, dtype=np.float64) * self.steps[k]) for k, n in enumerate((rows, columns))
        )
        found = []
        for i, j in itertools.product(range(rows - 1), range(columns - 1)):
            for third in ((i + 1, j), (i, j + 1)):
                top = [(x[a], y[b], self.heights[a, b]) for a, b in ((i, j), third, (i + 1, j + 1))]
                if not any(np.isnan(z) for *_, z in top):
                    found.append(Piece(np.array(top + [(u, v, self.base) for u, v, _ in top]), self.padding))
        return tuple(found)

    def prepare(self) -> Polytope:
        """The core's body."""
        return _prepared(core.PartSet.columns(self.heights, self.steps, self.origin, self.base), self.padding)

    @property
    def parts(self) -> int:
        """Heights."""
        return int((~np.isnan(self.heights)).sum())

    def some(self, rows: list[int]) -> Given:
        """With holes: a lattice that is cut would begin elsewhere, and be rounded otherwise."""
        there = np.flatnonzero(~np.isnan(self.heights))[rows]
        fewer = np.full_like(self.heights, np.nan)
        fewer.flat[there] = self.heights.flat[there]
        return replace(self, heights=fewer)


@dataclass(frozen=True, eq=False)
class Hull(Given):
    """The hull of points (n, 3), m."""

    kind: ClassVar[str] = "hull"
    by_part: ClassVar[tuple[str, ...]] = ("points",)
    points: Floats

    def pieces(self) -> tuple[Piece, ...]:
        """Itself."""
        return (Piece(self.points, self.padding),)

    def prepare(self) -> Polytope:
        """The core's body."""
        return Polytope(self.points, inflation_radius=self.padding)


@dataclass(frozen=True, eq=False)
class Mesh(Given):
    """A solid: points (n, 3), m, and triangles (m, 3)."""

    kind: ClassVar[str] = "mesh"
    points: Floats
    triangles: NDArray[Any]

    def pieces(self) -> tuple[Piece, ...]:
        """None: it is no union of hulls."""
        return ()

    def solid(self) -> SolidBody:
        """As the oracle of meshes has it."""
        return SolidBody("solid", surface(self.points, self.triangles.astype(np.int32)), self.padding)

    def prepare(self) -> Polytope:
        """The core's body."""
        return self.solid().polytope


@dataclass(frozen=True, eq=False)
class Under(Given):
    """A half-space: all x with normal · x <= offset, the normal (3,) of any length."""

    kind: ClassVar[str] = "half-space"
    normal: Floats
    offset: float

    def pieces(self) -> tuple[Piece, ...]:
        """None: it is unbounded."""
        return ()

    @property
    def shape(self) -> HalfSpace:
        """As users give it."""
        x, y, z = self.normal.tolist()
        return HalfSpace((x, y, z), self.offset)

    def prepare(self) -> Polytope:
        """The core's body."""
        return Polytope.of_half_space(self.shape, self.padding)


@dataclass(frozen=True, eq=False)
class Oval(Given):
    """An ellipsoid of radii (3,), m, which is the polytope around it that sticks out by an excess."""

    kind: ClassVar[str] = "ellipsoid"
    radii: Floats
    excess: float

    def pieces(self) -> tuple[Piece, ...]:
        """The polytope around it."""
        return (Piece(self.shape.vertices_and_faces()[0], self.padding),)

    @property
    def shape(self) -> Ellipsoid:
        """As users give it."""
        x, y, z = self.radii.tolist()
        return Ellipsoid((x, y, z), self.excess)

    @property
    def inner(self) -> Hull:
        """The polytope in it."""
        return Hull(self.padding, self.shape.inner()[0])

    def prepare(self) -> Polytope:
        """The core's body."""
        return Polytope(*self.shape.vertices_and_faces(), inflation_radius=self.padding)


KINDS: dict[str, type[Given]] = {made.kind: made for made in (Balls, Cells, Columns, Hull, Mesh, Under, Oval)}


def given_of(document: dict[str, Any]) -> Given:
    """The body of a document; KeyError, TypeError or ValueError if it is none."""
    made = KINDS[document["kind"]]
    numbers: Any = {each.name: document[each.name] for each in fields(made)}
    for name, given in numbers.items():
        numbers[name] = np.array(given) if isinstance(given, list) else given
    return made(**numbers)


def _prepared(parts: Any, padding: float) -> Polytope:
    return Polytope._from_core(parts.body(padding))
