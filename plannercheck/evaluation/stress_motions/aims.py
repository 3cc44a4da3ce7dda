"""Motions through a state at which bodies touch by construction.

In: a robot, a state with the contact that was built there, a random generator. Out: motions that pass the state at a
known parameter: in any direction, along the contact, or of one joint alone; from 1e-9 to 1e4 rad long.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.arrays import distinct
from plannercheck.evaluation.stress_motions.tangents import Tangents
from plannercheck.robots.robot import Robot

# Classes of lengths: probability, and powers of ten of the largest angle, rad (or length, m). The huge ones cost
# thousands of intervals each.
_LENGTHS = ((0.12, -9.0, -3.0), (0.55, -1.5, 0.3), (0.31, 0.3, 0.8), (0.02, 0.8, 4.0))
# Angles that take the short way go no further than this, rad: half a turn, with room for rounding.
_LONGEST_TURN = 3.1
# Lengths of slides against angles: m a rad, as powers of ten.
_SLIDE_PER_TURN = (-1.0, 0.5)
# Step of the derivative along the contact, rad or m.
_STEP = 1e-5
# Kinds of directions: any, of one or two joints alone; and of both, the part that goes along the contact.
_FEW_JOINTS, _ALONG = 0.3, 0.6
# Motions that pass the state a little off the contact: how many, by how much, m (powers of ten), and rad or m at most.
_LIFTED, _LIFTS, _LARGEST_LIFT = 0.3, (-3.5, -1.0), 0.5
# Where on the motion the state is; of so many one is at the first end, one at the last, and two are in the middle.
_INSIDE, _AT_ENDS = (0.05, 0.95), 12


class Motions(NamedTuple):
    """Motions, and the state that each passes.

    Attributes:
        q0: (n, nq) starts.
        q1: (n, nq) ends.
        at: (n,) parameters of the states.
        through: (n, nq) states.
        touching: (n,) whether the state collides by construction.
    """

    q0: Floats
    q1: Floats
    at: Floats
    through: Floats
    touching: Bools

    def of(self, rows: NDArray[np.generic]) -> Motions:
        """Some of them."""
        return Motions(*(array[rows] for array in self))


def joined(parts: list[Motions]) -> Motions:
    """All motions of several."""
    return Motions(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


@dataclass(frozen=True, eq=False)
class Aim:
    """A state and the contact that was built there.

    Attributes:
        state: (nq,) configuration.
        link: Index of the link whose body touches.
        other: Index of the link of what it touches, -1 for the world.
        point: (3,) in the world at the state, m.
        normal: (3,) in the world at the state.
        touches: Whether they share a point, else they just miss each other.
    """

    state: Floats
    link: int
    other: int
    point: Floats
    normal: Floats
    touches: bool


def through(robot: Robot, tangents: Tangents, aim: Aim, n: int, rng: np.random.Generator) -> Motions:
    """Motions through an aim's state."""
    rates = _rates(robot, tangents, aim)
    way, at = _directions(tangents, rates, n, rng), parameters(n, rng)
    lifts, touching = lifted(np.zeros(tangents.dimension), rates, aim.touches, n, rng)
    passed = tangents.moved(aim.state, lifts)
    q0 = tangents.moved(passed, -at[:, None] * way)
    q1 = tangents.moved(passed, (1 - at)[:, None] * way)
    exact = ~lifts.any(axis=1)
    passed[exact] = aim.state
    return Motions(q0, q1, at, passed, touching)


def parameters(n: int, rng: np.random.Generator) -> Floats:
    """Where on motions (n,) the state is that they pass: anywhere, in the middle, or at an end."""
    at = rng.uniform(*_INSIDE, n)
    kind = rng.integers(0, _AT_ENDS, n)
    at[kind == 0], at[kind == 1], at[kind == 2], at[kind == 3] = 0.0, 1.0, 0.5, 0.5
    return at


