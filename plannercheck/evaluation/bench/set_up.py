"""The user's waiting time before the first verdict: loading, building a checker, changing its scene.

In: a robot's and a scene's name. Out: a row for each step, with the first verdict and the first proved motion after it,
which include postponed work. The disk cache is warm, unless a row says otherwise. Steps take turns in one process;
steps of a fresh process begin a new one each. Times are processor times, and the least of the rounds counts.
"""

from __future__ import annotations

import json
import os
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plannercheck.bodies.shapes import Cylinder
from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.isolated_process import run_isolated_lines
from plannercheck.common.transforms import pose_of
from plannercheck.evaluation.bench.motion_sets import MotionCase, random_sets
from plannercheck.evaluation.bench.other_libraries import coal
from plannercheck.evaluation.bench.timing import in_turns
from plannercheck.evaluation.bench.vamp_model import VampModel
from plannercheck.motions.checker import Checker
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene

# The motion that is proved first after each step, rad.
_LENGTH = 0.4
# Motions that are drawn at once in search of a free one.
_DRAWS = 200
# A first process fills the disk cache, and as many more are timed as there are rounds, but not more than these.
_MOST_PROCESSES = 5
# Seconds until a fresh process is given up.
_PATIENCE = 600

_FROM_SCRATCH = "Checker(...)"
# Begins the names of our own objects, which no scene has.
_OWN = "plannercheck bench:"

# Prints milliseconds of each step as JSON; given the robot, the scene, a state and a motion from it.
_FRESH = """
import json, sys, time, warnings
warnings.simplefilter("ignore")
robot_name, scene_name, start, end = json.loads(sys.argv[1])
clock = [time.process_time()]
import pinocchio
clock.append(time.process_time())
import plannercheck as pc
robot = pc.Robot.load(robot_name)
clock.append(time.process_time())
scene = None if scene_name is None else pc.Scene.load(scene_name)
clock.append(time.process_time())
checker = pc.Checker(robot, scene)
clock.append(time.process_time())
checker.is_valid(start)
clock.append(time.process_time())
checker.check_motion(start, end)
clock.append(time.process_time())
print(json.dumps([1e3 * (b - a) for a, b in zip(clock, clock[1:])]))
"""


@dataclass(frozen=True)
class SetUpRow:
    """One step.

    Attributes:
        robot: Its name.
        scene: Its name.
        pairs: Number of pairs of bodies in the scene as it is loaded.
        what: The step.
        milliseconds: Time of the step itself.
        first_verdict: Milliseconds of the first `is_valid` after it; None where there is none.
        first_motion: Milliseconds of the first `check_motion` after that.
        prepared: Bodies that were there before the step and that it prepared again; None where there were none.
    """

    robot: str
    scene: str
    pairs: int
    what: str
    milliseconds: float
    first_verdict: float | None = None
    first_motion: float | None = None
    prepared: int | None = None


Report = Callable[[str], None]
# Makes a checker, or another judge of states and motions, inside the timing.
Step = Callable[[], Any]


