"""Trajectories by construction: curves that touch at one instant, corners of tubes that do, and what room is told."""

from dataclasses import replace
from math import comb

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError
from plannercheck.motions.motion_ends import Curves
from plannercheck.motions.trajectory_checks import TrajectoryChecks

SLIDER = """<robot name="slider"><link name="base"/><link name="cart"/>
<link name="ball"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="x" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="1 0 0"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<joint name="y" type="{}"><parent link="cart"/><child link="ball"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>"""


def slider(folder, second="prismatic"):
    (folder / "slider.urdf").write_text(SLIDER.format(second))
    return pc.Robot.from_urdf(folder / "slider.urdf")


def balls(*centres):
    scene = pc.Scene("balls")
    for k, centre in enumerate(centres):
        pose = np.eye(4)
        pose[:3, 3] = centre
        scene.add_sphere(f"ball{k}", 0.1, pose)
    return scene


def through(rng, state, at, degree, bend):
    """Control points of a random curve that passes a state at an instant."""
    k = np.arange(degree + 1)
    choices = np.array([comb(degree, each) for each in k])
    weights = choices * at**k * (1 - at) ** (degree - k)
    bends = bend * rng.normal(size=(degree + 1, len(state)))
    points = state + bends - weights @ bends
    if at in (0.0, 1.0):
        points[0 if at == 0 else -1] = state
    return points


@pytest.mark.parametrize("at", [0.0, 1.0, 0.5, 0.25, 1 / 64, 0.328125, 1 / 3, 0.7])
def test_a_curve_through_a_contact_is_never_free(at, tmp_path):
    """A needle of 0.1 mm, in the way at one instant; the curve turns there, or swings by."""
    robot, rng = slider(tmp_path), np.random.default_rng(int(100 * at))
    scene = pc.Scene("needle")
    scene.add_box("needle", (1e-4, 1e-4, 1.0))
    checker = pc.Checker(robot, scene)
    for _ in range(40):
        angle = rng.uniform(0, 2 * np.pi)
        state = (0.1 - 1e-6) * np.array([np.cos(angle), np.sin(angle)])
        points = through(rng, state, at, int(rng.integers(1, 8)), 10.0 ** rng.uniform(-4, 1))
        assert not checker.check_trajectory(pc.Trajectory.bezier([0, 1], points[None]), tolerance=1e-3)


def test_a_turning_point_is_where_the_curve_is_nearest(tmp_path):
    """A parabola that turns before a plate, at an instant that no grid has: free to the tolerance, refused beyond."""
    robot, scene = slider(tmp_path), pc.Scene("plate")
    scene.add_box("plate", (9.0, 0.1, 1.0), np.eye(4))
    checker = pc.Checker(robot, scene)
    for at in (0.3, 0.5, 0.61803):
        for gap, free in ((1e-3, True), (2.5e-4, True), (-1e-7, False), (-1e-3, False)):
            powers = np.array([[[-1.0, 2.0, 0.0], [0.15 + gap + at**2, -2 * at, 1.0]]])
            assert checker.check_trajectory(pc.Trajectory.polynomials([0, 1], powers)) == free, (at, gap)


@pytest.mark.parametrize("bend", [0, 2, 5, 12])
@pytest.mark.parametrize("late", [False, True])
def test_curves_whose_speed_changes_most_at_an_end_turn_back(bend, late, tmp_path):
    """y = (s - at)² (1.05 - s)^bend, or mirrored, touches a plate by 1e-7 m, in the middle of intervals, too."""
    robot, scene = slider(tmp_path), pc.Scene("plate")
    scene.add_box("plate", (99.0, 0.1, 1.0), np.eye(4))
    checker = pc.Checker(robot, scene)
    for size in (0.7, 3.0, 30.0):
        for at in np.append(np.linspace(0, 1 if bend < 3 else 0.375, 57), [1 / 3, 0.1]):
            shape = size * np.poly1d([-1.0, 1.05]) ** bend / (1.05 - at) ** bend * np.poly1d([1.0, -at]) ** 2
            if late:
                shape = shape(np.poly1d([-1.0, 1.0]))
            powers = np.zeros((1, 2, bend + 3))
            powers[0, 1] = shape.coeffs[::-1]
            powers[0, 1, 0] += 0.15 - 1e-7
            assert not checker.check_trajectory(pc.Trajectory.polynomials([0, 1], powers)), (at, size)


