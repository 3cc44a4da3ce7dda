"""Motions that are proved free: the bounds against brute force, verdicts against dense sampling and closed forms."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import plannercheck as pc
from plannercheck.common.package_data import example_robot_data
from plannercheck.robots.description import find_description, read_description

# Of lengths in m, for what is computed twice.
ROUNDING = 1e-11


def whole_robot(name, floating=False):
    """A robot in Pinocchio's own numbers."""
    description = read_description(find_description(name))
    return pc.Robot.from_urdf(description.urdf, description.srdf, package_dirs=example_robot_data(), floating=floating)


ROBOTS = {
    "panda": lambda: pc.Robot.load("panda"),
    "ur5": lambda: pc.Robot.load("ur5"),
    "tiago": lambda: pc.Robot.load("tiago"),  # a prismatic torso
    "pr2": lambda: pc.Robot.load("pr2"),  # continuous joints in the group, grippers that mimic
    "kinova": lambda: pc.Robot.load("kinova"),
    "talos": lambda: pc.Robot.load("talos"),
    "tiago whole": lambda: whole_robot("tiago"),  # cosines and sines
    "go2 floating": lambda: whole_robot("go2", floating=True),
    "fingers": lambda: pc.Robot.load("panda").with_group(["panda_joint1", "panda_joint7", "panda_finger_joint1"]),
}


@pytest.fixture(scope="module", params=list(ROBOTS))
def robot(request):
    return ROBOTS[request.param]()


def scattered(seed, count=6, size=0.2, reach=1.2):
    """A scene of small boxes, spheres and a capsule around the robot."""
    generator = np.random.default_rng(seed)
    scene = pc.Scene("scattered")
    for k in range(count):
        pose = np.eye(4)
        pose[:3, :3] = pin.exp3(generator.normal(size=3))
        pose[:3, 3] = generator.uniform(-reach, reach, 3)
        if k % 3:
            scene.add_box(f"box{k}", generator.uniform(0.001, size, 3), pose)
        else:
            scene.add_sphere(f"ball{k}", float(generator.uniform(0.01, size / 2)), pose)
    return scene


def checker_and_valid(robot, scene, n, seed):
    """A checker and valid configurations; without self-collision if the robot always touches itself (no SRDF)."""
    q = robot.random_configurations(n, seed)
    for own in (True, False):
        checker = pc.Checker(robot, scene, self_collision=own)
        valid = q[checker.check_states(q)]
        if len(valid) >= 4:
            return checker, valid
    raise AssertionError("no valid configurations")


def certified_ends(checker, q0, q1):
    return checker._motion_ends(q0[None], q1[None])


def points_in_frame(checker, body, poses, turns):
    """(k, n, 3): vertices of a body at k poses (k, 4, 4) of it, turned into frames (k, 3, 3)."""
    vertices = checker.polytopes[body].vertices
    world = np.einsum("kij,nj->kni", poses[:, :3, :3], vertices) + poses[:, None, :3, 3]
    return np.einsum("kji,knj->kni", turns, world)


def check_proof(checker, q0, q1, proof):
    """Gaps at both ends are as said, and at states between no vertex leaves its chord further than said."""
    inner = np.linspace(proof.start, proof.end, 5)
    states = checker.motion_certifier.states(q0, q1, inner)
    poses, links = checker.body_poses(states), checker.robot.link_poses(states)
    turns = np.repeat(np.eye(3)[None], len(inner), axis=0)
    if proof.frame is not None:
        turns = links[:, checker.robot.link_index(proof.frame), :3, :3]
    origin = np.zeros((len(inner), 3))
    if proof.frame is not None:
        origin = links[:, checker.robot.link_index(proof.frame), :3, 3]
    leaves, extents = [], []
    for sign, body in ((1, proof.first_body), (-1, proof.second_body)):
        points = points_in_frame(checker, body, poses[:, body], turns)
        seen = points - np.einsum("kji,kj->ki", turns, origin)[:, None]
        parts = np.linspace(0, 1, len(inner))[:, None, None]
        chords = (1 - parts) * seen[0] + parts * seen[-1]
        leaves.append(np.linalg.norm(seen - chords, axis=2).max())
        extents.append((sign * points @ proof.normal).min(axis=1) - checker.polytopes[body].swell)
    assert sum(leaves) <= proof.bulge + ROUNDING
    gaps = sum(extents)
    assert min(gaps[0], gaps[-1]) >= proof.gap - ROUNDING
    assert proof.gap > proof.bulge
    assert gaps.min() > 0


