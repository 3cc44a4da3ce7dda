"""The clock of a scene in which something moves: where each moving object is at each time.

In: a robot and the scene's moving objects. Out: `SceneClock`: the robot with joints that carry these objects, and
configurations or trajectories of the robot with the numbers of these joints at their times.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.bodies.moving import Moving, Ride, carrier_of, checked_time, is_screw
from plannercheck.bodies.objects import SceneObject
from plannercheck.checking.compiled_tables import never_known
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import contiguous, shown_array
from plannercheck.common.checked_yaml import error_context
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.shown_times import shown_seconds, shown_span
from plannercheck.common.transforms import identity
from plannercheck.robots.carriers import CarriedRobot, Carrier, free_carrier
from plannercheck.robots.robot import Robot
from plannercheck.robots.screw_carriers import screw_carrier
from plannercheck.trajectories.curve import Curve
from plannercheck.trajectories.joint_columns import check_order
from plannercheck.trajectories.one_clock import Clocked, side_by_side
from plannercheck.trajectories.trajectory import Trajectory

AnyChecker = TypeVar("AnyChecker")

# So long before its first time and after its last an object stands still, s: sums of times are rounded (0.1 + 0.2 is
# not 0.3). Proofs count it with the nanosecond within which knots are one.
_ROUNDED = 1e-12


@dataclass(frozen=True, eq=False)
class Course:
    """The course of the joints that carry some objects.

    Attributes:
        objects: Their names.
        curve: The joints' numbers.
        knots: Its breaks on the scene's clock, s.
        stands: Whether they stand still before and after it.
    """

    objects: tuple[str, ...]
    curve: Curve
    knots: Floats
    stands: bool

    def at(self, times: Floats) -> Floats:
        """(n, width) numbers at times (n,) of the scene's clock."""
        self.check(float(times.min(initial=np.inf)), float(times.max(initial=-np.inf)))
        first, last = self.curve.breaks[[0, -1]].tolist()
        return self.curve.at(np.clip(times - (self.knots[0] - first), first, last))

    def check(self, begin: float, end: float) -> None:
        """Raises if the course does not say where its objects are from begin to end, s."""
        first, last = self.knots[[0, -1]].tolist()
        if not self.stands and (begin < first - _ROUNDED or end > last + _ROUNDED):
            time = begin if begin < first - _ROUNDED else end
            raise PlannercheckError(
                f"object {self.objects[0]!r} moves from {shown_span(first, last)} of the scene's clock, not at"
                f" {shown_seconds(time)} s: give its Moving more poses, or outside='stand'"
            )


class SceneClock:
    """The clock of one robot's scene. Immutable.

    Attributes:
        robot: The robot with the joints that carry what moves.
        own: The robot without them.
        courses: The courses of what moves, in the order of its columns, which follow the robot's.
    """

    def __init__(self, robot: Robot, moving: Sequence[SceneObject]) -> None:
        """Makes the joints that carry the moving objects of a scene.

        Raises:
            PlannercheckError: If an object has the name of a link, or rides on a link that there is not.
        """
        self.own, self._moving = robot, tuple(moving)
        groups: dict[Hashable, list[SceneObject]] = {}
        for item in moving:
            if item.name in {*robot.link_names, *robot.model.names}:
                raise PlannercheckError(f"object {item.name!r} moves, but a link or joint of the robot has its name")
            groups.setdefault(carrier_of(_moving(item)), []).append(item)
        made = [_carried(items) for items in groups.values()]
        self.robot = CarriedRobot(robot, [carrier for carrier, _ in made])
        self.courses = tuple(course for _, course in made)

    def fits(self, robot: Robot, moving: Sequence[SceneObject]) -> bool:
        """Whether it is the clock of a robot and moving objects."""
        same = [(item.name, item.moving) for item in self._moving] == [(item.name, item.moving) for item in moving]
        return self.own is robot and same

    def rows(self, q: Floats, times: ArrayLike) -> Floats:
        """Configurations of the carrying robot, from the robot's own, (n, nq) or (1, nq), at times (n,) or one, s."""
        at = self._checked(times, len(q))
        if len(at) > len(q) == 1:
            q = np.repeat(q, len(at), axis=0)
        return np.concatenate([q, *(course.at(at) for course in self.courses)], axis=1)

    def _checked(self, times: ArrayLike, count: int) -> Floats:
        try:
            given = contiguous(times)
        except (TypeError, ValueError, OverflowError):
            raise PlannercheckError(f"times must be numbers, s, not {shown_array(times)}") from None
        if np.ndim(times) == 0:
            given = np.repeat(given, count)
        if given.ndim != 1 or (len(given) != count and (count != 1 or len(given) == 0)) or not np.isfinite(given).all():
            raise PlannercheckError(
                f"times must be one finite number, or one a configuration, ({count},), s, not {shown_array(times)}"
            )
        return given

    def on_clock(self, trajectory: Trajectory, start_time: float) -> Trajectory:
        """A trajectory of the robot that carries: the robot's own, begun at a time of the scene's clock.

        Raises:
            PlannercheckError: If the scene does not say where an object is then.
        """
        own = trajectory.curve
        knots = own.breaks + (checked_time(start_time, "start_time") - own.breaks[0])
        begin, end = knots[[0, -1]].tolist()
        for course in self.courses:
            course.check(begin, end)
        runs = [Clocked(own, knots), *(Clocked(course.curve, course.knots) for course in self.courses)]
        return Trajectory.of_curve(side_by_side(runs, begin, end))

    def missing(self) -> PlannercheckError:
        """The error of a question without a time."""
        names = ", ".join(repr(item.name) for item in self._moving)
        return PlannercheckError(
            f"{names} {'moves' if len(self._moving) == 1 else 'move'}, so say when: times= for states (time= for one),"
            " check_trajectory(trajectory, start_time=) for motions"
        )


