"""Configurations of a planning group, and how they become Pinocchio's full configurations.

In: a Pinocchio model, the joints of a group, the values of all other joints, the mimic joints. Out: `ConfigurationMap`,
which has the group's joints and limits. For each number in Pinocchio's q it has the source: a column of the group's
configuration (times a multiplier plus an offset) or a constant. The number is that value, its cosine or its sine, since
a continuous joint is one angle in a group and two numbers in Pinocchio's q.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from plannercheck.common.array_types import Floats, Ints
from plannercheck.common.arrays import OwnsArrays, configuration_rows
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.robots.joints import CIRCLE, TURN, kind_of
from plannercheck.robots.unit_lengths import UnitLengths, unit_lengths
from plannercheck.robots.urdf import Mimic

PLAIN, COSINE, SINE = 0, 1, 2

# Beyond this, products of poses could overflow; no joint gets there.
LARGEST_VALUE = 1e15

# A limit beyond all configurations is none; Pinocchio marks a missing one by the largest double.
NO_LIMIT = LARGEST_VALUE

# Range in m from which positions without limits are sampled.
_UNLIMITED_RANGE = 1.0


@dataclass(frozen=True, eq=False)
class ConfigurationMap(OwnsArrays):
    """How a group's configuration becomes Pinocchio's.

    Attributes:
        joint_names: The joints of the group, in its order.
        lower: (nq,) lower limits in rad or m, -inf where there is none.
        upper: (nq,) upper limits.
        columns: (full nq,) the column of the group's configuration for each number of Pinocchio's q, -1 if it is held.
        multipliers: (full nq,) factors of the column's value.
        offsets: (full nq,) added to the product; the held value where there is no column.
        roles: (full nq,) PLAIN for the value itself, COSINE or SINE of it.
        lengths: The check of columns that form unit vectors: quaternions, cosine and sine.
        starts: First column of each joint.
        angles: (nq,) columns that are plain angles of joints which turn about an axis.
    """

    joint_names: tuple[str, ...]
    lower: Floats
    upper: Floats
    columns: Ints
    multipliers: Floats
    offsets: Floats
    roles: Ints
    lengths: UnitLengths
    starts: tuple[int, ...]
    angles: NDArray[np.bool_]

    @property
    def units(self) -> tuple[tuple[int, int], ...]:
        """(start, stop) of columns that form a unit vector."""
        return self.lengths.columns

    @property
    def width(self) -> int:
        """How many numbers a configuration of the group has."""
        return len(self.lower)

    @property
    def tangent_places(self) -> Ints:
        """(nq,) the place in Pinocchio's tangent of what each number changes; -1 for a quaternion's last number.

        An angle or a distance has a place of its own, a cosine and its sine have one together, and x, y and z of a
        quaternion have those of turns about x, y and z.
        """
        is_counted = np.ones(self.width, dtype=bool)
        for _, stop in self.units:
            is_counted[stop - 1] = False
        places = np.cumsum(is_counted, dtype=np.int32) - 1
        for start, stop in self.units:
            places[stop - 1] = places[start] if stop - start == 2 else -1
        return np.asarray(places, dtype=np.int32)

    def described_columns(self) -> str:
        """Says in words which joint takes which columns."""
        if not self.joint_names:
            return "no joint moves: a configuration is an empty array"
        if len(self.joint_names) == self.width:
            return f"the joints are {', '.join(self.joint_names)}"
        ends = (*self.starts[1:], self.width)
        parts = (self._described(*each) for each in zip(self.joint_names, self.starts, ends, strict=True))
        return f"the columns are {', '.join(parts)}"

    def _described(self, name: str, start: int, end: int) -> str:
        if end - start == 1:
            return f"{start} {name}"
        unit = next(((first, last) for first, last in self.units if start <= first < end), (end, end))
        turned = {2: "cosine and sine", 4: "quaternion x, y, z, w"}.get(unit[1] - unit[0], "")
        kinds = [f"{' '.join('xyz'[: unit[0] - start])}" if unit[0] > start else "", turned]
        return f"{start} to {end - 1} {name} ({', '.join(filter(None, kinds))})"

    def expand(self, q: Floats) -> Floats:
        """Turns group configurations (n, nq) into Pinocchio's (n, full nq)."""
        full = np.broadcast_to(self.offsets, (len(q), len(self.offsets))).copy()
        free = self.columns >= 0
        full[:, free] += self.multipliers[free] * q[:, self.columns[free]]
        for role, function in ((COSINE, np.cos), (SINE, np.sin)):
            full[:, self.roles == role] = function(full[:, self.roles == role])
        return full

    def checked(self, q: ArrayLike) -> Floats:
        """Validates configurations (nq,) or (n, nq), rad and m: (n, nq) float64 in C order, n = 1 for a single one."""
        rows = configuration_rows(q, self.width, self.described_columns)
        _check_finite(rows)
        if self.lengths.columns:
            self.lengths.check(rows)
        return rows

    def random(self, n: int, seed: int | np.random.Generator | None) -> Floats:
        """Uniform configurations (n, nq) within the limits.

        Joints without limits: angles in [-pi, pi), positions within 1 m of zero, unit vectors uniform on
        their sphere.
        """
        try:
            generator = np.random.default_rng(seed)
        except (TypeError, ValueError):
            raise PlannercheckError(
                f"seed must be a whole number of at least 0, or a generator, not {seed!r}"
            ) from None
        low, high = self.sampled_range()
        q = generator.uniform(low, high, size=(n, self.width))
        for start, stop in self.units:
            unit = generator.standard_normal((n, stop - start))
            q[:, start:stop] = unit / np.linalg.norm(unit, axis=1, keepdims=True)
        return q

    def sampled_range(self) -> tuple[Floats, Floats]:
        """(nq,) bounds of the numbers of `random`: the limits, or a finite range where there are none."""
        turning = np.isinf(self.lower) & (self.angles | (self.roles_of_columns() != PLAIN))
        unlimited = np.where(turning, math.pi, _UNLIMITED_RANGE)
        low = np.where(np.isinf(self.lower), np.minimum(self.upper - 2 * unlimited, -unlimited), self.lower)
        high = np.where(np.isinf(self.upper), np.maximum(low + 2 * unlimited, unlimited), self.upper)
        return low, high

    def turning_columns(self) -> NDArray[np.bool_]:
        """(nq,) columns whose whole turns change no pose: continuous joints, unless a follower moves.

        A follower is back where it was if it is continuous and its multiplier is a whole number. A follower of half the
        speed, or one that slides, is elsewhere after a whole turn of its leader.
        """
        free = np.isinf(self.lower) & np.isinf(self.upper)
        whole = (self.roles != PLAIN) & (self.multipliers == np.round(self.multipliers))
        used = np.bincount(self.columns[self.columns >= 0], minlength=self.width)
        good = np.bincount(self.columns[(self.columns >= 0) & whole], minlength=self.width)
        return np.asarray(free & (used == good))

    def roles_of_columns(self) -> Ints:
        """(nq,) a role of each column of the group's configuration."""
        roles = np.zeros(self.width, dtype=np.int32)
        free = self.columns >= 0
        np.maximum.at(roles, self.columns[free], self.roles[free])
        return roles


