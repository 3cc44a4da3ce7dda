"""Motions over half-spaces: proved free only where no state in between collides, against dense states and tables."""

import numpy as np
import pytest
from poses import at

import plannercheck as pc


def room(robot, height):
    scene = pc.Scene("room")
    scene.add("floor", pc.HalfSpace((0.0, 0.0, 2.0), 2 * height))
    scene.add("wall", pc.HalfSpace((2.0, 1.0, 0.0), -0.8))
    for name in ("floor", "wall"):
        scene.allow(name, "panda_link0")
    return scene


def plates(height):
    """The same room of boxes, so large that the arm never sees their other sides."""
    scene, size = pc.Scene("plates"), 20.0
    pose = at(0, 0, height - size / 2)
    scene.add_box("floor", (size, size, size), pose)
    normal = np.array([2.0, 1.0, 0.0]) / np.sqrt(5.0)
    turned = np.eye(4)
    turned[:3, 0], turned[:3, 1] = normal, np.cross([0.0, 0.0, 1.0], normal)
    turned[:3, 3] = normal * (-0.8 / np.sqrt(5.0) - size / 2)
    scene.add_box("wall", (size, size, size), turned)
    for name in ("floor", "wall"):
        scene.allow(name, "panda_link0")
    return scene


def motions(robot, count, seed, length):
    rng = np.random.default_rng(seed)
    start = robot.random_configurations(count, seed=seed)
    way = rng.normal(size=start.shape)
    end = start + way * (length / np.linalg.norm(way, axis=1, keepdims=True))
    return start, np.clip(end, robot.lower, robot.upper)


@pytest.mark.parametrize("length", [0.2, 0.8, 2.5])
def test_motions_are_those_over_large_boxes(panda, length):
    ours = pc.Checker(panda, room(panda, 0.1))
    theirs = pc.Checker(panda, plates(0.1))
    start, end = motions(panda, 500, 1, length)
    free, expected = ours.check_motions(start, end), theirs.check_motions(start, end)
    # They may differ within the tolerance, where either may refuse.
    for k in np.flatnonzero(free != expected):
        states = ours.motion_certifier.states(start[k], end[k], np.linspace(0, 1, 400))
        assert ours.clearances(states).min() < 3e-4
    assert (free != expected).mean() < 0.01
    assert 0.1 < free.mean() < 0.95


def test_no_proved_motion_has_a_colliding_state(panda):
    checker = pc.Checker(panda, room(panda, 0.1))
    start, end = motions(panda, 400, 2, 1.0)
    free = checker.check_motions(start, end)
    assert 0.1 < free.mean() < 0.95
    for q0, q1 in zip(start[free], end[free], strict=True):
        assert checker.check_states(checker.motion_certifier.states(q0, q1, np.linspace(0, 1, 60))).all()
    refused = np.flatnonzero(~free)
    for k in refused[:60]:
        states = checker.motion_certifier.states(start[k], end[k], np.linspace(0, 1, 1500))
        assert not checker.check_states(states).all() or checker.clearances(states).min() < 1.1e-4
    assert [checker.check_motion(q0, q1) for q0, q1 in zip(start[:80], end[:80], strict=True)] == free[:80].tolist()


CARRIAGE = """<robot name="carriage"><link name="rail"/><link name="beam"/>
<link name="block"><collision><geometry><{shape}/></geometry></collision></link>
<joint name="x" type="prismatic"><parent link="rail"/><child link="beam"/><axis xyz="1 0 0"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<joint name="turn" type="revolute"><parent link="beam"/><child link="block"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>"""


def carriage(tmp_path, half_space, shape='box size="0.6 0.2 0.2"', **options):
    path = tmp_path / "carriage.urdf"
    path.write_text(CARRIAGE.format(shape=shape))
    scene = pc.Scene("plane")
    scene.add("plane", half_space)
    return pc.Checker(pc.Robot.from_urdf(path), scene, **options)


