"""Points near a posed body in lanes (cpp/narrow_phase/points_near_hull), against exact arithmetic of the oracle."""

import exact_verdicts
import numpy as np
import pytest
from poses import pose_at

import plannercheck as pc
from plannercheck.common.core import core
from plannercheck.evaluation.stress.body_families import MESHES, THIN_FAMILIES, family, mesh_points
from plannercheck.evaluation.stress.oracle import compiled_oracle

GAPS = np.array([0.0, 0.0, 1e-16, -1e-16, 1e-15, -1e-15, 1e-12, -1e-12, 1e-6, -1e-6, 1e-3, -1e-3, 0.05, -0.05, 0.3])
BODIES = [
    ("box", 8),
    ("round", 12),
    ("round", 400),
    ("cloud", 60),
    ("flat", 80),
    ("needle", 40),
    ("prism", 60),
    ("cone", 50),
    ("fan", 70),
    ("doubling", 60),
    ("lattice", 60),
    ("plate", 20),
    ("tilted plate", 20),
    ("sliver", 8),
    ("segment", 2),
    ("point", 1),
    (MESHES[0], 0),
    (MESHES[3], 0),
]


def body_of(name, n, inflation_radius=0.0):
    if name in MESHES:
        return pc.Polytope(mesh_points(name), inflation_radius=inflation_radius)
    if name in THIN_FAMILIES:
        return pc.Polytope(THIN_FAMILIES[name](n, np.random.default_rng(1)), inflation_radius=inflation_radius)
    return pc.Polytope(family(name, n, 1), inflation_radius=inflation_radius)


def near(body, pose, frame, points, radii, filters=True):
    xyz = np.ascontiguousarray(np.asarray(points, dtype=float).T)
    return core.points_near_hull(body.core, pose, frame, xyz, np.asarray(radii, dtype=float), filters)[0].astype(bool)


def truth(body, pose, frame, points, radii):
    oracle = compiled_oracle()
    hull = oracle.Points(body.vertices, body.inflation_radius)
    found = np.empty(len(points), dtype=bool)
    for k, (point, radius) in enumerate(zip(points, radii, strict=True)):
        verdict = oracle.decide(hull, pose[None], oracle.Points(point[None], radius), frame[None], False)[0]
        if verdict == 2:
            verdict = exact_verdicts.intersects(body.vertices, point[None], pose, frame, body.inflation_radius, radius)
        found[k] = verdict == 1
    return found


def points_about(rng, body, pose, frame, n):
    """Points at about their radii from vertices, edges and inner parts of facets, in coordinates of the frame."""
    vertices = body.vertices @ pose[:3, :3].T + pose[:3, 3]
    direction = rng.normal(size=(n, 3))
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    furthest = np.argsort(-(direction @ vertices.T), axis=1)[:, : min(3, len(vertices))]
    weights = rng.exponential(size=furthest.shape) * (rng.random(furthest.shape) < 0.6)
    weights[:, 0] += 1e-3
    weights /= weights.sum(axis=1)[:, None]
    corners = vertices[furthest]
    on_hull = np.einsum("ij,ijk->ik", weights, corners)
    normal = (
        np.cross(corners[:, 1] - corners[:, 0], corners[:, -1] - corners[:, 0])
        if furthest.shape[1] > 2
        else np.zeros((n, 3))
    )
    with np.errstate(all="ignore"):
        normal = (
            normal / np.linalg.norm(normal, axis=-1, keepdims=True) * np.sign((normal * direction).sum(-1))[:, None]
        )
    facing = np.isfinite(normal).all(axis=-1, keepdims=True) & (rng.random((n, 1)) < 0.5)
    away = np.where(facing, normal, direction)
    radii = rng.choice([0.0, 0.01, 0.1, 0.5], n)
    world = on_hull + (radii + body.inflation_radius + rng.choice(GAPS, n))[:, None] * away
    anywhere = rng.random(n) < 0.15
    world[anywhere] = vertices.mean(axis=0) + rng.normal(size=(anywhere.sum(), 3)) * np.ptp(vertices, axis=0).max()
    return np.linalg.solve(frame[:3, :3], (world - frame[:3, 3]).T).T, radii


def assert_agree(body, pose, frame, points, radii):
    expected = truth(body, pose, frame, points, radii)
    np.testing.assert_array_equal(near(body, pose, frame, points, radii), expected)
    return expected


