"""Trajectories of a cell's robots on the command line: judged on one clock, proved, and held against their proofs."""

import json
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from crossing_boxes import HALF, gantries
from gantries import gantry_robot

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.proofs import load_proofs, verify_trajectory
from plannercheck.proofs.executed_messages import cell_proved

pytestmark = pytest.mark.filterwarnings("ignore:.*it is judged from then on")


@pytest.fixture(name="folder")
def _folder(tmp_path, monkeypatch):
    """A cell of two gantries, and a message of each: left along x, right along y, which cross at 1 s."""
    checker = gantries(tmp_path, ("left", "right"))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cell.yaml").write_text(
        "robots:\n  left: {load: gantry.urdf, pose: {position: [0, 0, 0]}}\n"
        "  right: {load: gantry.urdf, pose: {position: [0, 0, 0]}}\n"
    )
    rng = np.random.default_rng(0)
    for name, way in (("left", [1.0, 0.1]), ("right", [0.1, 1.0])):
        points = np.linspace(-1, 1, 5)[:, None] * way + rng.uniform(-0.01, 0.01, (5, 2))
        velocities = np.tile(np.array(way), (5, 1))
        velocities[[0, -1]] = 0.0
        made = pc.Trajectory(np.array([0.1, 0.6, 1.1, 1.6, 2.1]), points, velocities, joint_names=["x", "y"])
        made.save(tmp_path / f"{name}.yaml")
    return checker, tmp_path


PATHS = ["--path", "left=left.yaml", "right=right.yaml"]


def test_two_that_meet(folder, capsys):
    assert main(["validate", "--robot", "cell.yaml", *PATHS]) == 1
    out = capsys.readouterr().out
    assert out.startswith("left, right on one clock: at 0.")
    assert "left/tip – right/tip" in out
    assert main(["validate", "--robot", "cell.yaml", *PATHS, "--format", "json"]) == 1
    (told,) = json.loads(capsys.readouterr().out)
    assert told["robots"] == ["left", "right"]
    assert not told["free"]
    assert told["collides_at"] == pytest.approx(0.9, abs=0.15)
    assert told["paths"] == {"left": "left.yaml", "right": "right.yaml"}
    elsewhere = [f"left={folder[1]}/left.yaml", f"right=../{folder[1].name}/right.yaml"]
    assert main(["validate", "--robot", "cell.yaml", "--path", *elsewhere]) == 1
    assert capsys.readouterr().out == out


def test_one_that_waits_is_proved_and_held_against_the_messages(folder, capsys):
    delayed = [*PATHS, "--delay", "right=0.7", "--controller", "jtc"]
    assert main(["validate", "--robot", "cell.yaml", *delayed, "--certify"]) == 0
    assert "right from 0.7 s; certified" in capsys.readouterr().out
    assert main(["verify", "cell.proof.json", "--robot", "cell.yaml", *delayed]) == 0
    out = capsys.readouterr().out
    assert "robots: 'left' has columns 0 to 1, 'right' has columns 2 to 3" in out
    assert "path 'left=left.yaml from 0 s, right=right.yaml from 0.7 s': all" in out
    assert "model: confirmed" in out
    for other in (["right=0.71"], ["left=0.001", "right=0.7"]):
        assert main(["verify", "cell.proof.json", *PATHS, "--delay", *other, "--controller", "jtc"]) == 1
        assert "on the clock are not proved" in capsys.readouterr().out
    assert main(["verify", "cell.proof.json", *delayed, "--tube", "1e-6"]) == 1
    capsys.readouterr()
    assert main(["verify", "cell.proof.json", *delayed[:-1], "linear"]) == 1


def test_a_tube_and_a_robot_that_stands(folder, capsys):
    standing = ["--path", "left=left.yaml", "right=0.0,0.9", "--controller", "ur"]
    proved = ["--certify", "--proof", "made.proof.npz", "--tube", "0.01"]
    assert main(["validate", "--robot", "cell.yaml", *standing, *proved]) == 0
    capsys.readouterr()
    assert main(["verify", "made.proof.npz", *standing, "--tube", "0.01"]) == 0
    out = capsys.readouterr().out
    assert "every configuration within 0.01 rad or m" in out
    assert main(["verify", "made.proof.npz", *standing, "--tube", "0.0101"]) == 1
    moved = ["--path", "left=left.yaml", "right=0.0,0.92", "--controller", "ur"]
    assert main(["verify", "made.proof.npz", *moved]) == 1


