"""Sliders move joints in the server's picture, and the verdict is that of the checker."""

import numpy as np
import pytest

from plannercheck.common.errors import PlannercheckError
from plannercheck.motions.checker import Checker
from plannercheck.planar.checker import Checker as PlanarChecker
from plannercheck.planar.robot import Robot as PlanarRobot
from plannercheck.planar.scene import Scene as PlanarScene
from plannercheck.robots.robot import Robot
from plannercheck.view import joints_of, picture, serve
from plannercheck.view.model import COLLIDING


@pytest.fixture(scope="module")
def rows(checker):
    """A valid configuration, then one that collides."""
    samples = checker.scene.samples("panda")
    valid = checker.check_states(samples)
    return np.stack([samples[valid][0], samples[~valid][0]])


def test_sliders_move_the_robot_and_its_verdict(checker, rows):
    pytest.importorskip("viser")
    shown = picture(checker, rows[0], planes=1)
    stage = serve(shown, port=0, joints=joints_of(checker, rows[:1]))
    try:
        assert "free of collision" in stage.verdict.content
        for slider, value in zip(stage.sliders, rows[1].tolist(), strict=True):
            slider.value = value
        stage.follow_sliders()
        expected = picture(checker, rows[1], planes=1)
        assert expected.verdict(0) in stage.verdict.content
        for mesh, handle in zip(expected.meshes, stage.meshes, strict=True):
            np.testing.assert_allclose(handle.position, mesh.pose(0)[:3, 3], atol=1e-6)
            is_red = tuple(handle.color) == tuple(round(255 * part) for part in COLLIDING)
            assert is_red == mesh.colliding[0]
        stage.show(0)
        assert [slider.value for slider in stage.sliders] == pytest.approx(rows[0])
        assert "free of collision" in stage.verdict.content
    finally:
        stage.server.stop()


def test_sliders_follow_the_frames(checker, rows):
    pytest.importorskip("viser")
    stage = serve(picture(checker, rows, planes=0), port=0, joints=joints_of(checker, rows))
    try:
        stage.show(1)
        assert [slider.value for slider in stage.sliders] == pytest.approx(rows[1])
        assert "configuration 1" in stage.verdict.content
    finally:
        stage.server.stop()


def test_bounds_are_the_limits_or_a_whole_turn(checker, rows):
    joints = joints_of(checker, rows)
    assert np.array_equal(joints.lower, checker.robot.lower)
    kinova = Checker(Robot.load("kinova"))
    q = kinova.robot.reference + 0.25
    joints = joints_of(kinova, q)
    free = np.isinf(kinova.robot.upper)
    np.testing.assert_allclose((joints.upper - joints.lower)[free], 2 * np.pi)
    assert (joints.lower <= q).all()
    forklift = joints_of(PlanarChecker(PlanarRobot.load("forklift")), np.zeros(3))
    np.testing.assert_allclose(forklift.upper, [10, 10, np.pi])


def test_planar_robots_are_moved_as_well():
    pytest.importorskip("viser")
    checker = PlanarChecker(PlanarRobot.load("forklift"), PlanarScene.load("parking"))
    samples = checker.scene.samples("forklift")
    q = samples[~checker.check_states(samples)][0]
    start = checker.scene.start("forklift")
    stage = serve(picture(checker, start), port=0, joints=joints_of(checker, start))
    try:
        for slider, value in zip(stage.sliders, q.tolist(), strict=True):
            slider.value = value
        stage.follow_sliders()
        assert "collision: " in stage.verdict.content
    finally:
        stage.server.stop()


def test_joints_of_several_numbers_are_named(tmp_path):
    urdf = tmp_path / "turntable.urdf"
    urdf.write_text(
        """<robot name="turntable"><link name="a"/><link name="b"><collision><geometry><box size="1 1 1"/></geometry>
</collision></link><joint name="turn" type="continuous"><parent link="a"/><child link="b"/></joint></robot>"""
    )
    with pytest.raises(PlannercheckError, match="some of turntable take several"):
        joints_of(Checker(Robot.from_urdf(urdf)), [1.0, 0.0])
