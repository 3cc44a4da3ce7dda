"""Paths in every format give the same configurations; what is wrong with a file is said."""

import json
import subprocess
import sys

import numpy as np
import pytest
import yaml

import plannercheck as pc
from plannercheck.common.errors import PlannercheckError
from plannercheck.ompl.plans import Plan
from plannercheck.validation.formats.paths import read_path

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


def test_truth_values_are_no_numbers_of_a_path(tmp_path):
    rows = [STATES[0].tolist(), [0.5, True, 0.5]]
    for document in (rows, {"path": rows, "joint_names": list(NAMES)}):
        (tmp_path / "plan.json").write_text(json.dumps(document))
        with pytest.raises(PlannercheckError, match=r"no table of numbers but has a truth value at \[1, 1\]"):
            read(tmp_path / "plan.json")
    with pytest.raises(PlannercheckError, match=r"plan file .*path must be numbers, not a truth value at \[1, 1\]"):
        Plan.load(tmp_path / "plan.json")


def trajectory(names, rows):
    points = [{"positions": list(row), "time_from_start": {"secs": k}} for k, row in enumerate(rows)]
    return {"joint_names": list(names), "points": points}


def timed(*times):
    """A trajectory whose points are at these times."""
    points = [{"positions": [1, 2, 3], "time_from_start": time} for time in times]
    return {"joint_names": list("abc"), "points": points}


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
    display["trajectory"].insert(0, {"joint_trajectory": trajectory(NAMES, [])})
    file.write_text(write(display))
    assert np.array_equal(read(file).states, STATES[[0, 1, 1, 2]])


@pytest.mark.parametrize(
    ("changes", "bent_by"),
    [
        ({}, ()),
        ({"velocities": [], "accelerations": [], "effort": [1.0, 2.0, 3.0]}, ()),
        ({"velocities": [0.0, -0.0, 0.0], "accelerations": [0, 0, 0]}, ()),
        ({"velocities": [0.0, 0.0, 1e-300]}, ("velocities",)),
        ({"velocities": [0.0, 0.0, 0.0], "accelerations": [0.0, -1.0, 0.0]}, ("accelerations",)),
        ({"velocities": [1.0, 0.0, 0.0], "accelerations": [0.0, -1.0, 0.0]}, ("velocities", "accelerations")),
    ],
)
@pytest.mark.parametrize("point", [0, 2])
def test_what_bends_the_way_of_a_trajectory_is_told(tmp_path, changes, bent_by, point):
    """A controller goes straight between points without velocities, and between those where all rest."""
    document = trajectory(NAMES, STATES.tolist())
    document["points"][point].update(changes)
    file = tmp_path / "t.yaml"
    for whole in (document, {"trajectory": [{"joint_trajectory": document}]}):
        file.write_text(yaml.safe_dump(whole))
        found = read(file)
        assert found.bent_by == bent_by
        assert np.array_equal(found.states, STATES)


def test_the_start_state_of_a_trajectory_gives_what_stands_still(tmp_path):
    document = {
        "trajectory": [{"joint_trajectory": trajectory((*NAMES, "d"), [[*row, 2.0] for row in STATES.tolist()])}],
        "trajectory_start": {"joint_state": {"name": ["a", "d", "finger"], "position": [9.0, 9.0, 0.03]}},
    }
    (tmp_path / "t.json").write_text(json.dumps(document))
    found = read(tmp_path / "t.json")
    assert np.array_equal(found.states, STATES)
    assert found.others == {"d": 2.0, "finger": 0.03}
    document["trajectory_start"]["attached_collision_objects"] = [{"link_name": "hand", "object": {"id": "mug"}}]
    (tmp_path / "t.json").write_text(json.dumps(document))
    with pytest.warns(UserWarning, match="trajectory_start attaches mug, which is not looked at"):
        read(tmp_path / "t.json")


