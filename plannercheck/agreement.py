"""A checker held against FCL, pair by pair, with exact arithmetic as the judge.

In: a checker and configurations (n, nq). Out: an AgreementReport that counts pairs and lists every
disagreement with the verdict of exact arithmetic on the same hulls and poses.

FCL is an independent peer, not the truth: it works to a tolerance and errs near contact and on small or flat
bodies. So nothing is concluded from FCL alone. Pairs whose world boxes are apart are free without asking FCL.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from plannercheck import exact
from plannercheck.fcl_bodies import FclBodies

if TYPE_CHECKING:
    from plannercheck.checker import Checker
    from plannercheck.hull import Polytope

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

# Configurations whose poses and boxes are held in memory at once.
_BLOCK = 256


@dataclass(frozen=True, eq=False)
class Disagreement:
    """A pair of bodies on which the checker and FCL differ.

    Attributes:
        row: The configuration's row in the given array.
        bodies: Names of the two bodies.
        ours: The checker's verdict, True for a collision.
        fcl: FCL's verdict; False also where the world boxes are apart and FCL was not asked.
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
    poses: tuple[Array, Array]

    @property
    def against_us(self) -> bool:
        """Whether exact arithmetic sides with FCL."""
        return self.ours != self.exact


@dataclass(frozen=True)
class AgreementReport:
    """What a comparison with FCL found.

    Attributes:
        states: Configurations compared.
        pairs: Verdicts compared: configurations times the checker's pairs.
        fcl_calls: Pairs that FCL decided; the world boxes of the others are apart.
        collisions: Pairs that collide by the checker's verdict.
        disagreements: Every pair on which the two differ, with the exact verdict.
        contradictions: Rows where `check_states` differs from the or of the checker's own pair verdicts.
    """

    states: int
    pairs: int
    fcl_calls: int
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


def compare_with_fcl(checker: Checker, q: Array, progress: Callable[[int], object] | None = None) -> AgreementReport:
    """Compares every pair verdict of a checker with FCL's.

    Args:
        checker: The checker.
        q: Configurations, (n, nq).
        progress: Called with the number of configurations done since the last call.

    Returns:
        The report; `report.passed` says whether the checker held.

    Raises:
        PlannercheckError: If python-fcl is not installed.
    """
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
        states=sum(report.states for report in reports),
        pairs=sum(report.pairs for report in reports),
        fcl_calls=sum(report.fcl_calls for report in reports),
        collisions=sum(report.collisions for report in reports),
        disagreements=tuple(found for report in reports for found in report.disagreements),
        contradictions=tuple(row for report in reports for row in report.contradictions),
    )


class _Comparison:
    """A checker with its bodies as FCL objects."""

    def __init__(self, checker: Checker) -> None:
        self._checker = checker
        self._fcl = FclBodies([_vertices_and_faces(polytope) for polytope in checker.polytopes])
        self._names = [body.name for body in checker.bodies]

    def block(self, q: Array, first_row: int) -> AgreementReport:
        """Compares the verdicts on configurations (n, nq) that start at a row of a larger set."""
        poses, ours = self._checker.body_poses(q), self._checker.colliding_pairs(q)
        valid = self._checker.check_states(q)
        theirs, asked = self._verdicts_of_fcl(poses)
        return AgreementReport(
            states=len(q),
            pairs=ours.size,
            fcl_calls=int(asked.sum()),
            collisions=int(ours.sum()),
            disagreements=tuple(
                self._judged(row, pair, poses[row], bool(ours[row, pair]), first_row)
                for row, pair in np.argwhere(theirs != ours).tolist()
            ),
            contradictions=tuple((first_row + np.flatnonzero(valid == ours.any(axis=1))).tolist()),
        )

    def _verdicts_of_fcl(self, poses: Array) -> tuple[Flags, Flags]:
        """FCL's verdicts (n, pairs), and which of them FCL was asked for."""
        asked = self._fcl.boxes_meet(poses, self._checker.pairs)
        verdicts = np.zeros_like(asked)
        for row, near in enumerate(asked):
            pairs = np.flatnonzero(near)
            verdicts[row, pairs] = self._fcl.collide_all(poses[row], self._checker.pairs[pairs])
        return verdicts, asked

    def _judged(self, row: int, pair: int, poses: Array, ours: bool, first_row: int) -> Disagreement:
        p, r = self._checker.pairs[pair].tolist()
        bodies = self._fcl.vertices[p], self._fcl.vertices[r], poses[p], poses[r]
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


def _vertices_and_faces(polytope: Polytope | None) -> tuple[Array, NDArray[np.int32]] | None:
    return None if polytope is None else (polytope.vertices, polytope.faces)
