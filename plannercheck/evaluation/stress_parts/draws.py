"""Random draws of the stress of sets of parts.

In: a seed and a number. Out: a `Draw`: a set, another body and poses of both, at a contact of one part or at random.
Any body may lie on a half-space; an ellipsoid may meet a point.

A draw takes one value of each list: how the bodies lie, the set's family and number of parts, the kind of the other
body, the sizes, the rotation, the distance from the origin.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np

from plannercheck.bodies.circumscribed import ball_around
from plannercheck.common.array_types import Floats
from plannercheck.evaluation.campaign.posed_pairs import ANY_OFFSET, PosedPairs
from plannercheck.evaluation.stress.contact_poses import random_directions
from plannercheck.evaluation.stress.random_cases import (
    DISTANCES,
    GAPS,
    ROTATIONS,
    SIZES,
    Placement,
    in_contact,
    random_specimen,
)
from plannercheck.evaluation.stress.sample_bodies import Specimen, prepared
from plannercheck.evaluation.stress_parts.bodies import Body, of_hull, of_solid
from plannercheck.evaluation.stress_parts.given import Balls, Oval
from plannercheck.evaluation.stress_parts.half_space_placing import lowered, random_half_space
from plannercheck.evaluation.stress_parts.set_families import SETS, random_set
from plannercheck.evaluation.stress_solids.bodies import random_solid
from plannercheck.evaluation.stress_solids.placing import OFFSETS, Place, around_contact, turn
from plannercheck.evaluation.stress_solids.placing import ROTATIONS as TURNS
from plannercheck.evaluation.stress_solids.solid_families import LARGE_FAMILIES, SOLID_FAMILIES

# Parts of a set, and how often: one leaf, one node, two and three levels of nodes.
COUNTS = (1, 2, 7, 8, 9, 20, 50, 65, 200, 600, 5000)
_COUNT_WEIGHTS = (0.06, 0.09, 0.1, 0.1, 0.12, 0.22, 0.12, 0.08, 0.08, 0.028, 0.002)
# Of two sets, each pair of whose parts the oracle may be asked for.
_FEW_PARTS = 30
# Sizes of another body over that of the set.
_RATIOS = (1.0, 1.0, 0.3, 0.3, 0.1, 0.1, 3.0, 10.0, 1e-2, 1e-3, 1e3)
WITH_HULL, WITH_SET, WITH_SOLID, WITH_HALF_SPACE, WITH_ELLIPSOID = "hull", "set", "solid", "half-space", "ellipsoid"
# What is laid on half-spaces, and how often; how many parts a set has then: the core asks one by one.
_ON_HALF_SPACES = {WITH_HULL: 0.35, WITH_SET: 0.35, WITH_SOLID: 0.15, WITH_ELLIPSOID: 0.15}
_SOME_PARTS = 200
# Of ellipsoids: about the excesses, the least of the radii over the size; how often they meet a point, not a set.
_EXCESSES, _THINNEST, _POINTS = (0.5, 0.1, 0.02), 1e-3, 0.5
# Which part is put in contact: any, one that is furthest along a direction, or the hull of the whole set.
_ANY_PART, _OUTER_PART, _WHOLE = range(3)
_MOST_CORNERS_OF_WHOLE = 600
# The part of the draws that have only poses that are not about a contact.
_ANYWHERE, _POSES = 0.15, 24
_SOLID_TRIANGLES = (12, 30, 60)
FAMILY_NAMES = (*SETS, WITH_HALF_SPACE, WITH_ELLIPSOID)
OFFSET_NAMES = (*GAPS, *(name for name in OFFSETS if name not in GAPS), ANY_OFFSET)
Draw: TypeAlias = PosedPairs[Body]  # of a set, or on a half-space of any body, and another body


def numbered_draw(seed: int, number: int) -> Draw:
    """The `number`-th draw of a seed, which can be made again alone."""
    return draw(np.random.default_rng([seed, number]))


def draw(rng: np.random.Generator) -> Draw:
    """A random draw."""
    other = str(rng.choice(list(OTHERS), p=[each.share for each in OTHERS.values()]))
    family, size = str(rng.choice(list(SETS))), float(rng.choice(SIZES))
    count = int(rng.choice(COUNTS, p=_COUNT_WEIGHTS))
    p = random_set(family, count if other == WITH_HULL else min(count, _FEW_PARTS), size, rng)
    second = size * float(rng.choice(_RATIOS))
    r = OTHERS[other].make(second, rng)
    if other == WITH_HALF_SPACE:
        p = _on_a_half_space(count, size, rng)
        family = WITH_HALF_SPACE if p.inner is None else WITH_ELLIPSOID
    if other == WITH_ELLIPSOID:
        family = WITH_ELLIPSOID
        if rng.random() < _POINTS:
            p = Body("point", Balls(0.0, size * rng.normal(size=(1, 3)), np.zeros(1)))
    if other == WITH_SOLID:
        poses_p, poses_r, offsets = _about_a_solid(p, r, rng)
    elif rng.random() < _ANYWHERE:
        poses_p, poses_r, offsets = _anywhere(p, r, size, rng)
    else:
        poses_p, poses_r, offsets = _in_contact(p, r, rng)
    label = f"{p.family} of {len(p.pieces)} parts, {size:.0e} m | {r.family} of {len(r.pieces)}, {second:.0e} m"
    return Draw(family, label, p, r, poses_p, poses_r, offsets)


def _any_hull(size: float, rng: np.random.Generator) -> Body:
    return of_hull(random_specimen(size, rng))


def _any_set(size: float, rng: np.random.Generator) -> Body:
    return random_set(str(rng.choice(list(SETS))), int(rng.integers(1, _FEW_PARTS)), size, rng)


def _any_solid(size: float, rng: np.random.Generator) -> Body:
    family = str(rng.choice([name for name in SOLID_FAMILIES if name not in LARGE_FAMILIES]))
    return of_solid(random_solid(family, int(rng.choice(_SOLID_TRIANGLES)), size, rng))


def _on_a_half_space(count: int, size: float, rng: np.random.Generator) -> Body:
    kind = str(rng.choice(list(_ON_HALF_SPACES), p=list(_ON_HALF_SPACES.values())))
    if kind == WITH_SET:
        return random_set(str(rng.choice(list(SETS))), min(count, _SOME_PARTS), size, rng)
    return OTHERS[kind].make(size, rng)


def _any_ellipsoid(size: float, rng: np.random.Generator) -> Body:
    radii = size * np.exp(rng.uniform(np.log(_THINNEST), 0, size=3))
    padding = float(rng.choice([0.0, 0.0, 0.1])) * size
    return Body(WITH_ELLIPSOID, Oval(padding, radii, least_excess(float(rng.choice(_EXCESSES)))))


def least_excess(excess: float) -> float:
    """The least excess of the polytope of an excess, with which the inner one has its corners on the ellipsoid."""
    return float(np.linalg.norm(ball_around(excess).points, axis=1).max() - 1)


class Other(NamedTuple):
    """What sets are put in contact with: in which part of the draws, and how it is made of a size in m."""

    share: float
    make: Callable[[float, np.random.Generator], Body]


OTHERS = {
    WITH_HULL: Other(0.74, _any_hull),
    WITH_SET: Other(0.1, _any_set),
    WITH_SOLID: Other(0.04, _any_solid),
    WITH_HALF_SPACE: Other(0.08, random_half_space),
    WITH_ELLIPSOID: Other(0.04, _any_ellipsoid),
}
_Placed = tuple[Floats, Floats, tuple[str, ...]]


def _in_contact(p: Body, r: Body, rng: np.random.Generator) -> _Placed:
    """A part of each body, features of both facing each other, in each of GAPS; of an ellipsoid either polytope."""
    p, r = (body.inner if body.inner is not None and rng.integers(2) else body for body in (p, r))
    first = _specimen_of(p, rng)
    found = in_contact("contact", _placement(rng), first, _specimen_of(r, rng), rng)
    poses_p = found.poses_p
    if r.half_space is not None:
        poses_p = lowered(p, poses_p, r.half_space, found.poses_r, first.size)
    return poses_p, found.poses_r, tuple(GAPS)


def _specimen_of(body: Body, rng: np.random.Generator) -> Specimen:
    if body.half_space is not None:
        return prepared("plate", body.half_space.shape.plate(body.half_space.padding or 1.0), body.half_space.padding)
    mode = _WHOLE if body.solid is not None else int(rng.integers(3))
    if mode == _WHOLE and (body.solid is not None or len(body.corners) <= _MOST_CORNERS_OF_WHOLE):
        return body.whole
    if mode == _ANY_PART:
        return body.pieces[rng.integers(len(body.pieces))].specimen
    direction = random_directions(1, rng)[0]
    furthest = [float((piece.corners @ direction).max()) + piece.radius for piece in body.pieces]
    return body.pieces[int(np.argmax(furthest))].specimen


def _anywhere(p: Body, r: Body, size: float, rng: np.random.Generator) -> _Placed:
    """A part of each near each other: across, inside and beside."""
    found = in_contact("anywhere", _placement(rng), _specimen_of(p, rng), _specimen_of(r, rng), rng)
    some = rng.permutation(len(found.poses_p))[:_POSES]
    poses_p, poses_r = found.poses_p[some], found.poses_r[some]
    poses_p[:, :3, 3] += size * rng.uniform(0, 0.7, size=(_POSES, 1)) * random_directions(_POSES, rng)
    return poses_p, poses_r, (ANY_OFFSET,) * _POSES


def _about_a_solid(p: Body, r: Body, rng: np.random.Generator) -> _Placed:
    """A part around the moment at which it begins to share a point with a solid."""
    assert r.solid is not None
    piece, pose_r = p.pieces[rng.integers(len(p.pieces))], np.eye(4)
    pose_r[:3, :3] = turn(str(rng.choice(TURNS)), rng)
    place = Place(turn(str(rng.choice(TURNS)), rng), pose_r)
    return *around_contact(piece.surface, r.solid, place, rng), tuple(OFFSETS)


def _placement(rng: np.random.Generator) -> Placement:
    return Placement(str(rng.choice(ROTATIONS)), float(rng.choice(DISTANCES)))
