"""The solver begins with the vertices and facets that it ended with last: same verdicts, fewer rounds."""

import numpy as np
import pytest

import plannercheck as pc


def near_contact(robot, scene, count, seed):
    """States on short ways from valid states to colliding ones, and back: each is near a contact."""
    checker = pc.Checker(robot, scene)
    q = robot.random_configurations(40 * count, seed)
    valid = checker.check_states(q)
    ways = []
    for free, colliding in zip(q[valid][:count], q[~valid][:count], strict=True):
        low, high = 0.0, 1.0
        for _ in range(12):
            middle = (low + high) / 2
            low, high = (middle, high) if checker.is_valid(free + middle * (colliding - free)) else (low, middle)
        way = np.linspace(low - 0.02, high + 0.02, 24)[:, None] * (colliding - free) + free
        ways += [way, way[::-1]]
    return np.clip(np.concatenate(ways), robot.lower, robot.upper)


@pytest.mark.parametrize(("name", "scene"), [("ur5", "kitchen"), ("panda", "cage"), ("baxter", "kitchen")])
def test_verdicts_are_those_without_memory(name, scene):
    robot, scene = pc.Robot.load(name), pc.Scene.load(scene)
    q = near_contact(robot, scene, 25, seed=11)
    learning = pc.Checker(robot, scene)
    plain = pc.Checker(robot, scene, tuning=pc.Tuning(cached_plane=False, bounds=False))
    expected = plain.check_states(q)
    assert 0.2 < expected.mean() < 0.8
    order = np.random.default_rng(12).permutation(len(q))
    for _ in range(2):
        assert learning.check_states(q).tolist() == expected.tolist()
        assert learning.check_states(q[order], threads=2).tolist() == expected[order].tolist()
        assert [learning.is_valid(row) for row in q[order]] == expected[order].tolist()


def test_less_rounds_are_needed():
    robot, scene = pc.Robot.load("ur5"), pc.Scene.load("kitchen")
    q = near_contact(robot, scene, 25, seed=13)
    rounds = []
    for remembers in (True, False):
        checker = pc.Checker(robot, scene, tuning=pc.Tuning(cached_plane=remembers))
        checker.check_states(q)
        rounds.append(checker.statistics()["queries"]["rounds"] / checker.statistics()["solver"])
    assert rounds[0] < 0.7 * rounds[1]
