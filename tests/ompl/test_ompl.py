"""OMPL plans with the checker as judge: limits, validators, seeds, and reasons for failure."""

import subprocess
import sys
from itertools import pairwise

import numpy as np
import pytest
from ompl import base, geometric

import plannercheck as pc
from plannercheck.common.errors import PlannercheckError
from plannercheck.motions.checker import Checker
from plannercheck.motions.motion_ends import Motions
from plannercheck.ompl import planning
from plannercheck.ompl.joint_space import JointSpace
from plannercheck.ompl.motion_validators import motion_validator
from plannercheck.ompl.plans import Plan
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene
from plannercheck.validation.path_recheck import resampled
from plannercheck.validation.paths import validate_path


@pytest.fixture(scope="module")
def ends(checker) -> tuple[np.ndarray, np.ndarray]:
    return checker.scene.start("panda"), checker.scene.goal("panda")


@pytest.fixture(scope="module")
def plan(checker, ends) -> Plan:
    return planning.plan(checker, *ends, seed=1)


@pytest.fixture(scope="module")
def kinova() -> Checker:
    return Checker(Robot.load("kinova"))


def validator_of(checker: Checker, resolution: float | None = None):
    space = JointSpace(checker.robot)
    information = planning.setup(checker, resolution).getSpaceInformation()
    return motion_validator(information, checker, space, resolution), space, information


def test_the_space_has_the_limits_of_the_robot(checker):
    space = planning.setup(checker).getStateSpace()
    assert isinstance(space, base.RealVectorStateSpace)
    assert space.getDimension() == checker.robot.nq
    bounds = space.getBounds()
    assert np.array_equal(list(bounds.low), checker.robot.lower)
    assert np.array_equal(list(bounds.high), checker.robot.upper)


def test_states_are_judged_by_the_checker(checker):
    setup = planning.setup(checker)
    information, space = setup.getSpaceInformation(), JointSpace(checker.robot)
    rows = checker.scene.samples("panda")[:100]
    verdicts = [information.isValid(space.state(information, row)) for row in rows]
    assert np.array_equal(verdicts, checker.check_states(rows))


def test_a_plan_leads_from_start_to_goal_within_the_limits(checker, ends, plan):
    assert plan.solved
    assert plan.reason == ""
    assert np.array_equal(plan.path[[0, -1]], ends)
    assert (plan.path >= checker.robot.lower).all()
    assert (plan.path <= checker.robot.upper).all()
    assert plan.length == pytest.approx(np.linalg.norm(np.diff(plan.path, axis=0), axis=1).sum())
    assert plan.length >= np.linalg.norm(ends[1] - ends[0]) - 1e-12
    assert 0 < plan.time < 10


def test_continuous_joints_are_checked_on_the_short_way():
    """Motions of which many go one way free and the other way not, the short way held to plain arithmetic."""
    checker = Checker(Robot.load("kinova"), Scene.load("kitchen"))
    validator, space, information = validator_of(checker)
    turning = space.continuous
    rng = np.random.default_rng(5)
    q = checker.robot.random_configurations(2000, 5)
    starts = q[checker.check_states(q)][:200]
    ends = starts + rng.uniform(-1, 1, starts.shape) * np.where(turning, 1.0, 0.1)
    ends = np.where(
        turning, (ends + np.pi) % (2 * np.pi) - np.pi, np.clip(ends, checker.robot.lower, checker.robot.upper)
    )
    step = ends - starts
    near = np.where(
        turning & (step > np.pi), step - 2 * np.pi, np.where(turning & (step < -np.pi), step + 2 * np.pi, step)
    )
    assert (np.abs(step) > np.pi).any(axis=1).sum() > 20
    np.testing.assert_allclose(space.differences(starts, ends), near, atol=1e-12)
    truth, long_way = (
        checker.motion_certifier.check(Motions(starts, ends, ends), 1e-4, 1) for ends in (starts + near, starts + step)
    )
    assert (truth & ~long_way).sum() > 10
    for q0, q1, free in zip(starts, ends, truth, strict=True):
        states = space.state(information, q0), space.state(information, q1)
        assert validator.checkMotion(*states) == free
        assert validator.checkMotionWithLastValid(*states)[0] == free
        assert checker.check_motion(q0, q1) == free
    assert np.array_equal(checker.check_motions(starts, ends), truth)


