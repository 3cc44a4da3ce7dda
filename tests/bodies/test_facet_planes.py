"""Facets as separating planes of two bodies of eight corners at most, against exact arithmetic and without them."""

from __future__ import annotations

import numpy as np
import pytest
from solids import solid_of

import plannercheck as pc
from plannercheck.bodies import exact_reference as exact
from plannercheck.bodies.tuning import pair_options
from plannercheck.common.core import core
from plannercheck.evaluation.stress import contact_poses as contacts

FACET_PLANE = 3  # the number of the stage in cpp/narrow_phase/pair_frame.hpp


@pytest.mark.parametrize(
    ("first", "second", "inflation_radius"), [(4, 4, 0), (4, 8, 0), (8, 8, 0), (6, 5, 0), (8, 8, 0.1), ("box", 8, 0)]
)
def test_facets_of_small_bodies(first, second, inflation_radius):
    """They separate most that touch nearly; the same verdicts without them, in both orders, on stretched poses, too."""
    (solid_p, P), (solid_r, R) = (
        solid_of("box" if n == "box" else "round", 8 if n == "box" else n, seed)
        for n, seed in ((first, 41), (second, 42))
    )
    P = pc.Polytope(P.vertices, inflation_radius=inflation_radius)
    gaps = np.tile(inflation_radius + np.array([0.1, 1e-3, 1e-6, 1e-12, 0, -1e-12, -1e-3, -0.1]), 40)
    poses_p, poses_r = contacts.contact_poses(solid_p, solid_r, gaps, np.random.default_rng(43))
    poses_p, poses_r = (np.array(np.broadcast_to(poses, (len(gaps), 4, 4))) for poses in (poses_p, poses_r))
    poses_p[::3, :3, :3] *= 1 + 2.5e-7
    poses_r[1::3, 0, :3] *= 1 - 4e-7
    truth = [
        exact.intersects(P.vertices, R.vertices, p, r, inflation_radius) for p, r in zip(poses_p, poses_r, strict=True)
    ]
    for a, b, pa, pb in ((P, R, poses_p, poses_r), (R, P, poses_r, poses_p)):
        for on in (True, False):
            options = pair_options(cached_plane=False, facet_plane=on)
            shared, stages, _ = core.intersect_batch(a.core, pa, b.core, pb, options)
            assert shared.astype(bool).tolist() == truth
            assert (stages == FACET_PLANE).any() == on
        kept, _, _ = core.intersect_batch(a.core, pa, b.core, pb, pair_options())  # planes for the poses that follow
        assert kept.astype(bool).tolist() == truth
        for pose_a, pose_b in zip(pa[:60], pb[:60], strict=True):
            assert pc.certify(a, b, pose_a, pose_b).verify()
