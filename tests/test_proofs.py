"""Proofs of motions in space: what the checker proves is confirmed, and what is false is refused.

False claims are made by construction (bodies that overlap in the middle of an interval alone, by less than a radius, on
the side that a bound leaves out), and by changing one number of a proof until a sampled state contradicts it.
"""

from __future__ import annotations

import os
import warnings
from dataclasses import replace
from itertools import pairwise

import mpmath
import numpy as np
import pinocchio as pin
import proof_oracle
import pytest
from flint import arb, arb_mat
from proof_cases import free_motions, random_tree, scattered, whole_robot

import plannercheck as pc
from plannercheck.certified_motions import Passage
from plannercheck.certified_motions import Proof as Plane
from plannercheck.proofs import Entry, Joint, Link, Model, Motion, PosedBody, Proof, entries, joint_motions
from plannercheck.proofs.build import Builder
from plannercheck.proofs.chains import Chains
from plannercheck.proofs.proof import JOINT_VALUES
from plannercheck.proofs.well_formed import hashes_of

# Proofs of which one number is changed; 1,000 take some 10 minutes.
CHANGES = int(os.environ.get("PLANNERCHECK_PROOFS", "150"))

STILL = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0)
CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2.0


def proved(checker, q0, q1):
    """The proofs of motions, all of which must be there and confirmed."""
    proofs = checker.certify_motions(q0, q1)
    assert all(proof is not None for proof in proofs)
    for proof in proofs:
        found = proof.verify()
        assert found, found.fault
        assert found.entries == len(proof.entries)
    return proofs


def sealed(proof, **changes):
    """A proof with changes, whose hashes are made to fit."""
    changed = replace(proof, **changes)
    return replace(changed, hashes=hashes_of(changed.model))


def at(x=0.0, y=0.0, z=0.0):
    return (1.0, 0.0, 0.0, x, 0.0, 1.0, 0.0, y, 0.0, 0.0, 1.0, z)


def point(name, link, pose=STILL, vertices=((0.0, 0.0, 0.0),), radius=0.0, reach=1e-200):
    return PosedBody(name, name, link, pose, np.array(vertices, dtype=np.float64), radius, 0.0, (0.0, 0.0, 0.0), reach)


def turn(parent=-1, placement=STILL, axis=(0.0, 0.0, 1.0), column=0, multiplier=1.0, offset=0.0, kind="turn"):
    return Joint(f"j{column}", kind, parent, placement, axis, (column,), (multiplier,), (offset,))


def claim(joints, bodies, start, end, entries, margin=0.0, links=None, pairs=((0, 1),), asked=None, whole=()):
    """A proof of what is given, link k on joint k."""
    links = links or tuple(Link(f"l{k}", k, STILL) for k in range(len(joints)))
    model = Model(tuple(joints), tuple(links), tuple(bodies), tuple(pairs), tuple(whole), len(start))
    motion = Motion(tuple(start), tuple(end), tuple(end if asked is None else asked))
    return Proof("space", "r", "s", hashes_of(model), model, motion, margin, tuple(entries))


def plane(direction=(0.0, 1.0, 0.0), frame=-1, start=0.0, end=1.0, pair=0):
    return Entry(pair, start, end, "plane", frame, tuple(map(float, direction)))


# ----- what is proved is confirmed


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
    pose = np.eye(4)
    pose[2, 3] = 0.25
    checker = pc.Checker(robot, pc.Scene.load("table"), padding=0.004)
    checker = checker.attach("stick", pc.shapes.Box((0.02, 0.02, 0.2)), "panda_hand", pose)
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


# ----- poses


def chains_of(checker, q0, q1):
    builder = Builder(checker)
    motion = Motion(*(tuple(map(float, q)) for q in (q0, q1, q1)))
    return Chains(builder._model, motion), builder._model


def joint_poses(robot, q):
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, robot.expand(q))
    return [pose.homogeneous for pose in data.oMi][1:]


def middle(matrix):
    return np.array([float(x) for x in matrix.entries()]).reshape(4, 4)


@pytest.mark.parametrize("seed", range(8))
def test_the_verifiers_poses_are_pinocchios(seed, tmp_path):
    generator = np.random.default_rng(100 + seed)
    robot = pc.Robot.from_urdf(random_tree(generator, tmp_path, links=7), floating=bool(seed % 2))
    q0, q1 = robot.random_configurations(2, generator)
    if seed % 4 < 2:  # turns of nearly nothing, where closed forms cancel
        q1 = pin.integrate(robot.model, q0, generator.normal(size=robot.model.nv) * 10.0 ** -generator.uniform(0, 9))
    chains, model = chains_of(pc.Checker(robot, scattered(generator)), q0, q1)
    for t in (0.0, 0.3, 1.0):
        exact = joint_poses(robot, pin.interpolate(robot.model, q0, q1, t))
        for k in range(len(model.joints)):
            assert np.abs(middle(chains.at(t, -1, k)) - exact[k]).max() < 1e-11


