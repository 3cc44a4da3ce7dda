"""The summary of `plannercheck validate`: a table for people, JSON for programs.

In: an `Outcome`. Out: text, or a mapping.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from plannercheck.bodies.solids import Solid, open_meshes
from plannercheck.checking.protocols import AnyChecker
from plannercheck.checking.verdicts import ValidityReport
from plannercheck.cli.common import percentage, table
from plannercheck.motions.checker import Checker
from plannercheck.validation.certification import CertificationReport
from plannercheck.validation.fcl_agreement import AgreementReport
from plannercheck.validation.judging import Limits

# Rows of the table of pairs.
_SHOWN_PAIRS = 10

# Disagreements with the reference that are listed one by one.
_SHOWN_DISAGREEMENTS = 10


@dataclass(frozen=True)
class Outcome:
    """What a run found.

    Attributes:
        checker: The checker.
        report: Report of all rows.
        limits: What limits mean.
        elapsed: From the first row that was read to the last output that was written, s.
        checking: Time of that in checkers, all workers together, s.
        resumed: Rows of the report that an earlier run had judged.
        agreement: With FCL, if that was asked for.
        certification: By proofs, if that was asked for.
    """

    checker: AnyChecker
    report: ValidityReport
    limits: Limits
    elapsed: float
    checking: float
    resumed: int
    agreement: AgreementReport | None
    certification: CertificationReport | None


def as_json(outcome: Outcome) -> dict[str, Any]:
    """The summary as JSON has it."""
    values: dict[str, Any] = {
        "robot": outcome.checker.robot.name,
        "scene": outcome.checker.scene.name,
        **asdict(outcome.report),
        "invalid": outcome.report.invalid,
        "limits": outcome.limits,
        "elapsed": outcome.elapsed,
        "checking": outcome.checking,
        "resumed": outcome.resumed,
    }
    solids = _solids(outcome.checker)
    if solids:
        values["solids"] = {name: solid.kind for name, solid in solids.items()}
    if outcome.agreement is not None:
        values["fcl"] = {**_agreement_counts(outcome.agreement), "passed": outcome.agreement.passed}
    if outcome.certification is not None:
        values["certificates"] = {**_proof_counts(outcome.certification), "passed": outcome.certification.passed}
    return values


def show_table(outcome: Outcome) -> None:
    """Prints the summary."""
    checker, report = outcome.checker, outcome.report
    print(f"{checker.robot.name} in {checker.scene.name}, {len(checker.pairs)} pairs of bodies")
    solids = _solids(checker)
    if solids:
        print("; ".join(filter(None, (f"solids: {len(solids)} bodies", open_meshes(solids)))))
    counts = [("configurations", report.states), ("valid", report.valid), ("invalid", report.invalid)]
    if outcome.limits != "ignore":
        counts.append(("beyond limits", report.beyond_limits))
    print(table(("", "count", "part"), [(name, n, percentage(n, report.states)) for name, n in counts]))
    if outcome.resumed:
        print(f"{outcome.resumed:,} configurations were judged by the run that this one went on with")
    if outcome.elapsed > 0:
        rate = f"{(report.states - outcome.resumed) / outcome.elapsed:,.0f} configurations a second"
        print(f"{outcome.elapsed:.3f} s, {rate}; {outcome.checking:.3f} s in the checker")
    _show_pairs(report)
    if outcome.agreement is not None:
        _show_agreement(outcome.agreement)
    if outcome.certification is not None:
        print("\nProved in exact arithmetic, apart from the compiled core:")
        print(table(("", "count"), list(_proof_counts(outcome.certification).items())))


def _solids(checker: AnyChecker) -> dict[str, Solid]:
    if not isinstance(checker, Checker):
        return {}
    return {body.name: body.shape for body in checker.bodies if isinstance(body.shape, Solid)}


def _show_pairs(report: ValidityReport) -> None:
    if not report.pairs:
        return
    counted = "all colliding pairs" if report.all_pairs else "the first colliding pair found"
    print(f"\nMost frequent collisions (each configuration counts for {counted}):")
    rows = [(p.first, p.second, p.states, percentage(p.states, report.states)) for p in report.pairs]
    print(table(("link", "link or obstacle", "count", "part"), rows[:_SHOWN_PAIRS]))
    if len(rows) > _SHOWN_PAIRS:
        print(f"and {len(rows) - _SHOWN_PAIRS} more pairs")


def _agreement_counts(agreement: AgreementReport) -> dict[str, int]:
    return {
        "configurations": agreement.states,
        "pairs": agreement.pairs,
        "decided by FCL": agreement.fcl_calls,
        "decided by exact arithmetic instead": agreement.exact_calls,
        "collisions": agreement.collisions,
        "disagreements": len(agreement.disagreements),
        "errors of FCL": len(agreement.errors_of_fcl),
        "against us": len(agreement.against_us),
    }


def _proof_counts(certification: CertificationReport) -> dict[str, int]:
    return {
        "configurations": certification.states,
        "shared points": certification.shared_points,
        "separating planes": certification.planes,
        "separate boxes": certification.boxes,
        "not proved": len(certification.unproved),
    }


def _show_agreement(agreement: AgreementReport) -> None:
    print("\nCompared with FCL, exact arithmetic being the judge:")
    print(table(("", "count"), list(_agreement_counts(agreement).items())))
    for found in agreement.disagreements[:_SHOWN_DISAGREEMENTS]:
        verdict = "collide" if found.exact else f"are {found.distance:.3g} m apart"
        side = "against us" if found.against_us else "FCL errs"
        print(f"row {found.row}: {found.bodies[0]} and {found.bodies[1]} {verdict}: {side}")
    if agreement.contradictions:
        print(f"rows whose verdicts contradict each other: {list(agreement.contradictions)}")
