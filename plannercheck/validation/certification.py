"""Certificates for the verdicts on a set of configurations, each proved in exact arithmetic without the core.

In: a checker, configurations (n, nq) and the first colliding pair of each. Out: a CertificationReport that counts the
proofs and lists unproved verdicts.

The idea: an invalid configuration needs one point that two bodies share, a valid one a separating plane for every
pair. Most pairs are so far apart that a plane at right angles to a world axis separates them; boxes in whole numbers
find these quickly. For the others the core gives a plane, which `Separation.verify` proves. All proofs are about the
points of the shapes, not about the vertices of the hulls that the core made, so these hulls are not trusted either.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.certificates import Certificate, Mixture, Separation, SharedPoint, UnprovedVerdictError
from plannercheck.bodies.exact_planes import CertifiedBody, PosedBody
from plannercheck.bodies.half_spaces import HalfSpace
from plannercheck.bodies.integers import IntegerHull, Integers
from plannercheck.bodies.intersection import certify_posed
from plannercheck.bodies.kinds import are_bounded, have_parts
from plannercheck.bodies.part_certificates import PartSeparation
from plannercheck.bodies.part_sets import PartSet
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.posed_half_spaces import PosedHalfSpace
from plannercheck.bodies.shapes import GeometryObject, inflated_hull
from plannercheck.bodies.solid_separations import SolidSeparation
from plannercheck.bodies.solids import Solid
from plannercheck.common.array_types import Floats
from plannercheck.common.counters import sum_fields
from plannercheck.common.errors import PlannercheckError
from plannercheck.motions.checker import Checker
from plannercheck.validation.part_proofs import (
    GivenParts,
    given_parts,
    proves_contact_of_parts,
    proves_separation_of_parts,
)
from plannercheck.validation.solid_proofs import GivenMesh, proves_contact, proves_separation

Box = tuple[Integers, Integers]

# Boxes are in whole numbers of 2^-60 m, rounded outward: far finer than any gap that matters.
_GRID = -60
# Configurations whose poses are held in memory at once.
_BLOCK = 256
_AXES: tuple[Integers, ...] = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
_OPPOSITES: tuple[Integers, ...] = ((-1, 0, 0), (0, -1, 0), (0, 0, -1))


@dataclass(frozen=True)
class Unproved:
    """A verdict without a proof, a fault of this library: its row, the names of both bodies, whether they collide."""

    row: int
    first: str
    second: str
    colliding: bool


@dataclass(frozen=True)
class CertificationReport:
    """The proofs of a set of verdicts, counted.

    Attributes:
        states: Configurations whose verdicts were checked.
        shared_points: Invalid configurations, each proved by a point that two bodies share.
        planes: Pairs of bodies in valid configurations proved apart by a plane of the core.
        boxes: Such pairs proved apart by exact boxes along the world's axes.
        unproved: Verdicts without a proof.
    """

    states: int
    shared_points: int
    planes: int
    boxes: int
    unproved: tuple[Unproved, ...]

    @property
    def passed(self) -> bool:
        """Whether every verdict is proved."""
        return not self.unproved


def certify_verdicts(checker: Checker, q: Floats, first_pair: NDArray[np.int32]) -> CertificationReport:
    """Proves the verdicts on a set of configurations.

    Args:
        checker: The checker that gave them.
        q: Configurations (n, nq), rad and m.
        first_pair: Row of `checker.pairs` that collides (n,), -1 for a valid configuration.

    Returns:
        The report; `report.passed` says whether all were proved.

    Raises:
        PlannercheckError: If the checker's bodies are not made of its shapes' points.
    """
    certification = _Certification(checker)
    reports = []
    for start in range(0, len(q), _BLOCK):
        poses = checker.body_poses(q[start : start + _BLOCK])
        for k, pair in enumerate(first_pair[start : start + _BLOCK].tolist()):
            row = start + k
            report = certification.valid(row, poses[k]) if pair < 0 else certification.invalid(row, poses[k], pair)
            reports.append(report)
    return merged(reports)


def merged(reports: list[CertificationReport]) -> CertificationReport:
    """One report for several sets; rows stay as they are."""
    counts = sum_fields(reports, "states", "shared_points", "planes", "boxes")
    return CertificationReport(**counts, unproved=tuple(found for report in reports for found in report.unproved))


class _Certification:
    """A checker, the points that its bodies were made of, and their boxes at the poses seen last."""

    def __init__(self, checker: Checker) -> None:
        self._checker = checker
        bodies = list(zip(checker.bodies, checker.polytopes, checker.paddings.tolist(), strict=True))
        shapes = enumerate(body.shape for body in checker.bodies)
        self._empty = {k for k, shape in shapes if isinstance(shape, PartSet) and shape.count == 0}
        self._parts = {
            k: given_parts(body.shape, padding)
            for k, (body, polytope, padding) in enumerate(bodies)
            if polytope is not None and isinstance(body.shape, PartSet) and k not in self._empty
        }
        self._given = [
            None if polytope is None or k in self._empty else self._given_body(k, polytope, padding)
            for k, (_, polytope, padding) in enumerate(bodies)
        ]
        self._boxes: dict[int, tuple[bytes, Box]] = {}
        self._meshes: dict[int, GivenMesh] = {}

    def invalid(self, row: int, poses: Floats, pair: int) -> CertificationReport:
        """The proof that one pair of bodies shares a point at poses (bodies, 4, 4)."""
        proved = self._is_proved(pair, poses, colliding=True)
        return CertificationReport(1, int(proved), 0, 0, () if proved else (self._unproved(row, pair, True),))

    def valid(self, row: int, poses: Floats) -> CertificationReport:
        """The proofs that no pair of bodies shares a point at poses (bodies, 4, 4)."""
        pairs = range(len(self._checker.pairs))
        near = [pair for pair in pairs if not self._are_apart_by_boxes(pair, poses)]
        unproved = [pair for pair in near if not self._is_proved(pair, poses, colliding=False)]
        return CertificationReport(
            states=1,
            shared_points=0,
            planes=len(near) - len(unproved),
            boxes=len(pairs) - len(near),
            unproved=tuple(self._unproved(row, pair, False) for pair in unproved),
        )

    def _is_proved(self, pair: int, poses: Floats, colliding: bool) -> bool:
        p, r = self._checker.pairs[pair].tolist()
        both = self._polytope(p), self._polytope(r)
        try:
            certificate = certify_posed(*both, poses[p], poses[r])
        except UnprovedVerdictError:
            return False
        bounded = are_bounded(*both)
        if have_parts(*both) and not bounded:
            return colliding != isinstance(certificate, Separation | PartSeparation) and certificate.verify()
        if have_parts(*both) and not isinstance(certificate, Separation):
            parts = (self._parts_or_mesh(p), poses[p]), (self._parts_or_mesh(r), poses[r])
            if isinstance(certificate, PartSeparation):
                return not colliding and proves_separation_of_parts(certificate, *parts)
            assert not isinstance(certificate, SolidSeparation)
            return colliding and proves_contact_of_parts(certificate, *parts)
        is_of_solids = bounded and any(polytope.solid is not None for polytope in both)
        if is_of_solids and not isinstance(certificate, Separation):
            given = (self._mesh(p), poses[p]), (self._mesh(r), poses[r])
            if isinstance(certificate, SolidSeparation):
                return not colliding and proves_separation(certificate, *given)
            assert not isinstance(certificate, PartSeparation)
            return colliding and proves_contact(certificate, *given)
        assert isinstance(certificate, SharedPoint | Separation)  # of hulls
        return isinstance(certificate, SharedPoint) == colliding and self._about_given(certificate, p, r).verify()

    def _parts_or_mesh(self, body: int) -> GivenParts | GivenMesh:
        """The parts that a body was made of, or the points of one that is no set."""
        return self._parts.get(body) or self._mesh(body)

    def _mesh(self, body: int) -> GivenMesh:
        """The points and, of a solid, triangles that a body was made of."""
        if body not in self._meshes:
            shape, given = self._checker.bodies[body].shape, self._given_of(body)
            assert isinstance(given, PosedBody)
            is_solid = self._polytope(body).solid is not None
            triangles = shape.used[1] if isinstance(shape, Solid) and is_solid else None
            self._meshes[body] = GivenMesh(given.vertices, triangles, given.inflation_radius)
        return self._meshes[body]

    def _about_given(self, certificate: Certificate, p: int, r: int) -> Certificate:
        """The same certificate for the points that the bodies were made of, at the same poses."""
        bodies = tuple(
            replace(self._given_of(k), pose=body.pose) for k, body in zip((p, r), certificate.bodies, strict=True)
        )
        about = replace(certificate, bodies=(bodies[0], bodies[1]))
        if not isinstance(about, SharedPoint):
            return about
        first, second = self._polytope(p), self._polytope(r)
        return replace(about, first=_of_source(about.first, first), second=_of_source(about.second, second))

    def _are_apart_by_boxes(self, pair: int, poses: Floats) -> bool:
        p, r = self._checker.pairs[pair].tolist()
        if p in self._empty or r in self._empty:  # which share a point with nothing
            return True
        if not are_bounded(self._polytope(p), self._polytope(r)):
            return False
        (low_p, high_p), (low_r, high_r) = self._box(p, poses[p]), self._box(r, poses[r])
        return any(low_p[k] > high_r[k] or low_r[k] > high_p[k] for k in range(3))

    def _box(self, body: int, pose: Floats) -> Box:
        key = pose.tobytes()
        if body not in self._boxes or self._boxes[body][0] != key:
            given = self._given_of(body)
            assert isinstance(given, PosedBody)
            self._boxes[body] = key, exact_box(replace(given, pose=pose))
        return self._boxes[body][1]

    def _polytope(self, body: int) -> Polytope:
        polytope = self._checker.polytopes[body]
        assert polytope is not None  # every body of a pair is prepared
        return polytope

    def _given_body(self, body: int, polytope: Polytope, padding: float) -> CertifiedBody:
        """The points that a body was made of, not posed yet; of a set of parts, points whose hull holds them all."""
        if body in self._parts:
            points, inflation_radius = self._parts[body].hull
            return PosedBody(points, np.eye(4), inflation_radius)
        return _given_body(self._checker.bodies[body], polytope, self._checker.excess, padding)

    def _given_of(self, body: int) -> CertifiedBody:
        given = self._given[body]
        assert given is not None
        return given

    def _unproved(self, row: int, pair: int, colliding: bool) -> Unproved:
        first, second = (self._checker.bodies[k].name for k in self._checker.pairs[pair].tolist())
        return Unproved(row, first, second, colliding)


def _given_body(body: GeometryObject, polytope: Polytope, excess: float, padding: float) -> CertifiedBody:
    """The points that a body was made of, not posed yet; its inflation radius includes its padding."""
    if isinstance(body.shape, HalfSpace):
        return PosedHalfSpace(np.array(body.shape.normal), body.shape.offset, np.eye(4), padding)
    points, _, inflation_radius = inflated_hull(body.shape, excess)
    inflation_radius += padding
    source = polytope.source
    if (
        inflation_radius != polytope.inflation_radius
        or source.max() >= len(points)
        or not np.array_equal(points[source], polytope.vertices)
    ):
        raise PlannercheckError(f"body {body.name!r} is not made of the points of its shape with excess={excess:g}")
    return PosedBody(points, np.eye(4), inflation_radius)


def _of_source(mixture: Mixture, polytope: Polytope) -> Mixture:
    """A mixture of the points that a polytope was made of."""
    inside = (mixture.vertices >= 0) & (mixture.vertices < len(polytope.source))
    # What is no vertex stays none.
    return replace(mixture, vertices=np.where(inside, polytope.source[mixture.vertices * inside], -1))


def exact_box(body: PosedBody) -> Box:
    """The box along the world's axes around a posed body, inflation radius included.

    Its lowest and highest corner are in whole numbers of 2^-60 m, rounded outward.
    """
    hull = IntegerHull(body.vertices, body.pose, body.inflation_radius)
    lows = [hull.point(hull.lowest(axis))[k] - hull.inflation_radius for k, axis in enumerate(_AXES)]
    highs = [hull.point(hull.lowest(axis))[k] + hull.inflation_radius for k, axis in enumerate(_OPPOSITES)]
    low_x, low_y, low_z = (_on_grid(low, hull.unit) for low in lows)
    high_x, high_y, high_z = (-_on_grid(-high, hull.unit) for high in highs)
    return (low_x, low_y, low_z), (high_x, high_y, high_z)


def _on_grid(number: int, unit: int) -> int:
    """A number in units of 2^unit m on the grid, rounded down."""
    shift = _GRID - unit
    return number >> shift if shift >= 0 else number << -shift
