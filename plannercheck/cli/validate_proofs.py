"""Verifies verdicts of `plannercheck validate`: by FCL, and by proofs in exact arithmetic.

In: a checker, chunks and their findings. Out: reports of the whole set, with rows counted as in their files.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from plannercheck.checking.protocols import AnyChecker
from plannercheck.common.errors import PlannercheckError
from plannercheck.motions.checker import Checker
from plannercheck.planar.checker import Checker as PlanarChecker
from plannercheck.validation.certification import CertificationReport, certify_verdicts
from plannercheck.validation.certification import merged as merged_certification
from plannercheck.validation.fcl_agreement import AgreementReport, compare_with_fcl
from plannercheck.validation.fcl_agreement import merged as merged_agreement
from plannercheck.validation.formats.chunks import Chunk
from plannercheck.validation.judging import Findings
from plannercheck.validation.planar_certification import certify_verdicts as certify_planar

# Verdicts without a proof that an error lists.
_SHOWN_UNPROVED = 5


class Verification:
    """What is verified, and what came out of it so far."""

    def __init__(self, checker: AnyChecker, with_fcl: bool, with_proofs: bool) -> None:
        if with_fcl and not isinstance(checker, Checker):
            raise PlannercheckError("--reference fcl is for robots in space: FCL knows no polygons")
        self._checker = checker
        self._agreements: list[AgreementReport] | None = [] if with_fcl else None
        self._certifications: list[CertificationReport] | None = [] if with_proofs else None

    def __call__(self, chunk: Chunk, findings: Findings) -> None:
        """Verifies a chunk."""
        if self._agreements is not None:
            self._agreements.append(_agreement(self._checker, chunk))
        if self._certifications is not None:
            first_pair = np.asarray(findings.arrays["first_pair"], dtype=np.int32)
            self._certifications.append(_certification(self._checker, chunk, first_pair))

    @property
    def agreement(self) -> AgreementReport | None:
        """With FCL; None if that was not asked for."""
        return None if self._agreements is None else merged_agreement(self._agreements)

    @property
    def certification(self) -> CertificationReport | None:
        """By proofs; None if that was not asked for."""
        return None if self._certifications is None else merged_certification(self._certifications)


def _agreement(checker: AnyChecker, chunk: Chunk) -> AgreementReport:
    """The comparison of a chunk, with rows as in its file."""
    assert isinstance(checker, Checker)
    report = compare_with_fcl(checker, chunk.rows)
    return replace(
        report,
        disagreements=tuple(replace(d, row=d.row + chunk.first_row) for d in report.disagreements),
        contradictions=tuple(row + chunk.first_row for row in report.contradictions),
    )


def _certification(checker: AnyChecker, chunk: Chunk, first_pair: NDArray[np.int32]) -> CertificationReport:
    """The proofs of a chunk's verdicts, with rows as in its file."""
    if isinstance(checker, PlanarChecker):
        report = certify_planar(checker, chunk.rows, first_pair)
    else:
        assert isinstance(checker, Checker)
        report = certify_verdicts(checker, chunk.rows, first_pair)
    return replace(report, unproved=tuple(replace(u, row=u.row + chunk.first_row) for u in report.unproved))


def check_proofs(certification: CertificationReport | None) -> None:
    """Raises if a verdict is not proved: that is a fault of this library."""
    if certification is None or certification.passed:
        return
    shown = [f"row {u.row}: {u.first} and {u.second}" for u in certification.unproved[:_SHOWN_UNPROVED]]
    raise PlannercheckError(
        f"{len(certification.unproved)} verdicts are not proved, which is a fault of plannercheck and worth a report: "
        + "; ".join(shown)
    )
