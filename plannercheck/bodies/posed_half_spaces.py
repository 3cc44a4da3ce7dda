"""Posed half-spaces in exact arithmetic, for certificates.

In: normal, offset and a pose, as the exact numbers that their doubles are. Out: the half-space in the world, how far
it reaches along a direction, and whether it holds a point. With g = normal · adj(M), which is normal · M⁻¹ det M, the
image of {x : normal · x <= offset} under y = M x + t is {y : g · (y − t) <= offset det M}, as det M > 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from plannercheck.bodies.integers import cross, dot
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import OwnsArrays

Vector = tuple[Fraction, Fraction, Fraction]


@dataclass(frozen=True, eq=False)
class PosedHalfSpace(OwnsArrays):
    """A half-space that a certificate is about.

    Attributes:
        normal: (3,) in the shape's frame, out of it, of any length.
        offset: The points with normal · x <= offset.
        pose: (4, 4) in the world, m.
        inflation_radius: How far around it belongs to the body, m.
    """

    normal: Floats
    offset: float
    pose: Floats
    inflation_radius: float = 0.0

    def plane(self) -> tuple[Vector, Fraction]:
        """The normal g and the offset c of {y : g · y <= c} in the world."""
        a, b, c = (_vector(row) for row in self.pose[:3, :3].tolist())
        normal, shift = _vector(self.normal.tolist()), _vector(self.pose[:3, 3].tolist())
        # Rows of the matrix of cofactors, whose transpose is adj(M).
        cofactors = cross(b, c), cross(c, a), cross(a, b)
        x, y, z = (dot(row, normal) for row in cofactors)
        return (x, y, z), Fraction(self.offset) * dot(a, cofactors[0]) + dot((x, y, z), shift)

    def lowest(self, direction: Vector) -> Fraction | None:
        """The least product of a direction with its points, the radius left out; None if there is none."""
        normal, offset = self.plane()
        along = dot(direction, normal)
        if any(cross(direction, normal)) or along >= 0:
            return None
        return offset * along / dot(normal, normal)

    def height(self, point: Vector) -> Fraction:
        """How far a point is over the plane, m times the length of `plane`'s normal."""
        normal, offset = self.plane()
        return dot(normal, point) - offset

    def holds(self, point: Vector) -> bool:
        """Whether a point is within the radius of the half-space."""
        normal, height = self.plane()[0], self.height(point)
        return height <= 0 or height**2 <= Fraction(self.inflation_radius) ** 2 * dot(normal, normal)


def _vector(row: list[float]) -> Vector:
    x, y, z = (Fraction(number) for number in row)
    return x, y, z