@pytest.mark.parametrize("others", [0, 1100])  # obstacles in lanes, and in the tree
def test_a_corner_of_a_tube_touches(others, tmp_path):
    """The ball keeps 0.3 m away from two others, and far away from more."""
    robot = slider(tmp_path)
    far = ([5.0 + k, 5.0, 0.0] for k in range(others))
    checker = pc.Checker(robot, balls([0.0, 0.5, 0.0], [0.6, -0.5, 0.0], *far))
    straight = pc.Trajectory.bezier([0, 1], [[[-1.0, 0.0], [0.5, 0.0], [1.0, 0.0]]])
    assert checker.check_trajectory(straight, tube=[0.0, 0.29])
    assert not checker.check_trajectory(straight, tube=[0.0, 0.301])
    still = pc.Trajectory.bezier([0, 1], [[[0.3, 0.5], [0.3, 0.5], [0.3, 0.5]]])
    assert checker.check_trajectory(still, tube=[0.09, 0.0])
    assert not checker.check_trajectory(still, tube=[0.101, 0.0])
    verdict = checker.explain_trajectory(straight)
    assert 0.14 < verdict.largest_tube < 0.3


def test_a_tube_as_thin_as_rounding_touches(tmp_path):
    """Two boxes on one line, a little further apart than nothing: the tube is twice as wide."""
    boxes = SLIDER.format("prismatic").replace('<sphere radius="0.1"/>', '<box size="0.2 0.2 0.2"/>')
    (tmp_path / "boxes.urdf").write_text(boxes)
    scene, pose = pc.Scene("box"), np.eye(4)
    pose[1, 3] = 0.5
    scene.add_box("box", (0.2, 0.2, 0.2), pose)
    checker = pc.Checker(pc.Robot.from_urdf(tmp_path / "boxes.urdf"), scene)
    beside = pc.Trajectory.bezier([0, 1], np.full((1, 3, 2), [0.0, 0.3 - 5e-11]))
    assert checker.check_trajectory(beside)
    assert not checker.check_trajectory(beside, tube=1e-10)


ONE_BALL = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
TWO_BOXES = "".join(
    f'<collision><origin xyz="0 {y} 0"/><geometry><box size="0.2 0.2 0.2"/></geometry></collision>' for y in (-0.2, 0.2)
)


@pytest.mark.parametrize("bodies", [ONE_BALL, TWO_BOXES])
def test_two_tubes_meet(bodies, tmp_path):
    """Both links move on one line, 0.3 m apart; each has half of it."""
    side = (
        SLIDER.format("prismatic")
        .replace('axis xyz="0 1 0"', 'axis xyz="1 0 0"')
        .replace('parent link="cart"', 'parent link="base"')
        .replace(ONE_BALL, bodies)
        .replace('<link name="cart"/>', f'<link name="cart">{bodies}</link>')
    )
    (tmp_path / "two.urdf").write_text(side)
    checker = pc.Checker(pc.Robot.from_urdf(tmp_path / "two.urdf"))
    for swing in (0.0, 0.5):
        both = np.array([[0.0, 0.5], [swing, 0.5 + swing], [0.0, 0.5]])
        curve = pc.Trajectory.bezier([0, 1], both[None])
        assert checker.check_trajectory(curve, tube=0.149)
        assert not checker.check_trajectory(curve, tube=0.1501)


def test_an_arm_turns_back_where_it_touches(tmp_path):
    """A ball on a slide on a turning joint comes near another one, and turns back: at instants that no grid has."""
    checker = swinging(tmp_path, [1.0, 0.0, 0.0])
    touching = 2 * np.arcsin(0.1)
    for at in (0.3, 0.5, 0.61803):
        for gap, free in ((1e-3, True), (-1e-6, False), (-1e-3, False)):
            powers = np.array([[[touching + gap + 2 * at**2, -4 * at, 2.0], [0.0, 0.0, 0.0]]])
            assert checker.check_trajectory(pc.Trajectory.polynomials([0, 1], powers)) == free, (at, gap)


def swinging(folder, centre):
    """The checker of a ball 1 m away from a turning joint, on a slide across."""
    arm = (
        SLIDER.replace('origin xyz="0 0 0"', "")
        .replace("prismatic", "revolute", 1)
        .replace('xyz="1 0 0"', 'xyz="0 0 1"')
    )
    arm = arm.replace("<collision>", '<collision><origin xyz="1 0 0"/>').format("prismatic")
    (folder / "arm.urdf").write_text(arm)
    return pc.Checker(pc.Robot.from_urdf(folder / "arm.urdf"), balls(centre))


