"""Values of files that most files have, taken at once: they have to be those that a look at each gives."""

import math

import numpy as np
import pytest

from plannercheck.common.checked_yaml import numbers
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.transforms import identity, is_identity, pose_of, pose_of_quaternion, rotation_of_quaternion


def test_plain_numbers_are_new_lists_of_floats():
    given = [1, 2.5, -0.0]
    found = numbers(given, "position", 3)
    assert found == [1.0, 2.5, 0.0]
    assert all(type(value) is float for value in found)
    assert math.copysign(1, found[2]) == -1
    found[0] = 7.0
    assert given[0] == 1


def test_texts_of_numbers_pass():
    assert numbers(["1e-5", 2], "position") == [1e-5, 2.0]


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ([1.0, True], "'position' must be a finite number, not True"),
        ([1.0, None], "'position' must be a number, not None"),
        ([10**400, 1], "'position' must be a number, not 1000"),
        ([math.inf, 1], "'position' must be a finite number, not inf"),
        ([math.nan, 1], "'position' must be a finite number, not nan"),
        ([1.0], "'position' needs 2 numbers, not 1"),
        ((1.0, 2.0), "'position' must be a list"),
    ],
)
def test_other_lists_are_refused(value, message):
    with pytest.raises(PlannercheckError, match=message):
        numbers(value, "position", 2)


def test_poses_of_quaternions_have_the_bits_of_their_rotations():
    generator = np.random.default_rng(3)
    for shift, turn in zip(
        generator.normal(size=(50, 3)).tolist(), generator.normal(size=(50, 4)).tolist(), strict=True
    ):
        expected = pose_of(shift, rotation_of_quaternion(turn))
        assert pose_of_quaternion(shift, turn).tobytes() == expected.tobytes()
    with pytest.raises(PlannercheckError, match="has no direction"):
        pose_of_quaternion([0.0] * 3, [0.0] * 4)


def test_identities():
    pose = identity()
    pose[0, 1] = -0.0
    assert is_identity(pose)
    pose[0, 3] = 5e-324
    assert not is_identity(pose)
    assert is_identity(identity())