@pytest.mark.parametrize("seed", range(6))
def test_jets_hold_poses_and_derivatives_all_over_an_interval(seed, tmp_path):
    generator = np.random.default_rng(200 + seed)
    robot = pc.Robot.from_urdf(random_tree(generator, tmp_path), floating=bool(seed % 2))
    q0, q1 = robot.random_configurations(2, generator)
    chains, model = chains_of(pc.Checker(robot, scattered(generator)), q0, q1)
    step = 2.0**-13
    for span in ((0.25, 0.375), (0.5, 0.53125)):
        for k in range(len(model.joints)):
            jet = chains.jet(span, -1, k)
            for t in np.linspace(span[0] + step, span[1] - step, 4):
                near = [middle(chains.at(float(t + d), -1, k)) for d in (-step, 0.0, step)]
                assert encloses(jet.value, near[1], 1e-12)
                assert encloses(jet.first, (near[2] - near[0]) / (2 * step), 1e-5)
                assert encloses(jet.second, (near[2] - 2 * near[1] + near[0]) / step**2, 1e-4)


def encloses(matrix, numbers, slack):
    """Whether balls hold numbers, but for a part of their size that differences are off by."""
    if matrix is None:
        return np.abs(numbers).max() < slack
    room = slack * (1 + np.abs(numbers).max())
    low = np.array([float(x.lower()) for x in matrix.entries()]).reshape(4, 4)
    high = np.array([float(x.upper()) for x in matrix.entries()]).reshape(4, 4)
    return bool(((numbers >= low - room) & (numbers <= high + room)).all())


# ----- false by construction: the smallest overlap that a missing term would let pass


def pendulum(wall, swing=0.3, arm=1.0, frame=-1, direction=(0.0, 1.0, 0.0), flipped=False, **options):
    """A point at the end of an arm along y swings past a wall at y = `wall`, nearest in the middle."""
    bodies = [point("wall", -1, at(y=wall)), point("tip", 0, at(y=arm))]
    if flipped:
        bodies, direction = bodies[::-1], tuple(-x for x in direction)
    return claim([turn()], bodies, (-swing,), (swing,), [plane(direction, frame)], **options)


@pytest.mark.parametrize("flipped", [False, True])
@pytest.mark.parametrize("swing", [0.01, 0.3, 1.2])
def test_a_swing_through_a_wall_is_refused_and_past_it_confirmed(swing, flipped):
    assert pendulum(1 + 1e-4, swing, flipped=flipped).verify()
    assert not pendulum(1 - 1e-6, swing, flipped=flipped).verify()


def test_the_second_derivative_counts_in_full():
    # On a short swing the tip leaves its chord by what the bound says, up to a hundred-thousandth of it.
    swing, deepest = 0.01, 7
    rise = 0.5 * swing**2 / 4.0**deepest  # of the shortest part that the verifier looks at
    assert not pendulum(1 - 0.4 * rise, swing).verify()


def test_a_direction_of_any_length_is_measured():
    for length in (1e-6, 1.0, 1e6):
        assert pendulum(1.001, direction=(0, length, 0), margin=0.0009).verify()
        assert not pendulum(1.001, direction=(0, length, 0), margin=0.0011).verify()
    assert not pendulum(1.001, direction=(0, 0, 0)).verify()
    assert not pendulum(1.001, direction=(0, -1, 0)).verify()


@pytest.mark.parametrize("which", [0, 1])
def test_radii_count(which):
    def with_radius(radius):
        bodies = [point("wall", -1, at(y=1.1)), point("tip", 0, at(y=1.0))]
        bodies[which] = replace(bodies[which], radius=radius)
        return claim([turn()], bodies, (-0.3,), (0.3,), [plane()])

    assert with_radius(0.0999).verify()
    assert not with_radius(0.1001).verify()