def test_a_tube_swings_by_the_lever(tmp_path):
    checker = swinging(tmp_path, [0.0, 1.4, 0.0])
    turned = np.pi / 2
    curve = pc.Trajectory.bezier([0, 1], [[[turned - 0.5, 0.0], [turned, 0.0], [turned + 0.5, 0.0]]])
    assert checker.check_trajectory(curve)
    # Along the arm the ball goes 0.2 m; turned by more, it is further away, of which the lever arms know nothing.
    assert checker.check_trajectory(curve, tube=[0.0, 0.19])
    assert not checker.check_trajectory(curve, tube=[0.0, 0.201])
    assert checker.check_trajectory(curve, tube=[0.1, 0.05])


@pytest.mark.parametrize("count", [1, 1100])  # in lanes, and by the tree
def test_the_room_that_is_told_is_there(count, tmp_path):
    robot = slider(tmp_path)
    checker = pc.Checker(robot, balls(*([0.0, 0.4 + 3 * k, 0.0] for k in range(count))))
    curve = pc.Trajectory.bezier([0, 1], [[[-1.0, 0.0], [0.3, 0.0], [1.0, 0.0]]])
    assert checker.clearances([0.0, 0.0])[0] == pytest.approx(0.2)
    assert 0.19 < checker.explain_trajectory(curve).clearance < 0.2
    rooms, none = TrajectoryChecks(checker, 0.0, 1e-4), np.zeros(2)
    for room, free in ((0.05, True), (0.199, True), (0.201, False), (0.39, False)):
        assert rooms._is_free(curve, none, room) == free


def test_pairs_that_cannot_meet_take_room_as_well(tmp_path):
    """Nothing within the limits reaches the other ball, so a verdict leaves it out."""
    robot = slider(tmp_path, "fixed")
    checker = pc.Checker(robot, balls([0.0, 0.4, 0.0]))
    assert checker.unreachable.all()
    curve = pc.Trajectory.bezier([0, 1], [[[-1.0], [0.3], [1.0]]])
    assert 0.19 < checker.explain_trajectory(curve).clearance <= 0.2001
    points, certifier = np.array([[[-1.0], [0.3], [1.0]]]), checker.certifier_of("slerp")
    for room, free in ((0.19, True), (0.21, False)):  # with and without Python in between
        curves = Curves(points, np.array([[0.0, room]]))
        assert certifier.check(curves, 1e-4, 1).all() == certifier.check_curves(curves, 1e-4, 1).all() == free


@pytest.mark.parametrize("tube", [0.0, 0, [0.0, 0.0]])
def test_a_curves_own_error_is_a_tube(tmp_path, tube):
    """0.05 m are left; one trajectory, of several, with and without a tube that is given."""
    checker = pc.Checker(slider(tmp_path), balls([0.0, 0.25, 0.0]))
    curve = pc.Trajectory.bezier([0, 1], [[[-1.0, 0.0], [0.3, 0.0], [1.0, 0.0]]])
    for error, free in ((0.0, True), (0.045, True), (0.055, False)):
        curve.curve = replace(curve.curve, error=np.array([0.0, error]))
        assert checker.check_trajectory(curve, tube) == free
        assert checker.check_trajectories([curve, curve], tube).tolist() == [free, free]
        assert checker.explain_trajectory(curve, tube).free == free


def test_a_tube_counts_where_rounding_is_known(tmp_path):
    """The bound of rounding holds in a range: curves that leave it with their tube alone need more care."""
    certifier = pc.Checker(slider(tmp_path), balls([0.0, 2.0, 0.0])).certifier_of("slerp")
    part, errors = certifier.pairs_by_table()[-1], certifier.rounding()
    for end, first in ((errors.high[0] - 0.01, 0.0), (errors.low[0] + 0.01, 0.0), (0.0, errors.high[0] - 0.01)):
        points = np.array([[[first, 0.0], [0.0, 0.1], [end, 0.0]]])
        for tube, known in ((0.005, True), (0.02, False)):
            found = core.curve_validity(
                part.core,
                certifier._kernel,
                errors.low,
                errors.high,
                errors.usual,
                points,
                np.array([[tube, 0.0, 0.0]]),
                1e-4,
                1,
            )
            assert (found is not None) == known


