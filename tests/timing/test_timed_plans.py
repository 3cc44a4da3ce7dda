"""`plannercheck plan --timed`: what is written is what was proved, or nothing is written."""

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.cli.main import main

PLAN = ["plan", "--robot", "panda", "--scene", "kitchen", "--seed", "1", "--planner", "RRTConnect"]
LIMITS = ["--acceleration", "3.75,1.875,2.5,3.125,3.75,5,5"]


def test_a_timed_plan_is_written_as_a_message(tmp_path, capsys):
    file = tmp_path / "traj.yaml"
    assert main([*PLAN, "--timed", *LIMITS, "--velocity", "1.5", "--output", str(file)]) == 0
    said = capsys.readouterr().out
    assert "less than stopping at each corner" in said
    assert "within a tube of 0, with a tolerance of 0.0001 m" in said
    assert f"written to {file}" in said
    checker = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("kitchen"))
    read = pc.Trajectory.load(file, checker.robot)
    assert f"timed: {read.duration:.3f} s" in said
    assert checker.check_trajectories([read])[0]
    speeds = np.abs(read.velocity(np.linspace(0, read.duration, 10000)))
    assert 1.4 < speeds.max() <= 1.5 * (1 + 1e-9)
    assert np.array_equal(read.position(0.0), checker.scene.start("panda"))


def test_padding_is_room_for_a_tube(tmp_path, capsys):
    file = tmp_path / "traj.yaml"
    given = ["--timed", *LIMITS, "--tube", "0.002", "--output", str(file)]
    padded = ["bookshelf" if word == "kitchen" else word for word in PLAN]
    assert main([*padded, "--padding", "0.02", *given]) == 0
    checker = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"))
    assert checker.check_trajectory(pc.Trajectory.load(file, checker.robot), tube=0.002)


def test_nothing_is_written_that_is_not_proved(tmp_path, capsys):
    file = tmp_path / "traj.json"
    assert main([*PLAN, "--timed", *LIMITS, "--tube", "0.5", "--output", str(file)]) == 1
    assert "not timed: the path's segment from configuration 0 to 1 is not proved" in capsys.readouterr().out
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--timed"], "--timed needs --acceleration: numbers, or MoveIt's joint_limits.yaml"),
        ([*LIMITS, "--blend", "0.2"], "--acceleration and --blend count only with --timed"),
        (["--timed", "--acceleration", "fast"], "--acceleration must be numbers separated by commas, not 'fast'"),
        (["--timed", "--acceleration", "1,2"], "acceleration must be a number more than 0, or 7, one a joint"),
        (["--timed", *LIMITS, "--output", "plan.npy"], "a trajectory is written as .yaml"),
        (["--timed", *LIMITS, "--velocity", "none.yaml"], "none.yaml"),
        (["--timed", *LIMITS, "--blend", "-1"], "blend must be at least 0, not -1"),
    ],
)
def test_options_that_do_not_fit_are_named(capsys, arguments, words):
    assert main([*PLAN, *arguments]) == 2
    assert words in capsys.readouterr().err


def test_a_planar_robot_is_not_timed(capsys):
    assert main(["plan", "--robot", "forklift", "--scene", "warehouse", "--timed", *LIMITS]) == 2
    assert "--timed is for robots in space" in capsys.readouterr().err
