"""Contact by construction on motions whose angles count their turns or are far from 0: followers, OMPL, the plane."""

import contextlib

import mpmath
import numpy as np
import pinocchio as pin
import pytest
from motion_contacts import HALF, robot_of
from poses import at
from random_branches import Joint, Tree

import plannercheck as pc
from plannercheck.motions.rounding_bounds import RoundingBounds
from plannercheck.ompl.joint_space import JointSpace

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
        _, (judged,), _ = checker._motion_ends(np.array([[start]]), np.array([[end]]))
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
        obstacle = at(*pose[:3, :3] @ own + pose[:3, 3])
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
    found = bounds.of_ranges(q0, q1)(np.arange(3))
    alone = [bounds.of_ranges(q0[k : k + 1], q1[k : k + 1])(np.arange(1))[0][0] for k in range(3)]
    assert {int(k): error for error, chosen in found for k in chosen} == dict(enumerate(alone))
    assert alone[0] == bounds.usual < alone[2] < alone[1]


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
    links = [pc.planar.Link("root", PAD, joint="free"), pc.planar.Link("arm", PAD, "root", (0, 0, 0.7123), "revolute")]
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


def test_a_far_end_is_proved_without_any_pair(tmp_path):
    """The asked end is off by what are no whole turns, and there is no body whose way that would matter for."""
    joint = Joint("continuous", "base", "a0", (0, 0, 0), (0.3, -0.2, 1), (0, 0, 1))
    checker = pc.Checker(robot_of(Tree((joint,)), tmp_path))
    (proof,) = checker.certify_motions([[0.0]], [[1e9 + 0.3]])
    assert proof.verify()
