"""The states that a scene declares for each robot: start, goal, and sample configurations.

In: arrays and npy files. Out: checked configurations by robot name. Scenes in space and in the plane share this.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.common.array_types import Floats
from plannercheck.common.checked_yaml import BROKEN_FILE
from plannercheck.common.errors import PlannercheckError


@dataclass(frozen=True)
class RobotStates:
    """The start and the goal (nq,) that a scene declares for one robot, and an npy file of samples (n, nq); or None."""

    start: Floats | None = None
    goal: Floats | None = None
    samples: Path | None = None


class DeclaredStates:
    """The start, goal and samples that a scene, named for errors, declares by robot name."""

    def __init__(self, name: str) -> None:
        """Declares nothing yet."""
        self.name = name
        self.states: dict[str, RobotStates] = {}

    def set_states(
        self,
        robot: str,
        start: ArrayLike | None = None,
        goal: ArrayLike | None = None,
        samples: str | Path | None = None,
    ) -> None:
        """Declares a robot's start and goal (nq,) and its npy file of samples; None keeps the former value."""
        states = self.states.get(robot, RobotStates())
        if start is not None:
            states = replace(states, start=_configuration(start, f"start of {robot!r}"))
        if goal is not None:
            states = replace(states, goal=_configuration(goal, f"goal of {robot!r}"))
        if samples is not None:
            states = replace(states, samples=Path(samples))
        if states.start is not None and states.goal is not None and len(states.start) != len(states.goal):
            raise PlannercheckError(
                f"states of {robot!r}: start has {len(states.start)} values, goal has {len(states.goal)}"
            )
        self.states[robot] = states

    def start(self, robot: str) -> Floats:
        """The start configuration (nq,) that the scene declares for a robot."""
        return self._declared(robot, "start", self._states_of(robot, "start").start)

    def goal(self, robot: str) -> Floats:
        """The goal configuration (nq,) that the scene declares for a robot."""
        return self._declared(robot, "goal", self._states_of(robot, "goal").goal)

    def samples(self, robot: str) -> Floats:
        """The sample configurations (n, nq) that the scene declares for a robot."""
        states = self._states_of(robot, "samples")
        if states.samples is None:
            raise self._undeclared(robot, "samples")
        samples = _load_samples(states.samples)
        width = samples.shape[1] if states.start is None else len(states.start)
        if samples.shape[1] != width:
            file = str(states.samples)
            raise PlannercheckError(f"samples {file!r} have {samples.shape[1]} columns, start has {width}")
        return samples

    def _states_of(self, robot: str, what: str) -> RobotStates:
        if robot not in self.states:
            raise self._undeclared(robot, what)
        return self.states[robot]

    def _declared(self, robot: str, what: str, value: Floats | None) -> Floats:
        if value is None:
            raise self._undeclared(robot, what)
        return value

    def _undeclared(self, robot: str, what: str) -> PlannercheckError:
        others = f", but for {', '.join(self.states)}" if self.states else ""
        return PlannercheckError(
            f"scene {self.name!r} declares no {what} for robot {robot!r}{others}: give the {what} yourself"
        )


def _configuration(values: ArrayLike, what: str) -> Floats:
    """A read-only configuration (nq,), all values finite."""
    try:
        array = np.array(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise PlannercheckError(f"{what} must be a list of numbers, not {values!r}") from None
    if array.ndim != 1 or not len(array):
        raise PlannercheckError(f"{what} must be one configuration (nq,), not of shape {array.shape}")
    if not np.isfinite(array).all():
        raise PlannercheckError(f"{what} has values that are not finite: {array.tolist()}")
    array.setflags(write=False)
    return array


def _load_samples(path: Path) -> Floats:
    """A set of configurations (n, nq) from an npy file."""
    try:
        samples = np.load(path, allow_pickle=False)
    except BROKEN_FILE as error:
        raise PlannercheckError(f"samples {str(path)!r} can't be read as npy: {error!s:.200}") from None
    if not isinstance(samples, np.ndarray) or samples.ndim != 2 or samples.dtype.kind not in "fiu":
        raise PlannercheckError(f"samples {str(path)!r} must be one array (n, nq) of numbers")
    bad = np.flatnonzero(~np.isfinite(samples).all(axis=1))
    if len(bad):
        raise PlannercheckError(f"samples {str(path)!r}: row {int(bad[0])} has values that are not finite")
    return samples.astype(np.float64)
