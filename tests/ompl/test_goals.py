"""Several goals, goals that a function yields, and what is just beyond a limit."""

import itertools
import re
import subprocess
import sys
import time
import warnings

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.cli.main import main
from plannercheck.ompl.plans import Plan


@pytest.fixture(scope="module")
def scene():
    return pc.Scene.load("bookshelf")


@pytest.fixture(scope="module")
def checker(scene):
    return pc.Checker(pc.Robot.load("panda"), scene)


@pytest.fixture(scope="module")
def ends(scene):
    return scene.start("panda"), scene.goal("panda")


def colliding(checker):
    q = checker.robot.random_configurations(200, seed=4)
    return q[~checker.check_states(q)]


FORMS = {
    "array": lambda checker, goals: np.array(goals),
    "list": lambda checker, goals: [list(q) for q in goals],
    "names": lambda checker, goals: [dict(zip(checker.robot.joint_names, q, strict=True)) for q in goals],
    "generator": lambda checker, goals: lambda: (q for q in goals),
    "returned array": lambda checker, goals: lambda: np.array(goals),
}


@pytest.mark.parametrize(
    ("planner", "form"),
    [
        *(("auto", form) for form in FORMS),
        *((planner, "array") for planner in ("RRTConnect", "LBKPIECE1", "KPIECE1", "BITstar", "PRM")),
    ],
)
def test_the_plan_says_which_goal_it_reached(checker, ends, form, planner, tmp_path):
    """The goals that collide or are beyond the limits are left out; of the two others, either will do."""
    start, goal = ends
    goals = [*colliding(checker)[:2], goal + 9.0, goal, goal - 0.01]
    plan = pc.ompl.plan(checker, start, FORMS[form](checker, goals), planner, time_limit=3.0, seed=1)
    assert plan.solved, plan.reason
    assert plan.goal in (3, 4)
    np.testing.assert_array_equal(plan.path[[0, -1]], [start, goals[plan.goal]])
    assert checker.check_motions(plan.path[:-1], plan.path[1:]).all()
    plan.save(tmp_path / "plan.json")
    assert Plan.load(tmp_path / "plan.json").goal == plan.goal


# Two walls: from the left part, one of three free goals can be reached. A planner that waits for its own thread holds
# Python's lock for ever, so that only another process can end it.
AMONG_WALLS = """
import signal, sys
import plannercheck as pc
from plannercheck.common.progress import reported_to

def alarm(number, frame):
    raise KeyboardInterrupt

planner, folder, is_heard, is_interrupted = sys.argv[1], sys.argv[2], *map(int, sys.argv[3:])
scene = pc.Scene("walls")
for x in (-0.2, 0.4):
    scene.add_box(f"wall at {x}", [0.02, 0.5, 0.5], [[1, 0, 0, x], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
checker = pc.Checker(pc.Robot.load(folder + "/slider.urdf"), scene)
heard = []
with reported_to(lambda *report: heard.append(report) if is_heard else None):
    if is_interrupted:
        assert pc.ompl.plan(checker, [-0.9], [-0.4], planner, time_limit=0.1).solved  # all is imported
        heard.clear()
        signal.signal(signal.SIGALRM, alarm)
        signal.setitimer(signal.ITIMER_REAL, 0.4)
        try:
            print(pc.ompl.plan(checker, [-0.9], [[0.1], [0.8], [0.9]], planner, time_limit=30.0, seed=1))
        except KeyboardInterrupt:
            print("interrupted")
    else:
        goals = [[0.1], [0.8], [-0.4]]
        for given in (goals, goals[::-1], lambda: iter(goals)):
            plan = pc.ompl.plan(checker, [-0.9], given, planner, time_limit=0.5, seed=1)
            print(plan.goal, plan.path[-1, 0] if plan.solved else plan.reason)
print("heard" if heard else "silent")
"""


