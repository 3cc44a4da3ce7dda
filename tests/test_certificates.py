"""What proves a verdict: planes and their gaps, in exact arithmetic."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from families import family

import plannercheck as pc
from plannercheck import exact
from plannercheck.certificates import separation

CUBE = family("box", 8, 0)


def shifted(*by):
    pose = np.eye(4)
    pose[:3, 3] = by
    return pose


def test_the_plane_is_halfway_and_its_normal_a_unit_vector():
    plane = separation(np.array([4.0, 0, 0]), np.array([[3.0, 0, 0], [5, 1, 1]]), np.array([[1.0, 2, 0]]), 10.0)
    np.testing.assert_array_equal(plane.normal, [1, 0, 0])
    assert plane.offset == 2
    assert 2 - 1e-13 < plane.gap < 2


def test_a_gap_below_rounding_is_none():
    plane = separation(np.array([1.0, 0, 0]), np.array([[1 + 2e-16, 0, 0]]), np.array([[1.0, 0, 0]]), 4.0)
    assert plane.gap == 0


def test_gaps_are_at_most_the_distance():
    rng = np.random.default_rng(1)
    P, R = pc.Polytope(family("round", 60, 1)), pc.Polytope(family("cone", 60, 2))
    for _ in range(40):
        direction = rng.normal(size=3)
        pose = shifted(*(direction / np.linalg.norm(direction) * rng.uniform(0.8, 3)))
        certificate = pc.certify(P, R, pose)
        distance = exact.distance(P.vertices, R.vertices, pose, None)
        assert isinstance(certificate, pc.Separation) == (distance > 0)
        if distance > 0:
            assert 0 < certificate.gap <= distance


def test_gaps_stay_below_the_distance_where_posing_cancels():
    # Two boxes face to face; one is far from its own frame's origin and posed back to the world's, which rounds a lot.
    rng = np.random.default_rng(2)
    R = pc.Polytope(CUBE)
    for _ in range(60):
        far = rng.normal(size=3) * 1e6
        P = pc.Polytope(CUBE + far)
        pose_p, pose_r = np.eye(4), np.eye(4)
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        turn *= np.sign(np.linalg.det(turn))
        pose_p[:3, :3] = pose_r[:3, :3] = turn
        pose_p[:3, 3] = turn @ [np.ptp(CUBE[:, 0]) + 10.0 ** rng.uniform(-9, -8), 0, 0] - turn @ far
        certificate = pc.certify(P, R, pose_p, pose_r)
        if isinstance(certificate, pc.Separation):
            assert certificate.gap <= exact.distance(P.vertices, R.vertices, pose_p, pose_r)


def test_certificates_are_frozen():
    cube = pc.Polytope(CUBE)
    for certificate in (pc.certify(cube, cube), pc.certify(cube, cube, shifted(2, 0, 0))):
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(certificate, dataclasses.fields(certificate)[0].name, None)


def test_two_touching_cubes_share_a_point_of_both():
    unit = pc.Polytope((CUBE > 0).astype(float))
    point = pc.certify(unit, unit, shifted(1, 0.25, 0.5)).point
    assert point[0] == 1
    assert 0.25 <= point[1] <= 1
    assert 0.5 <= point[2] <= 1
