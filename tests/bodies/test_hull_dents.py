"""Solids that are nearly their hulls: how deep their dents are, and that verdicts do not depend on what that saves."""

import numpy as np
import pytest
from poses import random_pose
from solid_meshes import both, box, dimpled, inflated, meshes, prepared, ring

import plannercheck as pc
from plannercheck.bodies.tuning import pair_options
from plannercheck.common.core import core
from plannercheck.evaluation.stress_solids.bodies import DENTED, decided
from plannercheck.evaluation.stress_solids.draws import dented_draw
from plannercheck.evaluation.stress_solids.surfaces import ball

STILL = np.eye(4)


@pytest.mark.parametrize("scale", [1e-30, 1e-6, 1.0, 1e6, 1e30])
@pytest.mark.parametrize("depth", [1e-13, 1e-6, 0.01, 0.06])
def test_the_deepest_dent_counts_by_its_part_of_the_height(depth, scale):
    mesh = dimpled(depth, scale)
    assert pc.Solid(*mesh).is_closed
    for points, triangles in (mesh, (mesh[0], mesh[1][:, ::-1])):
        assert prepared((points, triangles)).dent == pytest.approx(depth, rel=1e-6, abs=1e-13)


def test_what_is_no_shallow_dent_is_not_known():
    points, triangles = dimpled(0.01)
    everywhere_twice = points, np.vstack([triangles, triangles[:, ::-1]])
    flat = points * [1, 1, 0], triangles
    for mesh in (
        dimpled(0.07),
        (points, triangles[1:]),  # open
        everywhere_twice,  # wound around nowhere
        both((points, triangles), box(0.01)),
        both((points, triangles), box(0.01), flipped=True),
        both((points, triangles), (0.98 * points, triangles), flipped=True),  # a shell as thin as dents are
        flat,
        *(meshes()[name] for name in ("ring", "hollow box", "nested boxes", "open box", "one triangle")),
    ):
        assert prepared(mesh).dent == np.inf
    assert core.Polytope.from_points(np.ascontiguousarray(points), 0.0).dent == 0
    assert prepared(box()).dent < 1e-14


@pytest.mark.parametrize("seed", range(8))
def test_the_hull_less_its_dents_is_inside(seed):
    rng = np.random.default_rng(seed)
    found = ball(2000)
    pushed = found.points * (1 - 0.03 * rng.random((len(found.points), 1)))
    points = pushed * rng.uniform(0.2, 2, 3) + rng.normal(size=3)
    body, solid = prepared((points, found.triangles)), pc.Solid(points, found.triangles)
    assert 1e-3 < body.dent < 0.04
    centre = body.centre()[0]
    mixed = (
        rng.dirichlet(np.ones(3), 300)[:, :, None] * body.vertices()[rng.integers(len(body.vertices()), size=(300, 3))]
    )
    for point in np.vstack([body.vertices(), mixed.sum(axis=1)]):
        assert solid.core.contains(centre + (1 - body.dent) * (point - centre))
    balls, boxes = body.inner_shapes()
    for middle in (balls[0, :3], (boxes[0, :3] + boxes[0, 3:6]) / 2):
        assert solid.core.contains(np.ascontiguousarray(middle))


def test_inner_balls_and_boxes_are_past_the_dents():
    """A dish whose dimple comes down to where the largest ball and box of its hull would reach."""
    mesh = dimpled(0.05)
    balls, boxes = prepared(mesh).inner_shapes()
    solid = pc.Solid(*mesh)
    towards = np.vstack([np.eye(3), -np.eye(3)])
    for *centre, radius in balls:
        assert all(solid.core.contains(np.array(centre) + radius * way) for way in towards)
    low, high, rounding = boxes[0, :3], boxes[0, 3:6], boxes[0, 6]
    tops = [
        [x, y, high[2] + rounding] for x in np.linspace(low[0], high[0], 9) for y in np.linspace(low[1], high[1], 9)
    ]
    assert all(solid.core.contains(np.array(top)) for top in tops)
    assert high[2] + rounding > 0.5
    assert balls[:, 3].max() > 0.9