# 18 bodies, 3 inflation radii, 2 poses of 950 points each: 102,600 points.
@pytest.mark.parametrize(("name", "n"), BODIES)
def test_points_about_bodies_are_judged_as_by_exact_arithmetic(name, n):
    rng = np.random.default_rng([n, len(name)])
    for inflation_radius in (0.0, 0.02, 0.3):
        body = body_of(name, n, inflation_radius)
        for distance in (0.5, 20.0):
            pose, frame = pose_at(rng, distance), pose_at(rng, distance)
            points, radii = points_about(rng, body, pose, frame, 350)
            expected = assert_agree(body, pose, frame, points, radii)
            assert 0.1 < expected.mean() < 0.95


@pytest.mark.parametrize("count", range(1, 9))
def test_a_call_of_fewer_points_judges_these(count):
    rng = np.random.default_rng(count)
    body = pc.Polytope(family("round", 60, 1), inflation_radius=0.05)
    for _ in range(20):
        pose, frame = pose_at(rng, 1.0), pose_at(rng, 1.0)
        points, radii = points_about(rng, body, pose, frame, count)
        assert_agree(body, pose, frame, points, radii)


@pytest.mark.parametrize(("name", "n"), [("box", 8), ("round", 400), ("plate", 20), ("segment", 2), (MESHES[0], 0)])
def test_the_plain_path_judges_alike(name, n):
    rng = np.random.default_rng(n)
    body = body_of(name, n, 0.01)
    pose, frame = pose_at(rng, 1.0), pose_at(rng, 1.0)
    points, radii = points_about(rng, body, pose, frame, 3000)
    np.testing.assert_array_equal(
        near(body, pose, frame, points, radii), near(body, pose, frame, points, radii, filters=False)
    )


def test_points_that_touch_exactly_are_near():
    # Distances 5 to a facet, √(3² + 4²) to an edge, √(2² + 3² + 6²) = 7 to a corner, all without rounding.
    body, eye = pc.Polytope(np.indices((2, 2, 2)).reshape(3, 8).T * 8.0), np.eye(4)
    points = np.array(
        [[13.0, 4, 4], [11, 12, 4], [10, 11, 14], [-5, 1, 7], [-3, -4, 2], [-2, -3, -6], [8, 8, 8], [3, 0, 1]]
    )
    radii = np.array([5.0, 5, 7, 5, 5, 7, 0, 0])
    assert near(body, eye, eye, points, radii).all()
    less = np.nextafter(radii, -1)
    np.testing.assert_array_equal(near(body, eye, eye, points[:6], less[:6]), np.zeros(6, dtype=bool))
    outside = points.copy()
    outside[6], outside[7] = np.nextafter(points[6], 9), [3, np.nextafter(0, -1), 1]
    np.testing.assert_array_equal(near(body, eye, eye, outside[6:], radii[6:]), [False, False])


EXPONENTS = np.array([-323, -310, -300, -200, -162, -155, -100, -50, -10, -3, 0, 3, 10, 30, 45])


@pytest.mark.parametrize("seed", range(4))
def test_coordinates_of_any_scale(seed):
    rng = np.random.default_rng([seed, 7])
    for _ in range(120):
        k = int(rng.choice([1, 2, 3, 4, 8, 12]))
        vertices = rng.normal(size=(k, 3)) * 10.0 ** rng.choice(
            EXPONENTS, [(1, 1), (1, 3), (k, 1), (k, 3)][rng.integers(4)]
        )
        body = pc.Polytope(vertices, inflation_radius=rng.choice([0, 0, 1e-300, 1e-160, 1e-3, 1e30]))
        pose, frame = np.eye(4), np.eye(4)
        if rng.integers(2):
            pose, frame = pose_at(rng, 10.0 ** rng.choice(EXPONENTS)), pose_at(rng, 10.0 ** rng.choice(EXPONENTS))
        if rng.integers(2):
            frame = pose
        points = np.concatenate(
            [
                vertices[rng.integers(k, size=4)] * rng.choice([1, 1, 0.5, 1 + 1e-15, 2]),
                rng.normal(size=(4, 3)) * 10.0 ** rng.choice(EXPONENTS),
            ]
        )
        radii = 10.0 ** rng.choice(EXPONENTS, 8) * (rng.random(8) < 0.5)
        assert_agree(body, pose, frame, points, radii)
