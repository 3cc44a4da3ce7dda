"""The default solver has 48 rounds; the walk decides what it leaves: held against the walk, and against the gap."""

import numpy as np

import plannercheck as pc
from plannercheck.bodies.tuning import pair_options
from plannercheck.common.core import core
from plannercheck.evaluation.stress.body_families import rim_points
from plannercheck.evaluation.stress.contact_poses import Solid, contact_poses

ORACLE_ROUNDS = 48  # kOracleRounds in double_oracle.cpp
GAPS = np.array([1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 0.0, -1e-12, -1e-9, -1e-6, -1e-3])


def barrel(seed: int) -> np.ndarray:
    """40,000 vertices on rings, whose facets turn by little from one to the next (tests/benchmarks/worst_pairs.py)."""
    heights, rim = np.linspace(-0.5, 0.5, 50), rim_points(800, 0.37 * seed)
    return np.concatenate([np.column_stack([0.3 * (1 - 1e-4 * z * z) * rim, np.full(len(rim), z)]) for z in heights])


def test_pairs_that_use_up_their_rounds_end_in_the_walk():
    bodies = [pc.Polytope(barrel(seed)) for seed in (1, 2)]
    solids = [Solid("barrel", body.vertices, body.faces.astype(np.int64)) for body in bodies]
    gaps = np.resize(GAPS, 60) * min(solid.size for solid in solids)
    posed = contact_poses(*solids, gaps, np.random.default_rng(40000))
    rounds = []
    for a, b, gap in zip(*posed, gaps, strict=True):
        found = {
            method: core.intersect_batch(
                bodies[0].core, a[None], bodies[1].core, b[None], pair_options(method, cached_plane=False)
            )
            for method in ("oracle", "walk")
        }
        rounds.append(found["oracle"][2]["rounds"])
        assert found["oracle"][0][0] == found["walk"][0][0]
        if abs(gap) > 1e-10:
            assert found["oracle"][0][0] == (gap < 0)
    assert ORACLE_ROUNDS < max(rounds) < 2 * ORACLE_ROUNDS
