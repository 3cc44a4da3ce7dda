"""Trajectories in tables and bags: the points of the message that was written, and errors that name what is wrong."""

import json
import sqlite3
from pathlib import Path

import numpy as np
import pytest
from bags import bag_of, empty, message_of
from rosbags.rosbag2 import StoragePlugin

import plannercheck as pc

ROBOT = pc.Robot.load("panda")
NAMES = list(ROBOT.joint_names)
TIMES = np.array([0.0, 0.25, 1.5])
Q, V, A = np.random.default_rng(0).normal(size=(3, 3, 7))
V[-1] = 0
TURNED = [3, 0, 6, 1, 5, 2, 4]  # the columns of files, in another order than the robot's


def csv_of(path: Path, header: list[str], *columns) -> Path:
    rows = [",".join(header), *(",".join(map(repr, row)) for row in np.column_stack(columns).tolist())]
    path.write_text("\n".join(rows).replace("nan", "") + "\n")
    return path


def assert_same(found: pc.Trajectory, v=V, a=A) -> None:
    points = found.points
    for given, read in (
        (TIMES, points.times),
        (Q, points.positions),
        (v, points.velocities),
        (a, points.accelerations),
    ):
        np.testing.assert_array_equal(read, given)


@pytest.mark.parametrize(
    ("time", "name"),
    [("time", "{}.{}"), ("__time", "/joint_states/{}/{}"), ("time_from_start", "{}/{}"), ("t", "arm/{}.{}")],
)
def test_csv_is_read_by_names(tmp_path: Path, time: str, name: str):
    kinds = [name.format(NAMES[j], kind) for kind in ("position", "velocity", "acceleration") for j in TURNED]
    file = csv_of(tmp_path / "t.csv", [time, *kinds], TIMES, Q[:, TURNED], V[:, TURNED], A[:, TURNED])
    assert_same(pc.Trajectory.load(file, ROBOT))


def test_csv_of_bare_names_has_positions(tmp_path: Path):
    v = V.copy()
    v[1] = np.nan
    file = csv_of(tmp_path / "t.csv", ["time", *NAMES, *(f"{n}.velocity" for n in NAMES)], TIMES, Q, v)
    found = pc.Trajectory.load(file, ROBOT)
    assert_same(found, v, np.full_like(A, np.nan))
    assert [len(piece) for piece in found.curve.pieces] == [2, 2]


@pytest.mark.parametrize(
    ("header", "change", "words"),
    [
        (["time", *NAMES[:-1], "x"], None, "column 'x', which is no joint of panda"),
        (["time", *NAMES[:-1], NAMES[0]], None, "position: names panda_joint1 more than once"),
        (["time", *NAMES[:-1], f"{NAMES[0]}.velocity"], None, "position: lacks panda_joint7: give each joint"),
        (["stamp", *NAMES], None, "one column of the time in s, called 'time', not 0"),
        (["time", *NAMES], ("0.25", "1e9"), r"times must grow from 0 s on, but point 2"),
        (["time", *NAMES], ("\n0.0,", "\n1.7e9,"), "those of a clock"),
        (["time", *NAMES], (repr(Q[1, 3]), "much"), "point 1, column 'panda_joint4': 'much' is no finite number"),
        (["time", *NAMES], (repr(Q[1, 3]), "1_5"), "point 1, column 'panda_joint4': '1_5' is no finite number"),
        (["time", *NAMES], (repr(Q[1, 3]), ""), "point 1, column 'panda_joint4': '' is no finite number"),
        (["time", *NAMES], ("," + repr(Q[1, 3]), ""), "point 1 has 7 cells, and the header 8"),
    ],
)
def test_malformed_csv_is_named(tmp_path: Path, header: list[str], change, words: str):
    file = csv_of(tmp_path / "t.csv", header, TIMES, Q)
    if change:
        file.write_text(file.read_text().replace(change[0].replace("np.float64(", "").rstrip(")"), change[1]))
    with pytest.raises(pc.PlannercheckError, match=rf"(?s)t\.csv.*{words}"):
        pc.Trajectory.load(file, ROBOT)


def test_npz_has_the_arrays_by_name(tmp_path: Path):
    np.savez(tmp_path / "t.npz", times=TIMES, positions=Q, velocities=V, accelerations=A)
    assert_same(pc.Trajectory.load(tmp_path / "t.npz", ROBOT))
    names = np.array(NAMES)[TURNED]
    np.savez(tmp_path / "t.npz", times=TIMES, positions=Q[:, TURNED], joint_names=names)
    assert_same(pc.Trajectory.load(tmp_path / "t.npz", ROBOT), np.full_like(V, np.nan), np.full_like(A, np.nan))


