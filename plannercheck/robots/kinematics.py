"""Exports Pinocchio's model as the compiled kernel's joint table, and compares the kernel with Pinocchio.

In: a Pinocchio model, the map from group to full configurations, the frames of the links. Out: the compiled
`Kinematics`, which poses kLanes configurations at once; None if the table has no entry for some kind of joint. Also
Pinocchio's own poses: the reference for the comparison, and the poses of robots with such joints.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from plannercheck.common.array_types import Floats, Ints
from plannercheck.common.arrays import read_only
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError
from plannercheck.robots.configurations import COSINE, ConfigurationMap
from plannercheck.robots.joints import CIRCLE, KINDS, TURN, number_of

# How far an axis's length may be from 1; Pinocchio normalises axes, so more is no rounding.
_UNIT = 1e-6

# The largest number of values that a joint takes in Pinocchio's q.
_MOST_VALUES = max(kind.numbers for kind in KINDS)

# The largest difference from Pinocchio's poses that counts as rounding: of rotations, and of positions per metre of
# reach.
AGREEMENT = 1e-12
_CHECKED_CONFIGURATIONS = 8

# Up to this many degrees of freedom Pinocchio's own `Data` is used: it then has less than 70 MB.
_MOST_FOR_DATA = 100


class JointTable(NamedTuple):
    """The inputs of the compiled kernel, in the order in which it takes them.

    Attributes:
        width: How many numbers a configuration has.
        parents: (joints,) each joint's parent, which is an earlier joint, -1 for the world.
        kinds: (joints,) numbers of kinds, see `joints.KINDS`.
        axes: (joints, 3).
        placements: (joints, 3, 4) on the parents, m.
        columns: (joints, 7) column of the configuration for each number that the joint takes, -1 if held.
        multipliers: (joints, 7) applied to the column's value.
        offsets: (joints, 7) added to it.
        link_joints: (links,) the joint that each link is on, -1 for the world.
        link_placements: (links, 3, 4) on that joint, m.
    """

    width: int
    parents: Ints
    kinds: Ints
    axes: Floats
    placements: Floats
    columns: Ints
    multipliers: Floats
    offsets: Floats
    link_joints: Ints
    link_placements: Floats


def joint_table(model: pin.Model, configurations: ConfigurationMap, frames: Sequence[int]) -> JointTable | None:
    """The kernel's table of a group, or None if the model has a joint that the kernel does not know.

    `configurations` says where the numbers in Pinocchio's q come from; `frames` are Pinocchio's of the links.
    """
    joints = [_joint_row(model, model.joints[i], configurations) for i in range(1, model.njoints)]
    if any(row is None for row in joints):
        return None
    kinds, axes, columns, multipliers, offsets = zip(*joints, strict=True) if joints else ((), (), (), (), ())
    link_frames = [model.frames[i] for i in frames]
    table = JointTable(
        configurations.width,
        np.array([model.parents[i] - 1 for i in range(1, model.njoints)], dtype=np.int32),
        np.array(kinds, dtype=np.int32),
        np.reshape(axes, (-1, 3)).astype(np.float64),
        _placements([model.jointPlacements[i] for i in range(1, model.njoints)]),
        np.reshape(columns, (-1, _MOST_VALUES)).astype(np.int32),
        np.reshape(multipliers, (-1, _MOST_VALUES)).astype(np.float64),
        np.reshape(offsets, (-1, _MOST_VALUES)).astype(np.float64),
        np.array([frame.parentJoint - 1 for frame in link_frames], dtype=np.int32),
        _placements([frame.placement for frame in link_frames]),
    )
    _check_numbers(table, model)
    for array in table[1:]:
        read_only(array)
    return table


def _check_numbers(table: JointTable, model: pin.Model) -> None:
    """Raises for numbers that are none, and axes without length: a bound that is no number passes comparisons."""
    lengths = np.linalg.norm(table.axes, axis=1)
    faulty = ~np.isfinite(table.placements).all(axis=(1, 2))
    faulty |= np.array([KINDS[k].has_axis for k in table.kinds], dtype=bool) & ~(np.abs(lengths - 1) <= _UNIT)
    faulty |= ~(np.isfinite(table.multipliers) & np.isfinite(table.offsets)).all(axis=1)
    if faulty.any():
        name = model.names[int(np.argmax(faulty)) + 1]
        raise PlannercheckError(
            f"joint {name!r} has an axis without length, or a place or multiplier that is no number"
        )
    if not np.isfinite(table.link_placements).all():
        raise PlannercheckError("a link has a place on its joint that is no number")


def compiled_kinematics(
    model: pin.Model, configurations: ConfigurationMap, frames: Sequence[int]
) -> core.Kinematics | None:
    """The compiled kinematics of a group; None if the model has a joint that the kernel does not know.

    Arguments as of `joint_table`.
    """
    table = joint_table(model, configurations, frames)
    return None if table is None else core.Kinematics(*table)


def pinocchio_poses(model: pin.Model, configurations: ConfigurationMap, frames: Sequence[int], q: Floats) -> Floats:
    """World poses (n, links, 4, 4), m, of the links at group configurations (n, nq), by Pinocchio itself.

    Other arguments as of `joint_table`.
    """
    poser = _posed_with_data if model.nv <= _MOST_FOR_DATA else _posed_by_joints
    poses = np.empty((len(q), len(frames), 4, 4))
    for row, placements in zip(poses, poser(model, frames, configurations.expand(q)), strict=True):
        for link, placement in enumerate(placements):
            row[link] = placement.homogeneous
    return poses


def _posed_with_data(model: pin.Model, frames: Sequence[int], rows: Floats) -> Iterator[list[Any]]:
    """The frames' placements in the world at each of Pinocchio's configurations (n, nq)."""
    data = model.createData()
    for q in rows:
        pin.framesForwardKinematics(model, data, q)
        yield [data.oMf[frame] for frame in frames]


def _posed_by_joints(model: pin.Model, frames: Sequence[int], rows: Floats) -> Iterator[list[Any]]:
    """The same poses by the same products, without Pinocchio's `Data` (its nv^3 numbers take 60 GB for nv = 1,000)."""
    for q in rows:
        joints = joint_placements(model, q)
        yield [joints[model.frames[frame].parentJoint] * model.frames[frame].placement for frame in frames]


