"""The same pair through space, any dimension and, for prisms over polygons, the plane: always the same verdict.

Prisms stand on z = 0 and 1, so two of them at poses that turn about z share a point if and only if their polygons do.
Most pairs are near contact, up to rounding; some touch exactly.
"""

from collections import Counter

import numpy as np
import planar_cases as cases
import pytest
from ndim_pairs import near_poses, random_body, random_pose

import plannercheck as pc
from plannercheck import ndim, planar

PAIRS = 120


def prism(polygon, low=0.0, high=1.0):
    return np.concatenate([np.column_stack([polygon, np.full(len(polygon), z)]) for z in (low, high)])


def lifted(pose):
    """A pose in the plane as one in space."""
    matrix = np.eye(4)
    matrix[:2, :2], matrix[:2, 3] = pose[:2, :2], pose[:2, 2]
    return matrix


def in_space_and_any_dimension(p, r, pose_p, pose_r):
    """The verdict of both modules, in both orders, by trees and by the oracle; they must agree."""
    bodies, polytopes = (pc.Polytope(p), pc.Polytope(r)), (ndim.Polytope(p), ndim.Polytope(r))
    verdicts = [
        pc.intersects(*bodies, pose_p, pose_r),
        pc.intersects(*bodies[::-1], pose_r, pose_p),
        pc.certify(*bodies, pose_p, pose_r).verify()
        and isinstance(pc.certify(*bodies, pose_p, pose_r), pc.SharedPoint),
        ndim.intersects(*polytopes, pose_p, pose_r, method="tree"),
        ndim.intersects(*polytopes[::-1], pose_r, pose_p),
    ]
    assert len(set(verdicts)) == 1
    return verdicts[0]


@pytest.mark.parametrize(
    "make", [cases.near_pair, cases.exact_contact, cases.nested_pair, lambda rng: cases.random_pair(rng, cases.ROUND)]
)
def test_prisms_and_their_polygons(make):
    rng = np.random.default_rng(0)
    shared = 0
    for _ in range(PAIRS // 2):
        a, b, pose_a, pose_b = make(rng)
        verdict = planar.intersects(a, b, pose_a, pose_b)
        assert in_space_and_any_dimension(prism(a), prism(b), lifted(pose_a), lifted(pose_b)) == verdict
        shared += verdict
    assert shared > 0


def test_prisms_that_touch_with_their_ends():
    """Stacked prisms share a point if and only if their polygons do; the next double above, none."""
    rng = np.random.default_rng(1)
    verdicts = Counter()
    for _ in range(PAIRS // 4):
        a, b, pose_a, pose_b = cases.near_pair(rng)
        verdict = planar.intersects(a, b, pose_a, pose_b)
        poses = lifted(pose_a), lifted(pose_b)
        assert in_space_and_any_dimension(prism(a), prism(b, 1.0, 2.0), *poses) == verdict
        above = prism(b, np.nextafter(1.0, 2.0), 2.0)
        assert not in_space_and_any_dimension(prism(a), above, *poses)
        verdicts[verdict] += 1
    assert min(verdicts[True], verdicts[False]) > 5


def test_bodies_in_space():
    rng = np.random.default_rng(2)
    verdicts = Counter()
    while verdicts.total() < PAIRS:
        first, second = (random_body(rng, 3, most=30, kinds=("points",)) for _ in range(2))
        for near in (True, False):
            poses = near_poses(rng, first, second, 3) if near else [random_pose(rng, 3, far) for far in (0.0, 1.5)]
            matrices = []
            for matrix, shift in poses:
                pose = np.eye(4)
                pose[:3, :3] = matrix if np.linalg.det(matrix) > 0 else matrix[:, [1, 0, 2]]
                pose[:3, 3] = shift
                matrices.append(pose)
            verdicts[in_space_and_any_dimension(first.points, second.points, *matrices)] += 1
    assert min(verdicts[True], verdicts[False]) > PAIRS // 5
