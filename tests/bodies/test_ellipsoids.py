"""Ellipsoids: the outer polytope contains them, the inner one is in them, both within the excess, exactly."""

import pickle
from fractions import Fraction

import coal
import fcl
import numpy as np
import pytest
from poses import at, pose_at

import plannercheck as pc
from plannercheck.bodies.circumscribed import LEAST_BALL_EXCESS, unit_ball
from plannercheck.bodies.given_shapes import given_shape
from plannercheck.evaluation.stress.oracle import compiled_oracle
from plannercheck.validation.fingerprint import content_hash

RADII = [(1.0, 1.0, 1.0), (0.3, 0.2, 0.1), (2.0, 1e-3, 0.5), (1e6, 1.0, 1e-6), (1e-200, 1.0, 1e100), (1 / 3, 0.7, 0.1)]
EXCESSES = [1.0, 0.1, 1e-2]  # 1e-3 holds as well, in a minute


def fractions(points):
    return [[Fraction(c) for c in row] for row in points.tolist()]


def support_squared(normal, radii):
    """The square of the largest n·x over the ellipsoid: Σ (r_i n_i)²."""
    return sum((n * Fraction(r)) ** 2 for n, r in zip(normal, radii, strict=True))


def planes(points, triangles):
    for triangle in triangles:
        a, b, c = (points[k] for k in triangle)
        u, v = [y - x for x, y in zip(a, b, strict=True)], [y - x for x, y in zip(a, c, strict=True)]
        normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
        yield normal, sum(n * x for n, x in zip(normal, a, strict=True))


@pytest.mark.parametrize("excess", EXCESSES)
@pytest.mark.parametrize("radii", RADII, ids=str)
def test_the_outer_polytope_contains_the_ellipsoid_and_sticks_out_by_no_more_than_the_excess(radii, excess):
    points, faces = pc.Ellipsoid(radii, excess).vertices_and_faces()
    exact = fractions(points)
    for normal, offset in planes(exact, faces):
        assert offset > 0
        assert offset**2 >= support_squared(normal, radii)
    most = (1 + Fraction(excess)) ** 2 * (1 + Fraction(1, 2**49))
    assert all(sum((x / Fraction(r)) ** 2 for x, r in zip(row, radii, strict=True)) <= most for row in exact)


@pytest.mark.parametrize("excess", EXCESSES)
@pytest.mark.parametrize("radii", RADII, ids=str)
def test_the_inner_polytope_is_in_the_ellipsoid_and_within_the_gap(radii, excess):
    points, faces = pc.Ellipsoid(radii, excess).inner()
    exact = fractions(points)
    assert all(sum((x / Fraction(r)) ** 2 for x, r in zip(row, radii, strict=True)) <= 1 for row in exact)
    least = 1 / (1 + Fraction(excess)) ** 2 * (1 - Fraction(1, 2**45))
    for normal, offset in planes(exact, faces):
        assert offset**2 >= least * support_squared(normal, radii)


@pytest.mark.parametrize("radii", RADII[:4], ids=str)
def test_both_polytopes_are_convex_with_the_faces_given(radii):
    shape = pc.Ellipsoid(radii, 1e-2)
    for points, faces in (shape.vertices_and_faces(), shape.inner()):
        body = pc.Polytope(points, faces)  # which verifies the faces exactly
        assert len(body.vertices) == len(points)
        assert body.fault() == ""


@pytest.mark.parametrize(
    ("radii", "dimension"), [((0, 1, 2), 2), ((1, 0, 2), 2), ((1, 2, 0), 2), ((0, 3, 0), 1), ((0, 0, 0), 0)]
)
def test_a_radius_of_zero_makes_plates_segments_and_points(radii, dimension):
    shape = pc.Ellipsoid(radii)
    for points, faces in (shape.vertices_and_faces(), shape.inner()):
        assert faces is None
        assert pc.Polytope(points).dimension == dimension
        assert np.abs(points).max(axis=0, initial=0) == pytest.approx(radii, rel=2e-3)


