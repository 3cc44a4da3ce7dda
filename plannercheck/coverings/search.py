"""How far the bodies of a link are outside its cover, from both sides; 0 is proved exactly.

In: regions, the primitives of the cover. Out: `Outside`: a point that is furthest outside, as far as is known, and a
bound that no point exceeds.

The idea: branch and bound. The values of a primitive are convex, so over a triangle each is largest at a corner, and
the least of these bounds how far the triangle is outside. Triangles whose bound is no more than what is known are done,
others are cut into four. Curved regions are parted into cells with corners (see `curved_cells`), likewise. The inside
of other regions is covered by cubes: cubes off the region are left out, others are cut into eight. Primitives grown by
the bound so far hold the surface and the cubes that are done. What is left encloses no hole of theirs if it meets no
more than three of them: by the nerve theorem three convex bodies enclose nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product

import numpy as np

from plannercheck.bodies.exact_coverage import Parts
from plannercheck.common.array_types import Bools, Floats, Ints64
from plannercheck.coverings.curved_cells import Cells
from plannercheck.coverings.primitives import STEEPEST, Point, Primitives
from plannercheck.coverings.regions import Region, SolidRegion, posed, posed_exactly

# What the bounds may differ by, m: a twentieth of a millimetre.
TOLERANCE = 5e-5
# How often triangles are cut, and how small cubes get, m, before the rest is given up: far below what matters.
_MOST_CUTS, _FINEST = 40, 2.0**-24
# Triangles or cubes that are looked at in one step; beyond that, the bound is what they give.
_MOST_CELLS = 200_000
# Along its longest side, a region has so many cubes at first.
_FIRST_CUBES = 8
# Points of a step that are decided by fractions, and points in cubes that are tried; a bound on time alone.
_MOST_EXACT, _MOST_TRIED = 2000, 2000
# More convex bodies may enclose a hole.
_NO_HOLE = 3


@dataclass(frozen=True)
class Outside:
    """How far regions are outside their cover.

    Attributes:
        lower: m, of the witness; 0 if there is none.
        upper: m, no point is further outside; 0 if and only if the cover is proved to hold the regions.
        witness: A point of a region outside all primitives, exactly; None if none is known.
    """

    lower: float
    upper: float
    witness: Point | None

    @property
    def is_covered(self) -> bool:
        """Whether the cover is proved to hold the regions."""
        return self.upper <= 0.0


def outside(regions: Sequence[Region], cover: Primitives, tolerance: float = TOLERANCE, inside: bool = True) -> Outside:
    """How far the bodies of a link are outside a cover, between bounds.

    These differ by the tolerance, m, or more where a search has met its limits. Without `inside`, only the triangles of
    bodies are looked at, which proves nothing of the rest.
    """
    if not regions:
        return Outside(0.0, 0.0, None)
    if not len(cover):
        return Outside(np.inf, np.inf, _any_point(regions[0]))
    search = _Search(cover, tolerance)
    left = [region for region in regions if not region.is_in_one_of(cover)]
    for region in left:
        search.surface(region)
        for cells in region.cells():
            search.curved(cells, region)
    for region in left if inside else ():
        if isinstance(region, SolidRegion) and region.has_inside:
            search.inside(region)
    return Outside(search.lower, max(search.upper, search.lower), search.witness)


def _any_point(region: Region) -> Point:
    if len(region.triangles):
        return _exact(region.triangles[0], np.array([1, 0, 0]), 1, region.pose)
    x, y, z = region.near(region.pose[None, :3, 3])[1][0].tolist()
    return Fraction(x), Fraction(y), Fraction(z)


class _Search:
    """The bounds found so far."""

    def __init__(self, cover: Primitives, tolerance: float) -> None:
        self._cover, self._tolerance = cover, tolerance
        self.lower, self.upper = 0.0, 0.0
        self.witness: Point | None = None

    @property
    def _goal(self) -> float:
        """Cells that are no further outside are done."""
        return 0.0 if self.witness is None else self.lower + self._tolerance

    def surface(self, region: Region) -> None:
        """Looks at the triangles of a region."""
        parts = Parts.of(region.triangles)
        for cuts in range(_MOST_CUTS + 1):
            if not len(parts):
                return
            values = self._at_corners(parts, region.pose)
            error = self._cover.error(posed(parts.corners, region.pose))
            self._try_corners(parts, region, values.min(axis=2), error)
            bounds = values.max(axis=1)
            upper = bounds.min(axis=1) + error
            close = np.flatnonzero((upper > 0) & (upper <= 2 * error))[:_MOST_EXACT]
            upper[close[self._are_held(parts.of_rows(close), bounds[close] <= error, region)]] = 0.0
            done = upper <= self._goal
            self.upper = max(self.upper, float(upper[done].max(initial=0.0)))
            if cuts == _MOST_CUTS or np.count_nonzero(~done) > _MOST_CELLS // 4:
                self._give_up(float(upper[~done].max(initial=0.0)))
                return
            parts = parts.of_rows(~done).quartered()

    def _at_corners(self, parts: Parts, pose: Floats) -> Floats:
        """(m, 3, n) values at the corners."""
        points = posed(parts.corners, pose).reshape(-1, 3)
        return self._cover.values(points).reshape(-1, 3, len(self._cover))

    def _try_corners(self, parts: Parts, region: Region, values: Floats, error: float) -> None:
        """Takes the corner that is furthest outside for a witness, if it is further than the last."""
        for row, corner in _furthest(values, max(self.lower, -error), error, self.witness is None):
            point = _exact(parts.triangles[row], parts.weights[row, corner], parts.whole, region.pose)
            if self._take(point, float(values[row, corner]) - error):
                return

    def _take(self, point: Point, lower: float) -> bool:
        """Whether a point, which is at least so far outside, is outside by fractions, if doubles do not tell."""
        if lower <= 0 and any(self._cover.holds(k, point) for k in range(len(self._cover))):
            return False
        self.witness, self.lower = point, max(self.lower, lower, 0.0)
        return True

    def _are_held(self, parts: Parts, candidates: Bools, region: Region) -> Bools:
        """(m,) whether parts lie in one of the primitives that are candidates, by fractions."""
        found = np.zeros(len(parts), dtype=bool)
        for row in range(len(parts)):
            corners = [_exact(parts.triangles[row], w, parts.whole, region.pose) for w in parts.weights[row]]
            found[row] = any(
                all(self._cover.holds(int(k), corner) for corner in corners) for k in np.flatnonzero(candidates[row])
            )
        return found

    def curved(self, cells: Cells, region: Region) -> None:
        """Looks at the cells of a curved region."""
        for cuts in range(_MOST_CUTS + 1):
            corners = cells.corners()
            points = corners.reshape(-1, 3)
            values = self._cover.values(points).reshape(*corners.shape[:2], -1)
            self._try_points(points[np.argsort(-values.min(axis=2), axis=None)[:_MOST_TRIED]], region)
            upper = values.max(axis=1).min(axis=1) + self._cover.error(points)
            done = upper <= self._goal
            self.upper = max(self.upper, float(upper[done].max(initial=0.0)))
            if done.all():
                return
            if cuts == _MOST_CUTS or np.count_nonzero(~done) > _MOST_CELLS // 4:
                self._give_up(float(upper[~done].max()))
                return
            cells = cells.of_rows(~done).halved()

    def inside(self, region: SolidRegion) -> None:
        """Looks at the cubes of a region."""
        middles, half = _first_cubes(region)
        while len(middles):
            upper = self._cover.values_of_cubes(middles, half).min(axis=1) + self._cover.error(middles)
            rest = np.flatnonzero(upper > self._goal)
            self.upper = max(self.upper, float(np.delete(upper, rest).max(initial=0.0)))
            rest = rest[region.distances(middles[rest])[0] <= half * np.sqrt(3.0) * STEEPEST]
            middles, upper = middles[rest], upper[rest]
            self._try_points(middles[np.argsort(-upper)[:_MOST_TRIED]], region)
            rest = np.flatnonzero(upper > self._goal)
            self.upper = max(self.upper, float(np.delete(upper, rest).max(initial=0.0)))
            middles, upper = middles[rest], upper[rest]
            is_last = half <= _FINEST or 8 * len(middles) > _MOST_CELLS
            if self._encloses_nothing(middles, half, is_last):
                return
            if is_last:
                self._give_up(float(upper.max(initial=0.0)))
                return
            half /= 2
            middles = (middles[:, None] + half * _CORNERS).reshape(-1, 3)

    def _try_points(self, points: Floats, region: Region) -> None:
        """Takes the point of the region near given ones that is furthest outside for a witness, likewise."""
        known, points = region.near(points)
        points = points[known]
        if not len(points):
            return
        values, error = self._cover.values(points).min(axis=1)[:, None], self._cover.error(points)
        for row, _ in _furthest(values, max(self.lower, -error), error, self.witness is None):
            x, y, z = map(Fraction, points[row].tolist())
            if region.holds((x, y, z)) and self._take((x, y, z), float(values[row, 0]) - error):
                return

    def _give_up(self, upper: float) -> None:
        self.upper = max(self.upper, upper)

    def _encloses_nothing(self, middles: Floats, half: float, by_cluster: bool) -> bool:
        """Whether cubes, or each cluster of cubes that touch, meet too few primitives, grown by `upper`, for a hole."""
        reach = self.upper + half * np.sqrt(3.0) * STEEPEST
        meets = self._cover.values(middles) <= reach + self._cover.error(middles)
        if meets.any(axis=0).sum() <= _NO_HOLE:
            return True
        return by_cluster and all(meets[rows].any(axis=0).sum() <= _NO_HOLE for rows in _clusters(middles, half))


_CORNERS = np.array(list(product((-1.0, 1.0), repeat=3)))
_ZERO = Fraction(0)


def _furthest(values: Floats, least: float, error: float, is_first: bool) -> list[tuple[int, int]]:
    """Rows and columns of points to try, the furthest first: one that is surely further out than `least`, or a few."""
    order = np.argsort(-values, axis=None)[: 1 if values.max() - error > max(least, 0.0) else _MOST_EXACT]
    if not is_first:
        order = order[:1]
    rows, columns = np.unravel_index(order, values.shape)
    wanted = values[rows, columns] - error > least if not is_first else values[rows, columns] > least
    return list(zip(rows[wanted].tolist(), columns[wanted].tolist(), strict=True))


def _exact(triangle: Floats, weights: Ints64, whole: int, pose: Floats) -> Point:
    """A point of a triangle (3, 3) in a body's frame, in the link's."""
    shares = [Fraction(weight, whole) for weight in weights.tolist()]
    corners = [[Fraction(x) for x in corner] for corner in triangle.tolist()]
    own = [sum((share * corner[k] for share, corner in zip(shares, corners, strict=True)), _ZERO) for k in range(3)]
    return posed_exactly(own, pose)


def _first_cubes(region: SolidRegion) -> tuple[Floats, float]:
    """Middles (n, 3) of cubes that cover a region, and half an edge length, a power of two, m."""
    low, high = region.box()
    half = 2.0 ** np.ceil(np.log2(max(float((high - low).max()), _FINEST) / (2 * _FIRST_CUBES)))
    first, last = np.floor(low / (2 * half)) - 1, np.ceil(high / (2 * half)) + 1
    steps = [np.arange(a, b) for a, b in zip(first.tolist(), last.tolist(), strict=True)]
    lattice = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3)
    return 2 * half * lattice + half, half


def _clusters(middles: Floats, half: float) -> list[Ints64]:
    """Cubes by connected cluster, those with a common corner included."""
    places = {tuple(place): row for row, place in enumerate(np.rint(middles / half).astype(np.int64).tolist())}
    steps = [step for step in product((-2, 0, 2), repeat=3) if any(step)]
    clusters, seen = [], set[int]()
    for place, row in places.items():
        if row in seen:
            continue
        seen.add(row)
        stack, cluster = [place], []
        while stack:
            at = stack.pop()
            cluster.append(places[at])
            for step in steps:
                near = tuple(a + b for a, b in zip(at, step, strict=True))
                if near in places and places[near] not in seen:
                    seen.add(places[near])
                    stack.append(near)
        clusters.append(np.array(cluster, dtype=np.int64))
    return clusters
