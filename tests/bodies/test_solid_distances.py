"""Distances of solids, held against the least distance of all pairs of triangles."""

import numpy as np
import pytest
from poses import at, pose_at

import plannercheck as pc
from plannercheck.common.core import core


def _crumpled(rng: np.random.Generator, around: int = 8) -> pc.Solid:
    """A closed surface of random bumps and dents."""
    u = 2 * np.pi * np.arange(around) / around
    rows = [
        np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.full(around, np.cos(v))], axis=1)
        * rng.uniform(0.3, 1, (around, 1))
        for v in np.linspace(0.3, np.pi - 0.3, 4)
    ]
    points = np.concatenate([*rows, [[0, 0, 0.9], [0, 0, -0.9]]])
    k, after = np.arange(around), (np.arange(around) + 1) % around
    triangles = [np.stack([np.full(around, len(points) - 2), k, after], axis=1)]
    for row in range(3):
        low, high = row * around, (row + 1) * around
        triangles += [np.stack([low + k, high + k, high + after], axis=1)]
        triangles += [np.stack([low + k, high + after, low + after], axis=1)]
    triangles += [np.stack([np.full(around, len(points) - 1), 3 * around + after, 3 * around + k], axis=1)]
    return pc.Solid(points, np.concatenate(triangles))


def _least_of_triangles(a: pc.Solid, b: pc.Solid, pose_a, pose_b) -> float:
    of_b = [pc.Polytope(b.vertices[t]) for t in b.triangles]
    of_a = [pc.Polytope(a.vertices[t]) for t in a.triangles]
    return min(pc.distance(one, other, pose_a, pose_b).distance for one in of_a for other in of_b)


@pytest.mark.parametrize("seed", range(6))
def test_the_distance_is_the_least_one_of_all_triangles(seed):
    rng = np.random.default_rng(seed)
    a, b = _crumpled(rng), _crumpled(rng)
    pose_a, pose_b = pose_at(rng, 0.8), pose_at(rng, 0.8)
    pose_b[:3, 3] += [1.2, 0.2 * seed, 0]
    found = pc.distance(a, b, pose_a, pose_b)
    if pc.intersects(a, b, pose_a, pose_b):
        assert found.distance == 0
        return
    least = _least_of_triangles(a, b, pose_a, pose_b)
    assert found.distance == pytest.approx(least, rel=1e-8)
    assert 0 < found.lower_bound <= found.distance
    assert np.linalg.norm(found.point_p - found.point_r) == pytest.approx(found.distance, rel=1e-8)


def test_inflated_solids_are_nearer_by_both_radii():
    rng = np.random.default_rng(7)
    solids = [_crumpled(rng) for _ in range(2)]
    pose = at(2.5, 0.2, -0.1)
    between, less = (
        pc.distance(
            *(
                pc.Polytope(solid.used[0], inflation_radius=radius).of_solid(solid)
                for solid, radius in zip(solids, radii, strict=True)
            ),
            None,
            pose,
        ).distance
        for radii in ((0, 0), (0.1, 0.02))
    )
    assert less == pytest.approx(between - 0.12, rel=1e-12)


def test_a_ball_in_a_hollow_is_as_far_as_the_next_wall():
    points, faces = pc.Box((4.0, 4.0, 4.0)).vertices_and_faces()
    outer = np.concatenate([[[f[0], f[1], f[2]], [f[0], f[2], f[3]]] for f in faces])
    hollow = pc.Solid(np.concatenate([points, points / 2]), np.concatenate([outer, outer[:, ::-1] + len(points)]))
    place = at(0.25)
    assert pc.distance(hollow, pc.Sphere(0.25), None, place).distance == pytest.approx(0.5)
    place[0, 3] = 1.5
    assert pc.distance(hollow, pc.Sphere(0.25), None, place).distance == 0


def test_clearances_of_solids_are_those_of_their_pairs():
    robot = pc.Robot.load("ur10", geometry="solid")
    checker = pc.Checker(robot)
    q = robot.random_configurations(30, seed=5)
    valid, clearances = checker.check_states(q), checker.clearances(q)
    assert ((clearances > 0) == valid).all()
    poses = checker.body_poses(q)
    for row in np.flatnonzero(valid)[:5]:
        pairs = checker.pairs.tolist()
        apart = [
            core.distance_batch(checker.polytopes[a].core, poses[row, [a]], checker.polytopes[b].core, poses[row, [b]])[
                1
            ][0]
            for a, b in pairs
        ]
        assert clearances[row] == pytest.approx(min(apart), rel=1e-9)
    assert (checker.clearances(q, lower_bound=True)[valid] <= clearances[valid]).all()
