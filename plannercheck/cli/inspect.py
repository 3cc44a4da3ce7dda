"""`plannercheck inspect`: bodies and pairs of a robot in a scene, and the cost of checking them."""

from __future__ import annotations

import argparse
import time
import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np

from plannercheck import planar
from plannercheck.bodies.height_fields import HeightField
from plannercheck.bodies.hull_excess import largest_filling
from plannercheck.bodies.part_sets import PartSet
from plannercheck.bodies.pieces import polytope_volume
from plannercheck.bodies.point_clouds import PointCloud
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import GeometryObject, Hull, Shape
from plannercheck.bodies.solids import Solid
from plannercheck.bodies.triangle_meshes import TriangleMesh
from plannercheck.checking.input_hints import always_hint
from plannercheck.cli.common import (
    add_checker_arguments,
    load_checker,
    percentage,
    table,
)
from plannercheck.cli.inspect_geometry import show_geometries
from plannercheck.cli.inspect_meshes import mesh_files, show_meshes, triangle_meshes
from plannercheck.cli.inspect_summary import show_summary
from plannercheck.cli.robot_options import described
from plannercheck.common.errors import PlannercheckError
from plannercheck.motions.checker import Checker

# What sets are of, if not of cells.
_PARTS: dict[type[PartSet], str] = {PointCloud: "points", HeightField: "triangles"}

