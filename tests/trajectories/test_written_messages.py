"""Trajectories that are written: the same doubles come back, also by ROS's rules of a message."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml

import plannercheck as pc

ROBOT = pc.Robot.load("panda")


def random_trajectory(seed: int, **changes):
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.integers(1, 2 * 10**9, 6)) / 1e9
    q, v, a = rng.normal(size=(3, 6, 7)) * 10.0 ** rng.integers(-12, 3, (3, 6, 7))
    v[-1] = 0
    v[1], a[1:3] = np.nan, np.nan
    return pc.Trajectory(**{"times": times, "positions": q, "velocities": v, "accelerations": a, **changes})


@pytest.mark.parametrize("name", ["t.yaml", "t.yml", "t.json"])
def test_the_same_doubles_come_back(tmp_path: Path, name: str):
    for seed in range(5):
        made = random_trajectory(seed, joint_names=ROBOT.joint_names)
        made.save(tmp_path / name)
        found = pc.Trajectory.load(tmp_path / name, ROBOT)
        for field in ("times", "positions", "velocities", "accelerations"):
            np.testing.assert_array_equal(getattr(found.points, field), getattr(made.points, field))
        assert all(np.array_equal(a, b) for a, b in zip(found.curve.pieces, made.curve.pieces, strict=True))


def test_a_message_is_one_for_other_readers(tmp_path: Path):
    """Numbers are numbers by YAML 1.1, in which 1e-05 is a text; stamps are whole numbers."""
    random_trajectory(0, joint_names=ROBOT.joint_names).save(tmp_path / "t.yaml")
    points = yaml.safe_load((tmp_path / "t.yaml").read_text())["points"]
    assert all(type(x) is float for point in points for x in point["positions"])
    assert all(type(x) is int for point in points for x in point["time_from_start"].values())
    assert "velocities" not in points[1]


def test_what_no_message_holds_is_refused(tmp_path: Path):
    named = {"joint_names": ROBOT.joint_names}
    for made, words in (
        (random_trajectory(0), "names its joints: make the trajectory with joint_names="),
        (random_trajectory(0, times=[0, 1 / 3, 1, 2, 3, 4], **named), "point 1 is at .*333 s.*whole nanoseconds"),
        (pc.Trajectory([0, 1, 2**31], np.zeros((3, 7)), **named), "point 2 is at .* below 2147483648 s"),
        (pc.Trajectory.bezier([0, 1], [[[0.0], [1.0]]]), "a curve is no message"),
    ):
        with pytest.raises(pc.PlannercheckError, match=words):
            made.save(tmp_path / "t.yaml")
        assert not (tmp_path / "t.yaml").exists()
    with pytest.raises(pc.PlannercheckError, match=r"written as \.yaml, \.yml, \.json, not 't\.csv'"):
        random_trajectory(0, **named).save(tmp_path / "t.csv")
    with pytest.raises(pc.PlannercheckError, match="joint_names must name the 7 columns, not 2"):
        random_trajectory(0, joint_names=["a", "b"])


@pytest.mark.parametrize(
    "stamp", [{"sec": 1.5}, {"sec": 1, "nanosec": 0.5}, {"sec": True}, {"secs": "1"}, {"sec": 10**400}]
)
def test_stamps_are_whole_numbers(tmp_path: Path, stamp: dict):
    random_trajectory(0, joint_names=ROBOT.joint_names).save(tmp_path / "t.json")
    message = json.loads((tmp_path / "t.json").read_text())
    message["points"][0]["time_from_start"] = stamp
    (tmp_path / "t.json").write_text(json.dumps(message))
    with pytest.raises(pc.PlannercheckError, match=r"point 0: '(nano)?sec' must be a whole number"):
        pc.Trajectory.load(tmp_path / "t.json", ROBOT)


def test_errors_of_a_file_name_the_joint(tmp_path: Path):
    random_trajectory(0, joint_names=ROBOT.joint_names).save(tmp_path / "t.json")
    message = json.loads((tmp_path / "t.json").read_text())
    message["points"][-1]["velocities"][3] = 0.5
    (tmp_path / "t.json").write_text(json.dumps(message))
    with pytest.raises(pc.PlannercheckError, match=r"t\.json.*velocity 0\.5 in joint 'panda_joint4'"):
        pc.Trajectory.load(tmp_path / "t.json", ROBOT)
