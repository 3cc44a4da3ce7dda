"""Whether an ellipsoid itself, not the polytope that stands for it, shares a point with another body, exactly.

In: an ellipsoid of radii r, another body, poses of both. Out: verdicts where whole numbers decide: against a
half-space, and against a point.

The idea: a point's place in the ellipsoid's frame is x_i = X_i / det M by Cramer's rule, and the sum of x_i² / r_i²
decides. An ellipsoid's extent along g is the root of S, the sum of (r_i (Mᵀ g)_i)², and padding R adds the root of T =
R² g · g. The height h of its centre is at most the sum of both roots if h is 0 or less, or h² − S − T is, or (h² − S −
T)² <= 4 S T.
"""

from __future__ import annotations

import numpy as np

from plannercheck.common.array_types import Bools, Floats
from plannercheck.evaluation.stress_parts.bodies import Body
from plannercheck.evaluation.stress_parts.given import Oval, Under
from plannercheck.evaluation.stress_parts.half_space_truth import cross, plane_in_whole_numbers, whole_numbers


def decide_ellipsoids(p: Body, poses_p: Floats, r: Body, poses_r: Floats) -> Bools | None:
    """Whether two bodies share a point at poses (k, 4, 4); None if none is an ellipsoid, or no whole numbers tell."""
    poses = list(zip(poses_p, poses_r, strict=True))
    if isinstance(p.given, Oval) and isinstance(r.given, Under):
        return np.array([_meets_half_space(p.given, pose_p, r.given, pose_r) for pose_p, pose_r in poses])
    if isinstance(r.given, Oval) and r.given.padding == 0 and len(p.corners) == 1 and not p.radii.any():
        return np.array([_holds(r.given, pose_r, p.corners[0], pose_p) for pose_p, pose_r in poses])
    return None


def _meets_half_space(oval: Oval, pose: Floats, under: Under, pose_under: Floats) -> bool:
    given = [oval.radii, pose[:3], np.array([oval.padding, under.padding])]
    (radii, own, paddings), (g, t, offset), unit = plane_in_whole_numbers(given, under, pose_under)
    height = (g @ (own[:, 3] - t) - offset) << unit
    reach = int(((radii * (own[:, :3].T @ g)) ** 2).sum())
    around = (paddings.sum() ** 2 * (g @ g)) << (2 * unit)
    more = height**2 - reach - around
    return bool(height <= 0 or more <= 0 or more**2 <= 4 * reach * around)


def _holds(oval: Oval, pose: Floats, point: Floats, pose_of_point: Floats) -> bool:
    (radii, place, own, body), unit = whole_numbers([oval.radii, point, pose_of_point[:3], pose[:3]])
    a, b, c, t = body.T
    way = own[:, :3] @ place + ((own[:, 3] - t) << unit)
    x, y, z = way @ cross(b, c), way @ cross(c, a), way @ cross(a, b)
    u, v, w = radii
    return bool((x * v * w) ** 2 + (y * w * u) ** 2 + (z * u * v) ** 2 <= (a @ cross(b, c) * u * v * w) ** 2)
