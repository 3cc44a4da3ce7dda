"""Random draws of the stress of solids.

In: a seed and a number. Out: a `Draw`: two bodies and poses of both, at one contact for each of OFFSETS, or at random.

A draw takes one value of each list: how the bodies lie, the family and number of triangles of either, the fault of its
mesh (`variations`), the sizes, the distance from the origin, the rotations.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.evaluation.campaign.posed_pairs import ANY_OFFSET, PosedPairs
from plannercheck.evaluation.stress.contact_poses import identities, random_directions
from plannercheck.evaluation.stress.random_cases import EXTREME_SIZES
from plannercheck.evaluation.stress_solids.bodies import (
    CONVEX_FAMILIES,
    DENTED,
    TORN,
    Body,
    random_convex,
    random_dented,
    random_solid,
    random_torn,
)
from plannercheck.evaluation.stress_solids.common_frames import PARTNERS
from plannercheck.evaluation.stress_solids.placing import OFFSETS, ROTATIONS, Place, around_contact, offset, turn
from plannercheck.evaluation.stress_solids.solid_families import LARGE_FAMILIES, SOLID_FAMILIES

# Sizes of the first body, m, as powers of two about 1e-6 to 1e6, which keep lattices exact; and those of the second.
_SIZE_EXPONENTS = (-20, -13, -10, -7, -3, 0, 0, 0, 0, 3, 7, 10, 13, 20)
_RATIO_EXPONENTS = (0, 0, 0, 0, 0, -1, 1, -3, 3, -10, 10, -20, 20)
_LARGEST_EXPONENT = 20
DISTANCES = (0.0, 0.0, 0.0, 1.0, 1024.0, 2.0**20)
# About how many triangles a solid has, and how often; those of LARGE_FAMILIES and LARGEST are rarer.
COUNTS = (12, 30, 60, 120, 300, 1000)
_COUNT_WEIGHTS = (0.3, 0.3, 0.2, 0.12, 0.06, 0.02)
LARGEST = (10_000, 100_000)
_LARGEST_WEIGHTS, _LARGE_SHARE = (0.95, 0.05), 0.002
_ROBOT_SHARE, _CONVEX_SHARE = 0.01, 0.2
CONTACT, ANYWHERE, INSIDE, EXTREME = "contact", "anywhere", "inside", "extreme scales"
_RELATIONS = (CONTACT, ANYWHERE, INSIDE, EXTREME, *PARTNERS, DENTED, TORN)
_PARTNER_WEIGHT = 0.2 / len(PARTNERS)
_RELATION_WEIGHTS = (
    *(0.54, 0.06, 0.14, 0.01),
    *[_PARTNER_WEIGHT] * (len(PARTNERS) - 1),
    *[_PARTNER_WEIGHT / 2] * 2,
    0.05,
)
# Families for which whole numbers of thousands of digits take no longer than others for doubles.
_FEW_TRIANGLES = ("tetrahedra", "triangle soup", "one triangle", "star", "nested boxes")
# Powers of two by which a body is smaller than one that it may be inside of, and how far it is from a face, over
# its size.
_SMALLER_EXPONENTS, _DEPTHS = (-14, -10, -8, -7, -6), (0.005, 0.02, 0.05, 0.1)
# Moments of contact of the same two bodies, and poses anywhere.
_CONTACTS, _POSES = 2, 24
FAMILY_NAMES = (*SOLID_FAMILIES, *CONVEX_FAMILIES, *PARTNERS, EXTREME, DENTED, TORN)
Draw: TypeAlias = PosedPairs[Body]


def numbered_draw(seed: int, number: int) -> Draw:
    """The `number`-th draw of a seed, which can be made again alone."""
    return draw(np.random.default_rng([seed, number]))


def draw(rng: np.random.Generator) -> Draw:
    """A random draw."""
    relation = str(rng.choice(_RELATIONS, p=_RELATION_WEIGHTS))
    return _DRAWN.get(relation, _same_frame)(relation, rng)


def _in_contact(relation: str, rng: np.random.Generator) -> Draw:
    p, r = _bodies(rng)
    poses = [around_contact(p, r, _place(rng), rng) for _ in range(_CONTACTS)]
    return _drawn(p.family, relation, p, r, poses, tuple(OFFSETS) * _CONTACTS)


def _anywhere(relation: str, rng: np.random.Generator) -> Draw:
    """Centres about as far apart as the bodies are large: across, inside and beside each other."""
    p, r = _bodies(rng)
    return _drawn_anywhere(p.family, relation, p, r, rng)


def _drawn_anywhere(family: str, relation: str, p: Body, r: Body, rng: np.random.Generator) -> Draw:
    """Both bodies with centres about as far apart as they are large."""
    poses_p, poses_r = identities(_POSES), identities(_POSES)
    for k in range(_POSES):
        place = _place(rng)
        shift = place.pose_r[:3, 3] + 0.6 * rng.uniform(0, max(p.size, r.size)) * random_directions(1, rng)[0]
        poses_p[k], poses_r[k] = (found[0] for found in place.poses(shift[None]))
    return _drawn(family, relation, p, r, [(poses_p, poses_r)], (ANY_OFFSET,) * _POSES)


def _inside(relation: str, rng: np.random.Generator) -> Draw:
    """A small body just in front of or behind a triangle of a large one: inside of it, in a cavity or outside."""
    exponent = int(rng.choice(_SIZE_EXPONENTS))
    large = _solid(2.0**exponent, rng)
    smaller = 2.0 ** (exponent + int(rng.choice(_SMALLER_EXPONENTS)))
    small = _convex(smaller, rng) if rng.random() < 2 * _CONVEX_SHARE else _solid(smaller, rng)
    poses_p, poses_r = identities(_POSES), identities(_POSES)
    for k in range(_POSES):
        place = _place(rng)
        target = place.pose_r[:3, :3] @ _beside_triangle(large, rng) + place.pose_r[:3, 3]
        corner = small.surface.points[rng.integers(len(small.surface.points))]
        poses_p[k], poses_r[k] = (found[0] for found in place.poses((target - place.turn_p @ corner)[None]))
    if rng.integers(2):
        return _drawn(large.family, relation, large, small, [(poses_r, poses_p)], (ANY_OFFSET,) * _POSES)
    return _drawn(large.family, relation, small, large, [(poses_p, poses_r)], (ANY_OFFSET,) * _POSES)


def _at_extreme_scales(relation: str, rng: np.random.Generator) -> Draw:
    """In contact at the ends of the doubles' range, alike in size or not, also far from the origin."""
    size = float(rng.choice(EXTREME_SIZES))
    other = size if rng.integers(3) else float(rng.choice([1.0, *EXTREME_SIZES]))
    families = [str(name) for name in rng.choice(_FEW_TRIANGLES, 2)]
    p, r = (random_solid(name, COUNTS[0], s, rng) for name, s in zip(families, (size, other), strict=True))
    distance = float(rng.choice([0.0, 0.0, 0.0, 1.0, min(size, other), max(size, other)]))
    poses = [around_contact(p, r, _place(rng, [distance]), rng) for _ in range(_CONTACTS)]
    return _drawn(relation, relation, p, r, poses, tuple(OFFSETS) * _CONTACTS)


