"""Motions that are proved free: verdicts against clearances in closed form, and what is told of a motion."""

import numpy as np
import pinocchio as pin
import pytest
from certified_motions import certified_ends, dense_states

import plannercheck as pc

ARM = """<robot name="arm"><link name="base"/>{links}</robot>"""
LINK = """<link name="l{k}"><collision><origin xyz="{x} 0 0"/><geometry>{shape}</geometry></collision></link>
<joint name="j{k}" type="{kind}"><parent link="{parent}"/><child link="l{k}"/><origin xyz="{offset} 0 0"/>
<axis xyz="{axis}"/><limit lower="-6" upper="6" effort="1" velocity="1"/></joint>"""

AXES = ("0 0 1", "0 1 0", "1 0 0", "0 0.6 0.8", "0 0 -1")


def sphere_arm(tmp_path, kinds, shape='<sphere radius="0.02"/>'):
    """A chain of joints 0.3 m apart, each link with a small ball at its end."""
    links = [
        LINK.format(
            k=k,
            x=0.3,
            shape=shape,
            kind=kind,
            parent="base" if k == 0 else f"l{k - 1}",
            offset=0.3 if k else 0,
            axis=AXES[k % len(AXES)],
        )
        for k, kind in enumerate(kinds)
    ]
    path = tmp_path / "arm.urdf"
    path.write_text(ARM.format(links="".join(links)))
    joints = [f"j{k}" for k in range(len(kinds))]
    return pc.Robot.from_urdf(path, group=joints)


def closed_form_clearance(checker, q0, q1, steps):
    """Least distance of the balls from boxes and of each other along a motion, in closed form at sampled states."""
    states = dense_states(checker, q0, q1, steps)
    poses = checker.body_poses(states)
    least = np.inf
    for a, b in checker.pairs.tolist():
        first, second = checker.bodies[a], checker.bodies[b]
        centre = poses[:, a, :3, 3]
        if second.link is None:
            seen = (centre - second.pose[:3, 3]) @ second.pose[:3, :3]
            beyond = np.maximum(np.abs(seen) - np.array(second.shape.size) / 2, 0)
            distance = np.linalg.norm(beyond, axis=1) - first.shape.radius
        else:
            distance = np.linalg.norm(centre - poses[:, b, :3, 3], axis=1) - first.shape.radius - second.shape.radius
        least = min(least, float(distance.min()))
    return least


@pytest.mark.parametrize("kinds", [["revolute"] * 4, ["revolute", "prismatic", "revolute"], ["continuous"] * 3])
def test_clearances_decide(tmp_path, kinds):
    """In closed form: never accepted if it touches, always if the clearance is above the tolerance."""
    robot = sphere_arm(tmp_path, kinds)
    generator = np.random.default_rng(len(kinds))
    accepted = refused = close = 0
    for _ in range(8):
        q0 = generator.uniform(-2, 2, robot.nq)
        q1 = q0 + generator.normal(size=robot.nq)
        at = (1 - (part := generator.uniform(0.2, 0.8))) * q0 + part * q1
        scene = pc.Scene()
        last = robot.link_index(f"l{robot.nq - 1}")
        before, centre, after = ((1 - t) * q0 + t * q1 for t in (part - 1e-4, part, part + 1e-4))
        before, centre, after = (robot.link_poses(q)[last] @ [0.3, 0, 0, 1] for q in (before, centre, after))
        # A wall that the last ball passes sideways, in the direction from which its way bends.
        way, bend = (after - before)[:3], -(after + before - 2 * centre)[:3]
        normal = np.linalg.qr(np.column_stack([way, bend + 0.3 * np.linalg.norm(bend) * generator.normal(size=3)]))[0]
        normal = normal[:, 1] * np.sign(normal[:, 1] @ bend)
        thickness = 10.0 ** generator.uniform(-4, -2)
        offset = 0.02 + thickness / 2 + generator.choice([-1, 1, 1]) * 10.0 ** generator.uniform(-5, -2)
        pose = np.eye(4)
        pose[:3, :3] = np.linalg.qr(np.column_stack([normal, generator.normal(size=(3, 2))]))[0]
        pose[:3, 2] = np.cross(pose[:3, 0], pose[:3, 1])
        pose[:3, 3] = centre[:3] + offset * normal
        scene.add_box("wall", [thickness, 0.03, 0.03], pose)
        checker = pc.Checker(robot, scene, self_collision=False)
        for a, b in ((q0, q1), (at, q1), (q0 + 1e-3, q1 + 1e-3), (q0 - 1e-2, q1), (at, at + 1e-3)):
            (start,), (end,) = certified_ends(checker, a, b)
            steps = 2000
            clearance = closed_form_clearance(checker, start, end, steps)
            free = checker.check_motion(a, b)
            assert checker.explain_motion(a, b).free == free
            accepted, refused = accepted + free, refused + (not free)
            close += abs(clearance) < 2e-3
            if clearance <= 0:
                assert not free
            # What sampling misses: half a step at the tip's speed.
            elif clearance > 1e-4 + np.abs(end - start).sum() * 1.5 / steps / 2:
                assert free
    assert min(accepted, refused, close) >= 4


