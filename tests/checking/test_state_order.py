"""Sets of states are judged in an order in which like ones follow each other: verdicts do not depend on it."""

import numpy as np
import pytest

import plannercheck as pc

SIZES = (511, 512, 513, 1000, 8191, 8192, 16_384, 16_385 + 600)


@pytest.fixture(scope="module", params=[("panda", "bookshelf"), ("ur5", "kitchen"), ("talos", None), ("go2", None)])
def checkers(request):
    name, scene = request.param
    robot, scene = pc.Robot.load(name), None if scene is None else pc.Scene.load(scene)
    return tuple(pc.Checker(robot, scene, tuning=pc.Tuning(sorted_states=each)) for each in (True, False))


def walks(robot, count, steps, seed):
    ends = robot.random_configurations(2 * count, seed=seed).reshape(2, count, 1, -1)
    t = np.linspace(0, 1, steps)[:, None]
    return ((1 - t) * ends[0] + t * ends[1]).reshape(count * steps, -1)


@pytest.mark.parametrize("size", SIZES)
def test_verdicts_of_sets_of_any_size(checkers, size):
    with_order, plain = checkers
    q = plain.robot.random_configurations(size, seed=size)
    expected = plain.check_states(q)
    assert (with_order.check_states(q) == expected).all()
    assert (with_order.check_states(q, threads=2) == expected).all()
    shuffled = np.random.default_rng(size).permutation(size)
    assert (with_order.check_states(q[shuffled]) == expected[shuffled]).all()


def test_pairs_of_sets(checkers):
    with_order, plain = checkers
    q = plain.robot.random_configurations(3000, seed=1)
    assert (with_order.first_colliding_pair(q) == plain.first_colliding_pair(q)).all()
    assert (with_order.first_colliding_pair(q, threads=2) == plain.first_colliding_pair(q)).all()


@pytest.mark.parametrize("steps", [1, 2, 4, 8, 64, 2000])
def test_states_along_motions(checkers, steps):
    with_order, plain = checkers
    q = walks(plain.robot, 2000 // steps, steps, seed=steps)
    assert (with_order.check_states(q) == plain.check_states(q)).all()


def test_numbers_that_hardly_vary():
    """Columns of one value, of two values, of a value with outliers, and sets of one state."""
    robot = pc.Robot.load("panda")
    with_order, plain = (
        pc.Checker(robot, pc.Scene.load("bookshelf"), tuning=pc.Tuning(sorted_states=each)) for each in (True, False)
    )
    for seed in range(20):
        rng = np.random.default_rng(seed)
        q = robot.random_configurations(2000, seed=seed)
        for column in rng.permutation(7)[: rng.integers(8)]:
            values = q[: rng.choice([1, 2, 3, 40]), column]
            q[:, column] = rng.choice(values, size=len(q))
        assert (with_order.check_states(q) == plain.check_states(q)).all()


def test_like_states_follow_each_other():
    """Of a few states, each with many that hardly differ, all mixed up, planes of the last state settle more pairs."""
    robot = pc.Robot.load("talos")
    rng = np.random.default_rng(3)
    few = robot.random_configurations(40, seed=3)
    q = few[rng.integers(40, size=12_000)] + rng.uniform(-1e-3, 1e-3, size=(12_000, robot.nq))
    q = np.clip(q, robot.lower, robot.upper)
    settled = []
    for each in (True, False):
        checker = pc.Checker(robot, pc.Scene(), tuning=pc.Tuning(sorted_states=each))
        checker.check_states(q)
        settled.append(checker.statistics()["cached_plane"])
    assert settled[0] > 1.5 * settled[1]
