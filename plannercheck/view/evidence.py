"""What proves a frame's verdicts, to be drawn: common points of colliding pairs, planes between the nearest others.

In: a checker, poses of all bodies at a configuration, which pairs collide. Out: `Witness`es and `Plane`s.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from plannercheck.certificates import PosedBody, Separation, SharedPoint, direction_of, separation
from plannercheck.checker import Checker
from plannercheck.distances import Distance, distance
from plannercheck.hull import Polytope
from plannercheck.pair import certify
from plannercheck.view.model import Plane, Witness

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

# Planes are drawn as large as the smaller of their two bodies, within these bounds, m.
_SMALLEST_PLANE, _LARGEST_PLANE = 0.06, 0.4


class Evidence:
    """Finds what to draw at one frame.

    Attributes:
        checker: The checker.
        frame: Index of the frame.
        poses: (bodies, 4, 4) in the world, m.
        colliding: (pairs,) which pairs collide.
    """

    def __init__(self, checker: Checker, frame: int, poses: Floats, colliding: Bools) -> None:
        self.checker = checker
        self.frame = frame
        self.poses = poses
        self.colliding = colliding

    def witnesses(self) -> list[Witness]:
        """A common point for each colliding pair."""
        found = ((int(k), self._certificate(int(k))) for k in np.flatnonzero(self.colliding))
        return [
            Witness(self.frame, self.checker.pair_names(k), certificate.point)
            for k, certificate in found
            if isinstance(certificate, SharedPoint)
        ]

    def planes(self, count: int, q: Floats) -> list[Plane]:
        """Separating planes of the nearest pairs that do not collide.

        Args:
            count: How many at most.
            q: (nq,) the configuration.
        """
        found = (self._plane(k, self._distance(k)) for k in self._nearest(count, q))
        return [plane for plane in found if plane is not None]

    def _nearest(self, count: int, q: Floats) -> list[int]:
        """Rows of pairs; of one alone, the compiled search knows."""
        apart = np.flatnonzero(~self.colliding).tolist()
        if count == 1 and len(apart) == len(self.colliding):
            return [k for k in self.checker.nearest_pair(q[None]).tolist() if k >= 0]
        return sorted(apart, key=lambda k: self._distance(k).distance)[:count] if count > 0 else []

    def _plane(self, k: int, near: Distance) -> Plane | None:
        certificate = self._separation(k, near)
        if certificate is None:
            return None
        normal = certificate.normal
        middle = (near.point_p + near.point_r) / 2
        return Plane(
            frame=self.frame,
            pair=self.checker.pair_names(k),
            gap=certificate.gap,
            centre=middle - (normal @ middle - certificate.offset) * normal,
            normal=normal,
            size=float(np.clip(min(_extent(body) for body in self._bodies(k)), _SMALLEST_PLANE, _LARGEST_PLANE)),
            nearest=np.stack([near.point_p, near.point_r]),
        )

    def _separation(self, k: int, near: Distance) -> Separation | None:
        """Of the nearest points' direction, which keeps the most room; else the one that the verdict comes with."""
        first, second, *poses = self._posed(k)
        bodies = PosedBody(first.vertices, poses[0], first.swell), PosedBody(second.vertices, poses[1], second.swell)
        way = near.point_p - near.point_r
        widest = separation(direction_of(way), bodies) if way.any() else None
        certificate = self._certificate(k) if widest is None else widest
        return certificate if isinstance(certificate, Separation) else None

    def _bodies(self, k: int) -> tuple[Polytope, Polytope]:
        first, second = (self.checker.polytopes[body] for body in self.checker.pairs[k].tolist())
        assert first is not None
        assert second is not None  # both are in a pair
        return first, second

    def _posed(self, k: int) -> tuple[Polytope, Polytope, Floats, Floats]:
        first, second = self.checker.pairs[k].tolist()
        return *self._bodies(k), self.poses[first], self.poses[second]

    def _certificate(self, k: int) -> Separation | SharedPoint:
        return certify(*self._posed(k))

    def _distance(self, k: int) -> Distance:
        return distance(*self._posed(k))


def _extent(body: Polytope) -> float:
    """The largest edge of the box around a body, m."""
    return float(np.ptp(body.vertices, axis=0).max()) + 2 * body.swell