@pytest.mark.parametrize("which", [0, 1])
def test_every_vertex_counts(which):
    vertices = np.random.default_rng(which).uniform(-0.01, 0.01, (9, 3))
    for k in range(9):
        far = vertices.copy()
        far[k] = (0, 0.1001 if which else -0.1001, 0)
        bodies = [point("wall", -1, at(y=1.1)), point("tip", 0, at(y=1.0))]
        bodies[which] = replace(bodies[which], vertices=far)
        assert not claim([turn()], bodies, (-1e-4,), (1e-4,), [plane()]).verify()
        bodies[which] = replace(bodies[which], vertices=far * 0.95)
        assert claim([turn()], bodies, (-1e-4,), (1e-4,), [plane()]).verify()


def test_a_frame_turns_its_direction():
    # The direction is fixed on the arm: the wall, a point, is passed at the side, by both ends of the arm's way.
    for wall, holds in ((1.2, True), (0.9, False)):
        assert bool(pendulum(wall, frame=0).verify()) == holds
    bodies = [point("post", -1, at(x=0.0, y=0.5)), point("tip", 0, at(x=0.1, y=0.5))]
    passing = claim([turn()], bodies, (-0.3,), (0.3,), [plane((-1, 0, 0), 0)])
    assert not passing.verify()  # the tip turns into the post


@pytest.mark.parametrize("frame", [-1, 0, 1, 2, 3])
def test_planes_in_every_frame_of_two_branches(frame):
    # Two arms on a turning base move towards each other; in the frame of each link the plane turns along with it.
    joints = [turn(), turn(0, at(x=-1.0), column=1), turn(0, at(x=1.0), column=2), turn(2, at(y=0.5), column=3)]
    bodies = [point("right", 3, at(y=0.5), CUBE * 0.2), point("left", 1, at(y=1.0), CUBE * 0.2)]
    start = (0.0, 0.1, -0.1, 0.0)
    small, large = (0.05, 0.1, -0.05, 0.05), (0.05, -1.5, 1.5, 0.0)
    facing = plane((1, 0, 0), frame)
    assert claim(joints, bodies, start, small, [facing]).verify()
    assert not proof_oracle.is_false(claim(joints, bodies, start, small, [facing]))
    hitting = claim(joints, bodies, start, large, [facing])
    assert proof_oracle.is_false(hitting, 50)
    assert not hitting.verify()


def test_balls_that_overlap_in_the_middle_are_refused():
    def passing(distance):
        slide = turn(axis=(1.0, 0.0, 0.0), kind="slide")
        bodies = [
            point("post", -1, at(y=distance), ((0.1, 0, 0), (-0.1, 0, 0)), reach=0.1000001),
            point("ball", 0, STILL, ((0.0, 0.2, 0), (0.0, -0.2, 0)), 0.1, 0.2000001),
        ]
        return claim([slide], bodies, (-3.0,), (3.0,), [Entry(0, 0.0, 1.0, "balls")])

    assert passing(0.42).verify()
    assert not passing(0.399).verify()


def test_a_ball_has_to_hold_its_vertices():
    bodies = [point("cube", -1, at(x=2.0), CUBE, reach=0.8), point("ball", 0, STILL, radius=0.5)]
    proof = claim([turn()], bodies, (0.0,), (0.1,), [Entry(0, 0.0, 1.0, "balls")])
    assert not proof.verify()  # the cube's corners are 0.866 from its centre
    larger = claim([turn()], [replace(bodies[0], reach=0.8661), bodies[1]], (0.0,), (0.1,), proof.entries)
    assert larger.verify()


def test_slides_multipliers_and_offsets_move_bodies():
    def sliding(multiplier, offset, wall):
        slide = turn(axis=(0.0, 1.0, 0.0), kind="slide", multiplier=multiplier, offset=offset)
        return claim([slide], [point("wall", -1, at(y=wall)), point("tip", 0)], (0.0,), (1.0,), [plane()])

    assert sliding(2.0, 0.5, 2.501).verify()
    assert not sliding(2.0, 0.5, 2.499).verify()
    assert not sliding(-2.0, 0.5, 0.499).verify()


def test_quaternions_go_by_slerp_about_their_axis():
    free = Joint("base", "free", -1, STILL, (0.0, 0.0, 0.0), tuple(range(7)), (1.0,) * 7, (0.0,) * 7)
    half = 0.3
    start = (0.0, 0.0, 0.0, 0.0, 0.0, -np.sin(half / 2), np.cos(half / 2))
    end = (0.0, 0.0, 0.0, 0.0, 0.0, np.sin(half / 2), np.cos(half / 2))
    for wall, holds in ((1 + 1e-4, True), (1 - 1e-6, False)):
        bodies = [point("wall", -1, at(y=wall)), point("tip", 0, at(y=1.0))]
        assert bool(claim([free], bodies, start, end, [plane()]).verify()) == holds
        negative = tuple(-x if k > 2 else x for k, x in enumerate(end))  # the same turn, the short way all the same
        assert bool(claim([free], bodies, start, negative, [plane()]).verify()) == holds