def test_a_validator_proves_with_its_own_tolerance(tmp_path):
    """A block turns under a lid, 0.05 mm below it: refused for 0.1 mm, free for 0.04 mm."""
    urdf = tmp_path / "turning.urdf"
    urdf.write_text(
        """<robot name="turning"><link name="base"/>
<link name="block"><collision><origin xyz="1 0 0"/><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
<joint name="turn" type="continuous"><parent link="base"/><child link="block"/><axis xyz="0 0 1"/></joint></robot>"""
    )
    scene, pose = Scene("lid"), np.eye(4)
    pose[:3, 3] = [1.0, 0.0, 0.05 + 0.01 + 5e-5]
    scene.add_box("lid", [0.02, 0.02, 0.02], pose)
    checker = Checker(Robot.from_urdf(urdf, group=["turn"]), scene)
    space, information = JointSpace(checker.robot), planning.setup(checker).getSpaceInformation()
    for tolerance, free in ((1e-4, False), (4e-5, True)):
        assert checker.check_motion([-1.0], [1.0], tolerance=tolerance) == free
        validator = motion_validator(information, checker, space, None, tolerance)
        ends = [space.state(information, q) for q in ([-1.0], [1.0])]
        assert validator.checkMotion(*ends) == free
        assert validator.checkMotionWithLastValid(*ends)[0] == free
        path = validate_path(checker, [[-1.0], [1.0], [-1.0]], tolerance)
        assert path.free == free
        assert path.motion == (None if free else 0)


def test_distances_are_those_of_all_joints_and_bounded_ones_never_go_round(kinova):
    """Joints weigh equally; one with limits goes all the way, be it more than half a turn."""
    space = JointSpace(kinova.robot)
    setup = planning.setup(kinova)
    bounded = ~space.continuous
    low, high = (np.where(bounded, limit, 0.5) for limit in (kinova.robot.lower, kinova.robot.upper))
    assert (high - low)[bounded].max() > np.pi
    assert np.array_equal(space.differences(low, high), high - low)
    a, b = (space.state(setup.getSpaceInformation(), q) for q in (low, high))
    assert setup.getStateSpace().distance(a, b) == pytest.approx((high - low).sum())


def test_states_are_written_with_angles_within_half_a_turn(kinova):
    """As OMPL's SO2 needs them: an angle outside would make its distances wrong."""
    space = JointSpace(kinova.robot)
    information = planning.setup(kinova).getSpaceInformation()
    row = kinova.robot.reference.copy()
    for angle, written in (
        (4.0, 4.0 - 2 * np.pi),
        (-4.0, 2 * np.pi - 4.0),
        (np.pi, -np.pi),
        (-np.pi, -np.pi),
        (0.5, 0.5),
    ):
        row[space.continuous] = angle
        state = space.state(information, row)
        assert information.satisfiesBounds(state)
        found = np.array(space.read(state))
        assert found[space.continuous] == pytest.approx(written, abs=1e-15)
        assert np.array_equal(found[~space.continuous], row[~space.continuous])
    assert (found[space.continuous] == 0.5).all()


def test_all_sampled_states_of_a_plan_are_valid(checker, plan):
    for states in resampled(checker, plan.path, 1e-3):
        assert checker.check_states(states).all()


def test_a_seed_repeats_the_search(checker, ends):
    paths = [planning.plan(checker, *ends, seed=3, simplify=False).path for _ in range(2)]
    assert np.array_equal(*paths)


def test_reasons_name_limits_and_colliding_pairs(checker, ends):
    colliding = planning.plan(checker, np.zeros(7), ends[1])
    assert not colliding.solved
    assert colliding.path.shape == (0, 7)
    assert "start is beyond the limits: panda_joint4 is 0, not in" in colliding.reason
    expected = {(v.first, v.second) for v in checker.explain(np.zeros(7)).collisions}
    assert all(f"{first} with {second}" in colliding.reason for first, second in expected)
    assert expected


def test_a_search_that_runs_out_of_time_says_so(checker, ends):
    plan = planning.plan(checker, *ends, planner="RRT", time_limit=1e-6)
    assert not plan.solved
    assert "found no path" in plan.reason


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"planner": "RRTConect"}, "did you mean 'RRTConnect'"),
        ({"time_limit": 0}, "time_limit"),
        ({"seed": 0}, "seed"),
        ({"resolution": -1.0}, "resolution"),
        ({"longest_motion": -1.0}, "longest_motion"),
    ],
)
def test_bad_arguments(checker, ends, arguments, message):
    with pytest.raises(PlannercheckError, match=message):
        planning.plan(checker, *ends, **arguments)


