"""Proofs of trajectories, and whether they prove a message as a controller runs it, to the last bit of its doubles."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from proof_cases import random_tree, scattered

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.common.errors import PlannercheckError
from plannercheck.proofs import load_proofs, save_proofs, verify_path, verify_trajectory
from plannercheck.proofs.executed_curves import trajectory_proved

NAMES = [f"panda_joint{k}" for k in range(1, 8)]
TUBE = 0.002


@pytest.fixture(scope="module")
def checker():
    return pc.Checker(pc.Robot.load("panda"), pc.Scene("empty"))


def message(times, positions, velocities=None, accelerations=None, names=NAMES):
    """A JointTrajectory as plain data."""
    points = []
    for k, time in enumerate(times):
        whole = int(np.floor(time))
        point = {
            "positions": list(map(float, positions[k])),
            "time_from_start": {"sec": whole, "nanosec": round((time - whole) * 1e9)},
        }
        for key, rows in (("velocities", velocities), ("accelerations", accelerations)):
            if rows is not None and not np.isnan(rows[k]).any():
                point[key] = list(map(float, rows[k]))
        points.append(point)
    return {"joint_names": list(names), "points": points}


def written(path, document):
    path.write_text(json.dumps(document))
    return path


@pytest.fixture(scope="module")
def rows():
    """Times, positions, velocities and accelerations of a short trajectory: a quintic, a cubic and a linear piece."""
    generator = np.random.default_rng(3)
    start = np.array([0.1, -0.7, 0.2, -2.1, 0.1, 1.6, 0.7])
    positions = start + np.cumsum(generator.uniform(-0.1, 0.1, (4, 7)), axis=0)
    velocities, accelerations = generator.uniform(-0.2, 0.2, (2, 4, 7))
    accelerations[2:], velocities[3] = np.nan, np.nan
    return np.array([0.3, 0.75, 1.9, 2.6]), positions, velocities, accelerations


@pytest.fixture(scope="module")
def proofs(checker, rows):
    found = checker.certify_trajectory(pc.Trajectory(*rows), TUBE)
    assert [proof.verify().fault for proof in found] == [None] * 3
    return found


@pytest.fixture
def traj(rows, tmp_path):
    return written(tmp_path / "traj.json", message(*rows))


def test_a_trajectory_is_proved_as_it_is_run(proofs, traj, tmp_path, capsys):
    assert [len(proof.motion.control) for proof in proofs] == [6, 4, 2]
    for tube in (0.0, 0.001, TUBE):
        assert verify_trajectory(proofs, traj, "jtc", tube)
    save_proofs(proofs, tmp_path / "x.json")
    arguments = ["verify", str(tmp_path / "x.json"), "--robot", "panda", "--path", str(traj), "--controller", "jtc"]
    assert main([*arguments, "--tube", str(TUBE)]) == 0
    told = capsys.readouterr().out
    for words in (
        "polynomial of degree 5 from (",
        "within",
        "of it in each number",
        "all 3 motions proved",
        "confirmed",
    ):
        assert words in told
    assert main([*arguments, "--format", "json"]) == 0
    (result,) = json.loads(capsys.readouterr().out)
    assert [motion["degree"] for motion in result["motions"]] == [5, 3, 1]
    assert result["motions"][0]["inner"] == list(proofs[0].motion.inner)
    assert min(result["motions"][0]["tube"]) >= TUBE
    assert main([*arguments, "--tube", str(2 * TUBE)]) == 1
    assert "within 0.004 rad and m" in capsys.readouterr().out
    assert main([*arguments, "--straight"]) == 2
    assert main(["verify", str(tmp_path / "x.json"), "--tube", "0.1"]) == 2


def test_without_a_controller_curves_prove_no_path(proofs, rows, traj, tmp_path, capsys):
    save_proofs(proofs, tmp_path / "x.json")
    assert main(["verify", str(tmp_path / "x.json"), "--path", str(traj)]) == 2
    assert "--controller" in capsys.readouterr().err
    found = verify_path(proofs, rows[1])  # the last piece is straight
    assert found.fault.startswith("motions 0, 1 of the path's 3 are not proved")


@pytest.mark.parametrize("field", ["positions", "velocities", "accelerations"])
def test_every_number_of_a_message_counts(proofs, rows, tmp_path, field):
    generator = np.random.default_rng(5)
    for _ in range(6):
        document = message(*rows)
        k, column = int(generator.integers(3 if field == "velocities" else 2)), int(generator.integers(7))
        document["points"][k][field][column] += 0.01
        found = trajectory_proved(proofs, written(tmp_path / "t.json", document), "jtc", TUBE)
        assert min(found.missing) <= k <= max(found.missing) + 1
        # Smaller tubes are proved of messages that are off by the rest.
        document["points"][k][field][column] -= 0.01 - 1e-4
        close = trajectory_proved(proofs, written(tmp_path / "t.json", document), "jtc", TUBE / 2)
        assert not close.missing


def test_times_count(proofs, rows, tmp_path):
    document = message(*rows)
    document["points"][1]["time_from_start"]["nanosec"] += 100_000_000
    assert trajectory_proved(proofs, written(tmp_path / "t.json", document), "jtc", TUBE).missing == (0, 1)


def test_times_are_whole_nanoseconds(tmp_path):
    # Late in a long trajectory the difference of two doubles is off by far more than the rounding of control points.
    checker = pc.Checker(pc.Robot.load("panda"), pc.Scene("empty"))
    q = np.array([0.1, -0.7, 0.2, -2.1, 0.1, 1.6, 0.7])
    times = np.array([123456.7, 123456.7 + 0.1])
    rows = [q, q + 0.01], [0.2 * np.ones(7), np.zeros(7)]
    path = written(tmp_path / "t.json", message(times, *rows))
    trajectory = pc.Trajectory.load(path, checker.robot)
    found = checker.certify_trajectory(trajectory)
    assert verify_trajectory(found, path), verify_trajectory(found, path).fault


def test_times_beyond_104_days_are_doubles(tmp_path):
    checker, path = pc.Checker(pc.Robot.load("panda"), pc.Scene("empty")), tmp_path / "t.npz"
    q = np.array([0.1, -0.7, 0.2, -2.1, 0.1, 1.6, 0.7])
    rows = {"positions": [q, q + 0.01], "velocities": [0.2 * np.ones(7), np.zeros(7)]}
    np.savez(path, times=[1.7e9, 1.7e9 + 1 / 3], **rows)
    assert verify_trajectory(checker.certify_trajectory(pc.Trajectory.load(path, checker.robot)), path)


def test_motoros2_cuts_times_to_whole_ms(tmp_path):
    checker = pc.Checker(pc.Robot.load("panda"), pc.Scene("empty"))
    q = np.array([0.1, -0.7, 0.2, -2.1, 0.1, 1.6, 0.7])
    rows = [q, q + 0.01], [0.2 * np.ones(7), np.zeros(7)]
    path = written(tmp_path / "t.json", message([0.5, 0.6009], *rows))
    cut, whole = (
        checker.certify_trajectory(pc.Trajectory.load(path, checker.robot, controller))
        for controller in ("motoros2", "jtc")
    )
    for controller, of_it, of_other in (("motoros2", cut, whole), ("jtc", whole, cut)):
        assert verify_trajectory(of_it, path, controller)
        assert not verify_trajectory(of_other, path, controller)
    written(path, message([0.5, 0.5009], *rows))
    with pytest.raises(PlannercheckError, match="the same ms"):
        verify_trajectory(cut, path, "motoros2")


def test_another_controller_runs_another_curve(proofs, traj):
    assert trajectory_proved(proofs, traj, "motoros2", TUBE).missing == (0,)  # which leaves accelerations out
    assert trajectory_proved(proofs, traj, "linear", TUBE).missing == (0, 1)
    with pytest.raises(PlannercheckError, match="jtc"):
        trajectory_proved(proofs, traj, "jct")


def test_pieces_are_compared_in_their_order_and_none_is_left_out(proofs, traj):
    for kept in ([1, 0, 2], [0, 1], [0, 1, 2, 2], [1, 2], [2, 1, 0]):
        assert trajectory_proved([proofs[k] for k in kept], traj, "jtc", TUBE).fault


@pytest.mark.parametrize(
    "forge",
    [
        lambda m: replace(m, inner=(m.inner[0] + 0.01, *m.inner[1:])),
        lambda m: replace(m, inner=()),
        lambda m: replace(m, inner=m.inner[:14]),
        lambda m: replace(m, tube=()),
        lambda m: replace(m, tube=(*m.tube[:6], TUBE)),
        lambda m: replace(m, start=m.end, end=m.start, asked_end=m.start),
        lambda m: replace(m, inner=tuple(reversed(m.inner))),
    ],
)
def test_a_proof_of_another_curve_does_not_count(proofs, traj, forge):
    forged = [replace(proofs[0], motion=forge(proofs[0].motion)), *proofs[1:]]
    assert trajectory_proved(forged, traj, "jtc", TUBE).missing == (0,)
    assert trajectory_proved(proofs, traj, "jtc", TUBE)


def test_a_curve_may_be_given_by_a_higher_degree(proofs, traj):
    cubic = proofs[1].motion
    rows = np.array([[Fraction(x) for x in row] for row in cubic.control])
    inner = [(k * rows[k - 1] + (4 - k) * rows[k]) / 4 for k in range(1, 4)]
    raised = replace(cubic, inner=tuple(float(x) for row in inner for x in row))
    changed = [proofs[0], replace(proofs[1], motion=raised), proofs[2]]
    assert changed[1].verify()
    assert trajectory_proved(changed, traj, "jtc", TUBE * (1 - 1e-9))


def test_messages_that_no_controller_runs_are_errors(proofs, rows, tmp_path):
    times, positions, _, accelerations = rows
    alone = written(tmp_path / "a.json", message(times, positions, None, np.nan_to_num(accelerations)))
    with pytest.raises(PlannercheckError, match="accelerations without velocities"):
        trajectory_proved(proofs, alone)
    with pytest.raises(PlannercheckError, match="one point"):
        trajectory_proved(proofs, written(tmp_path / "b.json", message(times[:1], positions[:1])))
    with pytest.raises(PlannercheckError, match="'x'"):
        trajectory_proved(proofs, written(tmp_path / "c.json", message(*rows, names=["x", *NAMES[1:]])))
    with pytest.raises(PlannercheckError, match="tube"):
        trajectory_proved(proofs, alone, "jtc", -1.0)


def test_a_refused_trajectory_has_no_proof(checker, rows):
    assert checker.certify_trajectory(pc.Trajectory(*rows), 8.0) is None


@pytest.mark.parametrize("seed", range(10))
def test_proofs_of_free_trajectories_are_confirmed(seed, tmp_path):
    # Wherever the certifier proves a curve with its tube, bases that float and joints that follow others included.
    generator = np.random.default_rng(seed)
    kinds = ("revolute", "continuous", "prismatic") if seed % 2 else ("revolute", "prismatic", "planar", "floating")
    robot = pc.Robot.from_urdf(random_tree(generator, tmp_path, 5, kinds), floating=bool(seed % 3 == 0))
    checker = pc.Checker(robot, scattered(generator, 3))
    units = robot.configuration_map.units
    confirmed = 0
    for _ in range(60):
        q = robot.random_configurations(1, generator)[0]
        degree, tube = int(generator.integers(1, 6)), generator.uniform(0, 0.02, robot.nq)
        points = q + generator.uniform(-0.3, 0.3, (1, degree + 1, robot.nq))
        for first, past in units:
            tube[first:past] = 0.0
            points[0, :, first:past] = q[first:past] + generator.uniform(-0.1, 0.1, (degree + 1, past - first))
            points[0, :, first:past] /= np.linalg.norm(points[0, :, first:past], axis=1, keepdims=True)
        found = checker.certify_trajectory(pc.Trajectory.bezier([0.0, 1.0], points).of_robot(robot), tube)
        if found is not None:
            verified = found[0].verify()
            assert verified, verified.fault
            confirmed += 1
        if confirmed >= 4:
            break
    assert confirmed


def test_proofs_of_curves_are_kept_by_files(proofs, tmp_path):
    for name in ("x.json", "x.npz"):
        save_proofs(proofs, tmp_path / name)
        assert [proof.motion for proof in load_proofs(tmp_path / name)] == [proof.motion for proof in proofs]


def test_a_joint_that_turns_far_on_a_straight_piece_is_proved_literally(tmp_path):
    checker = pc.Checker(pc.Robot.load("kinova"), pc.Scene("empty"))
    start = checker.robot.random_configurations(200, np.random.default_rng(0))
    start = start[checker.check_states(start)]
    turning = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 5.0])  # the last joint turns without end, further than half a turn
    near = next(q for q in start if checker.check_trajectory(pc.Trajectory([0.0, 1.0], [q, q + turning])))
    (proof,) = checker.certify_trajectory(pc.Trajectory([0.0, 1.0], [near, near + turning]))
    assert len(proof.motion.control) == 3
    assert proof.verify(), proof.verify().fault
    traj = written(tmp_path / "t.json", message([0.0, 1.0], [near, near + turning], names=checker.robot.joint_names))
    assert trajectory_proved([proof], traj)


@pytest.mark.parametrize("shape", [pc.Sphere(0.1), pc.PointCloud(np.zeros((1, 3)), 0.1)])
def test_half_a_turn_of_a_base_has_no_proof_and_is_named(shape, tmp_path):
    scene = pc.Scene("far")
    scene.add("far", shape, np.vstack([np.eye(4)[:3] + np.array([0, 0, 0, 9.0]), [0, 0, 0, 1]]))
    robot = pc.Robot.from_urdf(random_tree(np.random.default_rng(0), tmp_path, 1), floating=True)
    checker = pc.Checker(robot, scene)
    start = np.array([0.0, 0, 0, 0, 0, 0, 1])
    for off, is_proved in ((0.0, False), (1e-13, False), (1e-9, True)):
        end = np.array([0.0, 0, 0, 0, 0, 1, off])
        trajectory = pc.Trajectory.bezier([0.0, 1.0], [[start, start, end]]).of_robot(robot)
        assert checker.check_trajectory(trajectory)
        if is_proved:
            assert checker.certify_trajectory(trajectory)[0].verify()
            continue
        for certify in (
            lambda moved=trajectory: checker.certify_trajectory(moved),
            lambda end=end: checker.certify_motions(start[None], end[None]),
        ):
            with pytest.raises(PlannercheckError, match=r"no proof of it was found, since .* half a turn"):
                certify()