def test_planar_joints_go_along_a_circle():
    planar = Joint("base", "planar", -1, STILL, (0.0, 0.0, 0.0), tuple(range(4)), (1.0,) * 4, (0.0,) * 4)
    a, radius = 0.5, 2.0  # along an arc about the origin, whose top is at y = radius
    start = (radius * np.sin(-a), radius * np.cos(a), np.cos(a), np.sin(a))
    end = (radius * np.sin(a), radius * np.cos(a), np.cos(a), -np.sin(a))
    for wall, holds in ((radius + 1e-3, True), (radius - 1e-6, False)):
        bodies = [point("wall", -1, at(y=wall)), point("tip", 0)]
        assert bool(claim([planar], bodies, start, end, [plane()]).verify()) == holds


def test_half_turns_have_no_short_way():
    circle = Joint("c", "circle", -1, STILL, (0.0, 0.0, 1.0), (0, 1), (1.0, 1.0), (0.0, 0.0))
    bodies = [point("wall", -1, at(y=3.0)), point("tip", 0, at(y=1.0))]
    found = claim([circle], bodies, (1.0, 0.0), (-1.0, 0.0), [plane()]).verify()
    assert not found
    assert "half a turn" in found.fault
    ball = Joint("b", "ball", -1, STILL, (0.0, 0.0, 0.0), (0, 1, 2, 3), (1.0,) * 4, (0.0,) * 4)
    found = claim([ball], bodies, (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 0.0), [plane()]).verify()
    assert not found
    assert "half a turn" in found.fault


def test_placements_off_rigid_cost_what_they_may_be_off():
    # The direction stands on the arm, and the wall is seen from it through placements that are off by 5e-7.
    off = tuple(x * (1 + 2e-7) if k % 4 < 3 else x for k, x in enumerate(STILL))
    for stretch, holds in ((STILL, True), (off, False)):
        joint = replace(turn(), placement=stretch)
        bodies = [point("wall", -1, at(y=100.0)), point("tip", 0, at(y=100.0 - 3e-5))]
        assert bool(claim([joint], bodies, (0.0,), (1e-9,), [plane((0, 1, 0), 0)]).verify()) == holds


def test_lengths_in_frames_off_rigid_are_stretched():
    # Both bodies hang on a joint whose placement shrinks them by 2e-7: in the joint's frame they are 0.1 mm further
    # apart than their radii, in the world 0.1 mm nearer.
    small = tuple(x * (1 - 2e-7) if k % 4 < 3 else x for k, x in enumerate(STILL))
    for placement, holds in ((STILL, True), (small, False)):
        bodies = [point("a", 0, at(y=1000.0001), radius=500.0), point("b", 0, radius=500.0)]
        joint = replace(turn(), placement=placement)
        assert bool(claim([joint], bodies, (0.0,), (1e-3,), [plane((0, 1, 0), 0)]).verify()) == holds


def test_axes_off_unit_length_cost_what_they_may_be_off():
    # Half a turn about an axis that is too long by 5e-7 stretches along it by 2e-6: at 1 km the tip is in the wall.
    for length, holds in ((1.0, True), (1 + 5e-7, False)):
        bodies = [point("wall", -1, at(z=1000.0)), point("tip", 0, at(z=999.999))]
        joint = turn(axis=(0.0, 0.0, length))
        assert bool(claim([joint], bodies, (3.0,), (3.1,), [plane((0, 0, 1), 0)]).verify()) == holds


def test_the_defect_of_a_tree_holds_for_every_chain():
    off = tuple(x * (1 + 2e-7) if k % 4 < 3 else x for k, x in enumerate(STILL))
    joints, links = [turn(), replace(turn(0, column=1), placement=off)], (Link("l", 1, off), Link("w", -1, off))
    proof = claim(joints, [point("a", -1), point("b", 0)], (0.0, 0.0), (0.1, 0.1), [], links=links)
    chains = Chains(proof.model, proof.motion)
    turned = proof_oracle.link_poses(proof.model, (0.3, 0.4))[0][:3, :3]
    assert chains.defect >= np.linalg.norm(turned.T @ turned - np.eye(3), 2)


