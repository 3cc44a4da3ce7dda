"""Lengths and poses along a robot's chains of joints: bounds on where its bodies can be.

In: a robot and its bodies' hulls. Out: `Chains`. Given values of some columns of the configuration, it bounds a body by
a ball with a posed centre, and says how far the centre moves at most for one unit of a column (its lever). Everything
beyond a joint of unknown value stays in a ball around that joint's origin. The radius of the ball is the sum of the
lengths between the following joints, of the distances that they slide, and of the distance of the body's furthest
point.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Sequence
from functools import cache, cached_property
from typing import Any, NamedTuple

import numpy as np

from plannercheck.bodies.shapes import GeometryObject, InflatedHull
from plannercheck.checking.neighbourhoods import Neighbourhood, neighbourhood
from plannercheck.checking.reach_screens import Screen, joint_tree
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.arrays import read_only
from plannercheck.common.core import core
from plannercheck.robots.configurations import LARGEST_VALUE
from plannercheck.robots.joints import KINDS, SLIDE, TURN
from plannercheck.robots.kinematics import JointTable
from plannercheck.robots.robot import Robot

Cut = tuple[int, ...]
Joints = tuple[int, ...]

# The margins of unreachable_pairs.py cover computed poses with at most this error, m, and placements and axes with at
# most this defect.
LARGEST_ERROR = 1e-7
RIGID = 1e-9

# Cells, by the number of columns that are cut. With 128 cells of a whole turn, a point at 1 m moves by 2.5 cm within a
# cell. Twice as many cells prove less than 1 % more pairs apart and take four times as long.
CELLS = {0: 1, 1: 128, 2: 24}
MOST_COLUMNS = max(CELLS)

# Columns are cut if their span is more than this part of their limits.
_LEAST_SPAN = 1e-6


class BoundingBall(NamedTuple):
    """A bound on where a body is, given values of some columns.

    Attributes:
        frame: A frame of `Chains` that these columns pose.
        centre: (3,) in that frame, m: the centre of a ball that holds the body whatever the other columns are.
        radius: The radius of that ball, m; may be infinite.
        levers: How far one unit of each column moves the centre at most, m.
        ball_levers: How far it moves any point of the ball at most, m.
        posed: Whether the frame is the body's own, so that the body's box may be used.
    """

    frame: int
    centre: Floats
    radius: float
    levers: dict[int, float]
    ball_levers: dict[int, float]
    posed: bool


class Boxes(NamedTuple):
    """Boxes and balls around bodies, in the bodies' frames.

    Attributes:
        low: (n, 3) lower corner of the box around each hull, m.
        high: (n, 3) upper corner, m.
        centre: (n, 3) centre of the box, m.
        radius: (n,) radius of the ball around the centre that holds the hull, m.
        inflation_radius: (n,) how far around the hull the body reaches, m.
    """

    low: Floats
    high: Floats
    centre: Floats
    radius: Floats
    inflation_radius: Floats

    def of(self, chosen: Any) -> Boxes:
        """Some of them."""
        return Boxes(*(array[chosen] for array in self))


def boxes_of(hulls: Sequence[InflatedHull]) -> Boxes:
    """The boxes and balls around hulls, see `shapes.inflated_hull`."""
    low = np.array([points.min(axis=0) for points, _, _ in hulls]).reshape(-1, 3)
    high = np.array([points.max(axis=0) for points, _, _ in hulls]).reshape(-1, 3)
    centre = 0.5 * (low + high)
    squares = [((points - c) ** 2).sum(axis=1).max() for (points, _, _), c in zip(hulls, centre, strict=True)]
    return Boxes(
        low,
        high,
        centre,
        np.sqrt(np.array(squares, dtype=np.float64)),
        np.array([h[2] for h in hulls], dtype=np.float64),
    )


class Chains:
    """The moving joints between the world and the bodies, the lengths between them, and poses of their frames.

    Each of the n joints has a frame before its motion (index k) and one after it (n + k); those of the bodies
    follow (2 n + b). Lengths that no joint of the group changes are measured in one configuration.
    """

    def __init__(
        self, robot: Robot, table: JointTable, bodies: Sequence[GeometryObject], hulls: Sequence[InflatedHull]
    ) -> None:
        """Measures the chains; `hulls` are those of `bodies`, and bodies on links come first."""
        self.robot, self._table, self._joints = robot, table, len(table.kinds)
        self.boxes = boxes_of(hulls)
        self.poses_in_world = np.array([body.pose for body in bodies])  # of obstacles
        own = self._own = tuple(body for body in bodies if body.link is not None)
        self._frames = _table_of_frames(robot, table, own)
        self._kernel = core.Kinematics(*self._frames)
        self._moving = [bool((columns >= 0).any()) for columns in table.columns]
        self._slides = [_most_slide(table, k, robot.lower, robot.upper) for k in range(self._joints)]
        spans = robot.upper - robot.lower
        sizes = np.maximum(np.abs(robot.lower), np.abs(robot.upper))
        # The middles of cells round by half an ulp of the limits: nothing beside a span that is a part of these.
        has_cells = np.isfinite(spans) & ((spans == 0) | (spans > _LEAST_SPAN * sizes))
        self._can_be_cut = [
            self._moving[k] and math.isfinite(self._slides[k]) and bool(has_cells[self._column(k)])
            for k in range(self._joints)
        ]
        links = [int(table.link_joints[robot.link_index(str(body.link))]) for body in own]
        self._chains = [self._chain(joint) for joint in links]
        self._base = np.array(robot.reference)
        at_base = self.poses(self._base[None], range(2 * self._joints + len(links)))[0]
        origins = at_base[:, :3, 3].tolist()
        self._origins, self._moved_origins = origins[: self._joints], origins[self._joints : 2 * self._joints]
        centres = np.column_stack([self.boxes.centre[: len(links)], np.ones(len(links))])
        self._centres = np.einsum("bij,bj->bi", at_base[2 * self._joints :, :3], centres).tolist()
        self._ends: dict[tuple[int, int, Cut], BoundingBall] = {}
        self._middles: dict[tuple[int, int, Cut], tuple[Floats, float]] = {}
        self._proved: bool | None = None

    def inherit(self, earlier: Chains) -> None:
        """Takes over results of earlier chains of the same robot and paddings; their bodies are the first of these."""
        self._ends |= earlier._ends
        self._middles |= earlier._middles

    def _chain(self, joint: int) -> Joints:
        """The moving joints from the world to this one."""
        chain: list[int] = []
        while joint >= 0:
            if self._moving[joint]:
                chain.append(joint)
            joint = int(self._table.parents[joint])
        return tuple(reversed(chain))

    def _column(self, joint: int) -> int:
        """The column of the first number that a moving joint takes; -1 if that number is held."""
        return int(self._table.columns[joint][0])

    def is_proved(self) -> bool:
        """Whether the margins cover all rounding within the limits."""
        if self._proved is None:
            self._proved = self._margins_cover()
        return self._proved

    def _margins_cover(self) -> bool:
        robot, table = self.robot, self._table
        low, high = (np.clip(limit, -LARGEST_VALUE, LARGEST_VALUE) for limit in (robot.lower, robot.upper))
        if not robot.kinematic_error_within(low, high) <= LARGEST_ERROR:
            return False
        rotations = np.concatenate([table.placements, table.link_placements])[:, :, :3]
        defect = np.abs(rotations.transpose(0, 2, 1) @ rotations - np.eye(3)).max(initial=0.0)
        lengths = np.linalg.norm(table.axes, axis=1)
        return bool(defect <= RIGID and (np.abs(lengths[lengths > 0] - 1) <= RIGID).all())

    def poses(self, q: Floats, frames: Iterable[int]) -> Floats:
        """(n, all frames, 4, 4) at configurations (n, nq); only the frames asked for are posed."""
        needed = np.zeros(2 * self._joints + len(self._chains), dtype=np.uint8)
        needed[list(frames)] = 1
        return np.asarray(self._kernel.link_poses(q, needed))

    def neighbourhood(self, frames: Iterable[int]) -> Neighbourhood:
        """Kinematics of some frames relative to each other."""
        return neighbourhood(self._frames, sorted(frames))

    def branches(self, a: int, b: int) -> tuple[Joints, Joints]:
        """The moving joints of two bodies from their fork outwards."""
        first, second = self._chains[a], self._chains[b]
        common = 0
        while common < min(len(first), len(second)) and first[common] == second[common]:
            common += 1
        return first[common:], second[common:]

    def whole_cut(self, a: int, b: int) -> Cut | None:
        """The columns on which the relative pose of two bodies depends; None if there are none, or too many to cut."""
        joints = [joint for branch in self.branches(a, b) for joint in branch]
        if not joints or not all(self._can_be_cut[joint] for joint in joints):
            return None
        columns = tuple(sorted({self._column(joint) for joint in joints}))
        spans = self.robot.upper[list(columns)] - self.robot.lower[list(columns)]
        return columns if len(columns) <= MOST_COLUMNS and (spans > 0).all() else None

    def add_to(self, key: Any) -> None:
        """Adds all that poses and lengths depend on, besides the bodies' hulls, to a hash."""
        for part in (*self._frames, self.robot.lower, self.robot.upper, self._base):
            array = np.ascontiguousarray(part)
            key.update(repr((array.dtype.str, array.shape)).encode() + array.tobytes())

    @property
    def count(self) -> int:
        """How many of the bodies are on links."""
        return len(self._own)

    def chain(self, body: int) -> Joints:
        """The moving joints from the world to a body."""
        return self._chains[body]

    @cached_property
    def screen(self) -> Screen:
        """A quick test for pairs of bodies on links about which nothing can be proved."""
        moving = [joint for joint in range(self._joints) if self._moving[joint]]
        number = {joint: k for k, joint in enumerate(moving)}
        above = [self._last_moving(int(self._table.parents[joint])) for joint in moving]
        own = slice(len(self._own))
        tree = joint_tree(
            [number.get(joint, -1) for joint in above],
            [self._column(joint) if self._can_be_cut[joint] else -1 for joint in moving],
            [self._slides[joint] for joint in moving],
            (_rows(self._origins, moving), _rows(self._moved_origins, moving)),
            [number.get(chain[-1], -1) if chain else -1 for chain in self._chains],
            (_rows(self._centres, range(len(self._own))), self.boxes.radius[own] + self.boxes.inflation_radius[own]),
        )
        return Screen(tree)

    def _last_moving(self, joint: int) -> int:
        """The first joint that moves, from this one towards the world; -1 if none does."""
        while joint >= 0 and not self._moving[joint]:
            joint = int(self._table.parents[joint])
        return joint

    def columns(self, branch: Joints) -> list[int]:
        """The columns that can be cut, in their order along a branch, up to the first joint that can't be cut."""
        found: list[int] = []
        for joint in branch:
            if not self._can_be_cut[joint] or len(found) == MOST_COLUMNS:
                break
            if self._column(joint) not in found:
                found.append(self._column(joint))
        return found

    def end(self, body: int, branch: Joints, cut: Cut) -> BoundingBall:
        """A bound on where a body is, given the columns of a cut."""
        key = body, len(branch), cut
        if key not in self._ends:
            self._ends[key] = self._new_end(body, branch, cut)
        return self._ends[key]

    def _new_end(self, body: int, branch: Joints, cut: Cut) -> BoundingBall:
        known = 0
        while known < len(branch) and self._can_be_cut[branch[known]] and self._column(branch[known]) in cut:
            known += 1
        posed = known == len(branch)
        if posed:
            frame, centre, following = 2 * self._joints + body, self.boxes.centre[body], self._centres[body]
        else:
            frame, centre, following = branch[known], np.zeros(3), self._origins[branch[known]]
        radius = self._room_beyond(body, branch[known:])
        levers: dict[int, float] = dict.fromkeys(cut, 0.0)
        ball_levers = dict(levers)
        length = 0.0
        for joint in reversed(branch[:known]):
            length += math.dist(following, self._moved_origins[joint])
            column, rate = self._column(joint), abs(float(self._table.multipliers[joint][0]))
            slides = KINDS[self._table.kinds[joint]] is SLIDE
            levers[column] += rate * (1.0 if slides else length)
            ball_levers[column] += rate * (1.0 if slides else length + radius)
            length += self._slides[joint]
            following = self._origins[joint]
        return BoundingBall(frame, centre, radius, levers, ball_levers, posed)

    def _room_beyond(self, body: int, branch: Sequence[int]) -> float:
        """How far a body gets from the origin of its branch's first joint, m; without a branch, its ball's radius."""
        room = float(self.boxes.radius[body] + self.boxes.inflation_radius[body])
        following = self._centres[body]
        for joint in reversed(branch):
            room += self._slides[joint] + math.dist(following, self._moved_origins[joint])
            following = self._origins[joint]
        return room

    def centres_in_cells(self, body: int, chain: Joints, cut: Cut) -> tuple[Floats, float]:
        """Centres (cells, 3) of a body's ball in the middles of cells, and how far they move within a cell, m."""
        end = self.end(body, chain, cut)
        key = body if end.posed else -1, end.frame, cut  # bodies beyond one joint share its origin as their centre
        if key not in self._middles:
            q, half = self.cells(cut)
            centres = self.poses(q, [end.frame])[:, end.frame, :3] @ np.append(end.centre, 1.0)
            sway = sum(end.levers[column] * width for column, width in zip(cut, half.tolist(), strict=True))
            self._middles[key] = centres, float(sway)
        return self._middles[key]

    def cells(self, cut: Cut) -> tuple[Floats, Floats]:
        """Middles (cells, nq) of the cells of a cut, in random order, and half their widths (columns of the cut,)."""
        count = CELLS[len(cut)]
        low, high = self.robot.lower[list(cut)], self.robot.upper[list(cut)]
        half = np.maximum(high - low, 0.0) / (2 * count)
        steps = _numbers_of_cells(len(cut))
        q = np.tile(self._base, (len(steps), 1))
        q[:, list(cut)] = low + half * (2 * steps + 1)
        return q, half