def test_proofs_hold_against_brute_force(robot):
    checker, valid = checker_and_valid(robot, scattered(1), 60, 2)
    proved = 0
    for near, far in zip(valid[:6:2], valid[1:6:2], strict=False):
        (q0,), (q1,) = certified_ends(checker, near, far)
        verdict = checker.explain_motion(q0, q1, proofs=True)
        assert (verdict.free_until == 1.0) == verdict.free
        for proof in verdict.proofs[:: max(1, len(verdict.proofs) // 25)]:
            check_proof(checker, q0, q1, proof)
            proved += 1
    assert proved > 0


def test_proofs_cover_every_pair_up_to_where_the_motion_is_free(robot):
    checker, valid = checker_and_valid(robot, scattered(3, 3), 40, 4)
    q0, q1 = valid[:2]
    verdict = checker.explain_motion(q0, q1, proofs=True)
    covered: dict[tuple[int, int], float] = {}
    for proof in sorted(verdict.proofs, key=lambda p: p.start):
        key = (proof.first_body, proof.second_body)
        if proof.start <= covered.get(key, 0.0):
            covered[key] = max(covered.get(key, 0.0), proof.end)
    moving = [tuple(checker.pairs[k].tolist()) for k in checker.motion_certifier._whole.rows]
    assert min(covered.get(key, 0.0) for key in moving) >= verdict.free_until


def test_states_are_pinocchios_interpolation():
    robot = whole_robot("tiago", floating=True)  # a floating base, cosines and sines, lengths
    checker = pc.Checker(robot, self_collision=False, scene=scattered(5))
    q = robot.random_configurations(8, 6)
    parameters = np.linspace(0, 1, 7)
    for q0, q1 in zip(q[::2], q[1::2], strict=True):
        states = checker.motion_certifier.states(q0, q1, parameters)
        theirs = np.array([pin.interpolate(robot.model, q0, q1, t) for t in parameters])
        apart = [np.abs(pin.difference(robot.model, a, b)).max() for a, b in zip(states, theirs, strict=True)]
        assert max(apart) < 1e-12


@pytest.mark.parametrize("seed", range(20))
def test_small_and_large_turns_of_a_floating_base(seed):
    robot = whole_robot("go2", floating=True)
    generator = np.random.default_rng(seed)
    checker = pc.Checker(robot)
    q0 = robot.random_configurations(1, seed)[0]
    moved = np.zeros(robot.model.nv)
    moved[:6] = generator.normal(size=6) * 10.0 ** generator.integers(-9, 1)
    q1 = pin.integrate(robot.model, q0, moved)
    states = checker.motion_certifier.states(q0, q1, np.array([0.0, 0.3, 1.0]))
    assert np.abs(pin.difference(robot.model, states[0], q0)).max() < 1e-13
    assert np.abs(pin.difference(robot.model, states[2], q1)).max() < 1e-12
    assert np.abs(pin.difference(robot.model, states[1], pin.interpolate(robot.model, q0, q1, 0.3))).max() < 1e-12


def dense_states(checker, q0, q1, steps):
    return checker.motion_certifier.states(q0, q1, np.linspace(0, 1, steps + 1))


@pytest.mark.parametrize(("name", "scene"), [("panda", "bookshelf"), ("ur5", "cage"), ("kinova", None)])
def test_verdicts_against_dense_sampling(name, scene):
    robot = pc.Robot.load(name)
    checker = pc.Checker(robot, scattered(7, 12) if scene is None else pc.Scene.load(scene))
    generator = np.random.default_rng(8)
    q = robot.random_configurations(200, 9)
    q0 = q[checker.check_states(q)][:50]
    way = generator.normal(size=q0.shape) * generator.uniform(0.02, 1.0, (len(q0), 1))
    q1 = q0 + way
    free = checker.check_motions(q0, q1)
    assert 0.2 < free.mean() < 0.95
    for a, b, verdict in zip(q0, q1, free, strict=True):
        (start,), (end,) = certified_ends(checker, a, b)
        sampled = checker.check_states(dense_states(checker, start, end, 3000)).all()
        if verdict:
            assert sampled
        else:
            assert_refused_rightly(checker, start, end)


def assert_refused_rightly(checker, q0, q1):
    """Some pair collides, or is within the tolerance, by a bound of its own: spheres grown by the tolerance."""
    verdict = checker.explain_motion(q0, q1)
    assert not verdict.free
    if verdict.collides_at is not None:
        state = checker.motion_certifier.states(q0, q1, np.array([verdict.collides_at]))[0]
        assert not checker.is_valid(state)
        assert verdict.free_until <= verdict.collides_at
    else:
        assert verdict.pair.certificate.gap <= verdict.tolerance


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


def test_batches_threads_and_history_do_not_matter():
    robot, scene = pc.Robot.load("panda"), pc.Scene.load("bookshelf")
    rows = scene.samples("panda")
    rows = rows[pc.Checker(robot, scene).check_states(rows)][:200]
    q0, q1 = rows[:100], rows[100:200]
    checker = pc.Checker(robot, scene)
    together = checker.check_motions(q0, q1)
    assert 0 < together.sum() < len(together)
    assert np.array_equal(checker.check_motions(q0, q1, threads=2), together)
    assert np.array_equal(checker.check_motions(q1, q0), together)
    assert np.array_equal([checker.check_motion(a, b) for a, b in zip(q0, q1, strict=True)], together)
    assert np.array_equal([checker.explain_motion(a, b).free for a, b in zip(q0[:30], q1, strict=False)], together[:30])
    assert np.array_equal(pc.Checker(robot, scene).check_motions(q0[::-1], q1[::-1])[::-1], together)


def test_bodies_that_never_move_are_judged_once():
    robot = pc.Robot.load("talos")
    assert pc.Checker(robot).check_motion(robot.reference, robot.reference)
    held = pc.Robot.load("panda").with_group(["panda_joint7"])
    bad = held.holding({"panda_joint4": -3.07, "panda_joint2": 1.7, "panda_joint6": 3.7})
    for candidate in (held, bad):
        checker = pc.Checker(candidate)
        free = checker.is_valid(candidate.reference)
        assert checker.check_motion(candidate.reference, candidate.reference) == free


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


def test_pinocchios_own_poses_prove_nothing():
    checker = pc.Checker(pc.Robot.load("panda"), kinematics="pinocchio")
    q = checker.robot.reference
    with pytest.raises(pc.PlannercheckError, match="resolution="):
        checker.check_motion(q, q)
    assert checker.check_motion(q, q, resolution=0.01)


@pytest.mark.parametrize("name", ["panda", "tiago"])
def test_pairs_that_never_meet_within_the_limits_change_no_verdict(name):
    robot = pc.Robot.load(name)
    live, plain = (pc.Checker(robot, pc.Scene.load("table"), reach=on) for on in (True, False))
    assert live.unreachable.any()
    q = robot.random_configurations(200, 9)
    q0, q1 = q[::2], q[::2] + 0.3 * (q[1::2] - q[::2])
    q1[::5] += 0.5 * (robot.upper - robot.lower)  # beyond the limits: all pairs count
    found, truth = live.check_motions(q0, q1), plain.check_motions(q0, q1)
    np.testing.assert_array_equal(found, truth)
    assert found.any()
    assert not found.all()
    certifiers = live.motion_certifier, plain.motion_certifier
    assert len(certifiers[0]._live.rows) < len(certifiers[1]._live.rows) == len(certifiers[0]._whole.rows)
    for a, b, free in zip(q0[:40], q1[:40], found[:40].tolist(), strict=True):
        assert live.check_motion(a, b) == free
        passages = [certifier.passage(a, b, 1e-4) for certifier in certifiers]
        assert passages[0].free == passages[1].free == free
        assert (passages[0].pair, passages[0].near) == (passages[1].pair, passages[1].near)
    assert live.motion_certifier.statistics()["motions"] == 180  # both parts count


def test_statistics_count_what_the_pair_test_did():
    checker = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"))
    q = checker.robot.random_configurations(200, 1)
    assert not checker.check_motions(q[::2], q[1::2]).all()  # some pair shares a point, which the pair test finds
    assert all(checker.motion_certifier.statistics()["queries"][name] > 0 for name in ("blocks", "games", "rounds"))


def test_planners_motions_are_those_of_the_checker():
    checker = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"))
    judge = checker.motion_certifier.motion_validity(1e-4)
    q = checker.robot.random_configurations(120, 4)
    q0, q1 = q[::2], q[::2] + 0.4 * (q[1::2] - q[::2])
    q1[::7] = checker.robot.upper + 0.2
    free = checker.check_motions(q0, q1).tolist()
    assert [judge(a.tolist(), b.tolist()) for a, b in zip(q0, q1, strict=True)] == free
    assert any(free)
    with pytest.raises((TypeError, IndexError)):
        judge(["x"] * 7, [0.0] * 7)
    with pytest.raises(IndexError):
        judge([0.0] * 3, [0.0] * 7)
