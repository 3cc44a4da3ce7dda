"""Any dimension: verdicts against a linear program and integers, proofs against fractions, trees against scans."""

from __future__ import annotations

import itertools
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from ndim_pairs import depth, near_poses, random_body, random_pose
from scipy.optimize import linprog
from scipy.spatial import ConvexHull

import plannercheck as pc
from plannercheck import ndim
from plannercheck.bodies import exact_reference as exact_in_space
from plannercheck.ndim import pair as pair_module
from plannercheck.ndim.exact import ExactSharedPoint, Guess, decide
from plannercheck.ndim.filters import encloses_origin, proves_inside
from plannercheck.ndim.guides import Hint
from plannercheck.ndim.integers import Farkas, Mix, dot, inverse, solve
from plannercheck.ndim.posed import ExactRows, ExactVertices
from plannercheck.ndim.poses import Affine, identity
from plannercheck.ndim.proofs import proves_shared
from plannercheck.ndim.qhull import convex_hull
from plannercheck.ndim.tree import Cones, Tree

METHODS = ("auto", "tree", "oracle", "exact")


def box(low, high):
    return np.array(list(itertools.product(*zip(low, high, strict=True))), dtype=np.float64)


def box_halfspaces(low, high):
    d = len(low)
    return np.concatenate([np.eye(d), -np.eye(d)]), np.concatenate([high, -np.asarray(low)])


def both_kinds(low, high):
    return ndim.Polytope(box(low, high)), ndim.Polytope.from_halfspaces(*box_halfspaces(low, high))


@pytest.mark.parametrize("d", range(1, 8))
def test_touching_boxes_share_a_point_and_the_next_double_does_not(d):
    for P, R in itertools.product(both_kinds(np.zeros(d), np.ones(d)), both_kinds(np.full(d, -1.0), np.zeros(d))):
        for method in METHODS if d <= 4 else ("oracle",):
            assert ndim.intersects(P, R, method=method)
            shift = np.zeros(d)
            shift[-1] = -5e-324
            assert not ndim.intersects(P, R, None, (np.eye(d), shift), method=method)


@pytest.mark.parametrize("d", range(2, 7))
def test_random_pairs_against_a_linear_program(d):
    rng = np.random.default_rng(d)
    for _ in range(8 if d < 5 else 4):
        first, second = random_body(rng, d), random_body(rng, d)
        for _ in range(3):
            poses = random_pose(rng, d, rng.uniform(0, 3), affine=True), random_pose(rng, d, rng.uniform(0, 1))
            clear = depth(first, second, *poses)
            if abs(clear) < 1e-5:
                continue
            for method in METHODS:
                assert ndim.intersects(first.polytope, second.polytope, *poses, method=method) == (clear > 0)


@pytest.mark.parametrize("d", range(2, 7))
def test_near_pairs_against_fractions(d):
    """Every method gives the verdict whose certificate fractions confirm, in both orders."""
    rng = np.random.default_rng(100 + d)
    shared, bodies = 0, 12 if d < 6 else 4
    for _ in range(bodies):
        first, second = random_body(rng, d), random_body(rng, d)
        pose_p, pose_r = near_poses(rng, first, second, d)
        certificate = ndim.certify(first.polytope, second.polytope, pose_p, pose_r, method="exact")
        assert certificate.verify()
        shared += certificate.shares
        for method in METHODS:
            assert ndim.intersects(first.polytope, second.polytope, pose_p, pose_r, method=method) == certificate.shares
            assert ndim.intersects(second.polytope, first.polytope, pose_r, pose_p, method=method) == certificate.shares
    assert 0 < shared < bodies


def test_in_space_the_verdicts_are_those_of_the_core():
    rng = np.random.default_rng(3)
    for _ in range(30):
        first, second = random_body(rng, 3, kinds=("points",)), random_body(rng, 3, kinds=("points",))
        poses = []
        for matrix, shift in near_poses(rng, first, second, 3):
            if np.linalg.det(matrix) < 0:
                matrix = matrix[:, [1, 0, 2]]
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = matrix, shift
            poses.append(pose)
        here = ndim.intersects(first.polytope, second.polytope, *poses)
        assert here == pc.intersects(pc.Polytope(first.points), pc.Polytope(second.points), *poses)
        assert here == exact_in_space.intersects(first.points, second.points, *poses)