def based(**translation):
    """A trajectory whose base moves with it, or not."""
    shift = {"x": 0.0, "y": 0.0, "z": 0.0, **translation}
    still = {"translation": shift, "rotation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}
    base = {"joint_names": ["base"], "points": [{"transforms": [still]}]}
    return {"joint_trajectory": trajectory(NAMES, STATES.tolist()), "multi_dof_joint_trajectory": base}


def test_a_base_that_stands_still_may_be_in_a_trajectory(tmp_path):
    (tmp_path / "t.yaml").write_text(yaml.safe_dump({"trajectory": [based()]}))
    assert np.array_equal(read(tmp_path / "t.yaml").states, STATES)


# OMPL writes to a stream of its own, which is flushed at the end of the process.
PRINTING = """
import sys
import plannercheck as pc
from ompl import geometric
from plannercheck.ompl.joint_space import JointSpace
checker = pc.Checker(pc.Robot.load(sys.argv[1]))
information, space = pc.ompl.setup(checker).getSpaceInformation(), JointSpace(checker.robot)
information.setup()
path = geometric.PathGeometric(information)
for row in checker.robot.random_configurations(4, 1):
    path.append(space.state(information, row))
getattr(path, sys.argv[2])()
"""


@pytest.mark.parametrize(("name", "how"), [("panda", "print"), ("kinova", "print"), ("kinova", "printAsMatrix")])
def test_what_ompl_prints(tmp_path, name, how):
    robot = pc.Robot.load(name)
    done = subprocess.run([sys.executable, "-c", PRINTING, name, how], capture_output=True, text=True, check=True)
    (tmp_path / "printed.path").write_text(done.stdout)
    found = read_path(tmp_path / "printed.path", robot.joint_names, robot.nq)
    assert np.allclose(found.states, robot.random_configurations(4, 1), rtol=1e-5, atol=1e-5)  # it prints six digits


# One for each reader.
SUFFIXES = ("json", "yaml", "npy", "npz", "csv", "txt")


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.json", "[[1, 2]]", "2 numbers, not 3"),
        ("a.json", "{", "no JSON"),
        ("a.json", "3", "must hold"),
        ("a.json", "{}", "holds no 'path'"),
        ("a.json", "[]", "no states"),
        *(
            ("a.json", json.dumps({"path": [[1, 2, 3]], key: value}), f"unknown key '{key}'")
            for key, value in (("joints", list("cab")), ("joint_name", list("cab")), ("units", "deg"))
        ),
        ("a.txt", "1_0 2 3\n", "no table of numbers"),
        ("a.json", '[[1, 2, "x"]]', "no table of numbers"),
        ("a.json", "[[1, 2, 3], [1, NaN, 3]]", "state 1 is not finite"),
        ("a.yaml", yaml.safe_dump(trajectory(("a", "b"), [(1, 2)])), "has no joint 'c'"),
        (
            "a.yaml",
            yaml.safe_dump(trajectory("abcd", [(1, 2, 3, 4), (1, 2, 3, 5)])),
            "moves d, outside .* with d, or leave out",
        ),
        ("a.yaml", yaml.safe_dump(trajectory("abcc", [(1, 2, 3, 4)])), "twice"),
        ("a.yaml", yaml.safe_dump(trajectory("abc", [(1, 2)])), "positions"),
        ("a.yaml", yaml.safe_dump(based(x=0.1)), "multi_dof_joint_trajectory: moves base: only joint_trajectory"),
        ("a.yaml", yaml.safe_dump({"trajectory": based(x=0.1)}), "multi_dof_joint_trajectory: moves base"),
        (
            "a.yaml",
            yaml.safe_dump({"joint_names": list("abc"), "points": [{"positions": [1, 2, 3], "velocities": [1]}]}),
            "point 0: 'velocities' needs 3 numbers",
        ),
        (
            "a.yaml",
            yaml.safe_dump({"joint_names": list("abc"), "points": [{"positions": [1, 2, 3], "velocity": [1, 1, 1]}]}),
            "point 0: unknown key 'velocity'",
        ),
        ("a.yaml", yaml.safe_dump(timed(2, 0)), "point 1: is at 0 s, before the point before it: give points in time"),
        ("a.yaml", yaml.safe_dump(timed({"sec": 1, "secs": 2})), "point 0: unknown key 'secs'"),
        *(
            (
                "a.yaml",
                yaml.safe_dump({"trajectory": [entry, {"joint_trajectory": trajectory("abc", [(1, 2, 3)])}]}),
                words,
            )
            for entry, words in (
                (None, "trajectory 0: must have 'points', or a 'joint_trajectory' that has them; it has nothing"),
                ("abc", "trajectory 0: it must be a mapping of keys to values, not 'abc'"),
                (
                    {"joint_trajectry": trajectory("abc", [(1, 2, 3)])},
                    "trajectory 0: must have .* it has joint_trajectry$",
                ),
                (
                    {"joint_trajectory": {"joint_names": list("abc"), "point": []}},
                    "trajectory 0: joint_trajectory: must have 'points'.* it has joint_names, point$",
                ),
            )
        ),
        (
            "a.yaml",
            yaml.safe_dump({key: trajectory("abc", [(1, 2, 3)]) for key in ("joint_trajectory", "trajectory")}),
            "has both 'joint_trajectory' and 'trajectory': leave one out",
        ),
        ("a.path", "Geometric path with 2 states\nRealVectorState [1 2 3]\n", "2 states hold 3 numbers"),
        ("a.txt", "hello world\n", "no table of numbers"),
        *((f"missing.{suffix}", None, rf"^path file '[^']*missing\.{suffix}' does not exist$") for suffix in SUFFIXES),
    ],
)
def test_bad_files(tmp_path, name, content, message):
    if content is not None:
        (tmp_path / name).write_text(content)
    with pytest.raises(PlannercheckError, match=message):
        read(tmp_path / name)
