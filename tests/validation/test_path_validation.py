"""Whole paths are judged motion by motion; the command says where the first stops, and by what."""

import json

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.validation.paths import validate_path


@pytest.fixture(scope="module")
def plan(checker):
    return pc.ompl.plan(checker, checker.scene.start("panda"), checker.scene.goal("panda"), seed=1)


@pytest.fixture(scope="module")
def through(checker, plan):
    """A path that leaves out what goes around the shelf."""
    return np.vstack([plan.path[:1], plan.path[:1] + 1e-3, plan.path[-1:]])


def test_a_plan_is_free(checker, plan):
    verdict = validate_path(checker, plan.path)
    assert verdict.passed
    assert (verdict.motions, verdict.free_motions) == (len(plan.path) - 1, len(plan.path) - 1)
    assert verdict.stopped is None


def test_the_first_motion_that_is_not_free_is_named(checker, through):
    verdict = validate_path(checker, through)
    assert not verdict.free
    assert (verdict.motion, verdict.free_motions, verdict.motions) == (1, 1, 2)
    stopped = verdict.stopped
    assert stopped.free_until <= stopped.collides_at
    assert stopped.pair.certificate.verify()
    state = (1 - stopped.collides_at) * through[1] + stopped.collides_at * through[2]
    assert not checker.is_valid(state)


def test_a_single_configuration_and_limits(checker, plan):
    assert validate_path(checker, plan.path[0]).passed
    beyond = np.vstack([plan.path[0], plan.path[0]])
    beyond[1, 6] = checker.robot.upper[6] + 0.1
    verdict = validate_path(checker, beyond)
    assert verdict.beyond_limits == 1
    assert not verdict.passed


def command(*arguments):
    return main(["validate", "--robot", "panda", "--scene", "bookshelf", *map(str, arguments)])


def test_the_command(tmp_path, capsys, plan, through):
    plan.save(tmp_path / "plan.json")
    np.save(tmp_path / "through.npy", through)
    assert command("--path", tmp_path / "plan.json") == 0
    assert "free, proved for all" in capsys.readouterr().out
    assert command("--path", tmp_path / "plan.json", tmp_path / "through.npy") == 1
    said = capsys.readouterr().out.splitlines()[1]
    assert "motion 1 is proved free up to" in said
    assert "share the point" in said
    assert command("--path", tmp_path / "through.npy", "--format", "json") == 1
    (result,) = json.loads(capsys.readouterr().out)
    assert result["motion"] == 1
    assert result["free_until"] <= result["collides_at"]
    assert len(result["certificate"]["shared_point"]) == 3
    assert len(result["pair"]) == 2


def test_joints_outside_the_group_are_held_as_the_file_says(tmp_path, capsys, checker, plan):
    names = [*checker.robot.joint_names, "panda_finger_joint1"]
    points = [{"positions": [*row, 0.0]} for row in plan.path.tolist()]
    (tmp_path / "t.json").write_text(json.dumps({"joint_names": names, "points": points}))
    closed = pc.Checker(checker.robot.holding({"panda_finger_joint1": 0.0}), checker.scene)
    expected = 0 if validate_path(closed, plan.path).passed else 1
    assert command("--path", tmp_path / "t.json") == expected
    capsys.readouterr()


def test_straight_motions_are_proved_where_they_are_meant(tmp_path, capsys, checker, plan):
    points = [{"positions": row, "velocities": [0.1] * 7} for row in plan.path.tolist()]
    points[-1]["velocities"] = [0.0] * 7
    points = [{**point, "time_from_start": {"sec": 2 * k}} for k, point in enumerate(points)]
    file = tmp_path / "t.json"
    file.write_text(json.dumps({"joint_names": list(checker.robot.joint_names), "points": points}))
    assert command("--path", file, "--straight") == 0
    assert "free, proved for all" in capsys.readouterr().out
    command("--path", file)
    assert "run by jtc" in capsys.readouterr().out
    assert command(tmp_path / "a.npy", "--straight") == 2
    capsys.readouterr()


def test_either_sets_or_paths(tmp_path, capsys):
    assert command() == 2
    assert command(tmp_path / "a.npy", "--path", tmp_path / "b.npy") == 2
    assert command("--path", tmp_path / "b.npy", "--output", tmp_path / "c.npz") == 2
    capsys.readouterr()