@pytest.mark.parametrize("d", [2, 4, 6])
def test_flat_bodies_segments_and_points(d):
    origin, far = np.zeros((1, d)), np.full((1, d), 2.0)
    segment = np.array([-np.ones(d), np.ones(d)])
    plate = box([-1.0] * (d - 1) + [0.0], [1.0] * (d - 1) + [0.0])
    cube = box([-0.5] * d, [0.5] * d)
    bodies = [ndim.Polytope(points) for points in (origin, segment, plate, cube)]
    for P, R in itertools.product(bodies, bodies):
        for method in METHODS:
            assert ndim.intersects(P, R, method=method)
            assert not ndim.intersects(P, ndim.Polytope(far), method=method)
        assert ndim.certify(P, R).verify()
    flat = ndim.Polytope.from_halfspaces(*box_halfspaces([-1.0] * (d - 1) + [0.0], [1.0] * (d - 1) + [0.0]))
    assert not flat.has_inside
    for P in bodies:
        assert ndim.intersects(P, flat)
        assert not ndim.intersects(flat, P, None, (np.eye(d), np.eye(d)[-1] * 3))
    assert "volume" in bodies[2].tree_note
    effort = ndim.verdict(bodies[2], bodies[3], method="tree")[1]
    assert effort.method == "oracle"
    assert "volume" in effort.note


def test_corners_that_are_no_doubles_count_as_the_halfspaces_say():
    """x ≥ 0 and 3 x ≤ 1: the end is a third, which no double is; points beside it tell."""
    third = ndim.Polytope.from_halfspaces([[3.0, 0], [-1, 0], [0, 1], [0, -1]], [1.0, 0, 1, 0])
    below = float(np.nextafter(1 / 3, 0)) if Fraction(1 / 3) > Fraction(1, 3) else 1 / 3
    above = float(np.nextafter(below, 1))
    assert ndim.intersects(ndim.Polytope([[below, 0.5]]), third)
    assert not ndim.intersects(ndim.Polytope([[above, 0.5]]), third)
    right = ndim.Polytope.from_halfspaces([[-3.0, 0], [1, 0], [0, 1], [0, -1]], [-1.0, 1, 1, 0])
    for method in METHODS:
        assert ndim.intersects(third, right, method=method)
        assert not ndim.intersects(third, right, None, (np.eye(2), [1e-300, 0]), method=method)


def test_certificates_are_refused_when_they_are_changed():
    P, R = (
        ndim.Polytope(box([0, 0, 0, 0], [1, 1, 1, 1])),
        ndim.Polytope.from_halfspaces(*box_halfspaces([2.0] * 4, [3.0] * 4)),
    )
    apart = ndim.certify(P, R)
    assert isinstance(apart, ndim.Separation)
    assert apart.verify()
    assert apart.gap == pytest.approx(2.0, rel=0.6)
    assert not replace(apart, exact_offset=apart.exact_offset * 3).verify()
    assert not replace(apart, gap=apart.gap * 4).verify()
    assert not replace(apart, multipliers=({}, {})).verify()
    shared = ndim.certify(P, R, (np.eye(4), np.full(4, 1.5)))
    assert isinstance(shared, ndim.SharedPoint)
    assert shared.verify()
    moved = (shared.exact_point[0] + Fraction(1, 10**9), *shared.exact_point[1:])
    assert not replace(shared, exact_point=moved).verify()
    assert not replace(shared, weights=({}, {})).verify()


def test_the_trail_of_a_separation_keeps_the_second_body_on_its_side():
    rng = np.random.default_rng(0)
    P, R = (ndim.Polytope(rng.normal(size=(200, 2))) for _ in range(2))
    for _ in range(20):
        pose = random_pose(rng, 2, 8.0)
        certificate = ndim.certify(P, R, pose, method="tree")
        assert certificate.verify()
        if isinstance(certificate, ndim.Separation):
            normals, offsets = certificate.hyperplanes[:, :-1], certificate.hyperplanes[:, -1]
            assert 1 <= len(normals) <= P.tree.depth
            assert (R.vertices @ normals.T <= offsets + 1e-9).all()


