"""Planes along the edges of boxes, and faces of boxes against hulls: what they separate, and that they leave contacts.

Poses are chosen so that only such a plane separates. Truth is exact arithmetic.
"""

import numpy as np
import pytest
from test_filter_bounds import CUBE, OCTAHEDRON, checker_of, free_bodies, stretched

import plannercheck as pc
from plannercheck.bodies.tuning import pair_options
from plannercheck.common.core import core
from plannercheck.evaluation.stress.contact_poses import identities
from plannercheck.evaluation.stress.random_cases import OFF_RIGID

# From what separates for sure to overlaps that rounding in floats and poses off rigid hide.
GAPS = np.concatenate([np.full(24, 1e-3), np.geomspace(1e-12, 1e-5, 40), -np.geomspace(1e-12, 1e-5, 40)])
BAR = CUBE * (2.0, 0.1, 0.1)
HALF_DIAGONAL = 0.05 * np.sqrt(2)


def turn_about(axis, angle):
    """A rotation (3, 3) about a coordinate axis."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    out = np.eye(3)
    out[i, i] = out[j, j] = np.cos(angle)
    out[j, i] = np.sin(angle)
    out[i, j] = -out[j, i]
    return out


def random_turns(n, rng):
    """Rotations (n, 3, 3)."""
    turns, _ = np.linalg.qr(rng.normal(size=(n, 3, 3)))
    return turns * np.sign(np.linalg.det(turns))[:, None, None]


def placed(turn_p, turn_r, offsets, rng):
    """Poses (n, 4, 4) of both bodies, r at offsets (n, 3) from p, all turned and moved anyhow."""
    n = len(offsets)
    world, poses_p, poses_r = random_turns(n, rng), identities(n), identities(n)
    poses_p[:, :3, :3], poses_r[:, :3, :3] = world @ turn_p, world @ turn_r
    poses_p[:, :3, 3] = rng.normal(size=(n, 3))
    poses_r[:, :3, 3] = poses_p[:, :3, 3] + np.einsum("kij,kj->ki", world, offsets)
    return poses_p, poses_r


def crossed_bars(gaps, rng):
    """Bars that cross, an edge of each facing the other: no face of theirs separates them."""
    offsets = np.zeros((len(gaps), 3))
    offsets[:, 2] = 2 * HALF_DIAGONAL + gaps
    across = turn_about(2, np.pi / 2) @ turn_about(0, np.pi / 4)
    return placed(turn_about(0, np.pi / 4), across, offsets, rng)


def corner_over_face(points, box, gaps, rng):
    """A face of a body faces that of a box: the body's own box sticks into it."""
    normal = np.ones(3) / np.sqrt(3)
    reach = (points @ normal).max() + box[:, 2].max()
    z = normal
    x = np.cross([0.0, 1.0, 0.0], z)
    x /= np.linalg.norm(x)
    turn = np.stack([x, np.cross(z, x), z], axis=1)
    return placed(np.eye(3), turn, (reach + gaps)[:, None] * normal, rng)


def shared(first, second, poses_p, poses_r):
    return core.intersect_batch(first.core, poses_p, second.core, poses_r, pair_options("exact"))[0].astype(bool)


def judged(first, second, kinematics, q, **switches):
    """Verdicts of states in a set, a few and one at a time; and what the filters and stages settled, by such a way."""
    counted = []
    found = []
    for rows in (len(q), 3, 1):
        checker = checker_of([first, second], [0, 1], [[0, 1]], **switches)
        parts = [
            checker.check_states(kinematics, np.ascontiguousarray(q[k : k + rows]), 1) for k in range(0, len(q), rows)
        ]
        found.append(~np.concatenate(parts).astype(bool))
        counted.append(checker.statistics())
    return found, counted


@pytest.mark.parametrize("off_rigid", [False, True])
def test_edges_of_boxes_separate_crossed_bars(off_rigid):
    """In sets, a few states and single ones; and they call no contact apart, also of poses off rigid."""
    rng = np.random.default_rng(1)
    bars = pc.Polytope(BAR), pc.Polytope(BAR)
    turns = identities(2)[:, :3, :3]
    kinematics, q = free_bodies(crossed_bars(GAPS, rng), stretched(turns, rng) if off_rigid else turns)
    posed = kinematics.link_poses(q, np.ones(2, dtype=np.uint8))
    expected = shared(*bars, *(np.ascontiguousarray(posed[:, k]) for k in range(2)))
    assert 0.05 < expected.mean() < 0.8
    found, counted = judged(*bars, kinematics, q)
    for each, statistics in zip(found, counted, strict=True):
        np.testing.assert_array_equal(each, expected)
        assert statistics["boxes"] >= 24


