"""Whether a body shares a point with a half-space, in whole numbers.

In: a body's corners with radii, a half-space, poses of both. Out: verdicts. It shares no code with the core.

The idea: with the columns a, b, c of M, the half-space {x : n · x <= d} under y = M x + t is
{y : g · (y − t) <= d det M}, g being n_x b × c + n_y c × a + n_z a × b. A ball of the radius r about y has a point
there if and only if h = g · (y − t) − d det M is 0 or less, or h² <= r² g · g. All doubles are whole numbers of one
unit, so that these are.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.array_types import Bools, Floats
from plannercheck.evaluation.stress_parts.bodies import Body
from plannercheck.evaluation.stress_parts.given import Under

Whole = NDArray[np.object_]
# Corners that are further over the plane than the lowest one by this part of all lengths are left out: a million times
# what doubles are rounded by.
_ROUNDING = 1e-9


def meets_half_space(body: Body, poses: Floats, under: Under, poses_under: Floats, every: bool = False) -> Bools:
    """Whether a body that is no half-space shares a point with one: (k,), at poses (k, 4, 4) of each.

    `every`: no corner is left out.
    """
    found = np.zeros(len(poses), dtype=bool)
    for k, (pose, pose_under) in enumerate(zip(poses, poses_under, strict=True)):
        heights, slack = rounded_heights(body, pose, under, pose_under)
        some = np.flatnonzero(heights <= heights.min() + (np.inf if every else slack))
        found[k] = _meets(body.corners[some], body.radii[some], pose, under, pose_under)
    return found


def rounded_heights(body: Body, pose: Floats, under: Under, pose_under: Floats) -> tuple[Floats, float]:
    """How far the ball about each corner is over the plane, (n,), m, and far more than these are rounded by, m."""
    normal, offset = plane_in_world(under, pose_under)
    heights = body.corners @ (pose[:3, :3].T @ normal) + normal @ pose[:3, 3] - offset - body.radii - under.padding
    lengths = (body.corners, body.radii, pose[:3, 3], pose_under[:3, 3], offset, under.padding)
    return heights, _ROUNDING * sum(float(np.abs(each).max()) for each in lengths)


def plane_in_world(under: Under, pose: Floats) -> tuple[Floats, float]:
    """The posed plane's unit normal (3,) and its distance from the origin along that, m, both rounded."""
    normal = np.linalg.solve(pose[:3, :3].T, under.normal)
    length = float(np.linalg.norm(normal))
    return np.asarray(normal / length, dtype=np.float64), under.offset / length + float(normal @ pose[:3, 3]) / length


def plane_in_whole_numbers(
    given: Sequence[Floats], under: Under, pose: Floats
) -> tuple[list[Whole], tuple[Whole, Whole, int], int]:
    """Other numbers and a posed plane, in multiples of one unit.

    The arrays, over 2^-unit; g, t and d det M, over its third, first and fourth power; the unit.
    """
    (*others, normal, offset, plane), unit = whole_numbers([*given, under.normal, np.array([under.offset]), pose[:3]])
    a, b, c, t = plane.T
    g = normal[0] * cross(b, c) + normal[1] * cross(c, a) + normal[2] * cross(a, b)
    return others, (g, t, int(offset[0] * (a @ cross(b, c)))), unit


def whole_numbers(given: Sequence[Floats]) -> tuple[list[Whole], int]:
    """Arrays of doubles over 2^-unit, of which all are multiples, as Python's integers; and that unit."""
    ratios = [[float(x).as_integer_ratio() for x in each.ravel()] for each in given]
    unit = max(below.bit_length() - 1 for each in ratios for _, below in each)
    found = [np.array([over * ((1 << unit) // below) for over, below in each], dtype=object) for each in ratios]
    return [whole.reshape(each.shape) for whole, each in zip(found, given, strict=True)], unit


def cross(a: Whole, b: Whole) -> Whole:
    """The vector product of whole numbers (3,)."""
    return np.array([a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2] for i in range(3)], dtype=object)


def _meets(corners: Floats, radii: Floats, pose: Floats, under: Under, pose_under: Floats) -> bool:
    given = [corners, radii, pose[:3], np.array([under.padding])]
    (points, reach, own, padding), (g, t, offset), unit = plane_in_whole_numbers(given, under, pose_under)
    heights = points @ (own[:, :3].T @ g) + ((g @ (own[:, 3] - t) - offset) << unit)
    squares = ((reach + padding) ** 2 * (g @ g)) << (2 * unit)
    return bool(((heights <= 0) | (heights**2 <= squares)).any())