def test_both_halves_of_an_interval_are_looked_at():
    # The swing is nearest to the wall at a quarter, or at three quarters, of its way, where it goes through.
    for start, end in ((-0.9, 0.3), (-0.3, 0.9)):
        bodies = [point("wall", -1, at(y=1 - 1e-6)), point("tip", 0, at(y=1.0))]
        assert not claim([turn()], bodies, (start,), (end,), [plane()]).verify()
        slide = turn(axis=(1.0, 0.0, 0.0), kind="slide")
        bodies = [point("post", -1, at(y=0.1), radius=0.06), point("ball", 0, radius=0.05)]
        balls = [Entry(0, 0.0, 1.0, "balls")]
        assert not claim([slide], bodies, (10 * start,), (10 * end,), balls).verify()


def test_what_is_no_number_is_not_straight():
    assert np.isnan(entries._positive(float("nan")))
    assert entries._positive(-1.0) == 0.0
    assert entries._positive(2.0) == 2.0


def test_the_width_of_an_enclosure_counts():
    points = np.array([[1.0, 2.0, 3.0], [-1.0, 0.5, -3.0]])
    seen = entries.Seen(points, np.abs(points).max(axis=0), 0, None)
    middles, widths = [0.3, -0.2, 0.1, 5.0], [0.01, 0.02, 0.03, 0.04]
    for k in range(4):
        row = arb_mat(1, 4, [arb(x, w if j == k else 0) for j, (x, w) in enumerate(zip(middles, widths, strict=True))])
        true = [p @ middles[:3] + middles[3] - widths[k] * abs([*p, 1.0][k]) for p in points]
        assert entries.lowest(seen, row) <= min(true) + 1e-15


@pytest.mark.parametrize("seed", range(4))
def test_bending_seen_from_another_branch_is_the_second_derivative(seed):
    generator = np.random.default_rng(seed)
    joints = [
        turn(k, at(*generator.uniform(-1, 1, 3)), axis=tuple(np.eye(3)[k % 3].tolist()), column=j)
        for j, k in enumerate((-1, 0, 1, 0, 3))
    ]
    bodies = [point("a", 2, at(0.3, 0.2), CUBE), point("b", 4, at(0.1, -0.3), CUBE)]
    ends = generator.uniform(-1, 1, (2, 5)).tolist()
    checker = entries.EntryChecker(claim(joints, bodies, *ends, [plane((1, 2, 3), 2)]))
    step, t = 2.0**-12, 0.5
    for frame in (2, 1, 4):
        direction = checker._direction(frame, (1.0, 2.0, 3.0))
        for seen in checker._seen:
            rows = [row_of(checker._row(seen, direction, t + d)) for d in (-step, 0.0, step)]
            second = (rows[2] - 2 * rows[1] + rows[0]) / step**2
            bending = checker._bending(seen, direction, (t - step, t + step))
            assert np.abs(row_of(bending) - second).max() < 1e-4 * (1 + np.abs(second).max())


def row_of(matrix):
    return np.array([float(x) for x in matrix.entries()])


@pytest.mark.parametrize("kind", sorted(JOINT_VALUES))
def test_held_joints_stand_where_they_are_held(kind):
    values = {
        "turn": (0.7,),
        "slide": (0.4,),
        "circle": (0.6, 0.8),
        "planar": (0.3, -0.2, 0.6, -0.8),
        "ball": (0.5, -0.5, 0.5, 0.5),
        "free": (0.1, 0.2, 0.3, 0.1, 0.7, 0.1, 0.7),
    }[kind]
    axis = (0.6, 0.0, 0.8) if kind in ("turn", "slide", "circle") else (0.0, 0.0, 0.0)
    joint = Joint("h", kind, 0, at(0.1, 0.2, 0.3), axis, (-1,) * len(values), (0.0,) * len(values), values)
    proof = claim([turn(), joint], [point("a", -1), point("b", 1)], (0.2,), (0.4,), [])
    pose = middle(Chains(proof.model, proof.motion).at(0.5, -1, 1))
    assert np.abs(pose - proof_oracle.link_poses(proof.model, (0.3,))[1]).max() < 1e-15


@pytest.mark.parametrize("kind", ["circle", "planar", "ball", "free"])
def test_numbers_off_unit_length_are_normalised(kind):
    count = JOINT_VALUES[kind]
    joint = Joint("j", kind, -1, STILL, (0.0, 0.0, 1.0), tuple(range(count)), (1.0,) * count, (0.0,) * count)
    unit = np.array([0.6, 0.8] if kind in ("circle", "planar") else [0.1, 0.7, 0.1, 0.7])
    start = (*(0.5,) * (count - len(unit)), *(unit * (1 + 5e-7)).tolist())
    end = (*(0.5,) * (count - len(unit)), *(unit[::-1] * (1 - 5e-7)).tolist())
    proof = claim([joint], [point("a", -1), point("b", 0)], start, end, [])
    for t in (0.0, 0.4, 1.0):
        turned = middle(Chains(proof.model, proof.motion).at(t, -1, 0))[:3, :3]
        assert np.abs(turned.T @ turned - np.eye(3)).max() < 1e-15


