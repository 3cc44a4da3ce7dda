"""Which stage decides, and what each costs: `python tests/benchmarks/stages.py [--states 20000]`.

Three kinds of queries: bodies at random poses, bodies near touching, and states of a robot in shipped scenes (random
ones, and ones next to the border between free and colliding). For each stage the share of queries that it decides and
the mean time of those, earlier stages included. Last what finer arithmetic costs on robot states: the time of all
against that of the states that doubles settle, taken in turns.
"""

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from solids import random_poses

import plannercheck as pc
from plannercheck.bodies.tuning import pair_options
from plannercheck.common.core import core
from plannercheck.evaluation.bench.records import write_record
from plannercheck.evaluation.stress import body_families as families
from plannercheck.evaluation.stress import contact_poses as contacts
from plannercheck.scenes.scene import shipped_scenes

STAGES = ("cached plane", "box face", "centre axis", "solver", "nearest points", "double-double", "exact")
DOUBLES = 5  # so many stages are in doubles
FAMILIES = ("round", "box", "cone", "needle", "mesh")
POSES, VERTICES, SEED = 400, 150, 1
# Relative gaps of poses near touching: any magnitude from 1 % to far below rounding, and none at all.
SMALLEST, LARGEST = -17.0, -2.0
HALVINGS, REPETITIONS = 48, 5
SCENES = tuple(shipped_scenes())
# States that are timed or counted at once: as few as make the counters' own cost small.
BLOCK, TURNS = 16, 3


def solids() -> Iterator[tuple[contacts.Solid, pc.Polytope]]:
    """Bodies about 1 m across."""
    for name in FAMILIES:
        points = families.mesh_points(families.MESHES[0]) if name == "mesh" else families.family(name, VERTICES, SEED)
        body = pc.Polytope(points)
        yield contacts.Solid(name, np.asarray(body.vertices), np.asarray(body.faces, dtype=np.int64)), body


def near_touching(
    p: contacts.Solid, r: contacts.Solid, rng: np.random.Generator
) -> tuple[contacts.Points, contacts.Points]:
    """Poses with gaps of all magnitudes, one in ten without a gap."""
    gaps = rng.choice([-1, 1], POSES) * 10 ** rng.uniform(SMALLEST, LARGEST, POSES) * (rng.uniform(size=POSES) > 0.1)
    return contacts.contact_poses(p, r, gaps * min(p.size, r.size), rng)


def random(p: contacts.Solid, r: contacts.Solid, rng: np.random.Generator) -> tuple[contacts.Points, contacts.Points]:
    """Poses of which about half collide."""
    return random_poses(p, r, POSES, rng)


def show_pairs(name: str, posed: Callable[..., tuple[contacts.Points, contacts.Points]]) -> list[dict[str, object]]:
    """Prints shares and costs over all pairs of bodies; each query comes alone, so that no plane is cached."""
    rng = np.random.default_rng(SEED)
    counts, spent = np.zeros(len(STAGES)), np.zeros(len(STAGES))
    bodies = list(solids())
    options = pair_options(cached_plane=False)
    for p, body_p in bodies:
        for r, body_r in bodies:
            poses = posed(p, r, rng)
            stages = core.intersect_batch(body_p.core, poses[0], body_r.core, poses[1], options)[1]
            for stage in np.unique(stages):
                chosen = [np.ascontiguousarray(pose[stages == stage]) for pose in poses]
                counts[stage] += len(chosen[0])
                spent[stage] += best_time(
                    lambda c=chosen, p=body_p, r=body_r: core.intersect_batch(p.core, c[0], r.core, c[1], options)
                )
    return show(name, counts, spent)


def best_time(work: Callable[[], object]) -> float:
    """Least seconds of a few runs."""
    times = []
    for _ in range(REPETITIONS):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


