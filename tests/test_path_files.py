"""Paths in every format give the same configurations; what is wrong with a file is said."""

from __future__ import annotations

import ctypes
import json

import numpy as np
import pytest
import yaml
from ompl import geometric

import plannercheck as pc
from plannercheck.errors import PlannercheckError
from plannercheck.joint_space import JointSpace
from plannercheck.path_files import read_path
from plannercheck.plans import Plan

NAMES = ("a", "b", "c")
STATES = np.array([[0.0, 0.1, -0.2], [1.0, 1e-17, 3.0], [0.5, 0.25, -1.5]])


def read(path):
    return read_path(path, NAMES, 3)


@pytest.mark.parametrize("suffix", [".json", ".npy", ".csv"])
def test_plans(tmp_path, suffix):
    plan = Plan(True, STATES, 1.0, 0.1, 0.1, "RRT", joint_names=NAMES)
    plan.save(tmp_path / f"plan{suffix}")
    assert np.array_equal(read(tmp_path / f"plan{suffix}").states, STATES)


def test_a_bare_list_and_a_table(tmp_path):
    (tmp_path / "list.json").write_text(json.dumps(STATES.tolist()))
    (tmp_path / "table.txt").write_text("\n".join(" ".join(map(repr, row)) for row in STATES.tolist()) + "\n\n")
    for name in ("list.json", "table.txt"):
        assert np.array_equal(read(tmp_path / name).states, STATES)


def trajectory(names, rows):
    points = [{"positions": list(row), "time_from_start": {"secs": k}} for k, row in enumerate(rows)]
    return {"joint_names": list(names), "points": points}


@pytest.mark.parametrize("suffix", [".yaml", ".json"])
def test_moveit_trajectories(tmp_path, suffix):
    write = yaml.safe_dump if suffix == ".yaml" else json.dumps
    swapped = trajectory(("c", "extra", "a", "b"), [(r[2], 0.5, r[0], r[1]) for r in STATES.tolist()])
    robot = {"joint_trajectory": swapped, "multi_dof_joint_trajectory": {"joint_names": []}}
    display = {"model_id": "robot", "trajectory": [{"joint_trajectory": trajectory(NAMES, STATES[:2].tolist())}, robot]}
    file = tmp_path / f"t{suffix}"
    for document in (swapped, robot, {"trajectory": robot}):
        file.write_text(write(document))
        found = read(file)
        assert np.array_equal(found.states, STATES)
        assert found.others == {"extra": 0.5}
    display["trajectory"][1] = {"joint_trajectory": trajectory(NAMES, STATES[1:].tolist())}
    file.write_text(write(display))
    assert np.array_equal(read(file).states, STATES[[0, 1, 1, 2]])


@pytest.mark.parametrize("name", ["panda", "kinova"])
def test_what_ompl_prints(tmp_path, capfd, name):
    checker = pc.Checker(pc.Robot.load(name))
    information, space = pc.ompl.setup(checker).getSpaceInformation(), JointSpace(checker.robot)
    path, rows = geometric.PathGeometric(information), checker.robot.random_configurations(4, 1)
    for row in rows:
        path.append(space.state(information, row))
    for show in (path.print, path.printAsMatrix):
        capfd.readouterr()
        show()
        ctypes.CDLL(None).fflush(None)
        (tmp_path / "printed.path").write_text(capfd.readouterr().out)
        found = read_path(tmp_path / "printed.path", checker.robot.joint_names, checker.robot.nq)
        assert np.allclose(found.states, rows, rtol=1e-5, atol=1e-5)  # OMPL prints six digits


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.json", "[[1, 2]]", "2 numbers, not 3"),
        ("a.json", "{", "no JSON"),
        ("a.json", "3", "must hold"),
        ("a.json", "{}", "holds no 'path'"),
        ("a.json", "[]", "no states"),
        ("a.json", '[[1, 2, "x"]]', "no table of numbers"),
        ("a.json", "[[1, 2, 3], [1, NaN, 3]]", "state 1 is not finite"),
        ("a.yaml", yaml.safe_dump(trajectory(("a", "b"), [(1, 2)])), "has no joint 'c'"),
        ("a.yaml", yaml.safe_dump(trajectory("abcd", [(1, 2, 3, 4), (1, 2, 3, 5)])), "moves d, outside"),
        ("a.yaml", yaml.safe_dump(trajectory("abcc", [(1, 2, 3, 4)])), "twice"),
        ("a.yaml", yaml.safe_dump(trajectory("abc", [(1, 2)])), "positions"),
        ("a.path", "Geometric path with 2 states\nRealVectorState [1 2 3]\n", "2 states hold 3 numbers"),
        ("a.txt", "hello world\n", "no table of numbers"),
        ("missing.json", None, "missing.json"),
    ],
)
def test_bad_files(tmp_path, name, content, message):
    if content is not None:
        (tmp_path / name).write_text(content)
    with pytest.raises(PlannercheckError, match=message):
        read(tmp_path / name)