def measure(
    robot_name: str, scene_name: str | None, rounds: int, seed: int, skipped: Report = lambda reason: None
) -> list[SetUpRow]:
    """Times all steps.

    Args:
        robot_name: A shipped robot, or the file of one.
        scene_name: A shipped scene or a file; None for no obstacles.
        rounds: Number of runs of each step.
        seed: Seed of the obstacles' places and of the first motion.
        skipped: Function that is told why a peer is left out.

    Returns:
        A row for each step.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of static pairs, which a moved obstacle may have
        robot, scene = Robot.load(robot_name), _scene(scene_name)
        checker = Checker(robot, scene)
        case = _first_motion(checker, seed)
        steps = {"Scene.load": lambda: _scene(scene_name)} if scene_name is not None else {}
        steps |= dict(_steps(checker, np.random.default_rng(seed)))
        best = _least(steps, case, checker, rounds)
        rows = [_row(checker, what, *found) for what, found in best.items()]
        fresh = _fresh_rows(checker, (robot_name, scene_name), case, rounds)
        return [*fresh, *rows, *_peer_rows(checker, case, rounds, skipped)]


def _scene(name: str | None) -> Scene:
    return Scene("empty") if name is None else Scene.load(name)


def _first_motion(checker: Checker, seed: int) -> MotionCase:
    """A free motion, the first of some that are drawn."""
    sets = random_sets(checker, "", _LENGTH, _DRAWS, seed)
    found = next((motions for motions in sets if motions.kind.endswith("free")), None)
    if found is None:
        raise PlannercheckError(f"{checker.robot.name} has no free motion in scene {checker.scene.name!r}")
    return found.cases[0]


def _steps(checker: Checker, rng: np.random.Generator) -> Iterator[tuple[str, Step]]:
    """The steps that make a checker, each with an obstacle somewhere else every time."""
    robot, link = checker.robot, checker.robot.bodies[-1].link or ""
    yield _FROM_SCRATCH, lambda: Checker(robot, checker.scene)
    yield "with_scene, one box more", _changed(checker, lambda scene: _add(scene, rng))
    if checker.scene.object_names:
        last = checker.scene.object_names[-1]
        carrying = checker.attach(f"{_OWN} can", Cylinder(0.03, 0.1), link, pose_of((0, 0, 0.2)))
        yield "with_scene, one object moved", _changed(checker, lambda scene: scene.move(last, _anywhere(rng)))
        yield "with_scene, one object gone", _changed(checker, lambda scene: scene.remove(last))
        yield (
            "with_scene while another is attached, one moved",
            _changed(carrying, lambda scene: scene.move(last, _anywhere(rng))),
        )
    yield "attach", lambda: checker.attach(f"{_OWN} tin", Cylinder(0.03, 0.1), link, pose_of((0, 0, 0.2)))


def _changed(checker: Checker, change: Callable[[Scene], object]) -> Step:
    def step() -> Checker:
        scene = checker.scene.copy()
        change(scene)
        return checker.with_scene(scene)

    return step


def _add(scene: Scene, rng: np.random.Generator) -> None:
    scene.add_box(f"{_OWN} box", rng.uniform(0.05, 0.2, 3).tolist(), _anywhere(rng))


def _anywhere(rng: np.random.Generator) -> Floats:
    return pose_of(rng.uniform(0.3, 0.8, 3))


def _least(
    steps: dict[str, Step], case: MotionCase, checker: Checker, rounds: int
) -> dict[str, tuple[list[float], int | None]]:
    """Of each step the milliseconds of its fastest round, and what it prepared again; rounds alternate in direction."""
    start, end = case.starts[0], case.ends[0]
    best: dict[str, tuple[list[float], int | None]] = {}
    for what in in_turns(steps, rounds):
        clock = [time.thread_time()]
        made = steps[what]()
        clock.append(time.thread_time())
        if isinstance(made, Checker):
            made.is_valid(start)
            clock.append(time.thread_time())
            made.check_motion(start, end)
            clock.append(time.thread_time())
        spent = _milliseconds(clock)
        if what not in best or sum(spent) < sum(best[what][0]):
            follows = isinstance(made, Checker) and what != _FROM_SCRATCH
            best[what] = spent, _prepared_again(checker, made) if follows else None
    return {what: best[what] for what in steps}


def _prepared_again(before: Checker, after: Checker) -> int:
    """Bodies that have another polytope than before."""
    earlier = {body.name: id(p) for body, p in zip(before.bodies, before.polytopes, strict=True) if p is not None}
    now = zip(after.bodies, after.polytopes, strict=True)
    return sum(p is not None and earlier.get(body.name, id(p)) != id(p) for body, p in now)


def _row(checker: Checker, what: str, spent: Sequence[float], prepared: int | None = None) -> SetUpRow:
    step, verdict, motion, *_ = (*spent, None, None)
    assert step is not None
    return SetUpRow(checker.robot.name, checker.scene.name, len(checker.pairs), what, step, verdict, motion, prepared)


def _fresh_rows(checker: Checker, names: tuple[str, str | None], case: MotionCase, rounds: int) -> list[SetUpRow]:
    """The same from a fresh process on, with a warm disk cache and with none."""
    given = json.dumps([*names, case.starts[0].tolist(), case.ends[0].tolist()])
    processes = min(rounds, _MOST_PROCESSES)
    rows = []
    for suffix, cached in (("", True), (", nothing cached", False)):
        spent = np.min([_fresh(given, cached) for _ in range(processes)], axis=0)
        pinocchio, load, scene, *built = map(float, spent)
        if cached:
            rows.append(_row(checker, "fresh process: import pinocchio", [pinocchio]))
        rows.append(_row(checker, f"fresh process: import, Robot.load{suffix}", [pinocchio + load]))
        if names[1] is not None:
            rows.append(_row(checker, f"fresh process: Scene.load{suffix}", [scene]))
        rows.append(_row(checker, f"fresh process: Checker(...){suffix}", built))
    return rows


def _fresh(given: str, cached: bool) -> list[float]:
    """Milliseconds of the steps of one process."""
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ if cached else {**os.environ, "PLANNERCHECK_CACHE": folder}
        done = run_isolated_lines(_FRESH, given, environment, _PATIENCE)
    if done.returncode:
        raise PlannercheckError(f"a fresh process failed: {done.stderr.strip().splitlines()[-1:]}")
    return [float(value) for value in json.loads(done.stdout.splitlines()[-1])]


def _peer_rows(checker: Checker, case: MotionCase, rounds: int, skipped: Report) -> list[SetUpRow]:
    """Other libraries, from our bodies to their first verdict."""
    rows = []
    peers: list[tuple[str, Callable[[Checker], Any], Callable[[Any, Floats], object]]] = [
        ("Pinocchio + coal: geometry and AABB tree", coal, lambda built, q: built(q)),
        ("VAMP: its environment", VampModel, lambda built, q: built.states_free(built.rows(q))),
    ]
    for what, build, judge in peers:
        try:
            spent = [_peer_spent(build, judge, checker, case.starts[:1]) for _ in range(rounds)]
        except (PlannercheckError, ImportError) as error:
            skipped(f"{what} is left out: {error}")
        else:
            rows.append(_row(checker, what, min(spent, key=sum)))
    return rows


def _peer_spent(
    build: Callable[[Checker], Any], judge: Callable[[Any, Floats], object], checker: Checker, q: Floats
) -> list[float]:
    clock = [time.thread_time()]
    built = build(checker)
    clock.append(time.thread_time())
    judge(built, q)
    clock.append(time.thread_time())
    return _milliseconds(clock)


def _milliseconds(clock: Sequence[float]) -> list[float]:
    return [1e3 * float(step) for step in np.diff(clock)]
