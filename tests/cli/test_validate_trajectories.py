"""`validate --path` of trajectories: what the controller runs is judged, in words and in JSON."""

import json
from pathlib import Path

import numpy as np
import pytest
from yaml import safe_load

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.proofs import verify_trajectory

ROBOT = pc.Robot.load("panda")
HOME = ROBOT.reference
AWAY = HOME + 0.1


@pytest.fixture(scope="module")
def checker():
    return pc.Checker(ROBOT, pc.Scene.load("bookshelf"))


def saved(path: Path, q, v=None, times=None) -> Path:
    times = np.arange(len(q), dtype=float) if times is None else times
    pc.Trajectory(times, np.array(q), v, joint_names=ROBOT.joint_names).save(path)
    return path


def command(*words) -> int:
    return main(["validate", "--robot", "panda", "--scene", "bookshelf", *map(str, words)])


def judged(capsys, *words) -> tuple[int, dict]:
    code = command("--format", "json", *words)
    (found,) = json.loads(capsys.readouterr().out)
    return code, found


@pytest.fixture
def free(tmp_path) -> Path:
    v = np.zeros((3, 7))
    v[1] = 0.3
    return saved(tmp_path / "free.yaml", [HOME, AWAY, HOME], v)


@pytest.fixture
def through(tmp_path, checker) -> Path:
    """Free at its three points, not between them."""
    for seed in range(100):
        a, b = ROBOT.random_configurations(2, seed)
        file = saved(tmp_path / "through.yaml", [a, b, a], np.zeros((3, 7)), [0.0, 2.0, 4.0])
        if checker.check_states([a, b]).all() and not checker.check_trajectory(pc.Trajectory.load(file, ROBOT)):
            return file
    raise AssertionError


def test_a_message_with_velocities_is_judged_as_it_is_run(capsys, checker, free):
    code, found = judged(capsys, "--path", free)
    verdict = checker.explain_trajectory(pc.Trajectory.load(free, ROBOT))
    assert code == 0
    assert found["free"] is verdict.free is True
    for key in ("free_until", "clearance", "clearance_at", "largest_tube"):
        assert found[key] == getattr(verdict, key)
    assert (found["controller"], found["pieces"], found["seconds"]) == ("jtc", 2, 2.0)
    assert command("--path", free, "--tube", found["largest_tube"]) == 0
    words = capsys.readouterr().out
    assert f"run by jtc in 2 s, tube {found['largest_tube']:g}); clearance" in words
    assert f"largest tube {found['largest_tube']:.3g}" in words


def test_the_controller_and_the_tube_decide(capsys, free):
    code, found = judged(capsys, "--path", free, "--controller", "linear")
    assert (code, found["controller"]) == (0, "linear")
    code, found = judged(capsys, "--path", free, "--tube", "1")
    assert (code, found["free"], found["collides_at"]) == (1, False, None)
    assert found["near_at"] is not None
    assert len(found["pair"]) == 2
    code, found = judged(capsys, "--path", free, "--tube", "0,0,0,0,0,0,1")
    assert (code, found["tube"]) == (0, [0, 0, 0, 0, 0, 0, 1])


def test_a_proof_is_written_and_verified(capsys, tmp_path, free):
    code, found = judged(capsys, "--path", free, "--tube", "0.02", "--certify")
    assert (code, found["proof"], found["proof_fault"]) == (0, str(tmp_path / "free.proof.json"), None)
    same = ["--robot", "panda", "--scene", "bookshelf", "--path", str(free), "--controller", "jtc"]
    assert main(["verify", found["proof"], *same, "--tube", "0.02"]) == 0
    assert main(["verify", found["proof"], *same, "--tube", "0.03"]) == 1  # wider than what is proved
    capsys.readouterr()


def test_the_first_collision_is_told(capsys, through):
    code, found = judged(capsys, "--path", through, "--controller", "jtc")
    assert code == 1
    assert 0 < found["free_until"] <= found["collides_at"] < 4
    assert len(found["certificate"]["shared_point"]) == 3
    assert command("--path", through, "--controller", "jtc") == 1
    assert f"collides at {found['collides_at']:.6g} s: " in capsys.readouterr().out


