"""Fixtures of the tests of `plannercheck bench`."""

import pytest

from plannercheck.evaluation.bench import timing


@pytest.fixture
def hasty(monkeypatch):
    """Figures that nobody reads: work is repeated only until the clock has moved."""
    monkeypatch.setattr(timing, "_SHORTEST", 1e-5)
    monkeypatch.setattr(timing, "_LEAST_ROUND", 0.0)
