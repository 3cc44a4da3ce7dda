"""Many changed scenes, and many plans, at constant memory.

In: how many. Out: counts, and by how much memory grew. The first tenth may fill caches; from there to the end, and
from the middle to the end, the process may grow by no more than `ROOM`.
"""

import itertools
import resource
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from poses import at

import plannercheck as pc
from long_runs.counts import BrokenPromiseError, Counts

ROOM = 8 << 20  # bytes
_SAMPLES = 10  # how often memory is looked at
_LARGE = 50
_URDF = """<robot name="r"><link name="a"><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
<link name="b"><collision><origin xyz="0 0 0.3"/><geometry><box size="0.1 0.1 0.4"/></geometry></collision></link>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/><origin xyz="0 0 0.2"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>
"""


def scenes(folder: Path, calls: int, rng: np.random.Generator) -> Counts:
    """Calls of `with_scene`, `attach` and `detach`: of ten eight, one and one; a state is judged after each.

    A robot of two links makes a million of them possible; each `_LARGE`th round is of a Panda before its bookshelf.
    """
    urdf = folder / "r.urdf"
    urdf.write_text(_URDF, encoding="utf-8")
    count = {"with_scene": 0, "attach": 0, "detach": 0}
    small = pc.Checker(pc.Robot.from_urdf(urdf), pc.Scene())
    large = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"))

    def one(number: int) -> None:
        if number % _LARGE == _LARGE - 1:
            _round(large, "panda_hand", ["panda_leftfinger", "panda_rightfinger"], rng, count)
        else:
            _round(small, "b", [], rng, count)

    return {**_constant(one, -(-calls // 10), count), "calls": sum(count.values()), **count}


def _round(checker: pc.Checker, link: str, touched: list[str], rng: np.random.Generator, count: dict[str, int]) -> None:
    """Ten calls, each of the checker that the last one gave."""
    q, free = checker.robot.reference, checker.is_valid(checker.robot.reference)
    for number in range(8):
        scene = checker.scene.copy()
        if "moving" in scene.object_names:
            scene.remove("moving")
        scene.add_box("moving", [0.1, 0.1, 0.1], at(*rng.uniform(1, 2, 3)))
        checker = checker.with_scene(scene)
        count["with_scene"] += 1
        _require(checker.is_valid(q) == free, "a far obstacle changes a verdict")
        if number == 2:
            checker = checker.attach("can", pc.Sphere(0.03), link, at(0, 0, 0.5), [link, *touched])
            count["attach"] += 1
            checker.is_valid(q)
        if number == 5:
            checker = checker.detach("can")
            count["detach"] += 1
            _require(checker.is_valid(q) == free, "what was let go of changes a verdict")


def plans(folder: Path, count: int, rng: np.random.Generator) -> Counts:
    """Plans with OMPL: short ones of an arm and, one of four, of a car with Reeds and Shepp's curves."""
    arm = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"))
    home = _valid(arm, rng)
    box = [[-0.5, -0.3], [0.5, -0.3], [0.5, 0.3], [-0.5, 0.3]]
    yard = pc.planar.Scene("yard", [[-5, -5], [5, 5]])
    yard.add_box("post", [0.2, 0.2], np.array([[1.0, 0, 3], [0, 1, 3], [0, 0, 1]]))
    car = pc.planar.Checker(pc.planar.Robot(box), yard)
    told = {"plans": 0, "solved": 0}

    def one(number: int) -> None:
        if number % 4 == 3:
            goal = rng.uniform([-1, -1, -3], [1, 1, 3])
            plan = pc.ompl.plan(
                car, np.zeros(3), goal, time_limit=5.0, simplify=False, curve="reeds_shepp", turning_radius=0.5
            )
        else:
            plan = pc.ompl.plan(arm, home, home + rng.uniform(-0.02, 0.02, len(home)), time_limit=5.0, simplify=False)
        told["plans"] += 1
        told["solved"] += plan.solved

    return {**_constant(one, count, told), **told}


def _valid(checker: pc.Checker, rng: np.random.Generator) -> np.ndarray:
    """A configuration around which all are free."""
    for seed in itertools.count():
        q = checker.robot.random_configurations(1, seed)[0]
        inside = (q > checker.robot.lower + 0.1).all() and (q < checker.robot.upper - 0.1).all()
        if inside and checker.is_valid(q) and checker.clearance(q) > 0.1:
            return np.asarray(q)
    raise AssertionError


def _constant(one: Callable[[int], object], trials: int, told: dict[str, int]) -> Counts:
    """Makes trials and compares the memory of the process along the way."""
    marks = [round(trials * k / _SAMPLES) for k in range(1, _SAMPLES + 1)]
    held, began = [], time.perf_counter()
    for number in range(trials):
        one(number)
        while len(held) < _SAMPLES and number + 1 >= marks[len(held)]:
            held.append(resident())
    for since, words in ((0, "the first tenth"), (_SAMPLES // 2 - 1, "the middle")):
        if held[-1] - held[since] > ROOM:
            grown = (held[-1] - held[since]) / 1e6
            raise BrokenPromiseError(f"memory grew by {grown:.1f} MB after {words} of {trials} trials: {told}")
    return {
        "MB": round(held[-1] / 1e6, 1),
        "MB more than after a tenth": round((held[-1] - held[0]) / 1e6, 2),
        "MB more than in the middle": round((held[-1] - held[_SAMPLES // 2 - 1]) / 1e6, 2),
        "µs a trial": round(1e6 * (time.perf_counter() - began) / trials),
    }


def resident() -> int:
    """Bytes of memory that this process has now."""
    return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * resource.getpagesize()


def _require(holds: bool, otherwise: str) -> None:
    if not holds:
        raise BrokenPromiseError(otherwise)
