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


def boxes_at(*places):
    """A box at each place (x, y), where a hub or a tip meets it after a turn beyond the motions here."""
    scene = pc.Scene("behind")
    for k, (x, y) in enumerate(places):
        pose = np.eye(4)
        pose[:2, 3] = x, y
        scene.add_box(f"box {k}", (0.04, 0.04, 0.04), pose)
    return scene


def contacts(checker, q0, q1):
    """Judges motions of which the middle is tried as a state: how many touch there. None of these may pass."""
    touching = ~checker.check_states((q0 + q1) / 2)
    assert not checker.check_motions(q0, q1)[touching].any()
    assert not any(checker.check_motion(a, b) for a, b in zip(q0[touching], q1[touching], strict=True))
    return int(touching.sum())


# Where a link has a hub, its tip has pairs with the other robot only, and leaves its chords further than the hub.
@pytest.mark.parametrize("turn", [0.3, 0.5, 0.7, 1.0])
@pytest.mark.parametrize(
    ("left", "box"), [((HUB, TIP), (-0.024, 0.018)), ((TIP,), (-0.98, 0.17))], ids=["both", "right"]
)
def test_two_tips_that_meet_in_the_middle_of_a_motion(tmp_path, left, box, turn):
    robots = arm(tmp_path, "left", "revolute", "0 0 1", *left), arm(tmp_path, "right", "revolute", "0 0 1", HUB, TIP)
    met, pose = 0, np.diag([-1.0, -1.0, 1.0, 1.0])
    for gap in np.linspace(-0.003, 0.0005, 15):
        pose[0, 3] = 2.02 + gap
        cell = pc.Robot.together({"left": robots[0], "right": (robots[1], pose)})
        checker = pc.Checker(cell, boxes_at(box, (pose[0, 3] + 0.024, -0.018)))
        ends = np.array([[turn, turn], [turn, -turn]])
        met += contacts(checker, -ends, ends)
    assert met > 20


def test_a_tip_that_meets_a_rod_in_the_middle_of_a_motion(tmp_path):
    robots = arm(tmp_path, "left", "revolute", "0 0 1", HUB, TIP), arm(tmp_path, "right", "prismatic", "1 0 0", ROD)
    cell = pc.Robot.together({"left": robots[0], "right": (robots[1], np.eye(4))})
    checker = pc.Checker(cell, boxes_at((-0.024, 0.018)))
    turns, gaps = (m.ravel() for m in np.meshgrid([0.3, 0.5, 0.7, 1.0], np.linspace(-0.0015, 0.0005, 21)))
    q0, q1 = np.stack([-turns, 1.01 + gaps], axis=1), np.stack([turns, 1.01 + gaps], axis=1)
    assert contacts(checker, q0, q1) > 50
