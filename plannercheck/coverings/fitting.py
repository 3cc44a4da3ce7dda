"""Fits spheres to links, so that they cover them, proved, and stick out little.

In: the bodies of links, how many spheres, and on request how far they may stick out. Out: `Primitives` by link.

The idea: points of each link are parted into clusters, each with its smallest ball, as Lloyd's method does it with the
power distance. Links begin with one cluster; the cluster that sticks out most is split, in the link where this gains
most. Then balls are grown to hold the points that the search of `search` finds outside, until the rest is small, and
all of a link at last by the bound that it proves. Centres and radii are multiples of 2^-20 m, rounded up, which 32 bits
hold as well.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from plannercheck.bodies.shapes import GeometryObject
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.arrays import distinct_rows, grouped
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.real_numbers import check_length
from plannercheck.common.whole_numbers import whole_number
from plannercheck.coverings.audits import surface_of, surface_triangles
from plannercheck.coverings.excess import apart, greatest_excess, surface_points
from plannercheck.coverings.primitives import Primitives
from plannercheck.coverings.regions import Region, posed, regions_of
from plannercheck.coverings.search import outside

# Points of a link's surface, and cubes along its longest side whose middles are points of its inside.
_ON_SURFACE, _INSIDE = 1500, 12
# Rounds of Lloyd's method after a split, the move of centres at which it ends, m, and steps towards the middle of a
# ball.
_ROUNDS, _STILL, _STEPS = 20, 1e-5, 40
# How many balls are tried for a split, and how many splits are looked ahead at: one may gain nothing, two much.
_TRIED, _AHEAD = 2, 3
# Points on a sphere by which its excess is estimated while fitting.
_ON_SPHERE = 60
# How often balls grow to hold points outside, and what is left to common growth, m.
_REPAIRS, _REST = 20, 2e-4
# Centres and radii are multiples of this, m.
_GRID = 2.0**-20
# The part of a wanted excess that is left for the growth of the proof.
_RESERVE = 0.9


@dataclass(frozen=True, eq=False)
class _Link:
    """A link to fit: its bodies' regions, and points (n, 3) of its surface and inside, m."""

    regions: Sequence[Region]
    points: Floats

    @classmethod
    def of(cls, bodies: Sequence[GeometryObject]) -> _Link:
        regions = regions_of(bodies)
        corners = [posed(surface_triangles(body), np.asarray(body.pose)).reshape(-1, 3) for body in bodies]
        surface = surface_of(bodies, _ON_SURFACE)
        low, high = surface.min(axis=0), surface.max(axis=0)
        step = float((high - low).max()) / _INSIDE
        axes = [np.arange(a + step / 2, b, step) for a, b in zip(low.tolist(), high.tolist(), strict=True)]
        lattice = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
        inside = lattice[apart(regions, lattice) == 0] if len(lattice) else lattice
        return cls(regions, distinct_rows(np.concatenate([*corners, surface, inside]))[0])


@dataclass(frozen=True, eq=False)
class _Fit:
    """Balls of a link.

    Attributes:
        centres: (k, 3) m.
        radii: (k,) m.
        costs: (k,) m³: over the surface of each ball that is the cover's, the integral of the distance from the link.
        worst: m, the largest of these distances.
    """

    centres: Floats
    radii: Floats
    costs: Floats
    worst: float

    @classmethod
    def of(cls, link: _Link, centres: Floats, radii: Floats) -> _Fit:
        cover = _cover(centres, radii)
        points, areas = surface_points(cover, _ON_SPHERE)
        distances = apart(link.regions, points)
        owner = np.abs(cover.values(points)).argmin(axis=1)
        costs = np.bincount(owner, distances * areas, minlength=len(radii)).astype(np.float64)
        return cls(centres, radii, costs, float(distances.max(initial=0.0)))

    @property
    def cost(self) -> float:
        return float(self.costs.sum())


def fitted(bodies: Mapping[str, Sequence[GeometryObject]], spheres: int, excess: float | None) -> dict[str, Primitives]:
    """Spheres by link that are proved to hold its bodies.

    Args:
        bodies: The bodies of each link that has any.
        spheres: How many at most; exactly so many without an excess.
        excess: m, how far they may stick out.

    Raises:
        PlannercheckError: If the number or the excess is no such number, or they are too few for it.
    """
    _check_wanted(len(bodies), spheres, excess)
    links = {name: _Link.of(each) for name, each in bodies.items()}
    ahead = {name: [_lloyd(link, link.points.mean(axis=0)[None], np.zeros(1))] for name, link in links.items()}
    done: dict[str, Primitives] = {}
    for _ in range(spheres - len(links)):
        if excess is None:
            name = max(links, key=lambda each: _gain(links[each], ahead[each]))
        else:
            wide = _too_wide(links, {each: fits[0] for each, fits in ahead.items()}, done, excess)
            if not wide:
                return done
            name = max(wide, key=lambda each: ahead[each][0].worst)
            done.pop(name, None)
        _look_ahead(links[name], ahead[name], 2)
        del ahead[name][0]
    fits = {name: each[0] for name, each in ahead.items()}
    if excess is None:
        return {name: _proved(links[name], fit) for name, fit in fits.items()}
    wide = _too_wide(links, fits, done, excess)
    if wide:
        raise PlannercheckError(
            f"{spheres} spheres do not reach an excess of {excess} m: link {wide[0]!r} has more; allow more of one or "
            "the other"
        )
    return done


def _look_ahead(link: _Link, fits: list[_Fit], count: int) -> None:
    """Makes fits, each with one ball more, until there are so many."""
    while len(fits) < count:
        fits.append(_split(link, fits[-1]))