NEEDLE = '<box size="0.6 0.0002 0.0002"/>'


def test_needles_and_thin_walls(tmp_path):
    robot = sphere_arm(tmp_path, ["revolute"] * 3, NEEDLE)
    generator = np.random.default_rng(3)
    missed = 0
    for _ in range(8):
        q0 = generator.uniform(-2, 2, 3)
        q1 = q0 + generator.normal(size=3)
        at = (q0 + q1) / 2
        tip = robot.link_poses(at)[robot.link_index("l2")] @ [0.5, 0, 0, 1]
        pose = np.eye(4)
        pose[:3, :3] = pin.exp3(generator.normal(size=3))
        pose[:3, 3] = tip[:3]
        scene = pc.Scene()
        scene.add_box("wall", [1e-4, 0.05, 0.05], pose)
        checker = pc.Checker(robot, scene, self_collision=False)
        assert not checker.is_valid(at)
        assert not checker.check_motion(q0, q1)
        assert not checker.check_motion(q1, q0)
        missed += bool(checker.check_states(np.linspace(q0, q1, 34)).all())
        verdict = checker.explain_motion(q0, q1)
        assert verdict.collides_at is not None
        assert verdict.collides_at <= 0.5
    assert missed > 0


def turning_block(tmp_path, kind="continuous"):
    path = tmp_path / "turn.urdf"
    path.write_text(f"""<robot name="turn"><link name="base"/>
    <link name="arm"><collision><origin xyz="1 0 0"/><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
    <joint name="turn" type="{kind}"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
    <limit lower="-7" upper="7" effort="1" velocity="1"/></joint></robot>""")
    return path


def wall_at(angle):
    scene, pose = pc.Scene(), np.eye(4)
    pose[:3, :3] = pin.exp3(np.array([0, 0, angle]))
    pose[:3, 3] = [np.cos(angle), np.sin(angle), 0]
    scene.add_box("wall", [0.1, 1e-4, 0.1], pose)
    return scene


def test_continuous_joints_take_the_short_way(tmp_path):
    urdf = turning_block(tmp_path)
    for group in (["turn"], None):
        robot = pc.Robot.from_urdf(urdf, group=group)
        ends = [np.array([a]) if group else np.array([np.cos(a), np.sin(a)]) for a in (3.0, -3.0)]
        assert not pc.Checker(robot, wall_at(np.pi)).check_motion(*ends)
        assert pc.Checker(robot, wall_at(0.0)).check_motion(*ends)
        assert pc.Checker(robot, wall_at(0.0)).check_motion(*ends, resolution=0.01) or group is None


