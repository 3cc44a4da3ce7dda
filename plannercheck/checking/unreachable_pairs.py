"""Proves by lever arms, without sampling, which pairs of bodies can never meet within the joint limits.

In: a robot, pairs of bodies, their hulls. Out: the pairs that meet at no configuration within the limits, and the pairs
that no joint of the group moves relative to each other.

The idea. Only the joints beyond a pair's last common joint move its bodies relative to each other. The first zero, one
or two columns that drive them are cut into cells. In the middle of a cell, everything up to the first joint that is not
cut is posed. Everything beyond that joint stays in a ball around its origin; its radius is the sum of the lengths
between the following joints, of the distances that they slide, and of the distance of the body's furthest point. Within
the cell, a column moves a centre by at most lever arm times half the cell's width, for each joint that it drives. If in
the middle of every cell the balls (or a ball and the other body's box) are further apart than these motions, the pair
never meets.

Proof of the margins. `kinematic_error_within` bounds how far computed poses are from exact kinematics, also those that
are computed here: pairs are dropped only if it is below LARGEST_ERROR, so that four of them are less than MARGIN. Exact
kinematics is rigid up to the rounding of placements and axes: they must be so up to RIGID each, all of a chain with
what is held on it up to 2.5e-6 (robots/unit_lengths.py), the poses of bodies and obstacles up to 1e-6. That stretches
lengths by less than 2e-6. Using the transpose of a box's pose as its inverse errs by 3.6e-6 of the distance from the
origin of the body's frame, which may be far from the body. RELATIVE, a part of all these lengths, covers both and the
rounding of the sums. The proofs do not hold beyond the limits, where the checker uses the full table, nor for poses by
Pinocchio. Nothing is proved about bodies on a joint that takes several numbers (floating, planar, cosine and sine).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from plannercheck.bodies.kinds import are_bounded
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import GeometryObject, InflatedHull
from plannercheck.bodies.tuning import pair_options
from plannercheck.checking.reach_bounds import MOST_COLUMNS, BoundingBall, Boxes, Chains, Cut, Joints
from plannercheck.common.array_types import Bools, Floats, Ints, Ints64
from plannercheck.common.arrays import distinct
from plannercheck.common.core import core
from plannercheck.robots.robot import Robot

# Bodies must stay apart by this, m, and by this part of all lengths that go into the bound.
MARGIN = 1e-6
RELATIVE = 1e-5

# Where the cells of a cut are split: most pairs that may meet do so in one of the first cells, and arrays stay small.
_BATCHES = (4, 32, *range(96, 600, 64))

# For few pairs, whose arrays are small anyway.
_FEW_PAIRS, _FEW_BATCHES = 8, (4, 96)

# Up to this many obstacles a cut is not split: splitting would take more time than it saves.
_FEW_OBSTACLES = 8


@dataclass(frozen=True)
class UnreachablePairs:
    """What joint limits and lever arms prove about pairs.

    Attributes:
        apart: (k,) pairs that never meet within the limits.
        static: (k,) pairs that no joint of the group moves relative to each other.
        is_proved: Whether rounding within the limits is bounded; if not, no pair counts as apart.
    """

    apart: Bools
    static: Bools
    is_proved: bool


def unreachable_pairs(
    robot: Robot,
    bodies: Sequence[GeometryObject],
    pairs: Ints,
    hulls: Sequence[InflatedHull],
) -> UnreachablePairs:
    """Proves which pairs can never meet.

    Args:
        robot: The robot.
        bodies: Bodies on links, then obstacles.
        pairs: (k, 2) indices into bodies; an obstacle is second.
        hulls: The hull of each body, see `shapes.inflated_hull`.

    Returns:
        Masks over the pairs. Nothing is proved if Pinocchio itself poses the robot, if rounding has no bound (a base
        that floats without limits), or if placements are no rotations.
    """
    apart, static = np.zeros(len(pairs), dtype=bool), np.zeros(len(pairs), dtype=bool)
    table = robot.joint_table
    if not len(pairs) or table is None or robot.kinematics is None:
        return UnreachablePairs(apart, static, False)
    chains = Chains(robot, table, bodies, hulls)
    if not chains.is_proved():
        return UnreachablePairs(apart, static, False)
    with_obstacle = pairs[:, 1] >= sum(body.link is not None for body in bodies)
    own = np.flatnonzero(~with_obstacle)
    apart[own] = apart_among_links(chains, pairs[own])
    static[own] = chains.screen.static(pairs[own].astype(np.int64))
    for body in distinct(pairs[with_obstacle, 0]).tolist():
        rows = np.flatnonzero(with_obstacle & (pairs[:, 0] == body))
        apart[rows] = _apart_from_obstacles(chains, body, pairs[rows, 1])
        static[rows] = not chains.chain(body)
    return UnreachablePairs(apart, static, True)


def stays_apart(p: Polytope, r: Polytope, pose_p: Floats, pose_r: Floats) -> bool:
    """Whether two bodies at rest at these poses (4, 4) are apart, with room for the rounding that MARGIN covers.

    The core finds a direction; doubles are enough to see that it separates the bodies by more than the margin. Solids
    whose hulls meet have no such direction, and count as meeting.
    """
    if not are_bounded(p, r):
        return _stays_over(p, r, pose_p, pose_r) if p.traits.is_bounded else _stays_over(r, p, pose_r, pose_p)
    found = core.certify_pair(p.core, pose_p, r.core, pose_r, pair_options(), False)
    normal = np.asarray(found.get("normal", np.zeros(3)))
    if found["shared"] or not normal.any():
        return False
    on_p, on_r = (body.vertices @ pose[:3, :3].T + pose[:3, 3] for body, pose in ((p, pose_p), (r, pose_r)))
    gap = float((on_p @ normal).min() - (on_r @ normal).max()) / float(np.linalg.norm(normal))
    extent = (
        sum(float(np.linalg.norm(points, axis=1).max()) for points in (on_p, on_r))
        + p.inflation_radius
        + r.inflation_radius
    )
    return gap > p.inflation_radius + r.inflation_radius + MARGIN + RELATIVE * extent


def _stays_over(p: Polytope, half_space: Polytope, pose_p: Floats, pose: Floats) -> bool:
    """`stays_apart` for a body and a half-space."""
    normal, offset = half_space.core.shape
    gap = float(core.distance_batch(p.core, pose_p[None], half_space.core, pose[None])[2][0])
    furthest = np.linalg.norm(p.vertices @ pose_p[:3, :3].T + pose_p[:3, 3], axis=1).max()
    plane = abs(offset) / np.linalg.norm(normal) + np.linalg.norm(pose[:3, 3]) + half_space.inflation_radius
    return gap > MARGIN + RELATIVE * float(furthest + p.inflation_radius + plane)


def apart_among_links(chains: Chains, pairs: Ints) -> Bools:
    """Which pairs (k, 2) of the robot's bodies never meet."""
    promising = chains.screen.may_be_proved(pairs.astype(np.int64), MOST_COLUMNS)
    apart = np.zeros(len(pairs), dtype=bool)
    apart[promising] = _apart_by_cells(chains, pairs[promising])
    return apart