def test_verdicts_against_hulls_between_the_two_polytopes_are_those_of_the_ellipsoid():
    """Against points: whether one is in the posed ellipsoid is decided in fractions."""
    rng, shape = np.random.default_rng(1), pc.Ellipsoid((0.5, 0.3, 0.1), 1e-2)
    outer, inner = pc.Polytope(*shape.vertices_and_faces()), pc.Polytope(*shape.inner())
    decided = 0
    for _ in range(2000):
        direction = rng.normal(size=3)
        direction /= np.linalg.norm(direction / np.array(shape.radii))
        point = direction * (1 + rng.normal() * 0.02)
        square = sum((Fraction(x) / Fraction(r)) ** 2 for x, r in zip(point.tolist(), shape.radii, strict=True))
        in_outer, in_inner = (pc.intersects(body, pc.Polytope(point[None])) for body in (outer, inner))
        assert in_outer or square > 1
        assert not in_inner or square <= 1
        decided += in_outer == in_inner
    assert decided > 1000


def test_ellipsoids_are_bodies_of_scenes_and_pairs():
    robot = pc.Robot.load("panda")
    scene = pc.Scene()
    pose = at(0.5, 0.0, 0.4)
    scene.add("egg", pc.Ellipsoid((0.2, 0.15, 0.3)), pose)
    checker = pc.Checker(robot, scene)
    q = robot.random_configurations(300, 1)
    scene_of_hull = pc.Scene()
    scene_of_hull.add("egg", pc.Hull(pc.Ellipsoid((0.2, 0.15, 0.3)).vertices_and_faces()[0]), pose)
    np.testing.assert_array_equal(checker.check_states(q), pc.Checker(robot, scene_of_hull).check_states(q))
    assert "ellipsoid of radii 0.2, 0.15, 0.3" in scene._repr_html_()
    assert pc.intersects(pc.Ellipsoid((1, 2, 3)), pc.Sphere(0.5))
    assert pc.distance(pc.Ellipsoid((1, 2, 3)), np.array([[5.0, 0, 0]])).distance == pytest.approx(4, abs=2e-3)
    assert pc.Ellipsoid((1, 2, 3)) == pc.Ellipsoid((1.0, 2.0, 3.0))


def test_what_is_certainly_hit_and_what_may_be(tmp_path):
    """Collisions of the inner polytope are the ellipsoid's, and those are the outer one's: states and motions."""
    robot, rng = pc.Robot.load("panda"), np.random.default_rng(3)
    shape, pose = pc.Ellipsoid((0.25, 0.15, 0.3), 0.05), pose_at(rng, 0.0)
    pose[:3, 3] = 0.45, 0.1, 0.5
    scenes = {name: pc.Scene(name) for name in ("outer", "inner", "true")}
    scenes["outer"].add("egg", shape, pose)
    scenes["inner"].add("egg", pc.Hull(shape.inner()[0]), pose)
    scenes["true"].add("egg", pc.Ellipsoid(shape.radii, 1e-3), pose)
    outer, inner, true = (pc.Checker(robot, scene, self_collision=False) for scene in scenes.values())
    q = robot.random_configurations(600, 4)
    free_of_outer, free_of_inner, free = (each.check_states(q) for each in (outer, inner, true))
    assert (free_of_outer <= free).all()
    assert (free <= free_of_inner).all()
    assert (free_of_outer < free_of_inner).any()
    gap = inner.clearances(q) - outer.clearances(q)
    apart = outer.clearances(q) > 0
    assert (gap[apart] > 0).all()
    assert (gap[apart] < 2 * shape.excess * max(shape.radii)).all()
    start, end = q[:200], np.clip(q[:200] + rng.normal(size=(200, 7)) * 0.1, robot.lower, robot.upper)
    moves_by_outer, moves_by_inner = outer.check_motions(start, end), inner.check_motions(start, end)
    assert (moves_by_outer <= moves_by_inner).all()
    assert 20 < moves_by_outer.sum() < 190
    padded = pc.Checker(robot, scenes["outer"], self_collision=False, padding=0.02)
    assert np.array_equal(padded.check_states(q), outer.clearances(q) > 0.02)
    scenes["outer"].save(tmp_path / "egg.yaml")
    again = pickle.loads(pickle.dumps(pc.Checker(robot, pc.Scene.load(tmp_path / "egg.yaml"), self_collision=False)))
    assert np.array_equal(again.check_states(q), free_of_outer)
    assert content_hash(again) == content_hash(outer)
    collided = outer.explain(q[np.flatnonzero(~free_of_outer)[0]])
    assert all(pair.certificate.verify() for pair in collided.collisions)