@pytest.mark.parametrize("seed", range(12))
def test_random_messages_in_fractions(tmp_path, seed):
    """The proof of what is merged proves the messages: knots that nearly meet, late ones, all controllers."""
    rng = np.random.default_rng(seed)
    checker = gantries(tmp_path, ("left", "right"))
    controller = ("jtc", "ur", "motoros2", "linear")[seed % 4]
    runs, files = {}, {}
    for k, name in enumerate(("left", "right")):
        count = int(rng.integers(2, 5))
        late = int(10 ** rng.integers(2, 7))
        times = (late + np.cumsum(rng.integers(1, 2000, count))) / 1e3
        points = rng.uniform(-1, 1, (count, 2)) + np.array([5.0 * k, 0.0])
        velocities = rng.uniform(-1, 1, (count, 2))
        velocities[-1] = 0.0
        made = pc.Trajectory(times, points, velocities, joint_names=["x", "y"])
        files[name] = tmp_path / f"{name}.json"
        made.save(files[name])
        runs[name] = pc.Trajectory.load(files[name], checker.robot.parts[name].robot, controller)
    knots = runs["left"].curve.breaks
    near = float(knots[0] - runs["right"].curve.breaks[0] + rng.choice([0.0, 1e-12, 3e-10]))
    starts = {"right": near} if near > 0 else {"left": float(rng.uniform(0, 3))}
    found = pc.first_conflict(checker, runs, starts)
    assert found.free
    found.proof[0].save(tmp_path / "one.json")
    (read,) = load_proofs(tmp_path / "one.json")
    assert (read.motion, read.hashes) == (found.proof[0].motion, found.proof[0].hashes)
    assert read.verify()
    assert cell_proved(found.proof, files, starts, controller).fault is None
    late = {name: start + 1e-3 for name, start in starts.items()}
    spans = [runs[name].curve.breaks + starts.get(name, 0.0) for name in runs]
    both = max(span[0] for span in spans) < min(span[-1] for span in spans)  # else they move one after the other
    assert (cell_proved(found.proof, files, late, controller).fault is not None) == both
    assert cell_proved(found.proof[:-1], files, starts, controller).missing == (len(found.proof) - 1,)


def _passing(times, path="slerp", turn=0.3, ride=None):
    """A scene in which a post goes along and turns far from the gantries, or rides on a link."""
    poses = np.array([np.eye(4)] * len(times))
    for k, pose in enumerate(poses):
        pose[:3, 3], pose[:3, :3] = [20 + 0.1 * k, 0.2 * k, 0.0], pin.exp3(np.array([0.0, 0.0, turn * k]))
    scene = pc.Scene("passing")
    scene.add("post", pc.Box((0.2, 0.2, 1.0)), pc.Moving(times, poses, path, "stand") if ride is None else ride)
    return scene


@pytest.mark.parametrize("path", ["slerp", "screw"])
def test_a_scene_that_moves(folder, capsys, path):
    """The proofs' clocks cut the messages, and are those of the path; the files say which columns are the robots'."""
    _passing([0.0, 0.75, 2.0], path).save("scene.yaml")
    files = ["--robot", "cell.yaml", "--scene", "scene.yaml"]
    delayed = [*PATHS, "--delay", "right=0.7", "--controller", "jtc"]
    assert main(["validate", *files, *delayed, "--certify"]) == 0
    capsys.readouterr()
    assert main(["verify", "cell.proof.json", *files, *delayed]) == 0
    out = capsys.readouterr().out
    assert "robots: 'left' has columns 0 to 1, 'right' has columns 2 to 3" in out
    assert "motions proved, from 0 to 2.8 s of the scene's clock" in out
    assert "where 'post' is at the proof's times, with the scene" in out

    def refused(words, arguments=delayed, code=1):
        assert main(["verify", "cell.proof.json", *files, *arguments]) == code
        told = capsys.readouterr()
        assert words in (told.out if code == 1 else told.err)

    for other in (["right=0.71"], ["left=0.001", "right=0.7"]):
        refused("and cut elsewhere", [*PATHS, "--delay", *other, "--controller", "jtc"])
    refused("nothing else", [*delayed, "--start-time", "0"], code=2)
    refused("and cut elsewhere", [*PATHS[:2], "right=0.0,0.9", "--controller", "jtc"])
    refused("on the clock are not proved", ["--path", "left=right.yaml", "right=left.yaml", *delayed[3:]])
    assert main(["verify", "cell.proof.json", *delayed]) == 2
    assert "name --robot and --scene" in capsys.readouterr().err
    proofs, messages = load_proofs("cell.proof.json"), {"left": "left.yaml", "right": "right.yaml"}

    def fault(given):
        return cell_proved(given, messages, {"right": 0.7}, robot_columns=4).fault

    def timed(proof, *clock):
        return replace(proof, motion=replace(proof.motion, clock=clock))

    assert fault(proofs) is None
    for k in range(len(proofs)):
        words = "and cut elsewhere" if k in (0, len(proofs) - 1) else "on the clock are not proved"
        assert words in fault(proofs[:k] + proofs[k + 1 :])
    for late in (0.1, 1e-6):
        forged = [timed(proof, *(time + late for time in proof.motion.clock)) for proof in proofs]
        assert "and cut elsewhere" in fault(forged)
        assert "on the clock are not proved" in fault([proofs[0], forged[1], *proofs[2:]])
    assert "on the clock are not proved" in fault([*proofs[:2], timed(proofs[2]), *proofs[3:]])
    left = pc.Trajectory.load("left.yaml", folder[0].robot.parts["left"].robot)
    pc.Trajectory([0.1, 2.1], left.position([0.1, 2.1])[:, :1], joint_names=["x"]).save("left.yaml")
    refused("lacks y", code=2)


