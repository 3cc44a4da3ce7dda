"""Where an object that moves is: its pose as a function of the scene's clock.

In: times and poses, or a robot's trajectory and one of its links. Out: `Moving`, which a scene takes for a pose.
Between two poses the position is straight and the turn goes the short way at constant speed, each by itself, or both
along one screw. The turns are quaternions in doubles: at its times, an object is turned as given up to their rounding.
"""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.bodies.shapes import checked_pose
from plannercheck.bodies.sizes import number
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import contiguous, read_only, shown_array
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.motion_paths import MotionPath, check_path
from plannercheck.common.public_names import set_module
from plannercheck.common.shown_times import shown_seconds, shown_span
from plannercheck.common.transforms import quaternion_of_rotation

Outside: TypeAlias = Literal["refuse", "stand"]

# Turns from half a turn less about twice this on have no short way in doubles, rad.
_HALF_TURN = 1e-6

# The shortest step between two poses, s, as between two points of a trajectory.
_SHORTEST = 1e-9


@dataclass(frozen=True, eq=False)
class Ride:
    """A link of another robot on which an object rides; trajectories and robots are of folders above this one.

    Attributes:
        trajectory: A `Trajectory`.
        robot: The `Robot` that runs it, or the robot and the pose (4, 4) of its base, m.
        link: The link.
        start_time: The scene's clock where the trajectory begins, s.
    """

    trajectory: Any
    robot: Any
    link: str
    start_time: float


@set_module("plannercheck")
class Moving:
    """The pose of an object as a function of time; objects that share it are moved as one. It can't be changed.

    Attributes:
        times: (m,) s of the scene's clock; none for an object that rides on a link.
        poses: (m, 4, 4) m; likewise.
        path: How it moves between two poses.
        outside: What holds before the first time and after the last.
        ride: The link that it rides on; None if its poses are given.
        rows: (m, 7) position and quaternion x, y, z, w.
    """

    def __init__(
        self, times: ArrayLike, poses: ArrayLike, path: MotionPath = "slerp", outside: Outside = "refuse"
    ) -> None:
        """An object at given poses.

        Args:
            times: (m,) s of the scene's clock, growing, two or more.
            poses: (m, 4, 4) of the object's frame in the world, m.
            path: "slerp": straight, and turning the short way at constant speed. "screw": about and along the one axis
                that leads from a pose to the next.
            outside: Before the first time and after the last, "refuse" is an error, "stand" stands still.

        Raises:
            PlannercheckError: If times do not grow, a pose is not rigid, or two poses are half a turn apart.
        """
        self.times, self.poses = _checked_times(times), _checked_poses(poses)
        self.path, self.outside = path, _checked_outside(outside)
        self.ride: Ride | None = None
        if len(self.times) != len(self.poses):
            raise PlannercheckError(f"Moving takes as many times as poses, not {len(self.times)} and {len(self.poses)}")
        check_path(path)
        self.rows = _rows(self.poses)

    @classmethod
    def along(
        cls, trajectory: Any, link: str, robot: Any, start_time: float = 0.0, outside: Outside = "refuse"
    ) -> Moving:
        """An object that rides on a link of another robot, whose bodies are left out.

        Args:
            trajectory: The `Trajectory` that the robot runs.
            link: The link; the object's frame is the link's.
            robot: The `Robot`, or the robot and the pose (4, 4) of its base, m.
            start_time: The scene's clock at the trajectory's beginning, s.
            outside: As for `Moving`: "stand" stands still before the trajectory and after it.

        Raises:
            PlannercheckError: If `start_time` is no number or the base's pose is not rigid. What does not fit the robot
                is named by the checker.
        """
        if isinstance(robot, tuple) and len(robot) == 2:
            robot = robot[0], checked_pose(robot[1], f"the base of the robot on whose link {link!r} it rides")
        made = cls.__new__(cls)
        made.times, made.poses, made.rows = np.zeros(0), np.zeros((0, 4, 4)), np.zeros((0, 7))
        made.path, made.outside = "slerp", _checked_outside(outside)
        made.ride = Ride(trajectory, robot, link, checked_time(start_time, "start_time"))
        return made

    def __repr__(self) -> str:
        if self.ride is not None:
            return f"Moving(along link {self.ride.link!r} from {shown_seconds(self.ride.start_time)} s)"
        return f"Moving({len(self.times)} poses, {shown_span(*self.times[[0, -1]].tolist())})"


