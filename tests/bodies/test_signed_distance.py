"""Signed distances: inside of their bounds by exact arithmetic, and points and directions as promised."""

import itertools

import numpy as np
import pytest
from poses import at, pose_at, pose_within

import plannercheck as pc
from plannercheck.bodies import exact_reference as exact
from plannercheck.evaluation.stress.body_families import family

CUBE = np.array(list(itertools.product((0.0, 1.0), repeat=3))) - 0.5
FAMILIES = [("box", 8), ("round", 20), ("cloud", 60), ("needle", 20), ("flat", 30)]


def lowest(body, pose, along):
    """The least height of an inflated body along a direction."""
    return float((body.vertices @ (pose[:3, :3].T @ along)).min() + pose[:3, 3] @ along) - body.inflation_radius


def assert_as_promised(found, first, second, poses):
    """Bounds, and a plane or a translation along the direction that proves the lower one."""
    assert found.lower_bound <= found.distance
    d = found.direction
    gap = lowest(first, poses[0], d) + lowest(second, poses[1], -d)
    assert gap == pytest.approx(found.lower_bound, abs=1e-12)
    assert found.point_p @ d == pytest.approx(lowest(first, poses[0], d), abs=1e-12)
    if found.lower_bound < 0:
        np.testing.assert_allclose(found.point_r - found.point_p, -found.lower_bound * d, atol=1e-15)


@pytest.mark.parametrize("distance", [0.0, 0.3, 0.9, 3.0])
def test_convex_bodies(distance):
    rng = np.random.default_rng(int(10 * distance))
    for (name, n), (other, m) in itertools.product(FAMILIES, repeat=2):
        radii = rng.uniform(0, 0.2, 2) * rng.integers(0, 2, 2)
        first, second = (
            pc.Polytope(family(kind, k, i), inflation_radius=radius)
            for i, (kind, k, radius) in enumerate(((name, n, radii[0]), (other, m, radii[1])))
        )
        poses = pose_at(rng, distance), pose_at(rng, 0.1)
        found = pc.signed_distance(first, second, *poses)
        assert found.distance - found.lower_bound < 1e-12
        assert_as_promised(found, first, second, poses)
        plain, depth = pc.distance(first, second, *poses), pc.depth(first, second, *poses)
        assert plain.lower_bound == found.lower_bound
        if pc.intersects(first, second, *poses):
            assert plain.distance == 0
            assert (depth.depth, depth.lower_bound) == (-found.lower_bound, -found.distance)
            np.testing.assert_array_equal(depth.direction, found.direction)
        else:
            assert plain.distance == found.distance > 0
            truth = exact.distance(first.vertices, second.vertices, *poses, *radii)
            assert found.lower_bound <= truth * (1 + 1e-15)
            assert truth <= found.distance * (1 + 1e-15)
            assert depth.depth == depth.lower_bound == 0


@pytest.mark.parametrize("gap", [-1e-3, -1e-9, -1e-13, 0.0, 1e-16, 1e-13, 1e-9, 1e-3])
def test_around_contact(gap):
    """Face to face, and vertex to face: the direction is the normal, also where doubles do not tell the gap."""
    turned, _ = np.linalg.qr(np.array([[1.0, 2, 3], [2, -1, 0.5], [0.3, 1, -1]]))
    vertex_down = np.concatenate([0.3 * CUBE + np.array([0, 0, 0.5]), [[0.0, 0, 0]]])
    for upper in (pc.Polytope(CUBE + np.array([0.2, 0.1, 0.5])), pc.Polytope(vertex_down)):
        lower = pc.Polytope(CUBE - np.array([0, 0, 0.5]))
        frame = at(turn=turned * np.linalg.det(turned))
        found = pc.signed_distance(upper, lower, frame @ at(0, 0, gap), frame)
        assert found.lower_bound - 1e-15 <= gap <= found.distance + 1e-15
        assert found.distance - found.lower_bound < 1e-12
        np.testing.assert_allclose(found.direction, frame[:3, 2], atol=1e-11)


