"""Samples of one body inside of the balls and the box in another one: they tell early, and change no verdict."""

from itertools import product

import numpy as np
import pytest
from poses import random_pose
from solid_meshes import box, inflated, meshes, prepared

from plannercheck.bodies.tuning import pair_options
from plannercheck.common.core import core

# How far poses are off rigid, a little less than they may be.
OFF_RIGID = 3.4e-6


def with_shapes(body):
    """Known to the core from now on, as they are to a checker's bodies."""
    body.inner_shapes()
    return body


def told(p, poses, r, still, trees_first=True):
    return core.intersect_batch(p, poses, r, still, pair_options(trees_first=trees_first))[0].astype(bool)


@pytest.mark.parametrize("radius", [0.0, 0.05])
def test_samples_change_no_verdict_of_batches(radius):
    rng = np.random.default_rng(3)
    every, colliding = meshes(), 0
    hull = core.Polytope.from_points(np.ascontiguousarray(box(0.7)[0]), radius)
    for first, second in product(("fine ring", "nested boxes", "hollow box", "small box", "open box"), repeat=2):
        p = with_shapes(inflated(every[first], radius))
        for r in (with_shapes(prepared(every[second])), with_shapes(hull)):
            poses = np.stack([random_pose(rng, spread) for spread in (0.4, 1.2, 3.0) for _ in range(40)])
            still = np.broadcast_to(random_pose(rng, 0.3), poses.shape).copy()
            found = told(p, poses, r, still)
            assert np.array_equal(found, told(p, poses, r, still, trees_first=False))
            assert np.array_equal(found, told(r, still, p, poses))
            colliding += found.sum()
    assert colliding > 500


@pytest.mark.parametrize("sign", [-1, 1])
@pytest.mark.parametrize("gap", [1e-7, 1e-9, 0.0, -1e-9, -1e-7])
def test_samples_near_the_face_of_a_box_whose_pose_is_hardly_rigid(gap, sign):
    """A corner above the middle of a face, by less than what the pose is off rigid."""
    scale = 1 + sign * OFF_RIGID / 2
    points, _ = box()
    tip = np.array([[0.0, 0.0, 0.0], [0.3, 0.0, 1.0], [-0.3, 0.2, 1.0], [-0.3, -0.2, 1.0]])
    sides = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
    hull, solid = core.Polytope.from_points(np.ascontiguousarray(points), 0.0), prepared((tip, sides))
    pose_of_box, pose = np.diag([scale, scale, scale, 1.0]), np.eye(4)
    pose[2, 3] = scale + gap
    found = [
        told(p, pose[None], r, pose_of_box[None])[0]
        for p, r in ((solid, hull), (with_shapes(solid), with_shapes(hull)))
    ]
    assert found == [gap <= 0, gap <= 0]


@pytest.mark.parametrize("gap", [1e-7, -1e-7])
def test_inflation_radii_are_of_the_world(gap):
    """Two corners of boxes one above the other, whose radii are the gap between them."""
    radius, scale = 0.25, 1 - OFF_RIGID / 2
    hull = with_shapes(core.Polytope.from_points(np.ascontiguousarray(box()[0]), radius))
    solid = with_shapes(inflated(box(0.2), radius))
    pose_of_box, pose = np.diag([scale, scale, scale, 1.0]), np.eye(4)
    pose[2, 3] = scale + 2 * radius + 0.2 + gap
    assert told(solid, pose[None], hull, pose_of_box[None])[0] == (gap < 0)