def test_pairs_that_cannot_meet_take_a_tube_as_well(tmp_path):
    """A proof covers all pairs: what is free has one."""
    checker = pc.Checker(slider(tmp_path, "fixed"), balls([0.0, 0.4, 0.0]))
    curve = pc.Trajectory.bezier([0, 1], [[[0.0], [0.3], [0.0]]])
    assert 0.19 < checker.explain_trajectory(curve).largest_tube < 0.2
    assert checker.certify_trajectory(curve, tube=0.19) is not None
    assert not checker.check_trajectory(curve, tube=0.21)


def test_unit_vectors_turn_from_end_to_end(tmp_path):
    """They follow no polynomial: a base that floats turns by half a turn, over control points of any length."""
    (tmp_path / "slider.urdf").write_text(SLIDER.format("prismatic"))
    robot = pc.Robot.from_urdf(tmp_path / "slider.urdf", floating=True)
    points = np.zeros((3, robot.nq))
    points[0, 6] = points[2, 5] = 1.0
    # The ball, 0.5 m out, swings over the y axis half-way.
    points[:, 7] = 0.5
    curve = pc.Trajectory.bezier([0, 2], points[None]).of_robot(robot)
    verdict = pc.Checker(robot, balls([0.0, 0.5, 0.0])).explain_trajectory(curve)
    assert verdict.collides_at == pytest.approx(1.0, abs=0.5)
    assert not verdict
    free = pc.Checker(robot, balls([0.0, -0.5, 0.0])).explain_trajectory(curve)
    assert free
    assert 0.5 < free.clearance < 0.51
    points[2, 5] = 0.0
    with pytest.raises(PlannercheckError, match="quaternion"):
        pc.Trajectory.bezier([0, 2], points[None]).of_robot(robot)


def test_a_search_for_the_largest_tube_ends_where_rounding_is_too_large(tmp_path):
    checker = pc.Checker(slider(tmp_path), balls([0.0, 0.0, 2.0]))
    still = pc.Trajectory.bezier([0, 1], np.zeros((1, 3, 2)))
    with pytest.raises(PlannercheckError, match="rounding"):
        checker.check_trajectory(still, tube=1.5, tolerance=1.5e-11)
    assert 0.1 < checker.explain_trajectory(still, tolerance=1.5e-11).largest_tube < 1.5


@pytest.mark.parametrize("tube", [np.nan, np.inf, -1e-300, 1e16, np.finfo(float).max])
def test_tubes_that_are_no_sizes_are_refused_and_leave_nothing_behind(tube, tmp_path):
    checker = pc.Checker(slider(tmp_path), balls([0.0, 2.0, 0.0]))
    beyond = pc.Trajectory.bezier([0, 1], [[[2.9, 0.0], [3.0, 0.1], [3.2, 0.0]]])
    with pytest.raises(PlannercheckError, match="tube must be"):
        checker.check_trajectory(beyond, tube=tube)
    assert checker.check_trajectory(beyond)


def test_one_trajectory_is_no_list_of_some(tmp_path):
    checker = pc.Checker(slider(tmp_path), balls([0.0, 2.0, 0.0]))
    with pytest.raises(PlannercheckError, match="check_trajectory takes one"):
        checker.check_trajectories(pc.Trajectory.bezier([0, 1], [[[0.0, 0.0], [1.0, 0.0]]]))


def test_errors_name_the_piece_and_its_time(tmp_path):
    checker = pc.Checker(slider(tmp_path), balls([0.0, 2.0, 0.0]))
    pieces = [[[0.0, 0.0], [0.1, 0.1], [0.2, 0.0]], [[0.2, 0.0], [1e12, 0.1], [0.2, 0.0]]]
    far = pc.Trajectory.bezier([0.0, 1.0, 2.5], pieces)
    near = pc.Trajectory.bezier([0.0, 1.0], pieces[:1])
    for judge in (checker.check_trajectory, checker.explain_trajectory, checker.certify_trajectory):
        with pytest.raises(PlannercheckError, match=r"^piece 1 of the trajectory, 1 to 2\.5 s: lengths and angles"):
            judge(far)
    with pytest.raises(PlannercheckError, match=r"^trajectory 2, piece 1 of the trajectory, 1 to 2\.5 s: lengths"):
        checker.check_trajectories([near, near, far])


