"""Pairs that overlapped lately are tried first, in single states and in blocks: same verdicts, less work."""

import numpy as np
import pytest

import plannercheck as pc


@pytest.fixture(scope="module")
def walks(panda):
    """States as planners ask for them: short walks, many of which stay in one collision, and random ones between."""
    rng = np.random.default_rng(3)
    starts = panda.random_configurations(60, seed=4)
    walks = [start + np.cumsum(rng.normal(scale=0.02, size=(25, 7)), axis=0) for start in starts]
    q = np.concatenate([rows for walk in walks for rows in (walk, panda.random_configurations(2, seed=len(walk)))])
    return np.clip(q, panda.lower, panda.upper)


@pytest.mark.parametrize("scene", ["bookshelf", "cage"])
def test_verdicts_do_not_depend_on_what_was_asked_before(panda, walks, scene):
    learning, plain = (pc.Checker(panda, pc.Scene.load(scene), tuning=pc.Tuning(learning=on)) for on in (True, False))
    expected = plain.check_states(walks)
    assert 0.1 < expected.mean() < 0.9
    assert [learning.is_valid(row) for row in walks] == expected.tolist()
    order = np.random.default_rng(5).permutation(len(walks))
    assert [learning.is_valid(row) for row in walks[order]] == expected[order].tolist()
    for threads in (1, 2):
        np.testing.assert_array_equal(learning.check_states(walks, threads=threads), expected)
        np.testing.assert_array_equal(learning.check_states(walks[order], threads=threads), expected[order])


@pytest.mark.parametrize("count", [1, 2, 7, 8, 9, 60])
def test_free_states_behind_blocks_that_collide_alike(panda, count):
    """In their own block, or in one with states that collide."""
    checker = pc.Checker(panda, pc.Scene.load("cage"))
    q = panda.random_configurations(300, seed=8)
    valid = pc.Checker(panda, pc.Scene.load("cage"), tuning=pc.Tuning(bounds=False)).check_states(q)
    for colliding, free in zip(q[~valid][:20], q[valid][:20], strict=True):
        rows = np.concatenate([np.tile(colliding, (32 + count, 1)), [free], np.tile(colliding, (16, 1)), [free] * 8])
        assert checker.check_states(rows).tolist() == [False] * (32 + count) + [True] + [False] * 16 + [True] * 8


def test_blocks_that_collide_alike_bound_no_other_pair(panda):
    """But for those that need a pair test."""
    checker = pc.Checker(panda, pc.Scene.load("bookshelf"))
    q = panda.random_configurations(300, seed=9)
    spent = []
    for colliding in q[~checker.check_states(q)][:20]:
        rows = np.tile(colliding, (64, 1))
        checker.check_states(rows)
        before = checker.statistics()
        assert not checker.check_states(rows).any()
        after = checker.statistics()
        spent.append(after["bounds"] - before["bounds"])
        settled = set(after) - {"states", "pairs", "queries"}
        assert sum(after[name] - before[name] for name in settled) == after["pairs"] - before["pairs"]
    assert np.mean(np.equal(spent, 0)) > 0.5


@pytest.mark.parametrize(("name", "scene"), [("panda", "cage"), ("baxter", "kitchen"), ("ur5", "kitchen")])
def test_each_pair_of_a_state_counts_once(name, scene):
    """Also where overlaps of some movers have decided all states before others are looked at."""
    robot = pc.Robot.load(name)
    checker = pc.Checker(robot, pc.Scene.load(scene))
    q = robot.random_configurations(640, seed=10)
    along = np.concatenate([np.linspace(a, b, 64) for a, b in zip(q[:10], q[10:20], strict=True)])
    plain = pc.Checker(robot, pc.Scene.load(scene), tuning=pc.Tuning(bounds=False))
    for rows in (q, along):
        assert checker.check_states(rows).tolist() == plain.check_states(rows).tolist()
        counted = checker.statistics()
        settled = set(counted) - {"states", "pairs", "queries"}
        assert sum(counted[key] for key in settled) == counted["pairs"]
        assert min(counted[key] for key in settled) >= 0


def test_states_that_are_not_there_do_not_count(panda):
    """The last block of a set has lanes to spare, which hold the last state once more."""
    checker = pc.Checker(panda, pc.Scene.load("bookshelf"))
    q = panda.random_configurations(300, seed=14)
    for colliding in q[~checker.check_states(q)][:20]:
        before = checker.statistics()
        assert not checker.check_states(np.tile(colliding, (25, 1))).any()
        assert checker.statistics()["overlaps"] - before["overlaps"] <= 25


def test_what_open_states_were_near_is_forgotten(panda):
    """Found by a test of orders: a set ends with a block of open states and a smaller one, whose other states keep the
    first one's pairs, and the next set's states in their places have pairs of another state."""
    checker = pc.Checker(panda, pc.Scene.load("bookshelf"))
    q = panda.random_configurations(1001, seed=3)
    alone = [checker.first_colliding_pair(row)[0] for row in q]
    for _ in range(3):
        assert checker.first_colliding_pair(q).tolist() == alone


def test_a_collision_is_not_looked_for_among_all_pairs_again(panda):
    """Once a pair stands out, states in which it overlaps have no pair bounded by balls."""
    checker = pc.Checker(panda, pc.Scene.load("bookshelf"))
    q = panda.random_configurations(500, seed=6)
    colliding = q[~checker.check_states(q)]
    checker.is_valid(colliding[0])
    spent = []
    for row in colliding[:20]:
        for _ in range(12):
            assert not checker.is_valid(row)
        before = checker.statistics()["bounds"]
        assert not checker.is_valid(row)
        spent.append(checker.statistics()["bounds"] - before)
    assert np.mean(np.equal(spent, 0)) > 0.5  # all but those that need a pair test
    counted = checker.statistics()
    settled = set(counted) - {"states", "pairs", "queries"}
    assert sum(counted[name] for name in settled) == counted["pairs"]


def test_a_pair_is_forgotten_in_states_that_are_free(panda):
    checker = pc.Checker(panda, pc.Scene.load("bookshelf"))
    q = panda.random_configurations(400, seed=7)
    valid = checker.check_states(q)

    def bounded(row):
        before = checker.statistics()["bounds"]
        checker.is_valid(row)
        return checker.statistics()["bounds"] > before

    known = [row for row in q[~valid][:20] if not all(bounded(row) for _ in range(12))]
    assert len(known) > 5
    for row in known:
        assert [bounded(row) for _ in range(12)][-1] is False
        assert all(checker.is_valid(other) for other in q[valid][:40])
        assert bounded(row)


@pytest.mark.parametrize("times", [100, 140, 400])
def test_a_free_state_after_very_many_that_collide_alike(panda, times):
    """Found by an audit: then all weight was one pair's, and a second one, which was none, was tried."""
    checker = pc.Checker(panda, pc.Scene())
    q = panda.random_configurations(3000, seed=1)
    valid = checker.check_states(q)
    for colliding in q[~valid][:5]:
        for _ in range(times):
            assert not checker.is_valid(colliding)
        assert all(checker.is_valid(row) for row in q[valid][:3])
