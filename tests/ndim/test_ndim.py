"""Any dimension: verdicts against a linear program and integers, certificates, trees against scans, bad input."""

import itertools
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from ndim_pairs import both_kinds, box, box_halfspaces, depth, near_poses, random_body, random_pose

import plannercheck as pc
from plannercheck import ndim
from plannercheck.bodies import exact_reference as exact_in_space
from plannercheck.ndim import pair as pair_module
from plannercheck.ndim.qhull import convex_hull
from plannercheck.ndim.tree import Cones, Tree

METHODS = ("auto", "tree", "oracle", "exact")


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
    for _ in range(6 if d < 5 else 2):
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
    shared, bodies = 0, 8 if d < 6 else 3
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


@pytest.mark.parametrize(("d", "n", "sizes"), SMALL_NETS[:4])
def test_the_walk_alone_is_right(d, n, sizes, monkeypatch):
    """With small nets, so that it has levels to walk; rounds are at most the levels of both trees."""
    monkeypatch.setattr("plannercheck.ndim.tree.default_sizes", lambda _: sizes)
    monkeypatch.setattr("plannercheck.ndim.bodies.default_sizes", lambda _: sizes)
    rng = np.random.default_rng(d)
    P, R = (ndim.Polytope(rng.normal(size=(n if d < 5 else d + 6, d)), memory=8 << 20) for _ in range(2))
    longest, shares = 0, set()
    for distance in np.linspace(0.2, 6, 12 if d < 5 else 6):
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
        ([[1.0, 0], [-1, 0], [0, 1], [0, -1]], [[1.0, 1, 1, 1], [2.0, 2, 2, 2]], r"as many offsets, not \(2, 4\)"),
        ([[1.0, 0]], "a", "offsets b .* must be numbers"),
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
        (np.eye(4) * (1 + 1j), "no real numbers"),
        ((np.eye(3), ["0", "0", "0"]), "no real numbers"),
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
    with pytest.raises(pc.PlannercheckError, match="no real numbers"):
        ndim.Polytope(np.ones((4, 3)) * 1j)
    with pytest.raises(pc.PlannercheckError, match=r"must be an ndim\.Polytope, not \[\[0"):
        ndim.intersects(cube, [[0, 0, 0]])
    with pytest.raises(pc.PlannercheckError, match=r"must be an ndim\.Polytope, not None"):
        ndim.overlap_graph([cube, None])


def test_a_body_says_of_what_it_is_made():
    assert repr(ndim.Polytope(box([0, 0], [1, 1]))) == "Polytope('polytope', dimension 2, 4 points)"
    walls = ndim.Polytope.from_halfspaces(np.vstack([np.eye(2), -np.eye(2)]), np.ones(4), name="walls")
    assert repr(walls) == "Polytope('walls', dimension 2, 4 halfspaces)"
