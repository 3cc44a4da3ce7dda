"""Eight threads that load, check, plan, validate and write at once: each result is that of one thread alone.

In: for how long. Out: counts. Results are computed once before, by one thread. In the end, the descriptors of the
console, OMPL's log level, the working folder and what is in the files are as they should be.
"""

import os
import subprocess
import threading
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np

import plannercheck as pc
from long_runs.counts import BrokenPromiseError, Counts
from long_runs.environment import ENVIRONMENT, PYTHON
from plannercheck.ompl.plans import Plan
from plannercheck.proofs import Proof

THREADS = 8
_ROWS = 400
_FORMATS = ("npz", "csv", "parquet")
_ROBOTS = (("panda", "bookshelf"), ("ur5", "table"))


def run(folder: Path, seconds: float, rng: np.random.Generator) -> Counts:
    """Lets threads do everything at once.

    Raises:
        BrokenPromiseError: At a result that is another one; at descriptors, log levels or files that are not intact.
    """
    from ompl import util

    work = _Work(folder)
    tasks: tuple[Callable[[int, np.random.Generator], None], ...] = (
        *(work.check, work.move, work.plan, work.validate, work.bodies, work.prove, work.scenes),
    )
    before = [os.fstat(number)[:3] for number in (0, 1, 2)], util.getLogLevel(), Path.cwd()
    end, counts, faults = time.monotonic() + seconds, Counter[str](), []
    lock = threading.Lock()

    def one(number: int) -> None:
        own = np.random.default_rng([number, int(rng.integers(2**31))])
        order = list(own.permutation(len(tasks)))
        try:
            while time.monotonic() < end and not faults:
                task = tasks[order[0]]
                order = [*order[1:], order[0]]
                task(number, own)
                with lock:
                    counts[task.__name__] += 1
        except BaseException as error:
            faults.append(f"thread {number}: {error!r}")

    pool = [threading.Thread(target=one, args=(number,)) for number in range(THREADS)]
    for thread in pool:
        thread.start()
    for thread in pool:
        thread.join()
    if faults:
        raise BrokenPromiseError(faults[0])
    after = [os.fstat(number)[:3] for number in (0, 1, 2)], util.getLogLevel(), Path.cwd()
    if after != before:
        raise BrokenPromiseError(f"descriptors, log level or folder were {before}, and are {after}")
    work.check_files()
    return {"threads": THREADS, "seconds": round(seconds), **dict(sorted(counts.items()))}


