"""How far the rounding of forward kinematics can move a point of a body: a proven bound, in m.

In: the compiled kernel's joint table (kinematics.py), the bodies with their placements, ranges of the configuration.
Out: `KinematicRounding.bound`, for a robot's limits or for one configuration.

What is bounded. "Exact kinematics" is what the kernel's formulas give over the real numbers for the same doubles:
placements as the affine maps that their doubles are, never re-orthonormalised; a value as multiplier * q + offset; the
true cosine and sine of an angle; quaternions and (cosine, sine) pairs as they are; and Rodrigues' formula
c + (1 - c) a a^T + s [a] with the axis as it is (its length may be off 1 by rounding: then the formula, not the nearest
rotation, is what counts). What Pinocchio rounds when it reads a URDF is thus part of the given numbers. A body's
vertices are given numbers too, and the verdict maps them exactly; of a sphere or capsule only the centre or ends move.

The idea. Follow the kernel's operations down the tree, joint by joint, and carry four numbers for each computed pose
(R', t') of the exact (R, t): `turn` >= |R' - R| (spectral norm), `shift` >= |t' - t|, `norm` >= |R|, `reach` >= |t|.
With u = 2^-53, fl(a op b) = (a op b)(1 + d), |d| <= u (the kernel is compiled without fused operations):

- Placing, R' P and R' p + t': an entry is a sum of at most three products. A product with 0, 1 or -1 is exact, as is
  adding 0; else each costs u. If w_k is the count of roundings that term k passes times |P_kj|, column j errs by at
  most u ||R| w| <= u norm min(|w|_1, sqrt(3) |w|_2), since |R| has columns of length <= norm and Frobenius norm
  <= sqrt(3) norm. The last addition of t' costs u |R p + t| more. Old errors go on: turn |P|, and shift + turn |p|.
- Turning about x, y or z replaces columns a, b by c a + s b and c b - s a. In the Frobenius norm the four products err
  by u |(|a|, |b|) (|c| |s|; |s| |c|)| <= u sqrt(2) norm sqrt(2), the two sums by u sqrt(2) norm. Errors (e, f) of
  (c, s) matter as the matrix (e -f; f e), of norm |(e, f)|; an error d of the angle as at most d.
- Rodrigues' matrix, entry by entry: 3 roundings on (1 - c) a_i a_j, one on s a_k, one on their sum; so with |a| = 1 the
  Frobenius norm of the error is at most u (3 (1 - c) + sqrt(2) |s| + sqrt(3)) <= u (3 + sqrt(11) + sqrt(3)).
- A quaternion's matrix: one rounding on each product, one more on the sums of the diagonal, one on each entry. With
  s = |v|^2 that is u (sqrt(8/3) s + sqrt(8 s (1 - s)) + sqrt(32) s + sqrt(3)), whose largest value over s is taken.
- Multiplying by such a matrix M, three products an entry: 3 u ||R| |M||_F <= 3 u sqrt(3) sqrt(3) norm.
- A slide by d along an axis is a placing by (axis d), with one more rounding for the product; an error of d adds to it.

The cosine and sine (cpp/math/sincos.hpp) err by at most `_SINCOS` u each, absolutely. The reduced angle r + tail has
|r| <= pi/4, |tail| <= u/2, and errs by less than u / 1000: the first product and difference of the reduction are exact,
all that is rounded after them is below 2^-12 or part of the tail. sin r = r + (r z S + tail one_less): u/2 from the
last sum (the result is below 1), u/16 from the one in brackets (below 1/8), 4.5 u on |r z S| <= 0.0785 or 0.36 u, the
polynomial's own 3.2e-17 |r z| or 0.14 u, less than 0.02 u from the tail: 1.09 u. cos r: u/2 from the last sum, u/4 from
z (at most u/2, halved), 5.1 u on z^2 C <= 0.016 or 0.09 u, less than 0.1 u from the rest: 0.94 u. The polynomials' own
errors are those on a fine grid in multi-precision. Beyond 1e6 rad the reduction is done in integers
(cpp/math/large_angle.hpp) and errs by less than 2^-107; |tail| <= u/2 as before, so the same bounds hold.

All of this is of first order in u. What is left out (products of errors, roundings of this computation itself) is less
than 1e-9 of it, as long as `turn` stays below 1e-10; `_REST` covers it, and `_UNDERFLOW` covers products below 1e-308.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.shapes import Capsule, Cone, Cylinder, GeometryObject, Shape, Sphere
from plannercheck.common.array_types import Floats
from plannercheck.robots.joints import CIRCLE, KINDS, TURN
from plannercheck.robots.kinematics import JointTable
from plannercheck.robots.unit_lengths import UNIT_TOLERANCE

# Unit roundoff of doubles.
_U = 2.0**-53

# Largest error of a computed cosine or sine, in u (derived above).
_SINCOS = 1.1
_SINCOS_PAIR = math.sqrt(2) * _SINCOS

# Errors of building and multiplying rotations, in u (derived above).
_TURN = 2 + math.sqrt(2)
_RODRIGUES = 3 + math.sqrt(11) + math.sqrt(3)
_QUATERNION_LINEAR = math.sqrt(8 / 3) + math.sqrt(32)
_QUATERNION = _QUATERNION_LINEAR / 2 + math.hypot(_QUATERNION_LINEAR / 2, math.sqrt(2)) + math.sqrt(3)
_MULTIPLY = 9.0

# How far pairs and quaternions whose length differs from 1 by UNIT_TOLERANCE stretch: |M| <= 1 + 4 UNIT_TOLERANCE,
# rounded up. It also covers the effect of their lengths on the constants above.
_STRETCH = 1 + 5 * UNIT_TOLERANCE

# Covers terms that are not of first order in u.
_REST = 1 + 1e-9
_UNDERFLOW = 1e-300  # m

# Above this, the terms that _REST covers are no longer proved to be small.
_LARGEST_TURN = 1e-10

# Ranges of configurations whose errors of links are kept: a robot is asked for two of them again and again.
_MOST_RANGES = 4


@dataclass(frozen=True)
class PoseError:
    """Bounds on a computed pose (R', t') and its error from the exact (R, t).

    Attributes:
        turn: At least |R' - R|, spectral norm.
        shift: At least |t' - t|, m.
        norm: At least |R|.
        reach: At least |t|, m.
    """

    turn: float = 0.0
    shift: float = 0.0
    norm: float = 1.0
    reach: float = 0.0

    def of_points(self, radius: float) -> float:
        """How far the points within `radius` m of the pose's origin may be off, m."""
        return self.turn * radius + self.shift