def test_revolute_joints_go_as_they_are_told(tmp_path):
    robot = pc.Robot.from_urdf(turning_block(tmp_path, "revolute"), group=["turn"])
    assert not pc.Checker(robot, wall_at(0.0)).check_motion([3.0], [-3.0])
    assert pc.Checker(robot, wall_at(np.pi)).check_motion([3.0], [-3.0])
    assert not pc.Checker(robot, wall_at(0.0)).check_motion([6.0], [-0.5])  # once around, and over 0 again


def test_explanations_tell_where(tmp_path):
    robot = pc.Robot.from_urdf(turning_block(tmp_path, "revolute"), group=["turn"])
    checker = pc.Checker(robot, wall_at(1.0))
    verdict = checker.explain_motion([0.0], [2.0])
    half = np.arctan2(0.05, 0.95)  # about where the block's corner meets the wall
    assert not verdict.free
    assert 0.4 < verdict.free_until <= verdict.collides_at < 0.5
    assert verdict.collides_at == pytest.approx((1.0 - half) / 2, abs=2e-3)
    assert verdict.pair.second == "wall"
    assert verdict.pair.colliding
    assert verdict.pair.certificate.verify()
    assert checker.check_motion([0.0], [2.0 * verdict.free_until], tolerance=1e-6)
    state = checker.motion_certifier.states(np.array([0.0]), np.array([2.0]), np.array([verdict.collides_at]))[0]
    assert not checker.is_valid(state)
    free = checker.explain_motion([0.0], [0.5])
    assert free.free
    assert (free.free_until, free.collides_at, free.near_at, free.pair) == (1.0, None, None, None)


def test_a_motion_within_the_tolerance_is_refused_without_a_collision(tmp_path):
    robot = pc.Robot.from_urdf(turning_block(tmp_path, "revolute"), group=["turn"])
    scene, pose = pc.Scene(), np.eye(4)
    pose[:3, 3] = [1.0, 0.0, 0.05 + 0.01 + 5e-5]
    scene.add_box("lid", [0.02, 0.02, 0.02], pose)
    checker = pc.Checker(robot, scene)
    assert not checker.check_motion([-1.0], [1.0])
    assert checker.check_motion([-1.0], [1.0], tolerance=4e-5)
    verdict = checker.explain_motion([-1.0], [1.0])
    assert verdict.collides_at is None
    assert not verdict.pair.colliding
    assert 0 < verdict.pair.certificate.gap <= 1e-4
    assert 0.4 < verdict.free_until <= verdict.near_at < 0.5


def test_both_ends_count(tmp_path):
    robot = pc.Robot.from_urdf(turning_block(tmp_path, "revolute"), group=["turn"])
    checker = pc.Checker(robot, wall_at(1.0))
    for q0, q1 in ((1.0, 0.0), (0.0, 1.0), (1.0, 1.0)):
        assert not checker.check_motion([q0], [q1])
    assert checker.check_motion([0.0], [0.0])


@pytest.mark.parametrize("tolerance", [0.0, -1.0, np.nan, np.inf])
def test_bad_tolerances(tmp_path, tolerance):
    checker = pc.Checker(pc.Robot.from_urdf(turning_block(tmp_path), group=["turn"]), wall_at(0.0))
    with pytest.raises(pc.PlannercheckError, match="tolerance"):
        checker.check_motion([1.0], [2.0], tolerance=tolerance)


def test_numbers_too_large_for_the_tolerance(tmp_path):
    robot = pc.Robot.from_urdf(turning_block(tmp_path, "revolute"), group=["turn"])
    checker = pc.Checker(robot, wall_at(0.0))
    with pytest.raises(pc.PlannercheckError, match="rounding"):
        checker.check_motion([1.0], [2.0], tolerance=1e-12)
    with pytest.raises(pc.PlannercheckError, match="rounding"):
        checker.check_motion([1e14], [1e14])
