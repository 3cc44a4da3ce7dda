"""Boxes of configurations that are proved free, against states in them."""

import numpy as np
import pytest

import plannercheck as pc


@pytest.fixture(scope="module")
def checker():
    return pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"))


def states_of(box, n=4000):
    """States in it, half of them corners."""
    rng = np.random.default_rng(0)
    within = rng.uniform(box.lower, box.upper, (n // 2, len(box.lower)))
    corners = np.where(rng.random((n // 2, len(box.lower))) < 0.5, box.lower, box.upper)
    return np.concatenate([within, corners])


@pytest.mark.parametrize("shape", [None, 0.5, [1, 1, 1, 1, 2, 2, 3]])
def test_all_states_of_a_box_are_free(checker, shape):
    q = checker.scene.start("panda")
    volumes = []
    for cells in (1, 60):
        box = checker.free_box(q, shape, cells)
        assert (box.lower < q).all()
        assert (q < box.upper).all()
        assert (box.lower >= checker.robot.lower).all()
        assert (box.upper <= checker.robot.upper).all()
        assert box.cells <= cells
        assert checker.check_states(states_of(box)).all()
        volumes.append(box.volume)
    assert volumes[1] > volumes[0]
    a, b = box.half_spaces()
    assert (a @ q <= b).all()
    np.testing.assert_array_equal(np.sort(b), np.sort(np.concatenate([box.upper, -box.lower])))


def test_a_slide_before_a_wall_is_free_up_to_the_wall(tmp_path):
    path = tmp_path / "slide.urdf"
    path.write_text(
        '<robot name="slide"><link name="base"/><link name="body"><collision><geometry>'
        '<box size="0.2 0.2 0.2"/></geometry>'
        '</collision></link><joint name="x" type="prismatic"><parent link="base"/><child link="body"/>'
        '<axis xyz="1 0 0"/>'
        '<limit lower="-1" upper="3" effort="1" velocity="1"/></joint></robot>'
    )
    scene, pose = pc.Scene("wall"), np.eye(4)
    pose[0, 3] = 1.0
    scene.add("wall", pc.Box((0.2, 1.0, 1.0)), pose)
    checker = pc.Checker(pc.Robot.from_urdf(path), scene)
    box = checker.free_box([0.3])
    assert box.lower[0] == -1.0
    assert 0.75 < box.upper[0] < 0.8  # where the box touches the wall
    assert checker.free_box([1.0]) is None


@pytest.mark.parametrize("off", [1e-9, 0.5])
def test_a_configuration_beyond_the_limits_is_named(off):
    """A search around it would not end."""
    checker = pc.Checker(pc.Robot.load("panda"), self_collision=False)
    q = np.array(pc.Scene.load("bookshelf").start("panda"))
    q[[0, 3]] = checker.robot.upper[0] + off, checker.robot.lower[3] - off
    with pytest.raises(pc.PlannercheckError, match="panda_joint1, panda_joint4: beyond the limits"):
        checker.free_box(q)


def test_a_joint_without_limits_turns_once(tmp_path):
    path = tmp_path / "wheel.urdf"
    path.write_text(
        '<robot name="wheel"><link name="base"/><link name="wheel"><collision><geometry>'
        '<sphere radius="0.1"/></geometry></collision></link><joint name="axle" type="continuous">'
        '<parent link="base"/><child link="wheel"/><axis xyz="1 0 0"/></joint></robot>'
    )
    scene, pose = pc.Scene("stone"), np.eye(4)
    pose[2, 3] = 1.0
    scene.add_sphere("stone", 0.1, pose)
    box = pc.Checker(pc.Robot.from_urdf(path).with_group(["axle"]), scene).free_box([0.5])
    assert (box.lower[0], box.upper[0]) == (0.5 - np.pi, 0.5 + np.pi)


def test_a_shape_is_its_proportions(checker):
    q = checker.scene.start("panda")
    boxes = [checker.free_box(q, size * np.arange(1.0, 8.0), 30) for size in (1.0, 2.0**-20, 2.0**1000)]
    assert all(np.array_equal(box.lower, boxes[0].lower) for box in boxes)


def test_what_is_no_box_is_named(checker):
    q = checker.scene.start("panda")
    for arguments, message in (
        ({"shape": [1, 2]}, "7 positive numbers"),
        ({"shape": 0}, "positive"),
        ({"shape": float("nan")}, "positive"),
        ({"cells": 0}, "cells must be"),
    ):
        with pytest.raises(pc.PlannercheckError, match=message):
            checker.free_box(q, **arguments)


def test_unit_vectors_have_no_boxes(tmp_path):
    path = tmp_path / "floats.urdf"
    path.write_text(
        '<robot name="floats"><link name="base"/><link name="body"><collision><geometry><sphere radius="1"/>'
        '</geometry></collision></link><joint name="j" type="floating"><parent link="base"/>'
        '<child link="body"/></joint></robot>'
    )
    with pytest.raises(pc.PlannercheckError, match="unit vectors"):
        pc.Checker(pc.Robot.from_urdf(path)).free_box([0, 0, 0, 0, 0, 0, 1.0])
