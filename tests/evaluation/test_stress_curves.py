"""A sample of the stress of curves, and what it finds when answers are wrong."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plannercheck.cli.main import main
from plannercheck.evaluation.campaign.campaign import run
from plannercheck.evaluation.campaign.cases import load, save
from plannercheck.evaluation.campaign.tallies import total
from plannercheck.evaluation.stress_motions.campaign import campaign, families_of
from plannercheck.evaluation.stress_motions.cases import subject_of
from plannercheck.evaluation.stress_motions.curve_numbers import numbers_of
from plannercheck.evaluation.stress_motions.curves import curved
from plannercheck.evaluation.stress_motions.draws import tree_draw
from plannercheck.evaluation.stress_motions.outcomes import COLLISION, HISTORY, UNREASONED
from plannercheck.evaluation.stress_motions.relatives import cut, raised
from plannercheck.evaluation.stress_motions.subjects import CurveSubject
from plannercheck.trajectories.trajectory import Trajectory

SAMPLE = 1500  # curves


def test_nothing_fails_on_a_sample() -> None:
    suite = campaign(2026, families_of(False, True), curves=True)
    found = run(suite, SAMPLE)
    assert found.failures == 0, "\n".join([*suite.lines(found), *(case.name for case in found.cases)])
    counted = {name: total(found.counts, outcome=name) for name in ("free", "sharp")}
    assert counted["free"] > SAMPLE / 10
    assert counted["sharp"] > SAMPLE / 20


@pytest.mark.parametrize("seed", range(8))
def test_curves_pass_the_contact_or_a_corner_of_their_tube_does(seed: int) -> None:
    rng = np.random.default_rng(seed)
    drawn = curved(tree_draw("chain" if seed % 2 else "straight", rng), rng)
    subject, motions = subject_of(drawn.recipe), drawn.motions
    states = np.concatenate(
        [subject.states(a, b, at[None]) for a, b, at in zip(motions.q0, motions.q1, motions.at, strict=True)]
    )
    reached = subject.nearest(states, motions.through, motions.q1)
    assert np.abs(subject.placed(reached) - subject.placed(motions.through)).max() < 1e-10
    assert not subject.checker.check_states(motions.through[motions.touching]).any()


def test_relatives_are_the_same_curve() -> None:
    rng = np.random.default_rng(1)
    for degree in range(1, 8):
        points, place = rng.normal(size=(degree + 1, 3)), rng.random()
        whole, more = (Trajectory.bezier([0, 1], each[None]) for each in (points, raised(points)))
        parts = Trajectory.bezier([0, place, 1], np.array(cut(points, place)))
        at = rng.random(20)
        assert np.abs(more.position(at) - whole.position(at)).max() < 1e-14
        assert np.abs(parts.position(at) - whole.position(at)).max() < 1e-14


def _all(answer: bool) -> Any:
    return lambda self, q0, *_: np.full(len(q0), answer)


@pytest.mark.parametrize(
    ("asked", "wrong", "kind"),
    [
        ("check", _all(True), COLLISION),
        ("check", _all(False), UNREASONED),
        ("check_one", lambda self, *_: True, HISTORY),
    ],
)
def test_wrong_answers_are_found(asked: str, wrong: Any, kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(CurveSubject, asked, wrong)
    found = run(campaign(4, ("tree",), curves=True), 200)
    assert total(found.faults, family="tree", outcome=kind) > 0


def test_a_failure_is_kept_and_asked_again(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(CurveSubject, "check", _all(True))
    suite = campaign(4, ("turns",), curves=True)
    case = next(case for case in run(suite, 100).cases if case.kind == COLLISION)
    case = replace(case, motions=case.motions.of(np.array([0])))  # that which failed
    save(tmp_path / "case.json", "motions", case.document())
    _, kept = load(tmp_path / "case.json", {"motions": lambda: suite})
    points, _ = numbers_of(kept.motions.q0[0], kept.motions.q1[0])
    assert len(points) >= 2
    assert main(["stress", "--case", str(tmp_path / "case.json")]) == 1
    monkeypatch.undo()
    assert main(["stress", "--case", str(tmp_path / "case.json")]) == 0


def test_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["stress", "--motions", "500", "--curves", "--families", "turns"]) == 0
    assert "turns" in capsys.readouterr().out
    assert main(["stress", "--motions", "10", "--curves", "--families", "plane chain"]) == 2
    assert main(["stress", "--curves"]) == 2
