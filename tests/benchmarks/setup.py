"""The wait before verdicts: loading, building checkers, changing scenes, up to a whole plan from two files.

Run: python tests/benchmarks/setup.py [--problems bookshelf_small_panda.tar.bz2 …] [--only robots scenes …]

Medians of process times in ms (CPU time of all threads), the disk cache warm unless said otherwise. Lines:

- loads: `import plannercheck` and `Robot.load` in fresh processes, with the cache warm, and with an empty one up to the
  first verdict of a checker;
- checkers: `Checker(robot, scene)` of a robot that was used before; the first motion of such a checker; and
  `with_scene` with one obstacle more, moved or gone, then the first verdict and the first proved motion;
- scenes: `Scene.load` of a shipped scene in YAML;
- plans: for every problem, from the planning scene's and the request's bytes to a proved path (RRTConnect, seed 1, not
  shortened): reading both, holding the other joints, the checker, and `pc.ompl.plan`;
- boxes: a checker among many boxes in a process of its own, seconds and the memory that it adds at most.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

CASES = (("panda", "bookshelf"), ("ur5", "kitchen"), ("baxter", "kitchen"), ("talos", "kitchen"))
PARTS = ("loads", "checkers", "scenes", "plans", "boxes")
_LOAD = "import plannercheck as pc; pc.Robot.load({name!r})"
_FIRST = (
    "import warnings, plannercheck as pc; warnings.simplefilter('ignore'); r = pc.Robot.load({name!r}); "
    "pc.Checker(r, pc.Scene.load({scene!r})).check_states(r.reference)"
)


def main() -> None:
    """Prints a line for each figure."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=PARTS, default=PARTS)
    parser.add_argument("--problems", nargs="*", default=[], help="MotionBenchMaker archives, for the plans")
    parser.add_argument("--every", type=int, default=1, help="take every so-many-th problem of a set")
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--boxes", type=int, default=100_000)
    parser.add_argument("--output", type=Path, metavar="FILE", help="write the rows as JSON")
    parser.add_argument("--one-scene", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one_scene is not None:
        _build_boxes(options.one_scene)
        return
    warnings.simplefilter("ignore", RuntimeWarning)
    rows: dict[str, float] = {}
    for name, value in _rows(options):
        rows[name] = value
        print(f"{name:64s} {value:10.3f}", flush=True)
    if options.output:
        options.output.write_text(json.dumps(rows, indent=1), encoding="utf-8")


def _rows(options: argparse.Namespace) -> Iterator[tuple[str, float]]:
    """Names and figures, ms unless the name says otherwise."""
    if "loads" in options.only:
        yield from _loads(options.rounds)
    if "checkers" in options.only:
        for robot, scene in CASES:
            yield from _checkers(robot, scene, options.rounds)
    if "scenes" in options.only:
        yield from _scenes(options.rounds)
    if "plans" in options.only and options.problems:
        yield from _plans(options.problems, options.every)
    if "boxes" in options.only:
        for count in (1_000, options.boxes):
            yield from _boxes(count)


def _spent(work: Callable[[], object]) -> float:
    """Process time of a call, ms."""
    began = time.process_time()
    work()
    return 1e3 * (time.process_time() - began)


def _of_process(code: str, **changes: str) -> float:
    """CPU time of a fresh Python process, ms."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-c", code], check=True, env=os.environ | changes, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return 1e3 * (after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime)


def _loads(rounds: int) -> Iterator[tuple[str, float]]:
    for name, scene in CASES:
        _of_process(_FIRST.format(name=name, scene=scene))
        runs = [_of_process(_LOAD.format(name=name)) for _ in range(rounds)]
        yield f"{name}: fresh process, imports and Robot.load", statistics.median(runs)
        runs = [_of_process(_FIRST.format(name=name, scene=scene)) for _ in range(rounds)]
        yield f"{name}: fresh process, to the first verdict in {scene}", statistics.median(runs)
    for name, scene in CASES:
        with tempfile.TemporaryDirectory() as folder:
            spent = _of_process(_FIRST.format(name=name, scene=scene), PLANNERCHECK_CACHE=folder)
        yield f"{name}: the same, nothing cached", spent


def _checkers(robot_name: str, scene_name: str, rounds: int) -> Iterator[tuple[str, float]]:
    import plannercheck as pc

    robot, scene = pc.Robot.load(robot_name), pc.Scene.load(scene_name)
    what = f"{robot_name} in {scene_name}: "
    yield what + "first checker of a robot just loaded", _spent(lambda: pc.Checker(robot, scene))
    q = robot.random_configurations(2000, 0)
    valid = pc.Checker(robot, scene).check_states(q)
    start = q[valid.argmax()]  # the first that is free; Talos stands in the ground of a kitchen, so it has none
    end = start + 1e-3
    spent: dict[str, list[float]] = {}
    for turn in range(rounds):
        for name, time_of_step in _steps(pc.Checker, (robot, scene), (start, end), turn).items():
            spent.setdefault(name, []).append(time_of_step)
    for name, times in spent.items():
        yield what + name, statistics.median(times)


def _steps(
    make: Callable[..., Any], arguments: tuple[Any, ...], motion: tuple[Any, Any], turn: int
) -> dict[str, float]:
    """A checker and its first answers, then checkers for changed scenes, ms."""
    found: list[Any] = []
    out = {"Checker(robot, scene)": _spent(lambda: found.append(make(*arguments)))}
    checker = found[0]
    out["its first verdict"] = _spent(lambda: checker.is_valid(motion[0]))
    out["its first motion"] = _spent(lambda: checker.check_motion(*motion))
    for name, scene in _edits(arguments[1], turn % 5):

        def change(scene: object = scene) -> None:
            changed = checker.with_scene(scene)
            changed.is_valid(motion[0])
            changed.check_motion(*motion)
            found.append(changed)  # what frees it is not measured

        out[f"with_scene, one {name}, verdict and motion"] = _spent(change)
    return out


def _edits(scene: object, turn: int) -> Iterator[tuple[str, object]]:
    """Scenes that differ from one by an obstacle."""
    pose = np.eye(4)
    pose[:3, 3] = 0.6, 0.1 * turn - 0.2, 0.55
    more = scene.copy()
    more.add_box("one more", [0.05, 0.05, 0.1], pose)
    yield "more", more
    moved, name = scene.copy(), scene.object_names[-1]
    shifted = np.array(scene.object(name).pose)
    shifted[2, 3] += 0.01 * (turn + 1)
    moved.move(name, shifted)
    yield "moved", moved
    gone = scene.copy()
    gone.remove(name)
    yield "gone", gone


def _scenes(rounds: int) -> Iterator[tuple[str, float]]:
    import plannercheck as pc

    for name in ("bookshelf", "kitchen"):
        yield f"Scene.load {name}", statistics.median(_spent(partial(pc.Scene.load, name)) for _ in range(rounds))


def _plans(archives: list[str], every: int) -> Iterator[tuple[str, float]]:
    import plannercheck as pc
    from plannercheck.scenes.motion_bench_maker import load_problems
    from plannercheck.validation.problem_sets import robot_of

    robot, totals = pc.Robot.load("panda"), list[float]()
    for archive in archives:
        problems = load_problems(archive)
        steps: dict[str, list[float]] = {}
        for number in list(problems.members)[::every]:
            times = _one_plan(pc, problems, number, lambda problem: robot_of(problem, robot))
            for name, spent in times.items():
                steps.setdefault(name, []).append(spent)
        name_of_set = Path(archive).name.split(".")[0]
        for name, spent in steps.items():
            yield f"{name_of_set}: {name}, median", statistics.median(spent)
        totals += steps["whole"]
    yield "all sets: whole, median", statistics.median(totals)


def _one_plan(pc, problems, number, robot_of) -> dict[str, float]:
    """Process times of the steps from two files to a path, ms."""
    state: dict[str, object] = {}

    def read() -> None:
        state["problem"] = problems.problem(number)

    def hold() -> None:
        state["robot"] = robot_of(state["problem"])

    def build() -> None:
        state["checker"] = pc.Checker(state["robot"], state["problem"].scene)

    def plan() -> None:
        problem = state["problem"]
        pc.ompl.plan(state["checker"], problem.start, problem.goal, seed=1, simplify=False)

    times = {step.__name__: _spent(step) for step in (read, hold, build, plan)}
    return times | {"whole": sum(times.values())}


def _boxes(count: int) -> Iterator[tuple[str, float]]:
    command = [sys.executable, __file__, "--one-scene", str(count)]
    run = subprocess.run(command, check=True, capture_output=True, text=True, env=os.environ)
    for name, value in json.loads(run.stdout).items():
        yield f"{count} boxes: {name}", value


def _build_boxes(count: int) -> None:
    """Prints the cost of a checker among so many boxes, and of motions there."""
    import plannercheck as pc

    warnings.simplefilter("ignore", RuntimeWarning)
    robot = pc.Robot.load("panda")
    pc.Checker(robot, pc.Scene.load("bookshelf")).check_motion(robot.reference, robot.reference)
    rng = np.random.default_rng(0)
    scene = pc.Scene("boxes")
    # All of them about the same density around the robot, in a slab that grows with their number.
    side = 1.2 * (count / 1000) ** 0.5
    poses = np.tile(np.eye(4), (count, 1, 1))
    poses[:, :3, 3] = rng.uniform([-side, -side, 0.8], [side, side, 1.6], (count, 3))
    sizes = rng.uniform(0.01, 0.03, (count, 3)).tolist()
    began_memory = _memory()

    def fill() -> None:
        for k, size in enumerate(sizes):
            scene.add_box(f"box {k}", size, poses[k])

    checkers: list[pc.Checker] = []
    out = {"scene s": _spent(fill) / 1e3}
    out["scene MB"] = _memory() - began_memory
    out["checker s"] = _spent(lambda: checkers.append(pc.Checker(robot, scene))) / 1e3
    out["scene and checker MB"] = _memory() - began_memory
    checker = checkers[0]
    q = robot.random_configurations(3000, 1)
    out["3,000 states ms"] = _spent(lambda: checker.check_states(q))
    free = q[checker.check_states(q)][:1]
    out["first motion ms"] = _spent(lambda: checker.check_motion(free[0], free[0] + 1e-3))
    out["scene, checker and motion MB"] = _memory() - began_memory
    ends = free[0] + rng.normal(size=(300, robot.nq)) * 0.2
    starts = np.repeat(free, 300, axis=0)
    checker.check_motions(starts, ends)
    out["a motion us"] = statistics.median(_spent(lambda: checker.check_motions(starts, ends)) for _ in range(5)) / 0.3
    print(json.dumps(out))


def _memory() -> float:
    """The most that this process has had, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


if __name__ == "__main__":
    main()
