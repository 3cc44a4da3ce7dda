"""From a planning-scene file and a motion request to a proved path: what a user waits for in all.

In: a problem set, a robot that is loaded. Out: medians over the problems, step by step, of processor time. Each problem
is done once: a scene that was seen before would be faster. The disk cache of prepared bodies is used.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.bench.problems import checker_of, name_of_set
from plannercheck.ompl import plan
from plannercheck.robots.robot import Robot
from plannercheck.scenes.motion_bench_maker import load_problems


@dataclass(frozen=True)
class FromFilesRow:
    """Medians over the problems of a set that were solved.

    Attributes:
        set: Its name.
        problems: Number of problems that were tried.
        solved: Number of problems that were solved.
        read: Time to read scene and request, ms.
        checker: Time to give the robot the request's group and build the checker, ms.
        plan: Time from start and goal to the path, without shortening, ms.
        total: Time of all three, ms.
        total_mean: Mean time of all three, ms.
    """

    set: str
    problems: int
    solved: int
    read: float
    checker: float
    plan: float
    total: float
    total_mean: float


@dataclass(frozen=True)
class Timed:
    """The solved problems of a set, of so many tried: (solved, 3) ms of reading, checker and plan."""

    set: str
    tried: int
    steps: Floats

    def row(self) -> FromFilesRow:
        """Their medians."""
        total = self.steps.sum(axis=1)
        read, built, planned = np.median(self.steps, axis=0).tolist()
        return FromFilesRow(
            self.set, self.tried, len(total), read, built, planned, float(np.median(total)), float(total.mean())
        )


def together(sets: Sequence[Timed]) -> Timed:
    """All problems of some sets."""
    return Timed("all", sum(each.tried for each in sets), np.concatenate([each.steps for each in sets]))


def measure(path: Path, robot: Robot, every: int, first: int | None, limit: float) -> Timed:
    """Plans every so-many-th problem of a set, at most the first ones, each within a time limit, s.

    Raises:
        PlannercheckError: If no problem is solved.
    """
    problems = load_problems(path)
    numbers = list(islice(islice(problems.members, 0, None, every), first))
    spent = []
    for number in numbers:
        clock = [time.thread_time()]
        problem = problems.problem(number)
        clock.append(time.thread_time())
        checker = checker_of(problem, robot)
        clock.append(time.thread_time())
        found = plan(checker, problem.start, problem.goal, time_limit=limit, simplify=False, seed=1)
        clock.append(time.thread_time())
        if found.solved:
            spent.append(1e3 * np.diff(clock))
    if not spent:
        raise PlannercheckError(f"no problem of {name_of_set(path)} was solved: nothing can be timed")
    return Timed(name_of_set(path), len(numbers), np.array(spent))