@pytest.mark.parametrize("seed", range(6))
def test_verdicts_are_the_oracles_whatever_is_switched(seed):
    """About moments of contact, in dents and beside them, at sizes of 1e-6 m to 1e6 m."""
    known = 0
    for number in range(12):
        drawn = dented_draw(DENTED, np.random.default_rng([41, seed, number]))
        truth = np.asarray(decided(drawn.p, drawn.poses_p, drawn.r, drawn.poses_r)) != 0
        p, r = drawn.p.polytope.core, drawn.r.polytope.core
        known += np.isfinite(p.dent) and np.isfinite(r.dent)
        for dents in (True, False):
            for method in ("oracle", "walk", "exact"):
                options = pair_options(method, dents=dents)
                found = core.intersect_batch(p, drawn.poses_p, r, drawn.poses_r, options)[0]
                assert np.array_equal(found.astype(bool), truth), (number, dents, method)
    assert known > 2


@pytest.mark.parametrize("depth", [1e-9, 1e-4, 0.02, 0.05])
@pytest.mark.parametrize("radius", [0.0, 0.3])
def test_a_probe_in_a_dent_is_free(depth, radius):
    """An octahedron over the middle of the dimple, from the depth of the dent up; the rounder body is the body_b."""
    tip = np.vstack([np.eye(3), -np.eye(3)])
    rng = np.random.default_rng(5)
    dish, shape = prepared(dimpled(depth)), inflated(dimpled(depth), radius)
    for size, width in ((0.003, 1.0), (0.3, 1.0), (0.3, 0.2)):
        probe = core.Polytope.from_points(size * tip * [width, width, 1], 0.0)
        for body, room in ((dish, 0.0), (shape, radius * np.hypot(1, depth))):  # the dimple's sides slope
            for gap in (-0.5, -1e-3, 1e-3, 0.5, 1.5):
                pose = random_pose(rng, 1.0)
                lifted = pose.copy()
                lifted[:3, 3] += pose[:3, :3] @ [0, 0, 1 - depth + room + size + gap * depth]
                # Beside its lowest point the dimple rises less than the octahedron does.
                expected = gap < 0
                for one, a, two, b in ((body, pose, probe, lifted), (probe, lifted, body, pose)):
                    told = {
                        bool(core.intersect_batch(one, a[None], two, b[None], pair_options(method, dents=dents))[0][0])
                        for dents in (True, False)
                        for method in ("oracle", "walk", "exact")
                    }
                    assert told == {expected}


def test_deep_pairs_are_told_by_their_hulls():
    """By the same stages and as many queries, so no triangles are looked at."""
    rng = np.random.default_rng(2)
    found = ball(300)
    middles = 0.9999 * found.points[found.triangles].mean(axis=1)
    fans = [
        [*found.triangles[k, [i, (i + 1) % 3]], len(found.points) + k] for k in range(len(middles)) for i in range(3)
    ]
    solid = prepared((np.vstack([found.points, middles]), np.array(fans)))
    hull = core.Polytope.from_points(found.points, 0.0)
    poses = np.stack([random_pose(rng, 0.4) for _ in range(50)])
    still = np.broadcast_to(STILL, poses.shape).copy()
    shared, stages, counters = core.intersect_batch(solid, poses, solid, still, pair_options(cached_plane=False))
    by_hulls = core.intersect_batch(hull, poses, hull, still, pair_options(cached_plane=False))
    assert np.array_equal(stages, by_hulls[1])
    assert counters == by_hulls[2]
    assert np.array_equal(shared, by_hulls[0])
    assert 5 < shared.sum() < 50


def test_rings_have_deep_dents():
    assert prepared(ring(9, 5, 0.3)).dent == np.inf