def among_walls(tmp_path, *arguments):
    (tmp_path / "slider.urdf").write_text(SLIDER)
    command = [sys.executable, "-c", AMONG_WALLS, arguments[0], str(tmp_path), *(str(int(a)) for a in arguments[1:])]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


@pytest.mark.parametrize(
    ("planner", "is_heard"), [("PRM", False), ("PRM", True), ("PRMstar", True), ("RRTConnect", False), ("auto", True)]
)
def test_of_three_goals_the_one_that_can_be_reached_is_found(planner, is_heard, tmp_path):
    """Whether or not somebody hears the progress: PRM's thread asks whether the time is over."""
    lines = among_walls(tmp_path, planner, is_heard, False)
    assert lines == ["2 -0.4", "0 -0.4", "2 -0.4", "heard" if is_heard else "silent"]


@pytest.mark.parametrize("planner", ["PRM", "RRTConnect", "auto"])
def test_a_search_for_several_goals_can_be_interrupted(planner, tmp_path):
    assert among_walls(tmp_path, planner, True, True) == ["interrupted", "heard"]


def test_many_goals_of_a_planner_with_a_thread_of_its_own_end_in_time(checker, ends):
    """Its goals are connected one after the other, before the search proper; the time counts."""
    began = time.perf_counter()
    q = checker.robot.random_configurations(3000, seed=4)
    plan = pc.ompl.plan(checker, ends[0], q[checker.check_states(q)], "PRM", time_limit=0.5, seed=1)
    assert time.perf_counter() - began < 5.0
    assert plan.solved or "found no path in" in plan.reason


def test_one_goal_is_number_0(checker, ends):
    assert pc.ompl.plan(checker, *ends, seed=1).goal == 0
    assert pc.ompl.plan(checker, ends[0], ends[1][None], seed=1).goal == 0
    assert pc.ompl.plan(checker, ends[0], ends[1] + 9.0).goal is None


def test_each_goal_is_reached_where_only_it_can_be(checker, ends):
    """With the others in collision, each place in the list is the one that is said."""
    others = colliding(checker)
    for k in range(4):
        goals = [*others[:k], ends[1], *others[k:3]]
        assert pc.ompl.plan(checker, ends[0], goals, seed=1).goal == k


def test_plans_with_few_goals_and_with_many_take_turns(checker, ends):
    """Spaces are kept from plan to plan, whatever the number of goals."""
    alone = pc.ompl.plan(checker, *ends, seed=2)
    for count in (3, 1, 2):
        assert pc.ompl.plan(checker, ends[0], [ends[1]] * count, seed=2).solved
    np.testing.assert_array_equal(pc.ompl.plan(checker, *ends, seed=2).path, alone.path)


def test_if_no_goal_will_do_the_reason_says_of_each_why(checker, ends):
    goals = [*colliding(checker)[:4], ends[1] + 9.0]
    for given in (goals, lambda: iter(goals)):
        plan = pc.ompl.plan(checker, ends[0], given)
        assert not plan.solved
        assert "goal 0 collides" in plan.reason
        assert "goal 2 collides" in plan.reason
        assert "and 2 more goals" in plan.reason
    assert "yielded none" in pc.ompl.plan(checker, ends[0], list).reason


def test_a_function_that_never_ends_is_asked_for_some(checker, ends):
    asked = itertools.count()

    def reaching():
        while True:
            yield ends[1] + 1e-3 * (next(asked) % 7)

    assert pc.ompl.plan(checker, ends[0], reaching, seed=1).solved
    assert next(asked) <= 17


def test_a_function_that_never_yields_a_free_goal_ends_in_time(checker, ends):
    bad = colliding(checker)[0]
    began = time.perf_counter()
    plan = pc.ompl.plan(checker, ends[0], lambda: itertools.repeat(bad), time_limit=0.3)
    assert not plan.solved
    assert "more goals" in plan.reason
    assert time.perf_counter() - began < 3.0


