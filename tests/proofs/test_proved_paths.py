"""Whether a file of proofs proves a whole path: in order, end to end, by any cut of straight motions."""

import json
from dataclasses import replace

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.ompl.plans import Plan
from plannercheck.proofs import load_proofs, save_proofs, verify_path


@pytest.fixture(scope="module")
def rows(checker):
    return checker.scene.start("panda") + np.linspace(0, 0.05, 5)[:, None] * [1, -1, 0.5, 0, 1, 0.3, 1]


@pytest.fixture(scope="module")
def proofs(checker, rows):
    return checker.certify_motions(rows[:-1], rows[1:])


def test_a_path_is_proved_by_its_proofs(proofs, rows, tmp_path, capsys):
    assert verify_path(proofs, rows)
    assert proofs[0].verify(path=rows[:2])
    save_proofs(proofs, tmp_path / "x.json")
    for name, write in (
        ("rows.json", lambda file: file.write_text(json.dumps(rows.tolist()))),
        ("rows.npy", lambda file: np.save(file, rows)),
        ("rows.csv", lambda file: file.write_text("\n".join(",".join(map(repr, row)) for row in rows.tolist()))),
        (
            "plan.json",
            lambda file: Plan(
                True, rows, 1.0, 0.0, 0.0, "x", joint_names=tuple(f"panda_joint{k}" for k in range(1, 8))
            ).save(file),
        ),
    ):
        write(tmp_path / name)
        assert main(["verify", str(tmp_path / "x.json"), "--path", str(tmp_path / name)]) == 0, name
        assert "all 4 motions proved" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("kept", "missing"),
    [
        ([0, 1, 3], [2]),
        ([1, 2, 3], [0]),
        ([0, 1, 2], [3]),
        ([], [0, 1, 2, 3]),
        ([0, 2, 1, 3], [2]),
        ([3, 2, 1, 0], [1, 2, 3]),
    ],
)
def test_what_is_missing_of_a_path_is_named(proofs, rows, tmp_path, capsys, kept, missing):
    # A proof out of its turn does not count: those before it do.
    changed = [proofs[k] for k in kept] or [replace(proofs[0], margin=-1.0)]
    save_proofs(changed, tmp_path / "x.json")
    (tmp_path / "p.json").write_text(json.dumps(rows.tolist()))
    assert main(["verify", str(tmp_path / "x.json"), "--path", str(tmp_path / "p.json"), "--format", "json"]) == 1
    (result,) = json.loads(capsys.readouterr().out)
    assert not result["proved"]
    if kept:
        assert result["path"]["missing"] == missing
        assert f"motion {missing[0]} goes from" in result["path"]["fault"]
    assert main(["verify", str(tmp_path / "x.json"), "--path", str(tmp_path / "p.json")]) == 1
    assert "path" in capsys.readouterr().out


def test_every_bit_of_a_path_counts(proofs, rows):
    generator = np.random.default_rng(1)
    for _ in range(10):
        k, column = generator.integers(len(rows)), generator.integers(7)
        changed = rows.copy()
        changed[k, column] = np.nextafter(changed[k, column], 9)
        found = verify_path(proofs, changed)
        assert not found
        assert "not proved" in found.fault


def test_motions_in_pieces_prove_the_whole_one_and_detours_do_not(checker, proofs, rows):
    # Rows 0 to 4 are on a line up to rounding.
    assert verify_path(proofs, rows[[0, 4]])
    assert verify_path(proofs, rows[[0, 2, 4]])
    assert not verify_path(proofs[:3], rows[[0, 4]])
    bent = rows.copy()
    bent[2, 3] += 1e-9
    assert not verify_path(checker.certify_motions(bent[:-1], bent[1:]), rows[[0, 4]])
    back = rows[[0, 2, 1, 4]]
    assert not verify_path(checker.certify_motions(back[:-1], back[1:]), rows[[0, 4]])


