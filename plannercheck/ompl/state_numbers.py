"""The numbers of OMPL's states, copied all at once.

In: an OMPL space whose states are bounded joints, angles, poses in the plane, or compounds of them, and how many
numbers a state has. Out: `StateNumbers`, which reads states, also for compiled functions.

OMPL's bindings show no pointer to a state's numbers, but every space copies them to a place in memory: one call of
45 ns, where seven numbers one by one take 280 ns (measured from Python).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from plannercheck.common.array_types import Floats
from plannercheck.common.core import core

_BYTES = 8  # of a double


class StateNumbers:
    """Reads states of one space, or of any that is made of the same parts.

    Attributes:
        states: The core's PlannerStates, by which compiled functions read them.
        failure: The core's PlannerFailure of validators on this space.
    """

    states: Any
    failure: Any

    def __init__(self, space: Any, width: int) -> None:
        """Takes an OMPL space whose states have so many numbers."""
        assert space.getSerializationLength() == _BYTES * width  # or other memory would be overwritten
        self.failure = core.PlannerFailure()
        self.states = core.PlannerStates(width, space.serialize)

    def read(self, state: Any) -> list[float]:
        """The numbers of a state."""
        numbers: list[float] = self.states.numbers(state)
        return numbers

    def rows(self, states: list[Any]) -> Floats:
        """(n, width), the numbers of n states."""
        rows: Floats = self.states.rows(states)
        return rows


class NumberedSpace:
    """What the spaces of robots in space and in the plane share: their states, and the numbers of these."""

    _numbers: StateNumbers | None = None  # `ompl_space` sets it

    def ompl_space(self) -> Any:
        """A new OMPL space."""
        raise NotImplementedError

    def _numbered(self, space: Any, width: int) -> Any:
        """The given space, whose states of so many numbers are read from now on."""
        self._numbers = StateNumbers(space, width)
        return space

    def write(self, state: Any, q: Sequence[float] | Floats) -> None:
        """Sets an OMPL state to a configuration (nq,)."""
        raise NotImplementedError

    def state(self, information: Any, q: Sequence[float] | Floats) -> Any:
        """A new OMPL state of a configuration (nq,); it frees itself, unlike states of the space."""
        state = information.allocState()
        self.write(state, q)
        return state

    @property
    def numbers(self) -> StateNumbers:
        """The numbers of states of these spaces."""
        if self._numbers is None:
            self.ompl_space()
        assert self._numbers is not None
        return self._numbers

    def read(self, state: Any) -> list[float]:
        """The configuration of an OMPL state, nq numbers."""
        return self.numbers.read(state)

    def rows(self, states: list[Any]) -> Floats:
        """(n, nq) the configurations of a path's states."""
        return self.numbers.rows(states)
