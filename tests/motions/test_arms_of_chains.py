"""Bounds of motions are made of the arms of chains: one that is no number is refused where the core takes it."""

from types import SimpleNamespace

import numpy as np
import pytest

import plannercheck as pc
from plannercheck.common.core import core
from plannercheck.motions import certifier_pairs

_ARMS = 8  # its place among the arguments of core.MotionCertifier


@pytest.mark.parametrize("arm", [np.nan, -1.0, -np.inf])
def test_an_arm_that_is_no_length_is_refused(monkeypatch, arm):
    def made(*arguments):
        given = list(arguments)
        given[_ARMS] = np.where(np.arange(len(given[_ARMS])) == len(given[_ARMS]) // 2, arm, given[_ARMS])
        return core.MotionCertifier(*given)

    monkeypatch.setattr(certifier_pairs, "core", SimpleNamespace(MotionCertifier=made))
    checker = pc.Checker(pc.Robot.load("ur5"), pc.Scene.load("table"))
    q = np.zeros(6)
    with pytest.raises(ValueError, match="an arm of a chain is no length"):
        checker.check_motion(q, q + 0.1)
