"""Paths are resampled as motions are checked, held against FCL, and searched between the samples."""

import numpy as np
import pytest

from plannercheck.motions.checker import Checker
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene
from plannercheck.validation.path_recheck import DENSER, check_path, resampled

# Coarse, so that an arm can jump over a ball: between samples the hand moves by up to half a metre.
COARSE = 0.5


@pytest.fixture(scope="module")
def robot() -> Robot:
    return Robot.load("panda")


@pytest.fixture(scope="module")
def swing(robot) -> np.ndarray:
    """The arm stretched out to one side, then to the other."""
    low = np.array([-0.9, 1.0, 0.0, -1.0, 0.0, 2.0, 0.8])
    high = low.copy()
    high[0] = 0.9
    return np.stack([low, high])


def pose_at(robot: Robot, swing: np.ndarray, part: float) -> np.ndarray:
    return robot.link_poses((1 - part) * swing[0] + part * swing[1])[robot.link_index("panda_hand")]


def test_every_tenth_of_the_denser_states_is_a_sample(robot, swing):
    checker = Checker(robot)
    (samples,), (denser,) = (list(resampled(checker, swing, 0.01, k)) for k in (1, DENSER))
    assert np.allclose(denser[::DENSER], samples, rtol=0, atol=1e-15)
    assert np.array_equal(samples[[0, -1]], swing)
    hands = robot.link_poses(samples)[:, robot.link_index("panda_hand"), :3, 3]
    assert np.linalg.norm(np.diff(hands, axis=0), axis=1).max() <= 0.01


def test_collisions_between_the_samples_are_found(robot, swing):
    pytest.importorskip("fcl")
    steps = len(next(resampled(Checker(robot), swing, COARSE))) - 1
    scene = Scene("ball")
    scene.add_sphere("ball", 0.01, pose_at(robot, swing, 0.5 / steps))
    checker = Checker(robot, scene)
    check = check_path(checker, swing, COARSE)
    assert check.passed
    assert check.agreement.states == steps + 1
    assert check.between == (DENSER - 1) * steps
    assert 0 < check.between_colliding < check.between


def test_a_path_through_an_obstacle_does_not_pass(robot, swing):
    pytest.importorskip("fcl")
    scene = Scene("ball")
    scene.add_sphere("ball", 0.01, pose_at(robot, swing, 0.0))
    check = check_path(Checker(robot, scene), swing, COARSE)
    assert not check.passed
    assert check.agreement.passed