class Placement(NamedTuple):
    """A constant placement (P, p) and what multiplying by it costs.

    Attributes:
        norm: |P|.
        length: |p|, m.
        turn: Error of R' P, in u and units of |R|.
        shift: Error of the products of R' p, in u and units of |R|, m.
    """

    norm: float
    length: float
    turn: float
    shift: float

    def on(self, parent: PoseError) -> PoseError:
        """The error of parent * placement."""
        reach = parent.reach + parent.norm * self.length
        last_sum = reach if self.length > 0 else 0.0
        return PoseError(
            parent.turn * self.norm + _U * parent.norm * self.turn,
            parent.shift + parent.turn * self.length + _U * (parent.norm * self.shift + last_sum),
            parent.norm * self.norm,
            reach,
        )

    def in_world(self) -> PoseError:
        """The error of a placement in the world, which is exact as given."""
        return PoseError(norm=self.norm, reach=self.length)


class Value(NamedTuple):
    """One number that a joint takes: its largest magnitude within a range, and its largest error."""

    size: float
    error: float


class KinematicRounding:
    """The bound for one robot; its joint table and bodies are read once."""

    def __init__(self, table: JointTable, bodies: Sequence[GeometryObject], links: Sequence[int]) -> None:
        """Reads the placements of the kernel's joint table, and of bodies, each on a link of the table."""
        self._table = table
        self._joint_placements = [_placement(p) for p in table.placements]
        self._link_placements = [_placement(p) for p in table.link_placements]
        self._bodies = _read_bodies(bodies, links)
        self._known: dict[bytes, list[PoseError]] = {}  # of links, by range

    def with_bodies(self, bodies: Sequence[GeometryObject], links: Sequence[int]) -> KinematicRounding:
        """The bound for the same robot with more bodies, which alone are read; arguments as for the robot's own."""
        more = copy.copy(self)
        more._bodies = [*self._bodies, *_read_bodies(bodies, links)]
        return more

    def bound(self, lower: Floats, upper: Floats) -> float:
        """How far a point of a body may be from where exact kinematics puts it.

        Args:
            lower: (nq,) least configuration, rad and m, finite; numbers of unit vectors such as quaternions are
                ignored.
            upper: (nq,) largest configuration.

        Returns:
            m, for every configuration within the range; infinite if there are too many joints for a proof.
        """
        links = self._link_errors(lower, upper)
        errors = [(placement.on(links[link]), radius) for link, placement, radius in self._bodies]
        if not all(error.turn <= _LARGEST_TURN for error, _ in errors):
            return math.inf
        return max((error.of_points(radius) * _REST + _UNDERFLOW for error, radius in errors), default=0.0)

    def _link_errors(self, lower: Floats, upper: Floats) -> list[PoseError]:
        key = lower.tobytes() + upper.tobytes()
        found = self._known.get(key)
        if found is None:
            found = self._new_link_errors(lower, upper)
            if len(self._known) >= _MOST_RANGES:
                self._known.clear()
            self._known[key] = found
        return found

    def _new_link_errors(self, lower: Floats, upper: Floats) -> list[PoseError]:
        table = self._table
        joints: list[PoseError] = []
        for i, parent in enumerate(table.parents.tolist()):
            placed = _placed(self._joint_placements[i], parent, joints)
            joints.append(_moved(placed, int(table.kinds[i]), table.axes[i], _values(table, i, lower, upper)))
        return [
            _placed(placement, joint, joints)
            for placement, joint in zip(self._link_placements, table.link_joints.tolist(), strict=True)
        ]


