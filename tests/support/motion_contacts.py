"""Bodies of a millimetre that meet at a chosen parameter of a motion.

In: a random tree, a motion, a parameter. Out: the tree with bodies on two links, or an obstacle, that meet then.
"""

import numpy as np
from random_branches import Joint

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


def obstacle_at(point, half, rotation=None):
    scene, pose = pc.Scene(), np.eye(4)
    pose[:3, 3] = point
    if rotation is not None:
        pose[:3, :3] = rotation
    scene.add_box("met", [2 * half] * 3, pose)
    return scene


def assert_met(robot, tree, link, q0, q1, rng, count=25):
    """A body of a millimetre on a link is refused motions that lead it against obstacles, at many parameters."""
    for t in rng.uniform(0.02, 0.98, count):
        pose = tree.poses(q0, q1, t)[link]
        point = pose[:3, :3] @ tree.bodies[link][1] + pose[:3, 3] + rng.uniform(-0.9, 0.9, 3) * HALF
        checker = pc.Checker(robot, obstacle_at(point, HALF), self_collision=False)
        assert not checker.check_motion(q0, q1)
