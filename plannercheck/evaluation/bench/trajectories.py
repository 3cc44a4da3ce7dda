"""Proved trajectories beside their chords, and beside samples at 1 kHz: ours, and other libraries'.

In: a checker, how many. Out: a row for each method. Each trajectory is smooth, a sum of three sines a joint, and given
by 31 points with velocities and accelerations, so it is 30 quintic pieces. All are free, so that no method ends early.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from plannercheck.bodies.tuning import Tuning
from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.bench import other_libraries
from plannercheck.evaluation.bench.drake_checker import drake
from plannercheck.evaluation.bench.timing import Contender, TimedRow, available, measured
from plannercheck.motions.checker import Checker
from plannercheck.trajectories.trajectory import Trajectory

DURATION, POINTS, RATE = 3.0, 31, 1000  # s, Hz
# Trajectories that slow libraries judge in a round, and draws of each that is wanted until that is given up.
_FEW, _MOST_DRAWS = 2, 200
_SWING = 0.25  # of each sine, rad


@dataclass(frozen=True)
class TrajectoryRow(TimedRow):
    """What one method took for trajectories.

    Attributes:
        robot: Its name.
        scene: Its name.
        trajectories: Judged in a round.
        refused: How many it calls colliding; all are proved free.
    """

    robot: str
    scene: str
    trajectories: int
    refused: int


def free_trajectories(checker: Checker, n: int, seed: int) -> list[Trajectory]:
    """Smooth trajectories that are proved free, and whose chords are."""
    robot, rng, found = checker.robot, np.random.default_rng(seed), list[Trajectory]()
    times, waves = np.linspace(0, DURATION, POINTS), np.arange(1, 4) * np.pi / 4
    for _ in range(_MOST_DRAWS * n):
        sines = rng.uniform(-_SWING, _SWING, (3, robot.nq))
        middle = robot.random_configurations(1, rng)[0]
        phases = np.outer(times, waves)
        q, v, a = np.sin(phases), np.cos(phases) * waves, -np.sin(phases) * waves**2
        v[-1] = 0.0  # a controller demands rest
        made = Trajectory(times, middle + q @ sines, v @ sines, a @ sines)
        points = _points(made)
        if made.limits(robot) or not checker.check_motions(points[:-1], points[1:]).all():
            continue
        if checker.check_trajectory(made):
            found.append(made)
        if len(found) == n:
            return found
    raise PlannercheckError(f"only {len(found)} of {n} trajectories that are free were found in {checker.scene.name!r}")


def measure(
    checker: Checker, n: int, rounds: int, seed: int, skipped: Callable[[str], None] = lambda reason: None
) -> list[TrajectoryRow]:
    """Times all methods by turns on n trajectories; the robot's joints take one number each."""
    drawn = free_trajectories(checker, n, seed)
    chords = [(points[:-1].copy(), points[1:].copy()) for points in map(_points, drawn)]
    starts, ends = (np.concatenate(parts) for parts in zip(*chords, strict=True))
    plain = Checker(checker.robot, checker.scene, tuning=Tuning(covers=False))
    samples = [t.position(np.linspace(0, DURATION, round(DURATION * RATE) + 1)) for t in drawn]

    def by_samples(judge: Callable[[Floats], Bools], some: list[Floats]) -> list[bool]:
        return [bool(judge(q).all()) for q in some]

    works: dict[str, list[Callable[[], Sequence[bool] | Bools]]] = {
        "its 30 chords, check_motions": [lambda: [bool(checker.check_motions(*each).all()) for each in chords]],
        "all chords at once": [lambda: np.asarray(checker.check_motions(starts, ends).reshape(n, -1).all(axis=1))],
        "check_trajectory": [lambda: [checker.check_trajectory(each) for each in drawn]],
        "check_trajectories": [partial(checker.check_trajectories, drawn)],
        "check_trajectories, tube of 0.01": [partial(checker.check_trajectories, drawn, 0.01)],
        "check_trajectories, no covers": [partial(plain.check_trajectories, drawn)],
        "3,001 samples, check_states": [partial(by_samples, checker.check_states, samples)],
    }
    counts = dict.fromkeys(works, n)
    for name, make in (("coal", other_libraries.coal), ("drake", drake)):
        if (judge := available(name, partial(make, checker), skipped)) is not None:
            works[f"3,001 samples, {name}"] = [partial(by_samples, judge, samples[:_FEW])]
            counts[f"3,001 samples, {name}"] = min(_FEW, n)
    times = measured({name: Contender(work, counts[name]) for name, work in works.items()}, rounds)
    return [
        TrajectoryRow(
            *times.row(name),
            checker.robot.name,
            checker.scene.name,
            counts[name],
            counts[name] - sum(map(bool, work[0]())),
        )
        for name, work in works.items()
    ]


def _points(trajectory: Trajectory) -> Floats:
    assert trajectory.points is not None
    return trajectory.points.positions