def dented_draw(relation: str, rng: np.random.Generator) -> Draw:
    """A solid that is nearly its hull, and another or a convex body, in contact or across each other."""
    exponent = int(rng.choice(_SIZE_EXPONENTS))
    p, r = (random_dented(_count(rng), 2.0 ** (exponent + int(rng.integers(-2, 3))), rng) for _ in range(2))
    if rng.random() < 2 * _CONVEX_SHARE:
        r = _convex(p.size, rng)
    if rng.integers(2):
        p, r = r, p
    poses = [around_contact(p, r, _place(rng), rng) for _ in range(_CONTACTS)]
    return _drawn(relation, relation, p, r, poses, tuple(OFFSETS) * _CONTACTS)


def torn_draw(relation: str, rng: np.random.Generator) -> Draw:
    """A solid of an open mesh with caps, and another or a convex body: in contact, or across and inside each other."""
    size = 2.0 ** float(rng.choice(_SIZE_EXPONENTS))
    p, r = random_torn(_count(rng), size, rng), random_torn(_count(rng), size, rng)
    if rng.random() < 2 * _CONVEX_SHARE:
        r = _convex(size * 2.0 ** -int(rng.integers(5)), rng)
    if rng.integers(2):
        p, r = r, p
    if rng.integers(2):
        return _drawn_anywhere(relation, relation, p, r, rng)
    poses = [around_contact(p, r, _place(rng), rng) for _ in range(_CONTACTS)]
    return _drawn(relation, relation, p, r, poses, tuple(OFFSETS) * _CONTACTS)