def whole_robot(model: pin.Model) -> ConfigurationMap:
    """The map of a robot without a group: Pinocchio's own q, mimic joints independent."""
    full = model.nq
    lower, upper = _limits(model)
    zeros = np.zeros(full)
    roles = np.zeros(full, dtype=np.int32)
    columns = np.arange(full, dtype=np.int32)
    lengths = unit_lengths(model, columns.tolist(), zeros, [False] * full)
    starts = tuple(model.idx_qs)[1:]
    names, angles = tuple(model.names)[1:], _plain_angles(_joints(model), starts, full)
    return ConfigurationMap(names, lower, upper, columns, np.ones(full), zeros, roles, lengths, starts, angles)


def planning_group(
    model: pin.Model, joints: Sequence[str], values: Mapping[str, Floats], mimics: Mapping[str, Mimic]
) -> ConfigurationMap:
    """The map of a planning group.

    Args:
        model: Pinocchio's model.
        joints: Names of the group's joints, none of which mimics another.
        values: The value of every joint, at which it is held if it is not in the group; an angle for a continuous
            joint.
        mimics: Joints that follow others.

    Returns:
        The map; a continuous joint takes one column, the others as many as Pinocchio gives them.
    """
    full = model.nq
    columns, multipliers = np.full(full, -1, dtype=np.int32), np.zeros(full)
    offsets, roles = np.zeros(full), np.zeros(full, dtype=np.int32)
    starts, limits = _group_columns(model, joints)
    for joint in _joints(model):
        name = model.names[joint.id]
        leader, multiplier, offset = followed(name, mimics, starts)
        entries = slice(joint.idx_q, joint.idx_q + joint.nq)
        if is_continuous(joint):
            roles[entries] = (COSINE, SINE)
        if leader in starts:
            steps = np.zeros(joint.nq) if is_continuous(joint) else np.arange(joint.nq)
            columns[entries] = starts[leader] + steps
            multipliers[entries], offsets[entries] = multiplier, offset
        else:
            offsets[entries] = values[name]
    lower, upper = (np.array([pair[side] for pair in limits]) for side in (0, 1))
    lengths = unit_lengths(model, columns.tolist(), offsets, (roles != PLAIN).tolist())
    firsts = tuple(starts.values())
    angles = _plain_angles((joint_by_name(model, name) for name in joints), firsts, len(lower))
    return ConfigurationMap(tuple(joints), lower, upper, columns, multipliers, offsets, roles, lengths, firsts, angles)


