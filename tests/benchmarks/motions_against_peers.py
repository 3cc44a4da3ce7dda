"""Proved motions beside motions that other libraries sample: `python tests/benchmarks/motions_against_peers.py`.

Motions of 1 rad of the Panda from valid states, in shipped scenes. Ours are proved, every state on them. The peers
judge 32 states a radian from coarse to fine, and stop when one of them collides: coal through Pinocchio with its AABB
tree, and python-fcl on the pairs whose boxes meet, both on the checker's hulls. By turns in one process, the least time
counts. A verdict differs where a peer calls a motion free that is refused, or the reverse.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path

import numpy as np

import plannercheck as pc
from plannercheck.cli.common import table
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.bench import other_libraries as peers
from plannercheck.evaluation.bench.records import write_record
from plannercheck.evaluation.bench.timing import least_seconds
from plannercheck.motions.sampling import coarse_to_fine

SCENES = ("bookshelf", "cage")
STATES_A_RADIAN = 32
SPLITS = (2, 9)  # the ends, then every eighth of the motion, then the rest
PEER_MOTIONS = 40  # peers are slower, and judge the first of the motions only


def unit_motions(checker: pc.Checker, n: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """n motions of 1 rad from valid states to states within the limits."""
    rng, robot = np.random.default_rng(seed), checker.robot
    starts, ends = np.zeros((0, robot.nq)), np.zeros((0, robot.nq))
    while len(starts) < n:
        q = robot.random_configurations(4 * n, rng)
        q = q[checker.check_states(q)]
        way = rng.normal(size=q.shape)
        end = q + way / np.linalg.norm(way, axis=1)[:, None]
        inside = ((end >= robot.lower) & (end <= robot.upper)).all(axis=1)
        starts, ends = np.vstack([starts, q[inside]]), np.vstack([ends, end[inside]])
    return starts[:n], ends[:n]


def sampled(judge: peers.Judge, q0: np.ndarray, q1: np.ndarray) -> np.ndarray:
    """Verdicts of a judge of states, some at a time: a call costs it something, and a collision ends a motion."""
    parts = np.split(coarse_to_fine(STATES_A_RADIAN)[:, None], SPLITS)
    return np.array(
        [all(judge((1 - part) * a + part * b).all() for part in parts) for a, b in zip(q0, q1, strict=True)]
    )


def measure(scene: str, motions: int, rounds: int) -> list[dict[str, object]]:
    """A row for each method in a scene."""
    checker = pc.Checker(pc.Robot.load("panda"), pc.Scene.load(scene))
    q0, q1 = unit_motions(checker, motions, 0)
    few = q0[:PEER_MOTIONS], q1[:PEER_MOTIONS]
    free = checker.check_motions(q0, q1)
    counts = {"plannercheck, batch": len(q0), "plannercheck, one by one": len(q0)}
    works: dict[str, Callable[[], np.ndarray]] = {
        "plannercheck, batch": lambda: checker.check_motions(q0, q1),
        "plannercheck, one by one": lambda: np.array([checker.check_motion(a, b) for a, b in zip(q0, q1, strict=True)]),
    }
    for name, make in (("coal, AABB tree", _coal), ("python-fcl", peers.fcl)):
        try:
            judge = make(checker)
        except (PlannercheckError, ImportError) as error:
            print(f"{name} is left out: {error}")
            continue
        works[name] = lambda judge=judge: sampled(judge, *few)
        counts[name] = len(few[0])
    differ = {name: int((work() != free[: counts[name]]).sum()) for name, work in works.items()}
    seconds = least_seconds(works, rounds)
    return [
        {
            "scene": scene,
            "method": name,
            "microseconds": 1e6 * spent / counts[name],
            "free": float(free.mean()),
            "motions": counts[name],
            "differ": differ[name],
        }
        for name, spent in seconds.items()
    ]


def _coal(checker: pc.Checker) -> peers.Judge:
    return peers.coal_with_tree(checker, peers.COAL_TOLERANCES[0])


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--motions", type=int, default=1000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--output", type=Path, metavar="FILE", help="write the rows as JSON")
    options = parser.parse_args()
    rows = [row for scene in SCENES for row in measure(scene, options.motions, options.rounds)]
    print(table(list(rows[0]), [[_cell(value) for value in row.values()] for row in rows]))
    if options.output:
        write_record(options.output, rows)


def _cell(value: object) -> object:
    return f"{value:.2f}" if isinstance(value, float) else value


if __name__ == "__main__":
    main()
