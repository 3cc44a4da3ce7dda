"""The algorithm in the plane: `python tests/benchmarks/planar.py [--largest 1000000] [--pairs N]`.

Rounds, vertices read and time of a query, from 100 vertices on, for 1,000 poses of two polygons each around contact
and exactly at it (worst and mean); the core's batch call against shapely's `intersects` with prepared geometry, in one
process by turns; and with --pairs a comparison with exact arithmetic that shares nothing with the core: a scan of all
sides' normals in doubles with a proven bound, and where that is not clear, in Python integers.
"""

import argparse
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
import shapely

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

import planar_cases as cases
from planar_brute_force import is_separated_across, share_point

import plannercheck as pc
from plannercheck.evaluation.bench.records import write_record

QUERIES = 1000
REPETITIONS = 9
# Vertices of the polygons that are compared with shapely.
PEER_SIZES = (10, 100, 1000, 10_000)
BLOCK = 10_000  # pairs
NUDGES = 4  # pairs made of one that is drawn
REPORTED = 50_000  # pairs
FLATNESS = 0.7  # of the ellipses on which vertices are


def best(*calls: Callable[[], object]) -> list[float]:
    """Seconds of each call, the least of several turns A B B A."""
    least = [np.inf] * len(calls)
    order = [*range(len(calls)), *reversed(range(len(calls)))]
    for _ in range(REPETITIONS):
        for k in order:
            began = time.perf_counter()
            calls[k]()
            least[k] = min(least[k], time.perf_counter() - began)
    return least


def poses_around_contact(polygon: np.ndarray, spread: float, rng: np.random.Generator) -> np.ndarray:
    """1,000 poses of a polygon beside itself: where random normals of both are opposed, and up to `spread` off."""
    poses = np.array([cases.rotation(angle) for angle in rng.uniform(0, 2 * np.pi, QUERIES)])
    for pose in poses:
        angle = rng.uniform(0, 2 * np.pi)
        normal = np.array([np.cos(angle), np.sin(angle)])
        fixed, moved = furthest(polygon, normal), furthest(polygon, -normal @ pose[:2, :2])
        pose[:2, 2] = fixed - pose[:2, :2] @ moved + rng.uniform(-spread, spread) * normal
    return poses