def joint_placements(model: pin.Model, q: Floats) -> list[Any]:
    """Pinocchio's poses in the world (pin.SE3) of the joints at a configuration (nq,), for a model of any size.

    The universe is first; the bits are those of `Data.oMi`.
    """
    placed = [pin.SE3.Identity()]
    for joint, parent, placement in list(zip(model.joints, model.parents, model.jointPlacements, strict=True))[1:]:
        data = joint.createData()
        joint.calc(data, q)
        local = placement * data.M
        placed.append(placed[parent] * local if parent > 0 else local)
    return placed


def disagreement(
    kinematics: core.Kinematics, model: pin.Model, configurations: ConfigurationMap, frames: Sequence[int]
) -> float:
    """Largest difference between the kernel's and Pinocchio's poses on a few random configurations.

    Positions count relative to the robot's reach, if that is more than 1 m.
    """
    q = configurations.random(_CHECKED_CONFIGURATIONS, seed=0)
    theirs = pinocchio_poses(model, configurations, frames, q)
    ours = kinematics.link_poses(q, np.ones(len(frames), dtype=np.uint8))
    extent = max(1.0, float(np.abs(theirs[..., 3]).max(initial=0.0)))
    scale = np.array([1.0, 1.0, 1.0, extent])
    return float((np.abs(ours - theirs) / scale).max(initial=0.0))


def _joint_row(model: pin.Model, joint: pin.JointModel, configurations: ConfigurationMap) -> Any | None:
    """(kind, axis, columns, multipliers, offsets) of one joint, None if the kernel does not know it."""
    kind = number_of(joint)
    if kind is None:
        return None
    axis = _axis_of(joint)
    entries = np.arange(joint.idx_q, joint.idx_q + joint.nq)
    if configurations.roles[entries[0]] == COSINE:  # one angle in place of its cosine and sine
        kind, entries = kind - CIRCLE.first + TURN.first, entries[:1]
    padding = _MOST_VALUES - len(entries)
    columns = np.pad(configurations.columns[entries], (0, padding), constant_values=-1)
    multipliers = np.pad(configurations.multipliers[entries], (0, padding))
    offsets = np.pad(configurations.offsets[entries], (0, padding))
    return _aligned(kind, axis, columns, multipliers, offsets)


def _axis_of(joint: pin.JointModel) -> Floats:
    """The joint's axis, from its motion subspace; zeros for joints of more than one degree of freedom."""
    if joint.nv != 1:
        return np.zeros(3)
    data = joint.createData()
    joint.calc(data, np.eye(1, joint.idx_q + joint.nq, joint.idx_q)[0])
    linear, angular = np.reshape(data.S, (2, 3))
    return np.asarray(linear + angular, dtype=np.float64)


def _aligned(kind: int, axis: Floats, columns: Any, multipliers: Floats, offsets: Floats) -> Any:
    """Replaces turns about -x, -y or -z by turns about x, y or z by the opposite angle, which is cheaper."""
    negative = np.flatnonzero(axis == -1.0)
    if kind not in (TURN.unaligned, CIRCLE.unaligned) or len(negative) == 0 or np.abs(axis).sum() != 1.0:
        return kind, axis, columns, multipliers, offsets
    sign = np.ones(_MOST_VALUES)
    sign[0 if KINDS[kind] is TURN else 1] = -1.0  # the angle, or the sine
    return KINDS[kind].first + int(negative[0]), -axis, columns, sign * multipliers, sign * offsets


def _placements(placements: Sequence[Any]) -> Floats:
    return np.ascontiguousarray(np.reshape([p.homogeneous[:3] for p in placements], (-1, 3, 4)), dtype=np.float64)
