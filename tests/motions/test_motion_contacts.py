"""Contact by construction: choose the robot, the motion and a parameter, and put a body of a millimetre where the other
one is then. The motion must be refused, however the two get there."""

from __future__ import annotations

import contextlib
import warnings
from dataclasses import replace
from itertools import pairwise

import mpmath
import numpy as np
import pinocchio as pin
import pytest
from random_branches import Joint, Tree, random_tree, tips

import plannercheck as pc
from plannercheck.motions.rounding_bounds import RoundingBounds
from plannercheck.ompl.joint_space import JointSpace

# Half edges of the bodies that meet, m: no slack of balls and boxes hides a fault.
HALF = 5e-4

# Axes of joints that move in the plane.
FLAT = {"revolute": (0, 0, 1), "prismatic": (1, 0, 0)}


def robot_of(tree, tmp_path):
    path = tmp_path / "tree.urdf"
    path.write_text(tree.urdf())
    return pc.Robot.from_urdf(path).with_group(tree.group)


def centre_in(pose, point):
    return pose[:3, :3].T @ (point - pose[:3, 3])


def meeting(tree, first, second, q0, q1, t, rng, reach):
    """The tree with a body on each link so that they meet at t, and where: (tree, point in the world)."""
    poses = tree.poses(q0, q1, t)
    own = rng.uniform(-reach, reach, 3)
    point = poses[first][:3, :3] @ own + poses[first][:3, 3]
    other = centre_in(poses[second], point + rng.uniform(-0.3, 0.3, 3) * HALF)
    return tree.with_body(first, HALF, own).with_body(second, HALF, other), point


def far_joint(kind, parent, child, x=0.0):
    return Joint(kind, parent, child, (x, 0, 0), (0, 0, 0), (0, 0, 1))


# ----- fault 2: planar and floating joints from the child's side


@pytest.mark.parametrize("kind", ["planar", "floating"])
def test_a_joint_that_is_no_root_is_bounded_from_both_sides(kind, tmp_path):
    """A turn of 0.6 rad at x = 5 m against a body that hangs on the root: seen from the child, its arm is 5 m."""
    joints = far_joint(kind, "base", "a0"), far_joint("revolute", "a0", "a1"), far_joint("revolute", "base", "b0")
    tree, half = Tree(joints), np.sin(0.15)
    turned = [[5, 0, np.cos(0.3), s * np.sin(0.3)] for s in (-1, 1)]
    if kind == "floating":
        turned = [[5, 0, 0, 0, 0, s * half, np.cos(0.15)] for s in (-1, 1)]
    q0, q1 = (np.array([*numbers, 0.0, 0.0]) for numbers in turned)
    poses = tree.poses(q0, q1, 0.5)
    tree = tree.with_body("a1", 0.02, centre_in(poses["a1"], np.zeros(3))).with_body("b0", 0.02, np.zeros(3))
    checker = pc.Checker(robot_of(tree, tmp_path))
    assert checker.check_states(np.array([q0, q1])).all()
    assert not checker.check_motion(q0, q1)


@pytest.mark.parametrize("seed", range(12))
def test_bodies_that_meet_are_never_passed(seed, tmp_path):
    rng = np.random.default_rng(seed)
    for k in range(25):
        tree = random_tree(rng, reach=rng.choice([0.05, 0.5]))
        q0, q1 = tree.motion(rng, far=rng.choice([0.2, 5.0]), way=rng.choice([0.3, 1.5]))
        t = rng.uniform(0.02, 0.98)
        made, _ = meeting(tree, *tips(tree), q0, q1, t, rng, reach=rng.choice([0.01, 0.5]))
        checker = pc.Checker(robot_of(made, tmp_path))
        assert len(checker.pairs) == 1
        assert not checker.check_motion(q0, q1), (seed, k)


def obstacle_at(point, half, rotation=None):
    scene, pose = pc.Scene(), np.eye(4)
    pose[:3, 3] = point
    if rotation is not None:
        pose[:3, :3] = rotation
    scene.add_box("met", [2 * half] * 3, pose)
    return scene


