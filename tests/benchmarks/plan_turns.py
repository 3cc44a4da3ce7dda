"""What the default planner "auto", which lets two planners take turns, costs simple plans beside RRTConnect alone.

`python tests/benchmarks/plan_turns.py --plans 100 --rounds 15`: ways between free configurations of shipped robots that
RRTConnect finds in its first turn. For each way, "auto", RRTConnect and RRTConnect again, as the null control, take
turns; the least processor time of all rounds counts, and the mean of the ways is printed, µs. With one seed all three
find the same path, which is checked.
"""

import argparse
import time

import numpy as np

import plannercheck as pc
from plannercheck.cli.common import table

CASES = (("panda", "empty"), ("panda", "bookshelf"), ("ur5", "table"), ("ur10", "empty"))
SIMPLE = 0.002  # s
PLANNERS = {"auto": "auto", "RRTConnect": "RRTConnect", "null": "RRTConnect"}


def simple_ways(checker: pc.Checker, count: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Free configurations between which there is a way that is found at once."""
    rng, found = np.random.default_rng(1), []
    while len(found) < count:
        rows = checker.robot.random_configurations(200, int(rng.integers(1 << 30)))
        free = rows[checker.check_states(rows)]
        for ends in zip(free[::2], free[1::2], strict=False):
            plan = pc.ompl.plan(checker, *ends, time_limit=1.0, simplify=False, seed=1)
            if plan.solved and plan.time < SIMPLE:
                found.append(ends)
    return found[:count]


def microseconds(checker: pc.Checker, ends: tuple[np.ndarray, np.ndarray], simplify: bool, rounds: int) -> list[float]:
    """The least processor time of each planner's plan."""
    least = dict.fromkeys(PLANNERS, np.inf)
    names = list(PLANNERS)
    for number in range(rounds):
        paths = []
        for name in np.roll(names, number).tolist():
            began = time.process_time_ns()
            plan = pc.ompl.plan(checker, *ends, planner=PLANNERS[name], simplify=simplify, seed=1)
            least[name] = min(least[name], (time.process_time_ns() - began) / 1e3)
            paths.append(plan.path)
        if not simplify and not all(np.array_equal(path, paths[0]) for path in paths):
            raise AssertionError("planners with one seed find different paths")
    return list(least.values())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--plans", type=int, default=100, help="ways of each robot")
    parser.add_argument("--rounds", type=int, default=15)
    options = parser.parse_args()
    rows = []
    for robot, scene in CASES:
        checker = pc.Checker(pc.Robot.load(robot), pc.Scene.load(scene))
        ways = simple_ways(checker, options.plans)
        for simplify in (False, True):
            auto, alone, null = np.mean([microseconds(checker, way, simplify, options.rounds) for way in ways], axis=0)
            shortened = "shortened" if simplify else "as found"
            rows.append([robot, scene, shortened, f"{alone:.0f}", f"{auto - alone:+.1f}", f"{null - alone:+.1f}"])
            rows[-1] += [f"{auto / alone - 1:+.1%}", f"{null / alone - 1:+.1%}"]
    header = ["robot", "scene", "path", "RRTConnect, µs", "auto, µs more", "null, µs more", "auto", "null"]
    print(table(header, rows))


if __name__ == "__main__":
    main()
