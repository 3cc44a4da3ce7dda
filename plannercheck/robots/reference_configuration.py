"""The state at which joints are held, and the group's reference configuration.

In: values of some joints as a user gives them (by name, or an array in Pinocchio's order). Out: a checked value for
every joint: the given value; else, for a mimic joint, the value that follows from its leader; else the value within the
limits that is nearest to Pinocchio's neutral value. A continuous joint's value is one angle.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import named_numbers, read_only_copy
from plannercheck.common.errors import PlannercheckError
from plannercheck.robots.configurations import (
    LARGEST_VALUE,
    followed,
    is_continuous,
    joint_by_name,
    joint_limits,
    joint_width,
)
from plannercheck.robots.unit_lengths import UNIT_TOLERANCE
from plannercheck.robots.urdf import Mimic

# The rounding of numbers written with six digits, rad or m.
_SLACK = 1e-6


def given_values(model: pin.Model, reference: Mapping[str, Any] | Sequence[float] | Floats | None) -> dict[str, Floats]:
    """The values (width,) of each joint given in a reference state, within the limits, an angle for a continuous joint.

    The reference has values by joint name, or is an array (full nq,) in Pinocchio's order; rad and m.
    """
    if reference is None:
        return {}
    given = reference if isinstance(reference, Mapping) else _split(model, reference)
    values = checked_values(model, given)
    for name, value in values.items():
        _check_limits(model, name, value)
    return values


def checked_values(model: pin.Model, given: Mapping[str, Any]) -> dict[str, Floats]:
    """Values by joint name as arrays, of the right length and finite; limits are not checked."""
    if not isinstance(given, Mapping):
        raise PlannercheckError(f"held values are by joint name, {{'joint': 0.5}}, not {given!r:.80}")
    values = {}
    for name, value in given.items():
        width = joint_width(joint_by_name(model, name))
        if type(value) is float and width == 1 and abs(value) <= LARGEST_VALUE:  # most; what follows takes 10 µs
            values[name] = np.array([value])
            continue
        try:
            array = np.atleast_1d(read_only_copy(value))
        except (TypeError, ValueError, OverflowError):
            array = np.array([math.nan])
        if array.shape != (width,) or not (np.abs(array) <= LARGEST_VALUE).all():
            raise PlannercheckError(
                f"joint {name!r} needs {width} finite value{'s' * (width > 1)} (at most {LARGEST_VALUE:g}), "
                f"not {value!r:.80}"
            )
        values[name] = array
    return values


def with_given(
    values: Mapping[str, Floats], given: Mapping[str, Floats], mimics: Mapping[str, Mimic]
) -> dict[str, Floats]:
    """Values by joint name with others given: followers that are not given move with their leaders."""
    kept = {name: value for name, value in values.items() if followed(name, mimics, given)[0] not in given}
    return {**kept, **given}


def all_values(model: pin.Model, given: Mapping[str, Floats], mimics: Mapping[str, Mimic]) -> dict[str, Floats]:
    """A value for every joint of the model: given, computed from its leader, or neutral."""
    neutral = pin.neutral(model)
    values = {}
    for name in list(model.names)[1:]:
        leader, multiplier, offset = followed(name, mimics, given)
        value = given[leader] if leader in given else _neutral_value(model, leader, neutral)
        values[name] = value if leader == name else multiplier * value + offset
    return values


def check_followers(
    joints: Sequence[str], given: Mapping[str, Floats], values: Mapping[str, Floats], mimics: Mapping[str, Mimic]
) -> None:
    """Raises for a value that a joint can't keep, since it follows a joint of the group."""
    for name in given:
        leader, multiplier, offset = followed(name, mimics, joints)
        right = multiplier * values[leader] + offset
        if leader != name and leader in joints and not np.abs(given[name] - right).max() <= _SLACK:
            raise PlannercheckError(
                f"joint {name!r} follows {leader!r} of the group, which makes its reference {right[0]:.9g}, not "
                f"{given[name][0]:.9g}: correct one of the two, or leave {name!r} out"
            )


def reference_of(model: pin.Model, joints: Sequence[str] | None, values: Mapping[str, Floats]) -> Floats:
    """The reference configuration (nq,) of a group, or Pinocchio's full one if there is none."""
    if joints is not None:
        return np.concatenate([np.atleast_1d(values[name]) for name in joints])
    parts = [np.zeros(0)]
    for name in list(model.names)[1:]:
        value = values[name]
        continuous = is_continuous(joint_by_name(model, name))
        parts.append(np.array([np.cos(value[0]), np.sin(value[0])]) if continuous else value)
    return np.concatenate(parts)


def _neutral_value(model: pin.Model, name: str, neutral: Floats) -> Floats:
    joint = joint_by_name(model, name)
    if is_continuous(joint):
        return np.zeros(1)
    lower, upper = zip(*joint_limits(model, joint), strict=True)
    return np.clip(neutral[joint.idx_q : joint.idx_q + joint.nq], lower, upper)


def _split(model: pin.Model, q: Sequence[float] | Floats) -> dict[str, Floats]:
    """The values of a full configuration, by joint name."""
    full = named_numbers(q, "a reference array")
    if np.shape(q) != (model.nq,):
        raise PlannercheckError(
            f"a reference array must be Pinocchio's full configuration ({model.nq},), not {np.shape(q)}"
        )
    values = {}
    for name in list(model.names)[1:]:
        joint = joint_by_name(model, name)
        own = full[joint.idx_q : joint.idx_q + joint.nq]
        if is_continuous(joint):
            if abs(math.hypot(*own) - 1) > UNIT_TOLERANCE:
                raise PlannercheckError(f"reference of joint {name!r} is no cosine and sine: {own.tolist()}")
            own = np.array([math.atan2(own[1], own[0])])
        values[name] = own
    return values


def _check_limits(model: pin.Model, name: str, value: Floats) -> None:
    for number, (lower, upper) in zip(value.tolist(), joint_limits(model, joint_by_name(model, name)), strict=True):
        if not lower - _SLACK <= number <= upper + _SLACK:
            raise PlannercheckError(
                f"reference of joint {name!r} is {number!r}, beyond its limits {lower!r} to {upper!r}"
            )
