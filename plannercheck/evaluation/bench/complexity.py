"""Rounds and visited vertices against n: the paper's three algorithms and their competitors.

In: a largest n and a number of queries. Out: a row for each body, method and n, and the growth with n. Each body is
tested against a copy of itself near contact, at gaps of 1 and 0.1 mm for bodies of about 1 m, apart and overlapping.
Work is counted, not timed.

A visited vertex is one whose product with a direction is formed, or that takes part in a game or in a closest pair of
constant size. The core counts blocks of four vertices, and games of at most 10 against 10. Dobkin and Kirkpatrick's
walk of 1990 is our own, and scans the new neighbours of a vertex one after the other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from plannercheck import ndim, planar
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.tuning import Method, pair_options
from plannercheck.common.array_types import Floats
from plannercheck.common.core import core
from plannercheck.evaluation.bench import dobkin_kirkpatrick
from plannercheck.evaluation.bench.nearest_points import Support, share_a_point
from plannercheck.evaluation.stress import body_families as families
from plannercheck.evaluation.stress import contact_poses as contacts

# Of one query: rounds and visited vertices.
Count = tuple[int, int]

# m.
GAPS = np.array([1e-3, -1e-3, 1e-4, -1e-4])
SIZES = (100, 300, 1000, 3000, 10_000)
# Random bodies, and those with vertices or facets of large degree, where a scan of neighbours is linear.
SPACE_FAMILIES = ("round", "prism", "cone", "doubling")
# Bodies of the hierarchical trees, and their dimensions. Random ones: preparation in more dimensions takes minutes.
TREE_DIMENSIONS = (2, 3)
# As in cpp: vertices of a block, and at most of a game's two sides together.
_BLOCK, _GAME = 4, 20
# Part of a polygon's vertices that the adversarial one has within `_NARROW` rad.
_CROWDED, _NARROW = 0.9, 0.05


@dataclass(frozen=True)
class ComplexityRow:
    """The vertices that one method visits on bodies of one size.

    Attributes:
        where: "space", "plane", or "trees, d = 2" and so on.
        family: Family of the bodies.
        method: How they were tested.
        vertices: Number of vertices of each body.
        queries: Number of queries.
        rounds_mean: Mean of the method's own rounds: levels, games or supports.
        rounds_worst: The largest number of these rounds.
        visited_mean: Mean number of visited vertices.
        visited_worst: The largest number of visited vertices.
        shared: How many pairs share a point, by this method.
    """

    where: str
    family: str
    method: str
    vertices: int
    queries: int
    rounds_mean: float
    rounds_worst: int
    visited_mean: float
    visited_worst: int
    shared: int


@dataclass(frozen=True)
class GrowthRow:
    """How a method grows with n: least squares over all sizes.

    Attributes:
        where: As in `ComplexityRow`.
        family: As in `ComplexityRow`.
        method: As in `ComplexityRow`.
        per_doubling: Visited vertices (mean) that each doubling of n adds: the slope against log2 n.
        exponent: Exponent of a power law through the means: 0 is a constant, 1 is linear.
        exponent_worst: The same through the worst of each size.
    """

    where: str
    family: str
    method: str
    per_doubling: float
    exponent: float
    exponent_worst: float


def measure(
    most: int, queries: int, seed: int = 0, progress: Callable[[str], None] = lambda text: None
) -> Iterator[ComplexityRow]:
    """Counts everything for up to `most` vertices, with so many queries of each body and size."""
    sizes = [n for n in SIZES if n <= most] or [most]
    for n in sizes:
        for name in SPACE_FAMILIES:
            progress(f"{n:,} vertices, space, {name}")
            yield from _in_space(name, n, queries, seed)
        for name in ("ellipse", "crowded"):
            yield from _in_the_plane(name, n, queries, seed)
        for d in TREE_DIMENSIONS:
            progress(f"{n:,} vertices, trees, d = {d}")
            yield from _in_trees(d, n, queries, seed)


def growth(rows: Sequence[ComplexityRow]) -> list[GrowthRow]:
    """Fits the growth of each method on each family: a row for each that was measured at two sizes or more."""
    curves: dict[tuple[str, str, str], list[ComplexityRow]] = {}
    for row in rows:
        curves.setdefault((row.where, row.family, row.method), []).append(row)
    return [_fitted(key, curve) for key, curve in curves.items() if len({row.vertices for row in curve}) > 1]


def _fitted(key: tuple[str, str, str], curve: Sequence[ComplexityRow]) -> GrowthRow:
    sizes = np.log2([row.vertices for row in curve])
    mean, worst = (np.array(counts) for counts in zip(*((r.visited_mean, r.visited_worst) for r in curve), strict=True))
    slopes = [float(np.polyfit(sizes, counts, 1)[0]) for counts in (mean, np.log2(mean), np.log2(worst))]
    return GrowthRow(*key, *slopes)


def _row(where: str, family: str, method: str, n: int, found: Sequence[tuple[bool, Count]]) -> ComplexityRow:
    rounds, visited = np.array([count for _, count in found]).T
    shared = sum(bool(verdict) for verdict, _ in found)
    spread = float(rounds.mean()), int(rounds.max()), float(visited.mean()), int(visited.max())
    return ComplexityRow(where, family, method, n, len(found), *spread, shared)


def _gaps(queries: int) -> Floats:
    return np.resize(GAPS, queries)


def _in_space(name: str, size: int, queries: int, seed: int) -> Iterator[ComplexityRow]:
    body = Polytope(families.family(name, size, seed)).without_cells()
    solid = contacts.Solid(name, body.vertices, body.faces.astype(np.int64))
    poses = list(zip(*contacts.contact_poses(solid, solid, _gaps(queries), np.random.default_rng(seed)), strict=True))
    levelled = dobkin_kirkpatrick.LevelledBody(body)

    def dobkin(pose_p: Floats, pose_r: Floats) -> tuple[bool, Count]:
        walked = dobkin_kirkpatrick.walk(levelled, levelled, pose_p, pose_r)
        return walked.shared, (walked.rounds, walked.visited)

    methods: dict[str, Callable[[Floats, Floats], tuple[bool, Count]]] = {
        "coupled walk": lambda p, r: _of_core(body, p, r, "walk"),
        "double oracle": lambda p, r: _of_core(body, p, r, "oracle"),
        "GJK on the hierarchies": lambda p, r: _gjk(body, p, r),
        "Dobkin and Kirkpatrick 1990": dobkin,
    }
    n = len(body.vertices)
    verdicts: list[bool] = []
    for method, ask in methods.items():
        found = [ask(p, r) for p, r in poses]
        verdicts = verdicts or [shared for shared, _ in found]
        yield _row("space", name, method, n, found)
    yield _brute_force("space", name, n, verdicts)


def _brute_force(where: str, family: str, n: int, verdicts: Sequence[bool]) -> ComplexityRow:
    """What one plane takes to check by a scan of both bodies; to find it takes more. Verdicts are another method's."""
    return _row(where, family, "brute force", n, [(shared, (1, 2 * n)) for shared in verdicts])


