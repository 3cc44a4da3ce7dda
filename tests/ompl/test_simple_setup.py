"""What `setup` gives beyond OMPL's SimpleSetup: simplified paths are checked, and programs end without leaks."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from ompl import geometric

import plannercheck as pc
from plannercheck.common.package_data import shipped_folder
from plannercheck.ompl import setup, space_of
from plannercheck.ompl.simple_setup import INFORMED_PLANNERS

P = pc.planar
PAGE = Path(__file__).parents[2] / "docs" / "how_to" / "plan_with_ompl.md"


@pytest.fixture
def solved():
    """A set-up with a path on Reeds-Shepp curves; the straight way from its start to its goal collides."""
    checker = P.Checker(P.Robot.load("forklift"), P.Scene.load("parking"))
    options = {"curve": "reeds_shepp", "turning_radius": 1.5}
    made, space = setup(checker, **options), space_of(checker, **options)
    information = made.getSpaceInformation()
    ends = checker.scene.start("forklift"), checker.scene.goal("forklift")
    made.setStartAndGoalStates(*(space.state(information, q) for q in ends))
    made.setPlanner(geometric.RRTConnect(information))
    made.solve(10.0)
    assert made.haveExactSolutionPath()
    return made, space


def configurations(made, space):
    return np.array([space.read(state) for state in made.getSolutionPath().getStates()])


def cut(made, *_):
    """A simplifier as bad as can be: it leaves the ends alone."""
    path = made.getSolutionPath()
    short = geometric.PathGeometric(path)
    short.keepBefore(path.getState(0))
    short.append(path.getState(path.getStateCount() - 1))
    path.assign(short)


def test_a_path_that_simplifying_breaks_is_kept_as_it_was(solved, monkeypatch):
    made, space = solved
    found = configurations(made, space)
    monkeypatch.setattr(geometric.SimpleSetup, "simplifySolution", cut)
    cut(made)
    assert not made.getSolutionPath().check(), "the case must be one"
    made.getSolutionPath().clear()
    for q in found:
        made.getSolutionPath().append(space.state(made.getSpaceInformation(), q))
    made.simplifySolution(0.1)
    assert np.array_equal(configurations(made, space), found)


@pytest.mark.parametrize("limit", [0.2, None])
def test_a_path_that_is_free_is_simplified(solved, limit):
    made, _ = solved
    before = made.getSolutionPath().length()
    made.simplifySolution(*([] if limit is None else [limit]))
    assert made.getSolutionPath().check()
    assert made.getSolutionPath().length() < before


def test_a_plan_is_not_simplified_into_a_collision(monkeypatch):
    """Whatever OMPL's simplifier says of what it has done."""

    def claim(_, path, *__, **___):
        path.keepBefore(path.getState(0))
        path.append(last)
        return True

    checker = P.Checker(P.Robot.load("forklift"), P.Scene.load("parking"))
    space = space_of(checker)
    ends = checker.scene.start("forklift"), checker.scene.goal("forklift")
    information = setup(checker).getSpaceInformation()
    last = space.state(information, ends[1])
    assert not checker.check_motion(*ends)
    monkeypatch.setattr(geometric.PathSimplifier, "simplify", claim)
    found = pc.ompl.plan(checker, *ends, seed=1)
    assert found.solved
    assert checker.check_motions(found.path[:-1], found.path[1:]).all()


@pytest.mark.parametrize("name", INFORMED_PLANNERS)
@pytest.mark.parametrize("several", [False, True])
def test_goals_in_sight_of_the_start_are_reached_at_once(name, several):
    """OMPL 2.0.1's SORRTstar would never return, and AORRTC drop the start of its path."""
    checker = pc.Checker(pc.Robot.load("panda"))
    start = checker.robot.reference
    goals = [start + 0.1, start - 0.1]
    found = pc.ompl.plan(checker, start, goals if several else goals[0], name, 1.0, simplify=False, seed=1)
    assert np.array_equal(found.path, [start, goals[found.goal]])
    assert found.time < 0.9


