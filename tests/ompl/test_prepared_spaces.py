"""Spaces that are kept from plan to plan: plans stay independent, checkers are freed, exceptions and Ctrl-C get out."""

import gc
import signal
import subprocess
import sys
import threading
import time
import weakref

import numpy as np
import pytest
from ompl import base, geometric

import plannercheck as pc
from plannercheck.common.core import core
from plannercheck.ompl import prepared_spaces, space_of
from plannercheck.ompl.joint_space import JointSpace

P = pc.planar
PLANNERS = ("RRTConnect", "KPIECE1", "RRT", "LBKPIECE1", "PRM", "BKPIECE1")


@pytest.fixture(scope="module")
def ends(checker):
    q = checker.robot.random_configurations(400, 2)
    return q[checker.check_states(q)]


def forklift():
    return P.Checker(P.Robot.load("forklift"), P.Scene.load("parking"))


def kept_of(checker):
    return [space for spaces in prepared_spaces._KEPT.get(checker, {}).values() for space in spaces]


def planned_anew(checker, start, goal, planner, seed):
    """The plan of a set-up that nobody has used, step by step as `pc.ompl.setup` is documented."""
    space = space_of(checker)
    prepared_spaces.util.RNG.setSeed(seed)
    setup = pc.ompl.setup(checker)
    information = setup.getSpaceInformation()
    setup.setStartAndGoalStates(space.state(information, start), space.state(information, goal))
    made = getattr(geometric, planner)(information)
    made.setRange(pc.ompl.LONGEST_MOTION)
    setup.setPlanner(made)
    setup.solve(base.timedPlannerTerminationCondition(10.0))
    return np.array([space.read(state) for state in setup.getSolutionPath().getStates()])


@pytest.mark.parametrize("planner", ["RRTConnect", "RRT", "KPIECE1"])
def test_a_seed_gives_the_same_plan_whatever_was_planned_before(checker, ends, planner):
    fresh = pc.Checker(checker.robot, checker.scene)  # nothing is kept for it
    for i in range(3):
        start, seed = ends[i], i + 1
        goal = ends[np.linalg.norm(ends - start, axis=1).argsort()[1]]  # the nearest, or RRT may search for long
        expected = planned_anew(fresh, start, goal, planner, seed)
        options = {"seed": seed, "simplify": False, "sampling": "everywhere"}
        first = pc.ompl.plan(pc.Checker(checker.robot, checker.scene), start, goal, planner, **options)
        for other in PLANNERS:
            pc.ompl.plan(checker, ends[i + 20], ends[i + 30], other, time_limit=0.05)
        again = pc.ompl.plan(checker, start, goal, planner, **options)
        assert np.array_equal(first.path, expected)
        assert np.array_equal(again.path, expected)