def side_by_side(model: pin.Model, maps: Sequence[ConfigurationMap]) -> ConfigurationMap:
    """The map of a model whose joints are those of several models, in their order, given the map of each."""
    widths = np.array([each.width for each in maps])
    shifts = np.concatenate([[0], np.cumsum(widths)[:-1]]).tolist()
    shifted = zip(maps, shifts, strict=True)
    columns = np.concatenate([np.where(each.columns < 0, -1, each.columns + shift) for each, shift in shifted])

    def joined(name: str) -> NDArray[Any]:
        return np.concatenate([getattr(each, name) for each in maps])

    offsets, roles = joined("offsets"), joined("roles")
    return ConfigurationMap(
        tuple(name for each in maps for name in each.joint_names),
        joined("lower"),
        joined("upper"),
        columns.astype(np.int32),
        joined("multipliers"),
        offsets,
        roles,
        unit_lengths(model, columns.tolist(), offsets, (roles != PLAIN).tolist()),
        tuple(start + shift for each, shift in zip(maps, shifts, strict=True) for start in each.starts),
        joined("angles"),
    )


def followed(name: str, mimics: Mapping[str, Mimic], known: Container[str]) -> tuple[str, float, float]:
    """The joint that determines a joint's value: (leader, multiplier, offset), through mimics of mimics.

    The joint itself with 1 and 0 if it follows none; the search stops at joints whose value is known.
    """
    multiplier, offset = 1.0, 0.0
    for _ in range(len(mimics) + 1):
        if name in known or name not in mimics:
            return name, multiplier, offset
        mimic = mimics[name]
        multiplier, offset = multiplier * mimic.multiplier, multiplier * mimic.offset + offset
        name = mimic.leader
    raise PlannercheckError(f"joint {name!r} mimics itself over other joints")


def joint_width(joint: pin.JointModel) -> int:
    """How many numbers a joint takes in a group; one for a continuous joint."""
    return 1 if is_continuous(joint) else int(joint.nq)


def is_continuous(joint: pin.JointModel) -> bool:
    """Whether Pinocchio keeps this joint as cosine and sine of one angle."""
    return kind_of(joint) is CIRCLE


def joint_by_name(model: pin.Model, name: str) -> pin.JointModel:
    """The joint of that name, or an error that lists the valid ones."""
    number = model.getJointId(name) if isinstance(name, str) else 0
    if not 0 < number < model.njoints:  # 0 is the universe
        raise unknown_name("joint", name, list(model.names)[1:])
    return model.joints[number]


def joint_limits(model: pin.Model, joint: pin.JointModel) -> list[tuple[float, float]]:
    """(lower, upper) of each number that a joint takes in a group; infinite for a continuous joint."""
    if is_continuous(joint):
        return [(-math.inf, math.inf)]
    entries = slice(joint.idx_q, joint.idx_q + joint.nq)
    lower, upper = _limits(model)
    return list(zip(lower[entries].tolist(), upper[entries].tolist(), strict=True))


def _plain_angles(joints: Iterable[pin.JointModel], starts: Sequence[int], width: int) -> NDArray[np.bool_]:
    """(width,) columns that are the one number of a joint which turns about an axis."""
    angles = np.zeros(width, dtype=np.bool_)
    for joint, start in zip(joints, starts, strict=True):
        if kind_of(joint) is TURN:
            angles[start] = True
    return angles


def _joints(model: pin.Model) -> Iterator[pin.JointModel]:
    return (model.joints[i] for i in range(1, model.njoints))


def _limits(model: pin.Model) -> tuple[Floats, Floats]:
    lower, upper = np.array(model.lowerPositionLimit), np.array(model.upperPositionLimit)
    lower[lower < -NO_LIMIT], upper[upper > NO_LIMIT] = -np.inf, np.inf
    return lower, upper


def _group_columns(model: pin.Model, joints: Sequence[str]) -> tuple[dict[str, int], list[tuple[float, float]]]:
    """First column of each joint, and limits of all columns."""
    starts: dict[str, int] = {}
    limits: list[tuple[float, float]] = []
    for name in joints:
        joint = joint_by_name(model, name)
        starts[name] = len(limits)
        limits += joint_limits(model, joint)
    return starts, limits


def _check_finite(rows: Floats) -> None:
    if len(rows) == 1 and all(map(LARGEST_VALUE.__ge__, map(abs, rows[0].tolist()))):  # takes half as long
        return
    usable = np.abs(rows) <= LARGEST_VALUE  # false for NaN
    if not usable.all():
        row = int(np.flatnonzero(~usable.all(axis=1))[0])
        raise PlannercheckError(
            f"configurations must be finite (and at most {LARGEST_VALUE:g}); row {row} is {rows[row].tolist()}"
        )
