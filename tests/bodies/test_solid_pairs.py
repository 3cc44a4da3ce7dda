"""Pairs of solids against brute force: all pairs of triangles, and winding numbers as sums of solid angles."""

from itertools import product

import numpy as np
import pytest
from poses import random_pose
from solid_meshes import box, brute, inflated, is_inside, meshes, prepared, triangles_meet

from plannercheck.common.core import core

SEEDS = range(2)


@pytest.mark.parametrize("seed", SEEDS)
def test_pairs_against_all_pairs_of_triangles(seed):
    rng = np.random.default_rng(seed)
    every = meshes()
    bodies = {name: prepared(mesh) for name, mesh in every.items()}
    answers = []
    for first, second in product(every, repeat=2):
        a, b = random_pose(rng, 0.4), random_pose(rng, 0.6)
        expected = brute(every[first], a, every[second], b)
        kind = core.solids_contact(bodies[first], a, bodies[second], b)[0]
        assert (kind != "apart") == expected, (first, second)
        answers.append(kind)
    assert {"apart", "triangles"} <= set(answers)


@pytest.mark.parametrize("order", range(4))
def test_the_order_of_triangles_and_points_does_not_matter(order):
    rng = np.random.default_rng(10 + order)
    every = meshes()
    mesh, other = every["fine ring"], every["ring"]
    points = rng.permutation(len(mesh[0]))
    place = np.argsort(points)
    turns = rng.integers(3, size=len(mesh[1]))
    triangles = np.stack([np.roll(t, k) for t, k in zip(place[mesh[1]], turns, strict=True)])
    shuffled = mesh[0][points], triangles[rng.permutation(len(triangles))]
    one, two, third = prepared(mesh), prepared(shuffled), prepared(other)
    for _ in range(40):
        a, b = random_pose(rng, 0.4), random_pose(rng, 0.4)
        verdicts = {core.solids_contact(body, a, third, b)[0] == "apart" for body in (one, two)}
        verdicts |= {core.solids_contact(third, b, body, a)[0] == "apart" for body in (one, two)}
        assert len(verdicts) == 1


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_what_touches_exactly_collides_at_any_scale(scale):
    """Boxes face to face, edge on edge and corner on corner: signs that rounding leaves open are found exactly."""
    points, triangles = box(scale)
    body = prepared((points, triangles))
    for step in ((2, 0, 0), (2, 2, 0), (2, 2, 2), (2, 0.5, 0.25), (-2, 2, 1)):
        near, far = np.eye(4), np.eye(4)
        near[:3, 3] = scale * np.array(step)
        far[:3, 3] = near[:3, 3] * (1 + 2.0**-50)
        assert core.solids_contact(body, np.eye(4), body, near)[0] == "triangles"
        assert core.solids_contact(body, np.eye(4), body, far)[0] == "apart"


def test_inflated_solids_meet_where_their_triangles_are_near():
    rng = np.random.default_rng(5)
    every = meshes()
    radius, met = 0.15, []
    names = ("ring", "box beside a ring", "one triangle", "open box")
    for first, second in product(names, repeat=2):
        for _ in range(2):
            a, b = random_pose(rng, 0.5), random_pose(rng, 0.7)
            near = triangles_meet(every[first], a, every[second], b, radius)
            inside = is_inside(every[first], a, every[second], b) or is_inside(every[second], b, every[first], a)
            body, other = inflated(every[first], 0.1), inflated(every[second], 0.05)
            assert (core.solids_contact(body, a, other, b)[0] != "apart") == (near or inside)
            met.append(near)
    assert 0 < sum(met) < len(met)


def test_what_is_found_is_a_pair_of_triangles_that_meets():
    rng = np.random.default_rng(7)
    mesh, other = meshes()["fine ring"], meshes()["nested boxes"]
    one, two = prepared(mesh), prepared(other)
    found = 0
    for _ in range(60):
        a, b = random_pose(rng, 0.5), random_pose(rng, 0.5)
        kind, i, j, _ = core.solids_contact(one, a, two, b)
        if kind == "triangles":
            found += 1
            assert triangles_meet((mesh[0], mesh[1][[i]]), a, (other[0], other[1][[j]]), b)
    assert found > 20


def test_bodies_that_share_a_corner_share_it_at_any_pose():
    """Both are posed alike, so a common vertex stays one, while rounding of the rest goes either way."""
    rng = np.random.default_rng(9)
    tip = np.array([0.3, -0.2, 0.1]) / 3
    triangles = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    for _ in range(40):
        corners = rng.uniform(0.1, 1, (3, 3))
        first = prepared((np.concatenate([[tip], tip + corners]), triangles))
        second = prepared((np.concatenate([[tip], tip - rng.permuted(corners, axis=0)]), triangles[:, ::-1]))
        pose = random_pose(rng, 3.0)
        assert core.solids_contact(first, pose, second, pose)[0] == "triangles"


@pytest.mark.parametrize(("height", "meets"), [(0.149, True), (0.151, False)])
def test_a_small_triangle_over_the_middle_of_a_large_one_meets_it_within_the_radii(height, meets):
    large = inflated((np.array([[-2.0, -2, 0], [3, -2, 0], [-2, 3, 0]]), np.array([[0, 1, 2]])), 0.1)
    small = inflated((np.array([[-0.1, 0, height], [0.1, 0, height], [0, 0.1, height]]), np.array([[0, 1, 2]])), 0.05)
    for one, other in ((large, small), (small, large)):
        assert (core.solids_contact(one, np.eye(4), other, np.eye(4))[0] == "triangles") == meets
