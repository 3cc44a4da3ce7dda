"""Verdicts where products of lengths underflow, or differences of floats overflow."""

import itertools
from fractions import Fraction

import exact_verdicts
import numpy as np
import pytest

import plannercheck as pc
from plannercheck.bodies import exact_reference as exact
from plannercheck.bodies.tuning import METHODS, pair_options
from plannercheck.common.core import core
from plannercheck.evaluation.stress import contact_poses as contacts
from plannercheck.evaluation.stress.sample_bodies import base_points

UNIT = np.array(list(itertools.product((0.0, 1.0), repeat=3)))


@pytest.mark.parametrize("scale", [1e-150, 1e-159, 5e-161, 5e-162, 3e-162, 2e-162, 1e-170, 1e-308])
@pytest.mark.parametrize("inflation_radius", [0.0, 0.4])
def test_lengths_whose_squares_underflow(scale, inflation_radius):
    """A review found that balls and axes took sums of products that had become 0 for distances."""
    cube, corner = 0.433 * (UNIT - 0.5) * scale, 0.433 * np.vstack([np.zeros(3), np.eye(3)]) * scale
    P, R = (
        pc.Polytope(cube),
        pc.Polytope(np.zeros((1, 3)) if inflation_radius > 0 else corner, inflation_radius=inflation_radius * scale),
    )
    offsets = 0.7 * np.random.default_rng(44).uniform(-1, 1, size=(60, 3))
    offsets[0] = 0.8248, 0.2086, 0.1484
    poses = contacts.identities(60)
    poses[:, :3, 3] = offsets * scale
    truth = [
        exact_verdicts.intersects(P.vertices, R.vertices, pose, np.eye(4), 0.0, R.inflation_radius) for pose in poses
    ]
    assert 0 < sum(truth) < 60
    for options in (pair_options(), pair_options(cached_plane=False), pair_options(centre_axis=False)):
        shared, _, _ = core.intersect_batch(P.core, poses, R.core, np.eye(4)[None], options)
        assert shared.astype(bool).tolist() == truth


@pytest.mark.parametrize("exponent", [30, 37, 38, 39, 45])
def test_boxes_whose_differences_overflow_floats(exponent):
    """Found by a review: infinity times a cosine of 6e-17 is no distance."""
    scale = 10.0**exponent
    body = pc.Polytope((UNIT - 0.5) * np.array([5, 0.2, 0.2]) * scale).core
    pose, placements = np.eye(4), np.repeat(np.eye(4)[None], 2, axis=0)
    pose[:2, :2] = [[1, -6e-17], [6e-17, 1]]
    pose[0, 3], placements[1, 0, 3] = 2 * scale, -2 * scale
    links, pairs, nothing = np.array([0, -1], dtype=np.int32), np.array([[0, 1]], dtype=np.int32), np.zeros(0)
    for bounds, boxes in itertools.product((True, False), (True, False)):
        checker = core.Checker(
            [body, body],
            links,
            placements,
            pairs,
            1,
            nothing,
            nothing,
            pair_options(bounds=bounds, boxes=boxes),
            core.sampled_poses(pose[None, None]),
            [],
        )
        found = checker.first_of_poses(np.repeat(pose[None, None], 8, axis=0), 1)
        assert found.tolist() == [0] * 8


@pytest.mark.parametrize("exponent", [37, 38, 39, 45])
@pytest.mark.parametrize("first", [0, 1])
def test_what_is_beyond_floats_may_be_anywhere(exponent, first):
    """Two bodies of one link are tested together against an obstacle: one is here, the other, which meets it, far."""
    scale = 10.0**exponent
    large, small = (pc.Polytope((UNIT - 0.5) * size).core for size in (scale, 1.0))
    bodies = [large, small, large] if first == 0 else [small, large, large]
    placements = np.repeat(np.eye(4)[None], 3, axis=0)
    placements[[first, 2], 0, 3] = 3 * scale, 3.5 * scale
    links = np.array([0, 0, -1], dtype=np.int32)
    pairs = np.array([[0, 2], [1, 2]], dtype=np.int32)
    pose, nothing = np.eye(4)[None, None], np.zeros(0)
    checker = core.Checker(
        bodies, links, placements, pairs, 1, nothing, nothing, pair_options(), core.sampled_poses(pose), []
    )
    assert checker.first_of_poses(np.repeat(pose, 8, axis=0), 1).tolist() == [first] * 8