@pytest.mark.parametrize("simplify", [False, True])
def test_plans_of_many_threads_have_their_own_ends(checker, ends, simplify):
    found, start = {}, threading.Barrier(6)

    def work(k):
        start.wait()
        for i in range(k, k + 5):
            planner = ("RRTConnect", "RRT")[i % 2]
            found[k, i] = pc.ompl.plan(checker, ends[i], ends[-1 - i], planner, 2.0, simplify)

    threads = [threading.Thread(target=work, args=(k,)) for k in range(0, 30, 5)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 30
    assert sum(plan.solved for plan in found.values()) > 15
    for (_, i), plan in found.items():
        if plan.solved:
            assert np.array_equal(plan.path[[0, -1]], [ends[i], ends[-1 - i]])
            assert checker.check_motions(plan.path[:-1], plan.path[1:]).all()


def test_a_space_is_borrowed_by_one_plan_at_a_time_and_used_again():
    checker = forklift()
    borrowed = [prepared_spaces.borrowed_space(checker, "RRTConnect", None, "straight", None, ()) for _ in range(3)]
    assert len({id(each.information.getStateSpace()) for each in borrowed}) == 3
    for each in borrowed:
        prepared_spaces.returned_space(each)
    assert prepared_spaces.borrowed_space(checker, "RRT", None, "straight", None, ()) in borrowed
    assert len(kept_of(checker)) == 2


def test_plans_that_differ_in_resolution_or_curve_have_spaces_of_their_own():
    checker = forklift()
    ends = checker.scene.start("forklift"), checker.scene.goal("forklift")
    for options in ({}, {"resolution": 0.05}, {"curve": "reeds_shepp", "turning_radius": 1.5}, {}):
        pc.ompl.plan(checker, *ends, seed=1, simplify=False, **options)
    assert len(kept_of(checker)) == 3


def test_spaces_whose_bounds_depend_on_the_ends_are_not_kept(tmp_path):
    """A joint that another one follows at half its speed: whole turns count, so the ends may be anywhere."""
    urdf = tmp_path / "geared.urdf"
    urdf.write_text(
        """<robot name="geared"><link name="a"/><link name="b"/>
<link name="c"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
<joint name="turn" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint>
<joint name="half" type="continuous"><parent link="b"/><child link="c"/><axis xyz="0 0 1"/>
<mimic joint="turn" multiplier="0.5"/></joint></robot>"""
    )
    checker = pc.Checker(pc.Robot.from_urdf(urdf, group=["turn"]))
    assert JointSpace(checker.robot).depends_on_ends
    for goal in (30.0, 300.0):
        plan = pc.ompl.plan(checker, [0.0], [goal], seed=1, simplify=False)
        assert plan.solved
        assert plan.path[-1] == goal
    assert kept_of(checker) == []


@pytest.mark.parametrize("options", [{}, {"resolution": 0.05}])
@pytest.mark.parametrize("make", [lambda: pc.Checker(pc.Robot.load("panda")), forklift])
def test_a_checker_is_freed_though_spaces_were_kept_for_it(make, options):
    checker = make()
    q = checker.robot.random_configurations(100, 1)
    start, goal = q[checker.check_states(q)][:2]
    pc.ompl.plan(checker, start, goal, time_limit=1.0, simplify=False, **options)
    (kept,) = kept_of(checker)
    gone, space_gone = weakref.ref(checker), weakref.ref(kept)
    del checker, kept
    gc.collect()
    assert gone() is None
    assert space_gone() is None


def test_a_set_up_outlives_the_checker_and_its_kept_spaces(ends):
    made = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"))
    pc.ompl.plan(made, ends[0], ends[1], simplify=False)
    setup, space = pc.ompl.setup(made), space_of(made)
    information = setup.getSpaceInformation()
    expected = [made.is_valid(q) for q in ends[:50] * 1.1]
    del made
    gc.collect()
    assert [information.isValid(space.state(information, q)) for q in ends[:50] * 1.1] == expected
    assert np.isfinite(information.getStateValidityChecker().clearance(space.state(information, ends[0])))
    setup.setStartAndGoalStates(*(space.state(information, q) for q in ends[:2]))
    assert setup.solve(10.0)


def test_an_exception_in_a_plan_gets_out_and_its_space_is_not_used_again(checker, ends, monkeypatch):
    made = pc.Checker(checker.robot, checker.scene)
    pc.ompl.plan(made, ends[0], ends[1], simplify=False)
    (kept,) = kept_of(made)
    judge = kept.information.getStateValidityChecker()

    def fail(state):
        raise ZeroDivisionError("within")

    monkeypatch.setitem(judge.__dict__, "isValid", fail)
    with pytest.raises(ZeroDivisionError, match="within"):
        pc.ompl.plan(made, ends[0], ends[1], simplify=False)
    assert kept_of(made) == []
    assert pc.ompl.plan(made, ends[0], ends[1], simplify=False).solved


@pytest.fixture
def _alarm_as_ctrl_c():
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    yield
    signal.setitimer(signal.ITIMER_REAL, 0)
    signal.signal(signal.SIGALRM, before)


@pytest.mark.usefixtures("_alarm_as_ctrl_c")
@pytest.mark.parametrize("planner", ["RRTstar", "InformedRRTstar", "BITstar", "PRMstar"])
def test_ctrl_c_ends_a_search_of_compiled_calls(checker, ends, planner):
    """No line of Python runs while a planner searches; these look for shorter paths until their time is over.

    PRMstar has a thread of its own: an exception that passed through it would end the process.
    """
    made = pc.Checker(checker.robot, checker.scene)
    began = time.perf_counter()
    signal.setitimer(signal.ITIMER_REAL, 0.3)
    with pytest.raises(KeyboardInterrupt):
        pc.ompl.plan(made, ends[0], ends[1], planner, time_limit=20.0)
    assert time.perf_counter() - began < 5.0
    assert kept_of(made) == []


@pytest.mark.usefixtures("_alarm_as_ctrl_c")
@pytest.mark.parametrize("options", [{}, {"resolution": 0.02}])
def test_ctrl_c_ends_a_search_in_the_plane(options):
    made = forklift()
    signal.setitimer(signal.ITIMER_REAL, 0.3)
    with pytest.raises(KeyboardInterrupt):
        pc.ompl.plan(
            made, made.scene.start("forklift"), made.scene.goal("forklift"), "PRMstar", time_limit=20.0, **options
        )
    assert kept_of(made) == []


def test_an_exception_beyond_the_limits_ends_the_search(checker, ends, monkeypatch):
    """A space wider than the limits: states beyond them are judged in Python, which fails."""
    made = pc.Checker(checker.robot, checker.scene)
    setup, space = pc.ompl.setup(made), space_of(made)
    information, bounds = setup.getSpaceInformation(), base.RealVectorBounds(7)
    bounds.setLow(-6.0)
    bounds.setHigh(6.0)
    setup.getStateSpace().setBounds(bounds)
    tables, asked = type(made._tables), []

    def fail(*arguments):
        asked.append(None)
        raise ZeroDivisionError(f"call {len(asked)}")

    beyond = space.state(information, made.robot.upper + 0.1)
    setup.setStartAndGoalStates(*(space.state(information, q) for q in ends[:2]))
    setup.setPlanner(geometric.RRTConnect(information))
    expected = information.isValid(beyond)
    monkeypatch.setattr(tables, "check_states", fail)
    with pytest.raises(ZeroDivisionError, match="call 1"):
        setup.solve(20.0)
    with pytest.raises(ZeroDivisionError, match="call"):  # no planner runs
        information.isValid(beyond)
    monkeypatch.undo()
    assert information.isValid(beyond) == expected


def test_of_two_exceptions_the_first_one_is_kept():
    """A planner with threads of its own may ask again before it stops."""
    failure, stopped = core.PlannerFailure(), []

    def fail(state):
        raise ZeroDivisionError(state)

    judge = core.remembered_failures(fail, failure)
    failure.arm(lambda: stopped.append(None))
    assert not judge("first")
    assert not judge("second")
    assert len(stopped) == 2
    assert failure.disarm().args == ("first",)
    assert failure.disarm() is None
    with pytest.raises(ZeroDivisionError, match="third"):
        judge("third")


PROGRAM = """
import plannercheck as pc
from ompl import util

checker = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"))
ends = checker.scene.start("panda"), checker.scene.goal("panda")
for planner in ("RRTConnect", "RRTConnect", "KPIECE1", "RRTstar", "RRT"):
    pc.ompl.plan(checker, *ends, planner, time_limit=0.3, seed=1)
turning = pc.Checker(pc.Robot.load("kinova"))
pc.ompl.plan(turning, turning.robot.reference, turning.robot.reference + 0.1, time_limit=0.3)
plane = pc.planar.Checker(pc.planar.Robot.load("forklift"), pc.planar.Scene.load("parking"))
for options in ({}, {"resolution": 0.05}, {"curve": "dubins", "turning_radius": 1.5}):
    pc.ompl.plan(plane, plane.scene.start("forklift"), plane.scene.goal("forklift"), time_limit=0.3, **options)
setup = pc.ompl.setup(checker)
validator = setup.getSpaceInformation().getMotionValidator()
information = pc.ompl.setup(turning).getSpaceInformation()
"""
STOPPED = """
import signal

def stop(*_):
    raise SystemExit(0)

signal.signal(signal.SIGALRM, stop)
signal.setitimer(signal.ITIMER_REAL, 0.3)
pc.ompl.plan(checker, *ends, "RRTstar", time_limit=20.0)
raise AssertionError("it was not stopped")
"""


@pytest.mark.parametrize("end", ["", STOPPED, "del checker, turning, plane"])
def test_a_program_leaves_no_leaks(end):
    done = subprocess.run([sys.executable, "-c", PROGRAM + end], capture_output=True, text=True, check=True)
    assert done.stdout == ""
    assert done.stderr == ""
