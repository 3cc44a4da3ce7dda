"""Proofs in doubles where a body is given by halfspaces (see `plannercheck.ndim.filters` for the bounds).

In: a hint and the two posed bodies, the second given by halfspaces. Out: True if the hint's verdict certainly holds.
"""

from __future__ import annotations

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.ndim.bodies import Polytope
from plannercheck.ndim.filters import inverse_of, proves_inside
from plannercheck.ndim.guides import Hint
from plannercheck.ndim.poses import Affine, solved
from plannercheck.ndim.rounding import UNDERFLOW, UNIT

PosedPolytope = tuple[Polytope, Affine]


def proves_shared(hint: Hint, mixed: PosedPolytope, body_b: PosedPolytope) -> bool:
    """Whether the hint's point certainly is in both bodies, the second given by halfspaces.

    The hint has weights if the first body is given by vertices.
    """
    body, pose = mixed
    if body.vertices is None:
        point, error = hint.point, np.zeros(body.dimension)
        return _is_inside(mixed, point, error) and _is_inside(body_b, point, error)
    weights = np.array(list(hint.weights_p.values()))
    if not len(weights) or not weights.sum() > 0:
        return False
    # The exact mixture of the exact posed vertices, with the weights' exact quotient, is within this of the point.
    vertices = body.vertices[list(hint.weights_p)]
    point = pose.of(vertices).T @ weights / weights.sum()
    error = (2 * (body.dimension + len(weights)) + 16) * UNIT * pose.of_rounding(body.reach) + UNDERFLOW
    return _is_inside(body_b, np.asarray(point), error)


def _is_inside(posed: PosedPolytope, point: Floats, error: Floats) -> bool:
    body, pose = posed
    assert body.normals is not None, "the body is given by halfspaces"
    assert body.offsets is not None, "halfspaces have offsets"
    return proves_inside(body.normals, body.offsets, pose, point, error)


def proves_apart(hint: Hint, mixed: PosedPolytope, body_b: PosedPolytope) -> bool:
    """Whether the hint's halfspaces, summed with its multipliers, certainly hold no vertex of the first body.

    The multipliers are at least 0; the first body is given by vertices, the second by halfspaces.
    """
    body, pose = mixed
    other, other_pose = body_b
    if body.vertices is None:
        return _multipliers_prove_apart(hint, mixed, body_b)
    assert other.normals is not None, "the second body is given by halfspaces"
    assert other.offsets is not None, "halfspaces have offsets"
    chosen, weights = list(hint.weights_r), np.array(list(hint.weights_r.values()))
    rounding = 2 * (len(weights) + body.dimension + 8) * UNIT
    normal = weights @ other.normals[chosen]
    normal_error = rounding * (weights @ np.abs(other.normals[chosen]))
    bound = float(weights @ other.offsets[chosen])
    bound_error = rounding * float(weights @ np.abs(other.offsets[chosen]))
    points, error = _in_b_frame(body.vertices, body.reach, pose, other_pose)
    if not np.isfinite(error).all():
        return False
    size = np.abs(points).max(axis=0)
    error_of_heights = float(np.abs(normal) @ (rounding * size + error) + normal_error @ (size + error))
    return bool((points @ normal).min() - bound > 2 * (error_of_heights + bound_error) + UNDERFLOW)


def _multipliers_prove_apart(hint: Hint, first: PosedPolytope, second: PosedPolytope) -> bool:
    """Whether the sums g_p·y ≤ c_p and g_r·z ≤ c_r of both bodies' halfspaces contradict each other.

    A common point x = M_p y + t_p = M_r z + t_r has, for any w, w·(t_r - t_p) = w·M_p y - w·M_r z. As entries of y and
    z are within the proved boxes, the right side is at most c_p + c_r + |M_p'w - g_p| reach_p + |M_r'w + g_r| reach_r.
    """
    g_p, c_p, rounding_p = _summed(first[0], hint.multipliers_p)
    g_r, c_r, rounding_r = _summed(second[0], hint.weights_r)
    pose_p, pose_r = first[1], second[1]
    w = solved(pose_p.matrix.T, g_p)
    terms = (2 * len(w) + 12) * UNIT
    slack = rounding_p + rounding_r
    for body, matrix, g in ((first[0], pose_p.matrix, g_p), (second[0], pose_r.matrix, -g_r)):
        defect = np.abs(w @ matrix - g) + terms * (np.abs(w) @ np.abs(matrix) + np.abs(g))
        slack += float(defect @ body.reach)
    apart = float(w @ (pose_r.shift - pose_p.shift))
    slack += terms * float(np.abs(w) @ (np.abs(pose_r.shift) + np.abs(pose_p.shift)))
    return bool(apart - c_p - c_r > 1.1 * slack + terms * (abs(apart) + abs(c_p) + abs(c_r)) + UNDERFLOW)


def _summed(body: Polytope, multipliers: dict[int, float]) -> tuple[Floats, float, float]:
    """The weighted sum g, c of a body's halfspaces in doubles, and how wrong g·y - c may be within its box."""
    assert body.normals is not None, "the body is given by halfspaces"
    assert body.offsets is not None, "halfspaces have offsets"
    chosen, weights = list(multipliers), np.array(list(multipliers.values()))
    rounding = 2 * (len(weights) + 4) * UNIT
    size = weights @ np.abs(body.normals[chosen])
    error = rounding * float(size @ body.reach + weights @ np.abs(body.offsets[chosen]))
    return weights @ body.normals[chosen], float(weights @ body.offsets[chosen]), error


def _in_b_frame(vertices: Floats, reach: Floats, pose: Affine, body_b: Affine) -> tuple[Floats, float]:
    """All vertices in the other body's frame, and how far any coordinate can be from the exact one."""
    d = len(reach)
    posed, size = pose.of(vertices), pose.of_rounding(reach)
    error = np.zeros(d) if pose.is_identity else (2 * d + 10) * UNIT * size + UNDERFLOW
    inverse, bound = inverse_of(body_b, size + error + np.abs(body_b.shift), error)
    return posed if body_b.is_identity else (posed - body_b.shift) @ inverse.T, bound
