"""Prints the results of checking paths again."""

from __future__ import annotations

from collections.abc import Sequence

from plannercheck.validation.fcl_agreement import merged
from plannercheck.validation.path_recheck import PathCheck


def show_checks(checks: Sequence[PathCheck]) -> None:
    """Prints the sum over some paths."""
    agreement = merged([check.agreement for check in checks])
    print(
        f"\nchecked again: {len(checks)}, {agreement.states} sampled states, "
        f"{agreement.collisions} colliding pairs; "
        f"FCL differs on {len(agreement.disagreements)} of {agreement.pairs} pairs "
        f"({len(agreement.errors_of_fcl)} errors of FCL, {len(agreement.against_us)} against us)\n"
        f"{sum(check.between for check in checks)} states between the samples: "
        f"{sum(check.between_colliding for check in checks)} collide, "
        f"on {sum(check.between_colliding > 0 for check in checks)} paths"
    )
