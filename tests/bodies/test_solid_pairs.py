"""Pairs of solids against brute force: all pairs of triangles, and winding numbers as sums of solid angles."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from plannercheck.common.core import core

SEEDS = range(2)
# A vertex's sum of solid angles, over 4π, is this close to a whole number unless it is on a triangle.
NEAR_WHOLE = 1e-6


def ring(around, across, radius):
    """Points and triangles of a ring of radius 1 about z."""
    u, v = (each.ravel() for each in np.meshgrid(np.arange(around), np.arange(across), indexing="ij"))
    a, b = 2 * np.pi * u / around, 2 * np.pi * v / across
    reach = 1 + radius * np.cos(b)
    points = np.stack([reach * np.cos(a), reach * np.sin(a), radius * np.sin(b)], axis=-1)
    here, right = u * across + v, (u + 1) % around * across + v
    up, both = u * across + (v + 1) % across, (u + 1) % around * across + (v + 1) % across
    return points, np.concatenate([np.stack([here, right, both], 1), np.stack([here, both, up], 1)])


def box(size=1.0):
    points = size * np.array(list(product((-1.0, 1.0), repeat=3)))
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return points, np.array([t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))])


def both(first, second, flipped=False):
    (p, s), (q, t) = first, second
    return np.concatenate([p, q]), np.concatenate([s, (t[:, ::-1] if flipped else t) + len(p)])


def meshes():
    return {
        "box": box(),
        "small box": box(0.1),
        "ring": ring(9, 5, 0.3),
        "fine ring": ring(14, 6, 0.2),
        "hollow box": both(box(), box(0.6), flipped=True),
        "nested boxes": both(box(), box(0.6)),
        "box beside a ring": both(ring(8, 4, 0.2), box(0.2)),
        "open box": (box()[0], box()[1][2:]),
        "one triangle": (np.array([[0, 0, 0], [1.5, 0, 0], [0, 1.2, 0.3]]), np.array([[0, 1, 2]])),
    }


def prepared(mesh):
    points, triangles = (np.ascontiguousarray(each) for each in mesh)
    solid = core.Solid(points, triangles.astype(np.int32))
    used = np.ascontiguousarray(points[np.unique(triangles)])
    return core.Polytope.from_points(used, 0.0).with_solid(solid)


def inflated(mesh, radius):
    points, triangles = (np.ascontiguousarray(each) for each in mesh)
    solid = core.Solid(points, triangles.astype(np.int32))
    return core.Polytope.from_points(np.ascontiguousarray(points[np.unique(triangles)]), radius).with_solid(solid)


def random_pose(rng, spread):
    pose = np.eye(4)
    q, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    pose[:3, :3] = q * np.sign(np.linalg.det(q))
    pose[:3, 3] = spread * rng.normal(size=3)
    return pose


def at(mesh, pose):
    points, triangles = mesh
    return (points @ pose[:3, :3].T + pose[:3, 3])[triangles]


def triangles_meet(first, a, second, b, radius=0.0):
    """Whether any triangle of one shares a point with any of the other, each tried with each."""
    options = core.PairOptions(core.Solver.oracle, *[True] * 8)
    corners = at(second, b)
    low, high = corners.min(axis=1) - radius - 1e-9, corners.max(axis=1) + radius + 1e-9
    others = [core.Polytope.from_points(np.ascontiguousarray(second[0][t]), 0.0) for t in second[1]]
    for i, posed in enumerate(at(first, a)):
        near = ((posed.min(axis=0) <= high) & (posed.max(axis=0) >= low)).all(axis=1)
        p = core.Polytope.from_points(np.ascontiguousarray(first[0][first[1][i]]), radius)
        for j in np.flatnonzero(near):
            r = others[j]
            if core.intersect_batch(p, a[None].copy(), r, b[None].copy(), options)[0][0]:
                return True
    return False


def winding(point, mesh, pose):
    """The winding number of a point that is on no triangle; solid angles as Van Oosterom and Strackee give them."""
    a, b, c = np.moveaxis(at(mesh, pose) - point, 1, 0)
    x, y, z = (np.linalg.norm(each, axis=1) for each in (a, b, c))
    below = x * y * z + (a * b).sum(1) * z + (b * c).sum(1) * x + (c * a).sum(1) * y
    number = 2 * np.arctan2((a * np.cross(b, c)).sum(1), below).sum() / (4 * np.pi)
    assert abs(number - round(number)) < NEAR_WHOLE
    return round(number)


def is_inside(inner, a, outer, b):
    if not core.Solid(np.ascontiguousarray(outer[0]), np.ascontiguousarray(outer[1], dtype=np.int32)).is_closed:
        return False
    points = inner[0] @ a[:3, :3].T + a[:3, 3]
    return any(winding(points[v], outer, b) != 0 for v in np.unique(inner[1]))


def brute(first, a, second, b):
    return triangles_meet(first, a, second, b) or is_inside(first, a, second, b) or is_inside(second, b, first, a)


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