def _read_bodies(bodies: Sequence[GeometryObject], links: Sequence[int]) -> list[tuple[int, Placement, float]]:
    return [(link, _placement(body.pose[:3]), radius_of(body.shape)) for link, body in zip(links, bodies, strict=True)]


def radius_of(shape: Shape) -> float:
    """The largest distance from its frame's origin of a body's points that its pose maps, m.

    For spheres and capsules these are the centre and the end points. For cylinders and cones they are the vertices of
    the polytope around them, which sticks out by at most the radius, whatever the excess.
    """
    match shape:
        case Sphere():
            return 0.0
        case Capsule():
            return shape.length / 2
        case Cylinder() | Cone():
            return math.hypot(2 * shape.radius, shape.length / 2)
    return float(np.linalg.norm(shape.vertices_and_faces()[0], axis=1).max())


def largest_distance(bodies: Sequence[GeometryObject], poses: Floats, others: Floats) -> float:
    """How far the points of n bodies move at most from poses (n, 4, 4) to others, m; bodies at NaN do not count."""
    difference = poses - others
    turns = np.linalg.norm(difference[:, :3, :3], axis=(1, 2))
    shifts = np.linalg.norm(difference[:, :3, 3], axis=1)
    radii = np.array([radius_of(body.shape) for body in bodies])
    distances = turns * radii + shifts
    return float(distances[~np.isnan(distances)].max(initial=0.0)) * _REST


def _placed(placement: Placement, joint: int, joints: Sequence[PoseError]) -> PoseError:
    """A placement on a joint, or in the world, where nothing is computed."""
    return placement.on(joints[joint]) if joint >= 0 else placement.in_world()


def _placement(matrix: Floats) -> Placement:
    """Reads a 3x4 placement."""
    products = (matrix != 0) & (np.abs(matrix) != 1)
    weights = np.abs(matrix) * (products + _sums_passed(matrix != 0))
    columns = [_column_error(weights[:, j]) for j in range(4)]
    return Placement(
        norm=float(np.linalg.norm(matrix[:, :3], 2)),
        length=float(np.linalg.norm(matrix[:, 3])),
        turn=math.hypot(*columns[:3]),
        shift=columns[3],
    )


