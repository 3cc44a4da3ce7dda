"""Fixtures of several modules."""

from __future__ import annotations

import pytest
from sample_robots import SRDF, URDF


@pytest.fixture
def arm(tmp_path):
    """Paths of a small URDF and its SRDF."""
    (tmp_path / "arm.urdf").write_text(URDF)
    (tmp_path / "arm.srdf").write_text(SRDF)
    return tmp_path / "arm.urdf", tmp_path / "arm.srdf"
