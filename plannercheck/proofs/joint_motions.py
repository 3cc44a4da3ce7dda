"""Motions of single joints in ball arithmetic: the claim's interpolations, written from their definitions.

In: a joint, a motion's control points. Out: a function from the parameter (a point, or a ball of an interval) to the
jet of the map from the joint's frame after its motion to its parent's.

Turns are Rodrigues' formula, c I + (1 - c) a a^T + s [a], with the axis a as it is. By an angle p(t) the map R(p) has
the derivatives R' p' and R'' p'^2 + R' p'', with R'' = -c (I - a a^T) - s [a]. Planar, floating and ball joints
move along M exp(t X) with the constant twist X = log(M^-1 N), so derivatives are products with X. The matrix over an
interval is the one at its middle times exp of the small rest. Where the path is "slerp", planar and floating joints
move along T exp(t X): a shift T, linear in t or a polynomial, and then a ball joint's motion.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from flint import arb, arb_mat

from plannercheck.common.motion_paths import MotionPath
from plannercheck.proofs.data import JOINTS, Joint
from plannercheck.proofs.faults import UnprovedError
from plannercheck.proofs.jets import Jet, affine, by_length, linear, product, times, total
from plannercheck.proofs.polynomials import Values, line, polynomial

Motion = Callable[[Any], Jet]

# Below this angle, rad, logarithms are computed as series, whose next term bounds the remainder.
_SMALL = arb(1) / 4

# This near to half a turn (its sine, or half of it), the short way has no proof: rounding in doubles, by about 1e-16,
# may take a checker or a planner the other way round than exact numbers.
_HALF_TURN_ROOM = 1e-12


def joint_motion(joint: Joint, control: Sequence[Sequence[float]], path: MotionPath = "screw") -> Motion:
    """The jet of a joint's map as a function of the parameter.

    Args:
        joint: The joint, well-formed.
        control: (degree + 1, columns) the motion's control points, from its start to its end.
        path: How planar and floating joints move: of degree 2 or more by "slerp".

    Returns:
        The function; for joints that are held, of a constant.

    Raises:
        UnprovedError: If the short way round is not definite.
    """
    placement = affine(joint.placement)
    if max(joint.columns) < 0:
        held = Jet(placement * held_map(joint))
        return lambda t: held
    first = joint.columns[0]
    here, there = control[0][first:], control[-1][first:]
    if joint.kind in ("turn", "slide"):
        values = _values([row[first] for row in control], joint.multipliers[0], joint.offsets[0])
        return (_turning if joint.kind == "turn" else _sliding)(placement, joint.axis, values)
    if joint.kind == "circle":
        angle, rate = arb.atan2(arb(here[1]), arb(here[0])), _shorter_turn(here, there)
        return _turning(placement, joint.axis, lambda t: (angle + t * rate, rate, None), joint.multipliers)
    before, after = _placed(joint.kind, here), _placed(joint.kind, there)
    if path == "slerp" and JOINTS[joint.kind].is_pose:
        lengths = JOINTS[joint.kind].lengths
        shift = [_values([row[first + k] if k < lengths else 0.0 for row in control]) for k in range(3)]
        return _shifting_and_turning(placement, shift, before, _turn_vector(joint.kind, here, there))
    return _screw(placement * before, _twist(before, after, _turn_vector(joint.kind, here, there)))


def _values(control: Sequence[float], multiplier: float = 1.0, offset: float = 0.0) -> Values:
    """The value of one number of a joint."""
    of = line if len(control) == 2 else polynomial
    return of(control, multiplier, offset)


def held_map(joint: Joint) -> Any:
    """The 4 x 4 map of a joint that is held at its offsets."""
    values = [arb(value) for value in joint.offsets]
    if joint.kind == "slide":
        return shifted([values[0] * arb(part) for part in joint.axis])
    if joint.kind == "turn":
        return _turned(joint.axis, values[0].cos(), values[0].sin())
    if joint.kind == "circle":
        return _turned(joint.axis, values[0], values[1])
    return _pose(joint.kind, values)


def shifted(by: Sequence[Any]) -> Any:
    """A translation, 4 x 4."""
    return arb_mat(4, 4, [1, 0, 0, by[0], 0, 1, 0, by[1], 0, 0, 1, by[2], 0, 0, 0, 1])


def _cross(a: Sequence[Any]) -> list[Any]:
    """The matrix [a] of a cross product with a."""
    zero = arb(0)
    return [zero, -a[2], a[1], a[2], zero, -a[0], -a[1], a[0], zero]


def _parts(axis: Sequence[float]) -> tuple[Any, Any, Any]:
    """The map c (I - a a^T) + s [a] + a a^T: the factors of c and s, and the constant part."""
    a = [arb(part) for part in axis]
    outer, one = linear([x * y for x in a for y in a]), linear([arb(int(k % 4 == 0)) for k in range(9)])
    last = arb_mat(4, 4, [0] * 15 + [1])
    return one - outer, linear(_cross(a)), outer + last


def _turned(axis: Sequence[float], cosine: Any, sine: Any) -> Any:
    of_cosine, of_sine, constant = _parts(axis)
    return of_cosine * cosine + of_sine * sine + constant


def _turning(placement: Any, axis: Sequence[float], values: Values, signs: Sequence[float] = (1.0, 1.0)) -> Motion:
    """A turn by an angle; the cosine and sine are multiplied by the signs."""
    of_cosine, of_sine, constant = (placement * part for part in _parts(axis))
    of_cosine, of_sine = of_cosine * arb(signs[0]), of_sine * arb(signs[-1] if len(signs) > 1 else 1.0)

    def jet(t: Any) -> Jet:
        angle, rate, bend = values(t)
        sine, cosine = angle.sin_cos()
        swing, turned = of_cosine * cosine + of_sine * sine, of_sine * cosine - of_cosine * sine
        return Jet(constant + swing, turned * rate, total(swing * -(rate * rate), times(turned, bend)))

    return jet


def _sliding(placement: Any, axis: Sequence[float], values: Values) -> Motion:
    along = placement * arb_mat(4, 4, [x for a in axis for x in (0, 0, 0, a)] + [0, 0, 0, 0])

    def jet(t: Any) -> Jet:
        value, rate, bend = values(t)
        return Jet(placement + along * value, along * rate, times(along, bend))

    return jet


def _screw(before: Any, twist: Any) -> Motion:
    def jet(t: Any) -> Jet:
        middle = t.mid()
        value = before * (twist * middle).exp() * (twist * (t - middle)).exp()
        first = value * twist
        return Jet(value, first, first * twist)

    return jet


def _shifting_and_turning(placement: Any, shift: Sequence[Values], before: Any, turn: Sequence[Any]) -> Motion:
    """A motion from a pose whose shift and turn move by themselves; the turn's vector is known."""
    turning = _screw(before - _column([before[k, 3] for k in range(3)]), linear(_cross(turn)))

    def jet(t: Any) -> Jet:
        value, rate, bend = zip(*(values(t) for values in shift), strict=True)
        second = None if None in bend else placement * _column(bend)
        return product(Jet(placement * shifted(value), placement * _column(rate), second), turning(t))

    return jet


