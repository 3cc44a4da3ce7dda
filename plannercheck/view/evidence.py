"""Proofs of a frame's verdicts, to be drawn: common points of colliding pairs, planes between the nearest other pairs.

In: a checker, poses of all bodies at a configuration, which pairs collide. Out: `Witness`es and `Plane`s. Pairs are
measured in the order of the distances of balls around their bodies, until no other pair can be nearer.
"""

from __future__ import annotations

import bisect

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.certificates import Separation, SharedPoint, separation
from plannercheck.bodies.distance import Distance, distance
from plannercheck.bodies.exact_planes import direction_of
from plannercheck.bodies.half_space_certificates import certified_body
from plannercheck.bodies.intersection import certify_posed
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.solid_certificates import Enclosure
from plannercheck.common.array_types import Bools, Floats
from plannercheck.motions.checker import Checker
from plannercheck.view.model import Plane, Witness

# Planes are drawn as large as the smaller of their two bodies, within these bounds, m.
_SMALLEST_PLANE, _LARGEST_PLANE = 0.06, 0.4


class Evidence:
    """Finds what to draw at the frames of a picture."""

    def __init__(self, checker: Checker) -> None:
        """Puts a ball around each body."""
        self._checker = checker
        balls = [_ball(body) for body in checker.polytopes]
        self._centres = np.array([centre for centre, _ in balls]).reshape(-1, 3)
        self._radii = np.array([radius for _, radius in balls])

    def witnesses(self, frame: int, poses: Floats, colliding: Bools) -> list[Witness]:
        """A common point for each colliding pair (pairs,), with bodies at poses (bodies, 4, 4) in the world, m."""
        found = ((int(k), certify_posed(*self._posed(int(k), poses))) for k in np.flatnonzero(colliding))
        return [
            Witness(frame, self._checker.pair_names(k), certificate.point)
            for k, certificate in found
            if isinstance(certificate, SharedPoint | Enclosure)
        ]

    def planes(self, frame: int, poses: Floats, colliding: Bools, count: int) -> list[Plane]:
        """At most `count` separating planes of the nearest pairs that do not collide; arguments as for `witnesses`.

        Of solids, where a plane separates their hulls.
        """
        found = (self._plane(frame, k, poses) for k in self._nearest(count, poses, np.flatnonzero(~colliding)))
        return [plane for plane in found if plane is not None]

    def _nearest(self, count: int, poses: Floats, rows: NDArray[np.int64]) -> list[int]:
        """The nearest of some rows of pairs, nearest first."""
        bounds = self._lower_bounds(poses, rows)
        best: list[tuple[float, int]] = []
        for place in np.argsort(bounds).tolist():
            if count == 0 or (len(best) >= count and bounds[place] > best[count - 1][0]):
                break
            k = int(rows[place])
            bisect.insort(best, (distance(*self._posed(k, poses)).distance, k))
        return [k for _, k in best[:count]]

    def _lower_bounds(self, poses: Floats, rows: NDArray[np.int64]) -> Floats:
        """(rows,) distances of the balls, less than those of the bodies, m."""
        centres = np.einsum("bij,bj->bi", poses[:, :3, :3], self._centres) + poses[:, :3, 3]
        first, second = self._checker.pairs[rows].T
        apart = np.linalg.norm(centres[first] - centres[second], axis=1)
        return np.asarray(apart - self._radii[first] - self._radii[second])

    def _plane(self, frame: int, k: int, poses: Floats) -> Plane | None:
        near = distance(*self._posed(k, poses))
        certificate = self._separation(k, poses, near)
        if certificate is None:
            return None
        normal, middle = certificate.normal, (near.point_p + near.point_r) / 2
        size = 2 * min(float(self._radii[body]) for body in self._checker.pairs[k].tolist())
        return Plane(
            frame=frame,
            pair=self._checker.pair_names(k),
            gap=certificate.gap,
            centre=middle - (normal @ middle - certificate.offset) * normal,
            normal=normal,
            size=min(max(size, _SMALLEST_PLANE), _LARGEST_PLANE),
            nearest=np.stack([near.point_p, near.point_r]),
        )

    def _separation(self, k: int, poses: Floats, near: Distance) -> Separation | None:
        """The plane across the nearest points, which has the largest gap; else the verdict's plane."""
        first, second, pose_p, pose_r = self._posed(k, poses)
        bodies = certified_body(first, pose_p), certified_body(second, pose_r)
        way = near.point_p - near.point_r
        widest = separation(direction_of(way), bodies) if way.any() else None
        certificate = certify_posed(first, second, pose_p, pose_r) if widest is None else widest
        return certificate if isinstance(certificate, Separation) else None

    def _posed(self, k: int, poses: Floats) -> tuple[Polytope, Polytope, Floats, Floats]:
        """Both bodies of a pair, and their poses."""
        a, b = self._checker.pairs[k].tolist()
        first, second = self._checker.polytopes[a], self._checker.polytopes[b]
        assert first is not None
        assert second is not None  # both are in a pair
        return first, second, poses[a], poses[b]


def _ball(body: Polytope | None) -> tuple[Floats, float]:
    """Centre (3,) and radius of a ball around a body, m; of a body in no pair, nothing."""
    if body is None:
        return np.zeros(3), 0.0
    centre = (body.vertices.min(axis=0) + body.vertices.max(axis=0)) / 2
    return centre, float(np.linalg.norm(body.vertices - centre, axis=1).max()) + body.inflation_radius