class _Work:
    """What threads do, and what must come out of it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.source = folder / "q.npy"
        self.checkers = {name: pc.Checker(pc.Robot.load(name), pc.Scene.load(scene)) for name, scene in _ROBOTS}
        self.rows = {name: each.robot.random_configurations(_ROWS, 0) for name, each in self.checkers.items()}
        self.states = {name: each.check_states(self.rows[name]) for name, each in self.checkers.items()}
        self.motions = {name: self._motions(each, name) for name, each in self.checkers.items()}
        free = {name: self.rows[name][self.states[name]] for name in self.checkers}
        self.ends = {name: (rows[0], rows[0] + 0.01) for name, rows in free.items()}
        np.save(self.source, self.rows["panda"])
        self.outputs = {suffix: self._validated(folder / f"whole.{suffix}") for suffix in _FORMATS}
        self.body = pc.Polytope(self.rows["panda"][:40, :3])
        self.box = [[-0.5, -0.3], [0.5, -0.3], [0.5, 0.3], [-0.5, 0.3]]

    def _motions(self, checker: pc.Checker, name: str) -> np.ndarray:
        rows = self.rows[name][:40]
        return np.asarray(checker.check_motions(rows, rows + 0.02))

    def _validated(self, output: Path) -> bytes:
        arguments = ["validate", "--robot", "panda", "--scene", "bookshelf", str(self.source), "--progress", "none"]
        ran = subprocess.run(
            [*PYTHON, "-m", "plannercheck", *arguments, "--output", str(output)],
            capture_output=True,
            text=True,
            check=False,
            env=ENVIRONMENT,
        )
        _require(ran.returncode == 1, f"validate ended with {ran.returncode}: {ran.stderr}")
        return output.read_bytes()

    def _loaded(self, name: str) -> pc.Checker:
        return pc.Checker(pc.Robot.load(name), pc.Scene.load(dict(_ROBOTS)[name]))

    def _name(self, rng: np.random.Generator) -> str:
        return _ROBOTS[int(rng.integers(len(_ROBOTS)))][0]

    def check(self, number: int, rng: np.random.Generator) -> None:
        """Loads a robot and checks states, with threads of its own; and a URDF that does not load."""
        name = self._name(rng)
        found = self._loaded(name).check_states(self.rows[name], threads=2)
        _require(np.array_equal(found, self.states[name]), f"other states of {name}")
        broken = self.folder / f"{number}.urdf"
        broken.write_text('<robot name="r"><link name="a"/><joint name="j" type="revolute"/></robot>')
        try:
            pc.Robot.from_urdf(broken)
        except pc.PlannercheckError:
            return
        raise AssertionError("a broken URDF loads")

    def move(self, number: int, rng: np.random.Generator) -> None:
        """Checks motions, by a checker that all threads share, and by an own one."""
        name = self._name(rng)
        for checker in (self.checkers[name], self._loaded(name)):
            _require(np.array_equal(self._motions(checker, name), self.motions[name]), f"other motions of {name}")

    def plan(self, number: int, rng: np.random.Generator) -> None:
        """Plans a short way with OMPL, writes and reads the plan; every motion of it is free."""
        name = self._name(rng)
        checker, (start, goal) = self.checkers[name], self.ends[name]
        plan = pc.ompl.plan(checker, start, goal, time_limit=20.0, simplify=bool(rng.integers(2)))
        _require(plan.solved, f"no plan: {plan.reason}")
        _require(bool(checker.check_motions(plan.path[:-1], plan.path[1:]).all()), "a plan that is not free")
        plan.save(self.folder / f"{number}.json")
        again = Plan.load(self.folder / f"{number}.json")
        _require(np.array_equal(again.path, plan.path), "another plan in its file")

    def validate(self, number: int, rng: np.random.Generator) -> None:
        """The command on a set, with an output in each format."""
        suffix = _FORMATS[int(rng.integers(len(_FORMATS)))]
        found = self._validated(self.folder / f"{number}.{suffix}")
        _require(found == self.outputs[suffix], f"other bytes in {suffix}")

    def bodies(self, number: int, rng: np.random.Generator) -> None:
        """Prepares a body, writes and reads it."""
        path = self.folder / f"{number}.body"
        pc.Polytope(self.rows["panda"][:40, :3]).save(path)
        _require(pc.Polytope.load(path).core.serialise() == self.body.core.serialise(), "another body")

    def prove(self, number: int, rng: np.random.Generator) -> None:
        """Explains a state and proves a motion in the plane; the proof is written, read and verified."""
        checker = pc.planar.Checker(pc.planar.Robot(self.box), pc.planar.Scene())
        (proof,) = checker.certify_motions(np.zeros((1, 3)), np.full((1, 3), 0.1))
        _require(proof is not None, "no proof")
        assert proof is not None
        path = self.folder / f"{number}.proof.json"
        proof.save(path)
        _require(bool(Proof.load(path).verify()), "a proof that does not verify")
        name = self._name(rng)
        k = int(rng.integers(_ROWS))
        explained = self.checkers[name].explain(self.rows[name][k])
        _require(explained.valid == bool(self.states[name][k]), "another verdict when explained")

    def scenes(self, number: int, rng: np.random.Generator) -> None:
        """Changes the scene of a checker that all share; writes and reads the scene."""
        checker = self.checkers["ur5"]
        scene = checker.scene.copy()
        scene.add_box("far", [0.1, 0.1, 0.1], np.block([[np.eye(3), np.full((3, 1), 9.0)], [np.zeros((1, 3)), 1.0]]))
        changed = checker.with_scene(scene)
        _require(np.array_equal(changed.check_states(self.rows["ur5"]), self.states["ur5"]), "a far box changes states")
        scene.save(self.folder / f"{number}.yaml")
        _require(pc.Scene.load(self.folder / f"{number}.yaml").object_names == scene.object_names, "another scene")

    def check_files(self) -> None:
        """Nothing unfinished or hidden is left."""
        left = [path.name for path in self.folder.iterdir() if path.name.startswith(".") or path.suffix == ".progress"]
        _require(not left, f"left behind: {left}")


def _require(holds: bool, otherwise: str) -> None:
    if not holds:
        raise AssertionError(otherwise)
