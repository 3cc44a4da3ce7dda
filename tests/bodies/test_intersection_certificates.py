"""Certificates of the pair test in fractions: planes separate, points are shared, also by far less than a double."""

import itertools
from fractions import Fraction

import exact_verdicts
import numpy as np
import pytest
from pair_ways import CENTRE_AXIS, NEAR, PAIRS, UNIT
from poses import at
from solids import solid_of

import plannercheck as pc
from plannercheck.bodies import exact_reference as exact
from plannercheck.bodies.tuning import METHODS, pair_options
from plannercheck.common.core import core
from plannercheck.evaluation.stress import body_families as families
from plannercheck.evaluation.stress import contact_poses as contacts
from plannercheck.evaluation.stress.body_families import family


def test_the_point_of_spheres_is_in_both():
    P, R = pc.Polytope(np.zeros((1, 3)), inflation_radius=0.3), pc.Polytope(np.zeros((1, 3)), inflation_radius=0.2)
    for x in (0.0, 0.1, 0.4999):
        found = core.certify_pair(P.core, at(x, 0, 0), R.core, np.eye(4), pair_options(), False)
        assert found["stage"] == "centre axis"
        assert np.linalg.norm(found["point"] - [x, 0, 0]) <= P.inflation_radius
        assert np.linalg.norm(found["point"]) <= R.inflation_radius


@pytest.mark.parametrize("scale", [1.0, 1e-3, 3e5])
@pytest.mark.parametrize(
    ("options", "stage"),
    [
        ({}, "nearest points"),
        ({"nearest_points": False}, "double-double"),
        ({"nearest_points": False, "double_double": False}, "exact"),
    ],
)
def test_the_point_of_two_inflated_bodies_is_in_both(options, stage, scale):
    """Their hulls are apart by nearly both radii, which differ: it divides that way as the radii do."""
    rng = np.random.default_rng(36)
    names = [("point", "box"), ("needle", "round"), ("segment", "segment"), ("flat", "point")]
    for (first, second), inflation_radii in itertools.product(
        names, ((0.3, 0.02), (0.01, 0.4), (0.2, 0.2), (0.25, 0.0))
    ):
        points = [
            families.THIN_FAMILIES[name](20, rng) if name in families.THIN_FAMILIES else family(name, 20, 37)
            for name in (first, second)
        ]
        bodies = [
            pc.Polytope(p * scale, inflation_radius=s * scale) for p, s in zip(points, inflation_radii, strict=True)
        ]
        pose_p, pose_r = contacts.identities(2)
        pose_p[:3, :3], pose_r[:3, :3] = contacts.frames(contacts.random_directions(2, rng))
        pose_p[:3, 3] = 9 * scale * contacts.random_directions(1, rng)[0]
        apart = pc.distance(*bodies, pose_p, pose_r)
        pose_p[:3, 3] += (1 + 0.01 * sum(inflation_radii) * scale / apart.distance) * (apart.point_r - apart.point_p)
        for a, b in ((0, 1), (1, 0)):
            poses = [pose_p, pose_r] if a == 0 else [pose_r, pose_p]
            arguments = bodies[a].core, poses[0], bodies[b].core, poses[1]
            found = core.certify_pair(*arguments, pair_options(centre_axis=False, **options), False)
            assert (found["shared"], found["stage"]) == (True, stage)
            for body, pose in zip((bodies[a], bodies[b]), poses, strict=True):
                beyond = exact.distance(
                    found["point"][None], body.vertices, None, pose, inflation_r=body.inflation_radius
                )
                assert beyond <= 1e-13 * scale


def test_a_plane_found_by_balls_is_no_wider_than_the_b():
    """Kept for the next pose, it must not separate bodies that overlap on the same side."""
    (_, P), (_, R) = solid_of("round", 80, 33), solid_of("box", 8, 34)
    directions = contacts.unit(np.random.default_rng(35).normal(size=(60, 3)))
    poses = contacts.identities(120)
    poses[0::2, :3, 3], poses[1::2, :3, 3] = 3 * directions, 0.7 * directions
    truth = [exact_verdicts.intersects(P.vertices, R.vertices, pose, np.eye(4)) for pose in poses]
    assert sum(truth) > 30
    for a, b in ((P, R), (R, P)):
        turned = poses if a is P else np.linalg.inv(poses)
        shared, stages, _ = core.intersect_batch(a.core, turned, b.core, np.eye(4)[None], pair_options())
        assert shared.astype(bool).tolist() == truth
        assert (stages[0::2] == CENTRE_AXIS).all()


