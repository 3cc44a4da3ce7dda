"""OMPL's states are read by one call of their space: the same numbers as part by part, in all kinds of spaces."""

import gc

import numpy as np
import pytest
from ompl import base

import plannercheck as pc
from plannercheck.common.core import core
from plannercheck.ompl import setup, space_of
from plannercheck.ompl.state_numbers import StateNumbers

COUNT = 40


def bounded(width):
    space, bounds = base.RealVectorStateSpace(width), base.RealVectorBounds(width)
    bounds.setLow(-2.0)
    bounds.setHigh(3.0)
    space.setBounds(bounds)
    return space


def plane(space=None):
    space, bounds = space or base.SE2StateSpace(), base.RealVectorBounds(2)
    bounds.setLow(-2.0)
    bounds.setHigh(3.0)
    space.setBounds(bounds)
    return space


def room():
    space, bounds = base.SE3StateSpace(), base.RealVectorBounds(3)
    bounds.setLow(-2.0)
    bounds.setHigh(3.0)
    space.setBounds(bounds)
    return space


def compound(*parts):
    space = base.CompoundStateSpace()
    for part in parts:
        space.addSubspace(part, 1.0)
    return space


def of_plane(state):
    return [state.getX(), state.getY(), state.getYaw()]


def of_room(state):  # the bindings do not show its quaternion
    return [state.getX(), state.getY(), state.getZ()]


SPACES = {
    "one bounded joint": (lambda: bounded(1), 1, lambda state: [state[0]]),
    "bounded joints": (lambda: bounded(7), 7, lambda state: [state[k] for k in range(7)]),
    "more joints than the stack holds": (lambda: bounded(99), 99, lambda state: [state[k] for k in range(99)]),
    "SO2": (base.SO2StateSpace, 1, lambda state: [state.value]),
    "SE2": (plane, 3, of_plane),
    "Dubins": (lambda: plane(base.DubinsStateSpace(1.5)), 3, of_plane),
    "Reeds-Shepp": (lambda: plane(base.ReedsSheppStateSpace(1.5)), 3, of_plane),
    "SE3": (room, 7, of_room),
    "angles and bounded joints": (
        lambda: compound(base.SO2StateSpace(), bounded(1), base.SO2StateSpace(), bounded(2)),
        5,
        lambda state: [state[0].value, state[1][0], state[2].value, state[3][0], state[3][1]],
    ),
    "a root and joints": (
        lambda: compound(plane(), base.SO2StateSpace(), bounded(1)),
        5,
        lambda state: [*of_plane(state[0]), state[1].value, state[2][0]],
    ),
}


@pytest.mark.parametrize("name", SPACES)
def test_numbers_read_at_once_are_those_of_the_parts(name):
    make, width, parts = SPACES[name]
    space = make()
    information, numbers = base.SpaceInformation(space), StateNumbers(space, width)
    sampler = information.allocStateSampler()
    states = [information.allocState() for _ in range(COUNT)]
    for state in states:
        sampler.sampleUniform(state)
    expected = np.array([parts(state) for state in states])
    assert len(np.unique(expected)) > COUNT / 2
    for state, row in zip(states, expected, strict=True):
        assert numbers.read(state)[: len(row)] == row.tolist()
        assert len(numbers.read(state)) == width
    rows = numbers.rows(states)
    assert np.array_equal(rows[:, : expected.shape[1]], expected)
    if name == "SE3":
        np.testing.assert_allclose(np.linalg.norm(rows[:, 3:], axis=1), 1.0)
    assert numbers.rows([]).shape == (0, width)


def test_a_space_of_another_width_is_refused():
    """OMPL would write beyond the numbers' end."""
    with pytest.raises(AssertionError):
        StateNumbers(bounded(7), 6)