@dataclass(frozen=True)
class MovingScene(Generic[AnyChecker]):
    """A scene's clock, and the checker of the robot that carries what moves."""

    clock: SceneClock
    checker: AnyChecker


class NeedsTimes:
    """Stands in the place of `CompiledTables`: any question to it lacks a time."""

    def __init__(self, clock: SceneClock) -> None:
        self._clock = clock

    def judges(self, _kernel: Any) -> tuple[Any, Any]:
        """Compiled judges that know of no verdict."""
        return never_known, never_known

    def __getattr__(self, name: str) -> Any:
        raise self._clock.missing()


def _moving(item: SceneObject) -> Moving:
    assert item.moving is not None
    return item.moving


def _carried(items: Sequence[SceneObject]) -> tuple[Carrier, Course]:
    """The joints that carry some objects that are moved as one, and their course."""
    moving, names = _moving(items[0]), tuple(item.name for item in items)
    stands = moving.outside == "stand"
    if moving.ride is not None:
        return _riding(items, moving.ride, stands)
    carrier, rows = free_carrier(names, moving.rows), moving.rows
    if is_screw(moving):
        carrier, rows = screw_carrier(names, moving.rows)
    pieces = tuple(np.stack(pair) for pair in pairwise(rows))
    curve = Curve(moving.times, pieces, np.zeros(rows.shape[1]), carrier.sources.units)
    return carrier, Course(names, curve, curve.breaks, stands)


def _riding(items: Sequence[SceneObject], ride: Ride, stands: bool) -> tuple[Carrier, Course]:
    what = f"object {items[0].name!r} moves along a trajectory"
    given: Any = ride.robot
    robot, base = given if isinstance(given, tuple) and len(given) == 2 else (given, None)
    if not isinstance(robot, Robot) or not isinstance(ride.trajectory, Trajectory):
        raise PlannercheckError(f"{what}: Moving.along takes a pc.Trajectory, the name of a link, and a pc.Robot")
    curve = ride.trajectory.curve
    if curve.nq != robot.nq or curve.units != robot.configuration_map.units:
        raise PlannercheckError(
            f"{what}, which has {curve.nq} columns, but {robot.configuration_map.described_columns()}; of a robot whose"
            " columns form unit vectors, give trajectory.of_robot(robot)"
        )
    with error_context(what):
        check_order(robot, ride.trajectory.points)
    links: dict[str, str] = {}
    for item in items:
        own = _moving(item).ride
        assert own is not None
        if own.link not in robot.link_names:
            raise unknown_name(f"link that {item.name!r} rides on", str(own.link), robot.link_names)
        links[item.name] = own.link
    points = np.concatenate([*curve.pieces])
    carrier = Carrier(
        items[0].name,
        robot.model,
        robot.configuration_map,
        identity() if base is None else base,
        links,
        curve.pieces[0][0],
        points.min(axis=0),
        points.max(axis=0),
    )
    knots = curve.breaks + (ride.start_time - curve.breaks[0])
    return carrier, Course(tuple(links), curve, knots, stands)
