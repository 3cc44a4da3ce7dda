"""Half-spaces against hulls, solids and sets of parts: verdicts, certificates and distances, in fractions."""

import pickle
from dataclasses import replace
from decimal import Context, Decimal, localcontext
from fractions import Fraction

import coal
import fcl
import numpy as np
import pytest
import solid_meshes
from poses import at, pose_at

import plannercheck as pc
from plannercheck.bodies.given_shapes import given_shape
from plannercheck.bodies.part_certificates import PartSeparation
from plannercheck.bodies.tuning import METHODS


def exact_heights(half_space, pose, points, pose_of_points):
    """|h|·h of each point over the posed plane, h its distance from it, in fractions; by solving M x + t = y.

    Cramer's rule on the columns of M, so that nothing is shared with the cofactors of the library.
    """
    m = [[Fraction(float(pose[i, k])) for k in range(4)] for i in range(3)]
    columns = [[m[i][k] for i in range(3)] for k in range(3)]

    def determinant(a, b, c):
        return (
            a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])
        )

    whole = determinant(*columns)

    def into_frame(y):
        solved = []
        for k in range(3):
            replaced = [list(column) for column in columns]
            replaced[k] = y
            solved.append(determinant(*replaced) / whole)
        return solved

    normal = [Fraction(x) for x in half_space.normal]
    # The gradient of normal · M⁻¹ y, by its values at the axes.
    gradient = [
        sum(n * x for n, x in zip(normal, into_frame([Fraction(int(i == k)) for i in range(3)]), strict=True))
        for k in range(3)
    ]
    square = sum(g * g for g in gradient)
    heights = []
    for point in points:
        y = [
            sum(Fraction(float(pose_of_points[i, k])) * Fraction(float(point[k])) for k in range(3))
            + Fraction(float(pose_of_points[i, 3]))
            - m[i][3]
            for i in range(3)
        ]
        over = sum(g * v for g, v in zip(gradient, y, strict=True)) - Fraction(half_space.offset)
        heights.append(over * abs(over) / square)
    return heights


def meets(half_space, pose, points, pose_of_points, radius=Fraction(0)):
    return min(exact_heights(half_space, pose, points, pose_of_points)) <= radius**2


def random_half_space(rng, size):
    normal = rng.normal(size=3) * 10.0 ** rng.integers(-3, 4)
    if rng.random() < 0.3:
        normal = np.eye(3)[rng.integers(3)] * rng.choice([-1.0, 1.0, 3.0])
    return pc.HalfSpace(tuple(normal.tolist()), float(rng.normal() * size * np.linalg.norm(normal)))


def lowered(half_space, pose, points, pose_of_points, radius, rng):
    """The pose of the points, moved so that the lowest one comes within rounding of the plane and the radius."""
    heights = [float(h) for h in exact_heights(half_space, pose, points, pose_of_points)]
    least = min(np.sign(h) * np.sqrt(abs(h)) for h in heights)
    normal = pose[:3, :3] @ np.array(half_space.normal)
    out = pose_of_points.copy()
    out[:3, 3] -= normal / np.linalg.norm(normal) * (least - radius)
    out[:3, 3] *= 1 + rng.integers(-4, 5, size=3) * 2.0**-52
    return out


def test_verdicts_against_hulls_are_exact():
    rng, seen, near = np.random.default_rng(0), [0, 0], [0, 0]
    for case in range(500):
        size = 10.0 ** rng.integers(-3, 4)
        points = rng.normal(size=(int(rng.integers(1, 30)), 3)) * size
        if case % 5 == 0:
            points = points.round(1)
        radius = float(rng.choice([0.0, 0.1 * size]))
        half_space = random_half_space(rng, size)
        pose, other = pose_at(rng, size), pose_at(rng, size)
        if case % 2:
            other = lowered(half_space, pose, points, other, radius, rng)
        body, plane = pc.Polytope(points, inflation_radius=radius), pc.Polytope(half_space)
        expected = meets(half_space, pose, points, other, Fraction(radius))
        seen[expected] += 1
        near[expected] += case % 2
        assert pc.intersects(body, plane, other, pose) == expected
        assert pc.intersects(plane, body, pose, other, method=METHODS[case % len(METHODS)]) == expected
        if case % 3 == 0:
            certificate = pc.certify(body, plane, other, pose)
            assert isinstance(certificate, pc.SharedPoint if expected else pc.Separation)
            assert certificate.verify()
            assert pc.certify(plane, body, pose, other).verify()
    assert min(seen) > 100
    assert min(near) > 40