def plate_in_plane(normal, middle, rng):
    """Points of a lattice in a plane, in pairs about a point of it: their mean is that point."""
    arms = np.cross(normal, rng.integers(-8, 9, (2, 3)))
    off = rng.integers(-4, 5, (rng.integers(1, 4), 2)) @ arms
    return np.vstack([middle + off, middle - off]).astype(float)


@pytest.mark.parametrize("exponent", [-500, -540, -560, -1000, -1030, -1060])
@pytest.mark.parametrize("method", METHODS)
def test_flat_pairs_with_coinciding_centres(exponent, method):
    """Found by an audit: a size that was a sum of squares was 0, and so was what rounding may be."""
    rng = np.random.default_rng(6)
    for _ in range(150):
        normal, middle = rng.integers(1, 10, 3), rng.integers(-2000, 2000, 3)
        P, R = (pc.Polytope(plate_in_plane(normal, middle, rng) * 2.0 ** (exponent - 12)) for _ in range(2))
        pose = np.eye(4)
        onto = np.array([[rng.choice([-1.0, 1.0]), 0, 0]])
        pose[:3, :3] = contacts.turns_onto(contacts.unit(normal[None].astype(float)), onto, rng)[0]
        assert exact_verdicts.intersects(P.vertices, R.vertices, pose, pose)  # both have their middle
        assert pc.intersects(P, R, pose, pose, method=method)
        assert pc.distance(P, R, pose, pose).distance == 0


@pytest.mark.parametrize("exponent", [-1068, -1060, -600, -560, -540, -535, -400, -10, 10])
def test_origin_radius_and_radius_are_upper_bounds(exponent):
    rng = np.random.default_rng(7)
    for n in (1, 2, 5, 30):
        body = pc.Polytope(np.ldexp(rng.uniform(-1, 1, (n, 3)), exponent))
        points = [[Fraction(x) for x in v] for v in body.vertices.tolist()]
        centre = [Fraction(x) for x in body.centre.tolist()]
        assert Fraction(body.core.origin_radius) ** 2 >= max(sum(x * x for x in v) for v in points)
        squares = (sum((x - c) ** 2 for x, c in zip(v, centre, strict=True)) for v in points)
        assert Fraction(body.core.radius) ** 2 >= max(squares)


