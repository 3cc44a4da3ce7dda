"""Any dimension, measured: `python tests/benchmarks/ndim.py agreement|rounds|speed|trees [--pairs 100000] [--seed 0]`.

agreement: random and near-touching pairs in dimensions 2 to 6, by points and by halfspaces, against a linear program
(HiGHS through SciPy); the truth about pairs that it finds close is a certificate that was verified in fractions, from
the bodies' own numbers. Runs with other seeds add up. rounds: of the walk through the trees, and vertices it visits,
against n. speed: a query against the linear program's feasibility question. trees: memory, depth and seconds of
preparation.
"""

import argparse
import itertools
import sys
import time
from collections import Counter
from functools import partial
from pathlib import Path

import numpy as np
from scipy.optimize import linprog

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from ndim_pairs import depth_program, depths, near_poses, random_body, random_pose

from plannercheck import ndim
from plannercheck.evaluation.bench.records import write_record

DIMENSIONS = (2, 3, 4, 5, 6)
# Least weights and depths above this are clear: HiGHS keeps 1e-7.
CLEAR = 1e-5
# Part of the pairs that are near contact.
NEAR = 0.25
# Pairs of poses for each pair of bodies.
POSES = 20
# Vertices beyond the dimension; more of them in part of the bodies up to a dimension.
FEW, MANY, LARGE, LARGE_UP_TO = 8, 60, 0.1, 4


def agreement(pairs: int, seed: int) -> None:
    """Prints how many pairs were judged, how, and how many verdicts were wrong, a hundred times on the way."""
    rng = np.random.default_rng(seed)
    counts = {d: Counter() for d in DIMENSIONS}
    for part in range(1, 101):
        for d, count in counts.items():
            while count["pairs"] < pairs * part // (100 * len(DIMENSIONS)):
                judge_bodies(rng, d, count)
        show_agreement(counts)


def show_agreement(counts: dict[int, Counter]) -> None:
    """Prints the table so far."""
    print("dimension    pairs   near   confirmed exactly   shared   by integers   wrong (oracle)   wrong (trees)")
    for d, count in [*counts.items(), ("all", sum(counts.values(), Counter()))]:
        print(
            f"{d!s:>9s}  {count['pairs']:7d} {count['near']:6d}   {count['confirmed']:17d}   {count['shared']:6d}   "
            f"{count['integers']:11d}   {count['wrong oracle']:14d}   {count['wrong tree']:13d}",
            flush=True,
        )


def judge_bodies(rng: np.random.Generator, d: int, count: Counter) -> None:
    """Two bodies at some pairs of poses, part of them near contact: the linear programs of all at once."""
    most = MANY if d <= LARGE_UP_TO and rng.random() < LARGE else FEW
    first, second = random_body(rng, d, most), random_body(rng, d, most)
    pairs = []
    for _ in range(POSES):
        near = rng.random() < NEAR
        count["near"] += near
        if near:
            pairs.append(near_poses(rng, first, second, d))
        else:
            pairs.append((random_pose(rng, d, rng.uniform(0, 3), affine=True), random_pose(rng, d, rng.uniform(0, 1))))
    for poses, clear in zip(pairs, depths([depth_program(first, second, *poses) for poses in pairs]), strict=True):
        judge(first, second, poses, clear, count)


def judge(first, second, poses, clear: float, count: Counter) -> None:
    """One pair, with both methods, against the program's verdict or a certificate that fractions prove."""
    count["pairs"] += 1
    if abs(clear) > CLEAR:
        truth = clear > 0
    else:
        certificate = ndim.certify(first.polytope, second.polytope, *poses, method="oracle")
        assert certificate.verify()
        truth = certificate.shares
        count["confirmed"] += 1
    count["shared"] += truth
    for method in ("oracle", "tree"):
        shares, effort = ndim.verdict(first.polytope, second.polytope, *poses, method=method)
        count[f"wrong {method}"] += shares != truth
        count["integers"] += method == "oracle" and effort.proof == "exact"


def sphere(rng: np.random.Generator, n: int, d: int) -> np.ndarray:
    """Points of the unit sphere (n, d)."""
    points = rng.normal(size=(n, d))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def touching_pose(rng: np.random.Generator, p: np.ndarray, r: np.ndarray, gap: float):
    """A pose of p at a gap from r along a random direction, by the true distance of a vertex pair's supports."""
    matrix, _ = random_pose(rng, p.shape[1], 0.0)
    u = rng.normal(size=p.shape[1])
    u /= np.linalg.norm(u)
    moved = p @ matrix.T
    low, high = moved[(moved @ u).argmin()], r[(r @ u).argmax()]
    return matrix, high - low + gap * u


