"""Pair by pair: no disagreement with FCL, at any gap, goes against us."""

from pathlib import Path

import pytest
from pair_run import Tally, run

from plannercheck.evaluation.campaign.cases import save

pytestmark = pytest.mark.agreement


@pytest.fixture(scope="module")
def tally(pairs_wanted: int, reports: list[str]) -> Tally:
    found = run(pairs_wanted, seed=2026)
    reports.append(
        f"{found.pairs} pairs, {found.decided} decided exactly: {len(found.against_us)} against us, "
        f"{len(found.clear_errors)} errors of FCL on wide bodies with a clear gap"
    )
    reports += found.table.lines()
    return found


def test_no_verdict_of_ours_is_refuted(tally: Tally, tmp_path: Path) -> None:
    for number, case in enumerate(tally.against_us[:20]):
        save(tmp_path / f"{number}.json", "pairs", case.document())
    names = [case.name for case in tally.against_us[:20]]
    assert not tally.against_us, f"{len(tally.against_us)} cases, the first saved in {tmp_path}: {names}"


def test_wide_bodies_with_a_clear_gap_never_disagree(tally: Tally) -> None:
    assert not tally.clear_errors, tally.clear_errors[:20]


def test_the_run_was_as_long_as_asked(tally: Tally, pairs_wanted: int) -> None:
    assert tally.pairs >= pairs_wanted
    assert tally.decided > 0
