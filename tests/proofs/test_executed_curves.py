"""Proofs of trajectories, and whether they prove a message as a controller runs it, to the last bit of its doubles."""

import json
from dataclasses import replace
from fractions import Fraction
from time import process_time

import numpy as np
import pytest
from proof_cases import random_tree, scattered

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.common.errors import PlannercheckError
from plannercheck.proofs import load_proofs, save_proofs, verify_path, verify_trajectory
from plannercheck.proofs.data import Motion
from plannercheck.proofs.executed_messages import trajectory_proved
from plannercheck.trajectories import CONTROLLERS

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


CONTINUOUS = (2, 6)


def claimed(proof, trajectory, tube=0.0):
    """Proofs as they would be of a trajectory with a tube, whose entries nobody looks at here."""
    widths = tuple((np.broadcast_to(tube, 7) + trajectory.curve.error).tolist())
    rows = [[tuple(row) for row in piece.tolist()] for piece in trajectory.curve.pieces]
    motions = (
        Motion(points[0], points[-1], points[-1], "slerp", tuple(x for row in points[1:-1] for x in row), widths)
        for points in rows
    )
    model = replace(proof.model, whole_turns=CONTINUOUS)
    return [replace(proof, model=model, motion=motion) for motion in motions]


def random_message(generator, controller):
    """Times, positions, velocities and accelerations that a controller takes, and a start or none."""
    count = int(generator.integers(2, 9))
    times = np.cumsum(10.0 ** generator.uniform(-2, 0.5, count))
    times = np.round(times, int(generator.choice([2, 9])))
    times -= times[0] if generator.random() < 0.3 else 0.0
    positions = generator.uniform(-3, 3, (count, 7))
    velocities, accelerations = generator.uniform(-1, 1, (2, count, 7))
    velocities[-1] = 0.0
    start = positions[0] + 10.0 ** generator.uniform(-3, 1) * generator.uniform(-1, 1, 7)
    if times[0] == 0 or controller == "motoros2":
        start = positions[0].copy()
    kind = int(generator.integers(3))
    if controller == "motoros2" or kind:
        return times, positions, velocities, accelerations if kind == 2 else None, start
    return times, positions, None, None, start


@pytest.mark.parametrize("controller", CONTROLLERS)
@pytest.mark.parametrize("seed", range(25))
def test_what_any_controller_runs_from_any_start_is_recognised(proofs, controller, seed, tmp_path):
    """The curves that are judged, by their reader, against the verifier's own; forgeries of each part are refused."""
    generator = np.random.default_rng([seed, CONTROLLERS.index(controller)])
    *rows, start = random_message(generator, controller)
    traj = written(tmp_path / "traj.json", message(*rows))
    started = generator.random() < 0.7
    given = start if started else None
    trajectory = pc.Trajectory(*rows, controller, given, CONTINUOUS)
    tube = generator.uniform(0, 0.01, 7)
    made = claimed(proofs[0], trajectory, tube)
    exact = tube * (1 - 1e-12)
    assert not trajectory_proved(made, traj, controller, exact.tolist(), given).fault
    # Another tube, in one joint alone.
    joint = int(generator.integers(7))
    wider = exact.copy()
    wider[joint] += 1e-9 + 2 * trajectory.curve.error[joint]
    assert trajectory_proved(made, traj, controller, wider.tolist(), given).missing
    # Another start, or the start left out, or invented.
    if started and rows[0][0] > 0 and controller != "motoros2":
        elsewhere = start.copy()
        elsewhere[joint] += 1e-6
        assert trajectory_proved(made, traj, controller, tube.tolist(), elsewhere).fault
        assert trajectory_proved(made, traj, controller, tube.tolist()).fault
    elif started:
        with pytest.raises(PlannercheckError, match="does not begin at the start"):
            trajectory_proved(made, traj, controller, tube.tolist(), start + 1e-6)
    # Another controller, where it runs another curve.
    for other in CONTROLLERS:
        try:
            curve = pc.Trajectory(*rows, other, given, CONTINUOUS).curve
        except PlannercheckError:
            with pytest.raises(PlannercheckError):
                trajectory_proved(made, traj, other, tube.tolist(), given)
            continue
        spans = np.array([curve.breaks[[0, -1]], trajectory.curve.breaks[[0, -1]]])
        at = np.linspace(spans[:, 0].max(), spans[:, 1].min(), 7)
        if len(curve.pieces) == len(made) and np.abs(curve.at(at) - trajectory.position(at)).max() > 0.1:
            assert trajectory_proved(made, traj, other, tube.tolist(), given).missing


