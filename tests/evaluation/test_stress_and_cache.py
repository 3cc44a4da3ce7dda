"""Stress runs leave the cache of prepared bodies alone: they write nothing into it, and it is on again after them."""

import os

import pytest

from plannercheck.common.cache import cache_folder
from plannercheck.evaluation.stress_motions import run as motions
from plannercheck.evaluation.stress_parts import run as parts
from plannercheck.evaluation.stress_solids import run as solids

RUNS = {
    "motions": lambda: motions.run(10, seed=4, families=("shipped",)),  # others have too few points to be kept
    "parts": lambda: parts.run(100, seed=9),
    "solids": lambda: solids.run(100, seed=9),
}


@pytest.mark.parametrize("kind", RUNS)
def test_bodies_of_one_use_are_not_kept(kind, tmp_path, monkeypatch):
    monkeypatch.setenv("PLANNERCHECK_CACHE", str(tmp_path / "cache"))
    RUNS[kind]()
    assert not (tmp_path / "cache").exists()
    assert os.environ["PLANNERCHECK_CACHE"] == str(tmp_path / "cache")
    assert cache_folder() == tmp_path / "cache"
