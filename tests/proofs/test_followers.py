"""Messages with joints that follow others, and with joints that stand still, are compared with proofs by the robot."""

import json
from dataclasses import replace

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.proofs import load_proofs, save_proofs, verify_path, verify_trajectory
from plannercheck.proofs.well_formed import hashes_of

_LINK = '<link name="{0}"><collision><geometry><box size="0.05 0.05 0.2"/></geometry></collision></link>'
_JOINT = (
    '<joint name="{0}" type="{1}"><parent link="base"/><child link="{0}_link"/><origin xyz="{2} 0 0.3"/>'
    '<axis xyz="0 {3} 0"/><limit lower="-1.5" upper="1.5" effort="1" velocity="1"/>{4}</joint>'
)


def gripper(folder, leader, follower, axes=(1, 1), by=(-1.0, 0.0), kind="revolute"):
    """A robot of one joint, one that follows it, and one that stands still and turns about a negative axis."""
    mimic = '<mimic joint="{}" multiplier="{}" offset="{}"/>'.format(leader, *by)
    text = "".join(_LINK.format(name) for name in ("base", f"{leader}_link", f"{follower}_link", "spare_link"))
    text += _JOINT.format(leader, kind, 0.3, axes[0], "") + _JOINT.format(follower, kind, -0.3, axes[1], mimic)
    text += _JOINT.format("spare", "revolute", 0.9, -1, "")
    (folder / "gripper.urdf").write_text(f'<robot name="gripper">{text}</robot>')
    (folder / "gripper.yaml").write_text(
        f"urdf: gripper.urdf\ngroup: {{name: one, joints: [{leader}]}}\nheld: {{spare: 0.25}}\n"
    )
    return folder / "gripper.yaml"


def message(path, **columns):
    rows = zip(*columns.values(), strict=True)
    points = [{"positions": list(row), "time_from_start": float(k)} for k, row in enumerate(rows)]
    path.write_text(json.dumps({"joint_names": list(columns), "points": points}))
    return str(path)


@pytest.fixture
def verified(tmp_path, capsys):
    """The exit code and what is said of a proof of a gripper's motion from 0 to 0.5, and of a message."""

    def run(robot, is_named, path, *words):
        proofs = pc.Checker(pc.Robot.load(robot), pc.Scene()).certify_trajectory(pc.Trajectory([0, 1], [[0.0], [0.5]]))
        save_proofs(proofs, tmp_path / "p.json")
        named = ("--robot", str(robot)) if is_named else ()
        code = main(["verify", str(tmp_path / "p.json"), "--path", path, *(words or ("--controller", "jtc")), *named])
        out = capsys.readouterr()
        return code, out.out + out.err

    return run


@pytest.mark.parametrize(
    ("kind", "axes"), [("revolute", (1, 1)), ("revolute", (1, -1)), ("revolute", (-1, 1)), ("prismatic", (1, -1))]
)
@pytest.mark.parametrize("by", [(-1.0, 0.0), (1.0, 0.0), (0.5, 0.1)])
@pytest.mark.parametrize("names", [("drive", "other"), ("other", "drive")])
def test_a_follower_beside_its_leader(verified, tmp_path, kind, axes, by, names):
    """Consistent ones are confirmed, in any order of names; others are refused, with the joint and both values."""
    leader, follower = names
    robot, file = gripper(tmp_path, *names, axes, by, kind), tmp_path / "m.json"
    right = [by[1], by[0] * 0.5 + by[1]]
    for words in ((), ("--straight",)):
        code, out = verified(robot, True, message(file, **{follower: right, leader: [0.0, 0.5]}), *words)
        assert (code, "model: confirmed" in out) == (0, True), out
        assert verified(robot, True, message(file, **{leader: [0.0, 0.5], "spare": [0.25, 0.25]}), *words)[0] == 0
        code, out = verified(robot, True, message(file, **{follower: [right[0], 0.4], leader: [0.0, 0.5]}), *words)
        assert code == 2
        assert (
            f"point 1: joint {follower!r} follows {leader!r}, which makes its positions {right[1]:.9g}, not 0.4" in out
        )
        assert verified(robot, True, message(file, **{follower: [0.0, 0.5]}), *words)[0] == 2
    proofs = load_proofs(tmp_path / "p.json")
    message(file, **{follower: right, leader: [0.0, 0.5]})
    assert verify_trajectory(proofs, file, robot=str(robot))
    assert verify_path(proofs, file, robot=str(robot))
    with pytest.raises(pc.PlannercheckError, match=r"\(--robot, robot=\)"):
        verify_trajectory(proofs, file)


