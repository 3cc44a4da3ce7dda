"""A trajectory message turns a continuous joint through its numbers, as a controller runs it; OMPL's paths do not.

The oracle is `interpolate_between_points` of ros2_controllers for positions alone: start + part * (end - start), no
whole turns taken off. The states that it gives are judged one by one.
"""

import json
import re
import warnings
from itertools import pairwise

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.proofs import load_proofs
from plannercheck.validation.formats.paths import read_robot_path
from plannercheck.validation.paths import validate_path

_URDF = """<robot name="r"><link name="base"/><link name="arm"><collision><origin xyz="0.5 0 0"/><geometry>
<box size="1 0.05 0.05"/></geometry></collision></link><joint name="j" type="continuous"><parent link="base"/>
<child link="arm"/><axis xyz="0 0 1"/></joint><link name="gear"/><joint name="follower" type="continuous">
<parent link="base"/><child link="gear"/><axis xyz="0 0 1"/><mimic joint="j" multiplier="-3"/></joint></robot>"""

# Positions of the continuous joint, rad; the post is at 0.
WAYS = {
    "wrap.py": [3.0, -3.0],
    "the other way": [-3.0, 3.0],
    "two turns": [0.5, 0.5 + 4 * np.pi],
    "nearly a turn": [0.5, 6.0],
    "half a turn": [np.pi / 2, -np.pi / 2],
    "half a turn on the free side": [np.pi / 2, 3 * np.pi / 2],
    "short": [1.0, 2.0],
    "far from zero": [1e3 + 0.5, 1e3 + 2.5],
    "the second motion": [0.5, 1.0, 5.9, 12.0],
}


def wrapped_in(kind: str, positions: list[float]) -> dict:
    inner = {"joint_names": ["j"], "points": [{"positions": [x]} for x in positions]}
    robot = {"joint_trajectory": inner, "multi_dof_joint_trajectory": {"joint_names": [], "points": []}}
    return {
        "JointTrajectory": inner,
        "RobotTrajectory": robot,
        "DisplayTrajectory": {"model_id": "r", "trajectory": [robot]},
        "FollowJointTrajectory": {"trajectory": inner, "path_tolerance": [], "multi_dof_trajectory": {}},
    }[kind]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("turns")
    (out / "whole.urdf").write_text(_URDF)
    (out / "group.yaml").write_text("urdf: whole.urdf\ngroup: {name: arm, joints: [j]}\n")
    pose = np.eye(4)
    pose[0, 3] = 0.8
    scene = pc.Scene("post")
    scene.add_box("post", [0.05, 0.05, 1], pose)
    scene.save(out / "post.yaml")
    return out


@pytest.fixture(scope="module", params=["group.yaml", "whole.urdf"])
def checker(request, folder):
    return pc.Checker(pc.Robot.load(str(folder / request.param)), pc.Scene.load(folder / "post.yaml"))


def states(robot, angles):
    """Configurations of a robot whose follower turns by -3 times the angle."""
    if robot.nq == 1:
        return angles[:, None]
    factors = [{"j": 1, "follower": -3}[name] for name in robot.joint_names]
    return np.stack([f(k * angles) for k in factors for f in (np.cos, np.sin)], axis=1)


def free_motions(checker, positions):
    """By states a milliradian apart."""
    return [
        bool(checker.check_states(states(checker.robot, np.linspace(a, b, 2 + int(abs(b - a) * 1e3)))).all())
        for a, b in pairwise(positions)
    ]


@pytest.mark.parametrize("kind", ["JointTrajectory", "RobotTrajectory", "DisplayTrajectory", "FollowJointTrajectory"])
@pytest.mark.parametrize("way", WAYS)
def test_a_message_is_judged_as_a_controller_runs_it(tmp_path, checker, way, kind):
    positions = WAYS[way]
    (tmp_path / "t.json").write_text(json.dumps(wrapped_in(kind, positions)))
    found = read_robot_path(tmp_path / "t.json", checker.robot)
    verdict = validate_path(checker, found.states, pieces=found.pieces)
    free = free_motions(checker, positions)
    assert (verdict.states, verdict.motions, verdict.free_motions) == (len(positions), len(free), sum(free))
    assert verdict.motion == (None if all(free) else free.index(False))
    if verdict.stopped is not None:
        a, b = positions[verdict.motion : verdict.motion + 2]
        at = np.array([a + (verdict.stopped.collides_at + 1e-9) * (b - a)])
        assert not checker.is_valid(states(checker.robot, at)[0])
        until = np.linspace(a, a + (verdict.stopped.free_until - 1e-9) * (b - a), 1000)
        assert verdict.stopped.free_until == 0 or checker.check_states(states(checker.robot, until)).all()


