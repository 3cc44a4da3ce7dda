"""While a path is shortened, answers on motions are remembered: the same as without, and each is found once."""

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.common.core import core
from plannercheck.ompl import setup


def remembering_judge(checker):
    """A planner's compiled judge of motions between rows."""
    failure = core.PlannerFailure()
    failure.remember()
    return checker.motion_certifier.motion_validity(1e-4, failure=failure)


def proved(checker):
    return checker.motion_certifier.statistics()["motions"]


def test_motions_asked_again_have_the_answers_of_the_checker(checker):
    generator = np.random.default_rng(0)
    starts, ends = (checker.robot.random_configurations(500, generator) for _ in range(2))
    ends = starts + 0.2 * (ends - starts)
    free = checker.check_motions(starts, ends)
    assert 0.1 < free.mean() < 0.9
    judge = remembering_judge(checker)
    for k in generator.integers(0, 500, 2000):
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
    judge = remembering_judge(checker)
    pairs = [(home.tolist(), other)[:: -1 if reverse else 1] for other in others.tolist()]
    assert [judge(a, b) for a, b in pairs] == free.tolist()


def test_motions_are_remembered_only_while_they_are_to_be(checker):
    failure = core.PlannerFailure()
    judge = checker.motion_certifier.motion_validity(1e-4, failure=failure)
    start = checker.scene.start("panda")

    def found():
        before = proved(checker)
        assert [judge(start.tolist(), (start + 0.01).tolist()) for _ in range(5)] == 5 * [True]
        return proved(checker) - before

    assert found() == 5
    failure.remember()
    assert [found(), found()] == [1, 0]
    failure.forget()
    assert found() == 5
    failure.remember()
    assert [found(), found()] == [1, 0]
    failure.remember()
    assert [found(), found()] == [1, 0]


def test_shortening_finds_each_answer_once_and_plans_are_the_same(checker, monkeypatch):
    ends = checker.scene.start("panda"), checker.scene.goal("panda")

    def planned():
        before = proved(checker)
        path = pc.ompl.plan(checker, *ends, seed=1).path
        return path, proved(checker) - before

    (path, count), again = planned(), planned()
    assert np.array_equal(path, again[0])
    assert count == again[1]
    monkeypatch.setattr(core.PlannerFailure, "remember", lambda self: None)
    plain, plain_count = planned()
    assert np.array_equal(path, plain)
    assert count < 0.95 * plain_count


def test_ompls_own_call_remembers_only_while_it_shortens(checker):
    prepared = setup(checker)
    information = prepared.getSpaceInformation()
    states = [information.allocState() for _ in range(2)]
    for state, q in zip(states, (checker.scene.start("panda"), checker.scene.goal("panda")), strict=True):
        state[0 : checker.robot.nq] = q.tolist()
    prepared.setStartAndGoalStates(*states)
    assert prepared.solve(5.0)
    prepared.simplifySolution()
    before = proved(checker)
    for _ in range(3):
        assert prepared.getSolutionPath().check()
    assert proved(checker) - before == 3 * (prepared.getSolutionPath().getStateCount() - 1)
