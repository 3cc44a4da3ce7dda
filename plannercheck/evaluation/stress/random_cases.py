"""The cases of the stress suite as data, and random draws from them.

In: a random generator. Out: a `Draw`: two bodies and poses of both, one for each gap of GAPS.

A draw takes one value of each list: how the bodies lie (RELATIONS), the family and number of vertices of either, the
smaller body's size, the ratio of the sizes, the distance from the origin, the rotation. Gaps are along a direction in
which the bodies face each other. Rounding changes them, so exact arithmetic decides the verdict.
"""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from plannercheck.bodies.shapes import RIGID_TOLERANCE
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.campaign.posed_pairs import PosedPairs
from plannercheck.evaluation.stress.contact_poses import (
    Points,
    identities,
    quarter_turns,
    random_directions,
    turned,
    turns_onto,
    unit,
)
from plannercheck.evaluation.stress.sample_bodies import HULLS, INFLATED, Indices, Specimen, prepared, specimen
from plannercheck.evaluation.stress.touching_neighbours import NEIGHBOURS, neighbours

# Sizes of the smaller body, m; the larger one over it, up to LARGEST; distances from the origin, m.
SIZES = tuple(10.0**k for k in range(-6, 7))
RATIOS = (1.0, 1.0, 1.0, 3.0, 10.0, 1e2, 1e3, 1e4, 1e5, 1e6)
LARGEST = 1e6
DISTANCES = (0.0, 0.0, 1.0, 1e3, 1e6)
ROTATIONS = ("none", "axis-aligned", "1e-9 rad", "random", "off rigid")
TINY_ANGLE = 1e-9  # rad
# Of poses off rigid: ‖MᵀM − 1‖ in the Frobenius norm, as far as poses are accepted, but for rounding.
OFF_RIGID = RIGID_TOLERANCE * (1 - 1e-9)
# Of the smaller of two bodies at the ends of the doubles' range, m, where squares of lengths or their products with
# others underflow or overflow; the other one is as large, or of one of these sizes. Coordinates are taken up to 1e50.
EXTREME_SIZES = tuple(10.0**k for k in (-310, -300, -250, -200, -165, -161, -158, -152, -121, -100, -50, 20, 40, 49))
EXTREME_DISTANCES = (0.0, 0.0, 0.0, 1.0, 1e100, 1e300)
# Powers of two of the sizes of flat bodies with coinciding centres.
COINCIDING_EXPONENTS = (-1040, -700, -560, -540, -530, -400, -20, 0, 20)
# Points a body, and how often: exact arithmetic in Python pays for every one.
COUNTS = (8, 16, 40, 100, 300, 1000)
COUNT_WEIGHTS = (0.35, 0.25, 0.2, 0.14, 0.05, 0.01)
# Gaps over the smaller body's size, by name, and one step of the translation's doubles.
GAPS: dict[str, float] = {
    "0": 0.0,
    **{f"{sign}1e-{k}": float(f"{sign}1e-{k}") for k in range(2, 19) for sign in "+-"},
    "+1 ulp": 0.0,
    "-1 ulp": 0.0,
}
_GAPS = np.array(list(GAPS.values()))
_STEPS = np.array([{"+1 ulp": 1, "-1 ulp": -1}.get(name, 0) for name in GAPS])


Draw: TypeAlias = PosedPairs[Specimen]  # at a pose for each of GAPS


@dataclass(frozen=True)
class Placement:
    """Where and how bodies lie: the rotation's name, the distance from the origin in m."""

    rotation: str
    distance: float


def draws(seed: int) -> Iterator[Draw]:
    """Random draws without end, without those whose bodies can't be prepared."""
    for number in itertools.count():
        with contextlib.suppress(PlannercheckError):
            yield numbered_draw(seed, number)


def numbered_draw(seed: int, number: int) -> Draw:
    """The `number`-th draw of a seed, which can be made again alone."""
    return draw(np.random.default_rng([seed, number]))