@pytest.mark.parametrize("normal", [(0, 0, 1), (0, 0, -2.5), (1, 0, 0), (1, 1, 1), (3, -4, 12)])
def test_touching_counts_and_the_next_double_does_not(normal):
    """A corner of a box exactly in the plane, then one unit further out."""
    box = pc.Polytope(pc.Box((2, 2, 2)))
    lowest = min(sum(n * x for n, x in zip(normal, corner, strict=True)) for corner in box.vertices.tolist())
    assert pc.intersects(box, pc.HalfSpace(normal, lowest))
    assert not pc.intersects(box, pc.HalfSpace(normal, np.nextafter(lowest, -np.inf)))
    assert pc.intersects(box, pc.HalfSpace(normal, np.nextafter(lowest, np.inf)))
    touching = pc.distance(box, pc.HalfSpace(normal, lowest))
    assert touching.distance == 0
    assert -1e-12 < touching.lower_bound <= 0


def test_spheres_touch_by_their_radius():
    """3-4-5: the distance of a centre from a tilted plane is a double."""
    ball, plane = pc.Sphere(1.0), pc.HalfSpace((3, 4, 0), -5.0)
    assert pc.intersects(ball, plane)
    assert not pc.intersects(pc.Sphere(np.nextafter(1.0, 0.0)), plane)
    certificate = pc.certify(ball, plane)
    assert certificate.verify()
    assert certificate.point.tolist() == [-0.6, -0.8, 0.0]
    assert pc.intersects(pc.Capsule(0.5, 3.0), pc.HalfSpace((0, 0, 1), -2.0))
    assert not pc.intersects(pc.Capsule(0.5, 3.0), pc.HalfSpace((0, 0, 1), np.nextafter(-2.0, -3.0)))


def test_many_poses_are_judged_as_one_by_one():
    rng = np.random.default_rng(1)
    half_space, body = pc.Polytope(pc.HalfSpace((0.3, -0.2, 1.0), 0.1)), pc.Polytope(rng.normal(size=(40, 3)))
    poses = np.array([pose_at(rng, 2.0) for _ in range(400)])
    verdicts = pc.intersects(body, half_space, poses)
    assert 20 < verdicts.sum() < 395
    assert verdicts.tolist() == [pc.intersects(body, half_space, pose) for pose in poses]
    assert pc.intersects(half_space, body, None, poses, threads=2).tolist() == verdicts.tolist()


def test_poses_beyond_any_hull_are_judged_by_the_plane():
    """A half-space's hull ends at 1e60 m, poses do not."""
    half_space, body = pc.Polytope(pc.HalfSpace((0.0, 0.0, 1.0))), pc.Polytope(pc.Box((1.0, 1.0, 1.0)))
    poses = np.tile(np.eye(4), (8, 1, 1))
    poses[:, 2, 3] = [-1e61, 1e61, -1e90, 1e90, -1e200, 1e200, 0.25, 0.75]
    poses[:4, 0, 3] = 1e70
    expected = [True, False] * 4
    assert [pc.intersects(body, half_space, pose) for pose in poses] == expected
    assert pc.intersects(body, half_space, poses).tolist() == expected
    assert pc.intersects(half_space, body, None, poses).tolist() == expected


@pytest.mark.filterwarnings("ignore:'panda_link0' of panda")
def test_a_robot_below_a_plane_that_is_beyond_any_hull_collides():
    scene = pc.Scene("deep")
    pose = np.eye(4)
    pose[2, 3] = 1e61
    scene.add("everything", pc.HalfSpace((0.0, 0.0, 1.0)), pose)
    for padding in (0.0, {("panda_hand", "everything"): 0.1}):  # the latter proves pairs apart by another path
        checker = pc.Checker(pc.Robot.load("panda"), scene, self_collision=False, padding=padding)
        assert not checker.unreachable.any()
        assert not checker.check_states(checker.robot.random_configurations(20, 0)).any()


def test_distances_are_those_of_the_lowest_vertex():
    rng, seen = np.random.default_rng(2), [0, 0]
    for _ in range(200):
        points, radius = rng.normal(size=(20, 3)), float(rng.choice([0.0, 0.25]))
        half_space, pose, other = random_half_space(rng, 1.0), pose_at(rng, 1.0), pose_at(rng, 2.0)
        body, plane = pc.Polytope(points, inflation_radius=radius), pc.Polytope(half_space)
        square = min(exact_heights(half_space, pose, points, other))
        height = float(np.sign(square) * np.sqrt(abs(float(square)))) - radius
        found, back = pc.distance(body, plane, other, pose), pc.distance(plane, body, pose, other)
        seen[height <= 0] += 1
        assert found.distance == pytest.approx(max(height, 0), abs=1e-12)
        assert found.lower_bound <= height + 1e-15
        assert found.lower_bound == pytest.approx(height, abs=1e-12)
        assert (back.distance, back.lower_bound) == (found.distance, found.lower_bound)
        assert np.array_equal(back.direction, -found.direction)
        if found.distance > 0:
            assert np.linalg.norm(found.point_p - found.point_r) == pytest.approx(height, abs=1e-12)
        moved = other.copy()
        moved[:3, 3] -= found.direction * found.lower_bound * (1 + 1e-12)
        assert abs(pc.distance(body, plane, moved, pose).lower_bound) < 1e-11
    assert min(seen) > 20