def _apart_by_cells(chains: Chains, pairs: Ints) -> Bools:
    """The same, by cells of cuts."""
    apart = np.zeros(len(pairs), dtype=bool)
    branches = [chains.branches(a, b) for a, b in pairs.tolist()]
    columns_of = {branch: tuple(chains.columns(branch)) for both in branches for branch in both}
    beyond = [(columns_of[first], columns_of[second]) for first, second in branches]
    for columns in range(MOST_COLUMNS + 1):
        waiting: dict[Cut, list[int]] = {}
        for k in np.flatnonzero(~apart).tolist():
            for cut in _cuts(*beyond[k], columns):
                waiting.setdefault(cut, []).append(k)
        for cut, rows in waiting.items():
            rows = [k for k in rows if not apart[k]]
            if not rows:  # another cut has proved all of them
                continue
            ends = [[chains.end(int(pairs[k, side]), branches[k][side], cut) for side in (0, 1)] for k in rows]
            apart[rows] = _apart_in_cells(chains, cut, pairs[rows], ends)
    return apart


@lru_cache(maxsize=4096)
def _cuts(first: Cut, second: Cut, columns: int) -> set[Cut]:
    """The sets of this many columns to try: the first ones of either branch, and of both."""
    splits = [(*first[:k], *second[: columns - k]) for k in range(columns + 1)]
    return {tuple(sorted(set(split))) for split in splits if len(set(split)) == columns}


def _apart_in_cells(chains: Chains, cut: Cut, pairs: Ints, ends: list[list[BoundingBall]]) -> Bools:
    """Which pairs (k, 2) with these ends (k, 2) are apart in every cell of a cut, by the same one of three tests."""
    q, half = chains.cells(cut)
    around = chains.neighbourhood({end.frame for both in ends for end in both})
    sides = [_Side(chains, cut, half, pairs[:, side], [both[side] for both in ends], around.place) for side in (0, 1)]
    apart = np.ones((3, len(pairs)), dtype=bool)
    for part in np.split(q, _BATCHES if len(pairs) > _FEW_PAIRS else _FEW_BATCHES):
        left = np.flatnonzero(apart.any(axis=0))
        if len(left) and len(part):
            poses = around.poses(part)
            first, second = (_Moving(side, poses, left) for side in sides)
            apart[:, left] &= [first.balls_apart(second), first.apart_from_box(second), second.apart_from_box(first)]
    return np.asarray(apart.any(axis=0))


class _Side:
    """One side of n pairs, with what all cells of a cut have in common."""

    def __init__(
        self,
        chains: Chains,
        cut: Cut,
        half: Floats,
        bodies: Ints,
        ends: list[BoundingBall],
        place: dict[int, int],
    ) -> None:
        self.frames = np.array([place[end.frame] for end in ends], dtype=np.int64)
        self.centre = np.array([end.centre for end in ends]).reshape(-1, 3)
        self.radius = np.array([end.radius for end in ends])
        self.sway = np.array([[end.levers[c] for c in cut] for end in ends]).reshape(len(ends), -1) @ half
        self.ball_sway = np.array([[end.ball_levers[c] for c in cut] for end in ends]).reshape(len(ends), -1) @ half
        self.posed = np.array([end.posed for end in ends], dtype=bool)
        self.box = chains.boxes.of(bodies)