def test_the_same_body_and_bodies_in_each_other():
    cube, small = pc.Polytope(CUBE), pc.Polytope(0.1 * CUBE)
    same = pc.signed_distance(cube, cube)
    assert same.lower_bound <= -1 <= same.distance
    inside = pc.signed_distance(small, cube, at(0.2, 0.1, 0))
    assert inside.distance == pytest.approx(-0.35, abs=1e-13)
    np.testing.assert_allclose(inside.direction, [1, 0, 0], atol=1e-12)


def test_spheres_and_capsules():
    ball, capsule = pc.Sphere(0.3), pc.Capsule(0.1, 1.0)
    for shift, distance in ((1.0, 0.6), (0.4, 0.0), (0.25, -0.15), (0.0, -0.4)):
        found = pc.signed_distance(ball, capsule, at(shift))
        assert found.lower_bound - 1e-16 <= distance <= found.distance + 1e-16
        assert found.distance - found.lower_bound < 1e-13


def test_flat_bodies():
    square = pc.Polytope([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    segment, point = pc.Polytope([[0.5, 0.5, -0.25], [0.5, 0.5, 1.0]]), pc.Polytope([[0.5, 0.5, 0.0]])
    for first, second, distance in (
        (square, square, 0.0),
        (segment, square, -0.25),
        (point, square, 0.0),
        (point, point, 0.0),
        (segment, segment, 0.0),
    ):
        found = pc.signed_distance(first, second)
        assert found.distance == pytest.approx(distance, abs=1e-14)
        assert found.lower_bound == pytest.approx(distance, abs=1e-13)


def test_half_spaces_and_sets_of_parts():
    floor = pc.HalfSpace((0, 0, 1), 0.0)
    cloud = pc.PointCloud([[0.0, 0, 0], [1, 0, 2.0]], 0.1)
    for height in (0.5, -0.5):
        pose = at(0, 0, height)
        found = pc.signed_distance(cloud, floor, pose)
        assert found.lower_bound - 1e-15 <= height - 0.1 <= found.distance + 1e-15
        assert found.distance - found.lower_bound < 1e-12
        assert pc.signed_distance(floor, cloud, None, pose).direction @ [0, 0, -1] == pytest.approx(1)


def test_balls_beyond_the_nearest_keep_their_lower_bounds():
    """Each ball of a cloud is measured up to the nearest so far: past that limit there is no upper bound."""
    rng = np.random.default_rng(0)
    cloud, cube = pc.PointCloud(rng.uniform(-1, 1, (200, 3)), 0.01), pc.Box((1, 1, 1))
    for other in (cube, pc.Capsule(0.1, 0.5), pc.Sphere(0.2)):
        for shift in rng.normal(size=(20, 3)) * 3:
            pose = np.eye(4)
            pose[:3, 3] = shift
            found = pc.signed_distance(cloud, other, None, pose)
            if found.distance > 0:
                assert found.distance - found.lower_bound <= 1e-12


def test_balls_whose_centres_are_on_a_face():
    """How deep they are is their radius alone: the hull and the centre touch. TIAGo's fingers do."""
    rng = np.random.default_rng(5)
    ball = pc.Polytope(np.zeros((1, 3)), inflation_radius=0.001)
    box = pc.Polytope(CUBE * [0.2, 0.1, 0.06])
    for k in range(300):
        on_face = np.append(rng.uniform(-0.9, 0.9, 2) * [0.1, 0.05], 0.03)
        pose = pose_within(rng, 1.0)
        there = pose @ at(*on_face)
        for order in (1, -1):
            pair, poses = (ball, box)[::order], (there, pose)[::order]
            found = pc.signed_distance(*pair, *poses)
            assert found.distance - found.lower_bound < 1e-12, k
            assert found.distance == pytest.approx(-0.001, abs=1e-12)