def _of_core(body: Polytope, pose_p: Floats, pose_r: Floats, method: Method) -> tuple[bool, Count]:
    """A solver alone; what it leaves undecided goes to exact arithmetic, which is not counted."""
    options = pair_options(method, cached_plane=False, centre_axis=False, nearest_points=False, double_double=False)
    verdicts, _, counters = core.intersect_batch(body.core, pose_p[None], body.core, pose_r[None], options)
    visited = _BLOCK * counters["blocks"] + _GAME * counters["games"]
    return bool(verdicts[0]), (counters["rounds"], visited)


def _gjk(body: Polytope, pose_p: Floats, pose_r: Floats) -> tuple[bool, Count]:
    blocks = 0

    def support(pose: Floats) -> Support:
        def furthest(direction: Floats) -> Floats:
            nonlocal blocks
            vertices, visited = body.core.extremes((direction @ pose[:3, :3])[None], False)
            blocks += int(visited[0])
            return np.asarray(pose[:3, :3] @ body.vertices[vertices[0]] + pose[:3, 3])

        return furthest

    shared, rounds = share_a_point(support(pose_p), support(pose_r), pose_p[:3, 3] - pose_r[:3, 3])
    return shared, (rounds, _BLOCK * blocks)


def polygon(name: str, n: int) -> Floats:
    """A convex polygon (n, 2) about 2 m across, counter-clockwise.

    "ellipse", or "crowded": nearly all vertices of a circle in a narrow angle.
    """
    if name == "ellipse":
        angles = 2 * np.pi * np.arange(n) / n
        return np.column_stack([np.cos(angles), 0.7 * np.sin(angles)])
    near = int(_CROWDED * n)
    angles = np.concatenate(
        [np.linspace(0, _NARROW, near, endpoint=False), np.linspace(_NARROW, 2 * np.pi, n - near, endpoint=False)]
    )
    return np.column_stack([np.cos(angles), np.sin(angles)])


def _in_the_plane(name: str, n: int, queries: int, seed: int) -> Iterator[ComplexityRow]:
    rng = np.random.default_rng(seed)
    vertices = polygon(name, n)
    fixed, moved = rng.integers(n, size=(2, queries))
    normals = _vertex_normals(vertices)
    poses = np.tile(np.eye(3), (queries, 1, 1))
    for pose, gap, a, b in zip(poses, _gaps(queries), fixed, moved, strict=True):
        pose[:2, :2] = _turn(-normals[b], normals[a])
        pose[:2, 2] = vertices[a] + gap * normals[a] - pose[:2, :2] @ vertices[b]
    counts = planar.count_batch(vertices, vertices, None, poses)
    found = zip(counts.shared, zip(counts.rounds, counts.vertices, strict=True), strict=True)
    yield _row("plane", name, "planar walk", n, [(bool(shared), (int(r), int(v))) for shared, (r, v) in found])
    yield _brute_force("plane", name, n, counts.shared.tolist())


def _vertex_normals(vertices: Floats) -> Floats:
    """Unit vectors (n, 2) halfway between the normals of the two sides at each vertex."""
    sides = np.roll(vertices, -1, axis=0) - vertices
    normals = contacts.unit(np.column_stack([sides[:, 1], -sides[:, 0]]))
    return contacts.unit(normals + np.roll(normals, 1, axis=0))


def _turn(source: Floats, target: Floats) -> Floats:
    """The rotation (2, 2) that takes one unit vector to another."""
    cos, sin = source @ target, source[0] * target[1] - source[1] * target[0]
    return np.array([[cos, -sin], [sin, cos]])


def _in_trees(d: int, n: int, queries: int, seed: int) -> Iterator[ComplexityRow]:
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(n, d))
    points = 0.5 * points / np.linalg.norm(points, axis=1)[:, None]
    body = ndim.Polytope(points)
    found = []
    for gap in _gaps(queries):
        normal = rng.normal(size=d)
        normal /= np.linalg.norm(normal)
        highest, lowest = points[np.argmax(points @ normal)], points[np.argmin(points @ normal)]
        pose = np.eye(d), highest - lowest + gap * normal
        shared, effort = ndim.verdict(body, body, pose, method="tree")
        found.append((shared, (effort.rounds, effort.visited)))
    where = f"trees, d = {d}"
    yield _row(where, "round", "walk down the trees", n, found)
    yield _brute_force(where, "round", n, [shared for shared, _ in found])
