"""OMPL's state validity checker for robots in space: exact verdicts, and clearances.

In: a checker, its OMPL space. Out: `ExactStates`. Verdicts come from one compiled call where states are plain numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from ompl import base

from plannercheck.motions.checker import Checker
from plannercheck.ompl.joint_space import JointSpace


class ExactStates(base.StateValidityChecker):  # type: ignore[misc]  # OMPL's bindings are untyped
    """Judges states, and gives clearances to OMPL's samplers, paths and objectives."""

    def __init__(self, information: Any, checker: Checker, space: JointSpace) -> None:
        """Keeps the space, but not the SpaceInformation, which keeps this object."""
        super().__init__(information)
        self._checker, self._space = checker, space
        compiled = None if space.continuous.any() else checker.state_validity()
        self._judge: Callable[[Any], bool] = compiled or self._read_and_judged

    def _read_and_judged(self, state: Any) -> bool:
        return self._checker.is_valid(np.array(self._space.read(state)))

    def isValid(self, state: Any) -> bool:  # noqa: N802  # OMPL's name
        """Whether a state is free of collision."""
        return self._judge(state)

    def clearance(self, state: Any) -> float:
        """The least distance of all pairs, m; where bodies overlap, the negative of a depth (`Checker.clearance`)."""
        return self._checker.clearance(np.array(self._space.read(state)))