def test_a_proof_states_the_pieces_that_it_proves(folder, checker, capsys):
    robot = "group.yaml" if checker.robot.nq == 1 else "whole.urdf"
    (folder / "t.json").write_text(json.dumps(wrapped_in("JointTrajectory", [0.5, 6.0])))
    named = ["--robot", str(folder / robot), "--scene", str(folder / "post.yaml")]
    assert main(["validate", *named, "--path", str(folder / "t.json"), "--certify"]) == 0
    assert "free, proved for the only motion in" in capsys.readouterr().out
    assert main(["verify", str(folder / "t.proof.json"), *named]) == 0
    assert re.search(r"\d motions in a row of '\w+' in 'post' proved", capsys.readouterr().out)
    proofs = load_proofs(folder / "t.proof.json")
    assert all(proof.verify().proved for proof in proofs)
    ends = np.array([proofs[0].motion.start, *(proof.motion.end for proof in proofs)])
    for k, name in enumerate(checker.robot.joint_names):
        angles = ends[:, 0] if ends.shape[1] == 1 else np.arctan2(ends[:, 2 * k + 1], ends[:, 2 * k])
        turned = (np.diff(angles) + np.pi) % (2 * np.pi) - np.pi
        assert (np.abs(turned) < 3.01).all()
        assert turned.sum() == pytest.approx({"j": 5.5, "follower": -16.5}[name])


@pytest.mark.parametrize("name", ["t.npy", "t.csv", "list.json", "plan.json", "t.txt"])
def test_other_paths_go_the_short_way(tmp_path, folder, name):
    """As OMPL's spaces have it; of a table, whose writer is not known, a warning says so."""
    robot = pc.Robot.load(str(folder / "group.yaml"))
    checker = pc.Checker(robot, pc.Scene.load(folder / "post.yaml"))
    rows = np.array([[3.0], [-3.0]])
    plan = {"joint_names": ["j"], "path": rows.tolist()}
    texts = {
        "list.json": json.dumps(rows.tolist()),
        "plan.json": json.dumps(plan),
        "t.txt": "3.0\n-3.0\n",
        "t.csv": "j\n3.0\n-3.0\n",
    }
    if name in texts:
        (tmp_path / name).write_text(texts[name])
    else:
        np.save(tmp_path / name, rows)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        found = read_robot_path(tmp_path / name, robot)
    assert validate_path(checker, found.states, pieces=found.pieces).free
    assert [str(each.message).count("turns by 6 rad from state 0 to 1") for each in told] == [1] * (
        name in ("t.npy", "t.csv")
    )


def test_from_one_message_to_the_next_the_short_way_is_gone(tmp_path, checker):
    """ros2_controllers take whole turns off on the way from the state before a message (`wraparound_joint`)."""
    parts = [wrapped_in("RobotTrajectory", part) for part in ([1.0, 3.0], [3.0 - 2 * np.pi, -1.0])]
    (tmp_path / "t.json").write_text(json.dumps({"trajectory": parts}))
    found = read_robot_path(tmp_path / "t.json", checker.robot)
    verdict = validate_path(checker, found.states, pieces=found.pieces)
    assert verdict.free
    assert (verdict.motions, verdict.cut > 0) == (3, checker.robot.nq > 1)  # of the follower


def test_turns_without_end_are_refused(tmp_path, checker):
    (tmp_path / "t.json").write_text(json.dumps(wrapped_in("JointTrajectory", [0.0, 1e9])))
    with pytest.raises(pc.PlannercheckError, match=r"t\.json': a continuous joint turns by [13]e\+09 rad"):
        read_robot_path(tmp_path / "t.json", checker.robot)


def test_a_base_that_moves_is_refused(tmp_path, checker):
    moved = {"points": [{"transforms": [{"translation": {"x": 1.0, "y": 0.0, "z": 0.0}}]}], "joint_names": ["base"]}
    for key in ("multi_dof_joint_trajectory", "multi_dof_trajectory"):
        (tmp_path / "t.json").write_text(json.dumps({**wrapped_in("FollowJointTrajectory", [0.5, 1.0]), key: moved}))
        with pytest.raises(pc.PlannercheckError, match=f"{key}: moves base"):
            read_robot_path(tmp_path / "t.json", checker.robot)


@pytest.mark.parametrize("end", ["", "---\n", "---", "\n---\n\n", "...\n---\n"])
def test_an_echoed_trajectory_is_one_document(tmp_path, checker, end):
    text = "joint_names: [j]\npoints:\n- positions: [0.5]\n- positions: [1.0]\n"
    (tmp_path / "t.yaml").write_bytes((text + end).encode())
    (tmp_path / "dos.yaml").write_bytes((text + end).replace("\n", "\r\n").encode())
    for name in ("t.yaml", "dos.yaml"):
        assert len(read_robot_path(tmp_path / name, checker.robot).states) == 2
    (tmp_path / "several.yaml").write_text(f"{text}---\n{text}---\n{text}---\n")
    with pytest.raises(
        pc.PlannercheckError, match=r"several\.yaml': holds 3 YAML documents, parted by lines of dashes"
    ):
        read_robot_path(tmp_path / "several.yaml", checker.robot)
