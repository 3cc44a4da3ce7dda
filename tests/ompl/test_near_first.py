"""Searches that sample near start and goal first: what the planner is given, and that nothing is lost by it."""

from itertools import pairwise

import numpy as np
import pytest
from ompl import base, geometric, util

import plannercheck as pc
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError
from plannercheck.motions.checker import Checker
from plannercheck.ompl import near_first, planning
from plannercheck.ompl.joint_space import JointSpace
from plannercheck.ompl.near_first import solve_near_first
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene

# An arm that turns and lifts, both by -3 to 3 rad; its configurations are (turn, lift).
ARM = """<robot name="turning"><link name="base"/><link name="post"/>
<joint name="turn" type="revolute"><parent link="base"/><child link="post"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<link name="arm"><collision><origin xyz="0.5 0 0"/><geometry><box size="0.8 0.1 0.1"/></geometry></collision></link>
<joint name="lift" type="revolute"><parent link="post"/><child link="arm"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint></robot>"""


class Recorded:
    """Stands for an OMPL set-up: notes the bounds of each search, asks its condition, and solves the last one."""

    def __init__(self, space, solved_in: int) -> None:
        self.space, self.solved_in = space, solved_in
        self.bounds: list[tuple[list[float], list[float]]] = []
        self.asked: list[int] = []

    def setup(self):
        assert (list(self.space.getBounds().low), list(self.space.getBounds().high)) == ([-3.0, -3.0], [3.0, 3.0])

    def getStateSpace(self):  # noqa: N802  # OMPL's name
        return self.space

    def haveExactSolutionPath(self):  # noqa: N802
        return len(self.bounds) >= self.solved_in

    def solve(self, condition):
        bounds = self.space.getBounds()
        self.bounds.append((list(bounds.low), list(bounds.high)))
        self.asked.append(next((k for k in range(5000) if condition.eval()), 5000))
        return f"status {len(self.bounds)}"


@pytest.fixture
def turning(tmp_path) -> Robot:
    path = tmp_path / "turning.urdf"
    path.write_text(ARM)
    return Robot.from_urdf(path)


def never() -> object:
    return base.timedPlannerTerminationCondition(1e6)


def behind_a_wall(robot: Robot) -> Checker:
    """The arm passes the wall only where it is lifted by a radian or more."""
    scene, pose = Scene("wall"), np.eye(4)
    pose[:3, 3] = [0.6, 0.0, 0.0]
    scene.add_box("wall", [0.5, 0.02, 1.0], pose)
    return Checker(robot, scene)


def test_boxes_grow_until_they_are_the_whole_space(turning):
    space = JointSpace(turning)
    setup = Recorded(space.ompl_space(), 100)
    ends = np.array([2.75, -2.9]), np.array([2.0, 0.0])
    assert solve_near_first(setup, space, ends, never()) == "status 3"
    expected = [([1.1, -3.0], [3.0, 0.9]), ([-0.4, -3.0], [3.0, 2.4]), ([-3.0, -3.0], [3.0, 3.0])]
    np.testing.assert_allclose(setup.bounds, expected, rtol=0, atol=1e-12)
    assert min(min(low) for low, _ in setup.bounds) == -3.0
    assert max(max(high) for _, high in setup.bounds) == 3.0


def test_each_box_has_iterations_of_its_own(turning):
    space = JointSpace(turning)
    setup = Recorded(space.ompl_space(), 100)
    solve_near_first(setup, space, (np.zeros(2), np.zeros(2)), never())
    assert setup.asked == [1000, 2000, 5000]


@pytest.mark.parametrize("solved_in", [1, 2, 3])
def test_the_space_has_all_its_bounds_again(turning, solved_in):
    space = JointSpace(turning)
    setup = Recorded(space.ompl_space(), solved_in)
    assert solve_near_first(setup, space, (np.zeros(2), np.ones(2)), never()) == f"status {solved_in}"
    bounds = setup.space.getBounds()
    assert (list(bounds.low), list(bounds.high)) == ([-3.0, -3.0], [3.0, 3.0])


def test_the_space_has_all_its_bounds_again_after_an_error(turning):
    space = JointSpace(turning)

    class Failing(Recorded):
        def solve(self, condition):
            raise KeyboardInterrupt

    setup = Failing(space.ompl_space(), 1)
    with pytest.raises(KeyboardInterrupt):
        solve_near_first(setup, space, (np.zeros(2), np.ones(2)), never())
    assert list(setup.space.getBounds().low) == [-3.0, -3.0]


def test_a_search_ends_when_its_time_is_over(turning):
    space = JointSpace(turning)
    setup = Recorded(space.ompl_space(), 100)
    over = base.timedPlannerTerminationCondition(1e-9)
    assert solve_near_first(setup, space, (np.zeros(2), np.ones(2)), over) == "status 1"
    assert setup.asked == [0]


def test_a_limit_of_calls_counts_them():
    limit = core.call_limit(3)
    assert [limit() for _ in range(5)] == [False, False, False, True, True]
    assert core.call_limit(0)()


def test_angles_keep_their_circle():
    robot = Robot.load("kinova")
    space = JointSpace(robot)
    ompl_space = space.ompl_space()
    a, b = robot.random_configurations(2, seed=3)
    bounded = np.flatnonzero(~space.continuous)
    assert 0 < len(bounded) < robot.nq
    space.bound(ompl_space, *near_first.box_around(space, (a, b), 0.1))
    for k in bounded:
        part, room = ompl_space.getSubspace(int(k)).getBounds(), 0.1 * (robot.upper[k] - robot.lower[k])
        assert part.low[0] == max(robot.lower[k], min(a[k], b[k]) - room)
        assert part.high[0] == min(robot.upper[k], max(a[k], b[k]) + room)


