"""A body at a pose that has been checked, for many queries.

In: a prepared body and a pose. Out: `Placed`, which pair queries take in place of a body and its pose.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import checked_pose
from plannercheck.common.array_types import Floats
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.public_names import set_module


@set_module("plannercheck")
class Placed:
    """A body that stays where it is: its pose is checked once, not by each query. Immutable.

    `intersects`, `certify`, `distance` and `depth` take it in place of a body and its pose.
    """

    __slots__ = ("__weakref__", "_core", "_polytope", "_pose")

    def __init__(self, polytope: Polytope, pose: ArrayLike | None = None) -> None:
        """Checks the pose.

        Args:
            polytope: The body.
            pose: Pose (4, 4) in the world, m; None is the identity. Used as the affine map that its doubles give.

        Raises:
            PlannercheckError: If the pose is not finite or not rigid, or the body is no `Polytope`.
        """
        if not isinstance(polytope, Polytope):
            raise PlannercheckError(
                f"Placed takes a Polytope, not {type(polytope).__name__}: prepare the body once by pc.Polytope(...)"
            )
        self._polytope, self._pose = polytope, checked_pose(pose, "a placed body")
        self._core = core.PlacedPolytope(polytope.core, np.ascontiguousarray(self._pose))

    @property
    def polytope(self) -> Polytope:
        """The body."""
        return self._polytope

    @property
    def pose(self) -> Floats:
        """Its pose (4, 4) in the world, m, read-only."""
        return self._pose

    def __reduce__(self) -> tuple[Any, ...]:
        return Placed, (self._polytope, self._pose)

    def __repr__(self) -> str:
        return f"Placed({self._polytope!r}, {self._pose.tolist()})"
