"""A robot that plans again with every frame of a moving camera, and how long each step takes.

In: a robot, a scene with a start and a goal, numbers. Out: a `Frame` after each frame, and `StepRow`s of them all. The
camera goes around the scene while a ball moves through it. The robot knows only what the last frame shows: its points
replace those of the frame before, less the robot's own ones. It goes along its plan at a steady speed, and back when it
has arrived. The camera is a process of its own, so that rendering, with NumPy's threads, which go on waiting for work,
is not part of any figure; all else runs on one core.
"""

from __future__ import annotations

import contextlib
import itertools
import multiprocessing
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection

import numpy as np

from plannercheck.bodies.point_clouds import PointCloud
from plannercheck.bodies.shapes import GeometryObject, Sphere
from plannercheck.common.array_types import Floats
from plannercheck.evaluation.sensing.cameras import DepthCamera, looking
from plannercheck.evaluation.sensing.clouds import TARGET, Placed, outside, robot_bodies, scene_bodies
from plannercheck.evaluation.sensing.noise import DepthNoise
from plannercheck.evaluation.sensing.rays import depth_image
from plannercheck.evaluation.worker_processes import ctrl_c_held_back
from plannercheck.motions.checker import Checker
from plannercheck.ompl.planning import plan
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene

# Frames a second, and how fast the robot goes, rad/s.
RATE, _SPEED = 30, 0.6
# Radius of the points, and how near the robot's bodies its own points are, m.
_RADIUS, _OWN = 0.01, 0.03
# Radius and height about the robot's base in which the floor is left out, m.
_BASE = (0.3, 0.1)
# The camera goes back and forth over this angle about the target, rad, at this distance and height, m, so fast, rad/s.
_SWAY, _DISTANCE, _HEIGHT, _TURN = 0.7, 1.7, 1.5, 0.5
# The ball's radius, and where it goes to and fro along y, m and rad/s.
_BALL, _BALL_AT, _BALL_WAY, _BALL_SPEED = 0.08, (0.35, 0.0, 0.75), 0.6, 0.8
# Pixels for each wanted point: some see nothing.
_SPARE = 2.3
# States that are judged after each frame.
STATES = 1000
# A search that has not ended after so many s is given up until the next frame.
_LIMIT = 1.0
_NAME = "camera"
STEPS = ("own points", "update", "checker", "states", "plan")


@dataclass(frozen=True)
class Frame:
    """What happened after a frame.

    Attributes:
        points: Number of points that the camera saw.
        kept: Those that are not the robot's own.
        seconds: Processor time of each of `STEPS`.
        free: Part of the random states that is free.
        states: States of the new path; 0 if there is none.
    """

    points: int
    kept: int
    seconds: tuple[float, ...]
    free: float
    states: int

    @property
    def total(self) -> float:
        """Seconds of all steps."""
        return sum(self.seconds)


@dataclass(frozen=True)
class StepRow:
    """What a step takes over all frames, in ms of the processor; the last row is that of all steps together.

    Attributes:
        step: One of `STEPS`, or "all".
        median: Of the frames.
        late: What 95 % of the frames do not exceed.
        most: Of any frame.
        frames: How many frames there were.
        points: Mean number of points that the camera saw.
        kept: Mean number of those that are not the robot's own.
        states: How many states are judged after each frame.
        in_time: Part of the frames after which all was done before the next one.
        planned: Part of the frames with a path.
    """

    step: str
    median: float
    late: float
    most: float
    frames: int
    points: float
    kept: float
    states: int
    in_time: float
    planned: float


def step_rows(found: Sequence[Frame]) -> list[StepRow]:
    """What each step takes, and all together."""
    spent = 1e3 * np.array([[*frame.seconds, frame.total] for frame in found])
    quantiles = np.quantile(spent, (0.5, 0.95, 1.0), axis=0).T.tolist()
    points, kept, planned = np.mean([(frame.points, frame.kept, frame.states > 0) for frame in found], axis=0).tolist()
    in_time = float((spent[:, -1] < 1e3 / RATE).mean())
    return [
        StepRow(step, median, late, most, len(found), points, kept, STATES, in_time, planned)
        for step, (median, late, most) in zip((*STEPS, "all"), quantiles, strict=True)
    ]


def frames(robot: Robot, scene: Scene, count: int, points: int, seed: int) -> Iterator[Frame]:
    """Goes through `count` frames of at most so many points, of a scene with a start and a goal for the robot.

    The seed is that of noise, states and searches.
    """
    with _camera(robot, scene, points, seed) as seen_at:
        yield from _followed(robot, scene, count, seed, seen_at)


