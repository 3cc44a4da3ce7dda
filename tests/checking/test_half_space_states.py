"""Robots over half-spaces: states against the heights of their bodies' vertices, and against every way to save work."""

import pickle
from fractions import Fraction

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.validation.certification import certify_verdicts
from plannercheck.validation.fingerprint import content_hash

FLOOR = pc.HalfSpace((0.0, 0.0, 1.0), 0.1)
WALL = pc.HalfSpace((3.0, 1.0, 0.5), -0.4)


def tilted():
    pose = np.eye(4)
    c, s = np.cos(0.3), np.sin(0.3)
    pose[1:3, 1:3] = [[c, -s], [s, c]]
    pose[:3, 3] = 0.1, -0.2, 0.05
    return pose


def scene_of_both():
    scene = pc.Scene("room")
    scene.add("floor", FLOOR)
    scene.add("wall", WALL, tilted())
    scene.allow("floor", "panda_link0")
    scene.allow("wall", "panda_link0")
    return scene


def heights_over(checker, q, name):
    """(n, pairs) of the pairs with an obstacle: the least height of the body's vertices over its plane, in doubles."""
    rows = [k for k in range(len(checker.pairs)) if checker.pair_names(k)[1] == name]
    poses = checker.body_poses(q)
    out = np.empty((len(q), len(rows)))
    for column, row in enumerate(rows):
        body, plane = checker.pairs[row].tolist()
        prepared, shape = checker.polytopes[body], checker.bodies[plane].shape
        pose = checker.bodies[plane].pose
        normal = pose[:3, :3] @ np.array(shape.normal) / np.linalg.norm(shape.normal)
        offset = shape.offset / np.linalg.norm(shape.normal) + normal @ pose[:3, 3]
        points = np.einsum("nij,vj->nvi", poses[:, body, :3, :3], prepared.vertices) + poses[:, body, None, :3, 3]
        out[:, column] = (points @ normal).min(axis=1) - offset - prepared.inflation_radius
    return rows, out - sum(checker.paddings[plane] for plane in [checker.pairs[rows[0], 1]])


@pytest.mark.parametrize("padding", [0.0, 0.03])
def test_states_are_judged_by_the_lowest_vertices(panda, padding):
    checker = pc.Checker(panda, scene_of_both(), padding=padding)
    q = panda.random_configurations(3000, seed=1)
    colliding = checker.colliding_pairs(q)
    for name in ("floor", "wall"):
        rows, heights = heights_over(checker, q, name)
        assert np.abs(heights).min() > 1e-12  # else doubles would not tell
        np.testing.assert_array_equal(colliding[:, rows], heights < 0)
        assert 0.02 < (heights < 0).any(axis=1).mean() < 0.98
    valid = checker.check_states(q)
    np.testing.assert_array_equal(valid, ~colliding.any(axis=1))
    assert [checker.is_valid(each) for each in q[:300]] == valid[:300].tolist()
    np.testing.assert_array_equal(checker.check_states(q[::-1], threads=2), valid[::-1])
    first = checker.first_colliding_pair(q)
    np.testing.assert_array_equal(first, np.where(valid, -1, colliding.argmax(axis=1)))


@pytest.mark.parametrize(
    "off",
    [{}, {"bounds": False}, {"boxes": False, "overlaps": False}, {"learning": False}, {"reach": False},
     {"static_poses": False}],
)  # fmt: skip
def test_verdicts_do_not_depend_on_switches(panda, off):
    scene = scene_of_both()
    scene.add_box("post", (0.1, 0.1, 1.5), tilted())
    q = panda.random_configurations(1500, seed=2)
    expected = pc.Checker(panda, scene)
    for found in (
        pc.Checker(panda, scene, tuning=pc.Tuning(**off)),
        pc.Checker(panda, scene, kinematics="pinocchio", tuning=pc.Tuning(**off)),
    ):
        np.testing.assert_array_equal(found.check_states(q), expected.check_states(q))
        np.testing.assert_array_equal(found.colliding_pairs(q), expected.colliding_pairs(q))
    numbers = found.statistics()
    assert numbers["pairs"] > 0


@pytest.mark.parametrize("count", [1, 500])
def test_every_pair_is_counted_once(panda, count):
    """Where a state surely collides, its pairs with half-spaces are skipped."""
    scene = scene_of_both()
    scene.add_box("post", (0.3, 0.3, 1.5), tilted())
    checker = pc.Checker(panda, scene)
    checker.check_states(panda.random_configurations(count, seed=3))
    numbers = {name: number for name, number in checker.statistics().items() if name not in ("states", "queries")}
    pairs = numbers.pop("pairs")
    assert pairs == count * len(checker.pairs)
    assert sum(numbers.values()) == pairs
    assert count == 1 or min(numbers["bounds"], numbers["overlaps"], numbers["skipped"], numbers["solver"]) > 0


def test_a_robot_before_nothing_but_a_half_space(panda):
    scene = pc.Scene()
    scene.add("floor", FLOOR)
    scene.allow("floor", "panda_link0")
    checker = pc.Checker(panda, scene, self_collision=False)
    q = panda.random_configurations(1000, seed=4)
    _, heights = heights_over(checker, q, "floor")
    np.testing.assert_array_equal(checker.check_states(q), (heights >= 0).all(axis=1))


