"""A sample of the stress of motions. `plannercheck stress --motions` runs more, found_faults.py what it has to find."""

from __future__ import annotations

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.cli import main
from plannercheck.stress import motion_judges, motion_run
from plannercheck.stress.motion_run import FAMILY_NAMES, MotionTally
from plannercheck.stress.motion_tables import lines

SAMPLE, VERIFIED = 3000, 60


@pytest.fixture(scope="module")
def tally() -> MotionTally:
    return motion_run.run(SAMPLE, seed=2027, verified=VERIFIED)


def test_nothing_is_wrong_on_a_sample(tally: MotionTally) -> None:
    assert tally.failures == 0, "\n".join([*lines(tally), *(case.name for case in tally.cases)])
    assert tally.motions >= SAMPLE
    total = sum(tally.counts.values(), start=type(next(iter(tally.counts.values())))())
    assert total["verified"] > VERIFIED / 2
    assert total["sharp"] > SAMPLE / 10  # free at both ends, in contact between
    assert 0.1 < total["free"] / total["motions"] < 0.9


def test_what_is_found_does_not_depend_on_processes() -> None:
    alone, shared = (motion_run.run(400, seed=5, verified=4, processes=n) for n in (1, 2))
    assert alone.counts == shared.counts
    assert alone.faults == shared.faults


@pytest.mark.parametrize(("free", "kind"), [(True, motion_judges.COLLISION), (False, motion_judges.UNREASONED)])
def test_wrong_verdicts_are_found(monkeypatch: pytest.MonkeyPatch, free: bool, kind: str) -> None:
    def check(self: object, q0: np.ndarray, *more: object, **options: object) -> np.ndarray:
        return np.full(len(q0), free)

    for checker in (pc.Checker, pc.planar.Checker):
        monkeypatch.setattr(checker, "check_motions", check)
    found = motion_run.run(300, seed=8, families=("tree", "plane chain"))
    assert sum(faults[kind] for faults in found.faults.values())
    assert found.cases


def test_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["stress", "--motions", "100", "--seed", "3", "--families", "plane chain"]) == 0
    printed = capsys.readouterr().out
    assert "plane chain" in printed
    assert main(["stress", "--motions", "100", "--families", "nowhere"]) == 2
    assert FAMILY_NAMES[0] in capsys.readouterr().err
