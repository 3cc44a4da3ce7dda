"""MotionBenchMaker problems for measurements: those with a valid start and goal.

In: problem sets, a robot. Out: a checker and two ends for each problem.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from plannercheck.common.array_types import Floats
from plannercheck.common.checked_yaml import error_context
from plannercheck.motions.checker import Checker
from plannercheck.ompl.start_and_goal import check_end_state
from plannercheck.robots.robot import Robot
from plannercheck.scenes.motion_bench_maker import Problem, load_problems


class Task(NamedTuple):
    """What is planned: from a start to a goal (nq,), rad, by the checker of the problem's robot in its scene."""

    checker: Checker
    start: Floats
    goal: Floats


def name_of_set(path: Path) -> str:
    """The name of a set's folder or archive."""
    return path.name.split(".")[0]


def checker_of(problem: Problem, robot: Robot) -> Checker:
    """The checker of a problem: its scene, its group, and its values of the joints that are held."""
    with error_context(f"problem {problem.name}"):
        return Checker(robot.with_group(problem.joint_names, problem.group).holding(problem.held), problem.scene)


def tasks(path: Path, robot: Robot, every: int = 1, first: int | None = None) -> Iterator[Task]:
    """The problems of a set that can be planned; starts or goals in collision or beyond the limits are left out.

    Every so-many-th problem is taken, at most the first ones. Any robot with the problems' joints does.
    """
    for problem in islice(islice(load_problems(path), 0, None, every), first):
        checker = checker_of(problem, robot)
        ends = problem.start, problem.goal
        if all(check_end_state(checker, q).accepted for q in ends):
            yield Task(checker, *ends)
