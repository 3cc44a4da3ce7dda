"""The stress of motions of solids: a sample, what its oracle finds when answers are wrong, and what hulls refuse."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plannercheck.bodies.solids import Solid
from plannercheck.cli.main import main
from plannercheck.common.array_types import Floats
from plannercheck.evaluation.campaign.campaign import run
from plannercheck.evaluation.campaign.cases import save
from plannercheck.evaluation.campaign.tallies import total
from plannercheck.evaluation.stress_motions.aims import Motions
from plannercheck.evaluation.stress_motions.campaign import campaign
from plannercheck.evaluation.stress_motions.cases import subject_of
from plannercheck.evaluation.stress_motions.draws import Draw
from plannercheck.evaluation.stress_motions.mesh_states import MeshStates
from plannercheck.evaluation.stress_motions.outcomes import COLLISION, FREE, UNREASONED, Judged
from plannercheck.evaluation.stress_motions.planned_draws import PLANNED, planned_draw, refused_by_others
from plannercheck.evaluation.stress_motions.solid_draws import SETTINGS, solid_draw, stage_of
from plannercheck.evaluation.stress_motions.subjects import SpaceSubject

pytestmark = pytest.mark.filterwarnings("ignore:.*open meshes")

FREE_BODIES = "key in lock", "hook in ring"


@pytest.mark.parametrize("family", SETTINGS)
def test_every_setting_is_judged(family: str) -> None:
    suite = campaign(3, (family,))
    found = run(suite, 1)
    assert found.failures == 0, "\n".join(suite.lines(found))
    count = {entry.outcome: n for entry, n in found.counts.items()}
    assert count["sharp"] > 5
    assert count["free"] > 50
    assert count["mesh states"] > 40 * count["free"]
    assert count["refused by meshes"] > 3


@pytest.mark.parametrize("family", ["planned ur10", "planned hook in ring"])
def test_hulls_refuse_a_part_of_a_planners_motions(family: str) -> None:
    suite = campaign(2, (family,))
    found = run(suite, 1)
    assert found.failures == 0, "\n".join(suite.lines(found))
    count = {entry.outcome: n for entry, n in found.counts.items()}
    assert count["planned"] == count["free"] == count["motions"]  # all that the planner was told are free
    assert 0 < count["refused by hull"] < count["planned"]
    told = f"{family}: {count['planned']} motions of RRT-Connect: hulls refuse"
    assert any(told in line for line in suite.lines(found))


def test_refused_by_hulls_is_counted() -> None:
    """Of two motions of the hook, one far from the ring and one in its hole."""
    stage = stage_of("hook in ring", "slerp")
    inside = stage.near[0]
    outside = inside + np.array([5.0, 0, 0, 0, 0, 0, 0])
    q = np.stack([outside, outside, inside])
    none = np.zeros(3, dtype=bool)
    drawn = Draw("planned hook in ring", stage.recipe, Motions(q, q, np.zeros(3), q, none), 1e-4)
    judged = Judged()
    refused_by_others(drawn, np.full(3, FREE, dtype=np.int8), judged)
    assert (judged.counts["planned"], judged.counts["refused by hull"]) == (3, 1)


def test_a_planner_finds_the_same_again() -> None:
    first, second = (planned_draw(PLANNED[0], np.random.default_rng(4)).motions for _ in range(2))
    np.testing.assert_array_equal(first.q0, second.q0)
    np.testing.assert_array_equal(first.q1, second.q1)


@pytest.mark.parametrize("family", SETTINGS)
def test_settings_have_concave_bodies(family: str) -> None:
    shapes = [body.shape for body in stage_of(family, "screw").checker.bodies]
    assert any(isinstance(shape, Solid) and not shape.equals_hull for shape in shapes)


def test_contacts_have_just_begun() -> None:
    """States through which motions are laid collide, and are free of collisions a little before."""
    for seed in range(3):
        drawn = solid_draw("hook in ring", np.random.default_rng(seed))
        subject, touching = subject_of(drawn.recipe), drawn.motions.touching
        assert touching.any()
        states = drawn.motions.through[touching]
        assert not subject.checker.check_states(states).any()
        aside = states + 1e-6 * np.random.default_rng(0).normal(size=states.shape)
        aside[:, 3:] /= np.linalg.norm(aside[:, 3:], axis=1)[:, None]
        assert subject.checker.check_states(aside).mean() > 0.2


@pytest.mark.parametrize("path", ["screw", "slerp"])
@pytest.mark.parametrize("family", FREE_BODIES)
def test_the_oracle_poses_what_is_judged(family: str, path: Any) -> None:
    stage, rng = stage_of(family, path), np.random.default_rng(6)
    meshes, robot = MeshStates(stage.checker), stage.checker.robot
    t = np.linspace(0, 1, 7)
    for _ in range(20):
        q0, q1 = stage.tangents.moved(stage.near[0], rng.normal(size=(2, 6)))
        theirs = meshes.between(q0, q1, t, path)
        ours = stage.checker.certifier_of(path).states(q0, q1, t)
        np.testing.assert_allclose(robot.link_poses(ours), robot.link_poses(theirs), atol=1e-9)


def test_surfaces_meet_and_come_near_by_the_oracle() -> None:
    """The hook beside the ring, where only distance matters, and drawn up to it."""
    stage = stage_of("hook in ring", "screw")
    meshes, checker = MeshStates(stage.checker), stage.checker
    rng = np.random.default_rng(3)
    states = stage.tangents.moved(stage.near[0], 0.3 * rng.normal(size=(300, 6)))
    np.testing.assert_array_equal(meshes.collide(checker.robot.expand(states)), ~checker.check_states(states))
    for q in states[checker.check_states(states)][:20]:
        distance = checker.clearance(q)
        assert meshes.come_near(q, distance + 1e-6)
        assert not meshes.come_near(q, distance - 1e-6)


def _all_free(self: Any, q0: Floats, *_: Any) -> Any:
    return np.ones(len(q0), dtype=bool)


@pytest.mark.parametrize(
    ("owner", "asked", "answer", "kind"),
    [
        (SpaceSubject, "check", _all_free, COLLISION),
        (MeshStates, "collide", lambda self, full: np.ones(len(full), dtype=bool), COLLISION),
        (MeshStates, "come_near", lambda self, full, distance: False, UNREASONED),
    ],
    ids=["all free", "all meet", "none near"],
)
def test_what_meshes_contradict_is_found(
    owner: type, asked: str, answer: Callable[..., Any], kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(owner, asked, answer)
    suite = campaign(4, ("hook in ring",))
    found = run(suite, 1)
    assert total(found.faults, outcome=kind) > 0, "\n".join(suite.lines(found))


def test_meshes_alone_find_motions_that_pass_through(monkeypatch: pytest.MonkeyPatch) -> None:
    """With a checker that calls every state and every motion free."""
    monkeypatch.setattr(SpaceSubject, "check", _all_free)
    monkeypatch.setattr("plannercheck.evaluation.stress_motions.judges.sampled", lambda *_: None)
    monkeypatch.setattr("plannercheck.evaluation.stress_motions.judges.ends_and_contacts", lambda *_: None)
    monkeypatch.setattr("plannercheck.evaluation.stress_motions.judges.least_clearances", lambda *_: None)
    suite = campaign(4, ("key in lock",))
    found = run(suite, 1)
    assert total(found.faults, outcome=COLLISION) > 50


def test_the_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["stress", "--motions", "1", "--geometry", "solid", "--families", "hook in ring"]) == 0
    said = capsys.readouterr().out
    assert "hook in ring" in said
    assert "by coal's meshes:" in said
    assert main(["stress", "--motions", "10", "--families", "hook in ring"]) == 2
    assert main(["stress", "--motions", "10", "--geometry", "solid", "--families", "tree"]) == 2
    assert main(["stress", "--motions", "10", "--pieces"]) == 2
    assert "with --geometry solid" in capsys.readouterr().err


def test_a_failure_is_kept_and_asked_again(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(SpaceSubject, "check", _all_free)
    suite = campaign(4, ("hook in ring",))
    (case, *_) = run(suite, 1).cases
    save(tmp_path / "case.json", "motions", replace(case, motions=case.motions.of(np.array([0]))).document())
    assert main(["stress", "--case", str(tmp_path / "case.json")]) == 1
    monkeypatch.undo()
    assert main(["stress", "--case", str(tmp_path / "case.json")]) == 0