def test_a_single_state_is_a_motion_that_rests(checker, rows):
    (proof,) = checker.certify_motions(rows[:1], rows[:1])
    assert proof.verify(path=rows[0])
    assert not proof.verify(path=rows[1])


def test_turns_are_proved_as_a_controller_runs_them(tmp_path, capsys):
    (tmp_path / "arm.urdf").write_text(
        "<robot name='arm'><link name='base'/><link name='tip'><collision><origin xyz='0.5 0 0'/><geometry>"
        "<sphere radius='0.1'/></geometry></collision></link><joint name='j' type='continuous'><parent link='base'/>"
        "<child link='tip'/><axis xyz='0 0 1'/></joint></robot>"
    )
    (tmp_path / "arm.yaml").write_text("urdf: arm.urdf\ngroup: {name: arm, joints: [j]}\n")
    scene = pc.Scene("post")
    scene.add_sphere("post", 0.1, np.array([[1, 0, 0, 0.5], [0, 1, 0, 0], [0, 0, 1, 1], [0, 0, 0, 1.0]]))
    checker = pc.Checker(pc.Robot.load(str(tmp_path / "arm.yaml")), scene)
    points = [{"positions": [q], "time_from_start": {"sec": k}} for k, q in enumerate((0.5, 6.0))]
    message = tmp_path / "t.json"
    message.write_text(json.dumps({"joint_trajectory": {"joint_names": ["j"], "points": points}}))
    scene.save(tmp_path / "post.yaml")
    named = ["--robot", str(tmp_path / "arm.yaml"), "--scene", str(tmp_path / "post.yaml")]
    assert main(["validate", *named, "--path", str(message), "--certify"]) == 0
    assert main(["verify", str(tmp_path / "t.proof.json"), *named, "--path", str(message)]) == 0
    capsys.readouterr()
    # The short way from 0.5 to 6 is the other way round: its proof is none of the message, but of the table.
    save_proofs(checker.certify_motions([[0.5]], [[6.0]]), tmp_path / "short.json")
    (tmp_path / "table.json").write_text("[[0.5], [6.0]]")
    assert main(["verify", str(tmp_path / "short.json"), "--path", str(message)]) == 1
    assert main(["verify", str(tmp_path / "short.json"), "--path", str(tmp_path / "table.json")]) == 0
    assert main(["verify", str(tmp_path / "t.proof.json"), "--path", str(tmp_path / "table.json")]) == 1
    points[1]["velocities"] = [1.0]
    message.write_text(json.dumps({"joint_trajectory": {"joint_names": ["j"], "points": points}}))
    capsys.readouterr()
    assert main(["verify", str(tmp_path / "t.proof.json"), "--path", str(message)]) == 2
    assert "--straight" in capsys.readouterr().err
    assert main(["verify", str(tmp_path / "t.proof.json"), "--path", str(message), "--straight"]) == 0


def test_paths_that_hold_other_joints_elsewhere_are_not_proved(proofs, rows, tmp_path, capsys):
    save_proofs(proofs, tmp_path / "x.json")
    names = [f"panda_joint{k}" for k in range(1, 8)] + ["panda_finger_joint1"]
    for held, code in ((0.04, 0), (0.01, 1)):
        path = np.column_stack([rows, np.full(len(rows), held)])
        plan = Plan(True, path, 1.0, 0.0, 0.0, "x", joint_names=tuple(names))
        plan.save(tmp_path / "p.json")
        assert main(["verify", str(tmp_path / "x.json"), "--path", str(tmp_path / "p.json")]) == code
    assert "holds the joint 'panda_finger_joint1' at 0.01" in capsys.readouterr().out