def exact(x):
    """A ball without a radius as mpmath's number."""
    mantissa, exponent = x.man_exp()
    return mpmath.ldexp(int(mantissa), int(exponent))


def test_series_of_small_turns():
    for x in (0.0, 1e-200, 1e-9, 1e-3, 0.1, 0.249999):
        with mpmath.workdps(60):
            square = mpmath.mpf(x) ** 2
            half = mpmath.mpf(x) / 2
            cotangent = (1 - half * mpmath.cot(half)) / square if x > 1e-30 else mpmath.mpf(1) / 12
            arctangent = mpmath.atan(x) / x if x > 1e-30 else mpmath.mpf(1)
            for found, true in (
                (joint_motions._cotangent(arb(x) ** 2), cotangent),
                (joint_motions._arctangent(arb(x)), arctangent),
            ):
                low, high = (exact(x) for x in (found.lower().mid(), found.upper().mid()))
                assert low - mpmath.mpf(10) ** -25 <= true <= high + mpmath.mpf(10) ** -25
                assert high - low < 1e-14


# ----- tables and intervals


def swinging():
    """A proof with two pairs, each proved by several entries."""
    bodies = [point("wall", -1, at(y=1.1)), point("tip", 0, at(y=1.0)), point("floor", -1, at(y=-1.1))]
    times = (0.0, 0.25, 0.625, 1.0)
    entries = [plane(start=a, end=b) for a, b in pairwise(times)]
    entries += [plane((0, 1, 0), start=a, end=b, pair=1) for a, b in pairwise(times)]
    return claim([turn()], bodies, (-0.3,), (0.3,), entries, pairs=((0, 1), (1, 2)))


def test_intervals_have_to_tile():
    proof = swinging()
    assert proof.verify()
    for k, entry in enumerate(proof.entries):
        for name in ("start", "end"):
            for value in (np.nextafter(getattr(entry, name), x) for x in (-1, 2)):
                entries = list(proof.entries)
                entries[k] = replace(entry, **{name: float(value)})
                assert not replace(proof, entries=tuple(entries)).verify(), (k, name, value)
        assert not replace(proof, entries=proof.entries[:k] + proof.entries[k + 1 :]).verify()
        assert not replace(proof, entries=(*proof.entries[: k + 1], entry, *proof.entries[k + 1 :])).verify()
    assert not replace(proof, entries=proof.entries[:3]).verify()
    assert not replace(proof, entries=()).verify()
    assert replace(proof, entries=proof.entries[3:] + proof.entries[:3]).verify()


def test_intervals_go_forward():
    bodies = [point("wall", -1, at(y=1.1)), point("tip", 0, at(y=1.0))]
    times = (0.0, 0.6, 0.4, 1.0)
    back = claim([turn()], bodies, (-0.3,), (0.3,), [plane(start=a, end=b) for a, b in pairwise(times)])
    assert not back.verify()


def test_pairs_of_the_table_can_not_be_left_out_or_doubled():
    proof = swinging()
    for pairs in (((0, 1),), ((0, 1), (1, 1)), ((0, 1), (1, 3)), ((0, 1), (-1, 2)), ((0, 1), (0, 2))):
        assert not replace(proof, model=replace(proof.model, pairs=pairs)).verify()
    for pairs in (((0, 1), (1, 1)), ((0, 1), (1, 3)), ((0, 1), (-1, 2)), ((0, 1), (1, 2), (0, 2))):
        assert not sealed(proof, model=replace(proof.model, pairs=pairs)).verify(), pairs