@pytest.mark.parametrize("seed", range(8))
def test_obstacles_that_are_met_are_never_passed(seed, tmp_path):
    """Also with poses that are off rigid by what is accepted, and bodies of half a metre."""
    rng = np.random.default_rng(100 + seed)
    for k in range(25):
        tree = random_tree(rng, reach=rng.choice([0.05, 0.5]))
        q0, q1 = tree.motion(rng, far=rng.choice([0.2, 5.0]), way=rng.choice([0.3, 1.5]))
        t, first = rng.uniform(0.02, 0.98), tips(tree)[rng.integers(2)]
        own = rng.uniform(-0.5, 0.5, 3) * rng.choice([0.01, 1])
        half = rng.choice([HALF, 0.2])
        pose = tree.poses(q0, q1, t)[first]
        corner = own + half * rng.choice([-1, 1], 3) * (1 - 1e-3 * HALF / half)
        point = pose[:3, :3] @ corner + pose[:3, 3]
        stretch = np.eye(3) + np.diag(rng.choice([-2.8e-7, 2.8e-7], 3))
        scene = obstacle_at(point + rng.uniform(-0.9, 0.9, 3) * HALF, HALF, stretch)
        checker = pc.Checker(robot_of(tree.with_body(first, half, own), tmp_path), scene, self_collision=False)
        assert len(checker.pairs) == 1
        assert not checker.check_motion(q0, q1), (seed, k)


