"""One motion at a time, with arguments that are none: `check_motion` hands most calls to a compiled function."""

from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.common.errors import PlannercheckError


@pytest.fixture(scope="module")
def checker() -> pc.Checker:
    return pc.Checker(pc.Robot.load("ur5"))


Q = np.zeros(6)


@pytest.mark.parametrize("warm", [False, True])
@pytest.mark.parametrize("ends", [(None, Q), (Q, None), (None, None)])
def test_ends_that_are_none_are_named(warm: bool, ends: tuple[object, object]) -> None:
    checker = pc.Checker(pc.Robot.load("ur5"))
    if warm:
        assert checker.check_motion(Q, Q)
    with pytest.raises(PlannercheckError, match="must be 6 numbers, not None"):
        checker.check_motion(*ends)


@pytest.mark.parametrize(
    "tolerance", [None, "1e-4", b"1", np.array([1e-4]), np.array([1e-4, 1]), [1e-4], -1.0, 0, float("nan"), 1j]
)
def test_tolerances_that_are_none_are_named(checker: pc.Checker, tolerance: object) -> None:
    calls = (checker.check_motion, checker.explain_motion)
    for call in calls:
        with pytest.raises(PlannercheckError, match="tolerance must be a positive length in m, not"):
            call(Q, Q, tolerance=tolerance)
    with pytest.raises(PlannercheckError, match="tolerance must be a positive length in m, not"):
        checker.check_motions(Q[None], Q[None], tolerance=tolerance)


@pytest.mark.parametrize(
    "tolerance", [1e-3, np.float64(1e-3), np.float32(1e-3), np.array(1e-3), Decimal("0.001"), Fraction(1, 1000), 1]
)
def test_tolerances_of_any_kind_of_real_number(checker: pc.Checker, tolerance: float) -> None:
    ends = checker.robot.random_configurations(60, seed=1), checker.robot.random_configurations(60, seed=2)
    free = checker.check_motions(*ends, tolerance=float(tolerance))
    assert [checker.check_motion(*rows, tolerance=tolerance) for rows in zip(*ends, strict=True)] == free.tolist()


def test_lists_arrays_and_names_are_the_same_motion(checker: pc.Checker) -> None:
    ends = checker.robot.random_configurations(60, seed=3), checker.robot.random_configurations(60, seed=4)
    free = checker.check_motions(*ends).tolist()
    assert 0 < sum(free) < len(free)
    names = checker.robot.joint_names
    for form in (list, tuple, lambda row: dict(zip(names, row.tolist(), strict=True))):
        assert [checker.check_motion(form(a), form(b)) for a, b in zip(*ends, strict=True)] == free
