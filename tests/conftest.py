"""Fixtures of several modules."""

from __future__ import annotations

import gc

import pytest
from sample_robots import SRDF, URDF


def pytest_collection_finish():
    """Tests live until the end. Garbage collection, which benchmarks ask for often, need not go through all of them."""
    gc.collect()
    gc.freeze()


@pytest.fixture
def arm(tmp_path):
    """Paths of a small URDF and its SRDF."""
    (tmp_path / "arm.urdf").write_text(URDF)
    (tmp_path / "arm.srdf").write_text(SRDF)
    return tmp_path / "arm.urdf", tmp_path / "arm.srdf"
