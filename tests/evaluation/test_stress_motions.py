"""A sample of the stress of motions, what it is made of, what it finds when answers are wrong, and what it keeps."""

import itertools
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial.transform import Rotation

import plannercheck as pc
from plannercheck.bodies.intersection import certify_posed
from plannercheck.cli.main import main
from plannercheck.evaluation.campaign.campaign import run
from plannercheck.evaluation.campaign.cases import load, save
from plannercheck.evaluation.campaign.tallies import Tally, total
from plannercheck.evaluation.stress_motions import campaign as motion_campaign
from plannercheck.evaluation.stress_motions.campaign import FAMILY_NAMES, campaign
from plannercheck.evaluation.stress_motions.cases import MotionCase, shrunk, subject_of
from plannercheck.evaluation.stress_motions.contacts import Closeness, extent_of, random_contact
from plannercheck.evaluation.stress_motions.draws import tree_draw
from plannercheck.evaluation.stress_motions.ompl_paths import OMPL_FAMILY
from plannercheck.evaluation.stress_motions.outcomes import (
    ASTRAY,
    COLLISION,
    EXCEPTION,
    HISTORY,
    PROOF,
    UNREASONED,
    Fault,
    Judged,
)
from plannercheck.evaluation.stress_motions.planar_draws import planar_draw
from plannercheck.evaluation.stress_motions.recipes import robot_of, shape_of, space_checker
from plannercheck.evaluation.stress_motions.subjects import PlaneSubject, SpaceSubject
from plannercheck.evaluation.stress_motions.tangents import tangents_of
from plannercheck.evaluation.stress_motions.trees import Wishes, random_states, random_tree
from plannercheck.proofs.data import Verification

SAMPLE = 1000  # motions


SUITE = campaign(2026, verified=0.03)
SUITES = {"motions": lambda: SUITE}


@pytest.fixture(scope="module")
def tally() -> Tally[MotionCase]:
    return run(SUITE, SAMPLE)


def test_nothing_fails_on_a_sample(tally: Tally[MotionCase]) -> None:
    assert tally.failures == 0, "\n".join(SUITE.lines(tally))
    assert not tally.cases
    assert tally.judged >= SAMPLE
    counted = {name: total(tally.counts, outcome=name) for name in ("free", "sharp", "verified")}
    assert counted["free"] > SAMPLE / 5
    assert counted["sharp"] > SAMPLE / 20
    assert counted["verified"] > 20


@pytest.mark.parametrize("family", FAMILY_NAMES)
def test_every_family_is_judged(family: str) -> None:
    suite = campaign(3, (family,))
    found = run(suite, 10)
    assert found.failures == 0, "\n".join(suite.lines(found))
    assert total(found.counts, family=family, outcome="motions") == found.judged >= 10


def test_what_is_found_does_not_depend_on_processes() -> None:
    alone, shared = (run(campaign(9, ("tree", "plane chain")), 600, processes=k) for k in (1, 2))
    assert alone.counts == shared.counts
    assert (alone.draws, alone.judged) == (shared.draws, shared.judged)


@pytest.mark.parametrize("seed", range(4))
def test_motions_pass_the_state_that_they_were_laid_through(seed: int) -> None:
    rng = np.random.default_rng(seed)
    recipe = random_tree(Wishes(("floating", "planar", "ball", "continuous", "revolute"), (1.0,) * 5, whole=1.0), rng)
    robot = robot_of(recipe)
    tangents = tangents_of(robot)
    (q,) = random_states(robot, 1, rng)
    way = rng.normal(size=tangents.dimension)
    q0, q1 = tangents.moved(q, -0.3 * way[None])[0], tangents.moved(q, 0.7 * way[None])[0]
    assert np.abs(pin.difference(robot.model, pin.interpolate(robot.model, q0, q1, 0.3), q)).max() < 1e-9


def test_contacts_by_construction_are_collisions() -> None:
    for seed in range(4):
        drawn = tree_draw("tree", np.random.default_rng(seed))
        assert drawn.recipe["kind"] == "space"
        touching = drawn.motions.through[drawn.motions.touching]
        assert not space_checker(drawn.recipe).check_states(touching).any()
        planar = planar_draw("plane chain", np.random.default_rng(seed))
        assert planar.recipe["kind"] == "plane"
        valid = PlaneSubject(planar.recipe).checker.check_states(planar.motions.through[planar.motions.touching])
        assert not valid.any()


_COUNT = itertools.count(1)


def _all_free(self: Any, q0: Any, *_: Any) -> Any:
    return np.ones(len(q0), dtype=bool)


def _none_free(self: Any, q0: Any, *_: Any) -> Any:
    return np.zeros(len(q0), dtype=bool)


def _thrown(self: Any, *_: Any) -> Any:
    raise ValueError("something else")


_UNPROVED = Verification(False, "it is none", 0, 0.0)


