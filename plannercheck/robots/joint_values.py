"""Configurations of a robot without a group, given by one number for each joint.

In: a Pinocchio model, the mimic joints. Out: maps that turn such rows into Pinocchio's q. In a row, a continuous joint
is one angle, not its cosine and sine. One map takes all joints; another map takes the joints that are no mimic joints,
as in MoveIt.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import contiguous, row_length
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.whole_numbers import whole_number
from plannercheck.robots.configurations import ConfigurationMap, planning_group
from plannercheck.robots.urdf import Mimic


def own_joints(model: pin.Model, mimics: Mapping[str, Mimic]) -> tuple[str, ...]:
    """The joints that follow no other joint, in Pinocchio's order."""
    return tuple(name for name in list(model.names)[1:] if name not in mimics)


def row_of_named(values: Mapping[str, ArrayLike], names: Sequence[str], widths: Sequence[int]) -> Floats:
    """Values by names of joints as (sum of widths,) numbers in the order of the names.

    Raises:
        PlannercheckError: If a joint is missing, is not one of them, or has not as many numbers as it takes.
    """
    for name in values:
        if name not in names:
            raise unknown_name("joint", name, names)
    missing = [name for name in names if name not in values]
    if missing:
        raise PlannercheckError(
            f"one configuration by names needs a value for each joint; missing: {', '.join(missing)}"
        )
    numbers = [_numbers_of(name, values[name], width) for name, width in zip(names, widths, strict=True)]
    return np.concatenate([np.zeros(0), *numbers])


def _numbers_of(joint: str, value: ArrayLike, width: int) -> Floats:
    try:
        numbers = np.atleast_1d(contiguous(value))
    except (TypeError, ValueError, OverflowError):
        numbers = np.zeros((0, 0))
    if numbers.shape != (width,):
        wanted = "one real number" if width == 1 else f"{width} real numbers"
        raise PlannercheckError(f"joint {joint!r} takes {wanted}, not {value!r:.80}")
    return numbers


class JointValues:
    """Configurations of a robot, given by its joints' values.

    Attributes:
        maps: Maps from fewer numbers than Pinocchio has to its configurations, each of another width, the widest first;
            none for a robot with a group, whose joints take one number each anyway.
    """

    def __init__(
        self, configurations: ConfigurationMap, model: pin.Model, mimics: Mapping[str, Mimic], is_whole: bool
    ) -> None:
        self._map, self._follow = configurations, bool(mimics) and is_whole
        maps = []
        if is_whole:
            own = planning_group(model, own_joints(model, mimics), {}, mimics)
            every = planning_group(model, tuple(model.names)[1:], {}, {})
            maps = [each for each in (every, own) if each.width < model.nq]
        self.maps = tuple({each.width: each for each in maps}.values())

    def configurations(self, rows: ArrayLike) -> Floats:
        """Configurations from joint values.

        Args:
            rows: (n, nq) or (nq,), rad and m. For a robot without a group also one number for each joint, or for each
                joint that does not follow another one; a continuous joint is then one angle.

        Returns:
            (n, nq), checked.
        """
        if not self.maps:
            return self._map.checked(rows)
        width = row_length(rows)
        chosen = next((each for each in self.maps if each.width == width), None)
        return self._map.checked(rows) if chosen is None else chosen.expand(chosen.checked(rows))

    def named(self, values: Mapping[str, ArrayLike]) -> Floats:
        """The configuration of values by names of joints.

        Args:
            values: Value of each joint, rad or m. Of a robot without a group, a continuous joint is one angle, and
                joints that follow others may be left out.

        Returns:
            (1, nq), checked.

        Raises:
            PlannercheckError: If a joint is missing, or not one of them.
        """
        maps = (*reversed(self.maps), self._map)  # those of fewer joints first
        chosen = next((each for each in maps if values.keys() <= set(each.joint_names)), self._map)
        ends = (*chosen.starts[1:], chosen.width)
        widths = [end - start for start, end in zip(chosen.starts, ends, strict=True)]
        return self.configurations(row_of_named(values, chosen.joint_names, widths))

    def random(self, n: int, seed: int | np.random.Generator | None) -> Floats:
        """As `ConfigurationMap.random`, (n, nq); joints that follow others do so."""
        n = whole_number(n, "n must be a number of configurations, 0 or more", 0)
        if not self._follow:
            return self._map.random(n, seed)
        return self.maps[-1].expand(self.maps[-1].random(n, seed))
