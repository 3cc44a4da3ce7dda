"""Points against a robot: in collision, how far, its own ones; against the pair test and exact arithmetic."""

import warnings

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.bodies import exact_reference as exact
from plannercheck.bodies.given_bodies import given_polytope
from plannercheck.common.core import core

ROBOTS = ["panda", "ur5", "pr2"]


def points_about(robot, q, n, rng):
    """Points near bodies and far from them, in runs of nearby ones."""
    poses = robot.link_poses(q)
    bodies = rng.integers(len(robot.bodies), size=n // 8 + 1).repeat(8)[:n]
    links = [robot.link_index(robot.bodies[k].link) for k in bodies.tolist()]
    return poses[links, :3, 3] + rng.normal(size=(n, 3)) * rng.choice([0.01, 0.05, 0.2, 1.0], (n, 1))


def placed_bodies(checker, q):
    poses = core.placed_on_links(
        np.stack([checker.robot.link_poses(q)[checker.robot.link_index(b.link)] for b in checker.robot.bodies]),
        np.stack([b.pose for b in checker.robot.bodies]),
    )
    return [
        (given_polytope(body.shape, None, "P")[0], pose) for body, pose in zip(checker.robot.bodies, poses, strict=True)
    ]


def by_pairs(placed, points, radii):
    balls = [pc.Polytope(point[None], inflation_radius=r) for point, r in zip(points, radii, strict=True)]
    return np.array([any(pc.intersects(body, ball, pose) for body, pose in placed) for ball in balls])


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("radius", [0.0, 0.02])
def test_points_in_collision_are_those_of_the_pair_test(name, radius):
    robot = pc.Robot.load(name)
    checker, rng = pc.Checker(robot), np.random.default_rng(3)
    for q in robot.random_configurations(3, 1):
        points = points_about(robot, q, 203, rng)
        found = checker.points_in_collision(q, points, radius)
        np.testing.assert_array_equal(found, by_pairs(placed_bodies(checker, q), points, np.full(203, radius)))
        assert 0.02 < found.mean() < 0.98
        one_by_one = [checker.points_in_collision(q, point[None], radius)[0] for point in points[:40]]
        np.testing.assert_array_equal(found[:40], one_by_one)


def test_every_point_may_have_its_radius():
    robot = pc.Robot.load("panda")
    checker, rng, q = pc.Checker(robot), np.random.default_rng(4), robot.random_configurations(1, 2)[0]
    points, radii = points_about(robot, q, 500, rng), rng.choice([0.0, 0.001, 0.05, 0.3], 500)
    found = checker.points_in_collision(q, points, radii)
    np.testing.assert_array_equal(found, by_pairs(placed_bodies(checker, q), points, radii))


def test_solid_links_let_points_into_their_hollows():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        robot = pc.Robot.load("ur10", geometry={"forearm_link": "solid", "upper_arm_link": "solid"})
    checker, hulls = pc.Checker(robot), pc.Checker(pc.Robot.load("ur10"))
    rng, q = np.random.default_rng(5), robot.random_configurations(1, 3)[0]
    points = points_about(robot, q, 600, rng)
    for radius in (0.0, 0.01):
        found = checker.points_in_collision(q, points, radius)
        np.testing.assert_array_equal(found, by_pairs(placed_bodies(checker, q), points, np.full(600, radius)))
        of_hulls = hulls.points_in_collision(q, points, radius)
        assert not (found & ~of_hulls).any()
        assert (of_hulls & ~found).any()
        near = np.isfinite(checker.point_distances(q, points, limit=radius)).any(axis=1)
        np.testing.assert_array_equal(near, found)


@pytest.mark.parametrize("name", ["panda", "ur5"])
def test_distances_are_those_of_exact_arithmetic(name):
    robot = pc.Robot.load(name)
    checker, rng, q = pc.Checker(robot), np.random.default_rng(6), robot.random_configurations(1, 4)[0]
    points = points_about(robot, q, 24, rng)
    found, lower = checker.point_distances(q, points), checker.point_distances(q, points, lower_bound=True)
    assert found.shape == lower.shape == (24, len(robot.link_names))
    poses = robot.link_poses(q)
    for column, link in enumerate(robot.link_names):
        bodies = [b for b in robot.bodies if b.link == link]
        if not bodies:
            assert np.isinf(found[:, column]).all()
            continue
        for row, point in enumerate(points):
            truth = np.inf
            for body in bodies:
                pose = core.placed_on_links(poses[column][None], body.pose[None])[0]
                vertices, _ = body.shape.vertices_and_faces()
                truth = min(truth, exact.distance(vertices, point[None], pose))
            assert lower[row, column] <= truth * (1 + 1e-15)
            assert truth <= found[row, column] * (1 + 1e-15)
            assert found[row, column] - lower[row, column] <= 1e-9 * max(truth, 1e-3)
            assert (found[row, column] == 0) == (truth == 0)


def test_distances_beyond_the_limit_are_infinite():
    robot = pc.Robot.load("panda")
    checker, rng, q = pc.Checker(robot), np.random.default_rng(7), robot.random_configurations(1, 5)[0]
    points = points_about(robot, q, 300, rng)
    all_of_them, limited = checker.point_distances(q, points), checker.point_distances(q, points, limit=0.1)
    np.testing.assert_array_equal(np.isfinite(limited), all_of_them <= 0.1)
    is_near = np.isfinite(limited)
    np.testing.assert_allclose(limited[is_near], all_of_them[is_near], rtol=1e-8, atol=1e-12)


def test_a_point_that_touches_collides_and_is_no_further_than_the_margin():
    scene = pc.Scene()
    robot = pc.Robot.load("panda")
    link, q = "panda_link0", robot.reference
    scene.attach("block", link, parts=pc.Box((0.5, 0.5, 0.5)))
    checker = pc.Checker(robot, scene)
    # The link is at the world's origin, so the block's faces are at 0.25 m exactly.
    points = np.array([[-0.25, 0.0, -0.2], [-0.5, 0.1, -0.2], [np.nextafter(-0.5, -1), 0.1, -0.2]])
    assert checker.points_in_collision(q, points).tolist() == [True, False, False]
    assert checker.points_in_collision(q, points, 0.25).tolist() == [True, True, False]
    left = checker.robot.remove_own_points(points, q, 0.25)
    np.testing.assert_array_equal(left, points[2:])
    distance = checker.point_distances(q, points)[:, robot.link_index(link)]
    assert distance[0] == 0
    assert distance[1] == pytest.approx(0.25, rel=1e-9)


def test_own_points_are_removed_and_others_stay():
    robot = pc.Robot.load("panda")
    rng, q = np.random.default_rng(8), robot.random_configurations(1, 6)[0]
    points = points_about(robot, q, 400, rng)
    near = by_pairs(placed_bodies(pc.Checker(robot), q), points, np.full(400, 0.03))
    np.testing.assert_array_equal(robot.remove_own_points(points, q, 0.03), points[~near])
    named = dict(zip(robot.joint_names, q, strict=True))
    np.testing.assert_array_equal(robot.remove_own_points(points, named, 0.03), points[~near])
    assert robot.remove_own_points(np.zeros((0, 3)), q, 0.03).shape == (0, 3)


def test_padding_is_no_part_of_the_radius_and_poses_are_the_checkers():
    robot = pc.Robot.load("ur5")
    rng, q = np.random.default_rng(9), robot.random_configurations(1, 7)[0]
    points = points_about(robot, q, 300, rng)
    plain = pc.Checker(robot).points_in_collision(q, points, 0.01)
    for other in (pc.Checker(robot, padding=0.05), pc.Checker(robot, kinematics="pinocchio")):
        np.testing.assert_array_equal(other.points_in_collision(q, points, 0.01), plain)


@pytest.mark.parametrize(
    ("points", "radius", "words"),
    [
        ([[0, 0, np.nan], [1, 1, 1]], 0.0, r"row 0 is \[0.0, 0.0, nan\].*1 such rows"),
        ([[0, 0, 0, 0]], 0.0, r"shape \(n, 3\), not \(1, 4\)"),
        ("cloud", 0.0, "numbers of shape"),
        ([[0, 0, 0]], -1.0, "not negative"),
        ([[0, 0, 0]], [0.1, 0.1], "one for each point"),
    ],
)
def test_wrong_points_are_told(points, radius, words):
    checker = pc.Checker(pc.Robot.load("panda"))
    q = checker.robot.reference
    with pytest.raises(pc.PlannercheckError, match=words):
        checker.points_in_collision(q, points, radius)


def test_a_limit_is_a_distance():
    checker = pc.Checker(pc.Robot.load("panda"))
    with pytest.raises(pc.PlannercheckError, match="limit must be a distance"):
        checker.point_distances(checker.robot.reference, [[0, 0, 0]], limit=-1)
