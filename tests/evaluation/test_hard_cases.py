"""Cases that once failed, kept by name: every one is decided as exact arithmetic decides it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.bodies import exact_reference as exact
from plannercheck.bodies.tuning import METHODS
from plannercheck.evaluation.stress.failing_cases import Case

HARD = Path(__file__).parent / "hard_cases"
CASES = sorted(HARD.glob("*.json"))


@pytest.mark.parametrize("path", CASES, ids=[path.stem for path in CASES])
def test_kept_case(path: Path) -> None:
    case = Case.load(path)
    p, r, pose_p, pose_r = case.bodies
    truth = exact.intersects(*case.bodies, *case.inflation_radii)
    first, second = (
        pc.Polytope(p, inflation_radius=case.inflation_radii[0]),
        pc.Polytope(r, inflation_radius=case.inflation_radii[1]),
    )
    assert (first.fault(), second.fault()) == ("", "")
    for method in METHODS:
        assert pc.intersects(first, second, pose_p, pose_r, method=method) == truth
        assert pc.intersects(second, first, pose_r, pose_p, method=method) == truth


def test_a_case_keeps_every_bit(tmp_path: Path) -> None:
    rng = np.random.default_rng(8)
    shapes = ((4, 3), (5, 3), (4, 4), (4, 4))
    case = Case("a name", tuple(rng.normal(size=shape) for shape in shapes))  # type: ignore[arg-type]
    case.save(tmp_path / "case.json")
    loaded = Case.load(tmp_path / "case.json")
    assert loaded.name == case.name
    for array, same in zip(case.bodies, loaded.bodies, strict=True):
        np.testing.assert_array_equal(array, same)
