"""Whether posed convex polygons share a point, by brute force on integers: the oracle of the planar tests.

In: vertices (n, 2) and poses (3, 3) in doubles. Out: the exact verdict. Sets of points have disjoint hulls if and only
if some line separates them strictly; then one does so that is parallel to a side of either hull, or, for hulls without
area, across one or across the line from a vertex of one to a vertex of the other. All such directions are tried on all
points, in Python integers: nothing is shared with the core, neither method nor arithmetic.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import product

import numpy as np


def posed_integers(bodies):
    """Posed vertices of several bodies as integers in one unit."""
    exact = [_posed(vertices, pose) for vertices, pose in bodies]
    unit = max(x.denominator for points in exact for point in points for x in point)  # powers of two
    return [[tuple(int(x * unit) for x in point) for point in points] for points in exact]


def _posed(vertices, pose):
    matrix = [[Fraction(float(x)) for x in row] for row in (np.eye(3) if pose is None else np.asarray(pose))]
    points = [[Fraction(float(x)) for x in vertex] for vertex in np.asarray(vertices)]
    return [tuple(row[0] * x + row[1] * y + row[2] for row in matrix[:2]) for x, y in points]


def share_point(a, b, pose_a=None, pose_b=None):
    """The verdict."""
    p, q = posed_integers([(a, pose_a), (b, pose_b)])
    return not any(_separates(d, p, q) for d in _directions(p, q))


def _directions(p, q):
    for points in (p, q):
        for (x0, y0), (x1, y1) in zip(points, points[1:] + points[:1], strict=True):
            yield y0 - y1, x1 - x0
    if _is_flat(p) or _is_flat(q):
        for points in (p, q):
            for (x0, y0), (x1, y1) in zip(points, points[1:] + points[:1], strict=True):
                yield x1 - x0, y1 - y0
        for (x0, y0), (x1, y1) in product(p, q):
            yield x1 - x0, y1 - y0
            yield y0 - y1, x1 - x0


def _is_flat(points):
    x0, y0 = points[0]
    return all(
        (x1 - x0) * (y2 - y0) == (y1 - y0) * (x2 - x0)
        for (x1, y1), (x2, y2) in zip(points[1:], points[2:], strict=False)
    )


def _separates(direction, p, q):
    dx, dy = direction
    along_p, along_q = ([dx * x + dy * y for x, y in points] for points in (p, q))
    return min(along_p) > max(along_q) or min(along_q) > max(along_p)
