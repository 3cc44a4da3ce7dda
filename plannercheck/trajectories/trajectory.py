"""A trajectory: the curve of configurations in time that a robot executes.

In: points with a controller that interpolates them, or polynomials, Bézier curves, B-splines; or a file of a message.
Out: `Trajectory`: positions, velocities, and the limits that it breaks.

A trajectory that is slowed down, by speed scaling or by a pendant, runs through the same configurations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.arrays import named_numbers, shown_array
from plannercheck.common.checked_yaml import error_context
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.public_names import set_module
from plannercheck.common.shown_times import shown_seconds
from plannercheck.common.user_warnings import warn
from plannercheck.robots.robot import Robot
from plannercheck.trajectories.controllers import Controller, Points, curve_of
from plannercheck.trajectories.curve import Curve, check_curve
from plannercheck.trajectories.files import read_points
from plannercheck.trajectories.forms import of_bezier, of_bspline, of_polynomials
from plannercheck.trajectories.joint_columns import check_order, check_robot
from plannercheck.trajectories.library_curves import of_library
from plannercheck.trajectories.limits import Excess, Kind, broken_limits
from plannercheck.trajectories.timing import Timing
from plannercheck.trajectories.written_messages import write_message

# How far control points of unit vectors may be off what is meant, as a part of their length.
MOST_OFF = 1e-10


@set_module("plannercheck")
class Trajectory:
    """A trajectory of a robot; it can't be changed.

    Attributes:
        curve: Its polynomials.
        points: The points that a controller interpolates; None if the curve was given as such.
        controller: Who interpolates them; None likewise.
        timing: What rounding the corners of a plan brought, where `pc.time_path` made it; else None.
    """

    def __init__(
        self,
        times: ArrayLike,
        positions: ArrayLike,
        velocities: ArrayLike | None = None,
        accelerations: ArrayLike | None = None,
        controller: Controller = "jtc",
        start: ArrayLike | tuple[ArrayLike, ArrayLike] | None = None,
        continuous: Sequence[int] = (),
        joint_names: Sequence[str] = (),
    ) -> None:
        """A trajectory of points.

        Args:
            times: (n,) s, growing, from 0 on.
            positions: (n, nq) rad and m.
            velocities: (n, nq) rad/s and m/s; a point without velocities has NaN.
            accelerations: (n, nq) rad/s² and m/s²; likewise.
            controller: Who interpolates: "jtc", "jtc-upsampled", "ur", "motoros2" or "linear".
            start: Where the robot stands at 0 s, (nq,), or q and velocities: the controller moves it from there to the
                first point. None: the robot is at the first point.
            continuous: Columns of joints that turn without end, from which the controller takes whole turns on the
                way to the first point.
            joint_names: Names of the columns, for `save` and errors; no robot may have these joints in another order.

        Raises:
            PlannercheckError: If an array is malformed, times do not grow, or the controller refuses the points.
        """
        self.points: Points | None = _points(times, positions, velocities, accelerations, tuple(joint_names))
        self.controller: Controller | None = controller
        self.timing: Timing | None = None
        width = self.points.positions.shape[1]
        self.curve = curve_of(self.points, controller, _start(start, width), continuous)

    @classmethod
    def of_curve(cls, curve: Curve) -> Trajectory:
        """A trajectory that is a curve, of pieces that meet."""
        check_curve(curve)
        made = cls.__new__(cls)
        made.points, made.controller, made.timing, made.curve = None, None, None, curve
        return made

    @classmethod
    def polynomials(cls, breaks: Any, coefficients: ArrayLike | None = None) -> Trajectory:
        """A trajectory of polynomials.

        Args:
            breaks: (m + 1,) s, growing; or, here and in `bezier` and `bspline`, an object of drake, ndcurves or SciPy
                alone (library_curves.py lists them).
            coefficients: (m, nq, degree + 1), of 1, t − breaks[k], its square and so on.
        """
        return cls.of_curve(of_library(breaks) if coefficients is None else of_polynomials(breaks, coefficients))

    @classmethod
    def bezier(cls, breaks: Any, points: ArrayLike | None = None) -> Trajectory:
        """A trajectory of Bézier curves: breaks (m + 1,) s, control points (m, degree + 1, nq)."""
        return cls.of_curve(of_library(breaks) if points is None else of_bezier(breaks, points))

    @classmethod
    def bspline(cls, knots: Any, points: ArrayLike | None = None) -> Trajectory:
        """A trajectory that is a B-spline: knots (n + degree + 1,) s, control points (n, nq)."""
        return cls.of_curve(of_library(knots) if points is None else of_bspline(knots, points))

    @classmethod
    def load(
        cls,
        path: str | Path,
        robot: Robot,
        controller: Controller = "jtc",
        start: ArrayLike | tuple[ArrayLike, ArrayLike] | None = None,
        message: int | None = None,
    ) -> Trajectory:
        """Reads a JointTrajectory, also within a RobotTrajectory, DisplayTrajectory or FollowJointTrajectory goal.

        Args:
            path: A .yaml or .json file, e.g. of `ros2 topic echo --once`; a .csv or .npz (tables.py says which columns
                and arrays); or a bag: its folder, .mcap, .db3 or .bag, which needs the extra `rosbags`.
            robot: Whose it is: its joints take one number each.
            controller: Who interpolates.
            start: Where the robot stands, as in the constructor.
            message: Which of several messages, counted from 0.

        Raises:
            PlannercheckError: If the file is malformed, it lacks joints of the robot, moves others, or has others
                elsewhere than the robot holds them (`robot.holding`); or it holds several messages and `message` is
                None: the error lists them.
        """
        points = read_points(path, robot, message)
        turning = np.flatnonzero(robot.configuration_map.turning_columns()).tolist()
        arrays = (points.times, points.positions, points.velocities, points.accelerations)
        with error_context(f"trajectory file {str(path)!r}"):
            made = cls(*arrays, controller, start, turning, points.joint_names)
        if made.curve.breaks[0] > 0 and start is None and controller != "motoros2":
            warn(
                f"trajectory file {str(path)!r}: its first point is at {shown_seconds(made.curve.breaks[0])} s, and it"
                " is judged from then on: start= (--start) adds the way from where the robot stands"
            )
        return made

    def save(self, path: str | Path) -> None:
        """Writes the points as a JointTrajectory, which `load` reads back to the same doubles.

        Args:
            path: A .yaml or .json file. The message has neither `controller` nor `start`.

        Raises:
            PlannercheckError: If the trajectory is a curve, has no joint_names, or its times are not whole nanoseconds.
        """
        if self.points is None:
            raise PlannercheckError("a curve is no message: only a trajectory of points can be saved")
        write_message(self.points, Path(path))

    def of_robot(self, robot: Robot) -> Trajectory:
        """The same trajectory, of a robot whose configurations hold unit vectors: cosines and sines, or quaternions.

        They turn from the start of a piece to its end by slerp, the short way; what the trajectory says of them in
        between does not count. Positions of floating and planar bases follow their polynomials.

        Raises:
            PlannercheckError: If the robot has another number of columns, a unit vector has another length, or points
                have velocities of one.
        """
        check_robot(robot)
        units, columns = robot.configuration_map.units, robot.configuration_map.described_columns()
        if robot.nq != self.curve.nq:
            raise PlannercheckError(f"the trajectory has {self.curve.nq} columns, but {columns}")
        check_order(robot, self.points)
        robot.check_configurations(np.concatenate([piece[[0, -1]] for piece in self.curve.pieces]))
        for first, past in units:
            if self.points is not None and np.nan_to_num(self.points.velocities[:, first:past]).any():
                raise PlannercheckError(
                    f"columns {first} to {past - 1} turn by slerp between points: set their velocities to 0"
                )
            off = float(self.curve.error[first:past].max())
            if off > MOST_OFF:  # no tube is around a unit vector, in which the error could count
                raise PlannercheckError(
                    f"columns {first} to {past - 1} form a unit vector, but are off by up to {off:.3g}: give pieces"
                    " that meet there, and coefficients that are not much larger than 1"
                )
        made = Trajectory.of_curve(replace(self.curve, units=units))
        made.points, made.controller = self.points, self.controller
        return made

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return float(self.curve.breaks[-1] - self.curve.breaks[0])

    def position(self, time: ArrayLike) -> Floats:
        """Configurations (n, nq) at times (n,), or (nq,) at one; s, rad and m."""
        return self.curve.at(time)

    def velocity(self, time: ArrayLike) -> Floats:
        """Velocities likewise; at a break those of the later piece."""
        return self.curve.at(time, 1)

    def acceleration(self, time: ArrayLike) -> Floats:
        """Accelerations likewise."""
        return self.curve.at(time, 2)

    def limits(
        self, robot: Robot, velocity: ArrayLike | None = None, acceleration: ArrayLike | None = None
    ) -> list[Excess]:
        """The limits that the trajectory breaks, also between its points.

        Args:
            robot: Whose position limits count.
            velocity: (nq,) or a number, largest speed of each joint, rad/s and m/s; None: no limit. MoveIt's are in
                joint_limits.yaml.
            acceleration: Likewise, rad/s² and m/s².

        Returns:
            For each joint and kind the worst, with the instant; none if all are kept.
        """
        check_robot(robot)
        if robot.nq != self.curve.nq or len(robot.joint_names) != robot.nq:
            columns = robot.configuration_map.described_columns()
            raise PlannercheckError(f"the trajectory has {self.curve.nq} columns, one a joint, but {columns}")
        check_order(robot, self.points)
        found = broken_limits(self.curve, robot.joint_names, "position", robot.lower, robot.upper)
        asked: tuple[tuple[Kind, ArrayLike | None], ...] = (("velocity", velocity), ("acceleration", acceleration))
        for kind, given in asked:
            if given is not None:
                row = named_numbers(given, kind)
                if row.shape not in ((1,), (robot.nq,)) or not (row >= 0).all():
                    raise PlannercheckError(
                        f"{kind} must be a limit of at least 0, or {robot.nq}, one a joint, not {shown_array(given)}"
                    )
                largest = np.broadcast_to(row, robot.nq)
                found += broken_limits(self.curve, robot.joint_names, kind, -largest, largest)
        return found

    def __repr__(self) -> str:
        by = "" if self.controller is None else f" by {self.controller}"
        return f"Trajectory({len(self.curve.pieces)} pieces{by}, {self.duration:.3g} s, nq={self.curve.nq})"


def _points(
    times: ArrayLike,
    positions: ArrayLike,
    velocities: ArrayLike | None,
    accelerations: ArrayLike | None,
    joint_names: tuple[str, ...] = (),
) -> Points:
    at, q = named_numbers(times, "times"), named_numbers(positions, "positions")
    if at.ndim != 1 or not len(at) or q.ndim != 2 or len(q) != len(at) or not q.shape[1]:
        raise PlannercheckError(f"a trajectory takes times (n,) and positions (n, nq), not {at.shape} and {q.shape}")
    if not np.isfinite(at).all() or at[0] < 0 or not (np.diff(at) > 0).all():
        wrong = int(np.argmin(np.concatenate([[at[0] >= 0], np.diff(at) > 0])))
        raise PlannercheckError(f"times must grow from 0 s on, but point {wrong} is at {at[wrong]} s")
    if joint_names and len(joint_names) != q.shape[1]:
        raise PlannercheckError(f"joint_names must name the {q.shape[1]} columns, not {len(joint_names)}")
    v, a = _derivatives(velocities, "velocities", q), _derivatives(accelerations, "accelerations", q)
    points = Points(at, q, v, a, joint_names)
    _check_finite(points, "positions", np.isfinite(q))
    for name, rows in (("velocities", v), ("accelerations", a)):
        _check_finite(points, name, np.isfinite(rows) | np.isnan(rows).all(axis=1, keepdims=True))
    return points


def _check_finite(points: Points, name: str, good: Bools) -> None:
    """Raises for the first number that is not good."""
    if not good.all():
        k, joint = np.argwhere(~good)[0].tolist()
        value = getattr(points, name)[k, joint]
        whole = "" if name == "positions" else ", or NaN for a whole point"
        raise PlannercheckError(f"{name} must be finite{whole}: point {k}, {points.named(joint)} has {value}")


def _derivatives(values: ArrayLike | None, name: str, positions: Floats) -> Floats:
    """(n, nq) numbers; NaN if there are none."""
    if values is None:
        return np.full_like(positions, np.nan)
    rows = named_numbers(values, name)
    if rows.shape != positions.shape:
        raise PlannercheckError(f"{name} must have the shape of positions, {positions.shape}, not {rows.shape}")
    return rows


def _start(start: ArrayLike | tuple[ArrayLike, ArrayLike] | None, width: int) -> Points | None:
    if start is None:
        return None
    q, v = start if isinstance(start, tuple) else (start, None)
    if np.shape(q) != (width,) or (v is not None and np.shape(v) != (width,)):
        raise PlannercheckError(
            f"start must be a configuration ({width},), or a tuple of one and its velocities, not {shown_array(start)}"
        )
    return _points([0.0], [q], None if v is None else [v], None)
