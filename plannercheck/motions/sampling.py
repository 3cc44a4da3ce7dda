"""Sampled motions: states along a segment, so dense that no link point moves further than a given distance.

In: a robot, segments of configurations. Out: whether all sampled states are valid. The bound is a sum over the joints
of the distance that one unit of the joint can move a point: the length of the longest chain from the joint to a body
that it carries.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property, partial

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from plannercheck.bodies.shapes import DEFAULT_EXCESS, inflated_hull
from plannercheck.checking.protocols import AnyChecker
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import read_only
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.motion_paths import MotionPath
from plannercheck.common.real_numbers import check_length
from plannercheck.motions.motion_ends import shorter_turn
from plannercheck.robots.configurations import NO_LIMIT
from plannercheck.robots.joints import kind_of
from plannercheck.robots.robot import Robot

# Between two states no link point moves further than this, in m: far below the 3 to 11 cm that planners use by default.
DEFAULT_RESOLUTION = 1e-3

# More states than this mean a mistake in the motion or the resolution: at 5 µs each they would take over an hour.
MOST_STEPS = 10**9

# States per batch: enough to fill the SIMD lanes many times, few enough to stop early.
_BATCH = 4096


class MotionSampler:
    """Interpolates motions of one robot and computes how many states a motion needs."""

    def __init__(self, robot: Robot, excess: float = DEFAULT_EXCESS) -> None:
        """Computes the lever arms of the robot's joints; `excess` as the checker's."""
        self._robot, self._excess = robot, excess
        self._positions = np.maximum(_limits(robot.model), np.abs(robot.expand(robot.reference)))
        self._levers = lever_arms(robot, self._positions, excess)
        self._sliding = _sliding_columns(robot)
        self._turning = read_only(np.flatnonzero(robot.configuration_map.turning_columns()))
        self.is_vector_space = len(robot.joint_names) == robot.nq  # one number a joint: angles and lengths
        self._column_levers = _column_levers(robot, self._levers) if self.is_vector_space else None

    def steps(self, q0: Floats, q1: Floats, resolution: float | None) -> NDArray[np.int64]:
        """How many steps each motion (n, nq) to (n, nq) needs: no link point moves over `resolution` m in one."""
        resolution = checked_resolution(resolution, DEFAULT_RESOLUTION)
        if self._robot.group is not None and not self.is_vector_space:
            raise PlannercheckError(
                f"motions of the group {self._robot.group!r} can't be sampled: a joint takes several numbers; "
                "choose a group without it, or the whole robot"
            )
        way = self._way(q0, q1)
        with np.errstate(over="ignore"):  # infinitely many steps are refused below
            steps = np.maximum(1, np.ceil(way / resolution))
        if not (steps <= MOST_STEPS).all():
            raise PlannercheckError(
                f"motion {int(np.argmax(way))} may move link points {way.max():.3g} m, more than {MOST_STEPS:g} "
                f"steps of {resolution:g} m: choose a coarser resolution or a shorter motion"
            )
        return steps.astype(np.int64)

    @property
    def whole_turns(self) -> NDArray[np.int64]:
        """Columns of angles that a whole turn does not change; motions take their short way."""
        return self._turning

    def shorter_turn(self, q0: Floats, q1: Floats) -> Floats:
        """Ends (…, nq) with continuous joints within half a turn of the starts'; the same array if they already are."""
        return shorter_turn(q0, q1, self._turning)

    def _way(self, q0: Floats, q1: Floats) -> Floats:
        """(n,) m: no link point travels further on these motions, whichever path they take.

        A screw takes the origin of a planar or floating joint along an arc, which is no shorter than the straight line,
        and turns it as slerp does.
        """
        levers = self._levers_within(q0, q1)
        if self._column_levers is not None:
            columns = self._column_levers if levers is self._levers else _column_levers(self._robot, levers)
            return np.asarray(np.abs(q1 - q0) @ columns)
        model = self._robot.model
        moved = np.array([pin.difference(model, a, b) for a, b in zip(q0, q1, strict=True)]).reshape(-1, model.nv)
        return np.asarray(np.abs(moved) @ levers)

    def _levers_within(self, q0: Floats, q1: Floats) -> Floats:
        """The lever arms; they are longer where a sliding joint of the group goes beyond its limits."""
        if not len(self._sliding):
            return self._levers
        taken = np.abs(self._robot.expand(np.concatenate([q0, q1]))).max(axis=0, initial=0)
        if (taken[self._sliding] <= self._positions[self._sliding]).all():
            return self._levers
        return lever_arms(self._robot, np.maximum(self._positions, taken), self._excess)

    def states(self, q0: Floats, q1: Floats, parameters: Floats, path: MotionPath = "screw") -> Floats:
        """States (k, nq) of one motion at parameters (k,) in [0, 1]; both ends are met exactly."""
        if self.is_vector_space:
            states = (1 - parameters)[:, None] * q0 + parameters[:, None] * q1
        else:
            model = self._robot.model
            states = np.array([pin.interpolate(model, q0, q1, float(t)) for t in parameters]).reshape(-1, len(q0))
            straight = self._placed if path == "slerp" else slice(0)
            states[:, straight] = (1 - parameters)[:, None] * q0[straight] + parameters[:, None] * q1[straight]
        states[parameters == 0] = q0
        states[parameters == 1] = q1
        return states

    def check(
        self, checker: AnyChecker, q0: Floats, q1: Floats, resolution: float | None, path: MotionPath = "screw"
    ) -> NDArray[np.bool_]:
        """Whether all sampled states of each motion (n, nq) to (n, nq) are valid, by batches of states."""
        steps = self.steps(q0, q1, resolution)
        motions = zip(q0, q1, steps.tolist(), strict=True)
        free = [
            samples_are_free(checker, partial(self.states, start, end, path=path), count)
            for start, end, count in motions
        ]
        return np.array(free, dtype=bool)

    @cached_property
    def _placed(self) -> NDArray[np.int64]:
        """Columns that are positions of planar and floating joints, of a robot in Pinocchio's own numbers."""
        model = self._robot.model
        joints = [joint for joint in range(1, model.njoints) if _is_pose(model, joint)]
        return np.concatenate(
            [np.zeros(0, np.int64), *(np.arange(model.nq)[_sliding_part(model, joint)] for joint in joints)]
        )