MALFORMED = [
    ("joints", "parent", 0),
    ("joints", "parent", -2),
    ("joints", "kind", "twist"),
    ("joints", "columns", (1,)),
    ("joints", "columns", (-2,)),
    ("joints", "columns", (0, 0)),
    ("joints", "axis", (0.0, 0.0, 1.1)),
    ("joints", "axis", (0.0, 0.0)),
    ("joints", "axis", (0.0, 0.0, float("nan"))),
    ("joints", "multipliers", (float("inf"),)),
    ("joints", "offsets", ()),
    ("joints", "placement", (1.1, *STILL[1:])),
    ("joints", "placement", (-1.0, *STILL[1:])),
    ("joints", "placement", STILL[:11]),
    ("links", "joint", 1),
    ("links", "joint", -2),
    ("links", "placement", (float("nan"), *STILL[1:])),
    ("bodies", "link", 1),
    ("bodies", "link", -2),
    ("bodies", "radius", -1e-3),
    ("bodies", "padding", 1e-3),
    ("bodies", "padding", -1e-3),
    ("bodies", "reach", -1.0),
    ("bodies", "centre", (0.0,)),
    ("bodies", "pose", (1.0, 0.0)),
    ("bodies", "vertices", np.zeros((0, 3))),
    ("bodies", "vertices", np.zeros((3, 2))),
    ("bodies", "vertices", np.zeros(3)),
    ("bodies", "vertices", np.array([[0.0, np.nan, 0.0]])),
]


@pytest.mark.parametrize(("part", "name", "value"), MALFORMED)
def test_malformed_models_are_refused_whatever_their_hashes(part, name, value):
    proof = swinging()
    items = list(getattr(proof.model, part))
    items[0] = replace(items[0], **{name: value})
    found = sealed(proof, model=replace(proof.model, **{part: tuple(items)})).verify()
    assert not found
    assert "content hash" not in found.fault


def test_malformed_motions_are_refused():
    proof = swinging()
    for values in ((float("nan"),), (float("inf"),), (), (0.1, 0.2), (1e16,)):
        for name in ("start", "end", "asked_end"):
            assert not replace(proof, motion=replace(proof.motion, **{name: values})).verify()
    for margin in (-1e-9, float("nan"), float("inf")):
        assert not replace(proof, margin=margin).verify()
    for direction in ((float("nan"), 1.0, 0.0), (0.0, float("inf"), 0.0), (0.0, 1.0), (1e300, 1e300, 0.0)):
        entries = (replace(proof.entries[0], direction=direction), *proof.entries[1:])
        assert not replace(proof, entries=entries).verify()
    for change in ({"frame": 1}, {"frame": -2}, {"pair": 2}, {"pair": -1}, {"by": "magic"}):
        assert not replace(proof, entries=(replace(proof.entries[0], **change), *proof.entries[1:])).verify()
    assert not replace(proof, motion=replace(proof.motion, asked_end=(0.3 + 2 * np.pi,))).verify()


def test_numbers_that_are_not_known_prove_nothing():
    # Products beyond the range of doubles: neither infinity nor what is no number may pass as "apart".
    huge = at(x=1e15, y=1e15)
    joints = [turn(k - 1, huge, column=0) for k in range(8)]
    bodies = [point("wall", -1, at(y=1.0)), point("tip", 7, huge, CUBE * 1e15)]
    found = claim(joints, bodies, (0.0,), (1e15,), [plane((1e15, 1e15, 0))]).verify()
    assert not found


def test_whole_turns_need_joints_that_a_whole_turn_does_not_change():
    bodies = [point("wall", -1, at(y=1.1)), point("tip", 0, at(y=1.0))]
    asked = (0.3 + 2 * np.pi,)
    assert claim([turn()], bodies, (-0.3,), (0.3,), [plane()], asked=asked, whole=(0,)).verify()
    assert not claim([turn(multiplier=0.5)], bodies, (-0.3,), (0.3,), [plane()], asked=asked, whole=(0,)).verify()
    slide = turn(kind="slide", axis=(1.0, 0.0, 0.0))
    assert not claim([slide], bodies, (-0.3,), (0.3,), [plane()], asked=asked, whole=(0,)).verify()
    assert not claim([turn()], bodies, (-3.2,), (3.2,), [plane()], asked=(3.2,), whole=(0,)).verify()


# ----- proofs by certifiers that are wrong


def forged(checker, q0, q1, planes, monkeypatch):
    """The proof that the package builds if its certifier says that a motion is free."""
    builder = Builder(checker)
    monkeypatch.setattr(builder, "_passage", lambda *arguments: Passage(True, 1.0, -1.0, -1, planes))
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


# ----- one number changed


def pool():
    """Proofs of small robots: trees with all kinds of joints, a Panda among a few obstacles."""
    import tempfile
    from pathlib import Path

    out = []
    for seed in range(8):
        generator = np.random.default_rng(300 + seed)
        with tempfile.TemporaryDirectory() as folder:
            robot = pc.Robot.from_urdf(random_tree(generator, Path(folder), links=5), floating=seed % 4 == 1)
        if seed % 2:
            leaders = [name for name in robot.joint_names if name not in robot.mimics]
            robot = robot.with_group(leaders)
        checker = pc.Checker(robot, scattered(generator, 2, 0.8))
        out += [proof for proof in checker.certify_motions(*free_motions(checker, 2, seed)) if proof is not None]
    return out


