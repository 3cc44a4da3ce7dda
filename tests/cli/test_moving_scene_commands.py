"""Commands in a scene that moves: trajectories are judged, proved and shown; what has no time is refused."""

import json
from pathlib import Path

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.view.picture import picture

_SCENE = """
objects:
  - name: table
    box: {size: [1.2, 1.2, 0.04]}
    position: [0.3, 0, -0.05]
  - name: pallet
    box: {size: [0.2, 0.2, 0.2]}
    moving:
      times: [0, 8]
      poses: [{position: [0.4, -2, 0.5]}, {position: [0.4, 2, 0.5]}]
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """With a scene, a trajectory and a set."""
    robot = pc.Robot.load("panda")
    rows = np.stack([robot.reference, robot.reference])
    rows[1, 0] -= 0.3
    (tmp_path / "moving.yaml").write_text(_SCENE)
    pc.Trajectory([0.0, 2.0], rows, joint_names=robot.joint_names).save(tmp_path / "way.yaml")
    np.save(tmp_path / "set.npy", rows)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def _run(command: str, *words: str) -> int:
    return main([command, "--robot", "panda", "--scene", "moving.yaml", *words])


def test_a_trajectory_is_judged_on_the_scenes_clock(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It is free before the pallet comes, and collides while it passes."""
    path = ("--path", "way.yaml", "--controller", "jtc")
    assert _run("validate", *path) == 0
    assert "least at 2 s of the scene's clock" in capsys.readouterr().out
    assert _run("validate", *path, "--start-time", "3.3", "--format", "json") == 1
    (found,) = json.loads(capsys.readouterr().out)
    assert "pallet" in json.dumps(found)
    assert found["collides_at"] > 3.3
    assert _run("validate", *path, "--start-time", "7") == 2
    assert "'pallet' moves from 0 to 8 s" in capsys.readouterr().err


def test_what_has_no_time_is_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """With the remedy."""
    for words in (("validate", "set.npy"), ("validate", "--path", "way.yaml"), ("view", "--html", "page.html")):
        assert _run(*words) == 2
        said = capsys.readouterr().err
        assert "move" in said
        assert "--controller" in said
    assert not (folder / "page.html").exists()


def test_sets_are_judged_at_their_times(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """At one, or each row at its own, as by `check_states(times=)`; with a certificate of what collides."""
    checker = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("moving.yaml"))
    q, times = checker.robot.random_configurations(300, 0), np.linspace(0, 8, 300)
    np.save("many.npy", q)
    np.save("times.npy", times)
    for words, at in ((("--time", "4"), 4.0), (("--times", "times.npy"), times)):
        assert _run("validate", "many.npy", *words, "--output", "out.npz", "--explain", "--limits", "ignore") == 1
        with np.load("out.npz") as found:
            assert np.array_equal(found["valid"], checker.check_states(q, times=at))
            hit = found["first_pair"] >= 0
            assert np.isfinite(found["point"][hit]).all()
    valid = checker.check_states(q, times=times)
    assert not np.array_equal(valid, checker.check_states(q, times=4.0))
    np.save("times.npy", times[:299])
    for words, message in (
        (("--times", "times.npy"), "row 299 has no time"),
        (("--times", "times.npy", "--time", "1"), "in place of --time"),
        (("--time", "9"), "from 0 to 8 s"),
        (("--time", "1", "--certify"), "without --certify"),
    ):
        assert _run("validate", "many.npy", *words) == 2
        assert message in capsys.readouterr().err
    np.save("times.npy", np.append(times, 8.0))
    assert _run("validate", "many.npy", "--times", "times.npy") == 2
    assert "301 numbers" in capsys.readouterr().err


