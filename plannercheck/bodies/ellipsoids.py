"""Ellipsoids, between an outer and an inner polytope.

In: three radii in m and an excess. Out: `Ellipsoid`, one of the shapes, which is tested as the outer polytope; and the
inner one. Both are images of polytopes around and in the unit ball under the map that stretches the axes by the radii.
The map preserves flat faces, convexity and containment, so the ellipsoid has the ball's excess along every direction,
however uneven the radii are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.circumscribed import (
    ROUNDING_MARGIN,
    ball_around,
    check_ball_excess,
    checked_excess,
    ring_around,
)
from plannercheck.bodies.sizes import length, numbers
from plannercheck.common.array_types import Faces
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.public_names import set_module

# How far the polytope of an ellipsoid sticks out, as a part of the radii: 3366 points. Ten times less takes ten times
# as many, and three seconds to prepare.
ELLIPSOID_EXCESS = 1e-3

# Shorter radii, but for 0, are no doubles of full precision, so that nothing is proved of their products.
_LEAST_RADIUS = 1e-250


@set_module("plannercheck")
@dataclass(frozen=True)
class Ellipsoid:
    """An ellipsoid about its centre, its axes along x, y and z.

    It is tested as a polytope around it, which contains it and lies within the ellipsoid of radii larger by the
    excess; so a verdict "free" is one of the ellipsoid, and a collision may be one of the rim, whose width is stated
    and can be set. The exact verdict would need the roots of a polynomial of degree six for each pair, and the shape
    could be in no motion, proof or certificate, all of which are about polytopes. `inner` gives a polytope in the
    ellipsoid: what touches that touches the ellipsoid. A radius of 0 makes a plate, a segment or a point.

    Attributes:
        radii: Along x, y, z in m.
        excess: How far the polytope may stick out, as a part of each radius; at least 4e-6 if no radius is 0.
    """

    radii: tuple[float, float, float]
    excess: float = ELLIPSOID_EXCESS

    def __post_init__(self) -> None:
        radii = numbers(self.radii, "ellipsoid radii")
        if len(radii) != 3:
            raise PlannercheckError(
                f"ellipsoid radii: three lengths in m along x, y, z, not {len(radii)}: {list(radii)}"
            )
        checked = tuple(length(r, f"ellipsoid radius {axis}") for r, axis in zip(radii, "xyz", strict=True))
        for radius, axis in zip(checked, "xyz", strict=True):
            if 0 < radius < _LEAST_RADIUS:
                raise PlannercheckError(f"ellipsoid radius {axis} is {radius} m: 0, or at least {_LEAST_RADIUS} m")
        object.__setattr__(self, "radii", checked)
        object.__setattr__(self, "excess", checked_excess(self.excess))
        if all(checked):
            check_ball_excess(self.excess)

    def vertices_and_faces(self, excess: float = 0.0) -> tuple[NDArray[np.float64], Faces | None]:
        """The outer polytope's points (n, 3) in m and its triangles, by the ellipsoid's own excess."""
        return self._image(1.0)

    def inner(self) -> tuple[NDArray[np.float64], Faces | None]:
        """The inner polytope's points (n, 3) in m and its triangles: all of it is in the ellipsoid.

        It contains the ellipsoid of radii divided by 1 + excess, up to rounding, so that the gap between both polytopes
        is less than twice the excess of each radius.
        """
        return self._image((1 - 2 * ROUNDING_MARGIN) / (1 + self.excess))

    def _image(self, factor: float) -> tuple[NDArray[np.float64], Faces | None]:
        """The polytope around the unit ball, or what radii of 0 leave of it, times a factor and the radii."""
        axes = [axis for axis, radius in enumerate(self.radii) if radius > 0]
        if len(axes) == 3:
            ball = ball_around(self.excess)
            return ball.points * factor * np.array(self.radii), list(ball.triangles)
        flat: NDArray[np.float64] = np.zeros((1, 0))
        if len(axes) == 2:
            flat = ring_around(1.0, self.excess) * factor
        elif axes:
            flat = np.array([[-1.0], [1.0]]) * min(factor, 1.0)
        points = np.zeros((len(flat), 3))
        points[:, axes] = flat * np.array(self.radii)[axes]
        return points, None
