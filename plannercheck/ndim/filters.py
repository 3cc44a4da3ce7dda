"""Verdicts in doubles with forward error bounds; if these leave a verdict open, integers decide.

In: posed bodies and a method's result. Out: True only if the exact bodies (with vertices and poses as the numbers that
their doubles are) are certainly apart, or certainly share a point.

The bounds are Higham's: a sum of k products in doubles, in any order and with or without fused steps, errs by at most
γ_k = k u / (1 - k u) times the sum of their absolute values, u = 2^-53. `_terms` counts the factors that meet on the
way, with room for computing the bound itself in doubles.
"""

from __future__ import annotations

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.ndim.poses import Affine, rounded_inverse
from plannercheck.ndim.rounding import UNDERFLOW, UNIT


class Posed:
    """A body's vertices with its pose, for supports: directions are pulled back, vertices stay where they are.

    Attributes:
        vertices: (n, d).
        pose: The map.
        rounding: |M| reach + |t| (d,): what errors are relative to.
    """

    def __init__(self, vertices: Floats, pose: Affine, reach: Floats) -> None:
        self.vertices, self.pose = vertices, pose
        self.rounding = pose.of_rounding(reach)

    def lowest(self, direction: Floats) -> tuple[int, float]:
        """A vertex with the least product with a direction, and that product, rounded."""
        products = self.vertices @ (direction @ self.pose.matrix)
        index = int(products.argmin())
        return index, float(products[index] + direction @ self.pose.shift)

    def lowest_few(self, direction: Floats, count: int) -> list[int]:
        """The vertices with the least products with a direction."""
        products = self.vertices @ (direction @ self.pose.matrix)
        return [int(k) for k in np.argsort(products, kind="stable")[:count]]

    def point(self, index: int) -> Floats:
        """One posed vertex, rounded."""
        return np.asarray(self.pose.matrix @ self.vertices[index] + self.pose.shift)


def gap_error(direction: Floats, first: Posed, second: Posed) -> float:
    """How far the difference of two rounded supports along a direction can be from the exact one."""
    size = float(np.abs(direction) @ (first.rounding + second.rounding))
    return _terms(len(direction)) * UNIT * size + UNDERFLOW


def _terms(dimension: int) -> int:
    # Pulling back, the product with a vertex, the translation, the difference: 2 d + 2; the rest is room.
    return 2 * dimension + 10


def encloses_origin(differences: Floats, rounding: Floats) -> bool:
    """Whether exact points near to the given ones certainly have the origin strictly inside their simplex.

    The points are d + 1 rounded differences of posed vertices (d + 1, d), whose errors are relative to `rounding` (d,).

    The weights w solve D w = e with the differences and a row of ones in D. With an approximate inverse C and
    β = ‖1 - C D‖ < 1, D is regular and the exact w is within ‖C (e - D w̃)‖ / (1 - β) of any w̃ (Rump).
    """
    size = len(differences)
    # Posing two vertices (d + 2 roundings each) and their difference.
    errors = np.append(_terms(size) * UNIT * rounding + UNDERFLOW, 0.0)
    matrix = np.vstack([differences.T, np.ones(size)])
    try:
        inverse = np.linalg.inv(matrix)
    except np.linalg.LinAlgError:
        return False
    weights = inverse[:, -1]
    if not (np.isfinite(inverse).all() and weights.min() > 0):
        return False
    spread = np.abs(inverse)
    sizes = np.abs(matrix) + errors[:, None]
    around = np.abs(np.eye(size) - inverse @ matrix) + (_terms(size) * UNIT) * (spread @ sizes) + UNDERFLOW
    around += spread @ np.broadcast_to(errors[:, None], (size, size))
    beta = float(around.sum(axis=1).max()) * (1 + _terms(size) * UNIT)
    if not beta < 0.5:
        return False
    right = np.append(np.zeros(size - 1), 1.0)
    residual = np.abs(right - matrix @ weights) + _terms(size) * UNIT * (sizes @ weights + right)
    residual += errors * weights.sum()
    # Twice, in place of 1 / (1 - β) ≤ 2 and with it room for the roundings of this line and the one above.
    return bool(weights.min() > 2.5 * float((spread @ residual).max()))


def proves_inside(normals: Floats, offsets: Floats, pose: Affine, point: Floats, error: Floats) -> bool:
    """Whether all within an error (d,) of a point (d,) of the world certainly is in a posed body of halfspaces."""
    inverse, inside_error = inverse_of(pose, np.abs(point) + np.abs(pose.shift) + error, error)
    if not np.isfinite(inside_error):
        return False
    inside = point if pose.is_identity else inverse @ (point - pose.shift)
    sizes = np.abs(normals) @ (np.abs(inside) + inside_error) + np.abs(offsets)
    bound = _terms(len(point)) * UNIT * sizes + np.abs(normals).sum(axis=1) * inside_error + UNDERFLOW
    return bool((normals @ inside - offsets < -2 * bound).all())


def inverse_of(pose: Affine, span: Floats, error: Floats) -> tuple[Floats, float]:
    """An approximate inverse N of a pose's M, and how wrong N (x - t) is, computed in doubles, at most.

    With β ≥ ‖1 - N M‖ and z = x - t: N z - M^-1 z = (N M - 1) M^-1 z, and ‖M^-1 z‖ ≤ ‖N z‖ / (1 - β). So each entry is
    wrong by at most β / (1 - β) times the largest of |N| |z|, and |N| times the error and rounding of z.

    |x| + |t| is at most `span` (d,), and x errs by at most `error` (d,). The bound is infinite if M is too close to
    singular for doubles.
    """
    d = len(span)
    if pose.is_identity:
        return pose.matrix, float(error.max())
    inverse = rounded_inverse(pose.matrix)
    size = np.abs(inverse)
    defect = np.abs(np.eye(d) - inverse @ pose.matrix) + _terms(d) * UNIT * (size @ np.abs(pose.matrix) + 1.0)
    beta = 1.01 * float(defect.sum(axis=1).max())
    if not beta < 0.5:
        return inverse, float("inf")
    moved = float((size @ (error + _terms(d) * UNIT * span)).max())
    return inverse, 1.01 * (moved + 2 * beta * float((size @ span).max())) + UNDERFLOW
