"""Verdicts where products of lengths underflow, or differences of floats overflow."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import plannercheck as pc
from plannercheck import exact
from plannercheck.core import core
from plannercheck.pair import pair_options
from plannercheck.stress import contacts

UNIT = np.array(list(itertools.product((0.0, 1.0), repeat=3)))


@pytest.mark.parametrize("scale", [1e-150, 1e-159, 5e-161, 5e-162, 3e-162, 2e-162, 1e-170, 1e-308])
@pytest.mark.parametrize("swell", [0.0, 0.4])
def test_lengths_whose_squares_underflow(scale, swell):
    """A review found that balls and axes took sums of products that had become 0 for distances."""
    cube, corner = 0.433 * (UNIT - 0.5) * scale, 0.433 * np.vstack([np.zeros(3), np.eye(3)]) * scale
    P, R = pc.Polytope(cube), pc.Polytope(np.zeros((1, 3)) if swell > 0 else corner, swell=swell * scale)
    offsets = 0.7 * np.random.default_rng(44).uniform(-1, 1, size=(60, 3))
    offsets[0] = 0.8248, 0.2086, 0.1484
    poses = contacts.identities(60)
    poses[:, :3, 3] = offsets * scale
    truth = [exact.intersects(P.vertices, R.vertices, pose, np.eye(4), 0.0, R.swell) for pose in poses]
    assert 0 < sum(truth) < 60
    for options in (pair_options(), pair_options(cached_plane=False), pair_options(centre_axis=False)):
        shared, _, _ = core.intersect_batch(P.core, poses, R.core, np.eye(4)[None], options)
        assert shared.astype(bool).tolist() == truth


@pytest.mark.parametrize("exponent", [30, 37, 38, 39, 45])
def test_boxes_whose_differences_overflow_floats(exponent):
    """Found by a review: infinity times a cosine of 6e-17 is no distance."""
    scale = 10.0**exponent
    body = pc.Polytope((UNIT - 0.5) * np.array([5, 0.2, 0.2]) * scale).core
    pose, placements = np.eye(4), np.repeat(np.eye(4)[None], 2, axis=0)
    pose[:2, :2] = [[1, -6e-17], [6e-17, 1]]
    pose[0, 3], placements[1, 0, 3] = 2 * scale, -2 * scale
    links, pairs, nothing = np.array([0, -1], dtype=np.int32), np.array([[0, 1]], dtype=np.int32), np.zeros(0)
    for bounds, boxes in itertools.product((True, False), (True, False)):
        switches = bounds, boxes, True, True
        checker = core.Checker(
            [body, body], links, placements, pairs, 1, nothing, nothing, pair_options(), *switches, pose[None, None]
        )
        found = checker.first_of_poses(np.repeat(pose[None, None], 8, axis=0), 1)
        assert found.tolist() == [0] * 8


@pytest.mark.parametrize("exponent", [37, 38, 39, 45])
@pytest.mark.parametrize("first", [0, 1])
def test_what_is_beyond_floats_may_be_anywhere(exponent, first):
    """Two bodies of one link are tested together against an obstacle: one is here, the other, which meets it, far."""
    scale = 10.0**exponent
    large, small = (pc.Polytope((UNIT - 0.5) * size).core for size in (scale, 1.0))
    bodies = [large, small, large] if first == 0 else [small, large, large]
    placements = np.repeat(np.eye(4)[None], 3, axis=0)
    placements[[first, 2], 0, 3] = 3 * scale, 3.5 * scale
    links = np.array([0, 0, -1], dtype=np.int32)
    pairs = np.array([[0, 2], [1, 2]], dtype=np.int32)
    pose, nothing = np.eye(4)[None, None], np.zeros(0)
    checker = core.Checker(
        bodies, links, placements, pairs, 1, nothing, nothing, pair_options(), True, True, True, True, pose
    )
    assert checker.first_of_poses(np.repeat(pose, 8, axis=0), 1).tolist() == [first] * 8


@pytest.mark.parametrize("method", ["exact", "oracle"])
def test_denormal_and_normal_numbers_add_up(method):
    """A box ends at the smallest normal double and a denormal one; another begins there, posed by the normal one."""
    normal, last = 2.0**-1022, 2.0**-1074
    first = pc.Polytope(UNIT * (normal + 64 * last))
    for steps, shared in ((63, True), (64, True), (65, False), (96, False)):
        second = pc.Polytope(steps * last + UNIT * normal)
        pose = np.eye(4)
        pose[:3, 3] = normal
        assert exact.intersects(first.vertices, second.vertices, np.eye(4), pose) == shared
        assert pc.intersects(first, second, None, pose, method) == shared
        assert pc.intersects(second, first, pose, None, method) == shared
