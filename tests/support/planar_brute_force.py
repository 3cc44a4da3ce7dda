"""Whether posed convex polygons share a point, by brute force on integers: the oracle of the planar tests.

In: vertices (n, 2) and poses (3, 3) in doubles. Out: the exact verdict. Sets of points have disjoint hulls if and only
if some line separates them strictly; then one does so that is parallel to a side of either hull, or, for hulls without
area, across one or across the line from a vertex of one to a vertex of the other. All such directions are tried on all
points, in Python integers: nothing is shared with the core, neither method nor arithmetic.
"""

from itertools import pairwise, product

import numpy as np


def posed_integers(bodies):
    """Posed vertices of several bodies as integers in one unit."""
    ratios = [
        [
            [float(x).as_integer_ratio() for x in np.ravel(values)]
            for values in (vertices, np.eye(3) if p is None else p)
        ]
        for vertices, p in bodies
    ]
    units = [max(denominator for body in ratios for _, denominator in body[k]) for k in (0, 1)]  # powers of two
    return [_posed(*(_in_unit(body[k], units[k]) for k in (0, 1)), units[0]) for body in ratios]


def _in_unit(ratios, unit):
    return [numerator * (unit // denominator) for numerator, denominator in ratios]


def _posed(values, pose, unit):
    """Counted in the product of both units; translations come in that of the pose alone."""
    a, b, x, c, d, y = pose[:6]
    points = zip(values[::2], values[1::2], strict=True)
    return [(a * v + b * w + x * unit, c * v + d * w + y * unit) for v, w in points]


def share_point(a, b, pose_a=None, pose_b=None):
    """The verdict."""
    p, q = posed_integers([(a, pose_a), (b, pose_b)])
    return not any(_separates(d, p, q) for d in _directions(p, q))


def is_separated_across(sides, a, b, pose_a, pose_b):
    """Whether the normal of one of some sides separates; sides of a are counted first, then those of b."""
    p, q = posed_integers([(a, pose_a), (b, pose_b)])
    normals = [*_normals(p), *_normals(q)]
    return any(_separates(normals[k], p, q) for k in sides)


def _normals(points):
    return [(y0 - y1, x1 - x0) for (x0, y0), (x1, y1) in zip(points, points[1:] + points[:1], strict=True)]


def _directions(p, q):
    yield from _normals(p)
    yield from _normals(q)
    if _is_flat(p) or _is_flat(q):
        yield from ((y, -x) for points in (p, q) for x, y in _normals(points))
        for (x0, y0), (x1, y1) in product(p, q):
            yield x1 - x0, y1 - y0
            yield y0 - y1, x1 - x0


def _is_flat(points):
    x0, y0 = points[0]
    return all((x1 - x0) * (y2 - y0) == (y1 - y0) * (x2 - x0) for (x1, y1), (x2, y2) in pairwise(points[1:]))


def _separates(direction, p, q):
    dx, dy = direction
    along_p, along_q = ([dx * x + dy * y for x, y in points] for points in (p, q))
    return min(along_p) > max(along_q) or min(along_q) > max(along_p)
