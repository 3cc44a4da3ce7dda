"""Compares a checker with FCL, pair by pair, with exact arithmetic as the judge.

In: a checker and configurations (n, nq). Out: an AgreementReport that counts pairs and lists every
disagreement with the verdict of exact arithmetic on the same hulls and poses.

FCL is an independent library, not the truth: it has a tolerance, and errs near contact and on small or flat bodies.
Pairs whose world boxes are apart count as free without a query to FCL. Bodies for which FCL has no reliable form (flat
ones, inflated polygons and polytopes) are compared with exact arithmetic.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from plannercheck.bodies import exact_reference as exact
from plannercheck.bodies.fcl_bodies import FclBodies
from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.arrays import OwnsArrays
from plannercheck.common.counters import sum_fields
from plannercheck.common.errors import PlannercheckError

if TYPE_CHECKING:
    from plannercheck.bodies.polytope import Polytope
    from plannercheck.motions.checker import Checker


# Configurations whose poses and boxes are held in memory at once.
_BLOCK = 256


@dataclass(frozen=True, eq=False)
class Disagreement(OwnsArrays):
    """A pair of bodies on which the checker and FCL differ.

    Attributes:
        row: The configuration's row in the given array.
        bodies: Names of the two bodies.
        ours: The checker's verdict, True for a collision.
        fcl: FCL's verdict; False also where the world boxes are apart and FCL was not asked, that of exact arithmetic
            where FCL can't take a body.
        exact: The verdict of exact arithmetic.
        distance: How far the bodies are apart, m; 0 if they collide.
        indices: The two bodies' places in the checker's bodies.
        poses: Their poses, (4, 4) each, m.
    """

    row: int
    bodies: tuple[str, str]
    ours: bool
    fcl: bool
    exact: bool
    distance: float
    indices: tuple[int, int]
    poses: tuple[Floats, Floats]

    @property
    def against_us(self) -> bool:
        """Whether exact arithmetic sides with FCL."""
        return self.ours != self.exact


@dataclass(frozen=True)
class AgreementReport:
    """What a comparison with FCL found.

    Attributes:
        states: Number of configurations compared.
        pairs: Verdicts compared: configurations times the checker's pairs.
        fcl_calls: Pairs that FCL decided.
        exact_calls: Pairs that exact arithmetic decided instead; the world boxes of the others are apart.
        collisions: Pairs that collide by the checker's verdict.
        disagreements: Every pair on which the two differ, with the exact verdict.
        contradictions: Rows where `check_states` differs from the or of the checker's own pair verdicts.
    """

    states: int
    pairs: int
    fcl_calls: int
    exact_calls: int
    collisions: int
    disagreements: tuple[Disagreement, ...]
    contradictions: tuple[int, ...]

    @property
    def agreements(self) -> int:
        """Pairs on which the two agree."""
        return self.pairs - len(self.disagreements)

    @property
    def against_us(self) -> tuple[Disagreement, ...]:
        """Disagreements that exact arithmetic decides for FCL: there should be none."""
        return tuple(found for found in self.disagreements if found.against_us)

    @property
    def errors_of_fcl(self) -> tuple[Disagreement, ...]:
        """Disagreements that exact arithmetic decides for the checker."""
        return tuple(found for found in self.disagreements if not found.against_us)

    @property
    def passed(self) -> bool:
        """Whether no disagreement goes against the checker and it never contradicts itself."""
        return not self.against_us and not self.contradictions


def compare_with_fcl(checker: Checker, q: Floats, progress: Callable[[int], object] | None = None) -> AgreementReport:
    """Compares every pair verdict of a checker with FCL's.

    Args:
        checker: The checker.
        q: Configurations, (n, nq).
        progress: Called with the number of configurations done since the last call.

    Returns:
        The report; `report.passed` says whether the checker held.

    Raises:
        PlannercheckError: If python-fcl is not installed, or a body is a solid, a set of parts or a half-space.
    """
    solids = [
        body.name for body, prepared in zip(checker.bodies, checker.polytopes, strict=True) if _is_solid(prepared)
    ]
    if solids:
        raise PlannercheckError(
            f"FCL is compared with hulls, and {', '.join(map(repr, solids[:3]))} "
            f"{'is' if len(solids) == 1 else 'are'} something else: "
            "load with geometry='hull', without clouds, grids or half-spaces"
        )
    comparison = _Comparison(checker)
    reports = []
    for start in range(0, len(q), _BLOCK):
        reports.append(comparison.block(q[start : start + _BLOCK], start))
        if progress is not None:
            progress(reports[-1].states)
    return merged(reports)


def merged(reports: list[AgreementReport]) -> AgreementReport:
    """One report for several sets of configurations; rows stay as they are."""
    return AgreementReport(
        **sum_fields(reports, "states", "pairs", "fcl_calls", "exact_calls", "collisions"),
        disagreements=tuple(found for report in reports for found in report.disagreements),
        contradictions=tuple(row for report in reports for row in report.contradictions),
    )


class _Comparison:
    """A checker with its bodies as FCL objects."""

    def __init__(self, checker: Checker) -> None:
        self._checker = checker
        self._fcl = FclBodies(
            [None if polytope is None else (polytope.vertices, polytope.faces) for polytope in checker.polytopes],
            [0.0 if polytope is None else polytope.inflation_radius for polytope in checker.polytopes],
        )
        self._names = [body.name for body in checker.bodies]

    def block(self, q: Floats, first_row: int) -> AgreementReport:
        """Compares the verdicts on configurations (n, nq) that start at a row of a larger set."""
        poses, ours = self._checker.body_poses(q), self._checker.colliding_pairs(q)
        valid = self._checker.check_states(q)
        near = self._fcl.boxes_meet(poses, self._checker.pairs)
        known: Bools = np.all(self._fcl.known[self._checker.pairs], axis=1)
        theirs = self._verdicts_of_others(poses, near, known)
        return AgreementReport(
            states=len(q),
            pairs=ours.size,
            fcl_calls=int(near[:, known].sum()),
            exact_calls=int(near[:, ~known].sum()),
            collisions=int(ours.sum()),
            disagreements=tuple(
                self._judged(row, pair, poses[row], bool(ours[row, pair]), first_row)
                for row, pair in np.argwhere(theirs != ours).tolist()
            ),
            contradictions=tuple((first_row + np.flatnonzero(valid == ours.any(axis=1))).tolist()),
        )

    def _verdicts_of_others(self, poses: Floats, near: Bools, known: Bools) -> Bools:
        """Verdicts (n, pairs): FCL's on near pairs that it knows, those of exact arithmetic on other near pairs."""
        verdicts = np.zeros_like(near)
        for row in range(len(near)):
            pairs = np.flatnonzero(near[row] & known)
            verdicts[row, pairs] = self._fcl.collide_all(poses[row], self._checker.pairs[pairs])
            for pair in np.flatnonzero(near[row] & ~known).tolist():
                verdicts[row, pair] = exact.intersects(*self._posed(pair, poses[row]))
        return verdicts

    def _posed(self, pair: int, poses: Floats) -> tuple[Floats, Floats, Floats, Floats, float, float]:
        """Vertices, poses and inflation radii of a pair, as exact arithmetic takes them."""
        p, r = self._checker.pairs[pair].tolist()
        vertices, inflation_radii = self._fcl.vertices, self._fcl.inflation_radii
        return vertices[p], vertices[r], poses[p], poses[r], inflation_radii[p], inflation_radii[r]

    def _judged(self, row: int, pair: int, poses: Floats, ours: bool, first_row: int) -> Disagreement:
        p, r = self._checker.pairs[pair].tolist()
        bodies = self._posed(pair, poses)
        certificate = exact.decide(*bodies)
        if not exact.holds(certificate, *bodies):
            raise AssertionError(f"the exact verdict on {self._names[p]} and {self._names[r]} does not hold")
        return Disagreement(
            row=first_row + row,
            bodies=(self._names[p], self._names[r]),
            ours=ours,
            fcl=not ours,
            exact=isinstance(certificate, exact.ExactSharedPoint),
            distance=exact.distance(*bodies),
            indices=(p, r),
            poses=(poses[p], poses[r]),
        )


def _is_solid(polytope: Polytope | None) -> bool:
    if polytope is None:
        return False
    return any(kind is not None for kind in (polytope.solid, polytope.parts, polytope.half_space))
