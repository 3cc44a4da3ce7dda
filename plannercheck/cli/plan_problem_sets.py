"""`plannercheck plan --problems`: whole problem sets.

In: a robot and problem sets. Out: a table of the sets, the pairs that reject starts and goals, and on request
every result as JSON.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

from plannercheck.cli import timed_plans
from plannercheck.cli.common import percentage, save_json, table
from plannercheck.cli.robot_options import robot_of
from plannercheck.cli.unused_options import check_used
from plannercheck.common.errors import PlannercheckError
from plannercheck.ompl import LONGEST_MOTION
from plannercheck.robots.robot import Robot
from plannercheck.scenes.motion_bench_maker import load_problems
from plannercheck.validation.fcl_agreement import merged
from plannercheck.validation.path_recheck import PathCheck
from plannercheck.validation.problem_sets import ProblemResult, SetSummary, solve, summary, with_ompl

# Options that say nothing of problem sets, whose problems are in space and are judged as they are.
_OF_ONE = (
    "--padding",
    "--no-self-collision",
    "--curve",
    "--turning-radius",
    "--bounds",
    "--timed",
    *timed_plans.OPTIONS,
)

_HEADER = (
    "set",
    "problems",
    "in limits",
    "free ends",
    "tried",
    "solved",
    "part",
    "median s",
    "mean s",
    "with shortening",
    "mean rad",
)


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    _check(options)
    robot = robot_of(options)
    results = {path: list(_results(path, robot, options)) for path in options.problems}
    summaries = {path: summary(found) for path, found in results.items()}
    everything = [result for found in results.values() for result in found]
    rows = [_row(path.name.split(".")[0], numbers) for path, numbers in summaries.items()]
    print(table(_HEADER, rows + ([_row("all", summary(everything))] if len(rows) > 1 else [])))
    _show_rejections(everything)
    _show_unsolved(everything)
    checks = [result.check for result in everything if result.check is not None]
    if checks:
        show_checks(checks)
    if options.output is not None:
        save_json(options.output, [_as_json(result) for result in everything])
        print(f"written to {options.output}")
    verified = all(result.check is None or result.check.passed for result in everything)
    return 0 if verified and all(result.plan.solved for result in everything) else 1


def _check(options: argparse.Namespace) -> None:
    for name in ("scene", "start", "goal"):
        if getattr(options, name) is not None:
            raise PlannercheckError(f"--{name} and --problems exclude each other: a problem has its own")
    check_used(options, _OF_ONE, "for one problem, not with --problems")
    if options.output is not None and options.output.suffix != ".json":
        raise PlannercheckError(f"the results of problem sets are written as .json, not {str(options.output)!r}")
    if options.first is not None and options.first < 1:
        raise PlannercheckError(f"--first must be at least 1, not {options.first}")


def _results(path: Path, robot: Robot, options: argparse.Namespace) -> Iterator[ProblemResult]:
    longest = LONGEST_MOTION if options.range is None else options.range
    planner = with_ompl(options.planner, options.time, not options.no_simplify, options.seed, longest, options.sampling)
    for problem in islice(load_problems(path), options.first):
        result = solve(problem, robot, planner, verify=options.verify is not None)
        if options.each:
            print(_line(result), flush=True)
        yield result


def _line(result: ProblemResult) -> str:
    plan = result.plan
    if not plan.solved:
        return f"{result.name}: {plan.reason}"
    spent = f"{plan.time:.3f} s + {plan.simplification_time:.3f} s"
    return f"{result.name}: solved in {spent}, {len(plan.path)} configurations, {plan.length:.3f} rad"


def _row(name: str, numbers: SetSummary) -> tuple[object, ...]:
    times = (f"{value:.3f}" for value in (*numbers.times, numbers.totals[1], numbers.length))
    counts = numbers.problems, numbers.within, numbers.free, numbers.accepted, numbers.solved
    return name, *counts, percentage(numbers.solved, numbers.accepted), *times


def _show_rejections(results: list[ProblemResult]) -> None:
    counts = summary(results).rejections
    if counts:
        print("\nColliding starts and goals:")
        print(
            table(
                ("end", "link", "link or obstacle", "problems"),
                [(*key, n) for key, n in counts.most_common()],
            )
        )
    beyond: Counter[str] = Counter()
    for result in results:
        beyond.update(
            f"{name}: {text}" for name, end in (("start", result.start), ("goal", result.goal)) for text in end.beyond
        )
    if beyond:
        print("\nBeyond the limits:")
        print(table(("joint", "problems"), list(beyond.most_common())))


def _show_unsolved(results: list[ProblemResult]) -> None:
    lines = [_line(r) for r in results if not r.plan.solved and r.start.accepted and r.goal.accepted]
    if lines:
        print("\nNot solved:")
        print("\n".join(lines))


def show_checks(checks: Sequence[PathCheck]) -> None:
    """Prints the results of checking some paths again, summed."""
    agreement = merged([check.agreement for check in checks])
    print(
        f"\nchecked again: {len(checks)}, {agreement.states} sampled states, "
        f"{agreement.collisions} colliding pairs; "
        f"FCL differs on {len(agreement.disagreements)} of {agreement.pairs} pairs "
        f"({len(agreement.errors_of_fcl)} errors of FCL, {len(agreement.against_us)} against us)\n"
        f"{sum(check.between for check in checks)} states between the samples: "
        f"{sum(check.between_colliding for check in checks)} collide, "
        f"on {sum(check.between_colliding > 0 for check in checks)} paths"
    )


def _as_json(result: ProblemResult) -> dict[str, Any]:
    plan, check = result.plan, result.check
    values: dict[str, Any] = {
        "problem": result.name,
        "solved": plan.solved,
        "reason": plan.reason,
        "time": plan.time,
        "simplification_time": plan.simplification_time,
        "length": plan.length,
        "joint_names": list(plan.joint_names),
        "path": plan.path.tolist(),
        "start_pairs": [list(pair) for pair in result.start.pairs],
        "goal_pairs": [list(pair) for pair in result.goal.pairs],
        "beyond_limits": [*result.start.beyond, *result.goal.beyond],
    }
    if check is not None:
        values["verified"] = {
            "states": check.agreement.states,
            "passed": check.passed,
            "errors_of_fcl": len(check.agreement.errors_of_fcl),
            "between": check.between,
            "between_colliding": check.between_colliding,
        }
    return values
