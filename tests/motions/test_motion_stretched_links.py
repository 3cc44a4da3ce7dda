"""Contact by construction of links that are stretched: quaternions off length 1, several in a chain."""

from itertools import pairwise

import mpmath
import numpy as np
import pytest
from motion_contacts import robot_of
from poses import at
from random_branches import Joint, Tree

import plannercheck as pc


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
    pose = at(side * (face + 0.5 - depth))
    scene.add_box("met", [1, 0.5, 0.5], pose)
    for k in range(others):
        pose = at(0.1 * k, 30, 0)
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
    pose = at(*tip[:3] + np.array([0.001 - 1e-9, 0, 0]))
    scene.add_box("met", [0.002] * 3, pose)
    checker = pc.Checker(robot, scene)
    assert not checker.is_valid(q)
    assert checker.is_valid(half_turns(count, 0.0))
    ends = (q, away) if t == 0 else (away, q)
    assert not checker.check_motion(*ends, tolerance=1e-3)
    assert checker.check_motion(half_turns(count, 0.0), away, tolerance=1e-8)
