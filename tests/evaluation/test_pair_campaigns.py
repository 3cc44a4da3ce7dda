"""What the stress of pairs counts, keeps and asks again, of hulls, of solids and of sets of parts alike."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from plannercheck.cli.main import main
from plannercheck.evaluation.campaign import pairs, posed_pairs
from plannercheck.evaluation.campaign.campaign import judged, run
from plannercheck.evaluation.campaign.tallies import EXCEPTION, TIMEOUT, WRONG, Tally, total
from plannercheck.evaluation.stress import campaign as hulls
from plannercheck.evaluation.stress_parts import campaign as parts
from plannercheck.evaluation.stress_parts import judges as judges_of_parts
from plannercheck.evaluation.stress_solids import campaign as solids
from plannercheck.evaluation.stress_solids import judges as judges_of_solids

CAMPAIGNS = {"pairs": hulls.campaign, "solids": solids.campaign, "parts": parts.campaign}
# Who answers whole batches, and as whom.
BATCHES = {"pairs": hulls, "solids": judges_of_solids, "parts": judges_of_parts}


@pytest.mark.parametrize(("kind", "count"), [("pairs", 2000), ("solids", 400), ("parts", 400)])
def test_runs_do_not_depend_on_the_number_of_processes(kind: str, count: int) -> None:
    alone, together = run(CAMPAIGNS[kind](9), count), run(CAMPAIGNS[kind](9), count, processes=2)
    assert alone.failures == 0
    for of in ("counts", "faults", "draws", "judged", "broken"):
        assert getattr(alone, of) == getattr(together, of)
    assert kind != "pairs" or alone.judged == 55 * 37


@pytest.mark.parametrize(("outcome", "found"), [("wrong", WRONG), (EXCEPTION, EXCEPTION), (TIMEOUT, TIMEOUT)])
@pytest.mark.parametrize("kind", ["solids", "parts"])
def test_failures_are_counted_and_kept(kind: str, outcome: str, found: str) -> None:
    """Of one contestant, at one pair of each draw."""
    batch = BATCHES[kind].BATCH

    def answers(drawn: Any, truth: list[bool], number: int) -> pairs.Asked:
        told: list[posed_pairs.Outcome] = [*truth]
        told[0] = not truth[0] if outcome == "wrong" else outcome
        return {batch: lambda: told}

    suite = replace(CAMPAIGNS[kind](1), questions=answers)
    tally = Tally[pairs.PairCase[Any]]()
    for number in range(3):
        tally.merge(judged((suite, number)))
    assert total(tally.faults, who=batch, outcome=found) == tally.failures == len(tally.cases) == 3


@pytest.mark.parametrize("kind", CAMPAIGNS)
def test_a_wrong_verdict_fails_the_command_and_is_kept_and_asked_again(
    kind: str, capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = BATCHES[kind].batch
    monkeypatch.setattr(BATCHES[kind], "batch", lambda *a: [not shared for shared in told(*a)])
    monkeypatch.setattr(pairs, "KEPT", 1)
    assert main(["stress", f"--{kind}", "20", "--seed", "4", "--cases", str(tmp_path)]) == 1
    assert "failed: draw 0" in capsys.readouterr().out
    (file,) = tmp_path.iterdir()
    assert main(["stress", "--case", str(file)]) == 1
    assert ": wrong" in capsys.readouterr().out
    monkeypatch.undo()
    assert main(["stress", "--case", str(file)]) == 0
    assert "nothing is wrong now" in capsys.readouterr().out


@pytest.mark.parametrize("kind", CAMPAIGNS)
def test_the_command(kind: str, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["stress", f"--{kind}", "100", "--seed", "4", "--cases", str(tmp_path)]) == 0
    assert "pairs of" in capsys.readouterr().out
    assert not list(tmp_path.iterdir())
    assert main(["stress", f"--{kind}", "0"]) == 2
