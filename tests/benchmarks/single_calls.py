"""Single calls beside batches and peers: `python tests/benchmarks/single_calls.py [--vertices 8,150,1000]`.

Pairs of round bodies at random poses, as in `plannercheck bench pairs`, one call a pair from Python: `pc.intersects`
with two poses and with two `pc.Placed`, its batch beside the core's own loop, python-fcl and coal with objects and
transforms ready. Then states of a robot in a scene: `is_valid` of arrays and of lists and OMPL's callback, over a state
in a batch. Contenders take turns in one process, and the least time of each counts (evaluation/bench/timing.py).
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

import coal
import fcl
import numpy as np
from ompl import base

import plannercheck as pc
from plannercheck.bodies.coal_bodies import coal_hull
from plannercheck.bodies.tuning import pair_options
from plannercheck.common.core import core
from plannercheck.evaluation.bench.pairs import GAPS
from plannercheck.evaluation.bench.records import write_record
from plannercheck.evaluation.bench.timing import least_seconds
from plannercheck.evaluation.stress.body_families import family
from plannercheck.evaluation.stress.contact_poses import Solid, contact_poses

Work = Callable[[], Any]
FCL, COAL, TWO_POSES = "python-fcl, objects ready", "coal, objects ready", "two poses"
BATCH, ROWS, LISTS, CALLBACK = "batch", "is_valid, arrays", "is_valid, lists", "OMPL's callback"
# What is asked for: at most so many times a batch's state.
ASKED = {ROWS: 2.2, CALLBACK: 2.5}


def pair_contenders(bodies: list[pc.Polytope], poses: tuple[np.ndarray, np.ndarray]) -> dict[str, Work]:
    """Each judges all pairs of poses."""
    P, R = bodies
    pairs = list(zip(*(list(each) for each in poses), strict=True))
    placed = [(pc.Placed(P, a), pc.Placed(R, b)) for a, b in pairs]
    options = pair_options()
    request = fcl.CollisionRequest(num_max_contacts=1, enable_contact=False)
    shapes = [
        fcl.Convex(b.vertices, len(b.faces), np.column_stack([np.full(len(b.faces), 3), b.faces]).ravel().tolist())
        for b in bodies
    ]
    objects = [
        [fcl.CollisionObject(shape, fcl.Transform(m[:3, :3], m[:3, 3])) for shape, m in zip(shapes, pair, strict=True)]
        for pair in pairs
    ]
    hulls = [coal_hull(body, "a round body") for body in bodies]
    frames = [[coal.Transform3s(m[:3, :3], m[:3, 3]) for m in pair] for pair in pairs]
    coal_request, result = coal.CollisionRequest(), coal.CollisionResult()
    coal_request.enable_contact = False

    def by_coal() -> list[bool]:
        found = []
        for a, b in frames:
            result.clear()
            found.append(coal.collide(hulls[0], a, hulls[1], b, coal_request, result) > 0)
        return found

    return {
        TWO_POSES: lambda: [pc.intersects(P, R, a, b) for a, b in pairs],
        "two Placed": lambda: [pc.intersects(a, b) for a, b in placed],
        "distance, two poses": lambda: [pc.distance(P, R, a, b) for a, b in pairs],
        BATCH: lambda: pc.intersects(P, R, *poses),
        "the core's loop": lambda: core.intersect_batch(P.core, poses[0], R.core, poses[1], options),
        FCL: lambda: [fcl.collide(a, b, request, fcl.CollisionResult()) > 0 for a, b in objects],
        COAL: by_coal,
    }


def measure_pairs(sizes: list[int], count: int, rounds: int) -> list[dict[str, object]]:
    """Prints and returns a row a size, gap and contender."""
    rows: list[dict[str, object]] = []
    print(f"{'vertices':>8}  {'gap':>7}  {'contender':26}  {'µs a pair':>9}  {'of python-fcl':>13}")
    for vertices in sizes:
        bodies = [pc.Polytope(family("round", vertices, seed)) for seed in (1, 2)]
        solids = [Solid("round", b.vertices, np.asarray(b.faces, dtype=np.int64)) for b in bodies]
        for gap in GAPS:
            wished = np.full(count, gap * min(solid.size for solid in solids))
            poses = contact_poses(solids[0], solids[1], wished, np.random.default_rng(vertices))
            seconds = least_seconds(pair_contenders(bodies, poses), rounds)
            for name, spent in seconds.items():
                ratio = spent / seconds[FCL]
                print(f"{vertices:8d}  {gap:+7g}  {name:26}  {1e6 * spent / count:9.3f}  {ratio:13.2f}")
                row = {"vertices": vertices, "gap": gap, "contender": name, "microseconds": 1e6 * spent / count}
                rows.append(row | {"of_fcl": ratio})
    return rows


def measure_states(robot: str, scene: str, count: int, rounds: int) -> list[dict[str, object]]:
    """Prints and returns a row a way to ask for states."""
    checker = pc.Checker(pc.Robot.load(robot), pc.Scene() if scene == "none" else pc.Scene.load(scene))
    q = checker.robot.random_configurations(count, 0)
    judge = checker.state_validity()
    space = base.RealVectorStateSpace(checker.robot.nq)
    states = [space.allocState() for _ in q]
    for state, row in zip(states, q, strict=True):
        for k, value in enumerate(row.tolist()):
            state[k] = value
    arrays, lists = list(q), q.tolist()
    contenders: dict[str, Work] = {
        BATCH: lambda: checker.check_states(q),
        ROWS: lambda: [checker.is_valid(row) for row in arrays],
        LISTS: lambda: [checker.is_valid(row) for row in lists],
    }
    if judge is not None:
        contenders[CALLBACK] = lambda: [judge(state) for state in states]
    expected = checker.check_states(q).tolist()
    assert all(list(work()) == expected for work in contenders.values())
    seconds = least_seconds(contenders, rounds)
    print(f"\n{robot} in {scene}, {count} random states")
    for name, spent in seconds.items():
        asked = f" (asked for: {ASKED[name]:g})" if name in ASKED else ""
        print(f"{name:18}  {1e6 * spent / count:6.3f} µs a state, {spent / seconds[BATCH]:5.2f} times a batch's{asked}")
    return [
        {"robot": robot, "scene": scene, "way": name, "microseconds": 1e6 * spent / count}
        for name, spent in seconds.items()
    ]


def main() -> None:
    """Measures both."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--vertices", default="8,150,1000", help="sizes; empty for no pairs (default: %(default)s)")
    parser.add_argument("--pairs", type=int, default=500)
    parser.add_argument("--robot", nargs="*", default=["panda"], help="none for no states")
    parser.add_argument("--scene", default="bookshelf")
    parser.add_argument("--states", type=int, default=1000)
    parser.add_argument("--rounds", type=int, default=31)
    parser.add_argument("--output", type=Path, metavar="FILE", help="write the rows as JSON")
    options = parser.parse_args()
    sizes = [int(size) for size in options.vertices.split(",") if size]
    rows = measure_pairs(sizes, options.pairs, options.rounds)
    for robot in options.robot:
        rows += measure_states(robot, options.scene, options.states, options.rounds)
    if options.output:
        write_record(options.output, rows)


if __name__ == "__main__":
    main()