SMALL_NETS = [(2, 60, (6, 8)), (3, 60, (10, 12)), (4, 60, (16, 20)), (5, 30, (14, 18)), (6, 22, (14, 16))]


@pytest.mark.parametrize(("d", "n", "sizes"), SMALL_NETS)
def test_trees_find_extreme_vertices(d, n, sizes):
    rng = np.random.default_rng(d)
    points = rng.normal(size=(n, d))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    tree = Tree(points, convex_hull(points).simplices, 4 << 20, sizes)
    assert tree.depth > 1
    assert d < 4 or any(isinstance(child, Cones) for child in tree.nodes[0].children)
    for normal in rng.normal(size=(100, d)):
        best, nodes, visited = tree.extreme(normal)
        assert points[best] @ normal == pytest.approx((points @ normal).max(), abs=1e-9)
        assert nodes <= tree.depth
        assert visited >= len(tree.nodes[0].net)


@pytest.mark.parametrize(("d", "n", "sizes"), SMALL_NETS)
def test_the_walk_alone_is_right(d, n, sizes, monkeypatch):
    """With small nets, so that it has levels to walk; rounds are at most the levels of both trees."""
    monkeypatch.setattr("plannercheck.ndim.tree.default_sizes", lambda _: sizes)
    monkeypatch.setattr("plannercheck.ndim.bodies.default_sizes", lambda _: sizes)
    rng = np.random.default_rng(d)
    P, R = (ndim.Polytope(rng.normal(size=(n if d < 5 else d + 6, d)), memory=8 << 20) for _ in range(2))
    longest, shares = 0, set()
    for distance in np.linspace(0.2, 6, 40 if d < 5 else 16):
        query = pair_module._Pair(P, R, random_pose(rng, d, distance), None, "tree")
        assert query.walked is not None
        assert query.walked.shares == ndim.intersects(P, R, (query.pose_p.matrix, query.pose_p.shift), method="oracle")
        assert query.walked.rounds <= P.tree.depth + R.polar_tree.depth
        longest = max(longest, query.walked.rounds)
        shares.add(query.walked.shares)
    assert longest > 1
    assert shares == {True, False}


def test_a_body_strictly_inside_another_meets_no_face_of_it():
    """The case that the text's pruning of faces leaves out."""
    rng = np.random.default_rng(0)
    large = ndim.Polytope(10 * rng.normal(size=(3000, 2)))
    small = ndim.Polytope(0.01 * rng.normal(size=(300, 2)))
    for shift in rng.normal(size=(20, 2)):
        query = pair_module._Pair(large, small, (np.eye(2), shift), None, "tree")
        assert query.walked is not None
        assert query.walked.shares
        assert query.walked.rounds == 0


def test_beyond_its_memory_a_body_takes_the_oracle_and_says_so():
    rng = np.random.default_rng(0)
    small, large = ndim.Polytope(rng.normal(size=(300, 4))), ndim.Polytope(rng.normal(size=(300, 4)), memory=10_000)
    assert not large.uses_tree
    assert "memory" in large.tree_note
    shares, effort = ndim.verdict(large, large, method="tree")
    assert shares
    assert effort.method == "oracle"
    assert "10000 bytes" in effort.note
    assert ndim.verdict(small, small)[1].method == "oracle"
    assert small.tree_bytes == 0


@pytest.mark.parametrize(
    ("A", "b", "words"),
    [
        ([[1.0, 0], [0, 1], [0, -1]], [1.0, 1, 1], r"unbounded.*ray \[-1.0, 0.0\]"),
        ([[1.0, 0], [-1, 0]], [1.0, 1], "unbounded.*ray"),
        ([[1.0, 1e-9], [-1, 0], [0, 1]], [1.0, 1, 1], "unbounded.*ray"),
        ([[1.0, 0], [-1, 0], [0, 1], [0, -1]], [1.0, -2, 1, 1], "empty: no point is in all halfspaces"),
        ([[1.0, 0], [0, 1]], [1.0], "2 normals need as many offsets"),
        ([[np.nan, 0]], [1.0], "must be finite"),
    ],
)
def test_halfspaces_that_bound_no_polytope(A, b, words):
    with pytest.raises(pc.PlannercheckError, match=words):
        ndim.Polytope.from_halfspaces(A, b)


