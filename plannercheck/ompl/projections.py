"""Projections of spaces for which OMPL has none: KPIECE1, BKPIECE1 and LBKPIECE1 need them for their cells.

In: one of our OMPL compound spaces. Out: its first two numbers as the default projection: x and y of a planar robot, or
else the two joints next to the base, which move most of the robot (MoveIt's setup assistant uses these two as well).
With a free body, it is the projection of the first of OMPL's own spaces that has one.
"""

from __future__ import annotations

from math import pi
from typing import Any

from ompl import base

# Spaces that OMPL has a projection for.
_PROJECTED = (base.SE2StateSpace, base.SE3StateSpace, base.SO3StateSpace)

# Joints whose values are the projection.
_JOINTS = 2


class FirstJoints(base.ProjectionEvaluator):  # type: ignore[misc]  # OMPL's bindings are untyped
    """The values of the first two joints of a space that has a part for each joint, rad or m."""

    def __init__(self, space: Any) -> None:
        """Reads the parts of an OMPL compound space, but does not keep it, since it keeps this object."""
        super().__init__(space)
        parts = [space.getSubspace(k) for k in range(min(_JOINTS, space.getSubspaceCount()))]
        self._turning = [isinstance(part, base.SO2StateSpace) for part in parts]
        bounds = base.RealVectorBounds(len(parts))  # OMPL makes 20 cells of each range
        for k, part in enumerate(parts):
            bounds.setLow(k, -pi if self._turning[k] else part.getBounds().low[0])
            bounds.setHigh(k, pi if self._turning[k] else part.getBounds().high[0])
        self.setBounds(bounds)

    def getDimension(self) -> int:  # noqa: N802  # OMPL's name
        """How many numbers a projection has: 2, or 1 if there is one joint."""
        return len(self._turning)

    def project(self, state: Any, projection: Any) -> None:
        """Writes the joints' values into an array (dimension,)."""
        for k, turning in enumerate(self._turning):
            projection[k] = state[k].value if turning else state[k][0]


def register_projection(space: Any) -> None:
    """Gives one of our OMPL compound spaces a default projection; other spaces have OMPL's own."""
    for k in range(space.getSubspaceCount()):
        if isinstance(space.getSubspace(k), _PROJECTED):
            space.registerDefaultProjection(base.SubspaceProjectionEvaluator(space, k))
            return
    space.registerDefaultProjection(FirstJoints(space))