def _column_levers(robot: Robot, levers: Floats) -> Floats:
    """(nq,) how far one unit of each column moves a point of any body at most, mimic joints included.

    Each column is an angle or a length, and joints follow it linearly, so one step of each column is enough to measure.
    """
    step, base = 0.5, np.zeros(robot.nq)
    full = np.atleast_2d(robot.expand(base + step * np.eye(robot.nq)))
    moved = np.array([pin.difference(robot.model, robot.expand(base), row) for row in full])
    return np.abs(moved / step).reshape(robot.nq, len(levers)) @ levers


def checked_resolution(resolution: float | None, default: float) -> float:
    """A resolution in m, or the default."""
    if resolution is None:
        return default
    check_length(resolution, "resolution")
    return float(resolution)


def samples_are_free(checker: AnyChecker, states: Callable[[Floats], Floats], steps: int) -> bool:
    """Whether all states of one motion at the multiples of 1/steps are valid, coarse ones first.

    `states` is a function from parameters (k,) to states (k, nq).
    """
    parameters = coarse_to_fine(steps)
    batches = (parameters[first : first + _BATCH] for first in range(0, len(parameters), _BATCH))
    return all(checker.check_states(states(batch)).all() for batch in batches)


def coarse_to_fine(steps: int) -> Floats:
    """All multiples of 1/steps in [0, 1], coarse ones first (0, 1, 1/2, 1/4, 3/4, …), to meet a collision early."""
    order = [np.array([0, steps])]
    stride = 1 << max(steps - 1, 0).bit_length()
    while stride > 1:
        order.append(np.arange(stride // 2, steps, stride))
        stride //= 2
    return np.concatenate(order) / steps


def lever_arms(robot: Robot, positions: Floats, excess: float = DEFAULT_EXCESS) -> Floats:
    """How far one unit of each of Pinocchio's velocities moves a point of any body at most.

    Args:
        robot: The robot.
        positions: (full nq,) how far from 0 each number of Pinocchio's configurations gets at most; sliding joints move
            their bodies that far away.
        excess: How far polytopes of cylinders and cones stick out, as a part of the radius.

    Returns:
        (nv,) m for angles in rad (m per rad), 1 for lengths. The distance from a joint to a body is bounded by the sum
        of the lengths between the joints, with sliding joints at these positions.
    """
    model = robot.model
    lever = np.zeros(model.njoints)  # of the bodies that a joint carries, from the joint's frame
    for body in robot.bodies:
        if body.link is None:
            continue
        frame = model.frames[model.getBodyId(body.link)]
        hull, _, inflation_radius = inflated_hull(body.shape, excess)
        points = hull @ body.pose[:3, :3].T + body.pose[:3, 3]
        on_joint = points @ frame.placement.rotation.T + frame.placement.translation
        furthest = float(np.linalg.norm(on_joint, axis=1).max()) + inflation_radius
        lever[frame.parentJoint] = max(lever[frame.parentJoint], furthest)
    for joint in range(model.njoints - 1, 0, -1):
        parent = model.parents[joint]
        carried = (
            lever[joint]
            + float(positions[_sliding_part(model, joint)].sum())
            + float(np.linalg.norm(model.jointPlacements[joint].translation))
        )
        lever[parent] = max(lever[parent], carried)
    return np.concatenate(
        [np.zeros(0), *(_joint_levers(model, joint, lever[joint]) for joint in range(1, model.njoints))]
    )


def _is_pose(model: pin.Model, joint: int) -> bool:
    kind = kind_of(model.joints[joint])
    return kind is not None and kind.is_pose


def _lengths(model: pin.Model, joint: int) -> int:
    """How many of a joint's first numbers are lengths.

    A joint that turns as well moves along a screw of at most half a turn, so its origin stays within d/2 of the middle
    m of the ends, d being the ends' distance. And |m| + d/2 is at most the sum of the larger numbers of both ends. So
    levers are measured at the ends.
    """
    kind = kind_of(model.joints[joint])
    return 0 if kind is None else kind.lengths


def _sliding_part(model: pin.Model, joint: int) -> slice:
    """The numbers of Pinocchio's configurations that are lengths by which a joint slides; there may be none."""
    first = model.idx_qs[joint]
    return slice(first, first + _lengths(model, joint))


def _sliding_columns(robot: Robot) -> NDArray[np.int64]:
    """Numbers of Pinocchio's configurations that are lengths and are moved by the group."""
    model = robot.model
    is_length = np.zeros(model.nq, dtype=bool)
    for joint in range(1, model.njoints):
        is_length[_sliding_part(model, joint)] = True
    low, high = (robot.expand(row) for row in robot.random_configurations(2, seed=0))
    return np.flatnonzero(is_length & (low != high))


def _limits(model: pin.Model) -> Floats:
    """(full nq,) the limit that is further from 0; 0 where there is none."""
    limits = np.abs([model.lowerPositionLimit, model.upperPositionLimit])
    return np.asarray(np.where(limits < NO_LIMIT, limits, 0.0).max(axis=0))


def _joint_levers(model: pin.Model, joint: int, lever: float) -> Floats:
    """(nv of the joint,) the levers, metres per unit of velocity."""
    lengths = _lengths(model, joint)
    return np.array([1.0] * lengths + [lever] * (model.nvs[joint] - lengths))
