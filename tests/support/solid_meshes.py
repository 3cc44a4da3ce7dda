"""Meshes of solids, and brute force: all pairs of triangles, winding numbers as sums of solid angles."""

from itertools import product

import numpy as np

from plannercheck.bodies.tuning import pair_options
from plannercheck.common.core import core

# A vertex's sum of solid angles, over 4π, is this close to a whole number unless it is on a triangle.
NEAR_WHOLE = 1e-6


def ring(around, across, radius):
    """Points and triangles of a ring of radius 1 about z."""
    u, v = (each.ravel() for each in np.meshgrid(np.arange(around), np.arange(across), indexing="ij"))
    a, b = 2 * np.pi * u / around, 2 * np.pi * v / across
    reach = 1 + radius * np.cos(b)
    points = np.stack([reach * np.cos(a), reach * np.sin(a), radius * np.sin(b)], axis=-1)
    here, right = u * across + v, (u + 1) % around * across + v
    up, both = u * across + (v + 1) % across, (u + 1) % around * across + (v + 1) % across
    return points, np.concatenate([np.stack([here, right, both], 1), np.stack([here, both, up], 1)])


def box(size=1.0):
    points = size * np.array(list(product((-1.0, 1.0), repeat=3)))
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return points, np.array([t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))])


def dimpled(depth, scale=1.0, shift=0.0):
    """A cube of two metres whose upper face is pushed in at its middle."""
    points, triangles = box()
    top = np.flatnonzero((points[triangles][:, :, 2] == 1).all(axis=1))
    around = [0, 4, 6, 2]  # below; the upper face's corners are these plus one
    rim = [corner + 1 for corner in around]
    fan = np.array([[rim[k], rim[(k + 1) % 4], 8] for k in range(4)])
    points = np.vstack([points, [0, 0, 1 - depth]])
    return scale * points + shift, np.vstack([np.delete(triangles, top, axis=0), fan])


def angle():
    """An L of three metres by two, one deep: prism over six points; watertight, concave."""
    flat = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 2), (0, 2)]
    points = np.array([[x, y, z] for z in (0.0, 1.0) for x, y in flat])
    top = [(6, 7, 9), (7, 8, 9), (6, 9, 10), (6, 10, 11)]
    bottom = [(c - 6, b - 6, a - 6) for a, b, c in top]
    sides = [t for k in range(6) for j in [(k + 1) % 6] for t in ((k, j, j + 6), (k, j + 6, k + 6))]
    return points, np.array(top + bottom + sides)


def both(first, second, flipped=False):
    (p, s), (q, t) = first, second
    return np.concatenate([p, q]), np.concatenate([s, (t[:, ::-1] if flipped else t) + len(p)])


def meshes():
    return {
        "box": box(),
        "small box": box(0.1),
        "ring": ring(9, 5, 0.3),
        "fine ring": ring(14, 6, 0.2),
        "hollow box": both(box(), box(0.6), flipped=True),
        "nested boxes": both(box(), box(0.6)),
        "box beside a ring": both(ring(8, 4, 0.2), box(0.2)),
        "open box": (box()[0], box()[1][2:]),
        "one triangle": (np.array([[0, 0, 0], [1.5, 0, 0], [0, 1.2, 0.3]]), np.array([[0, 1, 2]])),
    }


def prepared(mesh, own_axes=True):
    points, triangles = (np.ascontiguousarray(each) for each in mesh)
    solid = core.Solid(points, triangles.astype(np.int32), own_axes)
    used = np.ascontiguousarray(points[np.unique(triangles)])
    return core.Polytope.from_points(used, 0.0).with_solid(solid)


def inflated(mesh, radius):
    points, triangles = (np.ascontiguousarray(each) for each in mesh)
    solid = core.Solid(points, triangles.astype(np.int32))
    return core.Polytope.from_points(np.ascontiguousarray(points[np.unique(triangles)]), radius).with_solid(solid)


def at(mesh, pose):
    points, triangles = mesh
    return (points @ pose[:3, :3].T + pose[:3, 3])[triangles]


def triangles_meet(first, a, second, b, radius=0.0):
    """Whether any triangle of one shares a point with any of the other, each tried with each."""
    options = pair_options()
    corners = at(second, b)
    low, high = corners.min(axis=1) - radius - 1e-9, corners.max(axis=1) + radius + 1e-9
    others = [core.Polytope.from_points(np.ascontiguousarray(second[0][t]), 0.0) for t in second[1]]
    for i, posed in enumerate(at(first, a)):
        near = ((posed.min(axis=0) <= high) & (posed.max(axis=0) >= low)).all(axis=1)
        p = core.Polytope.from_points(np.ascontiguousarray(first[0][first[1][i]]), radius)
        for j in np.flatnonzero(near):
            r = others[j]
            if core.intersect_batch(p, a[None].copy(), r, b[None].copy(), options)[0][0]:
                return True
    return False


def winding(point, mesh, pose):
    """The winding number of a point that is on no triangle; solid angles as Van Oosterom and Strackee give them."""
    a, b, c = np.moveaxis(at(mesh, pose) - point, 1, 0)
    x, y, z = (np.linalg.norm(each, axis=1) for each in (a, b, c))
    below = x * y * z + (a * b).sum(1) * z + (b * c).sum(1) * x + (c * a).sum(1) * y
    number = 2 * np.arctan2((a * np.cross(b, c)).sum(1), below).sum() / (4 * np.pi)
    assert abs(number - round(number)) < NEAR_WHOLE
    return round(number)


def is_inside(inner, a, outer, b):
    if not core.Solid(np.ascontiguousarray(outer[0]), np.ascontiguousarray(outer[1], dtype=np.int32)).is_closed:
        return False
    points = inner[0] @ a[:3, :3].T + a[:3, 3]
    return any(winding(points[v], outer, b) != 0 for v in np.unique(inner[1]))


def brute(first, a, second, b):
    return triangles_meet(first, a, second, b) or is_inside(first, a, second, b) or is_inside(second, b, first, a)
