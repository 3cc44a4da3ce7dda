"""A sample of the stress suite, what it is made of, and what it keeps. `plannercheck stress` runs more of it."""

import itertools
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import plannercheck as pc
from plannercheck.bodies import exact_reference as exact
from plannercheck.cli.main import main
from plannercheck.evaluation.campaign import tallies
from plannercheck.evaluation.campaign.campaign import run
from plannercheck.evaluation.campaign.pairs import TRUTH, PairCase, smaller
from plannercheck.evaluation.campaign.posed_pairs import UNFIT
from plannercheck.evaluation.campaign.supervised_process import Supervised
from plannercheck.evaluation.campaign.tallies import EXCEPTION, TIMEOUT, WRONG, Tally, total
from plannercheck.evaluation.stress import campaign as stress
from plannercheck.evaluation.stress.other_libraries import Coal, Fcl
from plannercheck.evaluation.stress.random_cases import FAMILY_NAMES, GAPS, Draw, draw, draws
from plannercheck.evaluation.stress.sample_bodies import Specimen

SAMPLE = 2200  # pairs, with this seed of all families


SUITE = stress.campaign(25, (Coal,))


@pytest.fixture(scope="module")
def tally() -> Tally[PairCase[Specimen]]:
    return run(SUITE, SAMPLE)


def test_nothing_fails_on_a_sample(tally: Tally[PairCase[Specimen]]) -> None:
    assert tally.failures == 0, "\n".join(SUITE.lines(tally))
    assert not tally.cases


def test_the_sample_has_all_families_and_both_answers(tally: Tally[PairCase[Specimen]]) -> None:
    assert {entry.family for entry in tally.counts} == set(FAMILY_NAMES)
    assert {entry.offset for entry in tally.counts} == set(GAPS)
    assert 0.3 < total(tally.counts, who=TRUTH, shared=True) / tally.judged < 0.7


def test_the_tables_count_every_pair_and_the_errors_of_peers(tally: Tally[PairCase[Specimen]]) -> None:
    sums = [line.split() for line in SUITE.lines(tally) if line.startswith("all")]
    assert len(sums) == 2
    for each in sums:
        assert each[1:6] == [str(tally.judged), sums[0][2], "0", "0", "0"]
    assert total(tally.counts, who="coal", outcome=WRONG) == int(sums[0][6]) + int(sums[0][7]) > 0


@settings(max_examples=40, derandomize=True, deadline=None)
@given(st.integers(0, 2**63), st.integers(0, len(GAPS) - 1), st.sampled_from(["oracle", "walk", "exact"]))
def test_any_draw_is_decided_right(seed: int, k: int, method: str) -> None:
    drawn = draw(np.random.default_rng(seed))
    p, r = drawn.p.polytope, drawn.r.polytope
    truth = exact.intersects(
        p.vertices, r.vertices, drawn.poses_p[k], drawn.poses_r[k], p.inflation_radius, r.inflation_radius
    )
    assert pc.intersects(p, r, drawn.poses_p[k], drawn.poses_r[k], method=method) == truth  # type: ignore[arg-type]


def test_draws_can_be_made_again() -> None:
    for first, again in zip(itertools.islice(draws(3), 5), draws(3), strict=False):
        assert first.label == again.label
        np.testing.assert_array_equal(first.poses_p, again.poses_p)


def test_wrong_verdicts_exceptions_and_timeouts_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stress, "outcomes_of", _badly)
    tally = run(stress.campaign(1), 1)
    assert tally.failures > tallies.KEPT == len(tally.cases)
    assert {entry.outcome for entry in tally.faults if entry.who == "walk"} == {EXCEPTION, TIMEOUT, WRONG}
    assert tally.first == dict.fromkeys((EXCEPTION, TIMEOUT, WRONG), tally.judged)
    many = Tally[PairCase[Specimen]]()
    for _ in range(2):
        many.merge(tally)
    assert len(many.cases) == tallies.KEPT