def test_a_path_that_leaves_the_first_boxes_is_found(turning):
    checker = behind_a_wall(turning)
    ends = np.array([0.3, 0.0]), np.array([-0.3, 0.0])
    assert not checker.check_motion(*ends)
    found = pc.ompl.plan(checker, *ends, seed=1, simplify=False)
    assert found.solved
    assert np.abs(found.path[:, 1]).max() > near_first.STAGES[0][0] * 6


# Two slides that carry a box past a long wall.
GANTRY = """<robot name="gantry"><link name="base"/><link name="bridge"/>
<joint name="x" type="prismatic"><parent link="base"/><child link="bridge"/><axis xyz="1 0 0"/>
<limit lower="-{0}" upper="{0}" effort="1" velocity="1"/></joint>
<link name="box"><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
<joint name="y" type="prismatic"><parent link="bridge"/><child link="box"/><axis xyz="0 1 0"/>
<limit lower="-{0}" upper="{0}" effort="1" velocity="1"/></joint></robot>"""


@pytest.fixture(params=[2, 100])
def gantry(request, tmp_path) -> Checker:
    path = tmp_path / "gantry.urdf"
    path.write_text(GANTRY.format(request.param))
    scene = Scene("wall")
    scene.add_box("wall", [0.2, 1.2 * request.param, 0.2])
    return Checker(Robot.from_urdf(path), scene)


@pytest.mark.parametrize("seed", [1, 2])
def test_long_slides_find_their_way_around(gantry, seed):
    """Room by a fixed length took a hundred thousand iterations before it reached around the wall."""
    found = pc.ompl.plan(gantry, [-1.0, 0.0], [1.0, 0.0], seed=seed, simplify=False, longest_motion=0, time_limit=5)
    assert found.solved
    assert gantry.check_motions(found.path[:-1], found.path[1:]).all()


@pytest.mark.parametrize("longest", [0.0, 0.4])
def test_the_range_is_ompls_own_unless_it_is_set(turning, longest):
    """Of the whole space, whatever box comes first."""
    ranges = []
    for near in (True, False):
        setup, space = pc.ompl.setup(behind_a_wall(turning)), JointSpace(turning)
        planner = planning.made_planner("RRTConnect", setup.getSpaceInformation(), longest)
        setup.setPlanner(planner)
        ends = np.array([0.3, 0.0]), np.array([-0.3, 0.0])
        setup.setStartAndGoalStates(*(space.state(setup.getSpaceInformation(), q) for q in ends))
        solve_near_first(setup, space, ends, never()) if near else setup.solve(never())
        ranges.append(planner.getRange())
    assert ranges[0] == ranges[1] == (longest or pytest.approx(0.2 * np.hypot(6, 6)))


@pytest.mark.parametrize("problem", [("panda", "bookshelf"), ("baxter", "kitchen"), ("kinova", "kitchen")])
def test_both_samplings_find_proved_paths_within_the_limits(problem):
    checker = Checker(Robot.load(problem[0]), Scene.load(problem[1]))
    q = checker.robot.random_configurations(60, seed=4)
    q = q[checker.check_states(q)]
    for start, goal in list(pairwise(q))[:4]:
        for sampling in planning.SAMPLINGS:
            found = pc.ompl.plan(checker, start, goal, seed=2, simplify=False, sampling=sampling)
            assert found.solved
            assert checker.check_motions(found.path[:-1], found.path[1:]).all()
            assert (found.path >= checker.robot.lower).all()
            assert (found.path <= checker.robot.upper).all()


def test_everywhere_is_ompls_own_search():
    checker = Checker(Robot.load("panda"), Scene.load("bookshelf"))
    start, goal = checker.scene.start("panda"), checker.scene.goal("panda")
    pc.ompl.plan(checker, start, goal, seed=3)  # its space is kept, with all bounds
    found = pc.ompl.plan(checker, start, goal, seed=3, simplify=False, sampling="everywhere")
    setup, space = pc.ompl.setup(checker), JointSpace(checker.robot)
    information = setup.getSpaceInformation()
    with planning.OMPL_SILENCE():
        util.RNG.setSeed(3)
    setup.setStartAndGoalStates(space.state(information, start), space.state(information, goal))
    planner = geometric.RRTConnect(information)
    planner.setRange(pc.ompl.LONGEST_MOTION)
    setup.setPlanner(planner)
    setup.solve(10.0)
    own = np.array([space.read(state) for state in setup.getSolutionPath().getStates()])
    assert np.array_equal(found.path, own)


def test_a_seed_gives_the_same_search_again():
    checker = Checker(Robot.load("panda"), Scene.load("cage"))
    q = checker.robot.random_configurations(60, seed=4)
    start, goal = q[checker.check_states(q)][:2]
    plans = [pc.ompl.plan(checker, start, goal, seed=7, simplify=False) for _ in range(3)]
    assert all(np.array_equal(plan.path, plans[0].path) for plan in plans)


def test_other_planners_sample_everywhere(turning):
    checker = Checker(turning, Scene("empty"))
    paths = [
        pc.ompl.plan(checker, [0, 0], [1, 1], planner="RRT", seed=5, simplify=False, sampling=sampling).path
        for sampling in planning.SAMPLINGS
    ]
    assert np.array_equal(*paths)


def test_an_unknown_sampling_is_named(turning):
    with pytest.raises(PlannercheckError, match=r"sampling 'nearby'.*near, everywhere"):
        pc.ompl.plan(Checker(turning, Scene("empty")), [0, 0], [1, 1], sampling="nearby")