def test_the_way_from_where_the_robot_stands_counts(capsys, tmp_path):
    file = saved(tmp_path / "t.yaml", [AWAY, HOME], None, [1.0, 2.0])
    code, found = judged(capsys, "--path", file, "--start", ",".join(map(repr, HOME.tolist())))
    assert (code, found["pieces"]) == (0, 2)


def test_limits_are_told(capsys, tmp_path):
    v = np.zeros((3, 7))
    v[1, 0] = 3.0
    file = saved(tmp_path / "fast.yaml", [HOME, AWAY, HOME], v)
    (tmp_path / "joint_limits.yaml").write_text(
        "joint_limits: {panda_joint1: {has_acceleration_limits: true, max_acceleration: 4.0}}"
    )
    assert judged(capsys, "--path", file)[1]["limits"] == []
    code, found = judged(capsys, "--path", file, "--joint-limits", tmp_path / "joint_limits.yaml")
    assert code == 1
    assert [(each["joint"], each["kind"], each["limit"]) for each in found["limits"]] == [
        ("panda_joint1", "velocity", 2.175),
        ("panda_joint1", "acceleration", -4.0),
    ]
    assert command("--path", file, "--joint-limits", tmp_path / "joint_limits.yaml") == 1
    assert "breaks a limit: panda_joint1: velocity 3 at 1 s, beyond 2.175" in capsys.readouterr().out


def test_one_of_several_messages_is_chosen(capsys, tmp_path, free):
    part = {"joint_trajectory": safe_load(free.read_text())}
    other = json.loads(json.dumps(part))
    other["joint_trajectory"]["points"][-1]["positions"][0] += 0.01
    (tmp_path / "two.json").write_text(json.dumps({"trajectory": [other, part]}))
    assert command("--path", tmp_path / "two.json") == 2
    assert "holds 2 JointTrajectory messages: choose one by message= (--message)" in capsys.readouterr().err
    assert judged(capsys, "--path", tmp_path / "two.json", "--message", "1")[0] == 0
    chosen = ("--path", tmp_path / "two.json", "--controller", "jtc", "--message")
    assert judged(capsys, *chosen, "1", "--certify")[0] == 0
    for number in ("0", "1"):
        code = main(["verify", str(tmp_path / "two.proof.json"), *map(str, chosen), number])
        assert (code, "all 2 motions proved" in capsys.readouterr().out) == ((0, True) if number == "1" else (1, False))


def test_joints_that_the_start_holds_are_held(capsys, tmp_path, checker, free):
    """A finger far out leaves less room around the trajectory."""
    out = {"panda_finger_joint1": 0.3}
    start = {"joint_state": {"name": list(out), "position": list(out.values())}}
    message = {"trajectory_start": start, "trajectory": [{"joint_trajectory": safe_load(free.read_text())}]}
    (tmp_path / "t.json").write_text(json.dumps(message))
    _, found = judged(capsys, "--path", tmp_path / "t.json")
    trajectory = pc.Trajectory.load(free, ROBOT)
    held = pc.Checker(ROBOT.holding(out), checker.scene).explain_trajectory(trajectory)
    assert found["largest_tube"] == held.largest_tube < checker.explain_trajectory(trajectory).largest_tube


def with_finger(file: Path, values, velocities=None) -> Path:
    """The message with a joint outside the planning group, at these values at its points."""
    message = safe_load(file.read_text())
    message["joint_names"].append("panda_finger_joint1")
    for k, point in enumerate(message["points"]):
        point["positions"].append(values[k])
        if "velocities" in point:
            point["velocities"].append(0.0 if velocities is None else velocities[k])
    out = file.with_name("finger.json")
    out.write_text(json.dumps(message))
    return out


