"""Contacts by construction against the bounds of the filters in n dimensions: what doubles prove, integers confirm.

Gaps are 0 or about the last double, near the origin and far from it, for bodies of points, of halfspaces, and of both.
"""

import numpy as np
import pytest
from ndim_pairs import near_poses, random_body

from plannercheck import ndim

KINDS = [("points", "points"), ("points", "halfspaces"), ("halfspaces", "points"), ("halfspaces", "halfspaces")]

# Integers take longer for halfspaces.
_COUNTS = dict(zip(KINDS, (100, 30, 30, 12), strict=True))


def moved(pose, by):
    matrix, shift = pose
    return matrix, shift + by


@pytest.mark.parametrize("kinds", KINDS, ids="-".join)
@pytest.mark.parametrize("d", [2, 3, 4])
def test_contacts_on_the_last_double(d, kinds, monkeypatch):
    monkeypatch.setattr("ndim_pairs.NEAR_GAPS", (0.0, 1e-16, -1e-16, 2e-16, -2e-16, 1e-15, -1e-15))
    rng = np.random.default_rng(100 * d + len("".join(kinds)))
    verdicts = []
    for number in range(_COUNTS[kinds]):
        first, second = (random_body(rng, d, most=6, kinds=(kind,)) for kind in kinds)
        poses = near_poses(rng, first, second, d)
        if number % 2:
            far = 10.0 ** rng.integers(0, 7) * rng.normal(size=d)
            poses = moved(poses[0], far), moved(poses[1], far)
        truth = ndim.intersects(first.polytope, second.polytope, *poses, method="exact")
        assert ndim.intersects(first.polytope, second.polytope, *poses) == truth, number
        assert ndim.intersects(second.polytope, first.polytope, *poses[::-1]) == truth, number
        verdicts.append(truth)
    assert 0.1 < np.mean(verdicts) < 0.9
