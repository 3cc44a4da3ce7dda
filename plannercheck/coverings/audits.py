"""What an audit of a covering says of each link.

In: the bodies of links and their primitives. Out: `Audit`, one `AuditedLink` each.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np

from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import GeometryObject
from plannercheck.common.array_types import Floats
from plannercheck.common.exact_numbers import rounded
from plannercheck.common.html_tables import html_table
from plannercheck.common.public_names import set_module
from plannercheck.coverings.excess import greatest_excess, mean_excess
from plannercheck.coverings.primitives import Point, Primitives
from plannercheck.coverings.regions import posed, regions_of
from plannercheck.coverings.search import outside

# Points of a link's surface by which the share outside is estimated.
_SAMPLES = 4000


@set_module("plannercheck")
@dataclass(frozen=True)
class AuditedLink:
    """One link of an audit.

    Attributes:
        name: The link.
        primitives: How many spheres, capsules and boxes stand for it.
        covered: Whether they are proved to hold all of it.
        outside: Lower and upper bound, m, of how far they would have to grow to hold it; (0, 0) if they are proved to.
        witness: (x, y, z) in the link's frame, m, rounded: the point that the lower bound is of; None if none is known.
        share: The part of the link's surface that is outside, estimated from points spread over it.
        excess: m, no point of the primitives is further from the link; NaN if one of both is missing.
        mean_excess: m, the mean distance of their surface from the link, estimated likewise.
        area: m², of their surface, estimated likewise.
        exact_witness: The witness as fractions: a point of the link outside all primitives, exactly.
    """

    name: str
    primitives: int
    covered: bool
    outside: tuple[float, float]
    witness: tuple[float, float, float] | None
    share: float
    excess: float
    mean_excess: float
    area: float
    exact_witness: tuple[Fraction, Fraction, Fraction] | None = field(default=None, repr=False)


@set_module("plannercheck")
@dataclass(frozen=True)
class Audit:
    """The audit of a covering.

    Attributes:
        links: One each, in the robot's order.
        geometry: What meshes of links were taken as; None for the robot's own geometry.
        neighbours: Whether primitives of neighbouring links counted.
    """

    links: tuple[AuditedLink, ...]
    geometry: str | None
    neighbours: bool

    @property
    def covered(self) -> bool:
        """Whether all links are proved to be covered."""
        return all(link.covered for link in self.links)

    @property
    def outside(self) -> tuple[float, float]:
        """The bounds, m, of the link that is furthest outside."""
        return (
            max((link.outside[0] for link in self.links), default=0.0),
            max((link.outside[1] for link in self.links), default=0.0),
        )

    @property
    def mean_excess(self) -> float:
        """m, over the surfaces of all links' primitives."""
        rows = [link for link in self.links if np.isfinite(link.mean_excess)]
        area = sum(link.area for link in rows)
        return sum(link.mean_excess * link.area for link in rows) / area if area else float("nan")

    def as_json(self) -> dict[str, Any]:
        """Plain values; unknown numbers are None."""
        rows = [{name: _plain(value) for name, value in asdict(link).items()} for link in self.links]
        for row in rows:
            del row["exact_witness"]
        return {
            "covered": self.covered,
            "geometry": self.geometry,
            "neighbours": self.neighbours,
            "mean_excess": _plain(self.mean_excess),
            "links": rows,
        }

    def rows(self) -> list[tuple[str, ...]]:
        """The cells of a table, under `HEADER`."""
        return [_cells(link) for link in self.links]

    def _repr_html_(self) -> str:
        words = "all links are covered" if self.covered else "not all links are proved to be covered"
        return html_table(words, HEADER, self.rows())


HEADER = ("link", "primitives", "covered", "outside mm", "share %", "witness m", "excess mm", "mean mm")


def _cells(link: AuditedLink) -> tuple[str, ...]:
    low, high = (1e3 * each for each in link.outside)
    covered = "proved" if link.covered else "open" if link.witness is None else "no"
    return (
        link.name,
        str(link.primitives),
        covered,
        "0" if link.covered else f"{low:.2f}" if low == high else f"{low:.2f}-{high:.2f}",
        f"{100 * link.share:.1f}",
        "" if link.witness is None else " ".join(f"{x:.4f}" for x in link.witness),
        _millimetres(link.excess),
        _millimetres(link.mean_excess),
    )


def _millimetres(length: float) -> str:
    return f"{1e3 * length:.1f}" if np.isfinite(length) else "-"


def _plain(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_plain(each) for each in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value


def audited(
    name: str, bodies: Sequence[GeometryObject], own: Primitives, others: Primitives, tolerance: float
) -> AuditedLink:
    """The findings about a link with its own primitives, and what of other links' primitives counts for it.

    The bounds of what is outside may differ by the tolerance, m.
    """
    regions = regions_of(bodies)
    every = own + others
    found = outside(regions, every, tolerance)
    excess = mean = area = float("nan")
    if regions and len(own):
        excess = greatest_excess(regions, own)
        mean, area = mean_excess(regions, own)
    return AuditedLink(
        name=name,
        primitives=len(own),
        covered=found.is_covered,
        outside=(found.lower, found.upper),
        witness=None if found.witness is None else _rounded(found.witness),
        share=0.0 if found.is_covered else share_outside(bodies, every),
        excess=excess,
        mean_excess=mean,
        area=area,
        exact_witness=found.witness,
    )


def _rounded(point: Point) -> tuple[float, float, float]:
    x, y, z = map(rounded, point)
    return x, y, z


def share_outside(bodies: Sequence[GeometryObject], cover: Primitives) -> float:
    """The part of the surface of bodies that is outside a cover, estimated; curved bodies by polytopes around them."""
    points = surface_of(bodies, _SAMPLES)
    return (
        float((cover.values(points).min(axis=1) > 0).mean()) if len(cover) and len(points) else float(len(points) > 0)
    )


def surface_of(bodies: Sequence[GeometryObject], count: int, seed: int = 0) -> Floats:
    """About so many points (n, 3) spread over the surfaces of a link's bodies, in the link's frame, m."""
    triangles = np.concatenate([posed(surface_triangles(body), np.asarray(body.pose)) for body in bodies])
    areas = np.linalg.norm(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1)
    if not areas.sum():
        return np.asarray(triangles[:, 0])
    generator = np.random.default_rng(seed)
    chosen = triangles[generator.choice(len(triangles), count, p=areas / areas.sum())]
    u, v = np.sqrt(generator.random(count)), generator.random(count)
    weights = np.column_stack([1 - u, u * (1 - v), u * v])
    return np.asarray(np.einsum("nk,nki->ni", weights, chosen))


def surface_triangles(body: GeometryObject) -> Floats:
    """(m, 3, 3) m, the triangles of a body in its frame; of a curved one those of a polytope around it."""
    (region,) = regions_of([body])
    return region.triangles if len(region.triangles) else _around(body)


def _around(body: GeometryObject) -> Floats:
    hull = Polytope(*body.shape.vertices_and_faces(_COARSE))
    return np.asarray(hull.vertices)[np.asarray(hull.faces)]


# How far the polytopes around curved bodies stick out, as a part of the radius, where points are only samples.
_COARSE = 1e-2