def test_a_free_piece_without_a_proof_is_named(tmp_path, monkeypatch):
    checker = pc.Checker(slider(tmp_path), balls([0.0, 2.0, 0.0]))
    monkeypatch.setattr(type(checker._prover), "curve_proof", unproved)
    with pytest.raises(PlannercheckError, match=r"^piece 0 of the trajectory, 0 to 1 s: no proof"):
        checker.certify_trajectory(pc.Trajectory.bezier([0.0, 1.0], [[[0.0, 0.0], [0.1, 0.1], [0.2, 0.0]]]))


def unproved(*_):
    raise PlannercheckError("no proof")


WRONG_TYPES = {
    "tube": lambda checker, t: checker.check_trajectory(t, "wide"),
    "tubes": lambda checker, t: checker.check_trajectories([t], "0.1"),
    "tube of a proof": lambda checker, t: checker.certify_trajectory(t, {"x": 0.1}),
    "no tube": lambda checker, t: checker.explain_trajectory(t, None),
    "robot": lambda checker, t: t.limits("panda"),
    "robot of units": lambda checker, t: t.of_robot("panda"),
    "velocity": lambda checker, t: t.limits(checker.robot, "fast"),
    "acceleration": lambda checker, t: t.limits(checker.robot, 1.0, ["a", "b"]),
    "times": lambda checker, t: pc.Trajectory("soon", [[0.0], [1.0]]),
    "positions": lambda checker, t: pc.Trajectory([0, 1], "home"),
    "time": lambda checker, t: t.position("now"),
    "breaks": lambda checker, t: pc.Trajectory.polynomials("a", "b"),
    "checker": lambda checker, t: pc.time_path("panda", [[0, 0], [1, 1]], 1.0, 1.0),
    "blend": lambda checker, t: pc.time_path(checker, [[0, 0], [0.1, 0]], 1.0, 1.0, blend="wide"),
    "message": lambda checker, t: pc.Trajectory.load("t.yaml", checker.robot, message="0"),
    "path": lambda checker, t: pc.Trajectory.load(3, checker.robot),
}


@pytest.mark.parametrize("name", WRONG_TYPES)
def test_arguments_of_other_types_are_named(tmp_path, name):
    checker = pc.Checker(slider(tmp_path), balls([0.0, 2.0, 0.0]))
    t = pc.Trajectory.bezier([0.0, 1.0], [[[0.0, 0.0], [0.1, 0.1], [0.2, 0.0]]])
    named = {"robot of units": "Robot", "tubes": "tube", "tube of a proof": "tube", "no tube": "tube", "robot": "Robot"}
    with pytest.raises(PlannercheckError, match=named.get(name, name)):
        WRONG_TYPES[name](checker, t)


def test_numbers_that_are_not_finite_leave_nothing_behind(tmp_path):
    """A workspace that has seen them judges the next curve as a new one does."""
    certifier = pc.Checker(slider(tmp_path), balls([0.0, 2.0, 0.0])).certifier_of("slerp")
    points, none = np.array([[[2.9, 0.0], [3.0, 0.1], [3.2, 0.0]]]), np.zeros((1, 3))
    with pytest.raises(PlannercheckError, match="piece 0: lengths"):
        certifier.check_curves(Curves(points, np.array([[np.inf, 0.0, 0.0]])), 1e-4, 1)
    assert certifier.check_curves(Curves(points, none), 1e-4, 1).all()


def test_paddings_of_bodies_that_stand_still_are_taken_off_the_clearance(tmp_path):
    """A held post is 5 cm from a ball, of which the padding takes 1; the robot is further away, and can't be nearer."""
    post = """<link name="post"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
    <joint name="z" type="prismatic"><parent link="base"/><child link="post"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>"""
    path = tmp_path / "slider.urdf"
    path.write_text(SLIDER.format("prismatic").replace("</robot>", post))
    checker = pc.Checker(pc.Robot.from_urdf(path).with_group(["x", "y"]), balls((0, 0, 0.25)), padding=0.01)
    run = pc.Trajectory([0, 1], [[1.0, 1.0], [2.0, 1.0]], controller="linear")
    assert checker.explain_trajectory(run).clearance == pytest.approx(0.04, rel=0.01)
