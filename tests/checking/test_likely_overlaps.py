"""Single states try the pairs that overlapped most lately first: with the same verdicts, and less work."""

import numpy as np
import pytest

import plannercheck as pc


@pytest.fixture(scope="module")
def panda():
    return pc.Robot.load("panda")


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
    learning, plain = (pc.Checker(panda, pc.Scene.load(scene), learning=on) for on in (True, False))
    expected = plain.check_states(walks)
    assert 0.1 < expected.mean() < 0.9
    assert [learning.is_valid(row) for row in walks] == expected.tolist()
    order = np.random.default_rng(5).permutation(len(walks))
    assert [learning.is_valid(row) for row in walks[order]] == expected[order].tolist()


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
