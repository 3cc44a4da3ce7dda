"""Motions of solids: through rings that hulls fill, held against states in between and against distances."""

import warnings

import numpy as np
import pytest
import solid_meshes
from carriages import carriage

import plannercheck as pc


def ring(around: int = 32, across: int = 12, radius: float = 0.3) -> pc.Solid:
    """A ring of radius 1 about x."""
    points, triangles = solid_meshes.ring(around, across, radius)
    return pc.Solid(np.roll(points, 1, axis=1), triangles)


def checker(tmp_path, radius: float, padding: float = 0.0) -> pc.Checker:
    path = tmp_path / "carriage.urdf"
    path.write_text(carriage("y", radius))
    scene = pc.Scene("ring")
    scene.add("ring", ring())
    return pc.Checker(pc.Robot.from_urdf(path), scene, padding=padding)


@pytest.fixture(scope="module")
def arm():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of open meshes
        return pc.Checker(pc.Robot.load("ur10", geometry="solid"))


@pytest.fixture(scope="module")
def arm_motions(arm):
    rng = np.random.default_rng(11)
    start = arm.robot.random_configurations(400, seed=11)
    return start, np.clip(start + rng.normal(size=start.shape) * 0.15, arm.robot.lower, arm.robot.upper)


@pytest.mark.parametrize("radius", [0.1, 0.6, 0.69])
def test_a_ball_flies_through_a_ring(tmp_path, radius):
    through = checker(tmp_path, radius)
    assert through.check_motion([-2.0, 0.0], [2.0, 0.0])
    assert not through.check_motion([-2.0, 0.71 - radius], [2.0, 0.71 - radius])


def test_a_ball_as_large_as_the_hole_does_not(tmp_path):
    """The ring's corners are 0.7 m off its axis, its edges are nearer."""
    stuck = checker(tmp_path, 0.7)
    assert not stuck.check_motion([-2.0, 0.0], [2.0, 0.0])
    found = stuck.explain_motion([-2.0, 0.0], [2.0, 0.0])
    assert not found.free
    assert 0.3 < found.free_until < 0.5


def test_padding_narrows_the_hole(tmp_path):
    assert checker(tmp_path, 0.5, padding=0.15).check_motion([-2.0, 0.0], [2.0, 0.0])
    assert not checker(tmp_path, 0.5, padding=0.21).check_motion([-2.0, 0.0], [2.0, 0.0])


def test_a_ball_inside_the_ring_itself_collides(tmp_path):
    """It touches no triangle, all the way."""
    inside = checker(tmp_path, 0.05)
    assert not inside.check_states([[0.0, 1.0], [0.01, 1.02]]).any()
    assert not inside.check_motion([0.0, 1.0], [0.01, 1.02])


def test_free_motions_have_no_colliding_state(arm, arm_motions):
    start, end = arm_motions
    free = arm.check_motions(start, end)
    assert 0.3 < free.mean() < 0.9
    t = np.linspace(0, 1, 65)[:, None]
    for q0, q1 in zip(start[free][:150], end[free][:150], strict=True):
        assert arm.check_states((1 - t) * q0 + t * q1).all()


def test_refused_motions_are_within_the_tolerance_somewhere(arm, arm_motions):
    start, end = arm_motions
    refused = np.flatnonzero(~arm.check_motions(start, end))
    for k in refused[:60].tolist():
        found = arm.explain_motion(start[k], end[k])
        at = found.collides_at if found.collides_at is not None else found.near_at
        assert at is not None
        assert arm.clearance((1 - at) * start[k] + at * end[k]) <= found.tolerance


def test_one_by_one_and_in_any_order(arm, arm_motions):
    start, end = arm_motions
    together = arm.check_motions(start, end)
    order = np.random.default_rng(1).permutation(len(start))
    np.testing.assert_array_equal(arm.check_motions(start[order], end[order]), together[order])
    assert [arm.check_motion(*ends) for ends in zip(start[:80], end[:80], strict=True)] == together[:80].tolist()


def test_a_motion_whose_hulls_meet_has_a_proof(arm, arm_motions):
    pytest.importorskip("flint")
    start, end = arm_motions
    with_hulls = pc.Checker(pc.Robot.load("ur10"))
    only_solids = np.flatnonzero(arm.check_motions(start, end) & ~with_hulls.check_motions(start, end))
    k = int(only_solids[0])
    proof = arm.explain_motion(start[k], end[k]).proof
    assert proof is not None
    assert proof.verify()


def test_a_pair_at_rest_whose_hulls_meet_hinders_no_motion(tmp_path):
    """A bead that the rail holds in the middle of the ring."""
    moving = checker(tmp_path, 0.1)
    scene = moving.scene.copy()
    scene.attach("bead", "rail", np.eye(4), (), pc.Sphere(0.2))
    held = moving.with_scene(scene)
    assert held.is_valid([2.0, 0.0])
    assert held.check_motion([2.0, 0.0], [2.0, 1.0])
    assert not held.check_motion([2.0, 0.0], [0.0, 0.0])
