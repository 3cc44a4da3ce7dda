"""Plans by certified motions beside the same planner on Pinocchio and coal at OMPL's default resolution.

Run: python tests/benchmarks/plans_against_peer.py bookshelf_small_panda.tar.bz2 … --seeds 1 2 3 [--every 10]

The problems of MotionBenchMaker sets, one process, by turns (A B, next time B A). Both are RRTConnect of the same OMPL
on the same space with the same range, starts, goals and seeds:

- ours: `pc.ompl.setup(checker)`, every motion proved free;
- peer: a validity checker in Python that calls Pinocchio's computeCollisions with coal's dynamic AABB tree over the
  same hulls and pairs, stopping at the first collision; OMPL's own DiscreteMotionValidator at its default resolution of
  1 % of the space's extent.

Times are process times of `solve` (one thread: what the clock shows on an idle machine), plans as found, without
shortening; "call" is all of `pc.ompl.plan`, from its arguments to the Plan. The plans of the peer are then judged by
`Checker.check_motions`: a motion counts as colliding if a state on it collides by the exact verdict. The depth is that
of the deepest of STATES states a motion (by the bounds of `Checker.clearances`): how far its deepest pair of bodies has
to be moved apart at least (`pc.depth`).
"""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

import numpy as np
import pinocchio as pin
from ompl import base, geometric, util

import plannercheck as pc
from plannercheck.evaluation.bench.other_libraries import COAL_TOLERANCES, coal_geometry_data, coal_geometry_model
from plannercheck.evaluation.bench.records import write_record
from plannercheck.ompl import LONGEST_MOTION
from plannercheck.ompl.joint_space import JointSpace
from plannercheck.scenes.motion_bench_maker import load_problems
from plannercheck.validation.problem_sets import robot_of

STATES = 200


class CoalTree:
    """Whether a state is free, by Pinocchio and coal, with as little Python as there can be."""

    def __init__(self, checker: pc.Checker) -> None:
        robot = checker.robot
        self._model, self._geometry = robot.model, coal_geometry_model(checker)
        self._data = self._model.createData()
        self._geometry_data = coal_geometry_data(self._geometry, COAL_TOLERANCES[0])
        tree = pin.BroadPhaseManager_DynamicAABBTreeCollisionManager
        self._tree = tree(self._model, self._geometry, self._geometry_data)  # which keeps neither of the two alive
        self._full = np.array(robot.expand(np.zeros(robot.nq)))
        moved = [np.flatnonzero(np.array(robot.expand(row)) != self._full) for row in np.eye(robot.nq)]
        assert all(len(entries) == 1 for entries in moved)  # one number a joint, none that follows another
        self._columns = np.concatenate(moved)
        self._nq = robot.nq

    def __call__(self, state: object) -> bool:
        self._full[self._columns] = [state[k] for k in range(self._nq)]  # type: ignore[index]
        return not pin.computeCollisions(self._model, self._data, self._tree, self._full, True)


@dataclass
class Tally:
    """What one side did."""

    times: list[float] = field(default_factory=list)
    calls: list[float] = field(default_factory=list)
    tried: int = 0
    colliding: int = 0
    refused: int = 0
    depths: list[float] = field(default_factory=list)

    def line(self, name: str) -> str:
        """A row of the table."""
        ms = np.array(self.times) * 1e3
        return (
            f"{name:34s} {len(ms):5d} of {self.tried:5d}  {np.median(ms):9.2f} {ms.mean():9.2f} "
            f"{np.quantile(ms, 0.95):9.2f}"
        )


def planned(setup, space, start, goal, seed, longest, limit):
    """(process time of the search, path or None)."""
    information = setup.getSpaceInformation()
    util.RNG.setSeed(seed)
    setup.setStartAndGoalStates(space.state(information, start), space.state(information, goal))
    planner = geometric.RRTConnect(information)
    planner.setRange(longest)
    setup.setPlanner(planner)
    condition = base.timedPlannerTerminationCondition(limit)
    began = time.process_time()
    setup.solve(condition)
    spent = time.process_time() - began
    if not setup.haveExactSolutionPath():
        return spent, None
    return spent, np.array([space.read(state) for state in setup.getSolutionPath().getStates()])


def ours(checker, space, *options):
    """A plan by certified motions."""
    return planned(pc.ompl.setup(checker), space, *options)


def peers(checker, space, judge, *options):
    """A plan by the peer."""
    setup = geometric.SimpleSetup(space.ompl_space())
    setup.setStateValidityChecker(judge)
    return planned(setup, space, *options)


def judge_path(checker: pc.Checker, path: np.ndarray, tally: Tally) -> None:
    """Adds what the certified checker says of a path."""
    refused = np.flatnonzero(~checker.check_motions(path[:-1], path[1:]))
    t = np.linspace(0, 1, STATES)[:, None]
    deepest, there = 0.0, path[0]
    for k in refused.tolist():
        verdict = checker.explain_motion(path[k], path[k + 1])
        states = (1 - t) * path[k] + t * path[k + 1]
        if verdict.collides_at is not None:
            near = (1 - verdict.collides_at) * path[k] + verdict.collides_at * path[k + 1]
            states = np.vstack([states, near])
        colliding = states[~checker.check_states(states)]
        if len(colliding):
            bounds = np.maximum(-checker.clearances(colliding), np.finfo(float).tiny)
            if bounds.max() > deepest:
                deepest, there = float(bounds.max()), colliding[bounds.argmax()]
    tally.refused += len(refused) > 0
    tally.colliding += deepest > 0
    if deepest > 0:
        tally.depths.append(deepest_pair(checker, there))


