"""Proofs of motions in space: what the checker proves is confirmed, what a wrong certifier would prove is refused."""

from dataclasses import replace

import numpy as np
import proof_oracle
import pytest
from flint import arb
from poses import at
from proof_cases import free_motions, random_tree, scattered, whole_robot

import plannercheck as pc
from plannercheck.motions.certifier_answers import MotionResult
from plannercheck.motions.certifier_answers import Proof as Plane
from plannercheck.motions.proof_builder import Builder


def proved(checker, q0, q1):
    """The proofs of motions, all of which must be there and confirmed."""
    proofs = checker.certify_motions(q0, q1)
    assert all(proof is not None for proof in proofs)
    for proof in proofs:
        found = proof.verify()
        assert found, found.fault
        assert found.entries == len(proof.entries)
    return proofs


@pytest.mark.parametrize(
    ("robot", "scene", "count"),
    [
        ("panda", "bookshelf", 3),
        ("ur5", "kitchen", 3),
        ("pr2", "empty", 2),
        ("talos", "empty", 1),
        ("kinova", "bin", 2),
    ],
)
def test_motions_of_shipped_robots_are_proved(robot, scene, count):
    checker = pc.Checker(pc.Robot.load(robot), pc.Scene.load(scene))
    q0, q1 = free_motions(checker, count, 1)
    assert len(q0)
    for proof in proved(checker, q0, q1):
        assert {entry.pair for entry in proof.entries} == set(range(len(checker.pairs)))


@pytest.mark.parametrize("robot", ["tiago", "go2", "g1"])
def test_whole_robots_with_floating_bases_are_proved(robot):
    checker = pc.Checker(whole_robot(robot, floating=True), scattered(np.random.default_rng(0)))
    q0, q1 = free_motions(checker, 1, 1)
    if not len(q0):  # without its SRDF the robot always touches itself
        checker = pc.Checker(checker.robot, checker.scene, self_collision=False)
        q0, q1 = free_motions(checker, 1, 1)
    proved(checker, q0, q1)


@pytest.mark.parametrize("seed", range(12))
def test_random_trees_are_proved(seed, tmp_path):
    generator = np.random.default_rng(seed)
    robot = pc.Robot.from_urdf(random_tree(generator, tmp_path), floating=bool(seed % 2))
    if seed % 3 == 0:  # a group: continuous joints are angles, mimics follow, others are held
        leaders = [name for name in robot.joint_names if name not in robot.mimics]
        robot = robot.with_group([name for name in leaders if generator.random() < 0.7] or leaders[:1])
    checker = pc.Checker(robot, scattered(generator))
    q0, q1 = free_motions(checker, 2, seed)
    for proof in proved(checker, q0, q1):
        assert not proof_oracle.is_false(proof)


def test_a_motion_that_collides_has_no_proof_and_names_a_state():
    scene = pc.Scene.load("bookshelf")
    checker = pc.Checker(pc.Robot.load("panda"), scene)
    verdict = checker.explain_motion(scene.start("panda"), scene.goal("panda"))
    assert not verdict.free
    assert verdict.proof is None
    assert verdict.pair.certificate.verify()
    assert checker.certify_motions([scene.start("panda")], [scene.goal("panda")]) == (None,)


def test_the_proof_of_a_verdict_is_computed_once_and_of_this_motion():
    checker = pc.Checker(pc.Robot.load("ur5"), pc.Scene.load("table"))
    (q0,), (q1,) = free_motions(checker, 1, 4)
    verdict = checker.explain_motion(q0, q1)
    assert verdict.proof is verdict.proof
    assert verdict.proof.motion.start == tuple(q0)
    assert verdict.proof.motion.end == tuple(q1)
    assert verdict.proof.verify()


def test_held_fingers_and_padding_and_attached_objects_are_in_the_proof():
    robot = pc.Robot.load("panda").holding({"panda_finger_joint1": 0.02})
    pose = at(0, 0, 0.25)
    checker = pc.Checker(robot, pc.Scene.load("table"), padding=0.004)
    checker = checker.attach("stick", pc.Box((0.02, 0.02, 0.2)), "panda_hand", pose)
    q0, q1 = free_motions(checker, 1, 2)
    (proof,) = proved(checker, q0, q1)
    fingers = {joint.name: joint for joint in proof.model.joints if "finger" in joint.name}
    assert fingers["panda_finger_joint1"].offsets == (0.02,)
    assert all(max(joint.columns) < 0 for joint in fingers.values())
    assert all(body.padding == 0.002 for body in proof.model.bodies)
    assert "stick" in {body.label for body in proof.model.bodies}
    assert not proof_oracle.is_false(proof)


def test_mimics_follow_in_the_proof():
    robot = pc.Robot.load("panda").with_group(["panda_joint1", "panda_joint4", "panda_finger_joint1"])
    checker = pc.Checker(robot, pc.Scene.load("table"))
    q0, q1 = free_motions(checker, 2, 3)
    for proof in proved(checker, q0, q1):
        fingers = [joint for joint in proof.model.joints if "finger" in joint.name]
        assert [joint.columns for joint in fingers] == [(2,), (2,)]