def lifted(state: Floats, rates: Floats, touches: bool, n: int, rng: np.random.Generator) -> tuple[Floats, Bools]:
    """States (n, k) of which some are lifted off the contact, and whether (n,) they still touch by construction.

    Motions that just miss leave behind what those that just touch are then looked at with.
    """
    square = float(rates @ rates)
    lift = np.where(rng.random(n) < _LIFTED, 10.0 ** rng.uniform(*_LIFTS, n), 0.0)
    step = np.minimum(lift / max(square, 1e-300), _LARGEST_LIFT / max(np.sqrt(square), 1e-300))
    moved = state + step[:, None] * -rates
    return moved, np.full(n, touches) & (lift == 0)


def _rates(robot: Robot, tangents: Tangents, aim: Aim) -> Floats:
    """(dimension,) how fast each number lifts the point off the other body, along the normal; m per rad or m."""
    steps = _STEP * np.eye(tangents.dimension)
    poses = robot.link_poses(tangents.moved(aim.state, np.vstack([np.zeros(tangents.dimension), steps, -steps])))
    seen = _seen_from(poses, aim.other, _carried(poses, aim.link, aim.point))
    normal = aim.normal if aim.other < 0 else poses[0, aim.other, :3, :3].T @ aim.normal
    k = tangents.dimension
    return np.asarray((seen[1 : k + 1] - seen[k + 1 :]) @ normal / (2 * _STEP))


def _carried(poses: Floats, link: int, point: Floats) -> Floats:
    """Where a point on a link, given at the first of the poses, is at each (n, 3)."""
    own = poses[0, link, :3, :3].T @ (point - poses[0, link, :3, 3])
    return np.asarray(poses[:, link, :3, :3] @ own + poses[:, link, :3, 3])


def _seen_from(poses: Floats, link: int, points: Floats) -> Floats:
    if link < 0:
        return points
    return np.asarray(np.einsum("kji,kj->ki", poses[:, link, :3, :3], points - poses[:, link, :3, 3]))


def _directions(tangents: Tangents, rates: Floats, n: int, rng: np.random.Generator) -> Floats:
    """Tangent vectors (n, dimension) of random directions and lengths."""
    way = rng.normal(size=(n, tangents.dimension))
    owners = distinct(tangents.owners)
    few = rng.random(n) < _FEW_JOINTS
    chosen = rng.choice(owners, (n, 2))
    way[few[:, None] & ~(tangents.owners[None, :, None] == chosen[:, None, :]).any(axis=2)] = 0
    way[:, tangents.slides] *= 10.0 ** rng.uniform(*_SLIDE_PER_TURN, (n, 1))
    along = rng.random(n) < _ALONG
    masked = np.where(way != 0, rates, 0.0)
    squares = (masked**2).sum(axis=1)
    part = np.where(along & (squares > 0), (way * masked).sum(axis=1) / np.where(squares > 0, squares, 1), 0.0)
    way -= part[:, None] * masked
    largest = np.abs(way).max(axis=1, initial=0.0)
    way *= (lengths(n, rng) / np.where(largest > 0, largest, 1))[:, None]
    turned = np.zeros(n)
    for owner in owners:  # numbers of one joint turn it together
        own = way[:, tangents.turning & (tangents.owners == owner)]
        turned = np.maximum(turned, np.sqrt((own**2).sum(axis=1)))
    return np.asarray(way * np.minimum(1, _LONGEST_TURN / np.maximum(turned, 1e-300))[:, None])


def lengths(n: int, rng: np.random.Generator) -> Floats:
    """Random lengths (n,), rad."""
    kinds = rng.choice(len(_LENGTHS), n, p=[weight for weight, _, _ in _LENGTHS])
    low, high = (np.array([row[k] for row in _LENGTHS])[kinds] for k in (1, 2))
    return np.asarray(10.0 ** rng.uniform(low, high))