def test_touching_is_decided_exactly(panda):
    """A plane through the very vertex, as posed, and one a unit in the last place below it."""
    robot = panda
    q = robot.random_configurations(40, seed=5)
    plain = pc.Checker(robot, pc.Scene(), self_collision=False, tuning=pc.Tuning(reach=False))
    hand = next(k for k, body in enumerate(plain.bodies) if body.link == "panda_hand")
    points = pc.Polytope(plain.bodies[hand].shape).vertices
    decided = 0
    for each in q:
        pose = robot.link_poses(each)[robot.link_index("panda_hand")] @ plain.bodies[hand].pose
        exact = [
            sum(Fraction(float(pose[2, k])) * Fraction(float(p[k])) for k in range(3)) + Fraction(float(pose[2, 3]))
            for p in points
        ]
        nearest = float(min(exact))
        for offset in (np.nextafter(nearest, -9), nearest, np.nextafter(nearest, 9)):
            scene = pc.Scene()
            scene.add("plane", pc.HalfSpace((0, 0, 1), offset))
            scene.allow("plane", "panda_link0")
            checker = pc.Checker(robot, scene, self_collision=False)
            row = next(k for k in range(len(checker.pairs)) if checker.pair_names(k)[0] == "panda_hand")
            posed = checker.body_poses(each)[0][checker.pairs[row, 0]]
            assert np.array_equal(posed, pose)
            expected = min(exact) <= Fraction(float(offset))
            assert checker.colliding_pairs(each[None])[0, row] == expected
            decided += 1
    assert decided == 120


def test_explanations_are_proved_and_clearances_are_heights(panda):
    checker = pc.Checker(panda, scene_of_both(), self_collision=False)
    q = panda.random_configurations(60, seed=6)
    heights = np.concatenate([heights_over(checker, q, name)[1] for name in ("floor", "wall")], axis=1)
    np.testing.assert_allclose(checker.clearances(q), heights.min(axis=1), atol=1e-9)
    assert (checker.clearances(q, lower_bound=True) <= heights.min(axis=1)).all()
    for each in q[:20]:
        verdict = checker.explain(each, separations=True)
        assert verdict.valid == checker.is_valid(each)
        for pair in (*verdict.collisions, *verdict.separations):
            assert isinstance(pair.certificate, pc.SharedPoint if pair.colliding else pc.Separation)
            assert pair.certificate.verify()
    report = certify_verdicts(checker, q, checker.first_colliding_pair(q))
    assert report.passed
    assert report.shared_points
    assert report.planes


def test_a_base_that_stands_in_a_half_space_is_told(panda):
    scene = pc.Scene()
    scene.add("floor", FLOOR)
    with pytest.warns(RuntimeWarning, match="floor"):
        pc.Checker(panda, scene)
    below = pc.Scene()
    below.add("floor", pc.HalfSpace((0, 0, 1), -0.01))
    checker = pc.Checker(panda, below)
    static = [k for k in range(len(checker.pairs)) if checker.pair_names(k) == ("panda_link0", "floor")]
    assert all(checker.unreachable[static])


def test_carried_objects_are_tested_against_half_spaces_and_half_spaces_not_carried(panda):
    scene = scene_of_both()
    scene.attach("rod", "panda_hand", parts=pc.Capsule(0.02, 0.6))
    points = np.random.default_rng(7).normal(size=(50, 3)) * 0.1
    scene.attach("grasped", "panda_link7", parts=pc.PointCloud(points, 0.01))
    checker = pc.Checker(panda, scene, self_collision=False)
    q = panda.random_configurations(400, seed=7)
    colliding = checker.colliding_pairs(q)
    for k in range(len(checker.pairs)):
        names = checker.pair_names(k)
        if names[0] not in ("rod", "grasped") or names[1] not in ("floor", "wall"):
            continue
        a, b = checker.pairs[k].tolist()
        poses = checker.body_poses(q)
        shapes = checker.bodies[a].shape, checker.bodies[b].shape
        assert (
            colliding[:, k].tolist() == pc.intersects(*shapes, poses[:, a], np.ascontiguousarray(poses[:, b])).tolist()
        )
        assert 0 < colliding[:, k].sum() < len(q)
    with pytest.raises(pc.PlannercheckError, match="'shield' has a half-space, which no link can carry"):
        scene.attach("shield", "panda_hand", parts=FLOOR)
    with pytest.raises(pc.PlannercheckError, match="'floor' has a half-space, which no link can carry"):
        scene.attach("floor", "panda_hand")
    with pytest.raises(pc.PlannercheckError, match="'shield' has a half-space, which no link can carry"):
        scene.attach("shield", "panda_hand", FLOOR)
    with pytest.raises(pc.PlannercheckError, match="pose of 'egg' is an Ellipsoid: give shapes by parts="):
        scene.attach("egg", "panda_hand", pc.Ellipsoid((1, 1, 1)))


def test_checkers_are_pickled_and_hashed(panda):
    checker = pc.Checker(panda, scene_of_both())
    q = panda.random_configurations(300, seed=8)
    again = pickle.loads(pickle.dumps(checker))
    np.testing.assert_array_equal(again.check_states(q), checker.check_states(q))
    assert content_hash(again) == content_hash(checker)
    other = scene_of_both()
    other.remove("wall")
    other.add("wall", pc.HalfSpace(WALL.normal, -0.41), tilted())
    other.allow("wall", "panda_link0")
    assert content_hash(pc.Checker(panda, other)) != content_hash(checker)
    moved = checker.with_scene(other)
    np.testing.assert_array_equal(moved.check_states(q), pc.Checker(panda, other).check_states(q))
