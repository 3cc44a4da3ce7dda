"""Methods of other libraries for `bench states` that are more than a function of configurations: coal's loop, and VAMP.

In: a checker. Out: what `Method`s of methods.py build and how they judge.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from plannercheck.common.array_types import Bools, Floats
from plannercheck.evaluation.bench.coal_loop import CoalLoop, CoalStates, Variant
from plannercheck.evaluation.bench.vamp_model import VampModel
from plannercheck.motions.checker import Checker


class CoalAtBest:
    """coal's loop, asked as is fastest for the first states that it gets."""

    def __init__(self, checker: Checker) -> None:
        """Builds the loop."""
        self._loop = CoalLoop.of_checker(checker)
        self._variant: Variant | None = None

    @property
    def note(self) -> str:
        """How coal is asked."""
        return f"C++ loop over poses given beforehand: {self._variant}"

    def states(self, q: Floats) -> CoalStates:
        """Configurations (n, nq) as coal takes them."""
        found = self._loop.states(q)
        if self._variant is None:
            self._variant = self._loop.fastest(found)[0]
        return found

    def check(self, states: CoalStates) -> Bools:
        """Which are free."""
        assert self._variant is not None
        return self._loop.check(states, self._variant)


class VampInside:
    """VAMP's own work on states: the calls, whose copying of the obstacles is timed apart."""

    note = "a call for each state, less what a call with nothing to judge takes; eight lanes judge the same state"

    def __init__(self, checker: Checker) -> None:
        """Builds the model."""
        self._model = VampModel(checker)

    def paths(self, q: Floats) -> list[Any]:
        """Configurations (n, nq) as VAMP takes them."""
        return self._model.paths(q, q)

    def check(self, paths: list[Any]) -> Bools:
        """Which are free."""
        return self._model.free(paths)

    def copying(self, paths: list[Any]) -> list[bool]:
        """What is taken off."""
        return self._model.copying(len(paths))


class VampFromPython:
    """VAMP as its users call it, state by state."""

    note = "validate, called from Python; each call copies the obstacles"

    def __init__(self, checker: Checker) -> None:
        """Builds the model."""
        self._model = VampModel(checker)

    def rows(self, q: Floats) -> list[Any]:
        """Configurations (n, nq) as VAMP takes them."""
        return self._model.rows(q)

    def check(self, rows: list[Any]) -> Bools:
        """Which are free."""
        return np.asarray(self._model.states_free(rows))