@pytest.mark.parametrize(
    ("pose", "words"),
    [
        (np.eye(3), r"\(3, 3\)"),
        ((np.eye(3), np.zeros(2)), r"\(3,\)"),
        ((np.zeros((3, 3)), np.zeros(3)), "singular"),
        ((np.full((3, 3), 0.1), np.zeros(3)), "singular"),
        ((np.eye(3), np.full(3, np.inf)), "NaN or infinity"),
        (np.ones((4, 4)), "last row"),
    ],
)
def test_poses_that_are_none(pose, words):
    cube = ndim.Polytope(box([0, 0, 0], [1, 1, 1]))
    with pytest.raises(pc.PlannercheckError, match=words):
        ndim.intersects(cube, cube, pose)


def test_other_errors():
    cube, square = ndim.Polytope(box([0, 0, 0], [1, 1, 1])), ndim.Polytope(box([0, 0], [1, 1]))
    with pytest.raises(pc.PlannercheckError, match="dimension 3 and polytope 2"):
        ndim.intersects(cube, square)
    with pytest.raises(pc.PlannercheckError, match="unknown method 'orcale': did you mean 'oracle'"):
        ndim.intersects(cube, cube, method="orcale")
    with pytest.raises(pc.PlannercheckError, match="one is expected"):
        ndim.overlap_graph([cube, square])
    with pytest.raises(pc.PlannercheckError, match="at least one row"):
        ndim.Polytope(np.zeros((0, 3)))


def test_overlap_graph_against_all_pairs():
    rng = np.random.default_rng(0)
    regions = []
    for _ in range(25):
        low = rng.integers(0, 6, size=3).astype(np.float64)
        regions.append(both_kinds(low, low + rng.integers(1, 3, size=3))[int(rng.integers(2))])
    graph = ndim.overlap_graph(regions)
    truth = [
        (i, j)
        for i, j in itertools.combinations(range(len(regions)), 2)
        if ndim.intersects(regions[i], regions[j], method="exact")
    ]
    assert graph.edges.tolist() == [list(edge) for edge in truth]
    assert graph.tested + graph.skipped == 300
    assert graph.tested >= len(truth) > 0
    path = graph.path(*truth[0])
    assert path == list(truth[0])
    assert graph.path(3, 3) == [3]
    assert ndim.overlap_graph([]).edges.shape == (0, 2)


def test_swept_bodies_in_space_time():
    """Two boxes that pass each other: their sweeps in (x, y, z, t) meet exactly if the boxes ever do."""
    cube = box([0, 0, 0], [1, 1, 1])

    def sweep(start, end):
        return ndim.sweeps(cube, [start, end], [0.0, 1.0])[0]

    first = sweep([0.0, 0, 0], [4.0, 0, 0])
    # Crosses the same space, later; meets it; touches it with an edge at one moment.
    assert not ndim.intersects(first, sweep([2.0, -8, 0], [2.0, 0, 0]))
    assert ndim.intersects(first, sweep([2.0, -2, 0], [2.0, 2, 0]))
    assert ndim.intersects(first, sweep([2.0, -1, 0], [2.0, -1, 0]))
    assert not ndim.intersects(first, sweep([2.0, np.nextafter(-1, -2), 0], [2.0, np.nextafter(-1, -2), 0]))


def test_sweeps_against_moments():
    """Bodies on paths of three pieces: no moment collides where no sweeps meet, and a common point says where."""
    rng = np.random.default_rng(0)
    bodies = [rng.normal(size=(8, 3)) for _ in range(2)]
    in_space = [pc.Polytope(points) for points in bodies]
    times, met = np.array([0.0, 1.0, 2.5, 3.0]), 0

    def poses(waypoints, moments):
        matrices = np.tile(np.eye(4), (len(moments), 1, 1))
        matrices[:, :3, 3] = np.column_stack([np.interp(moments, times, column) for column in waypoints.T])
        return matrices

    for _ in range(15):
        ways = [3.0 * rng.normal(size=(4, 3)) for _ in range(2)]
        first, second = (ndim.sweeps(points, way, times) for points, way in zip(bodies, ways, strict=True))
        certificates = [ndim.certify(a, b) for a, b in zip(first, second, strict=True)]
        for k, certificate in enumerate(certificates):
            if certificate.shares:
                moments = certificate.point[3:]
                assert times[k] <= moments[0] <= times[k + 1]
            else:
                moments = np.linspace(times[k], times[k + 1], 20)
            for pair in zip(*(poses(way, moments) for way in ways), strict=True):
                # The moment is rounded, so bodies that only touch may be a rounding apart.
                apart = pc.distance(*in_space, *pair).distance
                assert apart <= 1e-12 if certificate.shares else not pc.intersects(*in_space, *pair)
        met += any(certificate.shares for certificate in certificates)
    assert 0 < met < 15