def deepest_pair(checker: pc.Checker, q: np.ndarray) -> float:
    """The greatest depth of a pair at a configuration, m."""
    poses = checker.body_poses(q[None])[0]
    pairs = checker.pairs[checker.colliding_pairs(q[None])[0]].tolist()
    return max(pc.depth(checker.polytopes[a], checker.polytopes[b], poses[a], poses[b]).depth for a, b in pairs)


def run(options: argparse.Namespace) -> None:
    """Prints a table a set, and one of all."""
    robot = pc.Robot.load("panda")
    util.setLogLevel(util.LOG_NONE)
    everything: dict[str, Tally] = {"ours": Tally(), "peer": Tally()}
    rows: list[dict[str, object]] = []
    print(f"{'':34s} {'solved':>14s}  {'median ms':>9s} {'mean ms':>9s} {'95 % ms':>9s}")
    for archive in options.sets:
        tallies = {"ours": Tally(), "peer": Tally()}
        for problem in islice(load_problems(archive), 0, None, options.every):
            checker = pc.Checker(robot_of(problem, robot), problem.scene)
            one_problem(checker, problem, options, tallies)
        name_of_set = Path(archive).name.split(".")[0]
        show(name_of_set, tallies)
        rows += rows_of(name_of_set, tallies)
        for name, tally in tallies.items():
            for attribute in ("times", "calls", "depths"):
                getattr(everything[name], attribute).extend(getattr(tally, attribute))
            for attribute in ("tried", "colliding", "refused"):
                setattr(everything[name], attribute, getattr(everything[name], attribute) + getattr(tally, attribute))
    show("all", everything)
    if options.output:
        write_record(options.output, [*rows, *rows_of("all", everything)])


def rows_of(name: str, tallies: dict[str, Tally]) -> list[dict[str, object]]:
    """A row for each side, for the record."""
    return [
        {
            "set": name,
            "side": side,
            "solved": len(tally.times),
            "tried": tally.tried,
            "median_ms": 1e3 * float(np.median(tally.times)),
            "mean_ms": 1e3 * float(np.mean(tally.times)),
            "call_median_ms": 1e3 * float(np.median(tally.calls)) if tally.calls else None,
            "refused": tally.refused,
            "colliding": tally.colliding,
            "deepest_median_mm": 1e3 * float(np.median(tally.depths)) if tally.depths else None,
            "deepest_mm": 1e3 * float(np.max(tally.depths)) if tally.depths else None,
        }
        for side, tally in tallies.items()
    ]


def one_problem(checker, problem, options, tallies):
    """Plans by turns; starts or goals beyond the limits or in collision are left out."""
    lower, upper = checker.robot.lower, checker.robot.upper
    ends = problem.start, problem.goals[0]
    if not all(checker.is_valid(q) and ((q >= lower) & (q <= upper)).all() for q in ends):
        return
    space, judge = JointSpace(checker.robot), CoalTree(checker)
    _ = checker.motion_certifier  # built once a scene, as the peer's geometry is
    for turn, seed in enumerate(options.seeds):
        sides = {
            "ours": lambda s=seed: ours(checker, space, *ends, s, options.range, options.time),
            "peer": lambda s=seed: peers(checker, space, judge, *ends, s, options.range, options.time),
        }
        for name in list(sides) if turn % 2 == 0 else reversed(list(sides)):
            spent, path = sides[name]()
            tallies[name].tried += 1
            if path is not None:
                tallies[name].times.append(spent)
                judge_path(checker, path, tallies[name])
        began = time.process_time()
        pc.ompl.plan(checker, *ends, time_limit=options.time, simplify=False, seed=seed, longest_motion=options.range)
        tallies["ours"].calls.append(time.process_time() - began)


def show(name: str, tallies: dict[str, Tally]) -> None:
    """Prints two rows and what follows from them."""
    for side, tally in tallies.items():
        print(tally.line(f"{name}, {side}"))
    mine, theirs = (np.array(tallies[side].times) for side in ("ours", "peer"))
    if not len(mine) or not len(theirs):
        return
    found, depths = tallies["peer"], np.array(tallies["peer"].depths)
    deep = ""
    if len(depths):
        deep = f"; deepest {np.median(depths) * 1e3:.1f} mm in the median, {depths.max() * 1e3:.1f} at most"
    print(
        f"  medians {np.median(theirs) / np.median(mine):.1f} x, means {theirs.mean() / mine.mean():.1f} x; the peer's "
        f"plans: {found.refused} of {len(theirs)} refused, {found.colliding} ({found.colliding / len(theirs):.1%}) "
        f"proved to collide{deep}; ours: {tallies['ours'].refused} refused; "
        f"all of pc.ompl.plan: median {np.median(tallies['ours'].calls) * 1e3:.2f} ms",
        flush=True,
    )


def main() -> None:
    """Reads options."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sets", nargs="+", help="MotionBenchMaker archives")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1])
    parser.add_argument("--every", type=int, default=1, help="take every so-many-th problem of a set")
    parser.add_argument("--range", type=float, default=LONGEST_MOTION, help="of both planners, rad")
    parser.add_argument("--time", type=float, default=10.0, help="limit of a search, s")
    parser.add_argument("--output", type=Path, metavar="FILE", help="write the rows as JSON")
    run(parser.parse_args())


if __name__ == "__main__":
    sys.exit(main())