def _column(shift: Sequence[Any]) -> Any:
    """The 4 x 4 matrix that is 0 but for a shift."""
    return arb_mat(4, 4, [x for part in shift for x in (0, 0, 0, part)] + [0] * 4)


def _shorter_turn(a: Sequence[float], b: Sequence[float]) -> Any:
    """The angle from one (cosine, sine) to another, the short way."""
    (c0, s0), (c1, s1) = ([arb(x) for x in pair[:2]] for pair in (a, b))
    cross, dot = c0 * s1 - s0 * c1, c0 * c1 + s0 * s1
    if not dot > 0 and not cross > _HALF_TURN_ROOM and not cross < -_HALF_TURN_ROOM:
        raise UnprovedError("the motion turns a joint by half a turn, of which the short way round is not known")
    return arb.atan2(cross, dot)


def _unit(kind: str, q: Sequence[float]) -> list[Any]:
    """The numbers of a joint that are a quaternion, or cosine and sine, normalised."""
    return by_length(q[JOINTS[kind].lengths : JOINTS[kind].numbers])


def _rotation(q: Sequence[Any]) -> Any:
    """The map of a quaternion x, y, z, w by the formula for those of length 1."""
    x, y, z, w = q
    return linear(
        [
            *(1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
            *(2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
            *(2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
        ]
    ) + arb_mat(4, 4, [0] * 15 + [1])


def _placed(kind: str, q: Sequence[float]) -> Any:
    """The map of a ball, planar or free joint at one end, its unit part normalised."""
    return _pose(kind, [*(arb(x) for x in q[: JOINTS[kind].lengths]), *_unit(kind, q)])


def _pose(kind: str, values: Sequence[Any]) -> Any:
    """The map of a ball, planar or free joint by its numbers as they are."""
    if kind == "ball":
        return _rotation(values)
    if kind == "planar":
        return shifted([values[0], values[1], arb(0)]) * _turned((0.0, 0.0, 1.0), values[2], values[3])
    if kind == "free":
        return shifted(values[:3]) * _rotation(values[3:])
    raise KeyError(kind)


def _turn_vector(kind: str, a: Sequence[float], b: Sequence[float]) -> list[Any]:
    """The rotation vector from one end to the other, the short way, in the frame of the first."""
    if kind == "planar":
        return [arb(0), arb(0), _shorter_turn(a[2:], b[2:])]
    (x0, y0, z0, w0), (x1, y1, z1, w1) = _unit(kind, a), _unit(kind, b)
    w = w0 * w1 + x0 * x1 + y0 * y1 + z0 * z1
    vector = [
        w0 * x1 - x0 * w1 - y0 * z1 + z0 * y1,
        w0 * y1 + x0 * z1 - y0 * w1 - z0 * x1,
        w0 * z1 - x0 * y1 + y0 * x1 - z0 * w1,
    ]
    if not w > _HALF_TURN_ROOM and not w < -_HALF_TURN_ROOM:
        raise UnprovedError("the motion turns a joint by half a turn, of which the short way round is not known")
    if w < 0:
        w, vector = -w, [-part for part in vector]
    sine = sum((part * part for part in vector), arb(0)).nonnegative_part().sqrt()
    ratio = 2 * arb.atan2(sine, w) / sine if sine > _SMALL else 2 / w * _arctangent(sine / w)
    return [ratio * part for part in vector]


def _arctangent(x: Any) -> Any:
    """atan(x) / x for |x| below 0.3: an alternating series, so the next term bounds the rest."""
    s, out, power = x * x, arb(0), arb(1)
    for k in range(20):
        out, power = out + power / (2 * k + 1), power * -s
    return out + ball_of(power / 41)


def _cotangent(s: Any) -> Any:
    """(1 - a/2 cot(a/2)) / a^2 of a^2 = s below 1/16.

    The series 1/12 + s/720 + … has the terms |B_2k| / (2k)! s^(k-1), each at most 1/39 s of the one before.
    """
    terms = (12, 720, 30240, 1209600, 47900160)
    out, power = arb(0), arb(1)
    for term in terms:
        out, power = out + power / term, power * s
    return out + ball_of(power / 10**9)  # the next is 691 / 1307674368000, below 0.53e-9, and the rest 1 % of it


def ball_of(x: Any) -> Any:
    """The ball around 0 that holds x and -x."""
    return (-x).union(x)


def _twist(before: Any, after: Any, turn: Sequence[Any]) -> Any:
    """The 4 x 4 twist X with before exp(X) = after, whose rotation vector is known."""
    w = arb_mat(3, 3, _cross(turn))
    difference = arb_mat(3, 1, [after[k, 3] - before[k, 3] for k in range(3)])
    shift = arb_mat(3, 3, [before[k, j] for j in range(3) for k in range(3)]) * difference
    s = sum((part * part for part in turn), arb(0)).nonnegative_part()
    if s > _SMALL * _SMALL:
        half = s.sqrt() / 2
        term = (1 - half * half.cos() / half.sin()) / s
    else:
        term = _cotangent(s)
    slide = shift - (w * shift) * arb("0.5") + (w * (w * shift)) * term
    rows = [[w[i, 0], w[i, 1], w[i, 2], slide[i, 0]] for i in range(3)]
    return arb_mat(4, 4, [x for row in rows for x in row] + [0, 0, 0, 0])
