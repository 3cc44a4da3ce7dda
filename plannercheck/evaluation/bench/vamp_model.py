"""A robot and its obstacles as VAMP has them: balls in floats, and motions sampled at its own resolution.

In: a checker. Out: a `VampModel` that judges states, motions and plans through VAMP's Python package, where that is
installed and has the robot. VAMP has boxes, balls and capsules: a cylinder becomes the capsule around it, as in VAMP's
own problem files, and a cone or a hull the box around it.

Each call of VAMP copies the obstacles into its vector types. `copying` is a call that does only that. Its time is
subtracted, which leaves VAMP's time in C++.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.part_sets import PartSet
from plannercheck.bodies.point_clouds import PointCloud
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import Box, Capsule, Cylinder, GeometryObject, Sphere
from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.bench.bounding_volumes import box_around
from plannercheck.evaluation.bench.timing import one_by_one
from plannercheck.motions.checker import Checker

# Points of clouds, of which calls are timed, at most.
MOST_POINTS = 2000

Path = Any  # VAMP's
State = NDArray[np.float32]


class VampPlan(NamedTuple):
    """A plan of VAMP's RRT-Connect.

    Attributes:
        path: (k, nq) rad; None if it found none.
        seconds: Time of the search alone by VAMP's own clock.
    """

    path: Floats | None
    seconds: float


class VampModel:
    """A robot among obstacles in VAMP.

    Attributes:
        states_a_radian: Number of states a radian that VAMP samples on motions of this robot.
    """

    def __init__(self, checker: Checker, most_points: int = MOST_POINTS) -> None:
        """Hands the obstacles to VAMP.

        Args:
            checker: A checker whose robot is one of VAMP's, by name and joints.
            most_points: Points of a cloud that are handed over at most: each call copies VAMP's tree of them, which
                with more points takes a thousand times what a state does.

        Raises:
            PlannercheckError: If VAMP is not installed, lacks the robot, or would get more points.
        """
        self._vamp = load_vamp()
        self._name, self._robot = checker.robot.name, _robot(self._vamp, checker)
        self.states_a_radian = int(self._robot.resolution())
        self.environment = self._vamp.Environment()
        obstacles = zip(checker.bodies, checker.polytopes, strict=True)
        for body, polytope in itertools.islice(obstacles, len(checker.robot.bodies), None):
            if isinstance(body.shape, PartSet):
                _add_cloud(self._robot, self.environment, body, most_points)
            else:
                _add(self._vamp, self.environment, body, polytope)

    def rows(self, q: Floats) -> list[State]:
        """Configurations (n, nq) one by one, as VAMP takes them."""
        return list(np.ascontiguousarray(q, dtype=np.float32))

    def paths(self, *ends: Floats) -> list[Path]:
        """Paths through the rows of several (n, nq): motions from two, single states from one given twice."""
        return [self._path(states) for states in zip(*map(self.rows, ends), strict=True)]

    def free(self, paths: Iterable[Path]) -> Bools:
        """Which paths VAMP finds free; each state is judged eight times at once where a path is one state, twice."""
        environment = self.environment
        return np.array([path.validate(environment) for path in paths], dtype=bool)

    def copying(self, count: int) -> list[bool]:
        """What as many calls take that have nothing to judge: a path of one state has no motion."""
        path, environment = self._path([np.zeros(self._robot.dimension(), dtype=np.float32)]), self.environment
        return [path.validate(environment) for _ in range(count)]

    def states_free(self, rows: Sequence[State]) -> Bools:
        """Which states VAMP finds free, one call each from Python."""
        return one_by_one(self._robot.validate, rows, itertools.repeat(self.environment))

    def search(self, start: Floats, goal: Floats, seed: int) -> Callable[[], VampPlan]:
        """A search by VAMP's RRT-Connect from (nq,) to (nq,), rad, with the settings that VAMP has for the robot.

        Seed 1 is the first run of VAMP's Halton sampler; others skip ahead.
        """
        _, planner, settings, _ = self._vamp.configure_robot_and_planner_with_kwargs(self._name, "rrtc")
        sampler = self._robot.halton()
        sampler.skip((seed - 1) * _SKIP)
        first, last = self.rows(np.array([start, goal]))

        def plan() -> VampPlan:
            found = planner(first, last, self.environment, settings, sampler)
            path = np.array(found.path.numpy(), dtype=np.float64) if found.solved else None
            return VampPlan(path, 1e-9 * found.nanoseconds)

        return plan

    def _path(self, states: Iterable[State]) -> Path:
        path = self._robot.Path()
        for state in states:
            path.append(state)
        return path


# So many samples later begins the run of the next seed.
_SKIP = 10_000


def load_vamp() -> Any:
    """VAMP's module, or an error that says what to install."""
    try:
        import vamp
    except ImportError as error:
        raise PlannercheckError(
            "comparing with VAMP needs its package, which is built when it is installed: pip install vamp-planner"
        ) from error
    return vamp


def _robot(vamp: Any, checker: Checker) -> Any:
    """VAMP's module for a robot of this name whose joints are the group's."""
    name, joints = checker.robot.name, list(checker.robot.joint_names)
    if name not in vamp.robots:
        raise PlannercheckError(f"VAMP has no robot {name!r}, only {', '.join(vamp.robots)}")
    robot = getattr(vamp, name)
    if robot.joint_names() != joints:
        raise PlannercheckError(f"VAMP's {name} has the joints {', '.join(robot.joint_names())}, not {joints}")
    if checker.scene.attached:
        raise PlannercheckError("objects that the robot carries are not handed to VAMP")
    return robot


def _add(vamp: Any, environment: Any, body: GeometryObject, polytope: Polytope | None) -> None:
    """Adds an obstacle; one that is in no pair (without a polytope) is left out."""
    turn, place = body.pose[:3, :3], body.pose[:3, 3].tolist()
    if polytope is None:
        return
    match body.shape:
        case Box(size=size):
            environment.add_cuboid(vamp.Cuboid(place, _euler(turn), [edge / 2 for edge in size]))
        case Sphere(radius=radius):
            environment.add_sphere(vamp.Sphere(place, radius))
        case Cylinder(radius=radius, length=length) | Capsule(radius=radius, length=length):
            environment.add_capsule(vamp.Cylinder(place, _euler(turn), radius, length))
        case _:
            box, pose = box_around(polytope)
            turn, place = turn @ pose[:3, :3], body.pose[:3, :3] @ pose[:3, 3] + body.pose[:3, 3]
            environment.add_cuboid(vamp.Cuboid(place.tolist(), _euler(turn), [edge / 2 for edge in box.size]))


def _add_cloud(robot: Any, environment: Any, body: GeometryObject, most: int) -> None:
    """Adds a cloud as VAMP's tree of points that may meet the robot's balls."""
    shape = body.shape
    if not isinstance(shape, PointCloud) or np.ptp(shape.radius) > 0:
        raise PlannercheckError(f"VAMP has nothing like {shape!r}")
    if shape.count > most:
        raise PlannercheckError(f"of clouds VAMP gets {most:,} points at most here, not {shape.count:,}")
    points = shape.points @ body.pose[:3, :3].T + body.pose[:3, 3]
    environment.add_pointcloud(points.tolist(), *robot.min_max_radii(), float(shape.radius[0]))


def _euler(turn: Floats) -> list[float]:
    """Angles about the fixed axes x, y, z, one after the other, rad."""
    return [
        float(np.arctan2(turn[2, 1], turn[2, 2])),
        float(np.arcsin(np.clip(-turn[2, 0], -1, 1))),
        float(np.arctan2(turn[1, 0], turn[0, 0])),
    ]
