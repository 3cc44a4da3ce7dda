"""The bodies of the stress of solids, as the core has them and as the oracle has them.

In: a family's name, about how many triangles, a size in m. Out: a `Body`. Convex bodies are hulls for the core and
their closed surfaces for the oracle, so a solid meets polytopes, balls, capsules, segments and points, too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.solids import Solid
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import distinct_values
from plannercheck.evaluation.stress import body_families
from plannercheck.evaluation.stress.oracle import compiled_oracle
from plannercheck.evaluation.stress_solids import solid_families
from plannercheck.evaluation.stress_solids.dented import dented
from plannercheck.evaluation.stress_solids.solid_families import LARGE_FAMILIES, LATTICE_FAMILIES, SOLID_FAMILIES
from plannercheck.evaluation.stress_solids.surfaces import Surface, octahedron, surface
from plannercheck.evaluation.stress_solids.torn import torn
from plannercheck.evaluation.stress_solids.variations import varied


@dataclass(frozen=True, eq=False)
class Body:
    """A body.

    Attributes:
        family: What it is.
        surface: Its triangles; of a convex body those of its hull, counter-clockwise seen from outside.
        inflation_radius: All points within this distance belong to the body, m.
        is_convex: Whether the core has the hull, not a solid.
        is_capped: Whether caps close the surface if it is open; else an open one is its triangles alone.
    """

    family: str
    surface: Surface
    inflation_radius: float = 0.0
    is_convex: bool = False
    is_capped: bool = False

    @cached_property
    def size(self) -> float:
        """Its greatest extent along an axis, m; of a point 1."""
        extent = float(np.ptp(self.surface.used_points, axis=0).max()) + 2 * self.inflation_radius
        return extent or 1.0

    @cached_property
    def truth(self) -> Any:
        """The oracle's mesh."""
        return compiled_oracle().Mesh(self.whole.points, self.whole.triangles, self.inflation_radius)

    @cached_property
    def whole(self) -> Surface:
        """The surface with its caps."""
        given = self.given
        return surface(*given.used) if self.is_capped and isinstance(given, Solid) else self.surface

    @property
    def parts(self) -> int:
        """Triangles, of which a smaller body has some; a convex body keeps all."""
        return 0 if self.is_convex else len(self.surface.triangles)

    def some(self, rows: list[int]) -> Body:
        """Some of the triangles, with the points that they use."""
        used, corners = distinct_values(self.surface.triangles[rows])
        return replace(self, surface=surface(self.surface.points[used], corners)) if rows else self

    def document(self) -> dict[str, Any]:
        """Its numbers."""
        kept = ("family", "inflation_radius", "is_convex", "is_capped")
        return {**vars(self.surface), **{name: getattr(self, name) for name in kept}}

    @property
    def triangles_alone(self) -> Body:
        """The same without caps."""
        return replace(self, is_capped=False)

    @property
    def hull(self) -> Body:
        """The hull of the same, as its closed surface; itself if that has no volume."""
        found = Polytope(self.surface.used_points)
        return replace(self, surface=surface(found.vertices, found.faces)) if found.dimension == _SPACE else self

    @cached_property
    def given(self) -> Solid | Polytope:
        """What a user would give, without the inflation radius of a solid."""
        if self.is_convex:
            return Polytope(self.surface.points, inflation_radius=self.inflation_radius)
        return Solid(self.surface.points, self.surface.triangles, "cap" if self.is_capped else "triangles")

    @cached_property
    def polytope(self) -> Polytope:
        """The body prepared for queries."""
        given = self.given
        if isinstance(given, Polytope):
            return given
        return Polytope(given.used[0], inflation_radius=self.inflation_radius).of_solid(given)


def body_of(document: dict[str, Any]) -> Body:
    """The body of a document."""
    found = surface(document["points"], document["triangles"])
    kinds = bool(document["is_convex"]), bool(document["is_capped"])
    return Body(str(document["family"]), found, float(document["inflation_radius"]), *kinds)


def tetrahedron(n: int, rng: np.random.Generator) -> Surface:
    """A tetrahedron of the lattice, right side out."""
    found = solid_families.tetrahedra(4, rng)
    a, b, c, d = found.points
    return found.inverted if np.linalg.det(np.stack([b - a, c - a, d - a])) < 0 else found