@cache
def _numbers_of_cells(columns: int) -> Ints64:
    """(cells, columns) the cells of so many columns by their numbers along each, in random order."""
    steps = np.array(list(itertools.product(range(CELLS[columns]), repeat=columns)), dtype=np.int64)
    return read_only(np.random.default_rng(0).permutation(steps))


def _rows(points: Sequence[Sequence[float]], wanted: Sequence[int]) -> Floats:
    """(n, 3) some of the points."""
    return np.array([points[k] for k in wanted], dtype=np.float64).reshape(-1, 3)


def _most_slide(table: JointTable, joint: int, lower: Floats, upper: Floats) -> float:
    """How far a joint slides its frame at most, m; infinite if several numbers move it."""
    kind, column = KINDS[table.kinds[joint]], int(table.columns[joint][0])
    if kind is TURN:
        return 0.0
    if kind is not SLIDE:
        return np.inf
    ends = np.array([lower[column], upper[column]])
    if not np.isfinite(ends).all():
        return np.inf
    return float(np.abs(ends * table.multipliers[joint][0] + table.offsets[joint][0]).max())


def _table_of_frames(robot: Robot, table: JointTable, bodies: Sequence[GeometryObject]) -> JointTable:
    """A table whose links are the joints' frames, before and after their motion, and the frames of bodies on links."""
    joints = np.arange(len(table.kinds), dtype=np.int32)
    links = [robot.link_index(str(body.link)) for body in bodies]
    on_links = np.array([body.pose for body in bodies]).reshape(-1, 4, 4)
    on_joints = table.link_placements[links] @ on_links
    identities = np.tile(np.eye(4)[:3], (len(joints), 1, 1))
    return table._replace(
        link_joints=np.concatenate([table.parents, joints, table.link_joints[links]]),
        link_placements=np.ascontiguousarray(np.concatenate([table.placements, identities, on_joints])),
    )
