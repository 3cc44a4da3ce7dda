"""Contact by construction: choose the robot, the motion and a parameter, and put a body of a millimetre where the other
one is then. The motion must be refused, however the two get there.

Here: links and held joints, planar and floating joints from the child's side. Far angles and stretched links have files
of their own.
"""

import warnings
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from motion_contacts import HALF, assert_met, centre_in, far_joint, meeting, obstacle_at, robot_of
from random_branches import Joint, Tree, random_tree, tips

import plannercheck as pc

CORNERS = np.array(np.meshgrid([-1.0, 1.0], [-1.0, 1.0], [-1.0, 1.0])).reshape(3, -1).T

# Axes of joints that move in the plane.
FLAT = {"revolute": (0, 0, 1), "prismatic": (1, 0, 0)}


def moving_tree(rng):
    """A random tree, small or large, and a motion of it."""
    tree = random_tree(rng, reach=rng.choice([0.05, 0.5]))
    return tree, *tree.motion(rng, far=rng.choice([0.2, 5.0]), way=rng.choice([0.3, 1.5]))


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
        tree, q0, q1 = moving_tree(rng)
        t = rng.uniform(0.02, 0.98)
        made, _ = meeting(tree, *tips(tree), q0, q1, t, rng, reach=rng.choice([0.01, 0.5]))
        checker = pc.Checker(robot_of(made, tmp_path))
        assert len(checker.pairs) == 1
        assert not checker.check_motion(q0, q1), (seed, k)


@pytest.mark.parametrize("seed", range(8))
def test_obstacles_that_are_met_are_never_passed(seed, tmp_path):
    """Also with poses that are off rigid by what is accepted, and bodies of half a metre."""
    rng = np.random.default_rng(100 + seed)
    for k in range(25):
        tree, q0, q1 = moving_tree(rng)
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


@pytest.mark.parametrize("seed", range(8))
def test_obstacles_far_from_their_own_frames_are_never_passed(seed, tmp_path):
    """Filters look at chords in an obstacle's frame: its hull may lie anywhere in that, also on fine grids."""
    rng = np.random.default_rng(150 + seed)
    for k in range(40):
        tree, q0, q1 = moving_tree(rng)
        first, own = tips(tree)[rng.integers(2)], rng.uniform(-0.5, 0.5, 3)
        pose = tree.poses(q0, q1, rng.uniform(0.02, 0.98))[first]
        point = pose[:3, :3] @ own + pose[:3, 3] + rng.uniform(-0.9, 0.9, 3) * HALF
        shift = rng.uniform(-1, 1, 3) * rng.choice([0.1, 3])
        scene, placed = pc.Scene(), np.eye(4)
        placed[:3, 3] = point - shift
        scene.add("met", shift + HALF * CORNERS, placed)
        checker = pc.Checker(robot_of(tree.with_body(first, HALF, own), tmp_path), scene, self_collision=False)
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


SWING = """<robot name="swing"><link name="base"/>
<link name="tip"><collision><origin xyz="0.5 0 0"/><geometry><box size="0.002 0.002 0.002"/></geometry></collision>
</link><joint name="turn" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>"""


@pytest.mark.parametrize("way", [0.2, 0.5, 1.0, 2.0, 3.0])
def test_paths_bulge_between_the_states_of_a_grid(way, tmp_path):
    """A small body swings past a plate that it meets only in the middle, where no state of a first grid is."""
    (tmp_path / "swing.urdf").write_text(SWING)
    scene, pose = pc.Scene("plate"), np.eye(4)
    pose[0, 3] = 0.5009 + 0.05
    scene.add_box("plate", [0.1, 0.1, 0.1], pose)
    checker = pc.Checker(pc.Robot.from_urdf(tmp_path / "swing.urdf"), scene)
    assert not checker.check_motion([-way / 2], [way / 2])
    assert not checker.check_motions([[-way / 2]] * 4, [[way / 2]] * 4, threads=2).any()