@pytest.mark.parametrize("name", ["InformedRRTstar", "RRTConnect", "SORRTstar"])
@pytest.mark.parametrize("several", [False, True])
def test_a_goal_that_is_the_start_is_reached(name, several):
    checker = pc.Checker(pc.Robot.load("panda"))
    start, other = checker.robot.reference, checker.robot.reference + 0.1
    found = pc.ompl.plan(checker, start, [other, start] if several else start, name, 0.2, seed=1)
    assert found.solved
    assert np.array_equal(found.path[0], start)
    assert np.array_equal(found.path[-1], [other, start][found.goal] if several else start)


def test_a_path_from_elsewhere_is_none(monkeypatch):
    checker = P.Checker(P.Robot.load("forklift"), P.Scene.load("parking"))
    made, space = setup(checker), space_of(checker)
    information = made.getSpaceInformation()
    start, goal = (space.state(information, getattr(checker.scene, end)("forklift")) for end in ("start", "goal"))

    def claim(problem, *_):
        problem.getProblemDefinition().addSolutionPath(geometric.PathGeometric(information, goal, goal))

    made.setStartAndGoalStates(start, goal)
    monkeypatch.setattr(geometric.SimpleSetup, "solve", claim)
    made.solve(0.1)
    assert made.refused_path
    assert not made.haveExactSolutionPath()


def test_without_a_path_there_is_nothing_to_simplify():
    setup(P.Checker(P.Robot.load("forklift"), P.Scene.load("parking"))).simplifySolution(0.1)


OWN_CLASSES = """
import plannercheck as pc
from ompl import base, geometric, util

util.setLogLevel(util.LOG_NONE)
scene = pc.Scene.load("bookshelf")
checker = pc.Checker(pc.Robot.load("panda"), scene)
setup = pc.ompl.setup(checker)
information = setup.getSpaceInformation()
start = information.allocState()
start[0:7] = list(scene.start("panda"))
space = setup.getStateSpace()


class Near(base.{goal}):
    def __init__(self, information):
        super().__init__(information)
        self.information = information
        self.setThreshold(0.5)

    def distanceGoal(self, state):
        return max(abs(state[k] - scene.goal("panda")[k]) for k in range(7))

    def sampleGoal(self, state):
        state[0:7] = list(scene.goal("panda"))

    def maxSampleCount(self):
        return 5


class States(base.StateValidityChecker):
    def isValid(self, state):
        return checker.is_valid([state[k] for k in range(7)])


class Motions(base.MotionValidator):
    def checkMotion(self, first, second):
        return checker.check_motion([first[k] for k in range(7)], [second[k] for k in range(7)])


class Length(base.OptimizationObjective):
    def stateCost(self, state):
        return base.Cost(0.0)

    def motionCost(self, first, second):
        return base.Cost(space.distance(first, second))


class Middle(base.ValidStateSampler):
    def sample(self, state):
        state[0:7] = list(checker.robot.reference)
        return True


setup.setStateValidityChecker(States(information))
information.setMotionValidator(Motions(information))
information.setValidStateSamplerAllocator(lambda asked: Middle(asked))
setup.setOptimizationObjective(Length(information))
setup.setStartState(start)
setup.setGoal(Near(information))
setup.setPlanner(geometric.RRTstar(information))
solved = setup.solve(0.3)
"""


def messages_of(program):
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    return done.stderr


@pytest.mark.parametrize("goal", ["GoalRegion", "GoalSampleableRegion"])
def test_a_program_with_classes_of_its_own_leaves_no_leaks(goal):
    assert messages_of(OWN_CLASSES.replace("{goal}", goal)) == ""


def test_the_program_of_the_docs_leaves_no_leaks(tmp_path):
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    shutil.copytree(shipped_folder("configs") / "puzzles", tmp_path / "configs/puzzles")
    done = subprocess.run(
        [sys.executable, "-c", "\n".join(blocks)], capture_output=True, text=True, check=True, cwd=tmp_path
    )
    assert "nanobind" not in done.stderr