def show(name: str, counts: np.ndarray, spent: np.ndarray | None = None) -> list[dict[str, object]]:
    """Prints one line a stage, and gives the rows."""
    rows: list[dict[str, object]] = []
    print(f"\n{name}: {int(counts.sum())} queries that bounds leave")
    for k, stage in enumerate(STAGES):
        share = 100 * counts[k] / counts.sum()
        cost = f"{1e6 * spent[k] / counts[k]:10.2f} us" if spent is not None and counts[k] else ""
        print(f"  {stage:15} {share:10.5f} %{cost}")
        each = 1e6 * spent[k] / counts[k] if spent is not None and counts[k] else None
        rows.append({"kind": name, "queries": counts.sum(), "stage": stage, "percent": share, "microseconds": each})
    return rows


def border_states(checker: pc.Checker, q: np.ndarray) -> np.ndarray:
    """Configurations as near to the border between free and colliding as doubles get, from random pairs (n, nq)."""
    half = len(q) // 2
    start, end = q[:half], q[half : 2 * half]
    valid = checker.check_states(start)
    rows = valid != checker.check_states(end)
    start, end, valid = start[rows], end[rows], valid[rows]
    for k in range(HALVINGS):
        middle = (start + end) / 2
        stay = (np.arange(len(middle)) % HALVINGS < k)[:, None]  # some rows stop early: all distances occur
        same = (checker.check_states(middle) == valid)[:, None]
        start, end = np.where(same & ~stay, middle, start), np.where(same | stay, end, middle)
    return np.asarray(start)


def stage_counts(checker: pc.Checker, before: dict[str, int]) -> np.ndarray:
    """Queries that each stage decided since the counters were taken."""
    now = checker.statistics()
    names = [stage.replace(" ", "_").replace("-", "_") for stage in STAGES]
    return np.array([now[name] - before[name] for name in names], dtype=float)


def fallback_ratio(checker: pc.Checker, q: np.ndarray) -> tuple[int, float]:
    """States in blocks that need more than doubles, and the time of all states over that of the others, a state."""
    needs = np.zeros(len(q), dtype=bool)
    for k in range(0, len(q), BLOCK):
        before = checker.statistics()
        checker.check_states(q[k : k + BLOCK])
        needs[k : k + BLOCK] = stage_counts(checker, before)[DOUBLES:].any()
    others = np.ascontiguousarray(q[~needs])
    turns = [[best_time(lambda rows=rows: checker.check_states(rows)) for rows in (q, others)] for _ in range(TURNS)]
    both = np.min(turns, axis=0) / [len(q), max(1, len(others))]
    return int(needs.sum()), float(both[0] / both[1]) if needs.any() else 1.0


def show_states(states: int) -> list[dict[str, object]]:
    """Prints shares on robot states, random ones and near the border, and what finer arithmetic costs them."""
    rows: list[dict[str, object]] = []
    robot = pc.Robot.load("panda")
    checkers = {name: pc.Checker(robot, pc.Scene.load(name)) for name in SCENES}
    for kind in ("random", "near the border"):
        counts, total, pairs, ratios = np.zeros(len(STAGES)), 0, 0, {}
        for seed, (scene, checker) in enumerate(checkers.items()):
            q = robot.random_configurations(states, seed)
            if kind != "random":
                q = border_states(checker, q)
            before = checker.statistics()
            checker.check_states(q)
            counts += stage_counts(checker, before)
            total += len(q)
            pairs += checker.statistics()["pairs"] - before["pairs"]
            ratios[scene] = fallback_ratio(checker, q)
        rows += show(f"{total} {kind} states of the Panda, {pairs} pairs", counts)
        print(f"  decided in doubles: {100 - 100 * counts[DOUBLES:].sum() / pairs:.6f} % of the pairs")
        for scene, (needs, ratio) in ratios.items():
            print(f"  {scene:10} {needs:6} states in blocks that doubles leave; time of all over others {ratio:.3f}")
    return rows


def main() -> None:
    """Runs all three."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--states", type=int, default=20_000, help="robot states a scene")
    parser.add_argument("--output", type=Path, metavar="FILE", help="write the rows as JSON")
    options = parser.parse_args()
    rows = [*show_pairs("random poses", random), *show_pairs("near touching", near_touching)]
    rows += show_states(options.states)
    if options.output:
        write_record(options.output, rows)


if __name__ == "__main__":
    main()