# Points (n, 3) of the frame at a robot's state and a time in s.
_Camera = Callable[[Floats, float], Floats]


def _followed(robot: Robot, scene: Scene, count: int, seed: int, seen_at: _Camera) -> Iterator[Frame]:
    q, goals = scene.start(robot.name), [scene.goal(robot.name), scene.start(robot.name)]
    known = Scene("what the camera sees")
    checker = Checker(robot)
    known.add(_NAME, PointCloud(seen_at(q, 0.0), np.array([_RADIUS])))
    states = robot.random_configurations(STATES, seed)
    path: Floats = q[None]
    for k in range(count):
        seen = seen_at(q, k / RATE)
        clock = [time.process_time()]
        kept = robot.remove_own_points(seen, q, _OWN)
        clock.append(time.process_time())
        known.update(_NAME, kept)
        clock.append(time.process_time())
        checker = checker.with_scene(known)
        clock.append(time.process_time())
        free = checker.check_states(states)
        clock.append(time.process_time())
        path = _planned(checker, q, goals[0], 1 + seed + k)
        clock.append(time.process_time())
        yield Frame(len(seen), len(kept), tuple(np.diff(clock).tolist()), float(free.mean()), len(path))
        q = _along(path, _SPEED / RATE) if len(path) else q
        if np.array_equal(q, goals[0]):
            goals.reverse()


@contextlib.contextmanager
def _camera(robot: Robot, scene: Scene, points: int, seed: int) -> Iterator[_Camera]:
    """A camera in a process of its own."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    resource_tracker.ensure_running()  # starting it lets Ctrl-C through again
    process = context.Process(target=_render, args=(theirs, robot, scene, points, seed), daemon=True)
    with ctrl_c_held_back():
        process.start()
    theirs.close()

    def seen_at(q: Floats, at: float) -> Floats:
        ours.send((q, at))
        return np.asarray(ours.recv())

    try:
        yield seen_at
    finally:
        process.terminate()
        process.join()
        ours.close()


def _render(asked: Connection, robot: Robot, scene: Scene, points: int, seed: int) -> None:
    """Sends what is seen at each state and time that comes."""
    rng = np.random.default_rng(seed)
    while True:
        q, at = asked.recv()
        asked.send(_seen(robot, scene, q, at, points, rng))


def _seen(robot: Robot, scene: Scene, q: Floats, at: float, count: int, rng: np.random.Generator) -> Floats:
    """The points (n, 3) of the frame at a time in s: scene, ball and robot."""
    bodies: Placed = [*scene_bodies(scene), _ball(at), *robot_bodies(robot, q)]
    angle = np.pi + _SWAY * np.sin(_TURN * at)
    eye = np.array([_DISTANCE * np.cos(angle), _DISTANCE * np.sin(angle), _HEIGHT])
    eye[:2] += TARGET[:2]
    width = int(np.ceil(np.sqrt(count * _SPARE * 4 / 3)))
    camera, pose = DepthCamera(width, -(-width * 3 // 4)), looking(eye, TARGET)
    depth = DepthNoise().of(depth_image(bodies, camera, pose), rng)
    points = outside(camera.points(depth, pose), _BASE)
    if len(points) > count:
        points = points[np.sort(rng.choice(len(points), count, replace=False))]
    return np.ascontiguousarray(points)


def _ball(at: float) -> tuple[GeometryObject, Floats]:
    """The ball that moves, at a time in s."""
    pose = np.eye(4)
    pose[:3, 3] = _BALL_AT
    pose[1, 3] += _BALL_WAY * np.sin(_BALL_SPEED * at)
    return GeometryObject("ball", None, pose, Sphere(_BALL)), pose


def _planned(checker: Checker, q: Floats, goal: Floats, seed: int) -> Floats:
    """A path (n, nq) from a state to a goal; empty if there is none, or an end collides."""
    if not (checker.is_valid(q) and checker.is_valid(goal)):
        return np.zeros((0, len(q)))
    found = plan(checker, q, goal, time_limit=_LIMIT, seed=seed, simplify=False)
    return found.path if found.solved else np.zeros((0, len(q)))


def _along(path: Floats, way: float) -> Floats:
    """The state (nq,) so far along a path, rad; its end if that is nearer."""
    for start, end in itertools.pairwise(path):
        length = float(np.linalg.norm(end - start))
        if way < length:
            return np.asarray(start + way / length * (end - start))
        way -= length
    return np.asarray(path[-1])