@pytest.mark.parametrize(
    ("goal", "message"),
    [
        (np.zeros((0, 7)), "one or more"),
        ([[0.0] * 7, [0.0] * 6], "goal 1"),
        (np.zeros((2, 6)), "goal 0"),
        (np.zeros((1, 2, 7)), "goal"),
        (lambda: None, "must yield"),
        (lambda: np.zeros(7), "one after the other"),
        (lambda: iter([[0.0] * 6]), "goal 0"),
        (lambda: {"panda_joint1": 0.0}, "must yield"),
    ],
)
def test_what_is_no_goal(checker, ends, goal, message):
    with pytest.raises(pc.PlannercheckError, match=message):
        pc.ompl.plan(checker, ends[0], goal)


def test_errors_of_the_function_come_through(checker, ends):
    def broken():
        yield ends[1]
        raise RuntimeError("no inverse kinematics")

    with pytest.raises(RuntimeError, match="no inverse kinematics"):
        pc.ompl.plan(checker, ends[0], broken)


# ----- just beyond a limit


@pytest.fixture
def free():
    return pc.Checker(pc.Robot.load("panda"))


@pytest.mark.parametrize("by", [1e-15, 3e-9, 9e-7])
@pytest.mark.parametrize("which", ["start", "goal"])
@pytest.mark.parametrize("side", ["lower", "upper"])
def test_what_is_just_beyond_a_limit_is_taken_at_it(free, ends, by, which, side):
    robot, given = free.robot, {"start": ends[0].copy(), "goal": ends[1].copy()}
    limit = getattr(robot, side)[0]
    given[which][0] = limit + (by if side == "upper" else -by)
    with pytest.warns(RuntimeWarning, match=f"{which}: panda_joint1 is .* taken as the limit") as caught:
        plan = pc.ompl.plan(free, **given, seed=1)
    assert plan.solved, plan.reason
    assert plan.path[0 if which == "start" else -1, 0] == limit
    assert repr(float(given[which][0])) in str(caught[0].message)  # all of its digits


def test_what_is_further_beyond_is_refused_with_enough_digits(free, ends):
    start = ends[0].copy()
    start[0] = free.robot.upper[0] + 2e-6
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        plan = pc.ompl.plan(free, start, ends[1])
    assert not plan.solved
    assert f"panda_joint1 is {start[0]:.12g}, not in" in plan.reason
    assert f"{start[0]:.12g}" != f"{free.robot.upper[0]:.12g}"


# ----- the command line


def test_without_a_scene_the_command_plans_in_the_empty_one(capsys, tmp_path, ends):
    given = [f"--{name}={','.join(map(repr, q.tolist()))}" for name, q in zip(("start", "goal"), ends, strict=True)]
    out = tmp_path / "plan.json"
    assert main(["plan", "--robot", "panda", *given, "--seed", "1", "--output", str(out)]) == 0
    assert len(Plan.load(out).path) == 2  # nothing is in the way
    capsys.readouterr()


SLIDER = """<robot name="slider"><link name="base"/><link name="block">
<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
<joint name="slide" type="prismatic"><parent link="base"/><child link="block"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""


@pytest.mark.parametrize("planner", ["auto", "RRTConnect", "RRT", "RRTstar"])
def test_no_path_is_said_plainly(tmp_path, planner):
    """A block before a wall; OMPL's "Approximate solution" is none."""
    (tmp_path / "slider.urdf").write_text(SLIDER)
    scene = pc.Scene("wall")
    scene.add_box("wall", [0.1, 0.5, 0.5])
    checker = pc.Checker(pc.Robot.load(tmp_path / "slider.urdf"), scene)
    plan = pc.ompl.plan(checker, [-0.5], [[0.5], [0.6]], planner, time_limit=0.3)
    assert not plan.solved
    assert plan.goal is None
    assert re.fullmatch(rf"{planner} found no path in 0\.\d s", plan.reason)