@pytest.mark.parametrize("exponent", [-307, -300, -200, -165, -160, -150, -125, -121, -100, 0, 40])
def test_distances_at_any_scale(exponent):
    """Within 1e-9 of max(distance, 1e-3 of the size); below 1e-121 m the double-double stage used to stand aside."""
    rng, scale = np.random.default_rng(8), 10.0**exponent
    apart = 0
    for k in range(25):
        family = ("round", "box", "flat", "plate", "segment")[k % 5]
        P, R = (
            pc.Polytope(base_points(family, 12, rng) * scale, inflation_radius=s * scale)
            for s in (0.0, 0.1 * (k % 3 == 0))
        )
        pose = contacts.identities(1)[0]
        turn = contacts.turns_onto(contacts.random_directions(1, rng), contacts.random_directions(1, rng), rng)
        pose[:3, :3] = turn[0]
        pose[:3, 3] = contacts.random_directions(1, rng)[0] * (0.3, 0.8, 1.01, 2, 1e3)[k // 5] * scale
        truth = exact.distance(P.vertices, R.vertices, pose, None, P.inflation_radius, R.inflation_radius)
        found = pc.distance(P, R, pose)
        assert (found.distance == 0) == (truth == 0)
        assert np.isfinite(found.lower_bound)
        if truth > 0:
            apart += 1
            least = Fraction(1e-3 * max(P.core.radius, R.core.radius))
            off = Fraction(1, 10**9) * max(Fraction(truth), least)
            assert abs(Fraction(found.distance) - Fraction(truth)) <= off
            assert Fraction(found.lower_bound) <= Fraction(truth) * (1 + Fraction(1, 2**52))
    assert 5 < apart < 25


@pytest.mark.parametrize("exponent", [-120, -149, -153, -157, -159, -161, -165, -200, -300])
def test_planar_bodies_that_touch_at_any_scale(exponent):
    """Found by an audit: circles were compared by squares that were denormal. Two squares, corner on corner."""
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    at = np.array([[-1, -1], [-1, 0], [3, 3], [3, 1], [1, 1], [-1 - 2**-20, 0], [3 + 2**-20, 3]])
    for odd in (1, 1.25, 1.375, 1.75, 1.8125):
        scale = odd * 2.0 ** round(exponent * np.log2(10))
        robot, scene = pc.planar.Robot(square * scale), pc.planar.Scene()
        scene.add_polygon("other", (square + 1) * scale)
        q = np.column_stack([at * scale, np.zeros(len(at))])
        for bounds in (True, False):
            checker = pc.planar.Checker(robot, scene, bounds=bounds)
            assert checker.check_states(q).tolist() == [False] * 5 + [True] * 2


def test_what_is_beyond_the_range_is_refused():
    """Coordinates and radii beyond 1e50 m, poses beyond 1e-6 off rigid, reflections; what is just within is taken."""
    pc.Polytope(UNIT * 1e50, inflation_radius=1e50)
    for vertices, inflation_radius, words in (
        (UNIT * 1.01e50, 0.0, "coordinates"),
        (UNIT, 1.01e50, "inflation radius"),
        (UNIT, -1e-300, "inflation radius"),
    ):
        with pytest.raises(pc.PlannercheckError, match=words):
            pc.Polytope(vertices, inflation_radius=inflation_radius)
    cube, pose = pc.Polytope(UNIT), np.eye(4)
    for stretch, taken in ((0.499e-6, True), (0.501e-6, False), (-0.499e-6, True), (-0.501e-6, False)):
        pose[0, 0] = 1 + stretch
        pose[0, 3] = np.finfo(float).max
        if taken:
            assert not pc.intersects(cube, cube, pose)
        else:
            with pytest.raises(pc.PlannercheckError, match="rigid"):
                pc.intersects(cube, cube, pose)
    with pytest.raises(pc.PlannercheckError, match="pose"):
        pc.intersects(cube, cube, np.diag([1.0, 1, -1, 1]))


@pytest.mark.parametrize("method", METHODS)
def test_bodies_at_the_ends_of_the_range_of_doubles(method):
    """The largest translations, whose differences overflow, and the least sizes, whose products underflow."""
    largest = np.finfo(float).max
    places = [
        (largest, 0, 0),
        (-largest, 0, 0),
        (largest, largest, 0),
        (np.nextafter(largest, 0), 0, 0),
        (1e-170, 0, 0),
    ]
    for size_p, size_r, inflation_radius in itertools.product(
        (1e-310, 1e-162, 1.0, 1e49), (1e-310, 1.0), (0.0, 1e-200, 1e50)
    ):
        P, R = (
            pc.Polytope((UNIT - 0.5) * size_p, inflation_radius=inflation_radius),
            pc.Polytope((UNIT - 0.5)[:4] * size_r),
        )
        for at_p, at_r in itertools.combinations_with_replacement(places, 2):
            poses = contacts.identities(2)
            poses[:, :3, 3] = at_p, at_r
            truth = exact_verdicts.intersects(P.vertices, R.vertices, *poses, P.inflation_radius, R.inflation_radius)
            assert pc.intersects(P, R, *poses, method=method) == truth


@pytest.mark.parametrize("method", ["exact", "oracle"])
def test_denormal_and_normal_numbers_add_up(method):
    """A box ends at the smallest normal double and a denormal one; another begins there, posed by the normal one."""
    normal, last = 2.0**-1022, 2.0**-1074
    first = pc.Polytope(UNIT * (normal + 64 * last))
    for steps, shared in ((63, True), (64, True), (65, False), (96, False)):
        second = pc.Polytope(steps * last + UNIT * normal)
        pose = np.eye(4)
        pose[:3, 3] = normal
        assert exact_verdicts.intersects(first.vertices, second.vertices, np.eye(4), pose) == shared
        assert pc.intersects(first, second, None, pose, method) == shared
        assert pc.intersects(second, first, pose, None, method) == shared


@pytest.mark.parametrize("radius", [3e-162, 1e-161, 4e-161, 1e-160])
def test_tiny_balls_that_overlap_are_never_apart(radius):
    """Squares of their distances are a few of the least doubles."""
    rng = np.random.default_rng(3)
    ball = pc.Polytope([[0.0, 0.0, 0.0]], inflation_radius=radius)
    for away in rng.normal(size=(200, 3)):
        pose = np.eye(4)
        pose[:3, 3] = 1.998 * radius * away / np.linalg.norm(away)
        assert pc.intersects(ball, ball, np.eye(4), pose)