def _gain(link: _Link, fits: list[_Fit]) -> float:
    """The largest gain a split, of the next few splits."""
    _look_ahead(link, fits, _AHEAD + 1)
    return max((fits[0].cost - fit.cost) / (k + 1) for k, fit in enumerate(fits[1 : _AHEAD + 1]))


def _check_wanted(links: int, spheres: int, excess: float | None) -> None:
    if not links:
        raise PlannercheckError("the robot has no collision bodies to cover")
    whole_number(spheres, f"spheres must be a whole number of at least {links}, one a link", links)
    if excess is not None:
        check_length(excess, "excess")


def _too_wide(
    links: Mapping[str, _Link], fits: Mapping[str, _Fit], done: dict[str, Primitives], excess: float
) -> list[str]:
    """Links whose balls exceed what is wanted, by an estimate or else proved; the others are kept in `done`."""
    wide = [name for name, fit in fits.items() if fit.worst > _RESERVE * excess]
    for name, fit in fits.items():
        if wide or name in done:
            continue
        cover = _proved(links[name], fit)
        if greatest_excess(links[name].regions, cover) <= excess:
            done[name] = cover
        else:
            wide.append(name)
    return wide


def _split(link: _Link, fit: _Fit) -> _Fit:
    """The fit with one ball more: of the balls that cost most, one is split whose split gains most."""
    owner = _nearest(link.points, fit.centres, fit.radii)
    costly = [int(k) for k in np.argsort(-fit.costs) if (owner == k).any()]
    return min((_split_at(link, fit, link.points[owner == k], k) for k in costly[:_TRIED]), key=lambda each: each.cost)


def _split_at(link: _Link, fit: _Fit, own: Floats, worst: int) -> _Fit:
    """The fit with one cluster, of points of its own, cut across its longest direction."""
    middle = own.mean(axis=0)
    along = np.linalg.svd(own - middle, full_matrices=False)[2][0]
    sides = (own - middle) @ along > 0
    seeds = np.array([own[side].mean(axis=0) if side.any() else middle for side in (sides, ~sides)])
    radius = fit.radii[worst] / 2
    centres = np.concatenate([np.delete(fit.centres, worst, axis=0), seeds])
    return _lloyd(link, centres, np.append(np.delete(fit.radii, worst), [radius, radius]))


def _lloyd(link: _Link, centres: Floats, radii: Floats) -> _Fit:
    """Clusters by the nearest ball and balls about clusters, in turn."""
    for _ in range(_ROUNDS):
        owner = _nearest(link.points, centres, radii)
        moved, radii = _balls(link.points, owner, centres)
        still = bool(np.abs(moved - centres).max() < _STILL)
        centres = moved
        if still:
            break
    return _Fit.of(link, centres, radii)


def _nearest(points: Floats, centres: Floats, radii: Floats) -> Ints64:
    """(n,) the ball of the least power distance."""
    squares = sum((points[:, k, None] - centres[:, k]) ** 2 for k in range(3))
    return np.asarray(np.argmin(squares - radii**2, axis=1))


def _balls(points: Floats, owner: Ints64, centres: Floats) -> tuple[Floats, Floats]:
    """Centres (k, 3) and radii (k,), m, of balls around clusters of points, nearly the smallest (Badoiu and Clarkson).

    The cluster of each point is its `owner` (n,). Centres are on the grid; balls without points stay where they are.
    """
    order = np.argsort(owner, kind="stable")
    points, owner = points[order], owner[order]
    first = grouped(owner).first
    present = owner[first]
    sizes = np.diff(np.append(first, len(points)))
    low, high = np.minimum.reduceat(points, first), np.maximum.reduceat(points, first)
    middles = (low + high) / 2
    for step in range(_STEPS):
        squares = _squares(points - np.repeat(middles, sizes, axis=0))
        largest = np.repeat(np.maximum.reduceat(squares, first), sizes)
        rows = np.flatnonzero(squares == largest)
        furthest = points[rows[np.searchsorted(rows, first)]]
        middles = middles + (furthest - middles) / (step + 2)
    found, radii = centres.copy(), np.zeros(len(centres))
    found[present] = _GRID * np.rint(middles / _GRID)
    squares = _squares(points - np.repeat(found[present], sizes, axis=0))
    radii[present] = np.sqrt(np.maximum.reduceat(squares, first))
    return found, radii


def _squares(vectors: Floats) -> Floats:
    return np.asarray(np.einsum("ij,ij->i", vectors, vectors))


def _cover(centres: Floats, radii: Floats) -> Primitives:
    return replace(Primitives.of(), ends=np.stack([centres, centres], axis=1), radii=radii)


def _proved(link: _Link, fit: _Fit) -> Primitives:
    """The balls, grown until they are proved to hold the link."""
    cover = _cover(fit.centres, _up(fit.radii))
    for _ in range(_REPAIRS):
        found = outside(link.regions, cover, _REST / 4, inside=False)
        if found.witness is None or found.upper <= _REST:
            break
        values = cover.values(np.array([[float(x) for x in found.witness]]))[0]
        radii = cover.radii.copy()
        radii[values.argmin()] += values.min() + _GRID
        cover = _cover(fit.centres, _up(radii))
    while not (found := outside(link.regions, cover, _REST / 4)).is_covered:
        cover = _cover(fit.centres, _up(cover.radii + found.upper))
    return cover


def _up(radii: Floats) -> Floats:
    return np.asarray(_GRID * np.ceil(radii / _GRID))
