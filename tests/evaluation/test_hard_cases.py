"""Cases that once failed, kept by name: every one is decided as exact arithmetic decides it."""

from pathlib import Path

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.bodies import exact_reference as exact
from plannercheck.bodies.tuning import METHODS
from plannercheck.evaluation.campaign.cases import load, save
from plannercheck.evaluation.campaign.pairs import PairCase
from plannercheck.evaluation.stress.campaign import campaign
from plannercheck.evaluation.stress.sample_bodies import Specimen

HARD = Path(__file__).parent / "hard_cases"
CASES = sorted(HARD.glob("*.json"))
SUITES = {"pairs": lambda: campaign(0)}


@pytest.mark.parametrize("path", CASES, ids=[path.stem for path in CASES])
def test_kept_case(path: Path) -> None:
    suite, case = load(path, SUITES)
    p, r, pose_p, pose_r = case.p, case.r, case.pose_p, case.pose_r
    truth = exact.intersects(p.points, r.points, pose_p, pose_r, p.inflation_radius, r.inflation_radius)
    first, second = (pc.Polytope(body.points, inflation_radius=body.inflation_radius) for body in (p, r))
    assert (first.fault(), second.fault()) == ("", "")
    for method in METHODS:
        assert pc.intersects(first, second, pose_p, pose_r, method=method) == truth
        assert pc.intersects(second, first, pose_r, pose_p, method=method) == truth
    assert suite.faults(case) == {}


def test_a_case_keeps_every_bit(tmp_path: Path) -> None:
    rng = np.random.default_rng(8)
    p, r = (Specimen("a body", rng.normal(size=(k, 3)), k / 3) for k in (4, 5))
    case = PairCase("a name", p, r, *rng.normal(size=(2, 4, 4)))
    save(tmp_path / "case.json", "pairs", case.document())
    _, loaded = load(tmp_path / "case.json", SUITES)
    assert loaded.name == case.name
    for body, same in ((p, loaded.p), (r, loaded.r)):
        assert body.inflation_radius == same.inflation_radius
        np.testing.assert_array_equal(body.points, same.points)
    np.testing.assert_array_equal([case.pose_p, case.pose_r], [loaded.pose_p, loaded.pose_r])