def draw(rng: np.random.Generator) -> Draw:
    """A random draw: mostly any two bodies in contact, else special pairs."""
    relation = str(rng.choice(list(RELATIONS), p=list(_RELATION_WEIGHTS)))
    placement = Placement(str(rng.choice(ROTATIONS)), float(rng.choice(DISTANCES)))
    return RELATIONS[relation](relation, placement, rng)


def contact(relation: str, placement: Placement, rng: np.random.Generator) -> Draw:
    """Any two bodies, features of both facing each other."""
    size, ratio = float(rng.choice(SIZES)), float(rng.choice(RATIOS))
    return _in_contact(relation, placement, [size, min(size * ratio, max(size, LARGEST))], rng)


def extreme_scales(relation: str, placement: Placement, rng: np.random.Generator) -> Draw:
    """The same at the ends of the doubles' range, alike in size or not, also far away, where gaps are lost."""
    size = float(rng.choice(EXTREME_SIZES))
    other = size if rng.integers(3) else float(rng.choice([1.0, *EXTREME_SIZES]))
    placement = Placement(placement.rotation, float(rng.choice([*EXTREME_DISTANCES, min(size, other)])))
    return replace(_in_contact(relation, placement, [size, other], rng), family=relation)


def coinciding_centres(relation: str, placement: Placement, rng: np.random.Generator) -> Draw:
    """Two flat bodies of one plane whose centres are the same point, exactly, the plane turned about across an axis.

    Their vertices lie on a lattice in pairs about that point, so they share it at every pose that both have.
    """
    normal, middle = rng.integers(1, 10, 3), rng.integers(-2000, 2000, 3)
    scale = 2.0 ** int(rng.choice(COINCIDING_EXPONENTS)) / 2**12
    p, r = (prepared(relation, _about(middle, normal, rng) * scale) for _ in range(2))
    axes, k = quarter_turns(len(_GAPS), rng)[:, 0], len(_GAPS)
    poses = _posed(turns_onto(np.tile(unit(normal[None].astype(float)), (k, 1)), axes, rng))
    moved = poses.copy()
    moved[:, :3, 3] = (min(p.size, r.size) * _GAPS)[:, None] * axes
    moved[:, :3, 3] = _stepped(moved[:, :3, 3], axes)
    return Draw(relation, _label(relation, placement, p, r), p, r, moved, poses, tuple(GAPS))


def _about(middle: Indices, normal: Indices, rng: np.random.Generator) -> Points:
    """Points (2 k, 3) of a lattice in pairs about a middle in the plane at right angles to a normal; all exact."""
    arms = np.cross(normal, rng.integers(-8, 9, (2, 3)))
    off = rng.integers(-4, 5, (rng.integers(1, 4), 2)) @ arms
    return np.vstack([middle + off, middle - off]).astype(np.float64)


def _in_contact(relation: str, placement: Placement, sizes: list[float], rng: np.random.Generator) -> Draw:
    p, r = (random_specimen(s, rng) for s in rng.permuted(sizes))
    return in_contact(relation, placement, p, r, rng)


def in_contact(relation: str, placement: Placement, p: Specimen, r: Specimen, rng: np.random.Generator) -> Draw:
    """Two bodies, features of both facing each other."""
    facing = _aligned if placement.rotation == "random" and rng.integers(2) else _as_they_lie
    turn_p, turn_r, point_p, point_r, directions = facing(p, r, placement, rng)
    gap = min(p.size, r.size) * _GAPS
    poses_p, poses_r = _posed(turn_p), _posed(turn_r)
    poses_r[:, :3, 3] = _far_away(placement, rng)
    touch = poses_r[:, :3, 3] + turned(poses_r, point_r) - turned(poses_p, point_p)
    poses_p[:, :3, 3] = touch + (p.inflation_radius + r.inflation_radius + gap)[:, None] * directions
    poses_p[:, :3, 3] = _stepped(poses_p[:, :3, 3], directions)
    return Draw(p.family, _label(relation, placement, p, r), p, r, poses_p, poses_r, tuple(GAPS))


