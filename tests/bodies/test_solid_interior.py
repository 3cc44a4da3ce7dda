"""Balls and boxes inside of solids are inside: no triangle meets them, and the solid winds around them."""

import numpy as np
import pytest
from poses import random_pose
from solid_meshes import at, box, meshes, prepared, ring, winding

from plannercheck.common.core import core

CLOSED = ("box", "ring", "fine ring", "hollow box", "nested boxes", "box beside a ring")
IDENTITY = np.eye(4)


def shapes(mesh):
    return prepared(mesh).inner_shapes()


def distances(points, mesh):
    """(n,) of points from all triangles; along each triangle's plane and edges."""
    out = np.full(len(points), np.inf)
    for a, b, c in at(mesh, IDENTITY):
        normal = np.cross(b - a, c - a)
        normal /= np.linalg.norm(normal)
        height = (points - a) @ normal
        foot = points - height[:, None] * normal
        sides = [np.cross(q - p, foot - p) @ normal for p, q in ((a, b), (b, c), (c, a))]
        over = np.all([s >= 0 for s in sides], axis=0)
        out = np.where(over, np.minimum(out, np.abs(height)), out)
        for p, q in ((a, b), (b, c), (c, a)):
            along = np.clip((points - p) @ (q - p) / ((q - p) @ (q - p)), 0, 1)
            out = np.minimum(out, np.linalg.norm(points - p - along[:, None] * (q - p), axis=1))
    return out


@pytest.mark.parametrize("name", CLOSED)
@pytest.mark.parametrize("is_inverted", [False, True])
def test_balls_touch_no_triangle_and_are_wound_around(name, is_inverted):
    mesh = meshes()[name]
    mesh = (mesh[0], mesh[1][:, ::-1]) if is_inverted else mesh
    balls, _ = shapes(mesh)
    assert len(balls) > 0
    assert (distances(balls[:, :3], mesh) >= balls[:, 3]).all()
    assert all(winding(ball[:3], mesh, IDENTITY) != 0 for ball in balls)
    # The largest one is not much smaller than what fits: half of the thickness, less what a few steps leave.
    thickness = {"ring": 0.3, "fine ring": 0.2, "hollow box": 0.2, "box": 1.0}.get(name)
    assert thickness is None or balls[:, 3].max() > 0.6 * thickness * np.cos(np.pi / 5)


@pytest.mark.parametrize("name", CLOSED)
def test_boxes_touch_no_triangle_and_are_wound_around(name):
    mesh = meshes()[name]
    _, boxes = shapes(mesh)
    (found,) = boxes
    low, high, radius = found[:3], found[3:6], found[6]
    assert winding((low + high) / 2, mesh, IDENTITY) != 0
    parts = np.stack(np.meshgrid(*[np.linspace(0, 1, 7)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    assert (distances(low + parts * (high - low), mesh) >= radius).all()
    # Neither does any triangle pass through it: its corners and some of its points keep away.
    weights = np.random.default_rng(0).dirichlet(np.ones(3), size=50)
    points = (weights @ at(mesh, IDENTITY)).reshape(-1, 3)
    beyond = np.maximum(np.maximum(low - points, points - high), 0)
    assert (np.linalg.norm(beyond, axis=1) >= radius).all()


@pytest.mark.parametrize("name", ["open box", "one triangle"])
def test_what_encloses_nothing_has_no_inside(name):
    balls, boxes = shapes(meshes()[name])
    assert len(balls) == 0
    assert len(boxes) == 0


def test_a_solid_that_winds_around_nothing_has_no_inside():
    """Every triangle is there twice, turned both ways."""
    points, triangles = box()
    balls, _ = shapes((points, np.concatenate([triangles, triangles[:, ::-1]])))
    assert len(balls) == 0


def test_a_hollow_is_no_inside():
    """Of a box in which a smaller one is left out, and of a ball's shape with its inside to the outside."""
    points, triangles = meshes()["hollow box"]
    balls, boxes = shapes((points, triangles))
    assert (np.abs(balls[:, :3]).max(axis=1) - balls[:, 3] >= 0).all()
    assert not (np.abs(balls[:, :3]).max(axis=1) < 0.6).any()
    assert np.abs(boxes[0, :6]).max() > 0.6


@pytest.mark.parametrize("scale", [1e-30, 1e-6, 1e6, 1e30])
def test_insides_scale(scale):
    points, triangles = ring(12, 6, 0.3)
    balls, _ = shapes((scale * points, triangles))
    assert (distances(balls[:, :3] / scale, (points, triangles)) >= balls[:, 3] / scale * (1 - 1e-9)).all()
    assert balls[:, 3].max() > 0.15 * scale


def test_overlaps_of_insides_are_contacts():
    """A ball in one solid that meets the box in another: the solids share a point."""
    rng = np.random.default_rng(3)
    every = meshes()
    met = 0
    for first in CLOSED:
        for second in CLOSED:
            one, two = prepared(every[first]), prepared(every[second])
            balls, _ = one.inner_shapes()
            _, boxes = two.inner_shapes()
            for _ in range(15):
                a, b = random_pose(rng, 0.4), random_pose(rng, 0.4)
                centres = (balls[:, :3] @ a[:3, :3].T + a[:3, 3] - b[:3, 3]) @ b[:3, :3]
                beyond = np.maximum(np.maximum(boxes[0, :3] - centres, centres - boxes[0, 3:6]), 0)
                gap = np.linalg.norm(beyond, axis=1) - balls[:, 3] - boxes[0, 6]
                if (gap < -1e-9).any():
                    met += 1
                    assert core.solids_contact(one, a, two, b)[0] != "apart"
    assert met > 50
