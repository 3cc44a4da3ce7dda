"""Plans of planar robots, checked by shapely: `python tests/benchmarks/planar_plans.py [--seeds 5]`.

OMPL's planners plan between the shipped starts and goals, straight and on curves, with motions judged in three ways: at
OMPL's default resolution of 1 % of the space's extent, sampled at 1 cm, and proved free. Each path, shortened, is then
followed as OMPL interpolates it, so that no point of the robot moves further than 1 mm between two states, and shapely
says at each whether the robot touches an obstacle or itself. Counted are states where shapely and plannercheck differ,
states that collide, and the plans that they are on: sampling proves nothing between samples.
"""

import argparse
import sys
import time
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from ompl import base, geometric, util

import plannercheck as pc
from plannercheck.evaluation.bench.records import write_record
from plannercheck.ompl import space_of
from plannercheck.ompl.curved_space import sampled_curve
from plannercheck.ompl.motion_validators import motion_validator
from plannercheck.ompl.planar_space import PlanarSpace

TASKS = [
    ("warehouse", "forklift", "straight", None),
    ("warehouse", "forklift", "reeds_shepp", 1.5),
    ("parking", "forklift", "straight", None),
    ("parking", "forklift", "dubins", 1.5),
    ("parking", "forklift", "reeds_shepp", 1.5),
    ("parking", "truck_trailer", "straight", None),
    ("parking", "truck_trailer", "reeds_shepp", 6.0),
]
PLANNERS = ("RRTConnect", "RRT", "PRM")
JUDGES = ("OMPL's default", "sampled at 1 cm", "proved")
FINE = 1e-3  # m
SAMPLED = 1e-2  # m
TIME_LIMIT = 10.0  # s
SHORTENING = 1.0  # s


def planned(checker: pc.planar.Checker, space: PlanarSpace, planner: str, judge: str, seed: int) -> list[Any] | None:
    """The states of a found path, shortened; None if there is none in time."""
    util.RNG.setSeed(seed)
    setup = geometric.SimpleSetup(space.ompl_space())
    setup.setStateValidityChecker(lambda state: checker.is_valid(np.array(space.read(state))))
    information = setup.getSpaceInformation()
    if judge != JUDGES[0]:
        resolution = SAMPLED if judge == JUDGES[1] else None
        information.setMotionValidator(motion_validator(information, checker, space, resolution))
    name = checker.robot.name
    ends = checker.scene.start(name), checker.scene.goal(name)
    setup.setStartAndGoalStates(*(space.state(information, q) for q in ends))
    setup.setPlanner(getattr(geometric, planner)(information))
    setup.solve(base.timedPlannerTerminationCondition(TIME_LIMIT))
    if not setup.haveExactSolutionPath():
        return None
    path = geometric.PathGeometric(setup.getSolutionPath())
    limit = base.timedPlannerTerminationCondition(SHORTENING)
    kept = setup.getPathSimplifier().simplify(path, limit, atLeastOnce=False)
    return list((path if kept else setup.getSolutionPath()).getStates())


def followed(checker: pc.planar.Checker, states: list[Any], space: PlanarSpace) -> np.ndarray:
    """The states (n, nq) of a path at 1 mm."""
    sampler, rows = checker.motion_sampler, []
    for a, b in pairwise(states):
        if not space.is_straight:
            rows.append(sampled_curve(space, a, b, sampler, FINE))
            continue
        q0, q1 = np.array(space.read(a)), np.array(space.read(b))
        end = sampler.shorter_turn(q0, q1)
        steps = int(sampler.steps(q0[None], end[None], FINE)[0])
        rows.append(sampler.states(q0, end, np.arange(steps + 1) / steps))
    return np.concatenate(rows)


def shapelys_verdicts(checker: pc.planar.Checker, q: np.ndarray) -> np.ndarray:
    """(n,) whether shapely finds no pair of polygons to touch; pairs with boxes apart need no look."""
    poses = checker.body_poses(q)
    valid = np.ones(len(q), dtype=bool)
    posed: dict[int, tuple[np.ndarray, np.ndarray, np.ndarray]] = {}

    def polygons(k: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        if k not in posed:
            body = checker.bodies[k]
            used = poses[:1, k] if body.link < 0 else poses[:, k]
            vertices = np.einsum("nij,vj->nvi", used[:, :2, :2], body.vertices) + used[:, None, :2, 2]
            shapes = shapely.polygons(np.concatenate([vertices, vertices[:, :1]], axis=1))
            everywhere = np.broadcast_to(shapes, len(q))
            posed[k] = everywhere, vertices.min(axis=1), vertices.max(axis=1)
        return posed[k]

    for a, b in checker.pairs.tolist():
        (first, low_a, high_a), (second, low_b, high_b) = polygons(a), polygons(b)
        near = ((low_a <= high_b) & (low_b <= high_a)).all(axis=1)
        valid[near] &= ~shapely.intersects(first[near], second[near])
    return valid


COLUMNS = (
    *("scene", "robot", "curve", "motions", "solved", "median s"),
    *("states at 1 mm", "differ", "colliding", "on plans"),
)


def row_of(task: tuple[str, str, Any, float | None], judge: str, seeds: range) -> list[str]:
    """The cells of a line of the table."""
    scene, name, curve, radius = task
    checker = pc.planar.Checker(pc.planar.Robot.load(name), pc.planar.Scene.load(scene))
    space = space_of(checker, curve, radius)
    assert isinstance(space, PlanarSpace)
    times, states, differ, colliding, plans = [], 0, 0, 0, 0
    planners = PLANNERS[:2] if curve == "dubins" else PLANNERS  # roadmaps go either way
    for planner in planners:
        for seed in seeds:
            began = time.perf_counter()
            path = planned(checker, space, planner, judge, seed)
            if path is None:
                continue
            times.append(time.perf_counter() - began)
            q = followed(checker, path, space)
            valid = shapelys_verdicts(checker, q)
            states += len(q)
            differ += int((valid != checker.check_states(q)).sum())
            colliding += int((~valid).sum())
            plans += not valid.all()
    tried = len(planners) * len(seeds)
    spent = f"{np.median(times):.2f}" if times else "-"
    counted = [f"{states:,}", str(differ), f"{colliding:,}", str(plans)]
    return [scene, name, curve, judge, f"{len(times)} of {tried}", spent, *counted]


def main() -> int:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--tasks", type=int, nargs="*", default=range(len(TASKS)), help="which lines of TASKS")
    parser.add_argument("--output", type=Path, metavar="FILE", help="write the rows as JSON")
    options = parser.parse_args()
    seeds = range(1, options.seeds + 1)
    util.setLogLevel(util.LOG_NONE)
    print(f"| {' | '.join(COLUMNS)} |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    rows: list[dict[str, object]] = []
    for task in (TASKS[k] for k in options.tasks):
        for judge in JUDGES:
            cells = row_of(task, judge, seeds)
            print(f"| {' | '.join(cells)} |", flush=True)
            rows.append(dict(zip(COLUMNS, cells, strict=True)))
    if options.output:
        write_record(options.output, rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