@pytest.mark.parametrize("name", ["panda", "kinova", "forklift", "truck_trailer"])
def test_a_robot_reads_what_it_has_written(name):
    if name in ("panda", "kinova"):
        checker = pc.Checker(pc.Robot.load(name))
    else:
        checker = pc.planar.Checker(pc.planar.Robot.load(name).with_bounds([-9, -9], [9, 9]))
    space, information = space_of(checker), setup(checker).getSpaceInformation()
    rows = checker.robot.random_configurations(COUNT, 3)
    states = [space.state(information, row) for row in rows]
    assert np.array_equal([space.read(state) for state in states], rows)
    assert np.array_equal(space.numbers.rows(states), rows)


@pytest.mark.parametrize("name", ["panda", "kinova"])
def test_validators_of_all_joints_agree_with_the_checker(name):
    """Also beyond the limits, where other pairs are judged; random angles lie on both sides of half a turn."""
    checker = pc.Checker(pc.Robot.load(name), pc.Scene.load("kitchen"))
    space, information = space_of(checker), setup(checker).getSpaceInformation()
    q = checker.robot.random_configurations(400, 4)
    q[::10, np.flatnonzero(np.isfinite(checker.robot.upper))[0]] *= 3.0
    valid = checker.check_states(q)
    assert valid.any()
    assert not valid.all()
    q0, q1 = q[:-1], q[:-1] + 0.1 * (q[1:] - q[:-1])
    free = checker.check_motions(q0, q1)
    assert free.any()
    assert not free.all()
    for row, expected in zip(q, valid, strict=True):
        assert information.isValid(space.state(information, row)) == expected
    for start, end, expected in zip(q0, q1, free, strict=True):
        assert information.checkMotion(space.state(information, start), space.state(information, end)) == expected


class Copying:
    """In place of a space's `serialize`: writes nothing, but does something else first."""

    def __init__(self, space, something):
        self.space, self.something = space, something

    def __call__(self, place, state):
        self.something()
        self.space.serialize(place, state)


def test_a_state_that_is_read_within_the_reading_of_another():
    space = bounded(7)
    information = base.SpaceInformation(space)
    first, second = information.allocState(), information.allocState()
    first[0:7], second[0:7] = np.arange(7.0).tolist(), (10 + np.arange(7.0)).tolist()
    copying, deep = Copying(space, None), []
    numbers = core.PlannerStates(7, copying)

    def within():
        if len(deep) < 3:
            deep.append(None)
            assert numbers.numbers(second) == [second[k] for k in range(7)]

    copying.something = within
    for i in range(4):
        deep.clear()
        first[0:7] = (100.0 * i + np.arange(7.0)).tolist()  # others each time, or memory might hold them from before
        assert numbers.numbers(first) == [first[k] for k in range(7)]
    copying.something = None  # or numbers would keep themselves alive


def test_an_exception_while_a_state_is_read():
    space = bounded(7)
    state = base.SpaceInformation(space).allocState()
    state[0:7] = np.arange(7.0).tolist()
    failing = [True]

    def fail():
        if failing:
            raise ZeroDivisionError("within")

    numbers = core.PlannerStates(7, Copying(space, fail))
    with pytest.raises(ZeroDivisionError, match="within"):
        numbers.numbers(state)
    with pytest.raises(ZeroDivisionError, match="within"):
        numbers.rows([state])
    failing.clear()
    assert numbers.numbers(state) == [state[k] for k in range(7)]


def test_what_is_no_state_is_refused():
    checker = pc.Checker(pc.Robot.load("panda"))
    numbers = space_of(checker).numbers
    with pytest.raises(TypeError):
        numbers.read([0.0] * 7)
    with pytest.raises(TypeError):
        checker.state_validity(numbers.states)(None)


def test_numbers_keep_their_space_alive():
    numbers = StateNumbers(bounded(7), 7)
    gc.collect()
    state = base.SpaceInformation(bounded(7)).allocState()
    state[0:7] = np.arange(7.0).tolist()
    assert numbers.read(state) == np.arange(7.0).tolist()
