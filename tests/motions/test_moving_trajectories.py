"""Trajectories in scenes that move: dense samples of exact verdicts, contacts at a chosen instant, proofs."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from support.moving_scenes import MovingCase, arm_urdf, contact_case, random_pose

import plannercheck as pc
from plannercheck.proofs import load_proofs, save_proofs
from plannercheck.proofs.verify import model_confirmed

# Trajectories that keep further than this from everything at dense samples may not be refused, m.
_CLEAR = 3e-4


@pytest.mark.parametrize("seed", range(40))
def test_trajectories_past_moving_boxes(tmp_path: Path, seed: int) -> None:
    """None that touches at a sample is called free; none that stays clear of all is refused."""
    case = contact_case(np.random.default_rng([7, seed]), tmp_path)
    free = case.checker.check_trajectory(case.trajectory, start_time=case.start_time)
    q, times = case.sampled(400)
    valid = case.checker.check_states(q, times=times)
    assert not free or valid.all()
    if not free and valid.all():
        q, times = case.sampled(4000)
        assert case.checker.clearances(q, times=times).min() <= _CLEAR
    if not free and not valid.all():
        verdict = case.checker.explain_trajectory(case.trajectory, start_time=case.start_time)
        first = times[np.argmin(valid)]
        assert verdict.collides_at is not None
        assert verdict.free_until <= verdict.collides_at <= first + 1e-9
        assert f"s of the scene's clock: {' – '.join(verdict.pair.names)}" in repr(verdict)


def _crossing(start: float = 0.0, clock: float = 0.0) -> MovingCase:
    """Panda at rest, and a box that goes through where its hand is between 3.5 and 4.5 s, from a clock's time on."""
    robot, scene = pc.Robot.load("panda"), pc.Scene("belt")
    hand = robot.link_poses(robot.reference)[robot.link_index("panda_hand")]
    ends = np.array([np.eye(4)] * 2)
    ends[:, :3, 3] = hand[:3, 3] + np.array([[0, -2, 0], [0, 2, 0]])
    scene.add("pallet", pc.Box((0.1, 0.1, 0.1)), pc.Moving([clock, clock + 8.0], ends))
    still = np.stack([robot.reference] * 2)
    return MovingCase(pc.Checker(robot, scene), pc.Trajectory([0.0, 2.0], still, controller="linear"), start)


@pytest.mark.parametrize("clock", [0.0, 2.0**23, 1.7e9])
def test_a_clock_may_be_late(clock: float) -> None:
    """Beyond 97 days a nanosecond is less than a rounding."""
    checker, trajectory, _ = _crossing(clock=clock)
    free = [checker.check_trajectory(trajectory, start_time=clock + start) for start in (0.0, 1.0, 2.5, 5.5)]
    assert free == [True, True, False, True]
    proofs = checker.certify_trajectory(trajectory, start_time=clock + 1.0)
    assert proofs is not None
    assert all(proof.verify() for proof in proofs)


def test_start_time_is_the_scenes_clock_at_the_beginning() -> None:
    """The same trajectory is free before the box comes and after it has gone."""
    checker, trajectory, _ = _crossing()
    starts = [0.0, 1.0, 2.5, 3.5, 5.5, 6.0]
    free = checker.check_trajectories([trajectory] * 6, start_time=starts)
    assert free.tolist() == [True, True, False, False, True, True]
    assert [checker.check_trajectory(trajectory, start_time=start) for start in starts] == free.tolist()
    later = pc.Trajectory([0.0, 2.0], trajectory.position([0, 2]), controller="linear", start=trajectory.position(0))
    assert checker.check_trajectory(later)
    assert not checker.check_trajectories([later], start_time=3.5)[0]
    verdict = checker.explain_trajectory(trajectory, start_time=[2.5])
    assert 3.2 < verdict.collides_at < 4.0
    assert verdict.pair.names[1] == "pallet"
    assert not checker.is_valid(trajectory.position(0), time=verdict.collides_at)
    assert len(verdict.tube) == 7
    for wrong in (np.nan, "soon", [0.0, 1.0]):
        with pytest.raises(pc.PlannercheckError, match="start_time"):
            checker.check_trajectories([trajectory] * 3, start_time=wrong)
    for start in (-0.5, 6.5):
        with pytest.raises(pc.PlannercheckError, match="'pallet' moves from 0 to 8 s"):
            checker.check_trajectory(trajectory, start_time=start)
    assert checker.check_trajectories((each for each in [trajectory] * 6), start_time=starts).tolist() == free.tolist()
    with pytest.raises(pc.PlannercheckError, match="check_trajectory takes one"):
        checker.check_trajectories(trajectory)
    with pytest.raises(pc.PlannercheckError, match=r"must be some pc\.Trajectory, not int"):
        checker.check_trajectories(3)
    with pytest.raises(pc.PlannercheckError, match=r"must be a pc\.Trajectory, not ndarray"):
        checker.check_trajectory(trajectory.position([0, 1]))
    with pytest.raises(pc.PlannercheckError, match="3 columns"):
        checker.check_trajectory(pc.Trajectory([0, 1], np.zeros((2, 3)), controller="linear"))