@pytest.mark.parametrize(
    ("waypoints", "times", "words"),
    [
        ([[0.0, 0, 0]], [0.0], "at least two waypoints"),
        ([[0.0, 0], [1, 1]], [0.0, 1], "at least two waypoints"),
        ([[0.0, 0, 0], [1, 1, 1]], [0.0, 0], "ascending"),
    ],
)
def test_paths_that_are_none(waypoints, times, words):
    with pytest.raises(pc.PlannercheckError, match=words):
        ndim.sweeps(box([0, 0, 0], [1, 1, 1]), waypoints, times)


def test_systems_in_integers_against_a_linear_program():
    rng = np.random.default_rng(0)
    unsolved = 0
    for _ in range(100):
        height, width = int(rng.integers(1, 6)), int(rng.integers(1, 10))
        columns = rng.integers(-3, 4, size=(width, height))
        right = rng.integers(-3, 4, size=height)
        answer = solve(columns.tolist(), right.tolist())
        feasible = linprog(np.zeros(width), A_eq=columns.T, b_eq=right, bounds=(0, None)).status == 0
        assert isinstance(answer, Mix) == feasible
        if isinstance(answer, Mix):
            assert all(w > 0 for w in answer.weights.values())
            mixed = sum(w * columns[k].astype(object) for k, w in answer.weights.items())
            assert list(np.broadcast_to(mixed, height)) == [answer.denominator * int(x) for x in right]
        else:
            assert isinstance(answer, Farkas)
            unsolved += 1
            assert max(dot(answer.row, column) for column in columns.tolist()) <= 0 < dot(answer.row, right.tolist())
    assert 0 < unsolved < 100


def test_inverses_in_integers():
    assert inverse([[1, 2], [2, 4]]) is None
    scaled, denominator = inverse([[0, 2], [-3, 1]])
    assert (np.array([[0, 2], [-3, 1]]) @ np.array(scaled) == denominator * np.eye(2, dtype=int)).all()
    assert denominator > 0


def test_hulls_of_halfspaces_and_points_agree():
    rng = np.random.default_rng(0)
    points = rng.normal(size=(40, 4))
    hull = ConvexHull(points)
    body = ndim.Polytope.from_halfspaces(hull.equations[:, :-1], -hull.equations[:, -1])
    assert len(body.points) == len(hull.vertices)
    assert (body.points >= body.box[0] - 1e-12).all()
    assert (body.points <= body.box[1] + 1e-12).all()
    np.testing.assert_allclose(body.box, [points.min(axis=0), points.max(axis=0)], atol=1e-9)


@pytest.mark.parametrize("dimension", [2, 3, 4])
def test_any_guess_decides_what_touches(dimension):
    """Boxes that share a corner, an edge or a face, from any two vertices, or halfspaces, as the guess."""
    corners = np.array(list(itertools.product((0.0, 1.0), repeat=dimension)))
    normals = np.vstack([np.eye(dimension), -np.eye(dimension)])
    offsets = np.repeat([1.0, 0.0], dimension)
    for along in range(1, dimension + 1):
        shift = np.where(np.arange(dimension) < along, 1.0, 0.5)
        still, moved = identity(dimension), Affine(np.eye(dimension), shift, False)
        for kinds in itertools.product("vr", repeat=2):
            sizes = [2**dimension if kind == "v" else 2 * dimension for kind in kinds]
            for guess in itertools.islice(itertools.product(*map(range, sizes)), 0, None, 3):
                bodies = [
                    ExactVertices(corners, pose) if kind == "v" else ExactRows(normals, offsets, pose)
                    for kind, pose in zip(kinds, (still, moved), strict=True)
                ]
                found, _ = decide(*bodies, Guess((guess[0],), (guess[1],)))
                assert isinstance(found, ExactSharedPoint)
                point = [Fraction(x, found.denominator) * Fraction(2) ** bodies[0].unit for x in found.point]
                for x, s in zip(point, shift.tolist(), strict=True):
                    assert max(0, Fraction(s)) <= x <= 1


