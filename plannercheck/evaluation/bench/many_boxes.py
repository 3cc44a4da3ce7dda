"""The cost of very many boxes: a scene of them and a checker in it, in time and memory.

In: how many boxes, and whether all of them are within a robot's reach. Out: `BoxesRow`. Each is measured in a separate
process, because a process keeps its memory, and its peak counts. Times are processor times.
"""

from __future__ import annotations

import json
import sys
import time
import warnings
from dataclasses import dataclass

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.isolated_process import run_isolated_lines
from plannercheck.common.transforms import at_places
from plannercheck.motions.checker import Checker
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene

# Half the side of the square in which a thousand boxes stand, m; more boxes stand in a larger square, as densely.
_SIDE = 1.2
_HEIGHTS = 0.8, 1.6
# Where all are within reach, they stand in this cube about the robot's base, m.
_REACH = 0.8
# Edges of the boxes, m; those within reach are a tenth of that.
_EDGES = 0.01, 0.03
_PATIENCE = 600  # s
_RUN = (
    "import json, sys; from plannercheck.evaluation.bench.many_boxes import costs; "
    "print(json.dumps(costs(*json.loads(sys.argv[1]))))"
)


@dataclass(frozen=True)
class BoxesRow:
    """The cost of a scene.

    Attributes:
        boxes: How many.
        where: Where they are.
        scene: Seconds to add them one by one.
        checker: Seconds to build the checker, the robot being known.
        first_motion: Milliseconds of its first motion; None if no drawn state is free.
        scene_mb: Megabytes that the process had grown by at most with the scene.
        checker_mb: The same with the checker.
        motion_mb: The same after the motion.
    """

    boxes: int
    where: str
    scene: float
    checker: float
    first_motion: float | None
    scene_mb: float
    checker_mb: float
    motion_mb: float


def measure(robot_name: str, count: int, are_near: bool, seed: int) -> BoxesRow:
    """Measures a scene of `count` boxes, all within the robot's reach or not, in a process of its own."""
    done = run_isolated_lines(_RUN, json.dumps([robot_name, count, are_near, seed]), time_limit=_PATIENCE)
    if done.returncode:
        raise PlannercheckError(f"a process with {count} boxes failed: {done.stderr.strip().splitlines()[-1:]}")
    where = "all within reach" if are_near else "in a slab around the robot"
    return BoxesRow(count, where, *json.loads(done.stdout.splitlines()[-1]))


def costs(robot_name: str, count: int, are_near: bool, seed: int) -> tuple[float | None, ...]:
    """The figures of a row, measured in this process."""
    warnings.simplefilter("ignore", RuntimeWarning)
    robot = Robot.load(robot_name)
    Checker(robot, Scene.load("bookshelf")).check_motion(robot.reference, robot.reference)  # all of the robot is known
    sizes, poses = _boxes(count, are_near, seed)
    scene, began, clock = Scene(f"{count} boxes"), _most_megabytes(), [time.process_time()]
    for k, size in enumerate(sizes.tolist()):
        scene.add_box(f"box {k}", size, poses[k])
    clock.append(time.process_time())
    memory = [_most_megabytes() - began]
    checker = Checker(robot, scene)
    clock.append(time.process_time())
    memory.append(_most_megabytes() - began)
    motion = _first_motion(checker, robot.random_configurations(1000, seed))
    memory.append(_most_megabytes() - began)
    return (*np.diff(clock).tolist(), motion, *memory)


def _first_motion(checker: Checker, q: Floats) -> float | None:
    """Milliseconds of the first motion from a free state."""
    free = np.flatnonzero(checker.check_states(q))
    if not len(free):
        return None
    start = q[free[0]]
    began = time.process_time()
    checker.check_motion(start, start + 1e-3)
    return 1e3 * (time.process_time() - began)


def _boxes(count: int, are_near: bool, seed: int) -> tuple[Floats, Floats]:
    """Edges (n, 3) and poses (n, 4, 4), m."""
    rng = np.random.default_rng(seed)
    side = _SIDE * (count / 1000) ** 0.5
    low = [-_REACH] * 3 if are_near else [-side, -side, _HEIGHTS[0]]
    high = [_REACH] * 3 if are_near else [side, side, _HEIGHTS[1]]
    poses = at_places(rng.uniform(low, high, (count, 3)))
    return rng.uniform(*_EDGES, (count, 3)) * (0.1 if are_near else 1.0), poses


def _most_megabytes() -> float:
    """The most that this process has had; 0 where the system does not tell."""
    try:
        import resource
    except ImportError:
        return 0.0
    unit = 2**20 if sys.platform == "darwin" else 2**10
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit
