"""Goals of a plan: one configuration, several, or a function that yields them, such as inverse kinematics.

In: the argument `goal=` of `plan`. Out: `Goals`: the valid goals, with their numbers, or why there is none.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.checking.protocols import AnyChecker
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import Configuration, shown_array
from plannercheck.common.errors import PlannercheckError
from plannercheck.ompl.angle_checkers import angle_end
from plannercheck.ompl.start_and_goal import check_end_state

# One configuration, several of them, or a function that yields them.
Goal: TypeAlias = Configuration | ArrayLike | Callable[[], Iterable[Configuration]]

# A function gives so many goals, or as many as it yields in this part of the time limit, but at least one if
# there is one: a planner that connects trees needs few goals, and has to have the time to reach one.
_MOST_DRAWN, _TIME_TO_DRAW = 16, 0.1

# Refused goals that a reason names.
_MOST_NAMED = 3


@dataclass
class Goals:
    """What can be planned to.

    Attributes:
        rows: The goals, (nq,) each.
        numbers: The place of each among those that were given or yielded.
        refused: Why each of the others can't be planned to.
        given: How many were given or yielded.
    """

    rows: list[Floats] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)
    refused: list[str] = field(default_factory=list)
    given: int = 0

    def add(self, checker: AnyChecker, q: Floats, name: str) -> None:
        """Judges another goal."""
        reason = check_end_state(checker, q).reason(name)
        if reason:
            self.refused.append(reason)
        else:
            self.rows.append(q)
            self.numbers.append(self.given)
        self.given += 1

    @property
    def reason(self) -> str:
        """Why there is nothing to plan to; empty if there is a goal."""
        if self.rows:
            return ""
        if not self.given:
            return "there is no goal: the function yielded none"
        more = len(self.refused) - _MOST_NAMED
        return "; ".join(self.refused[:_MOST_NAMED]) + (f"; and {more} more goals" if more > 0 else "")

    def reached(self, q: Floats, differences: Callable[[Floats, Floats], Floats]) -> int:
        """The number of the goal that a path's end (nq,) is, by differences from configurations (k, nq) to it."""
        if len(self.rows) == 1:
            return self.numbers[0]
        return self.numbers[int(np.abs(differences(np.array(self.rows), q)).sum(axis=1).argmin())]


def goals_of(given: AnyChecker, planned: AnyChecker, goal: Goal, time_limit: float) -> Goals:
    """The goals of a plan.

    Args:
        given: The checker that `plan` was given.
        planned: The checker that is planned by: its `angle_checker`.
        goal: (nq,) or a mapping; (k, nq) or k mappings; or a function without arguments that yields such configurations
            or returns them.
        time_limit: The time limit of the plan, s.

    Raises:
        PlannercheckError: If there is no configuration, or something else than a configuration.
    """
    found = Goals()
    if callable(goal):
        _draw(found, given, planned, goal, time_limit)
    elif isinstance(goal, Mapping) or not _are_several(goal):
        found.add(planned, angle_end(given, planned, goal, "goal"), "goal")
    else:
        rows = list(goal)  # type: ignore[arg-type]  # of several, one can be taken after the other
        for k, q in enumerate(rows):
            found.add(planned, angle_end(given, planned, q, f"goal {k}"), f"goal {k}")
        if not rows:
            raise PlannercheckError("goal must be one or more configurations, not (0, nq)")
    return found


def _are_several(goal: Any) -> bool:
    if isinstance(goal, list | tuple) and any(isinstance(q, Mapping) for q in goal):
        return True
    try:
        return np.ndim(goal) == 2
    except ValueError:  # rows of different lengths
        return isinstance(goal, list | tuple)


def _draw(found: Goals, given: AnyChecker, planned: AnyChecker, goal: Callable[[], Any], time_limit: float) -> None:
    began = time.perf_counter()
    for q in _yielded(goal):
        name = f"goal {found.given}"
        found.add(planned, angle_end(given, planned, q, name), name)
        spent = time.perf_counter() - began
        if len(found.rows) >= _MOST_DRAWN or spent > time_limit * (_TIME_TO_DRAW if found.rows else 1.0):
            return


def _yielded(goal: Callable[[], Any]) -> Iterator[Configuration]:
    yielded = goal()
    if isinstance(yielded, Mapping) or not isinstance(yielded, Iterable):
        raise PlannercheckError(f"goal() must yield configurations, not {shown_array(yielded)}")
    for q in yielded:
        if not isinstance(q, Mapping) and np.ndim(q) == 0:
            raise PlannercheckError(f"goal() must yield configurations, one after the other, not numbers: {q!r:.80}")
        yield q