@pytest.mark.parametrize(
    ("asked", "answer", "kind"),
    [
        ("check", _all_free, COLLISION),
        ("check", _none_free, UNREASONED),
        ("check_one", lambda self, *_: True, HISTORY),
        ("check", _thrown, EXCEPTION),
        ("placed", lambda self, q: np.arange(len(q) * 16.0).reshape(-1, 1, 4, 4) * next(_COUNT), ASTRAY),
        ("certify", lambda self, q0, *_: (None,) * len(q0), PROOF),
        ("certify", lambda self, *_: ((SimpleNamespace(verify=lambda: _UNPROVED),),), PROOF),
    ],
)
def test_wrong_answers_are_found(
    asked: str, answer: Callable[..., Any], kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(SpaceSubject, asked, answer)
    suite = campaign(4, ("tree",), verified=0.1)
    found = run(suite, 100)
    assert total(found.faults, family="tree", outcome=kind) > 0, "\n".join(suite.lines(found))
    assert any(line.startswith("first " + kind) for line in suite.lines(found))


def test_a_failure_is_kept_shrunk_and_asked_again(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(SpaceSubject, "check", _all_free)
    found = run(campaign(4, ("tree",)), 100)
    case = next(case for case in found.cases if case.kind == COLLISION)
    save(tmp_path / "case.json", "motions", shrunk(case).document())
    _, kept = load(tmp_path / "case.json", SUITES)
    assert len(kept.motions.at) == 1
    assert len(kept.recipe["obstacles"]) <= 1
    assert main(["stress", "--case", str(tmp_path / "case.json")]) == 1
    monkeypatch.undo()
    assert main(["stress", "--case", str(tmp_path / "case.json")]) == 0


def test_an_exception_of_a_draw_breaks_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(motion_campaign, "tree_draw", _thrown)
    found = run(campaign(4, ("tree",)), 1)
    assert found.failures == len(found.broken) == 1


def test_a_fault_without_a_draw_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    faulty = Judged(Counter(motions=1), [Fault(PROOF, -1, "what is wrong")])
    monkeypatch.setitem(motion_campaign._SPECIAL, OMPL_FAMILY, lambda rng: faulty)
    suite = campaign(4, (OMPL_FAMILY,))
    text = "\n".join(suite.lines(run(suite, 1)))
    assert "first proof refused" in text
    assert "what is wrong" in text


def test_the_command(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    few = ["stress", "--motions", "100", "--families", "turns", "--cases", str(tmp_path)]
    assert main(few) == 0
    assert "turns" in capsys.readouterr().out
    assert not list(tmp_path.iterdir())
    assert main(["stress", "--motions", "0"]) == 2
    assert main(["stress", "--motions", "10", "--families", "trees"]) == 2
    monkeypatch.setattr(SpaceSubject, "check", _all_free)
    assert main(few) == 1
    assert list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "path", sorted((Path(__file__).parent / "hard_cases" / "motions").glob("*.json")), ids=lambda path: path.stem
)
def test_motions_that_once_failed(path: Path) -> None:
    _, case = load(path, SUITES)
    assert SUITE.faults(case) == {}


def test_a_proof_up_to_the_limit_of_the_tolerance_ends():
    """With the finest tolerance, one end of an interval between neighbouring doubles is clear and the other is not."""
    path = Path(__file__).parent / "hard_cases" / "motions" / "ends-at-the-limit-of-the-tolerance.json"
    _, case = load(path, SUITES)
    subject = subject_of(case.recipe)
    found = subject.motion_result(case.motions.q0[0], case.motions.q1[0], case.tolerance, True)
    assert not found.free
    assert 0 < found.proved_until <= found.free_until < 1


def stretched_pose(rng):
    """A pose off rigid by about what chains of unit lengths may be."""
    pose = np.eye(4)
    pose[:3, :3] = Rotation.random(random_state=rng).as_matrix() + 4e-7 * rng.uniform(-1, 1, (3, 3))
    pose[:3, 3] = rng.uniform(-20, 20, 3)
    return pose


def test_contacts_on_stretched_links_are_contacts():
    """A ball's radius is not stretched with the link that it is on; a thin wall's contact is that shallow."""
    rng = np.random.default_rng(5)
    wall, touching = ["box", [1e-4, 0.5, 0.77]], 0
    for k in range(300):
        shapes = [wall, ["capsule", 0.2, 0.5]][:: 1 if k % 2 else -1]
        first, second = (extent_of(shape_of(shape)) for shape in shapes)
        pose, link = stretched_pose(rng), stretched_pose(rng)
        contact = random_contact(first, pose, shapes[1], rng, Closeness((-6.0, -6.0), 0.4, 0.2))
        if contact.touches:
            touching += 1
            bodies = [
                pc.Polytope(extent.vertices, inflation_radius=extent.inflation_radius) for extent in (first, second)
            ]
            found = certify_posed(*bodies, pose, link @ contact.pose_on(link))
            assert isinstance(found, pc.SharedPoint), (k, found)
    assert touching > 100