def test_links_carry_ellipsoids():
    robot, egg, table = pc.Robot.load("panda"), pc.Ellipsoid((0.05, 0.05, 0.2)), np.eye(4)
    table[:3, 3] = 0.85, 0.0, 0.2
    ahead = at(0, 0, 0.35)
    ours, hulls = pc.Scene("egg"), pc.Scene("egg")
    for scene, shape in ((ours, egg), (hulls, pc.Hull(egg.vertices_and_faces()[0]))):
        scene.add_box("table", (1.0, 1.0, 0.1), table)
        scene.attach("egg", "panda_hand", ahead, parts=shape)
    q = robot.random_configurations(400, 5)
    expected = pc.Checker(robot, hulls).check_states(q)
    assert np.array_equal(pc.Checker(robot, ours).check_states(q), expected)
    assert 0.05 < expected.mean() < 0.95


def test_pairs_with_hulls_agree_with_the_compiled_oracle():
    rng, shape = np.random.default_rng(2), pc.Ellipsoid((0.5, 0.3, 0.1), 0.05)
    body, other = pc.Polytope(*shape.vertices_and_faces()), pc.Polytope(rng.normal(size=(30, 3)) * 0.2)
    oracle = compiled_oracle()
    poses = np.stack([[pose_at(rng, 0.2), pose_at(rng, 0.5)] for _ in range(500)])
    first, second = np.ascontiguousarray(poses[:, 0]), np.ascontiguousarray(poses[:, 1])
    truth = oracle.decide(oracle.Points(body.vertices, 0.0), first, oracle.Points(other.vertices, 0.0), second, False)
    assert set(truth.tolist()) == {0, 1}
    np.testing.assert_array_equal(pc.intersects(body, other, first, second), truth == 1)


def test_ellipsoids_of_other_libraries_are_taken():
    assert given_shape(coal.Ellipsoid(1.0, 2.0, 3.0), "it")[0] == pc.Ellipsoid((1, 2, 3))
    assert given_shape(fcl.Ellipsoid(1.0, 2.0, 3.0), "it")[0] == pc.Ellipsoid((1, 2, 3))


def test_the_least_excess_of_a_ball_is_met_and_plates_may_have_less():
    pc.Ellipsoid((1, 1, 1), LEAST_BALL_EXCESS)
    assert np.linalg.norm(unit_ball(500).points, axis=1).max() <= 1 + LEAST_BALL_EXCESS
    assert len(pc.Ellipsoid((1, 1, 0), 1e-9).vertices_and_faces()[0]) > 10_000


@pytest.mark.parametrize(
    ("radii", "excess", "words"),
    [
        ((1.0, 2.0), 1e-3, "three lengths in m along x, y, z, not 2"),
        ((1, -2, 3), 1e-3, "ellipsoid radius y must be finite and not negative"),
        ((1, np.nan, 3), 1e-3, "ellipsoid radius y"),
        ((1, 1, 1e-300), 1e-3, "ellipsoid radius z is 1e-300 m"),
        ("abc", 1e-3, "ellipsoid radii must be an array of numbers"),
        ((1, 1, 1), 0.0, "excess must be within"),
        ((1, 1, 1), 1e-9, "excess 1e-09 needs about a million points around a ball, or more: give 4e-06 or more"),
    ],
)
def test_wrong_sizes_are_told(radii, excess, words):
    with pytest.raises(pc.PlannercheckError, match=words):
        pc.Ellipsoid(radii, excess)
