"""The questions about each configuration of a set, and the findings.

In: a checker, rows of a chunk. Out: `Findings`: arrays with one entry for each row, and their summary. A `Judge` and
its findings can be sent between machines.

Certificates are about one pair a configuration: a point that the first colliding pair shares, or, if the configuration
is valid, a plane between the two bodies that are nearest to each other.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.certificates import Separation, SharedPoint
from plannercheck.bodies.intersection import certify_posed
from plannercheck.bodies.part_certificates import PartSeparation
from plannercheck.bodies.solid_certificates import Enclosure
from plannercheck.bodies.solid_separations import SolidSeparation
from plannercheck.checking.protocols import AnyChecker
from plannercheck.checking.verdicts import PairCertificate, ValidityReport
from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.motions.checker import Checker
from plannercheck.planar.certificates import Separation as PlanarSeparation
from plannercheck.planar.certificates import SharedPoint as PlanarSharedPoint
from plannercheck.planar.checker import Checker as PlanarChecker
from plannercheck.validation.validate import validate

Arrays: TypeAlias = dict[str, NDArray[Any]]

Explained = Literal["none", "invalid", "all"]
Limits = Literal["error", "warn", "ignore"]

# Configurations whose poses are held at once, some kilobytes each.
_POSED_ROWS = 512


@dataclass(frozen=True)
class Findings:
    """The findings about a chunk.

    Attributes:
        arrays: Arrays by name, one entry for each row; all except the first two only if they are asked for:
            `first_pair`, int32 row of the checker's pairs, -1 if valid; `beyond_limits`; `explained_pair`, int32 row of
            the pair that the rest is about, -1 if none; `point` that both bodies share, m; `normal` and `offset` of the
            plane between them, `gap` between them at least, m; NaN where there is none.
        report: The summary.
    """

    arrays: Arrays
    report: ValidityReport


@dataclass(frozen=True)
class Judge:
    """The questions about each configuration.

    Attributes:
        all_pairs: Whether all colliding pairs are counted, not just the first of each configuration.
        limits: Whether configurations beyond the limits fail ("error"), are counted, or are not looked for.
        explain: Says which configurations get a certificate.
        threads: Number of threads that a judge uses.
        times: The scene's clock, where something in it moves: one number, or one for each row of the set, s.
    """

    all_pairs: bool = False
    limits: Limits = "error"
    explain: Explained = "none"
    threads: int = 1
    times: tuple[float, ...] = ()

    def __call__(self, checker: AnyChecker, rows: Floats, first_row: int = 0) -> Findings:
        """Judges configurations (n, nq), rad and m, from a row of the set on."""
        if self.times:
            assert isinstance(checker, Checker)
            checker, rows = checker.in_time(rows, self._times(first_row, len(rows)))
        found = validate(checker, rows, self.threads, self.all_pairs)
        arrays: Arrays = {"first_pair": found.first_pair}
        report = found.report
        if self.limits == "ignore":
            report = replace(report, beyond_limits=0)
        else:
            arrays["beyond_limits"] = found.beyond_limits
        if self.explain != "none":
            arrays |= _certificates(checker, rows, found.first_pair, self.explain == "all")
        return Findings(arrays, report)

    def _times(self, first_row: int, count: int) -> tuple[float, ...]:
        if len(self.times) == 1:
            return self.times * count
        if len(self.times) < first_row + count:
            raise PlannercheckError(f"row {len(self.times)} has no time: --times has {len(self.times)} numbers")
        return self.times[first_row : first_row + count]

    def fails(self, arrays: Arrays) -> NDArray[np.bool_]:
        """(n,) which rows do not pass: those that collide, and those beyond the limits if that is an error."""
        failed = arrays["first_pair"] >= 0
        return np.asarray(failed | arrays["beyond_limits"] if self.limits == "error" else failed)

    def passes(self, report: ValidityReport) -> bool:
        """Whether no row of a set fails."""
        return report.invalid == 0 and (report.beyond_limits == 0 or self.limits != "error")


def _certificates(checker: AnyChecker, rows: Floats, first_pair: NDArray[np.int32], valid_too: bool) -> Arrays:
    explained = first_pair.copy()
    free = np.flatnonzero(first_pair < 0)
    if valid_too and isinstance(checker, Checker):  # in the plane nothing tells which pair is nearest
        for first in range(0, len(free), _POSED_ROWS):
            part = free[first : first + _POSED_ROWS]
            explained[part] = checker.nearest_pair(rows[part])
    dimension = 2 if isinstance(checker, PlanarChecker) else 3
    point, normal = np.full((2, len(rows), dimension), np.nan)
    offset, gap = np.full((2, len(rows)), np.nan)
    chosen = np.flatnonzero(explained >= 0)
    for first in range(0, len(chosen), _POSED_ROWS):
        part = chosen[first : first + _POSED_ROWS]
        for row, certificate in zip(part.tolist(), _certified(checker, rows[part], explained[part]), strict=True):
            if isinstance(certificate, SharedPoint | PlanarSharedPoint | Enclosure):
                point[row] = certificate.point
            elif isinstance(certificate, Separation | PlanarSeparation):
                normal[row], offset[row], gap[row] = certificate.normal, certificate.offset, certificate.gap
            elif isinstance(certificate, SolidSeparation | PartSeparation):  # by more than one plane
                gap[row] = certificate.gap
    return {"explained_pair": explained, "point": point, "normal": normal, "offset": offset, "gap": gap}


def _certified(checker: AnyChecker, rows: Floats, pairs: NDArray[np.int32]) -> list[PairCertificate]:
    """The certificate of one pair for each row."""
    if isinstance(checker, PlanarChecker):
        poses = checker.body_poses(rows)
        colliding = checker.colliding_pairs(rows)
        return [
            checker.pair_verdict(pair, poses[k], bool(colliding[k, pair])).certificate
            for k, pair in enumerate(pairs.tolist())
        ]
    assert isinstance(checker, Checker)
    poses, polytopes = checker.body_poses(rows), checker.polytopes
    found: list[PairCertificate] = []
    for k, pair in enumerate(pairs.tolist()):
        a, b = checker.pairs[pair].tolist()
        first, second = polytopes[a], polytopes[b]
        assert first is not None  # every body of a pair is prepared
        assert second is not None
        found.append(certify_posed(first, second, poses[k, a], poses[k, b]))
    return found