def test_bad_ends_are_called_by_their_names(checker, ends):
    with pytest.raises(PlannercheckError, match=r"goal.*\(7,\)"):
        planning.plan(checker, ends[0], np.zeros(6))
    with pytest.raises(PlannercheckError, match="start must be one configuration"):
        planning.plan(checker, np.zeros((2, 7)), ends[1])
    with pytest.raises(PlannercheckError, match=r"goal.*finite"):
        planning.plan(checker, ends[0], np.full(7, np.nan))
    with pytest.raises(PlannercheckError, match=r"start must be numbers, not \[\[1, 2\], \[3\]\]"):
        planning.plan(checker, [[1, 2], [3]], ends[1])


@pytest.mark.parametrize("name", ["checker", "time_limit", "seed", "resolution", "longest_motion"])
@pytest.mark.parametrize("value", ["1", True, 1j, np.array([1.0])])
def test_arguments_that_are_no_numbers_are_named(checker, ends, name, value):
    with pytest.raises(PlannercheckError, match=f"^{name} must be"):
        planning.plan(**{"checker": checker, "start": ends[0], "goal": ends[1], name: value})


def test_all_motions_of_a_plan_are_proved_free(checker, plan):
    assert checker.check_motions(plan.path[:-1], plan.path[1:]).all()


# Geometric planners of OMPL 2.0.1 that its bindings expose.
PLANNERS = (
    *("AORRTC", "BFMT", "BITstar", "BKPIECE1", "FMT", "InformedRRTstar", "KPIECE1"),
    *("LBKPIECE1", "PRM", "PRMstar", "RRT", "RRTConnect", "RRTstar", "SORRTstar"),
)


@pytest.mark.parametrize("name", PLANNERS)
def test_every_planner_asks_for_proofs(checker, ends, name):
    # Not a goal in sight of the start: SORRTstar never returns where the straight motion is the best path.
    assert name in planning.planner_names()
    setup = planning.setup(checker)
    information, space = setup.getSpaceInformation(), JointSpace(checker.robot)
    validator = motion_validator(information, checker, space)
    information.setMotionValidator(validator)
    setup.setStartAndGoalStates(*(space.state(information, q) for q in ends))
    planner = getattr(geometric, name)(information)
    if hasattr(planner, "setNumSamples"):
        planner.setNumSamples(100)  # FMT and BFMT draw all of them before they look at a motion
    setup.setPlanner(planner)
    setup.solve(base.timedPlannerTerminationCondition(0.7))
    assert validator.getCheckedMotionCount() > 0
    if not setup.haveExactSolutionPath():  # in this time
        return
    path = np.array([space.read(state) for state in setup.getSolutionPath().getStates()])
    assert checker.check_motions(path[:-1], path[1:]).all()
    before = validator.getCheckedMotionCount()
    setup.simplifySolution(0.2)
    path = np.array([space.read(state) for state in setup.getSolutionPath().getStates()])
    assert checker.check_motions(path[:-1], path[1:]).all()
    assert validator.getCheckedMotionCount() >= before


@pytest.mark.parametrize("resolution", [None, 0.01])
def test_motions_are_judged_and_counted(checker, resolution):
    validator, space, information = validator_of(checker, resolution)
    rows = checker.scene.samples("panda")[600:640]
    expected = checker.check_motions(rows[:-1], rows[1:], resolution)
    for q0, q1, free in zip(rows[:-1], rows[1:], expected, strict=True):
        answer = validator.checkMotion(space.state(information, q0), space.state(information, q1))
        assert type(answer) is bool
        assert answer == free
    assert (validator.getValidMotionCount(), validator.getInvalidMotionCount()) == (expected.sum(), (~expected).sum())
    assert validator.getCheckedMotionCount() == len(expected)
    assert validator.getValidMotionFraction() == pytest.approx(expected.mean())
    validator.resetMotionCounter()
    assert validator.getCheckedMotionCount() == 0


@pytest.mark.parametrize("resolution", [None, 0.01])
def test_the_last_valid_state_comes_right_before_the_first_collision(checker, resolution):
    validator, space, information = validator_of(checker, resolution)
    rows = checker.scene.samples("panda")[600:640]
    for q0, q1 in pairwise(rows):
        last = information.allocState()
        ends = space.state(information, q0), space.state(information, q1)
        free, fraction = validator.checkMotionWithLastValid(*ends, last)
        assert free == checker.check_motion(q0, q1, resolution)
        assert (fraction == 1.0) == free
        assert np.allclose(space.read(last), q0 + fraction * (q1 - q0))
        assert fraction == 0.0 or checker.is_valid(space.read(last))
        if resolution is None and 0 < fraction < 1:
            assert checker.check_motion(q0, space.read(last), tolerance=1e-6)
            assert not checker.check_motion(space.read(last), q1)