@pytest.mark.parametrize("far", [1e3, 1e9, 1e16, 1e48])
def test_distances_far_from_the_origin_are_as_promised(far):
    """Far planes, bodies that are far in their frames, and both; of points that doubles cannot tell from the plane."""
    rng = np.random.default_rng(5)
    for number in range(60):
        points, radius = rng.normal(size=(1 + number % 4, 3)) * rng.choice([1.0, 1e-3]), rng.choice([0.0, 1e-3])
        half_space, pose, other = random_half_space(rng, 1.0), pose_at(rng, 1.0), pose_at(rng, 1.0)
        if number % 2:
            points, other[:3, 3] = points + (corner := rng.normal(size=3) * far), -other[:3, :3] @ corner
        if number % 3:
            pose[:3, 3] = far * rng.normal(size=3)
            other[:3, 3] += pose[:3, 3]
        other = lowered(half_space, pose, points, other, radius, rng)
        body, plane = pc.Polytope(points, inflation_radius=radius), pc.Polytope(half_space)
        found, square = pc.distance(body, plane, other, pose), min(exact_heights(half_space, pose, points, other))
        with localcontext(Context(prec=120)):
            root = (Decimal(abs(square.numerator)) / Decimal(square.denominator)).sqrt()
            height = float((root if square > 0 else -root) - Decimal(radius))
        size = float(np.ptp(points, axis=0).max()) / 2 + radius
        assert abs(max(found.distance, found.lower_bound) - max(height, 0)) <= 1e-9 * max(abs(height), 1e-3 * size)
        assert found.lower_bound <= height


def test_a_solid_counts_by_its_vertices():
    """Also a hollow one, into which the plane reaches: the part of the half-space in it is in it."""
    solid = pc.Solid(*solid_meshes.ring(16, 8, 0.3))
    points, rng, seen = solid.vertices, np.random.default_rng(3), [0, 0]
    for _ in range(60):
        half_space, pose, other = random_half_space(rng, 1.0), pose_at(rng, 0.5), pose_at(rng, 1.5)
        expected = meets(half_space, pose, points, other)
        seen[expected] += 1
        assert pc.intersects(solid, half_space, other, pose) == expected
        certificate = pc.certify(solid, half_space, other, pose)
        assert isinstance(certificate, pc.SharedPoint if expected else pc.Separation)
        assert certificate.verify()
    assert min(seen) > 8


@pytest.mark.parametrize("uneven", [False, True])
def test_a_cloud_counts_by_its_balls(uneven):
    rng, seen = np.random.default_rng(4), [0, 0]
    for _ in range(50):
        points = rng.normal(size=(int(rng.integers(1, 50)), 3))
        radii = rng.uniform(0.01, 0.4, size=len(points)) if uneven else np.full(len(points), 0.1)
        cloud = pc.PointCloud(points, radii if uneven else 0.1)
        half_space, pose, other = random_half_space(rng, 3.0), pose_at(rng, 0.5), pose_at(rng, 0.5)
        heights = exact_heights(half_space, pose, points, other)
        inside = [h <= Fraction(float(r)) ** 2 for h, r in zip(heights, radii, strict=True)]
        expected = any(inside)
        seen[expected] += 1
        assert pc.intersects(cloud, half_space, other, pose) == expected
        assert pc.intersects(half_space, cloud, pose, other) == expected
        certificate = pc.certify(cloud, half_space, other, pose)
        assert certificate.verify()
        assert isinstance(certificate, pc.SharedPoint) == expected
        gaps = [np.sign(float(h)) * np.sqrt(abs(float(h))) - r for h, r in zip(heights, radii, strict=True)]
        found = pc.distance(cloud, half_space, other, pose)
        assert found.lower_bound == pytest.approx(min(gaps), abs=1e-12)
        assert (found.distance == 0) == expected
        if expected:
            assert inside[np.flatnonzero((points == certificate.bodies[0].vertices[0]).all(axis=1))[0]]
    assert min(seen) > 8