def test_a_proof_is_compared_with_where_the_scene_has_the_pallet(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Bodies, pairs and columns are the files', and so is the pallet's place at the times of the proof."""
    pytest.importorskip("flint")
    assert _run("validate", "--path", "way.yaml", "--controller", "jtc", "--certify") == 0
    compared = ["verify", "way.proof.json", "--robot", "panda", "--scene"]
    capsys.readouterr()
    assert main([*compared, "moving.yaml"]) == 0
    said = capsys.readouterr().out
    assert "where 'pallet' is at the proof's times, with the scene" in said
    assert "from 0 to 2 s of the scene's clock" in said
    for old, new in (
        ("0.2, 0.2, 0.2", "0.2, 0.2, 0.3"),
        ("pallet", "crate"),
        ("[0, 8]", "[0, 9]"),
        ("0.4, 2, 0.5", "0.4, 2, 0.6"),
        ("moving", "# moving"),
    ):
        text = _SCENE.replace(old, new)
        if new == "# moving":
            text = _SCENE[: _SCENE.index("    moving:")]
        (folder / "other.yaml").write_text(text)
        assert main([*compared, "other.yaml"]) == 1
        capsys.readouterr()


def test_a_path_is_proved_from_its_start_time(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """At another start time, for another message, or without the robot's files, it is not."""
    pytest.importorskip("flint")
    path = ("--path", "way.yaml", "--controller", "jtc")
    assert _run("validate", *path, "--start-time", "0.3", "--certify") == 0
    capsys.readouterr()
    assert _run("verify", "way.proof.json", *path, "--start-time", "0.3") == 0
    assert "its only motion is proved, from 0.3 to 2.3 s of the scene's clock" in capsys.readouterr().out
    for words in ((), ("--start-time", "0.300001")):
        assert _run("verify", "way.proof.json", *path, *words) == 1
        assert "and cut elsewhere" in capsys.readouterr().out
    assert _run("verify", "way.proof.json", *path, "--start-time", "nan") == 2
    assert "must be a number of seconds" in capsys.readouterr().err
    robot = pc.Robot.load("panda")
    ends = pc.Trajectory.load("way.yaml", robot).position([0.0, 2.0])
    for count, code, words in ((7, 1, "1 of the 1 pieces of the trajectory are not proved"), (6, 2, "panda_joint7")):
        names = robot.joint_names[:count]
        pc.Trajectory([0.0, 2.0], ends[:, :count] + 1e-6, joint_names=names).save("way.yaml")
        assert _run("verify", "way.proof.json", *path, "--start-time", "0.3") == code
        assert words in "".join(capsys.readouterr())
    for arguments, words in (
        ((*path, "--start-time", "0.3"), "name --robot and --scene"),
        (("--start-time", "0.3"), "with --path"),
    ):
        assert main(["verify", "way.proof.json", *arguments]) == 2
        assert words in capsys.readouterr().err


def test_a_page_shows_all_that_moves_in_real_time(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The pallet is where it is at each frame, as an obstacle."""
    assert _run("view", "--path", "way.yaml", "--controller", "jtc", "--start-time", "3", "--html", "page.html") == 0
    assert _run("view", "--time", "4", "--only-invalid", "--html", "set.html", "set.npy") in (0, 2)
    assert (folder / "page.html").stat().st_size > 10_000
    checker = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("moving.yaml"))
    times = np.linspace(2, 6, 9)
    shown = picture(checker, np.repeat(checker.robot.reference[None], 9, axis=0), times=times)
    (pallet,) = [mesh for mesh in shown.meshes if mesh.name == "pallet"]
    assert pallet.layer == "obstacle"
    assert np.allclose(pallet.poses[:, 1, 3], np.linspace(-1, 1, 9))
    assert shown.clearances is not None
    assert np.array_equal(shown.clearances, checker.clearances(checker.robot.reference, times=times))
    assert len(picture(checker, checker.robot.reference, time=1.0).meshes) == len(shown.meshes)
    with pytest.raises(pc.PlannercheckError, match="say when"):
        picture(checker, checker.robot.reference)
