"""What convex pieces bring and cost: volumes, excess of the mesh over CoACD's pieces, valid states, time a state.

Run: python tests/benchmarks/decomposition.py --robot ur5 --links upper_arm_link forearm_link. Times are CPU µs a state,
by turns with the robot of hulls; the first run takes CoACD's minutes, later ones read the cache.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

import plannercheck as pc
from plannercheck.checking.mesh_collisions import LinkMeshes
from plannercheck.evaluation.bench.records import write_record
from plannercheck.robots.description import description_of


def main() -> None:
    """Prints the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--robot", default="ur5")
    parser.add_argument("--links", nargs="*", default=["upper_arm_link", "forearm_link"])
    parser.add_argument("--threshold", type=float, default=0.05)
    parser.add_argument("--slack", type=float, default=0.001)
    parser.add_argument("--states", type=int, default=20_000)
    parser.add_argument("--meshes", type=int, default=5000, help="states to hold against coal's meshes")
    parser.add_argument("--output", type=Path, metavar="FILE", help="write the rows as JSON")
    options = parser.parse_args()
    links = tuple(options.links) or None
    began = time.perf_counter()
    fine = pc.Robot.load(options.robot, pc.Decomposition(links, options.threshold, slack=options.slack))
    print(f"{options.robot}: loaded in {time.perf_counter() - began:.1f} s")
    for name, pieces in fine.pieces.items():
        volume = pieces.mesh_volume
        shares = (
            "open mesh"
            if not volume
            else f"hull {pieces.hull_volume / volume:.3f}, pieces {pieces.volume / volume:.3f}"
        )
        print(
            f"  {name}: {len(pieces.points)} pieces of {[len(p) for p in pieces.points]} vertices; times the mesh: "
            f"{shares}; mesh out of CoACD's {pieces.excess:.3g} m, grown by {pieces.growth:.3g} m"
        )
    coarse = pc.Robot.load(options.robot)
    q = coarse.random_configurations(options.states, 0)
    checkers = {"hulls": pc.Checker(coarse), "pieces": pc.Checker(fine)}
    best = dict.fromkeys(checkers, np.inf)
    for names in (("hulls", "pieces"), ("pieces", "hulls")) * 3:
        for name in names:
            began = time.thread_time()
            checkers[name].check_states(q)
            best[name] = min(best[name], time.thread_time() - began)
    rows: list[dict[str, object]] = []
    for name, checker in checkers.items():
        valid, spent = 100 * checker.check_states(q).mean(), 1e6 * best[name] / len(q)
        print(f"  {name}: {len(checker.pairs)} pairs, {valid:.2f} % valid, {spent:.2f} µs a state")
        rows.append({"bodies": name, "pairs": len(checker.pairs), "percent_valid": valid, "microseconds": spent})
    rows += _hold_against_meshes(options.robot, checkers, q[: options.meshes])
    if options.output:
        write_record(options.output, rows)


def _hold_against_meshes(robot: str, checkers: dict[str, pc.Checker], q: np.ndarray) -> list[dict[str, object]]:
    """Says in how many states the meshes themselves collide, and in how many of them a checker says valid."""
    coarse = checkers["hulls"]
    meshes = LinkMeshes(coarse.robot, description_of(robot))
    pairs = {frozenset(coarse.pair_names(k)) for k in range(len(coarse.pairs))}
    collide = np.array([any(meshes.collisions(*pair, row[None]) for pair in pairs) for row in q])
    print(f"  meshes: {100 * (1 - collide.mean()):.2f} % of the first {len(q)} states are valid, by coal")
    rows: list[dict[str, object]] = []
    for name, checker in checkers.items():
        valid = checker.check_states(q)
        missed, refused = (valid & collide).sum(), (~valid & ~collide).sum()
        print(f"  {name}: {missed} states valid in which meshes collide, {refused} not valid in which they don't")
        rows.append({"bodies": name, "states": len(q), "missed": missed, "refused": refused})
    return rows


if __name__ == "__main__":
    main()