@pytest.mark.parametrize("options", [(), ("--controller", "jtc"), ("--straight",)])
def test_joints_outside_the_group_are_held_or_refused_with_and_without_a_controller(capsys, checker, tmp_path, options):
    file = saved(tmp_path / "t.yaml", [HOME, AWAY, HOME], None if options == ("--straight",) else np.zeros((3, 7)))
    held = with_finger(file, [0.3] * 3)
    assert judged(capsys, "--path", held, *options)[1]["free"]
    if options != ("--straight",):
        posed = pc.Checker(ROBOT.holding({"panda_finger_joint1": 0.3}), checker.scene)
        expected = posed.explain_trajectory(pc.Trajectory.load(file, ROBOT)).largest_tube
        assert judged(capsys, "--path", held, "--controller", "jtc")[1]["largest_tube"] == expected
        assert expected < checker.explain_trajectory(pc.Trajectory.load(file, ROBOT)).largest_tube
    assert command("--path", with_finger(file, [0.0, 0.0, 0.01]), *options) == 2
    assert "moves panda_finger_joint1, outside the planning group: choose a group with" in capsys.readouterr().err


def test_a_joint_outside_the_group_that_only_has_a_velocity_is_refused(capsys, tmp_path):
    file = with_finger(saved(tmp_path / "t.yaml", [HOME, AWAY, HOME], np.zeros((3, 7))), [0.0] * 3, [0.0, 0.1, 0.0])
    assert command("--path", file, "--controller", "jtc") == 2
    assert "moves panda_finger_joint1" in capsys.readouterr().err


def test_a_trajectory_is_loaded_for_the_robot_that_holds_its_other_joints(capsys, tmp_path):
    file = with_finger(saved(tmp_path / "t.yaml", [HOME, AWAY, HOME], np.zeros((3, 7))), [0.03] * 3)
    with pytest.raises(pc.PlannercheckError, match=r"give robot\.holding\(\{'panda_finger_joint1': 0\.03\}\)"):
        pc.Trajectory.load(file, ROBOT)
    posed = ROBOT.holding({"panda_finger_joint1": 0.03})
    trajectory = pc.Trajectory.load(file, posed)
    proofs = [
        pc.Checker(robot, pc.Scene("empty")).certify_trajectory(pc.Trajectory(*rows))
        for rows in [(trajectory.points.times, trajectory.points.positions, trajectory.points.velocities)]
        for robot in (posed, ROBOT)
    ]
    assert verify_trajectory(proofs[0], file)
    assert "holds the joint 'panda_finger_joint1' at 0.03" in verify_trajectory(proofs[1], file).fault
    capsys.readouterr()


def test_a_late_first_point_is_told_once(capsys, tmp_path):
    file = saved(tmp_path / "late.yaml", [HOME, AWAY], None, [0.5, 2.0])
    assert command("--path", file, "--controller", "jtc") == 0
    err = capsys.readouterr().err
    assert err.count("its first point is at 0.5 s, and it is judged from then on") == 1
    assert command("--path", file, "--controller", "jtc", f"--start={','.join(map(repr, HOME.tolist()))}") == 0
    assert "first point is at" not in capsys.readouterr().err
    with pytest.warns(RuntimeWarning, match="judged from then on") as caught:
        pc.Trajectory.load(file, ROBOT)
    assert [each.filename for each in caught] == [__file__]


def test_a_row_that_is_no_numbers_is_named(capsys, free):
    for option in ("--start", "--tube"):
        assert command("--path", free, option, "0,a") == 2
        assert f"argument {option}: must be numbers separated by commas, not '0,a'" in capsys.readouterr().err


def test_what_is_no_trajectory_is_named(capsys, tmp_path):
    np.save(tmp_path / "q.npy", np.array([HOME, AWAY]))
    assert command("--path", tmp_path / "q.npy", "--tube", "0.1") == 2
    assert "must be one of .yaml, .yml, .json, .csv, .npz" in capsys.readouterr().err
    words = ["--robot", "truck_trailer", "--scene", "parking", "--path", str(tmp_path / "q.npy"), "--controller", "jtc"]
    np.save(tmp_path / "q.npy", np.zeros((2, pc.planar.Robot.load("truck_trailer").nq)))
    assert main(["validate", *words]) == 2
    assert "planar, and trajectories are of robots in space" in capsys.readouterr().err
