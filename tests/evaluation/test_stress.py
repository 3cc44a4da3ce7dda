"""A sample of the stress suite, what it is made of, and what it keeps. `plannercheck stress` runs more of it."""

from __future__ import annotations

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
from plannercheck.evaluation.stress import run as stress
from plannercheck.evaluation.stress.failing_cases import Case, shrunk
from plannercheck.evaluation.stress.failure_tables import EXCEPTION, TIMEOUT, WRONG
from plannercheck.evaluation.stress.other_libraries import Coal, Fcl
from plannercheck.evaluation.stress.random_cases import FAMILY_NAMES, GAPS, Draw, draw, draws
from plannercheck.evaluation.stress.supervised_process import Supervised
from plannercheck.evaluation.stress.tables import lines

SAMPLE = 6000  # pairs: fewer leave families out


@pytest.fixture(scope="module")
def tally() -> stress.StressTally:
    return stress.run(SAMPLE, seed=2026, peers=[Coal()])


def test_nothing_fails_on_a_sample(tally: stress.StressTally) -> None:
    assert tally.passed, "\n".join(lines(tally, []))
    assert not tally.cases


def test_the_sample_has_all_families_and_both_answers(tally: stress.StressTally) -> None:
    assert {family for family, _, _ in tally.pairs} == set(FAMILY_NAMES)
    assert {gap for _, gap, _ in tally.pairs} == set(GAPS)
    sharing = sum(count for (_, _, shared), count in tally.pairs.items() if shared)
    assert 0.3 < sharing / tally.pairs.total() < 0.7


def test_the_tables_count_every_pair_and_the_errors_of_peers(tally: stress.StressTally) -> None:
    text = lines(tally, ["coal"])
    totals = [line.split() for line in text if line.startswith("all")]
    assert len(totals) == 2
    for total in totals:
        assert total[1:6] == [str(tally.pairs.total()), totals[0][2], "0", "0", "0"]
    wrong = sum(n for (who, kind, _), n in tally.failures.items() if (who, kind) == ("coal", WRONG))
    assert wrong == int(totals[0][6]) + int(totals[0][7]) > 0


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
    monkeypatch.setattr(stress, "_outcomes", _badly)
    monkeypatch.setattr(stress, "KEPT", 0)
    tally = stress.run(1, seed=1)
    assert not tally.passed
    kinds = {kind for who, kind, _ in tally.failures if who == "walk"}
    assert {EXCEPTION, TIMEOUT, WRONG} <= kinds


def _badly(drawn: object, method: str) -> list[bool | str]:
    return [EXCEPTION, TIMEOUT, True, False] * 9 + [True]


def test_a_failure_is_shrunk_to_what_it_takes() -> None:
    rng = np.random.default_rng(1)
    p, r = rng.normal(size=(40, 3)), rng.normal(size=(30, 3))
    case = Case("two clouds", (p, r, np.eye(4), np.eye(4)), (0.5, 0.0))

    def shares(smaller: Case) -> bool:
        return exact.intersects(*smaller.bodies, *smaller.inflation_radii)

    small = shrunk(case, shares)
    assert shares(small)
    assert small.inflation_radii == case.inflation_radii
    assert len(small.bodies[0]) + len(small.bodies[1]) <= 5


def test_a_inflated_case_keeps_its_inflation_radii(tmp_path: Path) -> None:
    Case("a name", (np.zeros((1, 3)), np.ones((1, 3)), np.eye(4), np.eye(4)), (0.1, 0.0)).save(tmp_path / "case.json")
    assert Case.load(tmp_path / "case.json").inflation_radii == (0.1, 0.0)


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
            asked += outcomes[k] != stress.UNFIT
            wrong += outcomes[k] not in (stress.UNFIT, truth)
    assert wrong <= asked / 10
    assert asked > 3


def test_improper_poses_are_refused() -> None:
    drawn = next(draws(1))
    for improper in (np.diag([1.0, 1, -1, 1]), np.diag([1.001, 1, 1, 1]), np.full((4, 4), np.nan)):
        with pytest.raises(pc.PlannercheckError, match="pose"):
            pc.intersects(drawn.p.polytope, drawn.r.polytope, improper)


def test_the_command(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["stress", "--pairs", "100", "--seed", "4", "--cases", str(tmp_path)]) == 0
    assert "0" in capsys.readouterr().out
    assert not list(tmp_path.iterdir())
    assert main(["stress", "--pairs", "0"]) == 2
    assert main(["stress", "--cases", str(tmp_path / "missing")]) == 2


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