def posed_fractions(vertices, pose):
    matrix = [[Fraction(x) for x in row] for row in pose.tolist()]
    return [
        [sum(m * Fraction(x) for m, x in zip(row, v, strict=False)) + row[3] for row in matrix[:3]]
        for v in vertices.tolist()
    ]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("first", "second", "n"), PAIRS[:9])
def test_certificates_prove_their_verdicts(first, second, n, method):
    (p, P), (r, R) = solid_of(first, n, 11), solid_of(second, n, 12)
    for pose_p, pose_r in zip(*contacts.contact_poses(p, r, np.array(NEAR), np.random.default_rng(n)), strict=True):
        certificate = pc.certify(P, R, pose_p, pose_r, method)
        truth = exact_verdicts.intersects(P.vertices, R.vertices, pose_p, pose_r)
        assert isinstance(certificate, pc.SharedPoint) == truth
        if truth:
            assert_shared(certificate.point, P, R, pose_p, pose_r)
        else:
            assert_separates(certificate, P, R, pose_p, pose_r)


def assert_separates(plane, P, R, pose_p, pose_r):
    """The exact plane separates; its gap, from below, is one of the distance."""
    assert plane.verify()
    normal = plane.exact().normal
    above = min(sum(a * b for a, b in zip(normal, v, strict=True)) for v in posed_fractions(P.vertices, pose_p))
    below = max(sum(a * b for a, b in zip(normal, v, strict=True)) for v in posed_fractions(R.vertices, pose_r))
    assert above > below
    assert (above - below) ** 2 >= Fraction(plane.gap) ** 2 * sum(x * x for x in normal)
    assert plane.gap <= exact.distance(P.vertices, R.vertices, pose_p, pose_r) * (1 + 1e-15)


def assert_shared(point, P, R, pose_p, pose_r):
    """The point is in both bodies, up to the rounding of posing and mixing it."""
    for body, pose in ((P, pose_p), (R, pose_r)):
        size = np.abs(body.vertices).max() + np.abs(pose[:3, 3]).max()
        ball = 1e-14 * size * (UNIT * 2 - 1)
        assert exact_verdicts.intersects(point + ball, body.vertices, None, pose)


def test_a_separations_normal_points_from_second_to_first():
    cube = pc.Polytope(UNIT)
    for method in METHODS:
        plane = pc.certify(cube, cube, at(3), None, method)
        assert plane.normal[0] > 0.5
        assert 1.0 < plane.offset < 3.0
        assert 0 < plane.gap <= 2.0
        assert pc.certify(cube, cube, None, at(3), method).normal[0] < -0.5


@pytest.mark.parametrize("power", [-60, -90, -300])
def test_certificates_of_gaps_far_below_a_double(power):
    cube = pc.Polytope(UNIT)
    slanted = np.eye(4)
    slanted[:3, :3] = contacts.frames(np.array([[1.0, 2.0, 3.0]]) / np.sqrt(14))[0]
    for turn in (np.eye(4), slanted):
        for sign in (1, 0, -1):
            certificate = pc.certify(cube, cube, turn @ at(sign * 2.0**power), turn @ at(-1.0))
            assert certificate.verify()
            if turn is not slanted:
                assert isinstance(certificate, pc.Separation) == (sign > 0)


@pytest.mark.parametrize("power", [-60, -90])
def test_the_plane_of_double_double_is_exact(power):
    cube = pc.Polytope(UNIT)
    found = core.certify_pair(cube.core, at(2.0**power), cube.core, at(-1.0), pair_options(), True)
    assert found["stage"] == "double-double"
    assert not found["shared"]
    assert len(found["exact_normal"]) == 3
