"""Reasons why a planner can't start or end at a configuration.

In: a checker and a configuration. Out: `EndState`: limits exceeded and colliding pairs.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from operator import le

import numpy as np

from plannercheck.checking.input_hints import degrees_hint
from plannercheck.checking.named_configurations import given_configurations, named_configuration
from plannercheck.checking.protocols import AnyChecker, AnyRobot
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import Configuration, named_numbers
from plannercheck.common.errors import PlannercheckError

# What is beyond a limit by at most this, rad or m, is taken at the limit: rounding of files and degrees.
_AT_LIMIT = 1e-6


@dataclass(frozen=True)
class EndState:
    """The verdict on a start or a goal.

    Attributes:
        beyond: A text for each joint limit that is exceeded.
        pairs: Links with the links or obstacles they collide with, in the order of the checker's pair table.
        hint: What is probably wrong with the numbers, e.g. degrees; else empty.
        met: The pairs as `reason` names them: of clouds and maps with the part that collides.
    """

    beyond: tuple[str, ...]
    pairs: tuple[tuple[str, str], ...]
    hint: str = ""
    met: tuple[tuple[str, str], ...] = ()

    @property
    def accepted(self) -> bool:
        """Whether planning may start or end here."""
        return not self.beyond and not self.pairs

    def reason(self, name: str) -> str:
        """Why it is not accepted, in a sentence that uses the given name; empty if it is accepted."""
        if self.accepted:
            return ""
        parts = [f"{name} is beyond the limits: {', '.join(self.beyond)}"] if self.beyond else []
        parts += [self.hint] if self.hint else []
        collisions = ", ".join(f"{first} with {second}" for first, second in self.met)
        return "; ".join(parts + ([f"{name} collides: {collisions}"] if self.pairs else []))


_ACCEPTED = EndState((), ())


def check_end_state(checker: AnyChecker, q: Floats) -> EndState:
    """Judges a configuration (nq,)."""
    robot = checker.robot
    if _is_within(robot, q) and checker.is_valid(q):
        return _ACCEPTED
    beyond = [
        f"{_column_name(robot, k)} is {q[k]:.12g}, not in [{robot.lower[k]:.12g}, {robot.upper[k]:.12g}]"
        for k in np.flatnonzero((q < robot.lower) | (q > robot.upper)).tolist()
    ]
    collisions = () if checker.is_valid(q) else checker.explain(q).collisions
    pairs = dict.fromkeys((v.first, v.second) for v in collisions)
    met = dict.fromkeys(v.names for v in collisions)
    return EndState(tuple(beyond), tuple(pairs), degrees_hint(robot, q), tuple(met))


def checked_end(checker: AnyChecker, q: Configuration, name: str) -> Floats:
    """One configuration (nq,), given by its numbers or by names of joints, or an error that uses its name."""
    shape = () if isinstance(q, Mapping) else named_numbers(q, name).shape
    if not isinstance(q, Mapping) and len(shape) != 1:
        raise PlannercheckError(f"{name} must be one configuration ({checker.robot.nq},), not {shape}")
    try:
        of = named_configuration(checker.robot, q) if isinstance(q, Mapping) else given_configurations(checker.robot, q)
        return _at_limits(checker.robot, np.asarray(of[0]), name)
    except PlannercheckError as error:
        raise PlannercheckError(f"{name}: {error}") from None


def _is_within(robot: AnyRobot, q: Floats) -> bool:
    numbers = q.tolist()  # few: lists take half as long
    return all(map(le, robot.lower.tolist(), numbers)) and all(map(le, numbers, robot.upper.tolist()))


def _at_limits(robot: AnyRobot, q: Floats, name: str) -> Floats:
    """A configuration (nq,) whose numbers that are just beyond a limit are the limit; a warning names them."""
    if _is_within(robot, q):
        return q
    inside = np.clip(q, robot.lower, robot.upper)
    moved = np.flatnonzero((inside != q) & (np.abs(inside - q) <= _AT_LIMIT)).tolist()
    if not moved:
        return q
    q = q.copy()
    for k in moved:
        warnings.warn(
            f"{name}: {_column_name(robot, k)} is {float(q[k])!r}, beyond its limit {float(inside[k])!r} by "
            f"{abs(q[k] - inside[k]):.2g}: it is taken as the limit",
            RuntimeWarning,
            stacklevel=4,
        )
        q[k] = inside[k]
    return q


def _column_name(robot: AnyRobot, k: int) -> str:
    return robot.joint_names[k] if len(robot.joint_names) == robot.nq else f"column {k}"