# What settles pairs, and how.
STAGES = {
    "pairs": "all pairs of the table",
    "unreachable": "apart at all states within the joint limits, by proof",
    "bounds": "apart: cells of two joints, bounding balls, or the tree of obstacles",
    "overlaps": "in collision: balls or boxes inside both bodies",
    "boxes": "apart along an axis of a bounding box",
    "skipped": "not tested, since another pair of the configuration collides",
    "cached_plane": "apart by the plane that separated them last",
    "box_face": "apart along the normal of a face of a bounding box",
    "centre_axis": "apart along the line between their centres",
    "trees": "of solids: their trees of triangles, before their hulls were tested",
    "solver": "search for a separating plane or a common point, in doubles",
    "nearest_points": "nearest points (GJK), in doubles",
    "double_double": "the same in double-double arithmetic",
    "exact": "exact arithmetic, where rounding leaves the sign open",
    "tests": "polygons tested",
}
# Counters of the pair test, and what they count.
PAIR_TEST = {
    "blocks": ("vertex blocks", "read on the way down a hierarchy, four vertices each"),
    "exact_comparisons": ("exact comparisons", "of vertices whose order doubles leave open"),
    "queries_a": ("support queries on A", "the vertex of the one body that is deepest beyond a plane"),
    "queries_b": ("support queries on B", "the facet of the other, in whose frame both are, that a point is beyond"),
    "games": ("matrix games", "of the vertices and facets found so far: the next plane and point"),
    "rounds": ("rounds", "steps of the search for a separating plane or a common point"),
    "vertices": ("vertices", "of polygons that were read"),
    "double_double": ("double-double", "signs that doubles leave open"),
    "exact": ("exact", "signs that double-double leaves open, too"),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds the command's options."""
    add_checker_arguments(parser)
    parser.add_argument(
        "--states", type=int, default=10_000, help="number of random configurations to check; default: 10000"
    )
    parser.add_argument(
        "--fidelity",
        action="store_true",
        help="also show how far hulls are from their meshes, and which share of states hulls, convex pieces and meshes "
        "leave valid",
    )
    parser.add_argument("--seed", type=int, default=0, help="seed of the random configurations; default: 0")


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    if options.states < 1 or options.seed < 0:
        raise PlannercheckError("--states must be at least 1 and --seed at least 0")
    began = time.perf_counter()
    checker = load_checker(options)
    prepared = time.perf_counter() - began
    assert isinstance(checker, Checker | planar.Checker)
    if options.fidelity and not isinstance(checker, Checker):
        raise PlannercheckError("--fidelity compares hulls with meshes, which planar robots do not have")
    q = checker.robot.random_configurations(options.states, options.seed)
    valid, statistics = show_summary(checker, q)
    print()
    if isinstance(checker, Checker):
        files = mesh_files(checker, described(options))
        meshes = triangle_meshes(files)
        _show_bodies(checker, meshes, prepared)
        show_meshes(checker, files)
        if options.fidelity:
            _show_fidelity(checker, meshes)
            show_geometries(options)
    else:
        _show_polygons(checker)
    _show_stages(statistics, len(q))
    if not valid and (hint := always_hint(checker, q)):
        warnings.warn(hint, RuntimeWarning, stacklevel=2)
    return 0


def _show_bodies(checker: Checker, meshes: dict[str, TriangleMesh], prepared: float) -> None:
    pairs = np.bincount(checker.pairs.ravel(), minlength=len(checker.bodies)).tolist()
    rows = []
    within = checker.prepared  # a body that no pair needs within the limits is prepared only now
    for body, polytope, late, count in zip(checker.bodies, within, checker.polytopes, pairs, strict=True):
        sizes: tuple[object, ...] = (0, 0, 0)
        if polytope is not None:
            numbers = polytope.statistics()
            sizes = *_counts(body.shape, numbers), numbers["bytes"] // 1024
        volumes = _volumes(late, meshes.get(body.name))
        rows.append((body.name, body.link or "(scene)", _geometry(checker, body), *sizes, count, *volumes))
    header = ("body", "link", "geometry", "vertices", "facets", "kB", "pairs", "radius m", "hull cm³", "mesh cm³")
    print(table((*header, "hull / mesh"), rows))
    total = sum({id(p): p.nbytes for p in within if p is not None}.values())
    print(f"prepared in {prepared:.2f} s; bodies take {total / 2**20:.1f} MB, equal shapes counted once")


def _counts(shape: Shape, numbers: Mapping[str, int]) -> tuple[object, object]:
    """Vertices and facets; of a set how many parts it is of, since it has neither."""
    if isinstance(shape, PartSet):
        return f"{shape.count:,} {_PARTS.get(type(shape), 'cells')}", "-"
    return numbers["vertices"], numbers["facets"]


def _geometry(checker: Checker, body: GeometryObject) -> str:
    """What verdicts take a body as."""
    shape = body.shape
    if isinstance(shape, Solid):
        if shape.equals_hull:
            return "solid (its hull)"
        return {"closed": "solid", "open": "surface (open)"}.get(shape.kind, f"solid ({shape.kind})")
    is_piece = body.name.rpartition("/")[0] in checker.robot.pieces
    return "piece" if is_piece else type(shape).__name__.lower()


def _show_fidelity(checker: Checker, meshes: dict[str, TriangleMesh]) -> None:
    """How far hulls are from meshes."""
    rows = []
    for body, polytope in zip(checker.bodies, checker.polytopes, strict=True):
        mesh = meshes.get(body.name)
        is_hull = isinstance(body.shape, Hull) and polytope is not None and polytope.dimension == 3
        if mesh is None or polytope is None or not is_hull or polytope.inflation_radius:
            continue
        ratio = f"{polytope_volume(polytope) / mesh.volume:.2f}" if mesh.volume else "-"
        rows.append((body.name, body.link or "(scene)", ratio, f"{1e3 * largest_filling(polytope, mesh):.1f}"))
    print()
    if rows:
        print(table(("hull", "link", "hull / mesh volume", "furthest from the mesh, mm"), rows))
    else:
        print("no body is the hull of a mesh, so there is no distance of hulls from meshes to show")


def _volumes(polytope: Polytope | None, mesh: TriangleMesh | None) -> tuple[str, str, str, str]:
    """Cells: the ball around a body's centre, the volumes of hull and mesh, how many times as large the hull is."""
    if polytope is None or polytope.half_space is not None:
        return "-", "-", "-", "-"
    middle = 0.5 * (polytope.vertices.min(axis=0) + polytope.vertices.max(axis=0))
    radius = float(np.linalg.norm(polytope.vertices - middle, axis=1).max()) + polytope.inflation_radius
    hull = polytope_volume(polytope) if polytope.dimension == 3 else 0.0
    is_hull = polytope.inflation_radius == 0.0 and polytope.parts is None  # a set's is the box around it
    of_hull = f"{1e6 * hull:.1f}" if is_hull else "-"
    if mesh is None or not mesh.volume:
        return f"{radius:.3f}", of_hull, "-", "-"
    return f"{radius:.3f}", of_hull, f"{1e6 * mesh.volume:.1f}", f"{hull / mesh.volume:.2f}"


def _show_polygons(checker: planar.Checker) -> None:
    pairs = np.bincount(checker.pairs.ravel(), minlength=len(checker.bodies)).tolist()
    links = checker.robot.link_names
    rows = [
        (body.name, "(scene)" if body.link < 0 else links[body.link], len(body.vertices), count)
        for body, count in zip(checker.bodies, pairs, strict=True)
    ]
    print(table(("body", "link", "vertices", "pairs"), rows))


def _show_stages(statistics: dict[str, Any], states: int) -> None:
    """What settled the pairs of random states."""
    queries = statistics.pop("queries")
    pairs = statistics["pairs"]
    settled = [
        (_words(name), STAGES.get(name, ""), n, f"{n / states:.2f}", percentage(n, pairs))
        for name, n in statistics.items()
    ]
    print(f"\n{table(('pairs settled by', 'what that is', 'pairs', 'a configuration', 'of all pairs'), settled[1:])}\n")
    tests = [(*PAIR_TEST.get(name, (_words(name), "")), n, f"{n / states:.2f}") for name, n in queries.items()]
    print(table(("pair test", "what that is", "number", "a configuration"), tests))


def _words(name: str) -> str:
    return name.replace("_", " ")