def same_frame(relation: str, placement: Placement, rng: np.random.Generator) -> Draw:
    """Two bodies made in one frame, so that what they share they share exactly, at any pose; then moved by the gap."""
    size = float(2.0 ** np.round(np.log2(rng.choice(SIZES))))  # a power of two keeps the points exact
    p, r, outward = _PARTNERS[relation](size, rng)
    poses_r = _posed(np.repeat(_turns(placement, 1, rng), len(_GAPS), axis=0))
    poses_r[:, :3, 3] = _far_away(placement, rng)
    poses_p = poses_r.copy()
    directions = _facing(poses_p[:, :3, :3], outward, placement)
    poses_p[:, :3, 3] += (min(p.size, r.size) * _GAPS)[:, None] * directions
    poses_p[:, :3, 3] = _stepped(poses_p[:, :3, 3], directions)
    return Draw(relation, _label(relation, placement, p, r), p, r, poses_p, poses_r, tuple(GAPS))


def _identical(size: float, rng: np.random.Generator) -> tuple[Specimen, Specimen, Points]:
    p = random_specimen(size, rng)
    return p, p, p.features(1, rng)[1][0]


def _nested(size: float, rng: np.random.Generator) -> tuple[Specimen, Specimen, Points]:
    """A body and the same one, half as large, about a vertex or a middle."""
    p = random_specimen(size, rng)
    centre = p.vertices[0] if rng.integers(2) else p.vertices.mean(axis=0)
    inner = prepared(p.family, centre + (p.vertices - centre) / 2, p.inflation_radius / 2)
    return p, inner, p.features(1, rng)[1][0]


def _neighbours_by(kind: str) -> Callable[[float, np.random.Generator], tuple[Specimen, Specimen, Points]]:
    return lambda size, rng: neighbours(kind, size, _random_count(rng), rng)


_Partners = Callable[[float, np.random.Generator], tuple[Specimen, Specimen, Points]]
_PARTNERS: dict[str, _Partners] = {
    "identical": _identical,
    "nested": _nested,
    **{kind: _neighbours_by(kind) for kind in NEIGHBOURS},
}
RELATIONS: dict[str, Callable[[str, Placement, np.random.Generator], Draw]] = {
    "contact": contact,
    "extreme scales": extreme_scales,
    "coinciding centres": coinciding_centres,
    **dict.fromkeys(_PARTNERS, same_frame),
}
_RELATION_WEIGHTS = [0.62, 0.06, 0.02, *[0.3 / len(_PARTNERS)] * len(_PARTNERS)]
FAMILY_NAMES = (*HULLS, *INFLATED, *_PARTNERS, "extreme scales", "coinciding centres")


def _random_count(rng: np.random.Generator) -> int:
    return int(rng.choice(COUNTS, p=COUNT_WEIGHTS))


def random_specimen(size: float, rng: np.random.Generator) -> Specimen:
    """A body of any family, of a size in m."""
    return specimen(str(rng.choice([*HULLS, *INFLATED])), _random_count(rng), float(size), rng)


_Facing = tuple[Points, Points, Points, Points, Points]


def _aligned(p: Specimen, r: Specimen, placement: Placement, rng: np.random.Generator) -> _Facing:
    """Rotations of both that turn chosen features onto each other; those features; directions from r to p."""
    point_p, normal_p = p.features(len(_GAPS), rng)
    point_r, normal_r = r.features(len(_GAPS), rng)
    directions = random_directions(len(_GAPS), rng)
    return turns_onto(normal_p, -directions, rng), turns_onto(normal_r, directions, rng), point_p, point_r, directions


