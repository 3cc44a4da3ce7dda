"""Motions at the last double between free and refused: whatever else was asked, the verdict is the same."""

import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import plannercheck as pc
from plannercheck import planar
from plannercheck.common.core import core
from plannercheck.robots.kinematics import joint_table

ARM = """
<robot name="arm"><link name="base"/>
  <link name="upper"><collision><origin xyz="1 0 0" rpy="0.3 0.2 0.1"/><geometry><box size="0.3 0.2 0.1"/></geometry>
  </collision></link>
  <link name="fore"><collision><origin xyz="0.3 0 0" rpy="0.1 0.7 0.4"/><geometry><cylinder radius="0.05" length="0.5"/>
  </geometry></collision></link>
  <joint name="first" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
    <limit lower="-4" upper="4" effort="1" velocity="1"/></joint>
  <joint name="second" type="revolute"><parent link="upper"/><child link="fore"/><axis xyz="0 1 0"/>
    <origin xyz="1.2 0 0"/><limit lower="-4" upper="4" effort="1" velocity="1"/></joint>
</robot>"""


def last_refused(is_free, far):
    """The largest distance at which a motion is refused, and the next double, at which it is free; None if neither."""
    low, high = 0.0, far
    if is_free(low) or not is_free(high):
        return None
    while (middle := (low + high) / 2) not in (low, high):
        low, high = (low, middle) if is_free(middle) else (middle, high)
    return low, high


def other_motions(rng, q0, q1, near):
    """Six motions (6, nq), (6, nq): like this one, or any."""
    spread = 10.0 ** rng.integers(-9, -1) if near else 1.0
    return q0 + spread * rng.normal(size=(6, len(q0))), q1 + spread * rng.normal(size=(6, len(q1)))


def assert_the_same_whatever_was_asked(rng, checker_at, q0, q1, tolerance):
    """Whether there was a limit to look at."""
    ends = last_refused(lambda x: checker_at(x).check_motion(q0, q1, tolerance=tolerance), 6.0)
    for distance, free in zip(ends or (), (False, True), strict=False):
        for k in range(8):
            checker = checker_at(distance)
            a, b = other_motions(rng, q0, q1, near=k % 2 == 0)
            assert checker.check_motions([*a, q0], [*b, q1], tolerance=tolerance)[-1] == free
            assert checker.explain_motion(q0, q1, tolerance=tolerance, proofs=k > 5).free == free
    return ends is not None


@pytest.mark.parametrize("seed", range(3))
def test_at_the_limit_in_space(seed, tmp_path):
    rng = np.random.default_rng(seed)
    (tmp_path / "arm.urdf").write_text(ARM)
    robot = pc.Robot.from_urdf(tmp_path / "arm.urdf")
    looked_at = 0
    for _ in range(15):
        q0 = rng.uniform(-2, 2, 2)
        q1 = q0 + rng.uniform(-1, 1, 2)
        pose = np.eye(4)
        pose[:3, :3] = Rotation.random(random_state=rng).as_matrix()
        pose[:3, 3] = robot.link_poses((q0 + q1)[None] / 2)[0, rng.integers(1, 3), :3] @ [1, 0, 0, 1]
        size, away = rng.uniform(0.05, 0.4, 3), rng.normal(size=3)
        away /= np.linalg.norm(away)

        def checker_at(distance, pose=pose, size=size, away=away):
            scene, moved = pc.Scene("one"), pose.copy()
            moved[:3, 3] += distance * away
            scene.add_box("box", size, moved)
            return pc.Checker(robot, scene)

        tolerance = float(rng.choice([1e-4, 1e-2, 1e-1]))
        looked_at += assert_the_same_whatever_was_asked(rng, checker_at, q0, q1, tolerance)
    assert looked_at >= 4


@pytest.mark.parametrize("seed", range(3))
def test_at_the_limit_in_the_plane(seed):
    rng = np.random.default_rng(seed)
    robot = planar.Robot.load("truck_trailer")
    looked_at = 0
    for _ in range(12):
        q0 = np.array([0, 0, *rng.uniform(-0.5, 0.5, robot.nq - 2)])
        q1 = q0 + np.array([*rng.uniform(-2, 2, 2), *rng.uniform(-0.6, 0.6, robot.nq - 2)])
        outline = rng.uniform(0.1, 1.0) * np.column_stack([np.cos(range(0, 6, 2)), np.sin(range(0, 6, 2))])
        away = rng.normal(size=2)
        away *= 4 / np.linalg.norm(away)

        def checker_at(distance, outline=outline, away=away):
            scene = planar.Scene("one")
            scene.add_polygon("triangle", outline + distance * away)
            return planar.Checker(robot, scene)

        tolerance = float(rng.choice([1e-4, 1e-2, 1e-1]))
        looked_at += assert_the_same_whatever_was_asked(rng, checker_at, q0, q1, tolerance)
    assert looked_at >= 4


