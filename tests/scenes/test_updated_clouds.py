"""`scene.update` replaces a cloud's points and nothing else; checkers of the changed scene are those of a new one."""

import numpy as np
import pytest
from poses import at

import plannercheck as pc

RNG = np.random.default_rng(0)
FIRST, SECOND = RNG.uniform([0.2, -0.6, 0], [0.8, 0.6, 0.9], (2, 400, 3))


@pytest.fixture
def scene():
    scene = pc.Scene()
    scene.add_box("table", (0.5, 1.0, 0.05), at(0.7))
    scene.add("camera", pc.PointCloud(FIRST, 0.02), at(0.1))
    scene.add_sphere("ball", 0.1, at(-0.5))
    return scene


def test_points_change_and_all_else_stays(scene):
    before = {name: scene.object(name) for name in scene.object_names}
    scene.update("camera", SECOND[:100])
    assert scene.object_names == ("table", "camera", "ball")
    assert scene.object("table") is before["table"]
    changed = scene.object("camera")
    assert np.array_equal(changed.parts[0].shape.points, SECOND[:100])
    assert np.array_equal(changed.parts[0].shape.radius, [0.02])
    assert np.array_equal(changed.bodies[0].pose, at(0.1))
    assert np.array_equal(before["camera"].parts[0].shape.points, FIRST)


def test_checkers_of_frames_are_those_of_new_scenes(scene):
    robot = pc.Robot.load("panda")
    checker = pc.Checker(robot, scene)
    q = robot.random_configurations(500, 0)
    for points in (SECOND, FIRST[:1], FIRST):
        scene.update("camera", points)
        checker = checker.with_scene(scene)
        fresh = pc.Scene()
        fresh.add_box("table", (0.5, 1.0, 0.05), at(0.7))
        fresh.add("camera", pc.PointCloud(points, 0.02), at(0.1))
        fresh.add_sphere("ball", 0.1, at(-0.5))
        assert np.array_equal(checker.check_states(q), pc.Checker(robot, fresh).check_states(q))


def test_clouds_on_links_are_updated(scene):
    scene.attach("held", "panda_hand", parts=pc.PointCloud(FIRST[:5], 0.01))
    scene.update("held", SECOND[:3])
    assert scene.attached[0].link == "panda_hand"
    assert np.array_equal(scene.attached[0].parts[0].shape.points, SECOND[:3])


def test_what_is_no_cloud_is_refused(scene):
    with pytest.raises(pc.PlannercheckError, match="object 'table': is a Box: sensors update clouds"):
        scene.update("table", SECOND)
    with pytest.raises(pc.PlannercheckError, match="camera"):
        scene.update("lidar", SECOND)
    with pytest.raises(pc.PlannercheckError, match=r"object 'camera': points of a cloud must have shape \(n, 3\)"):
        scene.update("camera", SECOND[:, :2])
    assert np.array_equal(scene.object("camera").parts[0].shape.points, FIRST)