def _as_they_lie(p: Specimen, r: Specimen, placement: Placement, rng: np.random.Generator) -> _Facing:
    """Rotations of both, and what faces each other then along a normal of one of them or an axis."""
    k = len(_GAPS)
    turn_p, turn_r = _turns(placement, k, rng), _turns(placement, k, rng)
    if placement.rotation == "1e-9 rad":
        turn_r = _posed(np.tile(np.eye(3), (k, 1, 1)))[:, :3, :3]
    point_p, normal_p = p.features(k, rng)
    point_r, normal_r = r.features(k, rng)
    source = rng.integers(0, 3, k)[:, None]
    along_p = -_facing(turn_p, normal_p, placement)
    along_r = _facing(turn_r, normal_r, placement)
    axes = quarter_turns(k, rng)[:, 0]
    directions = np.where(source == 0, along_p, np.where(source == 1, along_r, axes))
    point_p = np.where(source == 0, point_p, p.support(-np.einsum("kji,kj->ki", turn_p, directions)))
    point_r = np.where(source == 1, point_r, r.support(np.einsum("kji,kj->ki", turn_r, directions)))
    return turn_p, turn_r, point_p, point_r, directions


def _facing(turns: Points, normals: Points, placement: Placement) -> Points:
    """Normals (k, 3) or (3,) as the maps (k, 3, 3) turn them: by the inverse's transpose where these are off rigid."""
    outward = np.broadcast_to(normals, (len(turns), 3))
    if placement.rotation == "off rigid":
        return unit(
            np.asarray(np.linalg.solve(np.swapaxes(turns, 1, 2), outward[:, :, None])[:, :, 0], dtype=np.float64)
        )
    return np.asarray(np.einsum("kij,kj->ki", turns, outward))


def _turns(placement: Placement, k: int, rng: np.random.Generator) -> Points:
    """Rotations (k, 3, 3)."""
    if placement.rotation == "none":
        return np.tile(np.eye(3), (k, 1, 1))
    if placement.rotation == "axis-aligned":
        return quarter_turns(k, rng)
    if placement.rotation == "off rigid":
        stretch = rng.normal(size=(k, 3, 3))
        stretch += np.swapaxes(stretch, 1, 2)
        rotations = turns_onto(random_directions(k, rng), random_directions(k, rng), rng)
        # (1 + s)² − 1 is 2 s but for the square of s, of norm 3e-13, which the room below the limit does not take.
        stretch *= OFF_RIGID / 2 / (1 + OFF_RIGID) / np.linalg.norm(stretch, axis=(1, 2), keepdims=True)
        return np.asarray(rotations @ (np.eye(3) + stretch))
    if placement.rotation == "random":
        return turns_onto(random_directions(k, rng), random_directions(k, rng), rng)
    x, y, z = TINY_ANGLE * random_directions(k, rng).T
    one = np.ones(k)  # less half the square of the angle, which is below a double's precision
    return np.stack([one, -z, y, z, one, -x, -y, x, one], axis=1).reshape(k, 3, 3)


def _far_away(placement: Placement, rng: np.random.Generator) -> Points:
    """A point (3,) at the placement's distance from the origin, m: along an axis or anywhere."""
    directions = quarter_turns(1, rng)[:, 0] if rng.integers(2) else random_directions(1, rng)
    return np.asarray(placement.distance * directions[0])


def _posed(turns: Points) -> Points:
    poses = identities(len(turns))
    poses[:, :3, :3] = turns
    return poses


def _stepped(translations: Points, directions: Points) -> Points:
    """Translations (k, 3), those of a gap of one step moved to the next double in the direction's largest entry."""
    rows = np.arange(len(translations))
    largest = np.argmax(np.abs(directions), axis=1)
    towards = np.sign(directions[rows, largest]) * _STEPS * np.finfo(np.float64).max
    chosen = translations[rows, largest]
    translations[rows, largest] = np.where(_STEPS == 0, chosen, np.nextafter(chosen, towards))
    return translations


def _label(relation: str, placement: Placement, p: Specimen, r: Specimen) -> str:
    bodies = " | ".join(f"{s.family} {len(s.vertices)} {s.size:.1e} m" for s in (p, r))
    return f"{relation}: {bodies}, {placement.rotation} rotation, {placement.distance:g} m away"