UNDER_A_BALL = """
<robot name="ball"><link name="base"/>
  <link name="table"><collision><origin xyz="0 0 -0.1"/><geometry><box size="0.2 0.2 0.2"/></geometry>
  </collision></link>
  <link name="ball"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="fixed" type="fixed"><parent link="base"/><child link="table"/></joint>
  <joint name="turn" type="revolute"><parent link="base"/><child link="ball"/><axis xyz="0 0 1"/>
    <origin xyz="0 0 0.10001"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>"""


def test_proofs_that_are_asked_for_do_not_change_the_verdict(tmp_path):
    """The pair can't meet within the limits, and is within the tolerance all the time."""
    (tmp_path / "ball.urdf").write_text(UNDER_A_BALL)
    checker = pc.Checker(pc.Robot.from_urdf(tmp_path / "ball.urdf"))
    assert checker.unreachable.all()
    assert checker.check_motion([-0.5], [0.5])
    verdict = checker.explain_motion([-0.5], [0.5], proofs=True)
    assert verdict.free
    covered = sorted((proof.start, proof.end) for proof in verdict.proofs)
    assert covered[0][0] == 0
    assert covered[-1][1] == 1
    assert all(a[1] == b[0] for a, b in itertools.pairwise(covered))
    assert verdict.proof.verify()


def test_planes_of_earlier_motions_change_no_verdict():
    """Motions that are close to each other, and far apart, one after the other: with and without hints."""
    rng = np.random.default_rng(7)
    robot, scene = pc.Robot.load("panda"), pc.Scene.load("bookshelf")
    hinted, plain = (pc.Checker(robot, scene, tuning=pc.Tuning(cached_plane=on)) for on in (True, False))
    starts = robot.random_configurations(60, 3)
    starts = np.repeat(starts[hinted.check_states(starts)][:12], 25, axis=0)
    ends = starts + 10.0 ** rng.uniform(-3, 0, (len(starts), 1)) * rng.normal(size=starts.shape)
    for tolerance in (1e-6, 1e-4, 2e-2):
        free = plain.check_motions(starts, ends, tolerance=tolerance)
        assert 0 < free.sum() < len(free)
        assert (hinted.check_motions(starts, ends, tolerance=tolerance) == free).all()
        assert [hinted.check_motion(a, b, tolerance=tolerance) for a, b in zip(starts, ends, strict=True)] == list(free)
    with_hints, without = (c.motion_certifier.statistics()["swept"] for c in (hinted, plain))
    assert with_hints < 2 * without  # twice as many motions


def test_hints_are_held_at_every_state(tmp_path):
    """Among tetrahedra, whose boxes are deepest elsewhere than they are: pairs near contact after near motions."""
    rng = np.random.default_rng(1)
    (tmp_path / "arm.urdf").write_text(ARM)
    robot, scene = pc.Robot.from_urdf(tmp_path / "arm.urdf"), pc.Scene("tetrahedra")
    for k in range(10):
        scene.add_hull(f"tetrahedron{k}", rng.normal(size=3) + rng.uniform(0.1, 0.5) * rng.normal(size=(4, 3)))
    hinted, plain = (pc.Checker(robot, scene, tuning=pc.Tuning(cached_plane=on)) for on in (True, False))
    starts = np.repeat(rng.uniform(-3, 3, (60, 2)), 30, axis=0)
    ends = starts + rng.uniform(-0.3, 0.3, starts.shape)
    free = plain.check_motions(starts, ends, tolerance=1e-6)
    assert 0.1 < free.mean() < 0.9
    assert (hinted.check_motions(starts, ends, tolerance=1e-6) == free).all()


def table_of(robot, group):
    """What the core makes kinematics from."""
    posed = robot.with_group(group)
    return joint_table(posed.model, posed.configuration_map, posed.frames)


def test_what_was_prepared_for_a_kinematics_does_not_serve_the_next_one_at_its_place(tmp_path):
    """Its links are posed by joints that move and joints that are held: others than those of the first."""
    (tmp_path / "arm.urdf").write_text(ARM)
    robot, scene = pc.Robot.from_urdf(tmp_path / "arm.urdf"), pc.Scene("one")
    scene.add_box("box", (0.3, 0.3, 0.3), np.array([[1, 0, 0, 1.1], [0, 1, 0, 1.0], [0, 0, 1, 0], [0, 0, 0, 1]]))
    ends = np.array([[0.0]]), np.array([[1.5]])

    def answer(certifier, kernel):
        motions = np.stack(ends, axis=1), np.empty((0, 0))
        return certifier.check(kernel, np.array([-9.0]), np.array([9.0]), 1e-12, *motions, 1e-4, 1).tolist()

    def certifier():
        return pc.Checker(
            robot.with_group(["second"]), scene, tuning=pc.Tuning(reach=False)
        ).motion_certifier._pairs_within_limits.core

    used, first, other = certifier(), core.Kinematics(*table_of(robot, ["second"])), table_of(robot, ["first"])
    by_second, place = answer(used, first), id(first)
    del first
    kernels = [core.Kinematics(*other)]  # nearly always at the same place; if not, then one of the next
    while id(kernels[-1]) != place and len(kernels) < 1000:
        kernels.append(core.Kinematics(*other))
    assert id(kernels[-1]) == place
    assert answer(used, kernels[-1]) == answer(certifier(), kernels[-1]) != by_second