def cyclic(rng: np.random.Generator, n: int, d: int) -> np.ndarray:
    """Points of a trigonometric or, in odd dimensions, the plain moment curve: the most facets n vertices can have."""
    t = 2 * np.pi * (np.arange(n) + rng.uniform(0.2, 0.8, n)) / n
    if d % 2:
        return np.column_stack([(t / np.pi - 1) ** k for k in range(1, d + 1)])
    return np.column_stack([f(k * t) / k for k in range(1, d // 2 + 1) for f in (np.cos, np.sin)])


def product(rng: np.random.Generator, n: int, d: int) -> np.ndarray:
    """About n vertices: a product of polygons with, in odd dimensions, a segment; few facets meet many vertices."""
    planes = d // 2
    sides = max(3, round((n / (1 + d % 2)) ** (1 / planes)))
    t = 2 * np.pi * np.arange(sides) / sides
    factors = [np.column_stack([np.cos(t + a), np.sin(t + a)]) for a in rng.uniform(0, 1, planes)]
    factors += [np.array([[-1.0], [1.0]])] * (d % 2)
    return np.array([np.concatenate(parts) for parts in itertools.product(*factors)]) / 2


def cross(rng: np.random.Generator, n: int, d: int) -> np.ndarray:
    """The cross polytope, and n - 2 d vertices beside its own, within 1e-3: nearly flat facets, crowded vertices."""
    corners = np.concatenate([np.eye(d), -np.eye(d)])
    beside = corners[rng.integers(2 * d, size=max(0, n - 2 * d))]
    return np.concatenate([corners, beside * (1 - 1e-6) + 1e-3 * rng.normal(size=beside.shape)])


def thin(rng: np.random.Generator, n: int, d: int) -> np.ndarray:
    """Points of a sphere that is a millionth as thick along one axis."""
    return sphere(rng, n, d) * np.append(np.ones(d - 1), 1e-6)


def round_body(rng: np.random.Generator, n: int, d: int) -> np.ndarray:
    """Points of the unit sphere."""
    return sphere(rng, n, d)


SIZES = {
    2: (100, 1000, 10_000, 100_000),
    3: (100, 1000, 10_000),
    4: (30, 100, 300, 1000),
    5: (50, 100, 200),
    6: (30, 60),
}
# Bodies with many facets or vertices of large degree, or nearly flat ones; their sizes as memory allows.
ADVERSARIES = {
    4: {cyclic: (30, 60, 100), product: (36, 144, 900), cross: (30, 100, 300), thin: (30, 100, 300)},
    5: {cyclic: (20, 40, 60), product: (50, 200), cross: (30, 60), thin: (50, 100)},
    6: {cyclic: (20,), product: (64, 125), cross: (30,), thin: (30,)},
}


ROUNDS = (
    *("d", "bodies", "n", "m (polar)", "depths"),
    *("rounds: mean", "rounds: worst", "visited: mean", "visited: worst", "oracle's rounds"),
)


def rounds(seed: int, dimensions: list[int], queries: int = 200) -> list[dict[str, object]]:
    """Prints rounds and vertices visited by the walk: round bodies, then adversarial ones; gives the rows."""
    rows: list[dict[str, object]] = []
    print("| " + " | ".join(ROUNDS) + " |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for d in dimensions:
        for make, numbers in {round_body: SIZES[d], **ADVERSARIES.get(d, {})}.items():
            for n in numbers:
                cells = rounds_of(make, d, n, seed, queries)
                print("| " + " | ".join(cells) + " |", flush=True)
                rows.append(dict(zip(ROUNDS, cells, strict=True)))
    return rows


def rounds_of(make, d: int, n: int, seed: int, queries: int) -> list[str]:
    """The cells of one row of the table."""
    rng = np.random.default_rng(seed)
    p, r = make(rng, n, d), make(rng, n, d)
    P, R = ndim.Polytope(p, memory=1 << 30), ndim.Polytope(r, memory=1 << 30)
    efforts, oracle = [], []
    for k in range(queries):
        pose = touching_pose(rng, p, r, (1e-3, -1e-3, 1e-1, -1e-1)[k % 4])
        efforts.append(ndim.verdict(P, R, pose, method="tree")[1])
        oracle.append(ndim.verdict(P, R, pose, method="oracle")[1].rounds)
    name = make.__name__.removesuffix("_body")
    if P.tree is None or R.polar_tree is None:
        note = f"no trees: {P.tree_note or R.tree_note}"
        return [str(d), name, str(len(p)), note, "", "", "", "", "", f"{np.mean(oracle):.1f}"]
    walked, visited = ([getattr(e, part) for e in efforts] for part in ("rounds", "visited"))
    depths = f"{P.tree.depth} + {R.polar_tree.depth}{'' if P.uses_tree and R.uses_tree else ', cut'}"
    sizes = [str(d), name, f"{len(p):,}", f"{len(R.polar_tree.points):,}", depths]
    counted = [f"{np.mean(walked):.1f}", str(max(walked)), f"{np.mean(visited):.0f}", str(max(visited))]
    return [*sizes, *counted, f"{np.mean(oracle):.1f}"]


def feasible_by_program(p: np.ndarray, r: np.ndarray, pose) -> bool:
    """Whether mixtures of both are the same point, by HiGHS."""
    matrix, shift = pose
    d, n = p.shape[1], len(p)
    rows = np.zeros((d + 2, n + len(r)))
    rows[:d, :n], rows[:d, n:] = (p @ matrix.T + shift).T, -r.T
    rows[d, :n] = rows[d + 1, n:] = 1.0
    right = np.append(np.zeros(d), [1.0, 1.0])
    return linprog(np.zeros(n + len(r)), A_eq=rows, b_eq=right, bounds=(0, None), method="highs").status == 0


def speed(seed: int, dimensions: list[int], queries: int = 20) -> list[dict[str, object]]:
    """Prints ms a query: minima of two interleaved passes, means over queries; gives the rows."""
    rows: list[dict[str, object]] = []
    print("| d | n | gap | program, ms | oracle, ms | trees, ms | program / oracle | program / trees |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for d in dimensions:
        for n in (100, 1000, 10_000):
            rng = np.random.default_rng(seed)
            p, r = sphere(rng, n, d), sphere(rng, n, d)
            P, R = ndim.Polytope(p), ndim.Polytope(r)
            trees = n in SIZES[d] and P.uses_tree and R.uses_tree
            for gap in (0.1, 1e-4, 0.0, -0.1):  # at 0 integers decide, which the program does not
                poses = [touching_pose(rng, p, r, gap) for _ in range(queries)]
                ways = {
                    "program": partial(feasible_by_program, p, r),
                    "oracle": partial(ndim.intersects, P, R, method="oracle"),
                }
                if trees:
                    ways["trees"] = partial(ndim.intersects, P, R, method="tree")
                ms = timed(ways, poses)
                tree, over = (f"{ms['trees']:.2f}", f"{ms['program'] / ms['trees']:.1f}") if trees else ("-", "-")
                print(
                    f"| {d} | {n:,} | {gap:g} | {ms['program']:.2f} | {ms['oracle']:.2f} | {tree} "
                    f"| {ms['program'] / ms['oracle']:.1f} | {over} |",
                    flush=True,
                )
                rows.append({"d": d, "n": n, "gap": gap, **ms})
    return rows


def timed(ways: dict, poses: list) -> dict[str, float]:
    """Mean ms of each way over poses, the least of two passes in turns A B B A for each pose."""
    best = {name: np.full(len(poses), np.inf) for name in ways}
    for name in [*ways, *reversed(ways)]:
        for k, pose in enumerate(poses):
            start = time.perf_counter()
            ways[name](pose)
            best[name][k] = min(best[name][k], time.perf_counter() - start)
    return {name: 1e3 * float(values.mean()) for name, values in best.items()}


def trees(seed: int, dimensions: list[int]) -> None:
    """Prints what the trees of round bodies take."""
    print(
        "dimension       n   tree: nodes  depth  largest leaf   polar: points  nodes  depth  largest leaf     MB      s"
    )
    for d in dimensions:
        for n in SIZES[d]:
            start = time.perf_counter()
            body = ndim.Polytope(sphere(np.random.default_rng(seed), n, d))
            if not body.uses_tree:
                print(f"{d:9d} {n:7d}   {body.tree_note} ({time.perf_counter() - start:.1f} s)", flush=True)
                continue
            tree, polar = body.tree, body.polar_tree
            print(
                f"{d:9d} {n:7d}   {len(tree.nodes):11d}  {tree.depth:5d}  {tree.largest_leaf:12d}   "
                f"{len(polar.points):13d}  {len(polar.nodes):5d}  {polar.depth:5d}  {polar.largest_leaf:12d}  "
                f"{body.tree_bytes / 2**20:6.1f} {time.perf_counter() - start:6.1f}",
                flush=True,
            )


def main() -> None:
    """Runs one of the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("table", choices=("agreement", "rounds", "speed", "trees"))
    parser.add_argument("--pairs", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--dimensions", type=int, nargs="*", default=list(DIMENSIONS), choices=DIMENSIONS)
    parser.add_argument("--output", type=Path, metavar="FILE", help="write the rows of rounds or speed as JSON")
    options = parser.parse_args()
    if options.table == "agreement":
        agreement(options.pairs, options.seed)
    else:
        rows = {"rounds": rounds, "speed": speed, "trees": trees}[options.table](options.seed, options.dimensions)
        if options.output and rows:
            write_record(options.output, rows)


if __name__ == "__main__":
    main()