@pytest.mark.parametrize("seed", range(6))
def test_held_joints_do_not_let_bodies_pass(seed, tmp_path):
    """Some joints of the robot are held where they are at the start, in any position of the tree."""
    rng = np.random.default_rng(200 + seed)
    judged = 0
    while judged < 20:
        tree = random_tree(rng, mimics=False)
        free = [joint.name for joint in tree.joints if rng.random() < 0.6]
        q0, q1 = tree.motion(rng, far=2.0)
        columns = np.cumsum([0, *(joint.numbers for joint in tree.joints)])
        parts = [slice(a, b) for a, b in pairwise(columns.tolist())]
        for joint, part in zip(tree.joints, parts, strict=True):
            q1[part] = q1[part] if joint.name in free else q0[part]
        if not free:
            continue
        t = rng.uniform(0.02, 0.98)
        made, _ = meeting(tree, *tips(tree), q0, q1, t, rng, reach=0.1)
        held = {
            joint.name: q0[part].tolist() if joint.numbers > 1 else float(q0[part][0])
            for joint, part in zip(tree.joints, parts, strict=True)
            if joint.name not in free
        }
        robot = robot_of(made, tmp_path).with_group(free).holding(held)
        taken = np.concatenate(
            [np.arange(p.start, p.stop) for j, p in zip(tree.joints, parts, strict=True) if j.name in free]
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # two bodies that rest may touch
            checker = pc.Checker(robot)
        assert not checker.check_motion(q0[taken], q1[taken])
        judged += 1


def assert_met(robot, tree, link, q0, q1, rng, count=25):
    """A body of a millimetre on a link is refused motions that lead it against obstacles, at many parameters."""
    for t in rng.uniform(0.02, 0.98, count):
        pose = tree.poses(q0, q1, t)[link]
        point = pose[:3, :3] @ tree.bodies[link][1] + pose[:3, 3] + rng.uniform(-0.9, 0.9, 3) * HALF
        checker = pc.Checker(robot, obstacle_at(point, HALF), self_collision=False)
        assert not checker.check_motion(q0, q1)


def test_extents_hold_all_the_way(tmp_path):
    """What slides before, after and beside the start lengthens the arm of the joint that turns it."""
    rng = np.random.default_rng(5)
    turn, slide = far_joint("revolute", "base", "a0"), far_joint("prismatic", "a0", "a1")
    slide = replace(slide, axis=(1, 0, 0))
    joints = {
        "slides out": (turn, slide),
        "screws out": (turn, far_joint("planar", "a0", "a1")),
        "follows far off": (turn, replace(slide, mimic=(turn.name, 0.1, 3.0))),
    }
    motions = {
        "slides out": ([0, 0], [3, 1]),
        "screws out": ([0, 0, 0, 1, 0], [3, 1, 0, np.cos(0.1), np.sin(0.1)]),
        "follows far off": ([0], [1]),
    }
    for name, used in joints.items():
        tree = Tree(used).with_body("a1", HALF, np.zeros(3))
        q0, q1 = (np.array(q, dtype=float) for q in motions[name])
        assert_met(robot_of(tree, tmp_path), tree, "a1", q0, q1, rng)


@pytest.mark.parametrize("kinds", [("revolute", "revolute"), ("revolute", "prismatic"), ("prismatic", "revolute")])
def test_curvature_is_no_less_than_what_it_is(kinds, tmp_path):
    """Of two turns about one axis, and of a slide on what turns, the bound is sharp."""
    rng = np.random.default_rng(6)
    first, second = far_joint(kinds[0], "base", "a0"), far_joint(kinds[1], "a0", "a1")
    tree = Tree((replace(first, axis=FLAT[kinds[0]]), replace(second, axis=FLAT[kinds[1]])))
    tree = tree.with_body("a1", HALF, np.array([1.0 if kinds[1] == "revolute" else 0.0, 0, 0]))
    robot = robot_of(tree, tmp_path)
    ways = {"revolute": (-0.5, 0.5), "prismatic": (-2.0, 2.0)}
    q0, q1 = (np.array([ways[kind][k] for kind in kinds]) for k in range(2))
    assert_met(robot, tree, "a1", q0, q1, rng, count=60)


def test_directions_are_of_length_one(tmp_path):
    tree = Tree((far_joint("revolute", "base", "a0"),)).with_body("a0", 0.1, np.array([1.0, 0, 0]))
    scene = obstacle_at([3, 0, 0], 0.1, np.eye(3) * (1 + 2.8e-7))
    verdict = pc.Checker(robot_of(tree, tmp_path), scene).explain_motion([0.0], [1.0], proofs=True)
    assert verdict.proofs
    assert all(abs(np.linalg.norm(proof.normal) - 1) < 1e-12 for proof in verdict.proofs)


def test_ways_between_spheres_are_not_shortened(tmp_path):
    """Small spheres that pass through each other far from both ends of an interval, on slides."""
    joints = [Joint("prismatic", "base", f"{branch}0", (0, 0, 0), (0, 0, 0), (1, 0, 0)) for branch in "ab"]
    tree = Tree(tuple(joints)).with_body("a0", 1e-3, np.zeros(3)).with_body("b0", 1e-3, np.array([0, 1.9e-3, 0]))
    checker = pc.Checker(robot_of(tree, tmp_path))
    rng = np.random.default_rng(3)
    for way in 10 ** rng.uniform(-2, 1, 40):
        a, b = rng.uniform(0.2, 0.8, 2) * way
        assert not checker.check_motion([-a, b], [way - a, b - way])


@pytest.mark.parametrize("where", [1, -2])
def test_every_sampled_state_counts(where, tmp_path):
    """An obstacle as small as the body meets it at the second or at the last but one of the states alone."""
    joint = Joint("prismatic", "base", "a0", (0, 0, 0), (0, 0, 0), (1, 0, 0))
    robot = robot_of(Tree((joint,)).with_body("a0", 1e-3, np.zeros(3)), tmp_path)
    for count in (*range(3, 40), 64, 100):
        parameters = np.arange(count + 1) / count
        scene = obstacle_at([parameters[where], 0, 0], 1e-3)
        checker = pc.Checker(robot, scene)
        steps = int(checker.motion_sampler.steps(np.array([[0.0]]), np.array([[1.0]]), 1 / count * (1 + 1e-9))[0])
        assert steps == count
        assert not checker.check_motion([0.0], [1.0], resolution=1 / count * (1 + 1e-9))


# ----- fault 3: joints that whole turns do not bring back


def led(follower, multiplier, offset=0.3):
    """A continuous joint and one that follows it, each with a link."""
    lead = Joint("continuous", "base", "a0", (0, 0, 0), (0.3, -0.2, 1), (0, 0, 1))
    mimic = (lead.name, multiplier, offset)
    return Tree((lead, Joint(follower, "a0", "a1", (0.4, 0, 0), (1, 0.2, 0), (0, 0.6, 0.8), mimic)))


FOLLOWERS = [
    ("continuous", 0.5),
    ("continuous", 2.0),
    ("continuous", -1.0),
    ("continuous", 1.5),
    ("prismatic", 0.1),
    ("prismatic", 1.0),
    ("revolute", 1.0),
]


@pytest.mark.parametrize(("follower", "multiplier"), FOLLOWERS)
def test_ompl_interpolates_what_is_judged(follower, multiplier, tmp_path):
    tree = led(follower, multiplier).with_body("a1", 0.01, np.array([0.2, 0.1, 0]))
    checker = pc.Checker(robot_of(tree, tmp_path))
    setup = pc.ompl.setup(checker)
    information, space = setup.getSpaceInformation(), JointSpace(checker.robot)
    assert space.continuous.tolist() == [follower == "continuous" and multiplier in (2.0, -1.0)]
    between = information.allocState()
    rng = np.random.default_rng(1)
    for start, end in rng.uniform(-np.pi, np.pi, (40, 2)):
        states = space.state(information, [start]), space.state(information, [end])
        _, (judged,) = checker._motion_ends(np.array([[start]]), np.array([[end]]))
        for t in (0.0, 0.3, 0.8, 1.0):
            information.getStateSpace().interpolate(*states, t, between)
            ours = checker.motion_certifier.states(np.array([start]), judged, np.array([t]))
            theirs = np.array([space.read(between)])
            expected = tree.poses(np.array([start]), np.array([end]), t)["a1"]
            for q in (ours, theirs):
                found = checker.robot.link_poses(q)[0, checker.robot.link_index("a1")]
                assert np.abs(found - expected).max() < 1e-12


@pytest.mark.parametrize(("follower", "multiplier"), FOLLOWERS)
def test_planners_are_refused_motions_that_meet_something(follower, multiplier, tmp_path):
    tree = led(follower, multiplier)
    rng = np.random.default_rng(2)
    for start, end in rng.uniform(-np.pi, np.pi, (20, 2)):
        q0, q1, t = np.array([start]), np.array([end]), rng.uniform(0.05, 0.95)
        own = rng.uniform(-0.3, 0.3, 3)
        made = tree.with_body("a1", HALF, own)
        pose = tree.poses(q0, q1, t)["a1"]
        obstacle = np.eye(4)
        obstacle[:3, 3] = pose[:3, :3] @ own + pose[:3, 3]
        scene = pc.Scene()
        scene.add_box("met", [2 * HALF] * 3, obstacle)
        checker = pc.Checker(robot_of(made, tmp_path), scene)
        information, space = pc.ompl.setup(checker).getSpaceInformation(), JointSpace(checker.robot)
        states = space.state(information, q0), space.state(information, q1)
        assert not checker.check_motion(q0, q1)
        assert not information.checkMotion(*states)
        assert not information.getMotionValidator().checkMotionWithLastValid(*states)[0]
        sampled = pc.ompl.setup(checker, 1e-4).getSpaceInformation()
        assert not sampled.checkMotion(*states)


def test_the_space_holds_start_and_goal_of_an_angle_that_counts_its_turns(tmp_path):
    robot = robot_of(led("continuous", 0.5).with_body("a1", 0.01, np.zeros(3)), tmp_path)
    checker = pc.Checker(robot)
    plan = pc.ompl.plan(checker, [-20.0], [9.0], seed=1)
    assert plan.solved
    assert plan.path[[0, -1], 0].tolist() == [-20.0, 9.0]
    assert plan.length == pytest.approx(29, abs=1e-9)
    space = JointSpace(robot)
    assert space.ompl_space().getBounds().high[0] == pytest.approx(2 * np.pi)
    information = pc.ompl.setup(checker).getSpaceInformation()
    with pytest.raises(pc.PlannercheckError, match=r"'to_a0' is 7, the space reaches from -6.28319 to 6.28319"):
        space.state(information, [7.0])


# ----- fault 4: angles far from 0


def exact_angle(angle, centre=0.0):
    """The same angle less whole turns, near a centre, by fifty digits."""
    with mpmath.workprec(300):
        turns = mpmath.nint((mpmath.mpf(angle) - centre) / (2 * mpmath.pi))
        return float(mpmath.mpf(angle) - 2 * mpmath.pi * turns)


@pytest.mark.parametrize("power", range(3, 16))
def test_motions_to_far_ends_of_continuous_joints_lead_there(power, tmp_path):
    """An obstacle of 0.2 mm at the far end, as its states are judged, and 30 m from the axis."""
    turn = Joint("continuous", "base", "a0", (0, 0, 0), (0, 0, 0), (0, 0, 1))
    tree = Tree((turn,)).with_body("a0", 1e-4, np.array([30.0, 0, 0]))
    robot = robot_of(tree, tmp_path)
    rng = np.random.default_rng(power)
    judged = 0
    for _ in range(6):
        end = rng.choice([-1, 1]) * rng.uniform(0.5, 1.0) * 10.0**power
        there = exact_angle(end)
        start = there - np.sign(there) * 0.5
        # Behind the end, so that only the last 0.1 mm of the way meets it.
        side = np.sign(there) * 1.9e-4
        obstacle = np.eye(4)
        obstacle[:3, :3] = pin.exp3(np.array([0, 0, there]))
        obstacle[:3, 3] = obstacle[:3, :3] @ [30.0, side, 0]
        scene = pc.Scene()
        scene.add_box("met", [2e-4] * 3, obstacle)
        checker = pc.Checker(robot, scene)
        assert not checker.is_valid([end])
        try:
            free = [checker.check_motion([start], [end]), *checker.check_motions([[start]] * 3, [[end]] * 3)]
        except pc.PlannercheckError:
            continue
        judged += 1
        assert not any(free)
        assert not checker.explain_motion([start], [end]).free
    assert judged >= 1


@pytest.mark.parametrize("power", [3, 6, 9, 12, 15])
@pytest.mark.parametrize("offset", [0.0, 0.7])
def test_far_ends_are_judged_as_their_states_are_posed_or_refused(power, offset, tmp_path):
    """Followers of far angles are posed with the rounding of their sums: then the pose is not the exact one."""
    turn = Joint("continuous", "base", "a0", (0, 0, 0), (0, 0, 0), (0, 0, 1))
    other = Joint("continuous", "base", "b0", (0, 0, 0), (0, 0, 0), (0, 0, 1), (turn.name, 3.0, offset))
    tree = Tree((turn, other)).with_body("b0", 1e-4, np.array([3.0, 0, 0]))
    robot = robot_of(tree, tmp_path)
    rng = np.random.default_rng(power)
    for _ in range(10):
        end = rng.uniform(0.5, 1.0) * 10.0**power
        pose = robot.link_poses([end])[robot.link_index("b0")]
        there = exact_angle(end)
        scene = pc.Scene()
        scene.add_box("met", [2e-5] * 3, pose @ pin.SE3(np.eye(3), np.array([3.0, 1.0e-4, 0])).homogeneous)
        checker = pc.Checker(robot, scene)
        assert not checker.is_valid([end])
        for start in (there - 0.2, there + 0.2):
            assert not checker.check_motion([start], [end], resolution=1e-2)
            if power <= 3:
                assert not checker.check_motion([start], [end])
            else:
                with pytest.raises(pc.PlannercheckError, match="rounding is no small part"):
                    checker.check_motion([start], [end])


def test_verdicts_of_near_motions_do_not_depend_on_far_ones_beside_them(tmp_path):
    turn = Joint("continuous", "base", "a0", (0, 0, 0), (0, 0, 0), (0, 0, 1))
    other = Joint("continuous", "a0", "a1", (0, 0, 0), (0, 0, 0), (0, 0, 1), (turn.name, 2.0, 0.3))
    robot = robot_of(Tree((turn, other)).with_body("a1", 1e-3, np.array([1.0, 0, 0])), tmp_path)
    bounds = RoundingBounds(robot)
    q0, q1 = np.array([[0.1], [0.2], [0.3]]), np.array([[0.5], [1e5], [1e4]])
    found = bounds.of_motions(q0, q1, q1)(np.arange(3))
    rows = [(q0[k : k + 1], q1[k : k + 1]) for k in range(3)]
    alone = [bounds.of_motion(start[0], end[0], end[0]) for start, end in rows]
    assert {int(k): error for error, chosen in found for k in chosen} == dict(enumerate(alone))
    assert alone[0] == bounds.usual < alone[2] < alone[1]


# ----- fault 5: quaternions off length 1, several in a chain


def stack_of_bases(tmp_path, count, kind="floating", half=0.4, x=2.0):
    """Joints of one place on top of each other, and a box of half a metre far out on the last one."""
    names = ["base", *(f"a{k}" for k in range(count))]
    joints = [Joint(kind, parent, child, (0, 0, 0), (0, 0, 0), (0, 0, 1)) for parent, child in pairwise(names)]
    return robot_of(Tree(tuple(joints)).with_body(names[-1], half, np.array([x, 0, 0])), tmp_path)


def half_turns(count, off, kind="floating"):
    """All joints turned by half a turn about z, with numbers of length 1 + off: it stretches most."""
    one = [0, 0, 0, 0, 0, 1 + off, 0] if kind == "floating" else [0, 0, -1 - off, 0]
    return np.array(one * count, dtype=float)


@pytest.mark.parametrize(
    ("count", "off"), [(1, 2e-7), (2, 1.05e-7), (6, 3.6e-8), (20, 1.0e-8), (1, -2e-7), (6, -3.6e-8)]
)
@pytest.mark.parametrize("others", [0, 80])
@pytest.mark.parametrize("depth", [1e-9, -1e-9])
def test_stretched_links_are_judged_as_they_are_posed(count, off, others, depth, tmp_path):
    """A box that touches the stretched one's face by a nanometre, alone and in batches, among few and many."""
    robot = stack_of_bases(tmp_path, count)
    q = half_turns(count, off * (1 - 1e-6))
    side = (-1) ** count
    with mpmath.workprec(200):
        length = mpmath.mpf(float(q[5]))
        face = float(mpmath.mpf(2.4) * (2 * length * length - 1) ** count)
    scene = pc.Scene()
    pose = np.eye(4)
    pose[0, 3] = side * (face + 0.5 - depth)
    scene.add_box("met", [1, 0.5, 0.5], pose)
    for k in range(others):
        pose = np.eye(4)
        pose[:3, 3] = [0.1 * k, 30, 0]
        scene.add_box(f"other{k}", [0.1] * 3, pose)
    checker = pc.Checker(robot, scene)
    expected = depth < 0
    assert checker.is_valid(q) == expected
    for n in (2, 5, 8, 17):
        assert (checker.check_states(np.tile(q, (n, 1))) == expected).all()
    assert (len(checker.explain(q).collisions) == 0) == expected


@pytest.mark.parametrize(("count", "off"), [(6, 1.99e-7), (40, 1.99e-7), (2, 1.2e-7), (2, -1.2e-7)])
def test_chains_off_length_one_beyond_what_bounds_allow_are_refused(count, off, tmp_path):
    robot = stack_of_bases(tmp_path, count)
    q = half_turns(count, off)
    message = (
        r"row 1: .*stretched, .* up to \d.*, accepted is 2.5e-06: columns 3 to 6 \(length (1.00000|0.99999).*normalise"
    )
    with pytest.raises(pc.PlannercheckError, match=message):
        pc.Checker(robot).check_states(np.array([half_turns(count, 0.0), q]))
    assert pc.Checker(robot).check_states(half_turns(count, 0.0)[None]).all()


def test_branches_do_not_share_what_they_may_be_off(tmp_path):
    joints = [Joint("floating", "base", f"a{k}", (3 * k, 0, 0), (0, 0, 0), (0, 0, 1)) for k in range(20)]
    robot = robot_of(Tree(tuple(joints)).with_body("a0", 0.1, np.zeros(3)), tmp_path)
    assert pc.Checker(robot).check_states(half_turns(20, 1.99e-7)[None]).all()


def test_pairs_of_cosine_and_sine_count_a_quarter(tmp_path):
    for count, off, fine in ((4, 1.99e-7, True), (5, 1.99e-7, False)):
        checker = pc.Checker(stack_of_bases(tmp_path, count, "planar"))
        q = half_turns(count, off, "planar")
        if fine:
            assert checker.check_states(q[None]).all()
        else:
            with pytest.raises(pc.PlannercheckError, match=r"columns 2 to 3 \(length 1.00000019"):
                checker.check_states(q[None])


def test_a_held_quaternion_off_length_one_is_refused(tmp_path):
    robot = stack_of_bases(tmp_path, 2)
    with pytest.raises(pc.PlannercheckError, match="what is held at joint 'to_a0' and before it is off rigid"):
        robot.with_group(["to_a1"]).holding({"to_a0": [0, 0, 0, 0, 0, 1 + 3e-7, 0]})
    held = robot.with_group(["to_a1"]).holding({"to_a0": [0, 0, 0, 0, 0, 1 + 1e-7, 0]})
    with pytest.raises(pc.PlannercheckError, match=r"accepted is 2\.5e-06"):
        held.check_configurations(half_turns(1, 1.5e-7))
    assert held.check_configurations(half_turns(1, 1.0e-7)).shape == (1, 7)


@pytest.mark.parametrize("t", [0.0, 1.0])
@pytest.mark.parametrize(("count", "off"), [(10, 2.1e-8), (20, 1e-8)])
def test_motions_hold_their_stretched_ends(count, off, t, tmp_path):
    """The end as it is posed touches, the same with lengths of 1 is apart."""
    robot = stack_of_bases(tmp_path, count, half=0.001, x=3.0)
    q = half_turns(count, off)
    poses = robot.link_poses(q)[robot.link_index(f"a{count - 1}")]
    tip = poses @ [3.001, 0, 0, 1]
    away = half_turns(count, 0.0)
    away[0] -= 0.5
    scene = pc.Scene()
    pose = np.eye(4)
    pose[:3, 3] = tip[:3] + np.array([0.001 - 1e-9, 0, 0])
    scene.add_box("met", [0.002] * 3, pose)
    checker = pc.Checker(robot, scene)
    assert not checker.is_valid(q)
    assert checker.is_valid(half_turns(count, 0.0))
    ends = (q, away) if t == 0 else (away, q)
    assert not checker.check_motion(*ends, tolerance=1e-3)
    assert checker.check_motion(half_turns(count, 0.0), away, tolerance=1e-8)


# ----- the plane


@pytest.mark.parametrize("power", [2, 3, 6, 9, 12, 15])
@pytest.mark.parametrize("curve", ["straight", "dubins", "reeds_shepp"])
def test_far_headings_in_the_plane_are_judged_as_they_are_posed_or_refused(power, curve):
    robot = pc.planar.Robot([[29.9999, -1e-4], [30.0001, -1e-4], [30.0001, 1e-4], [29.9999, 1e-4]])
    rng = np.random.default_rng(power)
    how = {} if curve == "straight" else {"curve": curve, "turning_radius": 1.0}
    judged = 0
    for _ in range(6):
        end = rng.choice([-1, 1]) * rng.uniform(0.5, 1.0) * 10.0**power
        there = exact_angle(end)
        scene = pc.planar.Scene()
        c, s = np.cos(there), np.sin(there)
        ahead = np.sign(there) * 1.5e-4
        centre = np.array([30 * c - ahead * s, 30 * s + ahead * c])
        square = 1e-4 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) @ np.array([[c, s], [-s, c]])
        scene.add_polygon("met", centre + square)
        checker = pc.planar.Checker(robot, scene)
        assert not checker.is_valid([0, 0, end])
        start = [0, 0, there - np.sign(there) * 0.4]
        assert not checker.check_motion(start, [0, 0, end], resolution=0.1, **how)
        try:
            free = [
                checker.check_motion(start, [0, 0, end], **how),
                checker.explain_motion(start, [0, 0, end], **how).free,
            ]
        except pc.PlannercheckError:
            continue
        judged += 1
        assert not any(free)
    assert judged or power >= 6