@pytest.fixture(scope="module")
def proofs():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = pool()
    assert len(found) >= 8
    assert all(proof.verify() for proof in found)
    return found


def changed_model(proof, generator, amount):
    """A proof with one number of its model changed by an amount, None if there is nothing to change."""
    part = generator.choice(["joints", "links", "bodies"])
    items = list(getattr(proof.model, part))
    k = int(generator.integers(len(items)))
    names = {
        "joints": ["placement", "axis", "multipliers", "offsets"],
        "links": ["placement"],
        "bodies": ["pose", "vertices", "radius", "centre", "reach"],
    }
    name = str(generator.choice(names[part]))
    value = getattr(items[k], name)
    if isinstance(value, float):
        new = value + amount
    elif isinstance(value, np.ndarray):
        new = value.copy()
        new[tuple(generator.integers(0, new.shape))] += amount
    else:
        j = int(generator.integers(len(value)))
        new = tuple(x + amount if i == j else x for i, x in enumerate(value))
    items[k] = replace(items[k], **{name: new})
    return replace(proof, model=replace(proof.model, **{part: tuple(items)}))


def changed_rest(proof, generator, amount):
    """A proof with one number of the motion or of an entry changed."""
    place = generator.choice(["start", "end", "margin", "direction", "direction", "frame"])
    if place == "margin":
        return replace(proof, margin=proof.margin + abs(amount))
    if place in ("start", "end"):
        j = int(generator.integers(proof.model.columns))
        q = tuple(x + amount if i == j else x for i, x in enumerate(getattr(proof.motion, place)))
        motion = replace(proof.motion, **{place: q})
        return replace(proof, motion=replace(motion, asked_end=motion.end))
    entries = list(proof.entries)
    planes = [k for k, entry in enumerate(entries) if entry.by == "plane"]
    if not planes:
        return proof
    k = int(generator.choice(planes))
    if place == "frame":
        entries[k] = replace(entries[k], frame=int(generator.integers(-1, len(proof.model.links))))
    else:
        j = int(generator.integers(3))
        direction = tuple(x + amount if i == j else x for i, x in enumerate(entries[k].direction))
        entries[k] = replace(entries[k], direction=direction)
    return replace(proof, entries=tuple(entries))


def changed_entries(proof, wrong):
    """Indices of the entries whose claims differ: all, if not just an entry is another."""
    if proof.hashes != wrong.hashes or proof.motion != wrong.motion or proof.margin != wrong.margin:
        return range(len(proof.entries))
    return [k for k, (a, b) in enumerate(zip(proof.entries, wrong.entries, strict=True)) if a != b]


def test_proofs_with_one_number_changed_beyond_its_slack_are_refused(proofs):
    """A change is beyond the slack where a sampled state contradicts the claim.

    Numbers with slack are directions, ends, placements, shapes: a gap is mostly larger than the margin, so a small
    change leaves a true claim, of another motion or body, which may pass. What the hashes hold has none: see below.
    """
    generator = np.random.default_rng(5)
    refused = 0
    for _ in range(50 * CHANGES):
        if refused >= CHANGES:
            break
        proof = proofs[int(generator.integers(len(proofs)))]
        change = (changed_model, changed_rest)[int(generator.integers(2))]
        seed = int(generator.integers(2**31))
        sign = float(generator.choice([-1, 1]))
        amount = sign * 10.0 ** generator.uniform(-4, 1)
        wrong = change(proof, np.random.default_rng(seed), amount)
        wrong = replace(wrong, hashes=hashes_of(wrong.model))
        if proof_oracle.is_false(wrong, only=changed_entries(proof, wrong)):
            found = wrong.verify()
            assert not found, (change.__name__, seed, amount)
            assert found.fault
            refused += 1
    assert refused >= CHANGES


def test_any_bit_of_the_model_is_held_by_its_hashes(proofs):
    generator = np.random.default_rng(6)
    for _ in range(CHANGES):
        proof = proofs[int(generator.integers(len(proofs)))]
        wrong = changed_model(proof, generator, 1e-16 * float(generator.choice([-1, 1])))
        if hashes_of(wrong.model) != proof.hashes:
            found = wrong.verify()
            assert not found
    model = replace(proof.model, bodies=(replace(proof.model.bodies[0], name="other"), *proof.model.bodies[1:]))
    assert "content hash" in replace(proof, model=model).verify().fault