def test_continuous_joints_go_the_short_way_and_the_asked_end_is_kept(tmp_path):
    robot = pc.Robot.load("pr2")
    checker = pc.Checker(robot)
    (q0,), (q1,) = free_motions(checker, 1, 3)
    column = int(checker.motion_sampler.whole_turns[0])
    asked = q1.copy()
    asked[column] += 6 * np.pi
    proof = checker.explain_motion(q0, asked).proof
    assert proof.verify()
    assert proof.motion.asked_end == tuple(asked)
    assert abs(proof.motion.end[column] - q0[column]) <= np.pi
    far = replace(proof.motion, asked_end=tuple(np.where(np.arange(len(asked)) == column, asked + 0.1, asked)))
    assert not replace(proof, motion=far).verify()


@pytest.mark.parametrize("asked", [1e6, 1e12, 9e14])
def test_an_asked_end_many_turns_away_does_not_count_among_what_is_interpolated(asked):
    robot = pc.Robot.load("pr2")
    checker = pc.Checker(robot)
    (q0,), (q1,) = free_motions(checker, 1, 3)
    q1 = q0.copy()
    q1[int(checker.motion_sampler.whole_turns[0])] = asked
    near = checker.motion_sampler.shorter_turn(q0[None], q1[None])
    (proof,) = checker.certify_motions(q0[None], q1[None])
    (plain,) = checker.certify_motions(q0[None], near)
    assert (proof is None) == (plain is None)
    if proof is not None:
        assert proof.margin <= 10 * plain.margin
        assert proof.verify()


def forged(checker, q0, q1, planes, monkeypatch):
    """The proof that the package builds if its certifier says that a motion is free."""
    builder = Builder(checker)
    monkeypatch.setattr(builder, "_motion_result", lambda *arguments: MotionResult(True, 1.0, -1.0, -1, planes))
    return builder.proof(*(np.asarray(q, dtype=np.float64) for q in (q0, q1, q1)), 1e-4)


def test_a_certifier_that_forgets_a_planar_joints_own_shift_is_found_out(tmp_path, monkeypatch):
    # Seen from the child, the root's box goes along an arc of 5 m around it, and through a plate in the middle of it,
    # which a certifier misses that takes the arm of the turn without the joint's own shift.
    path = tmp_path / "slider.urdf"
    path.write_text(
        "<robot name='slider'>"
        "<link name='a'><collision><geometry><box size='0.1 0.1 0.1'/></geometry></collision></link><link name='b'/>"
        "<link name='c'><collision><origin xyz='-5.05 0 0'/><geometry><box size='0.1 9 0.1'/></geometry></collision>"
        "</link><joint name='p' type='planar'><parent link='a'/><child link='b'/></joint>"
        "<joint name='w' type='fixed'><parent link='b'/><child link='c'/></joint></robot>"
    )
    checker = pc.Checker(pc.Robot.from_urdf(path))
    assert len(checker.pairs) == 1
    q0, q1 = ([5.0, 0.0, np.cos(a), np.sin(a)] for a in (-0.3, 0.3))
    assert checker.check_states([q0, [5.0, 0.0, 1.0, 0.0], q1]).tolist() == [True, False, True]
    child, root_first = checker.robot.link_index("c"), checker.bodies[checker.pairs[0, 0]].link == "a"
    planes = (Plane(0, 0.0, 1.0, child, not root_first, np.array([1.0, 0.0, 0.0]), 0.1, 0.0),)
    proof = forged(checker, q0, q1, planes, monkeypatch)
    assert proof_oracle.is_false(proof)
    assert not proof.verify()
    proofs = checker.certify_motions([q0], [q1])
    assert proofs[0] is None or not proofs[0].verify()


def test_a_certifier_that_forgets_what_far_ends_round_is_found_out():
    checker = pc.Checker(pc.Robot.load("pr2"))
    (q0,), (q1,) = free_motions(checker, 1, 3)
    proof = checker.explain_motion(q0, q1).proof
    column = int(checker.motion_sampler.whole_turns[0])
    for far, holds in ((1e3, True), (1e15, False)):
        turns = np.round(far / (2 * np.pi))
        asked = list(proof.motion.end)
        asked[column] += float(2 * np.pi * turns)  # rounded to a multiple of an eighth, at 1e15
        changed = replace(proof, motion=replace(proof.motion, asked_end=tuple(asked)))
        assert bool(changed.verify()) == holds
    assert float(arb.pi()) == np.pi


def test_entries_end_where_planes_do():
    """Found by the stress of motions: two planes, each of which holds just as long as the certifier says."""
    from plannercheck.motions.certifier_answers import Proof
    from plannercheck.motions.proof_builder import _PairEntries

    first, second = (np.array(d, dtype=float) for d in ([1, 0, 0], [0, 1, 0]))
    planes = [Proof(0, 0.0, 0.3, -1, False, first, 1.0, 0.1), Proof(0, 0.3, 1.0, -1, False, second, 1.0, 0.1)]

    class Checker:
        def holds(self, entry, deepest):
            plane = planes[0] if entry.end <= 0.3 else planes[1]
            within = plane.start <= entry.start and entry.end <= plane.end
            return entry.by == "plane" and within and entry.direction == tuple(plane.direction.tolist())

    checker = Checker()
    entries = _PairEntries(checker, 0, planes, None).over(0.0, 1.0, 0)
    assert [entries[0].start, *(entry.end for entry in entries)] == [*(entry.start for entry in entries), 1.0]
    assert all(checker.holds(entry, 0) for entry in entries)
    assert 0.3 in [entry.end for entry in entries]