@pytest.mark.parametrize("seed", range(8))
def test_edges_of_boxes_leave_what_they_cross(seed):
    """Bars of any lengths at any angles, edge on edge, stretched anyhow: overlaps of 1e-12 to 1e-5 m are found."""
    rng = np.random.default_rng(seed)
    for _ in range(6):
        p, r = (pc.Polytope(CUBE * rng.uniform((0.5, 0.05, 0.05), (3, 0.2, 0.2))) for _ in range(2))
        half_p, half_r = (np.ptp(body.vertices, axis=0)[1:] / 2 for body in (p, r))
        n = 64
        angles, lean_p, lean_r = rng.uniform(0.3, np.pi - 0.3, n), *rng.uniform(0.2, np.pi / 2 - 0.2, (2, n))
        turn_p = np.stack([turn_about(0, a) for a in lean_p])
        turn_r = np.stack([turn_about(2, a) @ turn_about(0, b) for a, b in zip(angles, lean_r, strict=True)])
        heights = [
            half[0] * np.sin(lean) + half[1] * np.cos(lean) for half, lean in ((half_p, lean_p), (half_r, lean_r))
        ]
        offsets = np.zeros((n, 3))
        offsets[:, 2] = sum(heights)
        # The upper edge of the one is not above its middle, and the lower edge of the other not below its own.
        top = np.stack([np.zeros(n), half_p[0] * np.cos(lean_p) - half_p[1] * np.sin(lean_p), heights[0]], axis=1)
        low = np.stack([np.zeros(n), -half_r[0] * np.cos(lean_r) + half_r[1] * np.sin(lean_r), -heights[1]], axis=1)
        low = np.einsum("kij,kj->ki", np.stack([turn_about(2, a) for a in angles]), low)
        offsets[:, :2] = (top - low)[:, :2]
        offsets[:, 2] -= np.geomspace(1e-12, 1e-5, n)
        poses_p, poses_r = placed(turn_p, turn_r, offsets, rng)
        for poses in ((poses_p,), (poses_r,), (poses_p, poses_r), ())[seed % 4]:  # one alone: only it has room for that
            poses[:, :3, :3] = stretched(poses[:, :3, :3], rng)
        expected = shared(p, r, poses_p, poses_r)
        assert expected.any()
        both = np.ascontiguousarray(np.stack([poses_p, poses_r], axis=1))
        checker = checker_of([p, r], [0, 1], [[0, 1]])
        single = np.concatenate([checker.first_of_poses(pose[None], 1) for pose in both])
        for found in (checker.first_of_poses(both, 1), single):
            np.testing.assert_array_equal(found >= 0, expected)


# The body whose polar is better conditioned B: the box before an octahedron one of whose corners is far away, or
# else the octahedron.
SPIKED = np.where(OCTAHEDRON == -1, (-3.0, -1.0, -1.0), OCTAHEDRON)
FACES = [(SPIKED, CUBE), (OCTAHEDRON, CUBE * (1.0, 1.0, 0.1))]


@pytest.mark.parametrize("inflation_radius", [0.0, 0.1])
@pytest.mark.parametrize("off_rigid", [False, True])
@pytest.mark.parametrize(("points", "box"), FACES)
def test_faces_of_boxes_separate_hulls(points, box, off_rigid, inflation_radius):
    """In both orders; they call no contact apart, and verdicts are the same without them."""
    rng = np.random.default_rng(2)
    body, obstacle = pc.Polytope(points, inflation_radius=inflation_radius), pc.Polytope(box)
    turns = identities(2)[:, :3, :3]
    poses = corner_over_face(points, box, GAPS + inflation_radius, rng)
    kinematics, q = free_bodies(poses, stretched(turns, rng) if off_rigid else turns)
    posed = kinematics.link_poses(q, np.ones(2, dtype=np.uint8))
    expected = shared(body, obstacle, *(np.ascontiguousarray(posed[:, k]) for k in range(2)))
    assert 0.05 < expected.mean() < 0.8
    for on in (True, False):
        found, counted = judged(body, obstacle, kinematics, q, box_face=on, cached_plane=False, centre_axis=False)
        for each, statistics in zip(found, counted, strict=True):
            np.testing.assert_array_equal(each, expected)
            assert (statistics["box_face"] >= 24) == on


def test_the_plane_of_a_face_is_kept():
    """The next poses of the pair are told apart by it."""
    rng = np.random.default_rng(3)
    for points, box in FACES:
        body, obstacle = pc.Polytope(points), pc.Polytope(box)
        (pose_p,), (pose_r,) = corner_over_face(points, box, np.array([1e-3]), rng)
        both = np.repeat(np.stack([pose_p, pose_r])[None], 40, axis=0)
        checker = checker_of([body, obstacle], [0, 1], [[0, 1]])
        assert (checker.first_of_poses(both, 1) < 0).all()
        statistics = checker.statistics()
        assert (statistics["box_face"], statistics["cached_plane"]) == (1, 39)


def test_faces_against_stretched_hulls():
    """A body_a's box stretched along the normal of its face: the plane has room for how far it is off rigid."""
    box = CUBE * (1.0, 1.0, 0.1)
    body, obstacle = pc.Polytope(OCTAHEDRON), pc.Polytope(box)
    for sign in (-1, 1):
        stretch = np.diag([1.0, 1.0, 1 + sign * OFF_RIGID * 0.49])
        for gap in (0.0, 1e-9, -1e-9, 1e-7, -1e-7, 1e-3):
            poses_p, poses_r = corner_over_face(OCTAHEDRON, box, np.array([gap]), np.random.default_rng(4))
            poses_r[:, :3, :3] = poses_r[:, :3, :3] @ stretch
            expected = shared(body, obstacle, poses_p, poses_r)
            both = np.repeat(np.stack([poses_p, poses_r], axis=1), 9, axis=0)
            found = checker_of([body, obstacle], [0, 1], [[0, 1]]).first_of_poses(np.ascontiguousarray(both), 1) >= 0
            assert (found == expected).all()
