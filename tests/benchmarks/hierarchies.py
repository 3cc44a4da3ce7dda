"""The logarithm, and what preparation costs: `python tests/benchmarks/hierarchies.py [--largest 100000]`.

For bodies of several families with 100 to 100,000 vertices: levels of both hierarchies, blocks of four vertices that
an extreme-vertex query visits, and blocks, rounds and games of the coupled walk on pairs near contact; the worst of
1,000 queries each. Then seconds and bytes a vertex of preparation, with the hull and with the hull given.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

import plannercheck as pc
from plannercheck.bodies.tuning import pair_options
from plannercheck.common.core import core
from plannercheck.evaluation.bench.records import write_record
from plannercheck.evaluation.stress import body_families as families
from plannercheck.evaluation.stress import contact_poses as contacts

FAMILIES = ("round", "cone", "prism", "doubling", "fan", "needle")
QUERIES = 1000
EXACT = 6  # the number of the stage in cpp/narrow_phase/pair_frame.hpp
GAPS = np.array([1e-3, -1e-3, 1e-6, -1e-6, 1e-1, -1e-1])


def directions(points: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Half of them random, half close to vertices, where the walk has most to tell apart."""
    towards = points[rng.integers(len(points), size=QUERIES // 2)]
    return np.concatenate([rng.normal(size=(QUERIES // 2, 3)), towards + 1e-3 * rng.normal(size=towards.shape)])


def worst_walk(body: pc.Polytope, name: str, rng: np.random.Generator) -> dict[str, int]:
    """The largest counters of the walk over pairs of the body with itself near contact, no other step in doubles.

    Pairs whose certificate is too close for its bound are decided exactly after the walk; `exact` counts them.
    """
    solid = contacts.Solid(name, body.vertices, body.faces)
    options = pair_options("walk", cached_plane=False, centre_axis=False, nearest_points=False)
    worst, exact = {"blocks": 0, "rounds": 0, "games": 0}, 0
    for _ in range(0, QUERIES, len(GAPS)):
        for a, b in zip(*contacts.contact_poses(solid, solid, GAPS, rng), strict=True):
            _, stages, counters = core.intersect_batch(body.core, a[None], body.core, b[None], options)
            worst = {key: max(worst[key], counters[key]) for key in worst}
            exact += int(stages[0] == EXACT)
    return {**worst, "exact": exact}


def show_logarithm(sizes: list[int]) -> list[dict[str, object]]:
    """Prints the table of levels, blocks, rounds and games, and gives its rows."""
    rows: list[dict[str, object]] = []
    print("Worst of 1,000; exact: how many pairs the walk left to exact arithmetic.")
    print("                      levels        blocks a query     coupled walk, near contact")
    print("family   vertices   hull  polar     hull  polar       blocks   rounds   games   exact")
    for name in FAMILIES:
        for size in sizes:
            rng = np.random.default_rng(0)
            body = pc.Polytope(families.family(name, size, 0)).without_cells()
            shape = body.statistics()
            asked = directions(body.vertices - body.centre, rng)
            hull, polar = (body.core.extremes(asked, of_polar)[1].max() for of_polar in (False, True))
            walk = worst_walk(body, name, rng)
            print(
                f"{name:8s} {len(body.vertices):8d}   {shape['inner']['levels']:4d}  {shape['polar']['levels']:5d}"
                f"     {hull:4d}  {polar:5d}       {walk['blocks']:6d}   {walk['rounds']:6d}   {walk['games']:5d}"
                f"   {walk['exact']:5d}",
                flush=True,
            )
            levels = {"hull_levels": shape["inner"]["levels"], "polar_levels": shape["polar"]["levels"]}
            asked_blocks = {"hull_blocks": hull, "polar_blocks": polar}
            named = {f"walk_{key}": value for key, value in walk.items()}
            rows.append({"family": name, "vertices": len(body.vertices), **levels, **asked_blocks, **named})
    return rows


def show_preparation(sizes: list[int]) -> list[dict[str, object]]:
    """Prints seconds and bytes a vertex for round bodies, and gives the rows."""
    rows: list[dict[str, object]] = []
    print("\nvertices   us a vertex   with the hull given   bytes a vertex")
    for size in (150, *sizes[1:]):
        points = families.family("round", size, 0)
        body = pc.Polytope(points)
        whole, given = [], []
        for _ in range(max(1, 20_000 // size)):
            start = time.perf_counter()
            pc.Polytope(points)
            whole.append(time.perf_counter() - start)
            start = time.perf_counter()
            core.Polytope.from_faces(body.vertices, body.faces, 0.0)
            given.append(time.perf_counter() - start)
        scale = 1e6 / size
        print(f"{size:8d}   {min(whole) * scale:11.1f}   {min(given) * scale:19.1f}   {body.nbytes / size:14.0f}")
        times = {"microseconds_a_vertex": min(whole) * scale, "hull_given": min(given) * scale}
        rows.append({"family": "preparation", "vertices": size, **times, "bytes_a_vertex": body.nbytes / size})
    return rows


def main() -> None:
    """Runs both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--largest", type=int, default=100_000, help="largest number of vertices")
    parser.add_argument("--output", type=Path, metavar="FILE", help="write the rows as JSON")
    options = parser.parse_args()
    sizes = [n for n in (100, 1000, 10_000, 100_000) if n <= options.largest]
    rows = [*show_logarithm(sizes), *show_preparation(sizes)]
    if options.output:
        write_record(options.output, rows)


if __name__ == "__main__":
    main()
