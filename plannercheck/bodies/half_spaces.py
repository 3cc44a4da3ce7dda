"""Half-spaces: all that is on one side of a plane, such as a floor or a wall.

In: a normal and an offset. Out: `HalfSpace`, one of the shapes. An unbounded body has no hull: as its hull, a
half-space has a cube that holds every other body, so no test of hulls ever finds a body apart from it.
cpp/narrow_phase/half_space_pair.hpp decides pairs, half_space_certificates.py proves the verdicts.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.circumscribed import BOX_SIGNS, prism_faces
from plannercheck.bodies.kinds import Kind
from plannercheck.bodies.sizes import number, numbers
from plannercheck.common.array_types import Faces
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.public_names import set_module

# Half the edge of the cube, m, as in cpp/bodies/half_space.cpp: bodies have coordinates up to 1e50.
_UNBOUNDED_EDGE = 1e60

# The furthest plane from the origin of the shape's frame, m.
_FURTHEST = 1e50


@set_module("plannercheck")
@dataclass(frozen=True)
class HalfSpace:
    """All points x with normal · x <= offset: everything under a plane. Its normal points out of it.

    The verdict against another body is that of one extreme vertex, exactly signed, for the very doubles that are given;
    inflation radii count along the normal. A half-space is an obstacle: no link can carry it.

    Attributes:
        normal: (3,) of any length but 0, in the shape's frame.
        offset: The plane is normal · x = offset; with a normal of length 1 in m. 0 is the plane through the origin.
    """

    body_kind: ClassVar[Kind] = "half_space"

    normal: tuple[float, float, float]
    offset: float = 0.0

    def __post_init__(self) -> None:
        normal = numbers(self.normal, "normal of a half-space")
        if len(normal) != 3:
            raise PlannercheckError(f"normal of a half-space must have 3 numbers, not {len(normal)}: {list(normal)}")
        if not all(map(math.isfinite, normal)) or not any(normal):
            raise PlannercheckError(f"normal of a half-space must be finite and not 0, not {list(normal)}")
        offset = number(self.offset, "offset of a half-space must be a number")
        object.__setattr__(self, "normal", tuple(x + 0.0 for x in normal))
        object.__setattr__(self, "offset", offset + 0.0)
        self._check_range()

    def _check_range(self) -> None:
        largest = max(map(abs, self.normal))
        if not math.isfinite(self.offset) or abs(self.offset) / largest > _FURTHEST:
            raise PlannercheckError(
                f"offset of a half-space must be finite and its plane within {_FURTHEST:g} m of the origin, not "
                f"{self.offset} with the normal {list(self.normal)}"
            )
        exponent = math.frexp(largest)[1]
        given, scaled = (*self.normal, self.offset), (*self.scaled[0], self.scaled[1])
        if any(math.ldexp(x, exponent) != y for x, y in zip(scaled, given, strict=True)):
            raise PlannercheckError(
                f"numbers of a half-space must not differ by more than 1e300 in size, as {list(given)} do"
            )

    @property
    def scaled(self) -> tuple[tuple[float, float, float], float]:
        """Normal and offset times a power of 2, so that the largest number of the normal is between 1/2 and 1."""
        exponent = -math.frexp(max(map(abs, self.normal)))[1]
        x, y, z = (math.ldexp(each, exponent) for each in self.normal)
        return (x, y, z), math.ldexp(self.offset, exponent)

    @property
    def digest(self) -> bytes:
        """A hash of the set, equal for half-spaces of the same numbers."""
        return hashlib.sha256(repr((self.normal, self.offset)).encode()).digest()

    def vertices_and_faces(self, excess: float = 0.0) -> tuple[NDArray[np.float64], Faces | None]:
        """The corners (8, 3) in m of a cube that holds every other body, and its faces, whatever the excess."""
        return BOX_SIGNS * _UNBOUNDED_EDGE, prism_faces(4)

    def plate(self, half_edge: float) -> NDArray[np.float64]:
        """The corners (4, 3) in m of a square in the plane, about the point nearest to the origin: to be drawn."""
        normal, offset = self.scaled
        length = float(np.linalg.norm(normal))
        unit = np.array(normal) / length
        first = np.cross(unit, np.eye(3)[np.abs(unit).argmin()])
        first /= np.linalg.norm(first)
        second = np.cross(unit, first)
        sides = half_edge * np.array([first + second, second - first, -first - second, first - second])
        return np.asarray(sides + unit * (offset / length))


def check_stands_still(name: str, link: str | None, shapes: Sequence[Any], moves: bool = False) -> None:
    """Raises if a link carries a half-space among these shapes, or one moves by itself; no link means obstacles."""
    if not any(isinstance(shape, HalfSpace) for shape in shapes):
        return
    if moves:
        raise PlannercheckError(f"{name!r} has a half-space, which can't move, since it is unbounded: give a box")
    if link is not None:
        raise PlannercheckError(
            f"{name!r} has a half-space, which no link can carry (here: {link!r}), since it is unbounded: give a box"
        )
