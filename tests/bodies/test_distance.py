"""Distances of posed bodies against exact arithmetic in Python integers and FCL, near contact and far away."""

import itertools
from fractions import Fraction

import exact_verdicts
import numpy as np
import pytest
from poses import at, pose_at

import plannercheck as pc
from plannercheck.bodies import exact_reference as exact
from plannercheck.common.core import core
from plannercheck.evaluation.stress.body_families import family

CUBE = np.array(list(itertools.product((0.0, 1.0), repeat=3)))
FAMILIES = [("box", 8), ("round", 30), ("cloud", 120), ("needle", 40), ("flat", 60), ("round", 1000)]


def assert_as_promised(found, first, second, poses, inflation_radii=(0.0, 0.0)):
    """Against exact arithmetic: value, bounds, points."""
    truth = exact.distance(first.vertices, second.vertices, *poses, *inflation_radii)
    size = max(body.core.radius + body.inflation_radius for body in (first, second))
    room = 1e-9 * max(truth, 1e-3 * size)
    assert abs(found.distance - truth) <= room
    assert (found.distance == 0) == exact_verdicts.intersects(first.vertices, second.vertices, *poses, *inflation_radii)
    assert found.lower_bound <= truth * (1 + 1e-15)
    if truth > 0:
        assert found.lower_bound >= truth - room
        assert abs(np.linalg.norm(found.point_p - found.point_r) - truth) <= room + 1e-14


@pytest.mark.parametrize(("name", "n"), FAMILIES)
def test_random_pairs_against_exact_arithmetic(name, n):
    rng = np.random.default_rng(n)
    for (other, m), gap in itertools.product(FAMILIES[:-1], (0.3, 1.5, 2.01, 4.0, 100.0)):
        first, second = pc.Polytope(family(name, n, 1)), pc.Polytope(family(other, m, 2))
        poses = pose_at(rng, gap), pose_at(rng, 0.1)
        assert_as_promised(pc.distance(first, second, *poses), first, second, poses)


@pytest.mark.parametrize("gap", [1.0, 1e-3, 1e-6, 1e-9, 1e-12, 1e-14, 2e-16])
def test_small_gaps(gap):
    """Face to face, edge to edge and corner to corner, of bodies that were brought that near."""
    rng = np.random.default_rng(5)
    cube, cloud = pc.Polytope(CUBE), pc.Polytope(family("cloud", 60, 3))
    for first, second in ((cube, cube), (cube, cloud), (cloud, cloud)):
        for _ in range(5):
            pose_p, pose_r = pose_at(rng, 5.0), pose_at(rng, 0.0)
            far = pc.distance(first, second, pose_p, pose_r)
            pose_p[:3, 3] -= (1 - gap / far.distance) * (far.point_p - far.point_r)
            assert_as_promised(pc.distance(first, second, pose_p, pose_r), first, second, (pose_p, pose_r))


def test_points_segments_polygons_and_balls():
    rng = np.random.default_rng(6)
    bodies = [
        pc.Polytope(rng.normal(size=(n, 3)), inflation_radius=s)
        for n, s in ((1, 0), (1, 0.3), (2, 0.2), (3, 0), (4, 0.1))
    ]
    for first, second in itertools.product(bodies, repeat=2):
        for gap in (0.0, 0.5, 3.0, 50.0):
            poses = pose_at(rng, gap), np.eye(4)
            found = pc.distance(first, second, *poses)
            assert_as_promised(found, first, second, poses, (first.inflation_radius, second.inflation_radius))


def test_touching_is_no_distance():
    cube = pc.Polytope(CUBE)
    for shift, truth in ((1.0, 0.0), (np.nextafter(1.0, 2.0), 2.0**-52), (0.5, 0.0)):
        pose = at(shift)
        found = pc.distance(cube, cube, pose)
        assert found.distance == pytest.approx(truth, rel=1e-9, abs=1e-12)
        assert (found.distance > 0) == (shift > 1)


def test_depth_separates():
    """Moving out by the depth separates; that of cubes through a face and of balls is the least."""
    rng = np.random.default_rng(7)
    cube = pc.Polytope(CUBE)
    for depth in (0.01, 0.2, 0.5):
        pose = at(1 - depth)
        assert pc.distance(cube, cube, pose).lower_bound == pytest.approx(-depth, abs=1e-13)
    for (name, n), (other, m) in itertools.product(FAMILIES[:4], repeat=2):
        first, second = pc.Polytope(family(name, n, 1)), pc.Polytope(family(other, m, 2))
        pose = pose_at(rng, 0.2)
        found = pc.distance(first, second, pose)
        if found.distance > 0:
            continue
        pose[:3, 3] += (found.point_r - found.point_p) * (1 + 1e-9)
        assert not pc.intersects(first, second, pose)
    ball = pc.Polytope([[0.0, 0, 0]], inflation_radius=1.0)
    pose = at(1.5)
    assert pc.distance(ball, ball, pose).lower_bound == pytest.approx(-0.5, abs=1e-14)


