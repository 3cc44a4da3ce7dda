"""Joints that a user moves by sliders, and the picture for their values.

In: a checker, the configurations of a picture. Out: `Joints`: the sliders' names, bounds and values, and a picture with
its verdict for values that the user sets.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.checking.named_configurations import given_configurations
from plannercheck.checking.protocols import AnyChecker
from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.view.page import Picture
from plannercheck.view.picture import picture
from plannercheck.view.surfaces import Surface, Visual

# How far a joint without limits is moved: a whole turn, rad; of a vehicle's x and y, m.
_TURN, _WAY = np.pi, 10.0


@dataclass(frozen=True, eq=False)
class Joints:
    """A robot's joints.

    Attributes:
        names: (nq,) what the sliders are called.
        lower: (nq,) where they begin, rad and m.
        upper: (nq,) where they end.
        rows: (frames, nq) the configurations that the picture shows.
        checker: The checker that judges.
        meshes: As for `picture`.
        visuals: As for `picture`.
    """

    names: tuple[str, ...]
    lower: Floats
    upper: Floats
    rows: Floats
    checker: AnyChecker = field(repr=False)
    meshes: Mapping[str, Surface] | None = field(default=None, repr=False)
    visuals: Sequence[Visual] = field(default=(), repr=False)

    def picture_of(self, q: ArrayLike) -> Picture:
        """One frame, of a configuration (nq,)."""
        values = ", ".join(f"{value:.3f}" for value in np.asarray(q))
        return picture(self.checker, q, labels=[f"joints at {values}"], meshes=self.meshes, visuals=self.visuals)


def joints_of(
    checker: AnyChecker,
    q: ArrayLike,
    meshes: Mapping[str, Surface] | None = None,
    visuals: Sequence[Visual] = (),
) -> Joints:
    """The joints of a checker's robot; arguments as for `picture`.

    Raises:
        PlannercheckError: If a joint takes several numbers, which sliders can't set one by one.
    """
    robot = checker.robot
    rows = given_configurations(robot, q)
    if len(robot.joint_names) != robot.nq:
        raise PlannercheckError(
            f"sliders are for joints of one number each, some of {robot.name} take several: choose a planning group"
        )
    far = np.where(np.isin(np.arange(robot.nq), _ways(checker)), _WAY, _TURN)
    lower = np.where(np.isfinite(robot.lower), robot.lower, rows.min(axis=0) - far)
    upper = np.where(np.isfinite(robot.upper), robot.upper, rows.max(axis=0) + far)
    lower, upper = np.minimum(lower, rows.min(axis=0)), np.maximum(upper, rows.max(axis=0))
    return Joints(robot.joint_names, lower, upper, rows, checker, meshes, visuals)


def _ways(checker: AnyChecker) -> list[int]:
    """Columns that are lengths without limits: x and y of a planar robot that moves freely."""
    return [0, 1] if getattr(checker.robot, "is_free", False) else []
