"""NumPy gives arrays that come out of a pickle a dtype object of their own: they are read in place like any other."""

import pickle

import numpy as np


def pickled(array):
    out = pickle.loads(pickle.dumps(array))
    assert out.dtype == array.dtype
    assert out.dtype is not array.dtype
    return out


def test_states_and_motions(checker):
    q = checker.robot.random_configurations(200, seed=1)
    ends = q + 0.05
    valid, free = checker.check_states(q), checker.check_motions(q, ends)
    assert 0.1 < valid.mean() < 0.9
    assert 0.1 < free.mean() < 0.9
    copies = pickled(q), pickled(ends)
    assert np.array_equal(checker.check_states(copies[0]), valid)
    assert np.array_equal(checker.check_motions(*copies), free)
    assert [checker.is_valid(row) for row in copies[0]] == valid.tolist()
    assert [checker.check_motion(*rows) for rows in zip(*copies, strict=True)] == free.tolist()


def test_nothing_is_left_to_python(checker):
    q = checker.robot.random_configurations(20, seed=2)
    copy, tolerance = pickled(q), 1e-4
    assert np.array_equal(checker._set_validity(copy, 1), checker._set_validity(q, 1))
    assert checker._judge_row(copy[0]) == checker._judge_row(q[0])
    judges = checker.motion_certifier
    assert np.array_equal(judges.judge_sets(copy, copy, tolerance, 1), judges.judge_sets(q, q, tolerance, 1))
    assert judges.judge_sets(copy, copy, tolerance, 1) is not None
    for other in (pickled(q.astype(np.float32)), pickled(q.astype(np.int64)), pickled(q.astype(complex))):
        assert checker._set_validity(other, 1) is None
        assert judges.judge_sets(other, copy, tolerance, 1) is None


def test_arrays_can_be_resized_afterwards(checker):
    """Their memory is let go when a call ends."""
    copy = pickled(checker.robot.random_configurations(20, seed=3)).copy()
    assert copy.dtype is not np.dtype("float64")
    checker.check_states(copy)
    checker.check_motions(copy, copy)
    copy.resize((10, 7), refcheck=False)
    assert len(checker.check_states(copy)) == 10