@pytest.mark.parametrize("seed", range(12))
def test_random_messages_in_a_scene_that_moves(tmp_path, seed):
    """Knots of what moves are near those of robots: it slides and turns, goes along a screw, or rides on a gantry."""
    rng = np.random.default_rng(seed)
    cell = gantries(tmp_path, ("left", "right")).robot
    runs, files = {}, {}
    for k, name in enumerate(("left", "right")):
        times = np.cumsum(rng.integers(1, 2000, int(rng.integers(2, 5)))) / 1e3
        points = rng.uniform(-1, 1, (len(times), 2)) + np.array([5.0 * k, 0.0])
        files[name], velocities = tmp_path / f"{name}.json", rng.uniform(-1, 1, points.shape)
        velocities[-1] = 0.0
        pc.Trajectory(times, points, velocities, joint_names=["x", "y"]).save(files[name])
        runs[name] = pc.Trajectory.load(files[name], cell.parts[name].robot)
    starts = {"right": float(rng.uniform(0, 2))}
    knots = np.concatenate([run.curve.breaks + starts.get(name, 0.0) for name, run in runs.items()])
    own = np.sort(rng.permutation(knots)[:3]) + rng.choice([-1, 0, 1], 3) * rng.choice([1e-12, 3e-10, 8e-10, 2e-9], 3)
    times = np.concatenate([[-1.0], own[np.diff(own, prepend=-1.0) > 0.05], [9.0]])
    scene = _passing(times, "screw" if seed % 3 == 1 else "slerp", turn=0.3 if seed % 3 == 1 else 1e-3)
    if seed % 3 == 2:
        way = pc.Trajectory(times + 1.0, rng.uniform(-1, 1, (len(times), 2)), controller="linear")
        robot = gantry_robot(tmp_path, HALF, (9.0, 9.0)), np.eye(4) + 20 * np.eye(4, k=3)
        scene = _passing(times, ride=pc.Moving.along(way, "tip", robot, -1.0, "stand"))
    checker = pc.Checker(cell, scene)
    found = pc.first_conflict(checker, runs, starts)
    assert found.free

    def fault(proofs, files=files, starts=starts):
        return cell_proved(proofs, files, starts, robot_columns=4).fault

    assert fault(found.proof) is None
    assert fault(found.proof, starts={"right": starts["right"] + 1e-6})
    assert all(fault(found.proof[:k] + found.proof[k + 1 :]) for k in range(len(found.proof)))
    breaks = runs["left"].curve.breaks
    pc.Trajectory(breaks, runs["left"].position(breaks), joint_names=["x", "y"]).save(tmp_path / "other.json")
    assert fault(found.proof, {**files, "left": tmp_path / "other.json"})
    begin = float(rng.choice([-0.7, 0.123456789, 1e3 / 3, 1.7e9 + 1 / 3 if seed % 3 else 0.0]))
    alone = pc.Checker(cell.parts["left"].robot, checker.scene)
    proofs = alone.certify_trajectory(runs["left"], start_time=begin)
    assert verify_trajectory(proofs, files["left"], start_time=begin, robot_columns=2)
    assert not verify_trajectory(proofs, files["left"], start_time=begin + 1e-6 + 1e-14 * begin, robot_columns=2)
    for columns in (1, 3):
        with pytest.raises(pc.PlannercheckError):
            verify_trajectory(proofs, files["left"], start_time=begin, robot_columns=columns)


