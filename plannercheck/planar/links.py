"""The parts of planar robots: links, given or read from a file, and the convex polygons on them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

from numpy.typing import ArrayLike

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import OwnsArrays
from plannercheck.common.public_names import set_module

Joint: TypeAlias = Literal["free", "revolute", "fixed"]


@set_module("plannercheck.planar")
@dataclass(frozen=True, eq=False)
class Link:
    """One rigid part of a planar robot.

    Attributes:
        name: Unique in the robot.
        footprint: One outline (n, 2) in the link's frame, m, or several; concave ones are split.
        parent: The name of its parent link, which is listed before it; None for the root.
        anchor: x, y in m and angle in rad of its frame in the parent's frame, or in the world.
        joint: "free" (the root alone), "revolute" or "fixed".
        limits: Least and largest angle of a revolute joint, rad; infinite for one that turns freely, and for others.
    """

    name: str
    footprint: ArrayLike | Sequence[ArrayLike]
    parent: str | None = None
    anchor: tuple[float, float, float] = (0.0, 0.0, 0.0)
    joint: Joint = "fixed"
    limits: tuple[float, float] = (-math.inf, math.inf)


@dataclass(frozen=True, eq=False)
class GeometryObject(OwnsArrays):
    """A convex polygon on a link, or in the world.

    Attributes:
        name: The name that reports use.
        link: Index of the link; -1 for a body in the world.
        vertices: (n, 2) in the link's frame, or in its own if it is in the world, m.
        pose: (3, 3) in the world, for a body on no link.
    """

    name: str
    link: int
    vertices: Floats
    pose: Floats
