"""Reports count what the checker says, and sum up over sets."""

import numpy as np
import pytest

from plannercheck.checking.verdicts import PairCount, ValidityReport, merged
from plannercheck.validation.validate import validate


@pytest.fixture(scope="module")
def samples(checker) -> np.ndarray:
    return checker.scene.samples("panda")


def test_counts_are_those_of_check_states(checker, samples):
    found = validate(checker, samples, threads=2)
    assert np.array_equal(found.valid, checker.check_states(samples))
    assert found.report.states == len(samples)
    assert found.report.valid == found.valid.sum()
    assert found.report.invalid == (~found.valid).sum()
    assert found.report.rate > 0


def test_first_pairs_add_up_to_the_invalid_ones(checker, samples):
    report = validate(checker, samples).report
    counts = [pair.states for pair in report.pairs]
    assert sum(counts) == report.invalid
    assert counts == sorted(counts, reverse=True)


def test_all_pairs_are_those_that_explain_names(checker, samples):
    rows = samples[-60:]
    report = validate(checker, rows, all_pairs=True).report
    expected: dict[tuple[str, str], int] = {}
    for row in rows:
        for pair in {(v.first, v.second) for v in checker.explain(row).collisions}:
            expected[pair] = expected.get(pair, 0) + 1
    assert {(pair.first, pair.second): pair.states for pair in report.pairs} == expected


def test_limits_are_counted_but_do_not_make_invalid(checker):
    rows = np.tile(checker.robot.reference, (3, 1))
    rows[1, 0] = checker.robot.upper[0] + 0.01
    report = validate(checker, rows).report
    assert report.beyond_limits == 1
    assert not report.passed
    assert report.valid == checker.check_states(rows).sum()


def test_merged_reports_add_up(checker, samples):
    whole = validate(checker, samples).report
    parts = merged([validate(checker, samples[:300]).report, validate(checker, samples[300:]).report])
    for name in ("states", "valid", "beyond_limits", "pairs"):
        assert getattr(parts, name) == getattr(whole, name)


def test_nothing_is_an_empty_report_that_passes():
    report = merged([])
    assert report == ValidityReport(0, 0, 0, ())
    assert report.passed
    assert np.isnan(report.rate)


def test_pairs_of_one_name_are_summed():
    first = ValidityReport(2, 1, 0, (PairCount("a", "b", 1),))
    second = ValidityReport(9, 1, 0, (PairCount("a", "c", 5), PairCount("a", "b", 3)))
    assert merged([first, second]).pairs == (PairCount("a", "c", 5), PairCount("a", "b", 4))