def test_a_tube_is_around_the_robots_numbers_alone() -> None:
    """A wide tube meets the box earlier; a row has as many numbers as the robot."""
    checker, trajectory, _ = _crossing()
    assert checker.check_trajectory(trajectory, tube=0.01, start_time=1.0)
    assert not checker.check_trajectory(trajectory, tube=0.5, start_time=1.0)
    assert checker.check_trajectory(trajectory, tube=[0.01] * 7, start_time=1.0)
    with pytest.raises(pc.PlannercheckError, match="row of 7"):
        checker.check_trajectory(trajectory, tube=[0.01] * 14, start_time=1.0)
    wide = checker.explain_trajectory(trajectory, start_time=1.0).largest_tube
    assert checker.check_trajectory(trajectory, tube=0.98 * wide, start_time=1.0)
    assert not checker.check_trajectory(trajectory, tube=1.1 * wide, start_time=1.0)
    verdict = checker.explain_trajectory(trajectory, start_time=1.0)
    assert verdict.free
    assert 0 < verdict.largest_tube < 0.5
    assert 1.0 <= verdict.clearance_at <= 3.0


def test_a_scene_at_rest_takes_no_notice_of_a_clock() -> None:
    """Times and start times change nothing."""
    robot = pc.Robot.load("panda")
    checker = pc.Checker(robot, pc.Scene.load("bookshelf"))
    q = robot.random_configurations(50, 0)
    assert np.array_equal(checker.check_states(q), checker.check_states(q, times=3.0))
    trajectory = pc.Trajectory([0.0, 2.0], q[:2], controller="linear")
    assert checker.check_trajectory(trajectory) == checker.check_trajectory(trajectory, start_time=9.0)


@pytest.mark.parametrize("path", ["slerp", "screw"])
def test_proofs_say_when_and_the_scene_is_compared_there(tmp_path: Path, path: str) -> None:
    """Of other times, other objects' motions, or no time: refused; also of one that stands."""
    pytest.importorskip("flint")
    rng = np.random.default_rng(3)
    poses = np.array([random_pose(rng, np.array([1.8 + 0.1 * k, 0.2 * k, 0.5])) for k in range(4)])
    robot = str(tmp_path / "arm.urdf")
    Path(robot).write_text(arm_urdf(rng, 2))
    scenes = {"as it is": poses, "other": poses.copy(), "turned": poses.copy()}
    scenes["other"][2, 0, 3] += 1e-6
    scenes["turned"][2, :3, :3] @= pin.exp3(np.array([0, 0, 1e-6]))
    for name, each in scenes.items():
        scene = pc.Scene("belt")
        scene.add("pallet", pc.Box((0.1, 0.2, 0.1)), pc.Moving([0, 1, 2.5, 4], each, path=path, outside="stand"))
        scene.save(tmp_path / f"{name}.yaml")
    files = {name: str(tmp_path / f"{name}.yaml") for name in scenes}
    checker = pc.Checker(pc.Robot.load(robot), pc.Scene.load(files["as it is"]))
    home = checker.robot.reference
    trajectory = pc.Trajectory([0, 2, 4.5], [home, home + 0.05, home], np.zeros((3, 2)))
    for start in (0.123456789, -1.0):
        proofs = checker.certify_trajectory(trajectory, tube=1e-3, start_time=start)
        assert proofs is not None
        assert proofs[0].motion.clock[0] == start
        first, *others = proofs
        found = model_confirmed(first, robot, files["as it is"], others=others)
        assert "where 'pallet' is at the proof's times" in found.compared[-1]
        for name in ("other", "turned"):
            fault = model_confirmed(first, robot, files[name], others=others).fault
            assert "'pallet' is not" in fault or "on other joints" in fault
        for clock, fault in (
            ((), "no clock"),
            (tuple(time + 1e-3 for time in others[0].motion.clock), "'pallet'"),
            (others[1].motion.clock, "'pallet' is not where"),
            (tuple(time + 0.5 for time in others[0].motion.clock), "does not go straight"),
            ((3.0, 2.0), "clock is"),
        ):
            moved = replace(others[0], motion=replace(others[0].motion, clock=clock))
            assert fault in model_confirmed(first, robot, files["as it is"], others=[moved]).fault
        save_proofs(proofs, tmp_path / "x.json")
        assert [proof.motion for proof in load_proofs(tmp_path / "x.json")] == [proof.motion for proof in proofs]
        assert all(proof.verify() for proof in proofs)


