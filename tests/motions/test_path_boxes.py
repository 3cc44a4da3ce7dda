"""Boxes around the paths of a link's bodies, which tell bodies of two robots apart before anything else is asked."""

import numpy as np
import pytest

import plannercheck as pc

HUB, TIP = (f'<origin xyz="{x} 0 0"/><geometry><sphere radius="0.01"/></geometry>' for x in (0.03, 1))
ROD = '<origin xyz="0.1 0 0"/><geometry><box size="0.2 0.002 0.002"/></geometry>'


def arm(folder, name, joint, axis, *bodies):
    """A robot of one joint whose link has some bodies."""
    shapes = "".join(f"<collision>{body}</collision>" for body in bodies)
    path = folder / f"{name}.urdf"
    path.write_text(f"""<robot name="{name}"><link name="base"/><link name="arm">{shapes}</link>
    <joint name="joint" type="{joint}"><parent link="base"/><child link="arm"/><axis xyz="{axis}"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>""")
    return pc.Robot.from_urdf(path)


def in_reach_of_hubs(*places):
    """A box behind each place on the x axis: a hub meets it after a turn, a tip never does."""
    scene = pc.Scene("behind")
    for k, (x, side) in enumerate(places):
        pose = np.eye(4)
        pose[:3, 3] = x - 0.024 * side, 0.018 * side, 0
        scene.add_box(f"box {k}", (0.04, 0.04, 0.04), pose)
    return scene


def contacts(checker, q0, q1):
    """Judges motions of which the middle is tried as a state: how many touch there. None of these may pass."""
    touching = ~checker.check_states((q0 + q1) / 2)
    assert not checker.check_motions(q0, q1)[touching].any()
    assert not any(checker.check_motion(a, b) for a, b in zip(q0[touching], q1[touching], strict=True))
    return int(touching.sum())


# The tip has pairs with the other robot only, and leaves its chords further than the hub, which has one with a box.
@pytest.mark.parametrize("turn", [0.3, 0.5, 0.7, 1.0])
def test_two_tips_that_meet_in_the_middle_of_a_motion(tmp_path, turn):
    robot, met = arm(tmp_path, "robot", "revolute", "0 0 1", HUB, TIP), 0
    for gap in np.linspace(-0.003, 0.0005, 15):
        pose = np.diag([-1.0, -1.0, 1.0, 1.0])
        pose[0, 3] = 2.02 + gap
        cell = pc.Robot.together({"left": robot, "right": (robot, pose)})
        checker = pc.Checker(cell, in_reach_of_hubs((0, 1), (pose[0, 3], -1)))
        ends = np.array([[turn, turn], [turn, -turn]])
        met += contacts(checker, -ends, ends)
    assert met > 20


def test_a_tip_that_meets_a_rod_in_the_middle_of_a_motion(tmp_path):
    robots = arm(tmp_path, "left", "revolute", "0 0 1", HUB, TIP), arm(tmp_path, "right", "prismatic", "1 0 0", ROD)
    cell = pc.Robot.together({"left": robots[0], "right": (robots[1], np.eye(4))})
    checker = pc.Checker(cell, in_reach_of_hubs((0, 1)))
    turns, gaps = (m.ravel() for m in np.meshgrid([0.3, 0.5, 0.7, 1.0], np.linspace(-0.0015, 0.0005, 21)))
    q0, q1 = np.stack([-turns, 1.01 + gaps], axis=1), np.stack([turns, 1.01 + gaps], axis=1)
    assert contacts(checker, q0, q1) > 50
