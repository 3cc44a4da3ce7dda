"""The joints of a robot with free bodies: each joint's OMPL space, and the limits of its numbers.

In: a robot, a box for positions. Out: `parts_of`, the joints in the order of their columns, and `limits_of`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.ompl.joint_space import free_range
from plannercheck.robots.configurations import is_continuous, joint_by_name
from plannercheck.robots.joints import CIRCLE, KINDS, Name, kind_of
from plannercheck.robots.robot import Robot

# Joints of one number are angles that whole turns do not change, or numbers.
Kind = Name | Literal["angle", "number"]

# How many numbers of a configuration and of an OMPL state a joint takes, and how many of these are a position.
WIDTHS: dict[Kind, tuple[int, int, int]] = {
    **{kind.name: (kind.numbers, kind.state_numbers, kind.lengths) for kind in KINDS},
    "angle": (1, 1, 0),
    "number": (1, 1, 0),
}


class Part(NamedTuple):
    """A joint: its kind, its first column in a configuration, and its first number in an OMPL state."""

    kind: Kind
    column: int
    number: int

    @property
    def columns(self) -> slice:
        """Its numbers in a configuration."""
        return slice(self.column, self.column + WIDTHS[self.kind][0])

    @property
    def position(self) -> slice:
        """The columns of its position; none for joints that only turn or slide."""
        return slice(self.column, self.column + WIDTHS[self.kind][2])

    @property
    def turn(self) -> slice:
        """The columns of a quaternion, of a cosine and a sine, or of an angle."""
        return slice(self.position.stop, self.columns.stop)


def has_free_bodies(robot: Robot) -> bool:
    """Whether a joint of a robot's configurations is floating, planar or a ball joint."""
    kinds = (kind_of(joint_by_name(robot.model, name)) for name in robot.joint_names)
    return any(kind is not None and not kind.has_axis for kind in kinds)


def parts_of(robot: Robot) -> tuple[Part, ...]:
    """The joints of a robot's configurations, in the order of their columns.

    Raises:
        PlannercheckError: If a joint takes several numbers that OMPL has no space for.
    """
    whole_turns, out, number = robot.configuration_map.turning_columns(), list[Part](), 0
    for name, column in zip(robot.joint_names, robot.configuration_map.starts, strict=True):
        joint = joint_by_name(robot.model, name)
        own = kind_of(joint)
        kind: Kind | None = None if own is None else own.name
        if joint.nq == 1:
            kind = "number"
        elif own is CIRCLE and robot.group is not None:
            kind = "angle" if whole_turns[column] else "number"
        if kind is None:
            raise PlannercheckError(
                f"joint {name!r} of {robot.name} takes {joint.nq} numbers, of which OMPL has no space: choose a "
                "planning group without it (robot.with_group)"
            )
        out.append(Part(kind, column, number))
        number += WIDTHS[kind][1]
    return tuple(out)


def limits_of(
    robot: Robot, parts: Sequence[Part], bounds: ArrayLike | None, held: Sequence[Floats]
) -> tuple[Floats, Floats]:
    """(nq,) least and largest of all numbers; positions are within the box as well, if there is one."""
    lower, upper = robot.lower, robot.upper
    box = None if bounds is None else _checked_box(bounds)
    for part in parts:
        where = part.position
        if box is not None and where.stop > where.start:
            lower[where] = np.maximum(lower[where], box[0, : where.stop - where.start])
            upper[where] = np.minimum(upper[where], box[1, : where.stop - where.start])
        name = robot.joint_names[parts.index(part)]
        if part.kind == "number" and is_continuous(joint_by_name(robot.model, name)):
            reach = free_range(robot.configuration_map, part.column)
            own = [float(q[part.column]) for q in held]
            lower[part.column], upper[part.column] = min([-reach, *own]), max([reach, *own])
        bounded = part.columns if part.kind == "number" else where
        if not np.isfinite([lower[bounded], upper[bounded]]).all():
            hint = "give the box of its positions by bounds=" if where.stop > where.start else "planning needs both"
            limits = f"{lower[bounded].tolist()} to {upper[bounded].tolist()}"
            raise PlannercheckError(f"joint {name!r} of {robot.name} has limits {limits}: {hint}")
    return lower, upper


def _checked_box(bounds: ArrayLike) -> Floats:
    try:
        box = np.array(bounds, dtype=np.float64)
    except (TypeError, ValueError):
        box = np.zeros(0)
    if box.shape != (2, 3) or not np.isfinite(box).all() or not (box[0] < box[1]).all():
        raise PlannercheckError(
            f"bounds must be the least and the largest x, y, z of free bodies, (2, 3) in m, not {bounds!r:.80}"
        )
    return box