def lattice_box(n: int, rng: np.random.Generator) -> Surface:
    """A box of the lattice."""
    low, high = np.sort(solid_families.lattice_points((2,), 8, rng), axis=0)
    return solid_families.box(low, np.where(low == high, high + 1 / 8, high))


def any_hull(n: int, rng: np.random.Generator) -> Surface:
    """The hull of points, its faces as the core finds them."""
    names = [name for name in body_families.FAMILIES if name != "doubling"]
    hull = Polytope(body_families.FAMILIES[str(rng.choice(names))](max(8, min(n // 2, 100)), rng))
    return surface(hull.vertices, hull.faces)


def segment(n: int, rng: np.random.Generator) -> Surface:
    """A segment, of the lattice or not."""
    points = solid_families.lattice_points((2,), 8, rng) if rng.integers(2) else body_families.round_body(2, rng)
    return surface(points, [[0, 1, 1]])


def point(n: int, rng: np.random.Generator) -> Surface:
    """A point."""
    return surface(solid_families.lattice_points((1,), 8, rng), [[0, 0, 0]])


CONVEX_FAMILIES: dict[str, Callable[[int, np.random.Generator], Surface]] = {
    "tetrahedron": tetrahedron,
    "box": lattice_box,
    "octahedron": lambda n, rng: octahedron(),
    "hull": any_hull,
    "segment": segment,
    "point": point,
}
# Families whose coordinates are on the lattice, so that moves along axes keep contact exact.
EXACT_FAMILIES = (*LATTICE_FAMILIES, "tetrahedron", "box", "octahedron", "point")
# Solids that are nearly their hulls, and those of open meshes that caps close.
DENTED, TORN = "dented", "torn"
_SPACE = 3
# Inflation radii over the size: of solids, which are rarely inflated, and of convex bodies.
_RADII = (0.5, 0.125, 2.0**-10, 0.01)
_INFLATED_SOLIDS, _INFLATED_HULLS = 0.06, 0.4


def random_solid(family: str, n: int, size: float, rng: np.random.Generator) -> Body:
    """A solid of a family, of about n triangles and a size in m, varied."""
    found = SOLID_FAMILIES[family](n, rng)
    name = ""
    if family not in LARGE_FAMILIES or rng.integers(2):
        found, name = varied(found, rng)
    radius = _radius(_INFLATED_SOLIDS, rng)
    return Body(family + name, found.scaled(size), radius * size)


def random_dented(n: int, size: float, rng: np.random.Generator) -> Body:
    """A solid that is nearly its hull, varied."""
    found, name = varied(dented(n, rng), rng)
    return Body(DENTED + name, found.scaled(size), _radius(_INFLATED_SOLIDS, rng) * size)


def random_torn(n: int, size: float, rng: np.random.Generator) -> Body:
    """A solid of an open mesh that caps close."""
    return Body(TORN, torn(n, rng).scaled(size), _radius(_INFLATED_SOLIDS, rng) * size, is_capped=True)


def random_convex(family: str, n: int, size: float, rng: np.random.Generator) -> Body:
    """A convex body of a family."""
    found = CONVEX_FAMILIES[family](n, rng)
    if family == "tetrahedron" and np.linalg.matrix_rank(found.points[1:] - found.points[0]) < 3:
        found = octahedron()
    return Body(family, found.scaled(size), _radius(_INFLATED_HULLS, rng) * size, is_convex=True)


def _radius(share: float, rng: np.random.Generator) -> float:
    return float(rng.choice(_RADII)) if rng.random() < share else 0.0


def decided(p: Body, poses_p: Floats, r: Body, poses_r: Floats, every: bool = False) -> Any:
    """The oracle's reasons (n,) at poses (n, 4, 4), Meeting in cpp/oracle/mesh_pairs.hpp; 0 where no point is shared.

    `every`: all pairs of triangles and all vertices are compared, in whole numbers alone.
    """
    return compiled_oracle().decide_meshes(p.truth, poses_p, r.truth, poses_r, every)
