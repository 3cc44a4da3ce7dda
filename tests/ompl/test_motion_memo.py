"""A validator remembers the motions of one search: the same answers as without, and they are asked for once."""

from __future__ import annotations

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.ompl import setup


@pytest.fixture(scope="module")
def checker():
    return pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"))


def judge_of(checker):
    """A planner's compiled judge of motions between rows."""
    return checker.motion_certifier.motion_validity(1e-4)


def test_motions_asked_again_have_the_answers_of_the_checker(checker):
    generator = np.random.default_rng(0)
    starts, ends = (checker.robot.random_configurations(500, generator) for _ in range(2))
    ends = starts + 0.2 * (ends - starts)
    free = checker.check_motions(starts, ends)
    assert 0.1 < free.mean() < 0.9
    judge = judge_of(checker)
    for k in generator.integers(0, 500, 5000):
        near = (k + generator.integers(0, 40)) % 500  # asked again soon, or when others have taken its place
        for one in (k, near, k):
            assert judge(starts[one].tolist(), ends[one].tolist()) == free[one]


@pytest.mark.parametrize("reverse", [False, True])
def test_motions_with_one_end_in_common_are_told_apart(checker, reverse):
    home = checker.scene.start("panda")
    others = checker.robot.random_configurations(4000, 1)
    others = home + 0.4 * (others - home)
    free = checker.check_motions(*((others, np.tile(home, (4000, 1)))[:: 1 if reverse else -1]))
    assert 0.1 < free.mean() < 0.9
    judge = judge_of(checker)
    pairs = [(home.tolist(), other)[:: -1 if reverse else 1] for other in others.tolist()]
    assert [judge(a, b) for a, b in pairs] == free.tolist()


def test_a_search_asks_for_a_motion_once_and_the_next_search_again(checker):
    ends = checker.scene.start("panda"), checker.scene.goal("panda")
    prepared = setup(checker)
    information = prepared.getSpaceInformation()
    validator = information.getMotionValidator()
    states = []
    for q in (ends[0], ends[0] + 0.01):
        state = information.allocState()
        state[0 : checker.robot.nq] = q.tolist()
        states.append(state)

    def proved():
        before = checker.motion_certifier.statistics()["motions"]
        counted = validator.getCheckedMotionCount()
        assert [information.checkMotion(*states) for _ in range(5)] == 5 * [True]
        assert validator.getCheckedMotionCount() == counted + 5
        return checker.motion_certifier.statistics()["motions"] - before

    assert [proved(), proved()] == [1, 0]
    prepared.setStartAndGoalStates(*states)
    prepared.solve(1.0)
    information.checkMotion(states[1], states[0])
    assert proved() <= 1
    validator.resetMotionCounter()
    assert [proved(), proved()] == [1, 0]


def test_plans_of_one_checker_are_searched_anew(checker):
    ends = checker.scene.start("panda"), checker.scene.goal("panda")
    pc.ompl.plan(checker, *ends, seed=1, simplify=False)
    asked = []
    for _ in range(3):
        before = checker.motion_certifier.statistics()["motions"]
        pc.ompl.plan(checker, *ends, seed=1, simplify=False)
        asked.append(checker.motion_certifier.statistics()["motions"] - before)
    assert asked[0] == asked[1] == asked[2] > 0
