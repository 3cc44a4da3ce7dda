"""Whole numbers that callers give."""

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.common.whole_numbers import whole_number

NUMBERS = [2, np.int64(2), np.uint8(2)]


@pytest.mark.parametrize("two", NUMBERS)
def test_numbers_of_numpy_are_whole_numbers(two):
    assert type(whole_number(two, "it must be 1 or more")) is int
    checker = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"))
    q = checker.robot.random_configurations(two, seed=0)
    assert len(checker.distances(q, nearest=two, threads=two)) == 4
    assert checker.check_states(q, two).shape == checker.check_motions(q, q[::-1], threads=two).shape == (2,)
    assert checker.free_boxes(q, cells=two, threads=two).cells.max() <= 2


@pytest.mark.parametrize("value", [1, 2.0, np.float64(2), True, np.True_, "2", None, float("nan")])
def test_what_is_none_is_shown(value):
    with pytest.raises(pc.PlannercheckError, match="it must be 2 or more, not "):
        whole_number(value, "it must be 2 or more", 2)