def test_a_robot_that_stands_still_is_proved_while_it_does(tmp_path):
    """No speed says that the proofs are of other times: neither of an earlier begin, nor of a later end."""
    checker = pc.Checker(gantry_robot(tmp_path, HALF, (9.0, 9.0)), _passing([0.0, 9.0]))
    for end in (1.0, 0.5, 1.5):
        pc.Trajectory([0.0, end], np.zeros((2, 2)), joint_names=["x", "y"]).save(tmp_path / f"{end}.json")
    proofs = checker.certify_trajectory(pc.Trajectory([0.0, 1.0], np.zeros((2, 2))), start_time=0.5)
    for start, end in ((0.5, 1.0), (0.5, 0.5), (0.5, 1.5), (0.500001, 1.0), (0.0, 1.5), (0.0, 0.5)):
        found = verify_trajectory(proofs, tmp_path / f"{end}.json", start_time=start, robot_columns=2)
        assert bool(found) == ((start, end) == (0.5, 1.0))


def test_moved_knots_cost_tube(tmp_path):
    """Right begins 0.5 ns after a knot of left, so that both are one: its tube has to be as wide as it moves then."""
    checker = gantries(tmp_path, ("left", "right"))
    runs, files = {}, {}
    for k, name in enumerate(("left", "right")):
        made = pc.Trajectory([0, 1, 2], np.array([[0, k], [1, k], [3, k]]), joint_names=["x", "y"])
        files[name] = tmp_path / f"{name}.json"
        made.save(files[name])
        runs[name] = made
    starts = {"right": 1 + 5e-10}
    proofs = pc.first_conflict(checker, runs, starts).proof
    assert cell_proved(proofs, files, starts).fault is None
    thin = [replace(proof, motion=replace(proof.motion, tube=(1e-12,) * 4)) for proof in proofs]
    assert cell_proved(thin, files, starts).fault is not None


@pytest.mark.parametrize(
    ("words", "arguments"),
    [
        ("unknown robot of the cell 'lfet': did you mean 'left'", ["--path", "lfet=left.yaml", "right=right.yaml"]),
        ("no trajectory of right", ["--path", "left=left.yaml"]),
        ("takes one ROBOT=FILE for each robot", [*PATHS, "left.yaml"]),
        ("takes one ROBOT=FILE for each robot", [*PATHS, "left=right.yaml"]),
        ("--delay takes ROBOT=SECONDS", [*PATHS, "--delay", "right"]),
        ("must be a time of at least 0 s", [*PATHS, "--delay", "right=-1"]),
        ("--delay says twice when 'right' starts", [*PATHS, "--delay", "right=0", "right=1"]),
        ("--delay counts only with --path ROBOT=FILE", ["--path", "left.yaml", "--delay", "right=1"]),
        ("--straight counts only for one robot", [*PATHS, "--straight"]),
    ],
)
def test_bad_input(folder, capsys, words, arguments):
    assert main(["validate", "--robot", "cell.yaml", *arguments]) == 2
    assert words in capsys.readouterr().err


def test_bad_input_of_verify(folder, capsys):
    checker, path = folder
    found = pc.first_conflict(checker, {"left": [0.0, 0.0], "right": pc.Trajectory([0, 1], [[0.5, 0.5], [1, 1]])})
    found.proof[0].save(path / "proof.json")
    for words, arguments in (
        ("takes --controller, one --tube and --delay", PATHS),
        ("nothing says what right does", ["--path", "left=left.yaml", "--controller", "jtc"]),
        ("unknown robot of the proof 'up'", [*PATHS, "up=left.yaml", "--controller", "jtc"]),
        ("--delay counts only with --path ROBOT=FILE", ["--path", "left.yaml", "--delay", "right=1"]),
        ("--path is one file, or ROBOT=FILE", ["--path", "left.yaml", "right.yaml"]),
    ):
        assert main(["verify", "proof.json", *arguments]) == 2
        assert words in capsys.readouterr().err