def test_fcl_agrees():
    fcl = pytest.importorskip("fcl")
    rng = np.random.default_rng(8)

    def convex(body):
        faces = np.column_stack([np.full(len(body.faces), 3), body.faces]).astype(np.int32)
        return fcl.Convex(np.array(body.vertices), len(body.faces), faces.ravel())

    for n in (8, 30, 200, 1000):
        bodies = [pc.Polytope(family("round", n, seed)) for seed in (1, 2)]
        shapes = [convex(body) for body in bodies]
        for _ in range(10):
            poses = pose_at(rng, 3.5), pose_at(rng, 0.2)
            objects = [
                fcl.CollisionObject(s, fcl.Transform(p[:3, :3].copy(), p[:3, 3].copy()))
                for s, p in zip(shapes, poses, strict=True)
            ]
            theirs = fcl.distance(*objects, fcl.DistanceRequest(), fcl.DistanceResult())
            assert pc.distance(*bodies, *poses).distance == pytest.approx(theirs, abs=1e-5)


def test_batches_are_single_calls():
    rng = np.random.default_rng(9)
    body = pc.Polytope(family("cloud", 40, 1))
    poses = np.array([pose_at(rng, gap) for gap in np.linspace(0.1, 4, 20)])
    overlap, distances, *_ = core.distance_batch(body.core, poses, body.core, np.eye(4)[None])
    singly = [pc.distance(body, body, pose).distance for pose in poses]
    np.testing.assert_array_equal(np.where(overlap, 0.0, distances), singly)


def test_depths_of_inflated_bodies_have_both_inflation_radii():
    """Cubes that overlap by 1/4: to part them takes that and both radii, and by no less do they come apart."""
    first, second = pc.Polytope(CUBE, inflation_radius=0.125), pc.Polytope(CUBE, inflation_radius=0.0625)
    pose = at(0.75)
    found = pc.distance(first, second, pose)
    depth = 0.25 + 0.125 + 0.0625
    assert found.distance == 0
    assert found.lower_bound == pytest.approx(-depth, abs=1e-12)
    np.testing.assert_allclose(found.direction, [1, 0, 0], atol=1e-12)
    np.testing.assert_allclose(found.point_r - found.point_p, depth * found.direction, atol=1e-12)
    assert found.point_p[0] == pytest.approx(0.75 - 0.125)
    for factor, shared in ((1 - 1e-9, True), (1 + 1e-9, False)):
        moved = pose.copy()
        moved[:3, 3] += factor * depth * found.direction
        assert pc.intersects(first, second, moved) == shared


def brought_near(rng, far):
    """A point that far from its frame's origin, a pose that takes it near the world's, and about where it is there."""
    corner, pose = rng.normal(size=3) * far, pose_at(rng, 0.0)
    pose[:3, 3] = -pose[:3, :3] @ corner
    there = [sum(Fraction(m) * Fraction(x) for m, x in zip(row, (*corner, 1.0), strict=True)) for row in pose[:3]]
    return corner, pose, np.array([float(x) for x in there])


@pytest.mark.parametrize("far", [1.0, 2.0**37, 5e19, 1e48])
@pytest.mark.parametrize("part", [1.0, 1e-6, 1e-12])
def test_coordinates_that_cancel(far, part):
    """A point that is far away in its own frame, next to bodies of any size near the world's origin."""
    rng = np.random.default_rng(10)
    for n, inflation_radius in itertools.product((1, 2, 3, 8, 60), (0.0, 0.5)):
        corner, pose, there = brought_near(rng, far)
        size = part * np.linalg.norm(there)
        vertices = family("cloud", n, n) if n > 3 else rng.normal(size=(n, 3))
        near = pc.Polytope(there + size * (vertices + np.array([3, 1, 0])), inflation_radius=size * inflation_radius)
        point = pc.Polytope(corner[None])
        radii = (0.0, near.inflation_radius)
        truth = exact.distance(point.vertices, near.vertices, pose, None, *radii)
        for found in (pc.distance(point, near, pose), pc.distance(near, point, None, pose)):
            assert abs(found.distance - truth) <= 1e-9 * max(truth, 1e-3 * (near.core.radius + near.inflation_radius))
            assert found.lower_bound <= truth * (1 + 1e-15)