@pytest.mark.parametrize("gap", [1e-3, 2e-4, -1e-9, -1e-3])
def test_a_turning_block_sweeps_a_known_depth(tmp_path, gap):
    """Its lowest corner goes around a circle: between the ends it is deeper than at both."""
    deepest = np.hypot(0.3, 0.1)
    checker = carriage(tmp_path, pc.HalfSpace((0, 0, 1), -deepest - gap))
    lowest = np.arctan2(0.3, 0.1)  # where a corner is straight below the axis
    ends = [0.0, lowest - 0.4], [0.5, lowest + 0.4]
    assert checker.is_valid(ends[0])
    assert checker.is_valid(ends[1])
    assert checker.check_motion(*ends) == (gap > 0)
    verdict = checker.explain_motion(*ends)
    assert verdict.free == (gap > 0)
    if gap == -1e-3:
        assert 0.3 < verdict.collides_at < 0.5
        assert verdict.pair.certificate.verify()


def test_gliding_along_a_plane_at_any_distance(tmp_path):
    """Parallel to the plane, the distance is what it is at the start: further than the tolerance is free."""
    for distance, expected in ((5e-4, True), (1.5e-4, True), (0.0, False), (-1e-6, False)):
        checker = carriage(tmp_path, pc.HalfSpace((0, 0, -1), -0.1 - distance))
        assert checker.check_motion([-2.0, 0.0], [2.0, 0.0]) == expected


def test_padding_counts_on_motions(tmp_path):
    plane = pc.HalfSpace((0, 0, -1), -0.2)
    assert carriage(tmp_path, plane, padding=0.099).check_motion([-2.0, 0.0], [2.0, 0.0])
    assert not carriage(tmp_path, plane, padding=0.101).check_motion([-2.0, 0.0], [2.0, 0.0])
    ball = carriage(tmp_path, plane, shape='sphere radius="0.15"', padding=0.049)
    assert ball.check_motion([-2.0, 0.0], [2.0, 0.0])
    assert not carriage(tmp_path, plane, shape='sphere radius="0.15"', padding=0.051).is_valid([0.0, 0.0])


def test_a_carried_cloud_goes_over_a_plane_that_its_box_cuts(tmp_path):
    """The cloud is a slanted row of balls: its box is in the half-space, no ball is."""
    along = np.linspace(0, 1, 30)
    cloud = pc.PointCloud(np.column_stack([along, 0 * along, along]), 0.01)
    slope = pc.HalfSpace((1, 0, -1), -0.05)
    path = tmp_path / "carriage.urdf"
    path.write_text(CARRIAGE.format(shape='sphere radius="0.001"'))
    scene = pc.Scene("slope")
    scene.add("slope", slope)
    scene.allow("slope", "block")
    scene.attach("row", "block", parts=cloud)
    checker = pc.Checker(pc.Robot.from_urdf(path), scene)
    assert (
        checker.check_motion([0.0, 0.0], [0.03, 0.0])
        == checker.check_states(np.column_stack([np.linspace(0, 0.03, 50), np.zeros(50)])).all()
    )
    q = np.column_stack([np.linspace(-0.1, 0.1, 81), np.zeros(81)])
    valid = checker.check_states(q)
    assert 10 < valid.sum() < 70
    last = q[np.flatnonzero(valid)].max(axis=0) if valid[0] else q[np.flatnonzero(valid)].min(axis=0)
    start = q[0] if valid[0] else q[-1]
    inside = start + (last - start) * 0.95
    assert checker.check_motion(start, inside)
    assert not checker.check_motion(start, start + (last - start) * 1.1)


def test_how_far_a_motion_is_free_and_its_intervals(panda):
    checker = pc.Checker(panda, room(panda, 0.12), self_collision=False)
    start, end = motions(panda, 60, 5, 1.2)
    seen = [0, 0]
    for q0, q1 in zip(start, end, strict=True):
        verdict = checker.explain_motion(q0, q1, proofs=True)
        seen[verdict.free] += 1
        assert verdict.free == checker.check_motion(q0, q1)
        for each in verdict.proofs:
            assert each.gap > each.chord_deviation
            assert each.frame is None
        if verdict.collides_at is not None:
            state = checker.motion_certifier.states(q0, q1, np.array([verdict.collides_at]))[0]
            assert not checker.is_valid(state)
            assert verdict.free_until <= verdict.collides_at
    assert min(seen) > 5
