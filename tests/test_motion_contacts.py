"""Contact by construction: choose the robot, the motion and a parameter, and put a body of a millimetre where the other
one is then. The motion must be refused, however the two get there."""

from __future__ import annotations

import numpy as np
import pytest
from random_trees import KINDS, Joint, Tree, random_tree, tips

import plannercheck as pc

# Half edges of the bodies that meet, m: no slack of balls and boxes hides a fault.
HALF = 5e-4


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