def test_a_draw_that_can_not_be_made_is_broken_and_ends_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(self: Specimen) -> None:
        raise pc.PlannercheckError("no body")

    monkeypatch.setattr(Specimen, "polytope", property(refused))
    tally = run(stress.campaign(1), 3)
    assert (tally.failures, tally.draws, tally.judged) == (3, 3, 3)
    assert any("broken: draw 2: PlannercheckError('no body')" in line for line in stress.campaign(1).lines(tally))


def _badly(drawn: object, method: str) -> list[bool | str]:
    return [EXCEPTION, TIMEOUT, True, False] * 9 + [True]


def test_a_failure_is_shrunk_to_what_it_takes() -> None:
    rng = np.random.default_rng(1)
    p, r = rng.normal(size=(40, 3)), rng.normal(size=(30, 3))
    case = PairCase("two clouds", Specimen("p", p, 0.5), Specimen("r", r), np.eye(4), np.eye(4))

    def shares(tried: PairCase[Specimen]) -> bool:
        radii = tried.p.inflation_radius, tried.r.inflation_radius
        return exact.intersects(tried.p.points, tried.r.points, tried.pose_p, tried.pose_r, *radii)

    small = smaller(case, shares)
    assert shares(small)
    assert small.p.inflation_radius == 0.5
    assert len(small.p.points) + len(small.r.points) <= 5
    assert stress.campaign(0).shrunk(case) is case  # it does not fail


@pytest.mark.parametrize("peer", [Coal, Fcl])
def test_peers_agree_at_wide_gaps_of_bodies_about_a_metre(peer: type[Coal] | type[Fcl]) -> None:
    asked, wrong = 0, 0
    wide = [k for k, gap in enumerate(GAPS.values()) if gap == 1e-2]
    for drawn in itertools.islice(draws(5), 100):
        if min(drawn.p.size, drawn.r.size) < 0.1 or max(drawn.p.size, drawn.r.size) > 10:
            continue
        outcomes = Supervised(peer()).outcomes(drawn)
        for k in wide:
            truth = exact.intersects(
                drawn.p.vertices,
                drawn.r.vertices,
                drawn.poses_p[k],
                drawn.poses_r[k],
                drawn.p.inflation_radius,
                drawn.r.inflation_radius,
            )
            asked += outcomes[k] != UNFIT
            wrong += outcomes[k] not in (UNFIT, truth)
    assert wrong <= asked / 10
    assert asked > 3


def test_improper_poses_are_refused() -> None:
    drawn = next(draws(1))
    for improper in (np.diag([1.0, 1, -1, 1]), np.diag([1.001, 1, 1, 1]), np.full((4, 4), np.nan)):
        with pytest.raises(pc.PlannercheckError, match="pose"):
            pc.intersects(drawn.p.polytope, drawn.r.polytope, improper)


def test_a_folder_of_cases_that_is_missing_is_refused(tmp_path: Path) -> None:
    assert main(["stress", "--cases", str(tmp_path / "missing")]) == 2


def test_a_peer_that_is_not_installed_is_told_at_once() -> None:
    def missing() -> Coal:
        raise pc.PlannercheckError("coal is not installed")

    with pytest.raises(pc.PlannercheckError, match="not installed"):
        stress.campaign(1, (missing,))


class Sleeper:
    """A peer that does not come back from its third pair."""

    name = "sleeper"

    def outcomes(self, drawn: Draw, first: int = 0) -> Iterator[bool | str]:
        for k in range(first, len(drawn.poses_p)):
            if k == 2:
                time.sleep(60)
            yield k % 2 == 0 if k else "exception"


def test_a_peer_that_does_not_come_back_is_stopped() -> None:
    drawn = draw(np.random.default_rng(0))
    expected = [k % 2 == 0 for k in range(len(drawn.poses_p))]
    assert Supervised(Sleeper(), 0.5).outcomes(drawn) == ["exception", False, "timeout", *expected[3:]]