@pytest.mark.parametrize("turns", [-2, -1, 0, 1, 2])
def test_whole_turns_are_taken_off_joints_that_turn_without_end_alone(proofs, turns, tmp_path):
    q = np.array([0.1, -0.7, 0.2, -2.1, 0.1, 1.6, 0.7])
    traj = written(tmp_path / "traj.json", message([1.0, 2.0], [q, q + 0.1]))
    for column in (2, 3):
        start = q - 0.3
        start[column] += 2 * np.pi * turns
        for controller in ("jtc", "jtc-upsampled", "ur", "linear"):
            made = claimed(
                proofs[0], pc.Trajectory([1.0, 2.0], [q, q + 0.1], None, None, controller, start, CONTINUOUS)
            )
            assert not trajectory_proved(made, traj, controller, 0.0, start).fault
            wraps = controller.startswith("jtc") and column == 2
            assert wraps == (abs(made[0].motion.start[column] - (q - 0.3)[column]) < 1e-9) or turns == 0
            # The same curve does not count if the model says that the joint does not turn without end.
            other = [replace(proof, model=replace(proof.model, whole_turns=())) for proof in made]
            assert bool(trajectory_proved(other, traj, controller, 0.0, start)) == (not wraps or turns == 0)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_half_a_turn_to_the_first_point_goes_as_the_controller_goes(proofs, way, tmp_path):
    first, start = np.zeros(7), np.zeros(7)
    first[6] = way * np.pi
    rows = [1.0, 2.0], [first, first]
    traj = written(tmp_path / "traj.json", message(*rows))
    made = claimed(proofs[0], pc.Trajectory(*rows, None, None, "jtc", start, CONTINUOUS))
    assert not trajectory_proved(made, traj, "jtc", 0.0, start).fault
    assert abs(made[0].motion.start[6]) < 1e-9


def test_a_long_upsampled_message_is_compared_in_time(proofs, tmp_path):
    generator = np.random.default_rng(1)
    times, positions = np.cumsum(generator.uniform(0.01, 1.0, 600)).round(9), generator.uniform(-1, 1, (600, 7))
    traj = written(tmp_path / "traj.json", message(times, positions))
    made = claimed(proofs[0], pc.Trajectory(times, positions, None, None, "jtc-upsampled"))
    began = process_time()
    assert not trajectory_proved(made, traj, "jtc-upsampled").fault
    assert process_time() - began < 10


def test_points_with_accelerations_alone_are_not_upsampled(rows):
    times, positions, _, accelerations = rows
    with pytest.raises(PlannercheckError, match="accelerations without velocities"):
        pc.Trajectory(times, positions, None, np.nan_to_num(accelerations), "jtc-upsampled")


def test_the_command_takes_a_start_and_a_tube_a_joint(checker, rows, traj, tmp_path, capsys):
    start, tube = rows[1][0] + 0.01, "0.002,0.001,0.001,0.001,0.001,0.001,0.003"
    listed = ",".join(map(repr, start.tolist()))
    common = ["--robot", "panda", "--path", str(traj), "--controller", "ur"]
    messaged = message(rows[0], rows[1], np.nan_to_num(rows[2]))
    written(traj, messaged)
    proof = str(tmp_path / "x.json")
    judged = ["validate", *common, "--tube", tube, f"--start={listed}", "--certify", "--proof", proof]
    assert main(judged) == 0, capsys.readouterr()
    verify = ["verify", proof, *common]
    assert main([*verify, "--tube", tube, f"--start={listed}"]) == 0, capsys.readouterr().out
    assert "all 4 motions proved" in capsys.readouterr().out
    assert main([*verify, "--tube", tube.replace("0.002", "0.0021"), f"--start={listed}"]) == 1
    assert "within 0.001 to 0.003 rad and m" in capsys.readouterr().out
    assert main([*verify, "--tube", tube]) == 1
    assert main([*verify, f"--start={listed[:-1]}9"]) in (0, 1)
    assert main([*verify, "--start=0,0"]) == 2
    assert "start must be 7 finite numbers" in capsys.readouterr().err
    assert main([*verify, "--tube", "0.1,0.2"]) == 2
    assert main([*verify, "--tube=-1"]) == 2
    assert main(["verify", proof, "--path", str(traj), f"--start={listed}"]) == 2
    assert "--start counts only with --controller" in capsys.readouterr().err


def test_another_controller_runs_another_curve(proofs, rows, traj, tmp_path):
    with pytest.raises(PlannercheckError, match="point 3 has no velocities for motoros2"):
        trajectory_proved(proofs, traj, "motoros2", TUBE)
    times, positions, velocities, accelerations = rows
    moving = written(tmp_path / "moving.json", message(times, positions, np.nan_to_num(velocities), accelerations))
    assert trajectory_proved(proofs, moving, "motoros2", TUBE).missing == (0, 2)  # which leaves accelerations out
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