def test_curves_do_not_prove_straight_paths(tmp_path, capsys):
    scene = pc.planar.Scene.load("warehouse")
    checker = pc.planar.Checker(pc.planar.Robot.load("forklift"), scene)
    q = np.array([scene.start("forklift"), scene.start("forklift") + np.array([0.3, 0.02, 0.05])])
    (tmp_path / "p.json").write_text(json.dumps(q.tolist()))
    straight = checker.certify_motions(q[:1], q[1:])
    curve = checker.certify_motions(q[:1], q[1:], curve="reeds_shepp", turning_radius=1.5)
    for proved, code in ((straight, 0), (curve, 1)):
        save_proofs(proved, tmp_path / "x.json")
        assert main(["verify", str(tmp_path / "x.json"), "--path", str(tmp_path / "p.json")]) == code
    assert "'reeds_shepp'" in capsys.readouterr().out


def test_calls_that_would_ignore_something_are_errors(proofs, tmp_path, capsys):
    with pytest.raises(pc.PlannercheckError, match="give the scene, too"):
        proofs[0].verify(robot="panda", meshes="solid")
    for wrong in (np.zeros((2, 6)), np.full((1, 7), np.nan), "none.json", [["a"] * 7], np.zeros((0, 7))):
        with pytest.raises(pc.PlannercheckError):
            proofs[0].verify(path=wrong)
    save_proofs(proofs, tmp_path / "x.json")
    file = str(tmp_path / "x.json")
    assert main(["verify", file, "--straight"]) == 2
    assert main(["verify", file, file, "--path", "p.json"]) == 2
    assert "one proof file" in capsys.readouterr().err


LIFT = (
    "<robot name='lift'><link name='base'/>"
    + "".join(
        f"<link name='{child}'><collision><origin xyz='0 0 0.2'/><geometry><box size='0.05 0.05 0.2'/></geometry>"
        f"</collision></link><joint name='{child}' type='{kind}'><parent link='{parent}'/><child link='{child}'/>"
        f"<origin xyz='0 0 0.5'/><axis xyz='0 1 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/>{more}</joint>"
        for parent, child, kind, more in (
            ("base", "turn", "continuous", ""),
            ("turn", "left", "revolute", ""),
            ("left", "right", "revolute", "<mimic joint='left' multiplier='0.7' offset='0.1'/>"),
        )
    )
    + "</robot>"
)


def test_a_path_of_one_number_a_joint_is_read_by_the_robot(tmp_path, capsys, monkeypatch):
    """A plan of a hand with joints that follow others was certified and could not be compared with its proof."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lift.urdf").write_text(LIFT)
    robot = ["--robot", "lift.urdf"]
    ends = ["--start", "0.5,0.1", "--goal", "2.8,-0.2"]
    assert main(["plan", *robot, *ends, "--output", "plan.json", "--seed", "1"]) == 0
    assert main(["validate", *robot, "--path", "plan.json", "--certify"]) == 0
    capsys.readouterr()
    assert main(["verify", "plan.proof.json", *robot, "--path", "plan.json"]) == 0
    assert "path 'plan.json': " in capsys.readouterr().out
    assert main(["verify", "plan.proof.json", "--path", "plan.json"]) == 2
    assert "name the robot, too (--robot, robot=)" in capsys.readouterr().err
    plan, proofs = Plan.load("plan.json"), load_proofs("plan.proof.json")
    assert plan.path.shape[1] == 2
    assert verify_path(proofs, plan.path, robot="lift.urdf")
    assert verify_path(proofs, "plan.json", robot="lift.urdf")
    other = plan.path + np.array([0.0, 1e-9])
    assert not verify_path(proofs, other, robot="lift.urdf")
    assert "not proved" in proofs[0].verify(robot="lift.urdf", path=other).fault
    for path in (plan.path, [[1.0, 2.0], [1.0]]):
        with pytest.raises(pc.PlannercheckError, match="with robot= they may have one number a joint"):
            verify_path(proofs, path)
    with pytest.raises(pc.PlannercheckError):
        verify_path(proofs, [[1.0, 2.0], [1.0]], robot="lift.urdf")