@pytest.mark.parametrize("names", [("drive", "other"), ("other", "drive")])
def test_without_the_robot_nobody_knows_which_joint_follows(verified, tmp_path, names):
    """Found by an audit: a message of the follower alone was taken for one of its leader, which turns the other way."""
    robot = gripper(tmp_path, *names)
    for name in names:
        for words in ((), ("--straight",)):
            code, out = verified(robot, False, message(tmp_path / "m.json", **{name: [0.0, 0.5]}), *words)
            assert (code, "the robot says which one follows: name it (--robot, robot=)" in out) == (2, True), out
    np.save(tmp_path / "m.npy", [[0.0], [0.5]])
    assert verified(robot, False, str(tmp_path / "m.npy"), "--format", "table")[0] == 0


@pytest.mark.parametrize(("held", "given"), [(0.25, 0.7), (0.25, -0.25), (0.0, 0.7), (0.0, -0.7)])
@pytest.mark.parametrize("is_named", [True, False])
def test_where_a_joint_stands_still(verified, tmp_path, held, given, is_named):
    """Found by an audit: where a proof holds a joint at 0, a message could hold it anywhere."""
    robot = gripper(tmp_path, "drive", "other", by=(0.5, 0.1))
    robot.write_text(robot.read_text().replace("0.25", str(held)))
    for value, expected in ((held, 0), (given, 1)):
        code, out = verified(robot, is_named, message(tmp_path / "m.json", drive=[0.0, 0.5], spare=[value] * 2))
        assert code == expected, out
        assert (f"holds the joint 'spare' at {value!r}" in out) == bool(expected)


def test_a_joint_that_stands_still_is_not_turned_about_another_axis(verified, tmp_path):
    """Found by changing proofs: a proof of a joint at -0.25 passed for one of a path that holds it at 0.25."""
    robot, file = gripper(tmp_path, "drive", "other", by=(0.5, 0.1)), tmp_path / "m.json"
    assert verified(robot, True, message(file, drive=[0.0, 0.5], spare=[0.25, 0.25]))[0] == 0
    (proof,) = load_proofs(tmp_path / "p.json")
    joints = [
        replace(joint, axis=tuple(-x for x in joint.axis)) if joint.name == "spare" else joint
        for joint in proof.model.joints
    ]
    model = replace(proof.model, joints=tuple(joints))
    changed = replace(proof, model=model, hashes=hashes_of(model))
    assert changed.verify()
    found = changed.verify(str(robot))
    assert "joint 'spare' stands still, and the sign" in str(found.fault)


def test_followers_in_a_cell(tmp_path, capsys):
    robot = gripper(tmp_path, "other", "drive")
    (tmp_path / "cell.yaml").write_text(
        f"robots:\n  a: {{load: {robot}}}\n  b: {{load: {robot}, pose: {{position: [3, 0, 0]}}}}\n"
    )
    cell = pc.Robot.load(tmp_path / "cell.yaml")
    proofs = pc.Checker(cell, pc.Scene()).certify_trajectory(pc.Trajectory([0, 1], [[0.0, 0.1], [0.5, 0.1]]))
    save_proofs(proofs, tmp_path / "p.json")
    for right, code in ((-0.5, 0), (0.5, 2)):
        file = message(tmp_path / "m.json", other=[0.0, 0.5], drive=[0.0, right])
        words = ["--path", f"a={file}", "b=0.1", "--controller", "jtc", "--robot", str(tmp_path / "cell.yaml")]
        assert main(["verify", str(tmp_path / "p.json"), *words]) == code, capsys.readouterr()
    assert "joint 'drive' follows 'other'" in capsys.readouterr().err
