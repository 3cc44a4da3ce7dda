"""Trajectories of robots whose configurations hold unit vectors: positions by polynomials, turns by slerp."""

import numpy as np
import pinocchio as pin
import pytest

import plannercheck as pc

FREE = """<robot name="box"><link name="base"/><link name="body"><collision><geometry><box size="0.4 0.2 0.1"/>
</geometry></collision></link><joint name="base" type="floating"><parent link="base"/><child link="body"/></joint>
</robot>"""


@pytest.fixture(name="robot")
def _robot(tmp_path) -> pc.Robot:
    (tmp_path / "box.urdf").write_text(FREE)
    return pc.Robot.from_urdf(tmp_path / "box.urdf")


def quaternion(rng: np.random.Generator) -> np.ndarray:
    q = rng.normal(size=4)
    return q / np.linalg.norm(q)


def random_pieces(rng: np.random.Generator, degree: int = 3) -> np.ndarray:
    points = rng.uniform(-1, 1, (degree + 1, 7))
    points[:, 3:] = quaternion(rng)
    points[-1, 3:] = quaternion(rng)
    return points


def test_turns_are_pinocchios_slerp(robot):
    rng = np.random.default_rng(0)
    for _ in range(100):
        points = random_pieces(rng)
        t = pc.Trajectory.bezier([0.0, 2.0], points[None]).of_robot(robot)
        a, b = (pin.Quaternion(points[k, 3:]) for k in (0, -1))
        for s in (0.0, 0.3, 0.7, 1.0):
            turned = a.slerp(s, b).coeffs()
            found = t.position(2 * s)[3:]
            assert min(np.abs(found - turned).max(), np.abs(found + turned).max()) < 1e-12
            step = 1e-6
            if 0 < s < 1:
                rate = (t.position(2 * s + step) - t.position(2 * s - step)) / (2 * step)
                assert np.abs(rate - t.velocity(2 * s)).max() < 1e-7


def test_a_box_that_turns_and_swings_is_judged_as_its_samples(robot):
    scene = pc.Scene("post")
    scene.add_box("post", (0.1, 0.1, 3.0), np.eye(4))
    checker, rng, found = pc.Checker(robot, scene), np.random.default_rng(1), []
    for _ in range(200):
        t = pc.Trajectory.bezier([0.0, 1.0], random_pieces(rng, int(rng.integers(1, 6)))[None]).of_robot(robot)
        samples = checker.check_states(t.position(np.linspace(0, 1, 2000))).all()
        free = checker.check_trajectory(t)
        assert not free or samples
        verdict = checker.explain_trajectory(t)
        assert verdict.free == free
        assert verdict.collides_at is None or not checker.is_valid(t.position(verdict.collides_at))
        found.append((free, bool(samples)))
    assert 20 < sum(free for free, _ in found) < 180
    assert sum(samples and not free for free, samples in found) <= 1


def test_a_trajectory_that_is_of_no_robot_is_refused_with_the_remedy(robot):
    t = pc.Trajectory.bezier([0.0, 1.0], random_pieces(np.random.default_rng(2))[None])
    with pytest.raises(pc.PlannercheckError, match="of_robot"):
        pc.Checker(robot, pc.Scene("none")).check_trajectory(t)


def test_unit_vectors_are_checked(robot):
    points = random_pieces(np.random.default_rng(3))
    points[-1, 3:] *= 1.01
    with pytest.raises(pc.PlannercheckError, match="quaternion"):
        pc.Trajectory.bezier([0.0, 1.0], points[None]).of_robot(robot)


def test_a_tube_has_no_room_around_a_unit_vector(robot):
    t = pc.Trajectory.bezier([0.0, 1.0], random_pieces(np.random.default_rng(4))[None]).of_robot(robot)
    checker = pc.Checker(robot, pc.Scene("none"))
    with pytest.raises(pc.PlannercheckError, match="unit vector"):
        checker.check_trajectory(t, tube=0.1)
    assert checker.check_trajectory(t, tube=[0.1] * 3 + [0.0] * 4)


def test_velocities_of_a_quaternion_are_refused(robot):
    rows = np.zeros((2, 7))
    rows[:, 6] = 1.0
    speeds = np.zeros((2, 7))
    pc.Trajectory([0, 1], rows, speeds).of_robot(robot)
    speeds[0, 4] = 0.1
    with pytest.raises(pc.PlannercheckError, match="slerp"):
        pc.Trajectory([0, 1], rows, speeds).of_robot(robot)


def test_unit_vectors_of_pieces_meet_whatever_the_size_of_other_columns(robot):
    """A base far out: rounding of its positions is no excuse for a jump of its turn."""
    turns = [[0.0, 0.0, np.sin(angle / 2), np.cos(angle / 2)] for angle in (0.0, 1.0, 1.0 + 1e-6, 0.5)]
    rows = np.array([[5e3, 0.0, 0.0, *turn] for turn in turns])
    with pytest.raises(pc.PlannercheckError, match=r"columns 3 to 6.*meet"):
        pc.Trajectory.bezier([0.0, 1.0, 2.0], rows.reshape(2, 2, 7)).of_robot(robot)
    rows[2] = rows[1]
    pc.Trajectory.bezier([0.0, 1.0, 2.0], rows.reshape(2, 2, 7)).of_robot(robot)
