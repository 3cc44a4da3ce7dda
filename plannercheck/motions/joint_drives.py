"""Which columns drive the joints of a motion, and how far joints differ from rigid ones.

In: the kernel's joint table. Out: for each joint its column and its kind of move; the groups of columns that form a
circle, a quaternion or a pose; the defect of all placements that no motion changes; and how far joints and links are
from the world's origin.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from plannercheck.common.array_types import Floats, Ints
from plannercheck.common.motion_paths import MotionPath
from plannercheck.robots.joints import KINDS, SLIDE
from plannercheck.robots.kinematics import JointTable
from plannercheck.robots.unit_lengths import DEFECT_PARTS

# DriveKind in cpp/motions/motion_bounds.hpp.
TURN_DRIVE, SLIDE_DRIVE, PART_DRIVE = 0, 1, 2


class Spread(NamedTuple):
    """How far from the world's origin joints and links may be on a motion, for any angles.

    Attributes:
        extent: The distance with all columns at 0, m.
        travel: (width,) what each unit of a column adds, at the end where the column is larger, m.
        joints: Number of joints on the longest chain.
    """

    extent: float
    travel: Floats
    joints: int


def spread(table: JointTable) -> Spread:
    """Adds up lengths of placements along a robot's chains, from the world on."""
    extents, counts = [0.0], [0]  # the world's, at -1, comes first
    travel = np.zeros(table.width)
    lengths = np.linalg.norm(table.placements[:, :, 3], axis=1).tolist()
    for j, (parent, number) in enumerate(zip(table.parents.tolist(), table.kinds.tolist(), strict=True)):
        kind, count = KINDS[number], KINDS[number].lengths
        columns, multipliers = table.columns[j, :count], np.abs(table.multipliers[j, :count])
        np.add.at(travel, columns[columns >= 0], kind.stretch * multipliers[columns >= 0])
        extents.append(extents[parent + 1] + lengths[j] + float(np.abs(table.offsets[j, :count]).sum()))
        counts.append(counts[parent + 1] + 1)
    ends = np.linalg.norm(table.link_placements[:, :, 3], axis=1).tolist()
    on_links = (extents[j + 1] + end for j, end in zip(table.link_joints.tolist(), ends, strict=True))
    return Spread(max(*extents, *on_links), travel, max(counts))


def split_joints(table: JointTable, path: MotionPath) -> tuple[tuple[int, int], ...]:
    """The joints whose position and turn move by themselves on a path, and how many numbers the position has."""
    kinds = enumerate(KINDS[k] for k in (table.kinds.tolist() if path == "slerp" else ()))
    return tuple((j, kind.lengths) for j, kind in kinds if kind.is_pose and (table.columns[j] >= 0).any())


def drives(table: JointTable, path: MotionPath = "screw") -> tuple[Ints, Floats, Ints]:
    """Kinds and columns (joints, 2), multipliers and offsets (joints, 2), and kinds and columns of parts (parts, 2).

    Where positions and turns move by themselves, the slides come after the table's joints, as in `JointTree`.
    """
    listed: list[tuple[int, int]] = []
    parts: dict[int, int | None] = {}
    split = dict(split_joints(table, path))
    factors = [np.stack([table.multipliers[:, 0], table.offsets[:, 0]], axis=1)]
    for joint, (number, columns) in enumerate(zip(table.kinds.tolist(), table.columns.tolist(), strict=True)):
        kind, column = KINDS[number], columns[0]
        if kind.part is None or column < 0:
            listed.append((SLIDE_DRIVE if kind is SLIDE else TURN_DRIVE, column))
            continue
        first = column + split.get(joint, 0)
        listed.append((PART_DRIVE, first))
        parts[first] = kind.turn_part if joint in split else kind.part
    for joint, count in split.items():
        listed += [(SLIDE_DRIVE, int(column)) for column in table.columns[joint, :count]]
        factors.append(np.stack([table.multipliers[joint, :count], table.offsets[joint, :count]], axis=1))
    by_column = sorted(parts.items())
    return (
        np.array(listed, dtype=np.int32).reshape(-1, 2),
        np.ascontiguousarray(np.concatenate(factors)),
        np.array([(part, column) for column, part in by_column], dtype=np.int32).reshape(-1, 2),
    )


def defect(table: JointTable) -> float:
    """The defect of all placements, axes and held joints together, with room for rounding."""
    turns = np.concatenate([table.placements[:, :, :3], table.link_placements[:, :, :3]])
    off = np.linalg.norm(np.swapaxes(turns, 1, 2) @ turns - np.eye(3), axis=(1, 2)).sum()
    axes = np.linalg.norm(table.axes, axis=1)
    return float(off + np.abs(axes[axes > 0] - 1).sum() + _held_defect(table)) * 2


def _held_defect(table: JointTable) -> float:
    """The defect of joints that are held at a unit vector whose length is not exactly 1."""
    total = 0.0
    for kind, columns, offsets in zip(table.kinds.tolist(), table.columns, table.offsets, strict=True):
        start, stop = KINDS[kind].unit or (0, 0)
        if stop > start and columns[start] < 0:
            total += DEFECT_PARTS[stop - start] * abs(float(np.linalg.norm(offsets[start:stop])) - 1)
    return total