# A square of 2 µm, 3 m out.
PAD = [[3 - 1e-6, -1e-6], [3 + 1e-6, -1e-6], [3 + 1e-6, 1e-6], [3 - 1e-6, 1e-6]]


@pytest.mark.parametrize("power", [3, 5, 7, 9, 11, 13])
def test_far_angles_of_planar_joints_are_judged_as_they_are_posed_or_refused(power):
    """Angles along a chain are summed and rounded: far from 0 the pose is not that of the angle less whole turns."""
    links = [
        pc.planar.Link("root", PAD, joint="free"),
        pc.planar.Link("arm", PAD, "root", (0, 0, 0.7123), "revolute"),
    ]
    robot = pc.planar.Robot(links)
    rng = np.random.default_rng(power)
    for _ in range(10):
        end = rng.uniform(0.5, 1.0) * 10.0**power
        pose = robot.link_poses(np.array([[0, 0, 0.31, end]]))[0, 1]
        scene = pc.planar.Scene()
        ahead = pose[:2, :2] @ np.array([3.0, 1.999e-6]) + pose[:2, 2]
        scene.add_polygon("met", ahead + (np.array(PAD) - [3, 0]) @ pose[:2, :2].T)
        checker = pc.planar.Checker(robot, scene)
        goal = [0, 0, 0.31, end]
        if checker.is_valid(goal):
            continue
        start = [0, 0, 0.31, exact_angle(end) - 0.2]
        assert not checker.check_motion(start, goal, resolution=1e-2)
        assert not checker.check_motion(start, goal, resolution=1e-2, curve="dubins", turning_radius=1.0)
        if power <= 5:
            assert not checker.check_motion(start, goal)
        else:
            with contextlib.suppress(pc.PlannercheckError):
                assert not checker.check_motion(start, goal)