def is_screw(moving: Moving) -> bool:
    """Whether a step both slides and turns, along a screw; else both paths are the same."""
    slides = (moving.rows[1:, :3] != moving.rows[:-1, :3]).any(axis=1)
    turns = (moving.rows[1:, 3:] != moving.rows[:-1, 3:]).any(axis=1)
    return moving.path == "screw" and bool((slides & turns).any())


def carrier_of(moving: Moving) -> Hashable:
    """A key: objects of the same key are moved by the same joints."""
    if moving.ride is None:
        return moving.times.tobytes(), moving.poses.tobytes(), moving.path, moving.outside
    robot, base = moving.ride.robot if isinstance(moving.ride.robot, tuple) else (moving.ride.robot, None)
    placed = None if base is None else np.asarray(base).tobytes()
    return id(moving.ride.trajectory), id(robot), placed, moving.ride.start_time, moving.outside


# Where an object is: its pose (4, 4), m, the identity by default, or how it moves.
Placement: TypeAlias = "ArrayLike | Moving | None"


def checked_time(time: Any, what: str) -> float:
    """One finite number of seconds."""
    found = number(time, f"{what} must be a number of seconds")
    if not math.isfinite(found):
        raise PlannercheckError(f"{what} must be a number of seconds, not {shown_array(time)}")
    return found


def _checked_times(times: ArrayLike) -> Floats:
    try:
        at = contiguous(times)
    except (TypeError, ValueError, OverflowError):
        raise PlannercheckError(f"times of Moving must be numbers (n,), s, not {shown_array(times)}") from None
    if at.ndim != 1 or len(at) < 2:
        raise PlannercheckError(
            f"times of Moving must be two or more, (n,), s, not {at.shape}: an object of one pose does not move"
        )
    grows = np.append(np.isfinite(at[0]), np.diff(at) >= _SHORTEST) & np.isfinite(at)
    if not grows.all():
        k = int(np.argmin(grows))
        raise PlannercheckError(f"times of Moving must grow by 1 ns or more, but time {k} is {at[k]} s")
    return read_only(at.copy())


def _checked_poses(poses: ArrayLike) -> Floats:
    try:
        given = contiguous(poses)
    except (TypeError, ValueError, OverflowError):
        raise PlannercheckError(
            f"poses of Moving must be matrices (n, 4, 4) in metres, not {shown_array(poses)}"
        ) from None
    if given.ndim != 3 or given.shape[1:] != (4, 4):
        raise PlannercheckError(f"poses of Moving must be matrices (n, 4, 4) in metres, not of shape {given.shape}")
    for k, pose in enumerate(given):
        checked_pose(pose, f"pose {k} of Moving")
    return read_only(given.copy())


def _checked_outside(outside: Any) -> Outside:
    if outside not in get_args(Outside):
        raise unknown_name("value of outside=", str(outside), get_args(Outside))
    return outside  # type: ignore[no-any-return]


def _rows(poses: Floats) -> Floats:
    """(m, 7) positions and quaternions, whose signs are such that each turn is the short one."""
    rows = np.empty((len(poses), 7))
    rows[:, :3] = poses[:, :3, 3]
    rows[:, 3:] = [quaternion_of_rotation(pose[:3, :3]) for pose in poses]
    for k in range(1, len(rows)):
        along = float(rows[k - 1, 3:] @ rows[k, 3:])
        if abs(along) < _HALF_TURN:
            raise PlannercheckError(
                f"poses {k - 1} and {k} of Moving are half a turn apart, so that no way is the short one: give a pose"
                " in between"
            )
        if along < 0:
            rows[k, 3:] *= -1.0
    return read_only(rows)
