"""OMPL's state validity checker for robots in space: exact verdicts, and clearances.

In: a checker, its OMPL space. Out: `ExactStates`. Verdicts come from one compiled call if the robot's numbers need no
conversion (`Checker.state_validity`).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from ompl import base

from plannercheck.motions.checker import Checker
from plannercheck.ompl.joint_space import JointSpace
from plannercheck.ompl.pose_space import PoseSpace


class ExactStates(base.StateValidityChecker):  # type: ignore[misc]  # OMPL's bindings are untyped
    """Judges states, and gives clearances to OMPL's samplers, paths and objectives."""

    def __init__(self, information: Any, checker: Checker, space: JointSpace | PoseSpace) -> None:
        """Keeps the space, but not the SpaceInformation, which keeps this object."""
        super().__init__(information)
        self._checker, self._space = checker, space
        is_plain = isinstance(space, JointSpace)
        compiled = checker.state_validity(space.numbers.states, space.numbers.failure) if is_plain else None
        if compiled is not None:
            self.__dict__["isValid"] = compiled  # OMPL calls it instead of the method, without a frame of Python

    def isValid(self, state: Any) -> bool:  # noqa: N802  # OMPL's name
        """Whether a state is free of collision."""
        return self._checker.is_valid(np.array(self._space.read(state)))

    def clearance(self, state: Any) -> float:
        """The least distance of all pairs, m; where bodies overlap, the negative of a depth (`Checker.clearance`)."""
        return self._checker.clearance(np.array(self._space.read(state)))