@pytest.mark.parametrize("resolution", [None, 0.01])
def test_space_information_asks_our_validator(checker, resolution):
    setup = planning.setup(checker, resolution)
    information, space = setup.getSpaceInformation(), JointSpace(checker.robot)
    rows = checker.scene.samples("panda")[600:620]
    for q0, q1 in pairwise(rows):
        states = space.state(information, q0), space.state(information, q1)
        assert information.checkMotion(*states) == checker.check_motion(q0, q1, resolution)


def test_continuous_joints_of_a_group_are_angles(kinova):
    space = JointSpace(kinova.robot)
    assert space.continuous.tolist() == np.isinf(kinova.robot.upper).tolist()
    setup = planning.setup(kinova)
    assert isinstance(setup.getStateSpace(), base.CompoundStateSpace)
    information = setup.getSpaceInformation()
    q = kinova.robot.random_configurations(20, seed=0)
    for row in q:
        assert np.array_equal(space.read(space.state(information, row)), row)


def test_angles_take_the_short_way(kinova):
    start = kinova.robot.reference.copy()
    goal = start.copy()
    start[0], goal[0] = 3.0, -3.0
    plan = planning.plan(kinova, start, goal, seed=1)
    assert plan.solved
    assert plan.length < 1.0


TURNTABLE = """
<robot name="turntable">
  <link name="a"/>
  <link name="b"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
  <joint name="turn" type="continuous"><parent link="a"/><child link="b"/></joint>
</robot>
"""


def test_joints_that_planning_does_not_know_are_named(tmp_path):
    urdf = tmp_path / "turntable.urdf"
    urdf.write_text(TURNTABLE)
    with pytest.raises(PlannercheckError, match="'turn' of turntable takes 2 numbers"):
        planning.setup(Checker(Robot.from_urdf(urdf)))
    assert planning.setup(Checker(Robot.from_urdf(urdf, group=["turn"]))) is not None


def test_planner_names_are_those_of_ompl():
    names = planning.planner_names()
    assert {"RRTConnect", "PRM", "KPIECE1"} <= set(names)
    assert all(issubclass(getattr(geometric, name), base.Planner) for name in names)


SCRIPT = """
import plannercheck as pc
from ompl import base
robot, scene = pc.Robot.load("panda"), pc.Scene.load("bookshelf")
checker = pc.Checker(robot, scene)
setup = pc.ompl.setup(checker)
information = setup.getSpaceInformation()
start, goal = information.allocState(), information.allocState()
start[0:7], goal[0:7] = list(scene.start("panda")), list(scene.goal("panda"))
setup.setStartAndGoalStates(start, goal)
assert setup.solve(base.timedPlannerTerminationCondition(10.0))
plan = pc.ompl.plan(checker, scene.start("panda"), scene.goal("panda"), seed=5)
assert plan.solved
"""


def test_a_script_leaves_no_leaks_and_no_chatter():
    done = subprocess.run([sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=True)
    assert done.stdout == ""
    assert done.stderr == ""


def test_ends_by_names_of_joints(checker, ends):
    named = [dict(zip(checker.robot.joint_names[::-1], q[::-1], strict=True)) for q in ends]
    for start, goal in (named, (ends[0], named[1])):
        found = planning.plan(checker, start, goal, seed=2, simplify=False)
        assert np.array_equal(found.path, planning.plan(checker, *ends, seed=2, simplify=False).path)
    with pytest.raises(PlannercheckError, match=r"goal: .*missing: panda_joint1$"):
        planning.plan(checker, ends[0], {name: value for name, value in named[1].items() if name != "panda_joint1"})
    with pytest.raises(PlannercheckError, match=r"start: unknown joint 'panda_joint8'"):
        planning.plan(checker, {**named[0], "panda_joint8": 0.0}, ends[1])
    with pytest.raises(PlannercheckError, match=r"start: .*finite"):
        planning.plan(checker, {**named[0], "panda_joint1": np.nan}, ends[1])


def test_planar_ends_by_names():
    checker = pc.planar.Checker(pc.planar.Robot.load("forklift"), pc.planar.Scene.load("parking"))
    ends = checker.scene.start("forklift"), checker.scene.goal("forklift")
    named = [dict(zip(checker.robot.joint_names, q, strict=True)) for q in ends]
    found = [planning.plan(checker, *pair, seed=2, simplify=False) for pair in (ends, named)]
    assert found[0].solved
    assert np.array_equal(found[0].path, found[1].path)
