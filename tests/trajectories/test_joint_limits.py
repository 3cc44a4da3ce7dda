"""Limits of speeds and accelerations as MoveIt reads them."""

from pathlib import Path

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.trajectories import joint_limits

PANDA = pc.Robot.load("panda")

# As franka's MoveIt configuration has them, shortened.
FILE = """
default_velocity_scaling_factor: 0.1
default_acceleration_scaling_factor: 0.1
joint_limits:
  panda_joint1: {has_velocity_limits: true, max_velocity: 1.5, has_acceleration_limits: true, max_acceleration: 3.75}
  panda_joint2:
    has_velocity_limits: false
    has_acceleration_limits: false
    max_acceleration: 2
  panda_joint3: {has_acceleration_limits: true, max_acceleration: 5, has_jerk_limits: true, max_jerk: 1000}
  panda_finger_joint1: {has_velocity_limits: true, max_velocity: 0.1}
"""


def test_the_urdf_limits_speeds():
    assert joint_limits.velocity_limits(PANDA).tolist() == [2.175] * 4 + [2.61] * 3


@pytest.mark.parametrize("wrapped", [False, True])
def test_moveits_file_overrides_the_urdf(tmp_path: Path, wrapped: bool):
    file = tmp_path / "joint_limits.yaml"
    inner = "".join(f"      {line}\n" for line in FILE.splitlines())
    file.write_text(f"/**:\n  ros__parameters:\n    robot_description_planning:\n{inner}" if wrapped else FILE)
    found = joint_limits.read(file, PANDA)
    assert found.velocity.tolist() == [1.5, np.inf, 2.175, 2.175, 2.61, 2.61, 2.61]
    assert found.acceleration.tolist() == [3.75, np.inf, 5.0] + [np.inf] * 4


def test_position_limits_of_the_file_are_said_to_be_unused(tmp_path: Path):
    file = tmp_path / "joint_limits.yaml"
    file.write_text("joint_limits: {panda_joint1: {max_position: 1.0}, panda_joint2: }")
    with pytest.warns(UserWarning, match=r"position limits \(panda_joint1\) are not looked at"):
        joint_limits.read(file, PANDA)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("limits: {}", "'joint_limits' is missing"),
        ("joint_limits: {panda_joint9: {}}", "panda_joint9"),
        ("joint_limits: {panda_joint1: {has_velocity_limits: true}}", "'panda_joint1'.*'max_velocity' is missing"),
        ("joint_limits: {panda_joint1: {max_velocity: 1.0}}", "max_velocity without has_velocity_limits, and MoveIt"),
        ("joint_limits: {panda_joint1: {has_velocity_limits: 1, max_velocity: 1.0}}", "must be true or false, not 1"),
        ("joint_limits: {panda_joint1: {has_velocity_limits: true, max_velocity: 0}}", "must be more than 0, not 0"),
        ("joint_limits: {panda_joint1: {max_speed: 1.0}}", "max_speed"),
    ],
)
def test_malformed_files_are_named(tmp_path: Path, text: str, words: str):
    file = tmp_path / "joint_limits.yaml"
    file.write_text(text)
    with pytest.raises(pc.PlannercheckError, match=f"(?s)joint_limits.yaml.*{words}"):
        joint_limits.read(file, PANDA)