@pytest.mark.parametrize("dimension", [2, 3, 4, 6])
def test_what_rounding_may_move_out_is_not_enclosed(dimension):
    """A simplex with a face nearer to the origin than what its corners may be off is not proved to hold it."""
    rng = np.random.default_rng(dimension)
    rounding = np.full(dimension, 2.0)
    for _ in range(40):
        corners = np.vstack([-np.eye(dimension), np.ones(dimension)]) + rng.uniform(
            -0.1, 0.1, (dimension + 1, dimension)
        )
        turn = np.linalg.qr(rng.normal(size=(dimension, dimension)))[0]
        corners = corners - corners[:-1].mean(axis=0)  # the origin is on the face of all corners but the last
        for height, enclosed in ((1e-6, True), (1e-16, False), (0.0, False), (-1e-6, False)):
            moved = (corners - height * corners[-1]) @ turn
            assert encloses_origin(moved, rounding) == enclosed


@pytest.mark.parametrize("dimension", [2, 3, 5])
def test_a_point_is_proved_inside_only_where_rounding_leaves_it(dimension):
    """A turned box, and points just within and beyond its faces, some of them moved by an error."""
    rng = np.random.default_rng(dimension)
    normals, offsets = np.vstack([np.eye(dimension), -np.eye(dimension)]), np.repeat([1.0, 1.0], dimension)
    none = np.zeros(dimension)
    for _ in range(30):
        turn = np.linalg.qr(rng.normal(size=(dimension, dimension)))[0]
        shift = rng.uniform(-3, 3, dimension)
        face = rng.uniform(-0.9, 0.9, dimension)
        for depth_below, proved in ((1e-9, True), (1e-16, False), (0.0, False), (-1e-9, False)):
            face[0] = 1 - depth_below
            point = turn @ face + shift
            assert proves_inside(normals, offsets, Affine(turn, shift, False), point, none) == proved
            assert proves_inside(normals, offsets, identity(dimension), face, none) == proved
            assert not proves_inside(normals, offsets, Affine(turn, shift, False), point, none + 1e-8)
        inside = turn @ (0.5 * face) + shift
        assert proves_inside(normals, offsets, Affine(turn, shift, False), inside, none + 1e-3)


@pytest.mark.parametrize("dimension", [2, 3, 5])
def test_a_mixture_is_proved_inside_only_where_posing_it_leaves_it(dimension):
    """An edge 1e6 from its own origin, which its pose brings near to a box: its middle, about on one of its faces."""
    rng = np.random.default_rng(dimension)
    host = ndim.Polytope.from_halfspaces(*box_halfspaces(-np.ones(dimension), np.ones(dimension)))
    proofs = []
    for number in range(300):
        ends = 1e6 * rng.normal(size=dimension) + rng.normal(size=(2, dimension))
        turn = np.linalg.qr(rng.normal(size=(dimension, dimension)))[0]
        middle = rng.uniform(-0.9, 0.9, dimension)
        middle[0] = 1 - (1e-6 if number % 10 == 0 else rng.uniform(-1e-10, 1e-10))
        pose = Affine(turn, middle - turn @ ends.mean(axis=0), False)
        hint = Hint(True, (0, 1), (), middle, {0: 0.5, 1: 0.5}, {}, {}, 1, 1, "oracle")
        proofs.append(proves_shared(hint, (ndim.Polytope(ends), pose), (host, identity(dimension))))
        mixed = [sum(map(Fraction, column)) / 2 for column in ends.T.tolist()]
        rows = [[Fraction(x) for x in (*row, s)] for row, s in zip(turn.tolist(), pose.shift.tolist(), strict=True)]
        place = [sum(m * x for m, x in zip(row[:-1], mixed, strict=True)) + row[-1] for row in rows]
        assert max(map(abs, place)) <= 1 or not proofs[-1], number
    assert all(proofs[::10])
    assert not all(proofs)