def _beside_triangle(body: Body, rng: np.random.Generator) -> Floats:
    """A point (3,) beside an inner point of a triangle, m."""
    a, b, c = body.surface.points[body.surface.triangles[rng.integers(len(body.surface.triangles))]]
    normal = np.cross(b - a, c - a)
    length = float(np.linalg.norm(normal))
    normal = normal / length if length > 0 else random_directions(1, rng)[0]
    depth = float(rng.choice(_DEPTHS)) * body.size * rng.choice([-1, 1])
    return np.asarray((a + b + c) / 3 + depth * normal)


def _same_frame(relation: str, rng: np.random.Generator) -> Draw:
    """Both at one pose, and moved by the offsets along an axis or any way."""
    count, size = _count(rng), 2.0 ** float(rng.choice(_SIZE_EXPONENTS))
    p, r = (Body(relation, found.scaled(size)) for found in PARTNERS[relation](count, rng))
    if rng.integers(2):
        p, r = r, p
    poses = []
    for _ in range(_CONTACTS):
        place = _place(rng)
        place = Place(place.pose_r[:3, :3], place.pose_r)
        at = place.pose_r[:3, 3]
        direction = place.turn_p[:, rng.integers(3)] if rng.integers(2) else random_directions(1, rng)[0]
        poses.append(place.poses(offset(at, at, direction * rng.choice([-1, 1]), min(p.size, r.size))))
    return _drawn(relation, relation, p, r, poses, tuple(OFFSETS) * _CONTACTS)


_DRAWN: dict[str, Callable[[str, np.random.Generator], Draw]] = {
    CONTACT: _in_contact,
    ANYWHERE: _anywhere,
    INSIDE: _inside,
    EXTREME: _at_extreme_scales,
    DENTED: dented_draw,
    TORN: torn_draw,
}


def _place(rng: np.random.Generator, distances: Sequence[float] = DISTANCES) -> Place:
    pose_r = np.eye(4)
    pose_r[:3, :3] = turn(str(rng.choice(ROTATIONS)), rng)
    pose_r[rng.integers(3), 3] = rng.choice(distances)
    return Place(turn(str(rng.choice(ROTATIONS)), rng), pose_r)


def _count(rng: np.random.Generator) -> int:
    if rng.random() < _LARGE_SHARE:
        return int(rng.choice(LARGEST, p=_LARGEST_WEIGHTS))
    return int(rng.choice(COUNTS, p=_COUNT_WEIGHTS))


def _bodies(rng: np.random.Generator) -> tuple[Body, Body]:
    """A solid and another, or a convex body, in any order."""
    exponent = int(rng.choice(_SIZE_EXPONENTS))
    second = min(exponent + int(rng.choice(_RATIO_EXPONENTS)), _LARGEST_EXPONENT)
    p, r = (_solid(2.0**e, rng) for e in (exponent, second))
    if rng.random() < _CONVEX_SHARE:
        r = _convex(2.0**second, rng)
    return (p, r) if rng.integers(2) else (r, p)


def _convex(size: float, rng: np.random.Generator) -> Body:
    return random_convex(str(rng.choice(list(CONVEX_FAMILIES))), _count(rng), size, rng)


def _solid(size: float, rng: np.random.Generator) -> Body:
    is_large = rng.random() < _ROBOT_SHARE
    names = LARGE_FAMILIES if is_large else [name for name in SOLID_FAMILIES if name not in LARGE_FAMILIES]
    return random_solid(str(rng.choice(list(names))), _count(rng), size, rng)


def _drawn(
    family: str, relation: str, p: Body, r: Body, poses: list[tuple[Floats, Floats]], offsets: tuple[str, ...]
) -> Draw:
    bodies = " | ".join(f"{body.family} {len(body.surface.triangles)} {body.size:.1e} m" for body in (p, r))
    row = next(name for name in FAMILY_NAMES if family == name or family.startswith(name + " "))
    poses_p, poses_r = (np.concatenate(part) for part in zip(*poses, strict=True))
    return Draw(row, f"{relation}: {bodies}", p, r, poses_p, poses_r, offsets)