def test_sums_of_times_are_rounded(tmp_path: Path) -> None:
    """0.1 + 0.2 is not 0.3, where an object's motion ends: it stands there, also in proofs, for a picosecond."""
    pytest.importorskip("flint")
    rng = np.random.default_rng(3)
    robot, file = str(tmp_path / "arm.urdf"), str(tmp_path / "belt.yaml")
    Path(robot).write_text(arm_urdf(rng, 2))
    scene = pc.Scene("belt")
    poses = [random_pose(rng, np.array([2.0, y, 0.5])) for y in (0.0, 0.5)]
    scene.add("pallet", pc.Box((0.1, 0.2, 0.1)), pc.Moving([0.0, 0.3], poses))
    scene.save(file)
    checker = pc.Checker(pc.Robot.load(robot), scene)
    home = checker.robot.reference
    assert 0.1 + 0.2 > 0.3
    for begin, end in ((0.0, 0.1 + 0.2), (0.0, 0.3 + 9e-13), (-9e-13, 0.3)):
        trajectory = pc.Trajectory([0.0, end - begin], [home, home + 0.01], controller="linear", start=home)
        assert checker.check_trajectory(trajectory, start_time=begin)
        (proof,) = checker.certify_trajectory(trajectory, start_time=begin)
        found = model_confirmed(proof, robot, file)
        assert not found.fault
        assert "where 'pallet' is at the proof's times" in found.compared[-1]
        assert proof.verify()
        np.testing.assert_array_equal(
            checker.body_poses(home, times=[begin, end]), checker.body_poses(home, times=[0.0, min(end, 0.3)])
        )
    home_and_back = np.array([home, home + 0.01, home])
    scene.remove("pallet")
    scene.add("pallet", pc.Box((0.1, 0.2, 0.1)), pc.Moving([0.0, 0.1, 0.3], [poses[0], poses[0], poses[1]]))
    scene.save(file)
    near = pc.Trajectory([0.0, 0.1 - 9e-13, 0.3], home_and_back, controller="linear", start=home)
    first, *others = pc.Checker(pc.Robot.load(robot), scene).certify_trajectory(near)
    assert not model_confirmed(first, robot, file, others=others).fault
    for begin, end in ((0.0, 0.3 + 1.1e-12), (-1.1e-12, 0.2)):
        with pytest.raises(pc.PlannercheckError, match=r"'pallet' moves from 0 to 0\.3 s"):
            checker.body_poses(home, times=[begin, end])


def test_proofs_hold_and_name_the_columns_of_what_moves() -> None:
    """One a piece; the box's columns are the robot's and seven more."""
    pytest.importorskip("flint")
    checker, trajectory, _ = _crossing()
    assert checker.certify_trajectory(trajectory, start_time=3.0) is None
    proofs = checker.certify_trajectory(trajectory, tube=1e-3, start_time=0.5)
    assert proofs is not None
    assert all(proof.verify() for proof in proofs)
    assert proofs[0].model.columns == 14
    assert "pallet" in {joint.name for joint in proofs[0].model.joints}
    assert checker.explain_trajectory(trajectory, start_time=0.5).proof is not None
