"""All ways to decide a pair, pairs of body families, and gaps near contact.

In: two bodies and their poses. Out: verdicts in which all methods, switches and orders agree with exact arithmetic.
"""

import itertools

import exact_verdicts
import numpy as np

from plannercheck.bodies.tuning import METHODS, pair_options
from plannercheck.common.core import core
from plannercheck.evaluation.stress.body_families import MESHES

# All ways to decide a pair; the first is the default.
WAYS = list(itertools.product(METHODS, (True, False), (True, False)))
NEAR = (1e-1, 1e-3, 1e-6, 1e-9, 1e-12, 1e-14, 1e-15, 1e-16, 0.0, -1e-16, -1e-15, -1e-13, -1e-9, -1e-4, -1e-1)

# Numbers of stages in cpp/narrow_phase/pair_frame.hpp.
CENTRE_AXIS, SOLVER, NEAREST_POINTS, DOUBLE_DOUBLE, EXACT = 2, 3, 4, 5, 6
UNIT = np.array(list(itertools.product((0.0, 1.0), repeat=3)))


def assert_all_ways_agree(first, second, poses_p, poses_r):
    """All methods and switches, in both orders, against the oracle; returns the verdicts."""
    truth = np.array(
        [
            exact_verdicts.intersects(first.vertices, second.vertices, p, r)
            for p, r in zip(poses_p, poses_r, strict=True)
        ]
    )
    poses_p, poses_r = np.ascontiguousarray(poses_p), np.ascontiguousarray(poses_r)
    for way in WAYS:
        options = pair_options(way[0], cached_plane=way[1], centre_axis=way[2])
        shared, _, _ = core.intersect_batch(first.core, poses_p, second.core, poses_r, options)
        np.testing.assert_array_equal(shared.astype(bool), truth, err_msg=f"{way}")
        shared, _, _ = core.intersect_batch(second.core, poses_r, first.core, poses_p, options)
        np.testing.assert_array_equal(shared.astype(bool), truth, err_msg=f"{way} swapped")
    return truth


PAIRS = [
    ("box", "box", 8),
    ("box", "round", 80),
    ("round", "round", 30),
    ("round", "cloud", 200),
    ("flat", "needle", 40),
    ("flat", "flat", 100),
    ("prism", "cone", 60),
    ("fan", "doubling", 100),
    ("lattice", "lattice", 60),
    (MESHES[0], MESHES[2], 0),
    (MESHES[3], "box", 8),
]