def test_balls_that_no_one_radius_keeps_apart_are_proved_apart_by_parts():
    cloud, floor = pc.PointCloud([[0, 0, 0.1], [1, 0, 1]], np.array([0.05, 0.9])), pc.HalfSpace((0, 0, 1), 0.0)
    for certificate in (pc.certify(cloud, floor), pc.certify(floor, cloud)):
        assert isinstance(certificate, PartSeparation)
        assert certificate.gap == pytest.approx(0.05)
        assert certificate.verify()
        halves = replace(certificate, ranges=certificate.ranges[:1])
        assert not halves.verify()


def test_false_certificates_are_refused():
    ball, plane = pc.Sphere(0.5), pc.HalfSpace((0, 0, 1), 0.0)
    over = at(0, 0, 2.0)
    apart, shared = pc.certify(ball, plane, over), pc.certify(ball, plane)
    assert apart.verify()
    assert shared.verify()
    half_space = apart.bodies[1]
    higher = replace(half_space, offset=1.6)  # within the ball's radius of its centre
    turned = replace(half_space, normal=np.array([1e-9, 0.0, 1.0]))  # far away it reaches the ball's height
    for wrong in (higher, turned):
        assert not replace(apart, bodies=(apart.bodies[0], wrong)).verify()
    lower = replace(half_space, offset=-0.6)
    assert not replace(shared, bodies=(shared.bodies[0], lower)).verify()
    assert not replace(shared, second=shared.first).verify()


def test_numbers_of_any_size():
    for scale in (1e-280, 1e-3, 1.0, 1e200):
        half_space = pc.HalfSpace((0, 0, scale), -scale)
        assert pc.intersects(pc.Box((2, 2, 2)), half_space)
        assert not pc.intersects(pc.Box((2, 2, 2 - 1e-15)), half_space)
        assert pc.certify(pc.Box((2, 2, 2)), half_space).verify()
    far = pc.HalfSpace((0, 0, 1), -1e50)
    assert not pc.intersects(pc.Box((1, 1, 1)), far)
    assert pc.intersects(pc.Polytope([[0, 0, -1e50]]), far)
    assert pc.intersects(pc.Polytope([[0, 0, 1e50]]), pc.HalfSpace((0, 0, 1), 1e50))


def test_bodies_are_pickled_and_not_saved(tmp_path):
    half_space = pc.HalfSpace((0.1, 0.7, -3.0), 0.3)
    body, point = pc.Polytope(half_space), np.array([[0.0, 0.0, -0.1]])
    again = pickle.loads(pickle.dumps(body))
    assert again.half_space == body.half_space
    assert pc.intersects(again, point) == pc.intersects(body, point)
    assert pickle.loads(pickle.dumps(half_space)) == half_space
    assert pickle.loads(pickle.dumps(half_space)).digest == half_space.digest
    assert half_space.digest != pc.HalfSpace((0.1, 0.7, -3.0), 0.31).digest
    with pytest.raises(pc.PlannercheckError, match="this is a half-space: pickle it"):
        body.save(tmp_path / "body")


def test_half_spaces_of_other_libraries_are_taken():
    """Both have the same points: normal · x <= offset."""
    for library in (coal, fcl):
        shape = given_shape(library.Halfspace(np.array([0.0, 0.6, 0.8]), 0.5), "it")[0]
        assert shape == pc.HalfSpace((0.0, 0.6, 0.8), 0.5)


def test_two_half_spaces_are_refused_by_name():
    floor, wall = pc.Polytope(pc.HalfSpace((0, 0, 1), 0.0)), pc.Polytope(pc.HalfSpace((1, 0, 0), 0.0))
    poses = np.tile(np.eye(4), (3, 1, 1))
    for query in (pc.intersects, pc.certify, pc.distance, pc.signed_distance, pc.depth):
        with pytest.raises(pc.PlannercheckError, match="P and R are two half-spaces"):
            query(floor, wall)
    with pytest.raises(pc.PlannercheckError, match="P and R are two half-spaces"):
        pc.intersects(floor, wall, poses)


@pytest.mark.parametrize(
    ("normal", "offset", "words"),
    [
        ((0, 0), 0.0, "must have 3 numbers, not 2"),
        ((0, 0, 0), 0.0, "finite and not 0"),
        ((0, np.inf, 0), 0.0, "finite and not 0"),
        ("up", 0.0, "normal of a half-space must be an array of numbers"),
        ((0, 0, 1), np.nan, "within 1e\\+50 m of the origin"),
        ((0, 0, 1), 1e60, "within 1e\\+50 m of the origin"),
        ((0, 0, 1), "low", "must be a number, not 'low'"),
        ((1e300, 0, 1e-300), 0.0, "must not differ by more than 1e300"),
    ],
)
def test_wrong_numbers_are_told(normal, offset, words):
    with pytest.raises(pc.PlannercheckError, match=words):
        pc.HalfSpace(normal, offset)
