"""Two planners that take turns: who is on when, and that a seed gives one path."""

import numpy as np
import pytest
from ompl import base

import plannercheck as pc
from plannercheck.common.core import core
from plannercheck.ompl import planning, searches
from plannercheck.ompl.searches import FIRST_TURN, LONGEST_TURN, Search, in_turns


class Recorded:
    """Stands for a search: notes its turns, and has a path after so many of them."""

    def __init__(self, name: str, turns: list[tuple[str, int]], found_in: int) -> None:
        self.name, self.turns, self.found_in = name, turns, found_in

    def go_on(self, condition, iterations):
        self.turns.append((self.name, iterations))
        return "status"

    @property
    def has_found(self) -> bool:
        return sum(name == self.name for name, _ in self.turns) >= self.found_in


def never():
    return base.timedPlannerTerminationCondition(1e6)


def turns_until(found_in: dict[str, int]) -> list[tuple[str, int]]:
    turns: list[tuple[str, int]] = []
    search, status = in_turns(lambda name: Recorded(name, turns, found_in.get(name, 10**9)), never())
    assert (search.name, status) == (turns[-1][0], "status")
    return turns


def test_turns_grow_and_either_may_find():
    assert turns_until({"RRTConnect": 1}) == [("RRTConnect", 1000)]
    assert turns_until({"LBKPIECE1": 1}) == [("RRTConnect", 1000), ("LBKPIECE1", 5000)]
    assert turns_until({"RRTConnect": 3})[1:] == [
        *[("LBKPIECE1", 5000), ("RRTConnect", 2000), ("LBKPIECE1", 10000), ("RRTConnect", 4000)]
    ]
    long = turns_until({"LBKPIECE1": 12})
    assert long[-2:] == [("RRTConnect", LONGEST_TURN), ("LBKPIECE1", 5 * LONGEST_TURN)]
    assert sum(n for name, n in long if name == "RRTConnect") > 7 * LONGEST_TURN


def test_time_ends_the_turns():
    turns: list[tuple[str, int]] = []
    calls = base.PlannerTerminationCondition(core.call_limit(3))
    search, _ = in_turns(lambda name: Recorded(name, turns, 10**9), calls)
    assert not search.has_found
    assert 1 < len(turns) < 6


@pytest.fixture(scope="module")
def scene():
    return pc.Scene.load("bookshelf")


@pytest.fixture(scope="module")
def checker(scene):
    return pc.Checker(pc.Robot.load("panda"), scene)


def test_what_rrtconnect_finds_in_its_first_turn_is_its_own_path(checker, scene):
    ends = scene.start("panda"), scene.goal("panda")
    for seed in (1, 2, 3):
        by_turns = pc.ompl.plan(checker, *ends, seed=seed)
        alone = pc.ompl.plan(checker, *ends, "RRTConnect", seed=seed)
        assert by_turns.planner == alone.planner == "RRTConnect"
        np.testing.assert_array_equal(by_turns.path, alone.path)


class NeverFinding(Search):
    """RRTConnect that misses the way: it searches, but not for long enough (bookshelf_thin, problem 89)."""

    def go_on(self, condition, iterations=None):
        return super().go_on(condition, 2 if self.planner == "RRTConnect" else iterations)

    @property
    def has_found(self) -> bool:
        return self.planner != "RRTConnect" and super().has_found


@pytest.mark.parametrize("several", [1, 3])
def test_what_one_planner_misses_the_other_one_finds(checker, scene, monkeypatch, several):
    monkeypatch.setattr(planning, "Search", NeverFinding)
    start, goal = scene.start("panda"), scene.goal("panda")
    goals = np.array([goal + 0.01 * k for k in range(several)])
    plans = [pc.ompl.plan(checker, start, goals, seed=4, time_limit=20.0) for _ in range(3)]
    for plan in plans:
        assert plan.solved
        assert plan.planner == "LBKPIECE1"
        assert checker.check_motions(plan.path[:-1], plan.path[1:]).all()
        np.testing.assert_array_equal(plan.path, plans[0].path)  # a seed gives one path
    monkeypatch.undo()
    assert pc.ompl.plan(checker, start, goals, seed=4).planner == "RRTConnect"  # the spaces are as they were


def test_turns_serve_every_space():
    """Angles, free bodies and planar curves; the latter are checked once more the way they are gone."""
    robot = pc.Robot.load("kinova")
    q = robot.random_configurations(60, seed=1)
    checker = pc.Checker(robot)
    start, goal = q[checker.check_states(q)][:2]
    for given in (1, 10**9):
        searches_turn = searches.FIRST_TURN
        searches.FIRST_TURN = given
        try:
            assert pc.ompl.plan(checker, start, goal, seed=2).solved
        finally:
            searches.FIRST_TURN = searches_turn
    assert searches.FIRST_TURN == FIRST_TURN
    warehouse = pc.planar.Scene.load("warehouse")
    forklift = pc.planar.Checker(pc.planar.Robot.load("forklift"), warehouse)
    ends = warehouse.start("forklift"), warehouse.goal("forklift")
    plan = pc.ompl.plan(forklift, *ends, curve="reeds_shepp", turning_radius=1.5, seed=1)
    assert plan.solved, plan.reason
    assert plan.goal == 0


@pytest.mark.parametrize(("star", "full"), [("RRT*", "RRTstar"), ("BIT*", "BITstar"), ("PRM*", "PRMstar")])
def test_a_star_is_a_name(checker, scene, star, full):
    plan = pc.ompl.plan(checker, scene.start("panda"), scene.goal("panda"), star, time_limit=0.5, simplify=False)
    assert plan.planner == full
    with pytest.raises(pc.PlannercheckError, match="auto"):
        pc.ompl.plan(checker, scene.start("panda"), scene.goal("panda"), "no*such")
