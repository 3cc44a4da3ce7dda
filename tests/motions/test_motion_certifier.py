"""Motions that are proved free: the bounds against brute force, verdicts against dense sampling."""

import numpy as np
import pinocchio as pin
import pytest
from certified_motions import certified_ends, dense_states
from proof_cases import whole_robot

import plannercheck as pc

# Of lengths in m, for what is computed twice.
ROUNDING = 1e-11


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
        extents.append((sign * points @ proof.normal).min(axis=1) - checker.polytopes[body].inflation_radius)
    assert sum(leaves) <= proof.chord_deviation + ROUNDING
    gaps = sum(extents)
    assert min(gaps[0], gaps[-1]) >= proof.gap - ROUNDING
    assert proof.gap > proof.chord_deviation
    assert gaps.min() > 0


def test_proofs_hold_against_brute_force(robot):
    checker, valid = checker_and_valid(robot, scattered(1), 60, 2)
    proved = 0
    for near, far in zip(valid[:4:2], valid[1:4:2], strict=False):
        (q0,), (q1,) = certified_ends(checker, near, far)
        verdict = checker.explain_motion(q0, q1, proofs=True)
        assert (verdict.free_until == 1.0) == verdict.free
        for proof in verdict.proofs[:: max(1, len(verdict.proofs) // 12)]:
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
    moving = [tuple(checker.pairs[k].tolist()) for k in checker.motion_certifier._all_pairs.rows]
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


def test_small_and_large_turns_of_a_floating_base():
    robot = whole_robot("go2", floating=True)
    generator, checker = np.random.default_rng(0), pc.Checker(robot)
    for q0 in robot.random_configurations(20, 0):
        moved = np.zeros(robot.model.nv)
        moved[:6] = generator.normal(size=6) * 10.0 ** generator.integers(-9, 1)
        q1 = pin.integrate(robot.model, q0, moved)
        states = checker.motion_certifier.states(q0, q1, np.array([0.0, 0.3, 1.0]))
        assert np.abs(pin.difference(robot.model, states[0], q0)).max() < 1e-13
        assert np.abs(pin.difference(robot.model, states[2], q1)).max() < 1e-12
        middle = pin.interpolate(robot.model, q0, q1, 0.3)
        assert np.abs(pin.difference(robot.model, states[1], middle)).max() < 1e-12


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


def test_pinocchios_own_poses_prove_nothing():
    checker = pc.Checker(pc.Robot.load("panda"), kinematics="pinocchio")
    q = checker.robot.reference
    with pytest.raises(pc.PlannercheckError, match="resolution="):
        checker.check_motion(q, q)
    assert checker.check_motion(q, q, resolution=0.01)


@pytest.mark.parametrize("name", ["panda", "tiago"])
def test_pairs_that_never_meet_within_the_limits_change_no_verdict(name):
    robot = pc.Robot.load(name)
    live, plain = (pc.Checker(robot, pc.Scene.load("table"), tuning=pc.Tuning(reach=on)) for on in (True, False))
    assert live.unreachable.any()
    q = robot.random_configurations(200, 9)
    q0, q1 = q[::2], q[::2] + 0.3 * (q[1::2] - q[::2])
    q1[::5] += 0.5 * (robot.upper - robot.lower)  # beyond the limits: all pairs count
    found, truth = live.check_motions(q0, q1), plain.check_motions(q0, q1)
    np.testing.assert_array_equal(found, truth)
    assert found.any()
    assert not found.all()
    certifiers = live.motion_certifier, plain.motion_certifier
    assert (
        len(certifiers[0]._pairs_within_limits.rows)
        < len(certifiers[1]._pairs_within_limits.rows)
        == len(certifiers[0]._all_pairs.rows)
    )
    for a, b, free in zip(q0[:40], q1[:40], found[:40].tolist(), strict=True):
        assert live.check_motion(a, b) == free
        results = [certifier.motion_result(a, b, 1e-4) for certifier in certifiers]
        assert results[0].free == results[1].free == free
        assert (results[0].pair, results[0].near) == (results[1].pair, results[1].near)
    assert live.motion_certifier.statistics()["motions"] == 180  # both parts count


def test_one_motion_beyond_the_limits_meets_what_no_motion_within_them_reaches(tmp_path, monkeypatch):
    path = tmp_path / "arm.urdf"
    path.write_text("""<robot name="arm"><link name="base"/>
    <link name="arm"><collision><origin xyz="0.5 0 0"/><geometry><box size="0.8 0.1 0.1"/></geometry></collision></link>
    <joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>""")
    scene = pc.Scene("behind")
    pose = np.eye(4)
    pose[0, 3] = -0.6
    scene.add_box("post", (0.1, 0.1, 1.0), pose)
    checker = pc.Checker(pc.Robot.from_urdf(path), scene)
    assert checker.unreachable.all()
    for end, free in ((0.9, True), (2.0, True), (3.0, False), (4.0, False)):
        assert checker.check_motion(np.array([0.0]), np.array([end])) is free
        assert checker.check_motions(np.array([[0.0]]), np.array([[end]])).tolist() == [free]
        assert checker.motion_certifier.judge_rows_beyond(np.array([0.0]), np.array([end]), 1e-4) is free
    monkeypatch.setattr(pc.Checker, "check_motions", None)  # one motion needs no set
    assert not checker.check_motion(np.array([0.0]), np.array([3.0]))


def test_statistics_count_what_the_pair_test_did():
    # Padded, some pairs come so near that only the pair test finds whether they share a point.
    checker = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"), padding=0.02)
    q = checker.robot.random_configurations(200, 1)
    assert not checker.check_motions(q[::2], q[1::2]).all()
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