def furthest(polygon: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """The vertex of `regular(n, FLATNESS)` that is furthest along a direction: one of those next to its angle."""
    angle = np.arctan2(FLATNESS * direction[1], direction[0])
    near = (int(np.rint(angle / (2 * np.pi) * len(polygon))) + np.arange(-1, 2)) % len(polygon)
    return np.asarray(polygon[near[np.argmax(polygon[near] @ direction)]])


def growth(largest: int) -> list[dict[str, object]]:
    """Prints rounds, vertices and time against n, and gives the rows."""
    rows: list[dict[str, object]] = []
    print("| vertices | gap | shared | rounds: mean | worst | vertices read: mean | worst | open signs | ns |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    first: dict[float, tuple[int, float]] = {}
    for exponent in range(2, int(np.log10(largest)) + 1):
        polygon = cases.regular(10**exponent, FLATNESS)
        for spread in (0.5, 1e-3, 1e-9, 0.0):
            poses = poses_around_contact(polygon, spread, np.random.default_rng(exponent))
            counts = pc.planar.count_batch(polygon, polygon, None, poses)
            (seconds,) = best(
                lambda polygon=polygon, poses=poses: pc.planar.intersects_batch(polygon, polygon, None, poses)
            )
            nanoseconds = 1e9 * seconds / QUERIES
            first.setdefault(spread, (int(counts.rounds.max()), nanoseconds))
            print(
                f"| {len(polygon):,} | ±{spread:g} | {counts.shared.mean():.2f} "
                f"| {counts.rounds.mean():.1f} | {counts.rounds.max()} "
                f"| {counts.vertices.mean():.0f} | {counts.vertices.max()} "
                f"| {counts.double_double.sum()} + {counts.exact.sum()} | {nanoseconds:,.0f} |"
            )
            steps = {"rounds_mean": counts.rounds.mean(), "rounds_worst": counts.rounds.max()}
            read = {"read_mean": counts.vertices.mean(), "read_worst": counts.vertices.max()}
            rows.append({"vertices": len(polygon), "gap": spread, **steps, **read, "nanoseconds": nanoseconds})
            last = int(counts.rounds.max()), nanoseconds
            if 10**exponent == largest:
                ratio = last[0] / first[spread][0], last[1] / first[spread][1]
                print(f"  ±{spread:g}: rounds grew {ratio[0]:.2f}-fold, time {ratio[1]:.1f}-fold")
    return rows


def against_shapely() -> list[dict[str, object]]:
    """Prints times beside shapely's: one polygon against itself at 1,000 poses, and against 1,000 arrays so posed.

    shapely takes the latter, as polygons made beforehand. Those and our arrays fill more memory than the caches.
    """
    rows: list[dict[str, object]] = []
    print("\n| vertices | gap | at poses, ns | arrays, ns | shapely prepared, ns | over poses | over arrays | differ |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for n in PEER_SIZES:
        polygon = cases.regular(n, FLATNESS)
        for spread in (0.5, 1e-3):
            poses = poses_around_contact(polygon, spread, np.random.default_rng(n))
            posed = [np.ascontiguousarray(polygon @ p[:2, :2].T + p[:2, 2]) for p in poses]
            one, others = pc.planar.Polygons([polygon]), pc.planar.Polygons(posed)
            peers = shapely.polygons([shapely.linearrings(vertices) for vertices in posed])
            prepared = shapely.Polygon(polygon)
            shapely.prepare(prepared)
            ours, arrays, theirs = best(
                lambda polygon=polygon, poses=poses: pc.planar.intersects_batch(polygon, polygon, None, poses),
                lambda one=one, others=others: pc.planar.intersects_batch(one, others),
                lambda prepared=prepared, peers=peers: shapely.intersects(prepared, peers),
            )
            differ = (pc.planar.intersects_batch(polygon, posed) != shapely.intersects(prepared, peers)).sum()
            print(
                f"| {n:,} | ±{spread:g} | {1e6 * ours:,.0f} | {1e6 * arrays:,.0f} | {1e6 * theirs:,.0f} "
                f"| {theirs / ours:.1f} × | {theirs / arrays:.1f} × | {differ} |"
            )
            times = {"poses_ns": 1e6 * ours, "arrays_ns": 1e6 * arrays, "shapely_ns": 1e6 * theirs}
            rows.append({"vertices": n, "gap": spread, **times, "differ": differ})
    return rows


def doubtful_sides(pairs: list[tuple[np.ndarray, ...]]) -> list[np.ndarray | None]:
    """For pairs of equally many vertices: None if they surely are apart, else the sides whose normals may separate.

    Polygons with area are apart if and only if the normal of some side of either separates them. With S the largest sum
    of the absolute values of the terms of a posed coordinate, a posed coordinate errs by 4u S, a side's by 10u S, so a
    difference of products along its normal by less than 96u S^2; 128u S^2 covers what computing it adds.
    """
    a, b, poses_a, poses_b = (np.array(part) for part in zip(*pairs, strict=True))
    posed, size = [], np.zeros(len(pairs))
    for vertices, poses in ((a, poses_a), (b, poses_b)):
        posed.append(np.einsum("kij,knj->kni", poses[:, :2, :2], vertices) + poses[:, None, :2, 2])
        sums = np.einsum("kij,knj->kni", np.abs(poses[:, :2, :2]), np.abs(vertices)) + np.abs(poses[:, None, :2, 2])
        size = np.maximum(size, sums.max(axis=(1, 2)))
    bound = 128 * 2.0**-53 * size**2
    sides = np.concatenate([np.roll(p, -1, axis=1) - p for p in posed], axis=1)
    normals = np.stack([-sides[:, :, 1], sides[:, :, 0]], axis=2)
    along_a, along_b = (np.einsum("kmj,knj->kmn", normals, p) for p in posed)
    apart = np.maximum(along_a.min(axis=2) - along_b.max(axis=2), along_b.min(axis=2) - along_a.max(axis=2))
    surely = (apart > bound[:, None]).any(axis=1)
    return [None if s else np.flatnonzero(row >= -limit) for s, row, limit in zip(surely, apart, bound, strict=True)]


def drawn(rng: np.random.Generator) -> tuple[str, tuple[np.ndarray, ...]]:
    """A pair of some kind."""
    kind = rng.choice(["random", "flat", "near", "grid", "nested", "larger"], p=[0.2, 0.1, 0.4, 0.2, 0.05, 0.05])
    make: dict[str, Callable[..., tuple[np.ndarray, ...]]] = {
        "random": lambda: cases.random_pair(rng, cases.ROUND),
        "flat": lambda: cases.random_pair(rng) if rng.random() < 0.5 else cases.near_pair(rng, 10, cases.FLAT),
        "near": lambda: cases.near_pair(rng),
        "grid": lambda: cases.exact_contact(rng),
        "nested": lambda: cases.nested_pair(rng),
        "larger": lambda: cases.near_pair(rng, 120, (cases.ellipse, cases.with_runs)),
    }
    return str(kind), make[str(kind)]()


def block(rng: np.random.Generator, size: int) -> tuple[list[str], list[tuple[np.ndarray, ...]]]:
    """Pairs of all kinds: drawn ones, each with some that are a little off."""
    kinds: list[str] = []
    pairs: list[tuple[np.ndarray, ...]] = []
    while len(pairs) < size:
        kind, pair = drawn(rng)
        several = cases.nudged(rng, pair, NUDGES)
        kinds += [kind] * len(several)
        pairs += several
    return kinds[:size], pairs[:size]


def truths(pairs: list[tuple[np.ndarray, ...]]) -> tuple[np.ndarray, int]:
    """The verdicts of the oracle, and how many needed integers."""
    verdicts, integers = np.zeros(len(pairs), dtype=bool), 0
    groups: dict[tuple[int, int], list[int]] = {}
    for k, (a, b, *_) in enumerate(pairs):
        if min(len(a), len(b)) > 2 and not (is_flat(a) or is_flat(b)):
            groups.setdefault((len(a), len(b)), []).append(k)
        else:
            verdicts[k] = share_point(*pairs[k])
            integers += 1
    for members in groups.values():
        for k, sides in zip(members, doubtful_sides([pairs[k] for k in members]), strict=True):
            if sides is not None:
                verdicts[k] = not is_separated_across(sides, *pairs[k]) if len(sides) else True
                integers += len(sides) > 0
    return verdicts, integers


def is_flat(vertices: np.ndarray) -> bool:
    """Whether all vertices are on a line; the families without area are on quarters, where doubles are exact."""
    first, rest = vertices[1] - vertices[0], vertices[2:] - vertices[0]
    return not (first[0] * rest[:, 1] != first[1] * rest[:, 0]).any()


def compare(total: int, seed: int) -> int:
    """Compares verdicts on `total` pairs with the oracle; the number of wrong ones."""
    rng = np.random.default_rng(seed)
    counts: Counter[str] = Counter()
    wrong: list[tuple[np.ndarray, ...]] = []
    began = time.perf_counter()
    while counts["pairs"] < total:
        kinds, pairs = block(rng, min(BLOCK, total - counts["pairs"]))
        truth, integers = truths(pairs)
        a, b, poses_a, poses_b = zip(*pairs, strict=True)
        found = pc.planar.count_batch(list(a), list(b), np.array(poses_a), np.array(poses_b))
        wrong += [pairs[k] for k in np.flatnonzero(found.shared != truth)]
        counts.update(f"kind {kind}" for kind in kinds)
        counts.update(
            {
                "pairs": len(pairs),
                "shared": int(truth.sum()),
                "decided by integers in the oracle": integers,
                "with signs left open by doubles": int((found.double_double > 0).sum()),
                "with signs left open by double-double": int((found.exact > 0).sum()),
                "wrong": int((found.shared != truth).sum()),
            }
        )
        if counts["pairs"] % REPORTED == 0:
            print(f"{counts['pairs']:,} pairs, {counts['wrong']} wrong", flush=True)
    print(f"\n{total:,} pairs, seed {seed}, {time.perf_counter() - began:.0f} s")
    for name, count in sorted(counts.items()):
        print(f"  {name}: {count:,}")
    for pair in wrong[:5]:
        print([array.tolist() for array in pair])
    return len(wrong)


def main() -> int:
    """Prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--largest", type=int, default=10**6)
    parser.add_argument("--pairs", type=int, default=0, help="only compare this many pairs with exact arithmetic")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--output", type=Path, metavar="FILE", help="write the rows as JSON")
    options = parser.parse_args()
    if options.pairs:
        return 1 if compare(options.pairs, options.seed) else 0
    rows = [*(growth(options.largest) if options.largest else []), *against_shapely()]
    if options.output:
        write_record(options.output, rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