class _Moving:
    """One side of some of these pairs in some cells, given by poses (cells, frames, 4, 4) in their middles."""

    def __init__(self, side: _Side, poses: Floats, rows: Ints64) -> None:
        self.pose = poses[:, side.frames[rows]]
        self.centre = np.einsum("cnij,nj->cni", self.pose[..., :3, :3], side.centre[rows]) + self.pose[..., :3, 3]
        self.radius, self.sway, self.ball_sway = side.radius[rows], side.sway[rows], side.ball_sway[rows]
        self.posed, self.box = side.posed[rows], side.box.of(rows)
        self.extent = _lengths(self.centre).max(axis=0) + self.radius + self.ball_sway

    def balls_apart(self, other: _Moving) -> Bools:
        distance = _lengths(self.centre - other.centre).min(axis=0)
        return np.asarray(distance > self.radius + other.radius + self.sway + other.sway + self._margin(other))

    def apart_from_box(self, other: _Moving) -> Bools:
        """Whether the balls are apart from the other bodies' boxes; False where these are not posed."""
        away = self.centre - other.pose[..., :3, 3]
        inside = np.einsum("cnji,cnj->cni", other.pose[..., :3, :3], away)
        distance = _from_box(inside, other.box).min(axis=0)
        room = self.radius + other.box.inflation_radius + self.sway + other.ball_sway + self._margin(other)
        offset = _lengths(other.box.centre)  # `away` begins at the frame's origin, however far that is
        return np.asarray(other.posed & (distance > room + RELATIVE * offset))

    def _margin(self, other: _Moving) -> Floats:
        return np.asarray(MARGIN + RELATIVE * (self.extent + other.extent))


def _lengths(vectors: Floats) -> Floats:
    """(...,) the lengths of vectors (..., 3), as np.linalg.norm has them, with less around it."""
    return np.asarray(np.sqrt((vectors * vectors).sum(axis=-1)))


def _from_box(points: Floats, box: Boxes) -> Floats:
    """Distances of points (..., n, 3) from n boxes in their frames."""
    beyond = np.maximum(np.maximum(box.low - points, points - box.high), 0.0)
    return np.asarray(np.sqrt((beyond * beyond).sum(axis=-1)))


def _apart_from_obstacles(chains: Chains, body: int, obstacles: Ints) -> Bools:
    """Which obstacles (n,) a body never meets."""
    apart = np.zeros(len(obstacles), dtype=bool)
    chain = chains.chain(body)
    columns = chains.columns(chain)
    for count in range(len(columns) + 1):
        cut = tuple(columns[:count])
        left = np.flatnonzero(~apart)
        if len(left):
            apart[left] = _clear_in_cells(chains, body, chain, cut, obstacles[left])
    return apart


def _clear_in_cells(chains: Chains, body: int, chain: Joints, cut: Cut, obstacles: Ints) -> Bools:
    """Which obstacles (n,) are outside the ball around an end in every cell of a cut."""
    end = chains.end(body, chain, cut)
    centres, sway = chains.centres_in_cells(body, chain, cut)
    extent = end.radius + sway + np.linalg.norm(centres, axis=1).max()
    box, pose = chains.boxes.of(obstacles), chains.poses_in_world[obstacles]
    room = end.radius + sway + box.inflation_radius + MARGIN + RELATIVE * (extent + sizes_of(box, pose))
    clear = np.isfinite(room)
    for part in np.split(centres, _BATCHES) if len(obstacles) > _FEW_OBSTACLES else [centres]:
        left = np.flatnonzero(clear)
        if len(left) and len(part):
            clear[left] = (_squared_distances(part, box.of(left), pose[left]) > room[left] ** 2).all(axis=0)
    return np.asarray(clear)


def sizes_of(box: Boxes, poses: Floats) -> Floats:
    """(n,) the lengths of n obstacles at poses (n, 4, 4) on which rounding depends, m."""
    lengths = np.linalg.norm(poses[:, :3, 3], axis=1) + np.linalg.norm(box.centre, axis=1)
    return np.asarray(lengths + box.radius + box.inflation_radius)


def _squared_distances(points: Floats, box: Boxes, poses: Floats) -> Floats:
    """(c, n) squared distances of points (c, 3) in the world from n posed boxes, all by one product of matrices."""
    offset = np.einsum("nji,nj->ni", poses[:, :3, :3], poses[:, :3, 3]) + box.centre
    beyond = points @ poses[:, :3, :3].transpose(1, 0, 2).reshape(3, -1) - offset.ravel()
    np.abs(beyond, out=beyond)
    beyond -= (0.5 * (box.high - box.low)).ravel()
    np.maximum(beyond, 0.0, out=beyond)
    return np.asarray(np.square(beyond, out=beyond).reshape(len(points), -1, 3).sum(axis=2))