def _sums_passed(present: NDArray[np.bool_]) -> NDArray[np.int64]:
    """How many additions of (first + second) + third each term (3, n) passes whose both sides may be other than 0."""
    first, second, third = present.astype(np.int64)
    return np.array([second + third, first + third, first | second])


def _column_error(weights: Floats) -> float:
    """Bound of ||R| w| in units of |R|, for weights (3,)."""
    return float(min(weights.sum(), math.sqrt(3) * np.linalg.norm(weights)))


def _values(table: JointTable, joint: int, lower: Floats, upper: Floats) -> list[Value]:
    """The numbers that a joint takes from the configurations within a range."""
    rows = zip(table.columns[joint], table.multipliers[joint], table.offsets[joint], strict=True)
    return [
        Value(abs(float(offset)), 0.0)
        if column < 0
        else _value(float(multiplier), float(offset), float(lower[column]), float(upper[column]))
        for column, multiplier, offset in rows
    ]


def _value(multiplier: float, offset: float, lower: float, upper: float) -> Value:
    """fl(fl(multiplier * q) + offset); products by 1 and -1 and sums with 0 are exact."""
    product = abs(multiplier) * max(abs(lower), abs(upper))
    size = max(abs(multiplier * lower + offset), abs(multiplier * upper + offset))
    error = _U * (product * (abs(multiplier) not in (0.0, 1.0)) + size * (offset != 0))
    return Value(size, error)


def _moved(pose: PoseError, kind: int, axis: Floats, values: Sequence[Value]) -> PoseError:
    """The error of a joint's pose after its motion."""
    joint = KINDS[kind]
    if joint.lengths:
        along = (axis, [values[0]] * 3) if joint.has_axis else (np.ones(3), values[: joint.lengths])
        pose = _slid(pose, *along)
    matrix = _of_axis(axis) if kind in (TURN.unaligned, CIRCLE.unaligned) else _TURN
    if joint.turn == "angle":
        return _turned(pose, matrix + _SINCOS_PAIR, values[joint.lengths].error)
    if joint.turn == "pair":
        return _turned(pose, matrix, _error_of(values[joint.lengths : joint.numbers]), _STRETCH)
    return _turned(pose, _QUATERNION + _MULTIPLY, 0.0, _STRETCH) if joint.turn == "quaternion" else pose


def _of_axis(axis: Floats) -> float:
    """The error, in u, of Rodrigues' matrix and of multiplying by it."""
    return (_RODRIGUES + _MULTIPLY) * max(1.0, float(axis @ axis))


def _error_of(values: Sequence[Value]) -> float:
    return math.hypot(*(value.error for value in values))


def _turned(pose: PoseError, roundings: float, angle_error: float, stretch: float = 1.0) -> PoseError:
    """A pose times a rotation that errs by `roundings` u, of norm `stretch`."""
    turn = (pose.turn + pose.norm * (_U * roundings + angle_error)) * stretch
    return replace(pose, turn=turn, norm=pose.norm * stretch)


def _slid(pose: PoseError, axis: Floats, values: Sequence[Value]) -> PoseError:
    """A pose shifted by value * axis component along its own x, y, z (missing ones stand at 0)."""
    parts = np.zeros((3, 2))  # length and its error
    for k, value in enumerate(values):
        product = _U * value.size if abs(axis[k]) not in (0.0, 1.0) else 0.0
        parts[k] = abs(axis[k]) * value.size, abs(axis[k]) * (value.error + product)
    lengths, errors = parts.T
    roundings = (lengths != 0) + _sums_passed(lengths[:, None] != 0)[:, 0]
    length = float(np.linalg.norm(lengths))
    reach = pose.reach + pose.norm * length
    rounded = _U * (pose.norm * _column_error(lengths * roundings) + (reach if length > 0 else 0.0))
    shift = pose.shift + pose.turn * length + pose.norm * float(np.linalg.norm(errors)) + rounded
    return replace(pose, shift=shift, reach=reach)
