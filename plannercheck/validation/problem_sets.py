"""Plans for the problems of a MotionBenchMaker set.

In: a robot and problems. Out: a `ProblemResult` for each, and a `SetSummary` for a whole set.

The robot's joints outside the group are held at the values of each request's start state.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import mean, median

from plannercheck.common.checked_yaml import error_context
from plannercheck.motions.checker import Checker
from plannercheck.ompl import plan
from plannercheck.ompl.near_first import Sampling
from plannercheck.ompl.plans import Plan
from plannercheck.ompl.start_and_goal import EndState, check_end_state, checked_end
from plannercheck.robots.robot import Robot
from plannercheck.scenes.motion_bench_maker import Problem
from plannercheck.validation.path_recheck import PathCheck, check_path


@dataclass(frozen=True, eq=False)
class ProblemResult:
    """A problem and its result.

    Attributes:
        name: Name of the problem.
        start: The verdict on its start.
        goal: The goal that was planned to, judged.
        plan: The plan.
        check: The path checked again, if asked for and if there is one.
    """

    name: str
    start: EndState
    goal: EndState
    plan: Plan
    check: PathCheck | None = None


@dataclass(frozen=True)
class SetSummary:
    """The results of a set, counted.

    Attributes:
        problems: All of them.
        free: Number of problems whose start and goal collide with nothing.
        within: Number of problems whose start and goal are within the limits.
        accepted: Both, so that planning was tried.
        solved: Number of problems with a plan.
        times: Median and mean of the search, s; of the solved ones.
        totals: Median and mean of search and shortening, s.
        length: Mean length of the plans, rad.
        rejections: How many starts or goals are rejected by each pair; ("start", first, second).
    """

    problems: int
    free: int
    within: int
    accepted: int
    solved: int
    times: tuple[float, float]
    totals: tuple[float, float]
    length: float
    rejections: Counter[tuple[str, str, str]]


def robot_of(problem: Problem, robot: Robot) -> Robot:
    """The robot with a problem's group and held joints."""
    with error_context(f"problem {problem.name}"):
        return robot.with_group(problem.joint_names, problem.group).holding(problem.held)


def solve(
    problem: Problem, robot: Robot, planner: Callable[[Checker, Problem, int], Plan], verify: bool = False
) -> ProblemResult:
    """Plans one problem.

    Args:
        problem: The problem.
        robot: Any robot with the problem's joints.
        planner: A function of the checker, the problem and the index of a goal, which returns the plan.
        verify: Whether to check the path again, see `check_path`.

    Returns:
        The result. Of several goals, the first accepted one is used.
    """
    checker = Checker(robot_of(problem, robot), problem.scene)
    with error_context(f"problem {problem.name}"):
        start = check_end_state(checker, checked_end(checker, problem.start, "start"))
        goals = [check_end_state(checker, checked_end(checker, goal, "goal")) for goal in problem.goals]
    chosen = next((k for k, goal in enumerate(goals) if goal.accepted), 0)
    found = planner(checker, problem, chosen)
    check = check_path(checker, found.path) if verify and found.solved else None
    return ProblemResult(problem.name, start, goals[chosen], found, check)


def with_ompl(
    planner: str, time_limit: float, simplify: bool, seed: int | None, longest_motion: float, sampling: Sampling
) -> Callable[[Checker, Problem, int], Plan]:
    """A planner for `solve`; arguments as of `ompl.plan`."""

    def run(checker: Checker, problem: Problem, goal: int) -> Plan:
        return plan(
            checker,
            problem.start,
            problem.goals[goal],
            planner,
            time_limit,
            simplify,
            seed,
            longest_motion=longest_motion,
            sampling=sampling,
        )

    return run


def summary(results: Sequence[ProblemResult]) -> SetSummary:
    """Counts the results of a set."""
    solved = [result.plan for result in results if result.plan.solved]
    rejections: Counter[tuple[str, str, str]] = Counter()
    for result in results:
        for name, end in (("start", result.start), ("goal", result.goal)):
            rejections.update((name, *pair) for pair in end.pairs)
    return SetSummary(
        problems=len(results),
        free=sum(not result.start.pairs and not result.goal.pairs for result in results),
        within=sum(not result.start.beyond and not result.goal.beyond for result in results),
        accepted=sum(result.start.accepted and result.goal.accepted for result in results),
        solved=len(solved),
        times=_median_and_mean([plan.time for plan in solved]),
        totals=_median_and_mean([plan.time + plan.simplification_time for plan in solved]),
        length=_median_and_mean([plan.length for plan in solved])[1],
        rejections=rejections,
    )


def _median_and_mean(values: Sequence[float]) -> tuple[float, float]:
    return (median(values), mean(values)) if values else (float("nan"), float("nan"))
