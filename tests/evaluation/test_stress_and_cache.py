"""Stress runs leave the cache of prepared bodies alone: they write nothing into it, and it is on again after them."""

import os

import pytest

from plannercheck.common.cache import cache_folder
from plannercheck.evaluation.campaign.campaign import run
from plannercheck.evaluation.stress_motions import campaign as motions
from plannercheck.evaluation.stress_parts import campaign as parts
from plannercheck.evaluation.stress_solids import campaign as solids

RUNS = {
    "motions": lambda: run(motions.campaign(4, ("shipped",)), 10),  # others have too few points to be kept
    "parts": lambda: run(parts.campaign(9), 100),
    "solids": lambda: run(solids.campaign(9), 100),
}


@pytest.mark.parametrize("kind", RUNS)
def test_bodies_of_one_use_are_not_kept(kind, tmp_path, monkeypatch):
    monkeypatch.setenv("PLANNERCHECK_CACHE", str(tmp_path / "cache"))
    RUNS[kind]()
    assert not (tmp_path / "cache").exists()
    assert os.environ["PLANNERCHECK_CACHE"] == str(tmp_path / "cache")
    assert cache_folder() == tmp_path / "cache"