@pytest.mark.parametrize(
    ("arrays", "words"),
    [
        ({"times": TIMES}, "has no array 'positions'; it has times"),
        ({"times": TIMES, "positions": Q, "q": Q}, "'q'"),
        ({"times": TIMES, "positions": Q[:, :6]}, r"'positions' must be \(n, 7\), a column a joint, not \(3, 6\)"),
        ({"times": TIMES, "positions": Q, "velocities": V[:2]}, r"'velocities' must be \(3, 7\)"),
        ({"times": TIMES, "positions": Q, "joint_names": ["x", *NAMES[1:]]}, "unknown joint of panda 'x'"),
        ({"times": TIMES, "positions": np.full((3, 7), "x")}, "'positions' must hold numbers"),
        ({"times": TIMES, "positions": np.where(Q[2, 1] == Q, np.inf, Q)}, "point 2, joint 'panda_joint2' has inf"),
    ],
)
def test_malformed_npz_is_named(tmp_path: Path, arrays: dict, words: str):
    np.savez(tmp_path / "t.npz", **arrays)
    with pytest.raises(pc.PlannercheckError, match=rf"(?s)t\.npz.*{words}"):
        pc.Trajectory.load(tmp_path / "t.npz", ROBOT)


def in_the_files_order() -> pc.Trajectory:
    rows = (np.ascontiguousarray(each[:, TURNED]) for each in (Q, V, A))
    return pc.Trajectory(TIMES, *rows, joint_names=[NAMES[j] for j in TURNED])


def joint_trajectory():
    return message_of(in_the_files_order())


def display_trajectory():
    part = empty("moveit_msgs/msg/RobotTrajectory", joint_trajectory=joint_trajectory())
    return empty("moveit_msgs/msg/DisplayTrajectory", model_id="panda", trajectory=[part])


@pytest.mark.parametrize("plugin", list(StoragePlugin))
@pytest.mark.parametrize("message", [joint_trajectory, display_trajectory])
@pytest.mark.parametrize("whole", [True, False])
def test_bags_hold_the_message(tmp_path: Path, plugin: StoragePlugin, message, whole: bool):
    folder = bag_of(tmp_path / "bag", plugin, message())
    path = folder if whole else next(p for p in folder.iterdir() if p.suffix != ".yaml")
    assert_same(pc.Trajectory.load(path, ROBOT))


def test_bags_without_definitions_are_read(tmp_path: Path):
    """As ROS 2 wrote them before Iron."""
    folder = bag_of(tmp_path / "bag", StoragePlugin.SQLITE3, display_trajectory())
    with sqlite3.connect(next(folder.glob("*.db3"))) as file:
        file.execute("DELETE FROM message_definitions")
    assert_same(pc.Trajectory.load(folder, ROBOT))


def test_one_of_several_messages_is_chosen(tmp_path: Path):
    folder = bag_of(tmp_path / "bag", StoragePlugin.MCAP, joint_trajectory(), display_trajectory())
    listed = (
        r"holds 2 JointTrajectory.*message= .--message.: 0: /topic0 \(trajectory_msgs.*7 joints, 3 points; 1: /topic1 "
    )
    for message in (None, 2, -1):
        with pytest.raises(pc.PlannercheckError, match=listed):
            pc.Trajectory.load(folder, ROBOT, message=message)
    assert_same(pc.Trajectory.load(folder, ROBOT, message=1))


def test_what_is_no_bag_of_trajectories_is_named(tmp_path: Path):
    folder = bag_of(tmp_path / "bag", StoragePlugin.MCAP, empty("std_msgs/msg/Header"))
    with pytest.raises(pc.PlannercheckError, match=r"(?s)bag.*no messages of.*topics: /topic0 \(std_msgs/msg/Header"):
        pc.Trajectory.load(folder, ROBOT)
    (tmp_path / "t.mcap").write_bytes(b"no bag")
    (tmp_path / "t.txt").write_text("")
    for name, words in (
        ("t.mcap", "is no bag that rosbags reads"),
        ("", "is no bag"),
        ("t.txt", "must be one of"),
        ("u.csv", "does not exist"),
    ):
        with pytest.raises(pc.PlannercheckError, match=words):
            pc.Trajectory.load(tmp_path / name, ROBOT)


def test_one_of_several_in_a_display_is_chosen(tmp_path: Path):
    points = [{"positions": q, "time_from_start": {"sec": k}} for k, q in enumerate(Q[:, TURNED].tolist())]
    part = {"joint_trajectory": {"joint_names": [NAMES[j] for j in TURNED], "points": points}}
    (tmp_path / "t.json").write_text(json.dumps({"trajectory": [part, part]}))
    found = pc.Trajectory.load(tmp_path / "t.json", ROBOT, message=1)
    np.testing.assert_array_equal(found.points.positions, Q)
