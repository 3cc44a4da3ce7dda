"""Whether proofs prove what a controller runs between the points of a message: the exact polynomials of its doubles.

In: confirmed proofs of one file, a file of a trajectory, who runs it. Out: what is missing. Piece k of the message is
proved by proof k. Both polynomials are brought to one degree, in fractions. Their control points may differ, in each
column, by what the proof's tube has more than the tube that is asked for: polynomials differ no more than their control
points do.

The rules are written from the controllers' own code (`Trajectory::interpolate_between_points` of ros2_controllers).
The way from where the robot stands to the first point is not part of the message.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, Literal, TypeAlias, get_args

from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.model_comparisons import message_reader
from plannercheck.proofs.claims import column_names
from plannercheck.proofs.data import Model, Motion, ProofData
from plannercheck.proofs.paths import PathProved

Runner: TypeAlias = Literal["jtc", "motoros2", "linear"]
RUNNERS: tuple[Runner, ...] = get_args(Runner)

# Nanoseconds beyond which doubles skip whole numbers, 104 days.
_MOST = 2**53

# Control points of one column.
Control: TypeAlias = list[Fraction]


def trajectory_proved(proofs: Sequence[ProofData], path: Any, controller: str = "jtc", tube: float = 0.0) -> PathProved:
    """Whether proofs prove a message as a controller runs it.

    Args:
        proofs: At least one, of one model; those that are confirmed, in their order.
        path: A file that `pc.Trajectory.load` reads.
        controller: "jtc" (joint_trajectory_controller of ros2_control), "motoros2", or "linear".
        tube: How far each number may be off the curve at any instant, rad and m.

    Returns:
        What is missing.

    Raises:
        PlannercheckError: If the file can't be read, holds other joints or one point, or no controller runs it.
    """
    if controller not in RUNNERS:
        raise unknown_name("controller", controller, RUNNERS)
    if not 0 <= tube < float("inf"):
        raise PlannercheckError(f"tube must be a length of at least 0, not {tube!r}")
    model, names = proofs[0].model, column_names(proofs[0])
    if not isinstance(model, Model) or any(
        len(joint.columns) > 1 and max(joint.columns) >= 0 for joint in model.joints
    ):
        raise PlannercheckError("a JointTrajectory is of joints of one number each, and the proof has others")
    if not names or len(names) != model.columns:
        raise PlannercheckError("the proof has no joints, or numbers that no joint takes")
    points = message_reader()(path, names)
    times = _instants(points.times.tolist(), controller)
    count = len(times) - 1
    if count < 1:
        raise PlannercheckError(f"trajectory file {str(path)!r}: has one point, and no way between points")
    if controller == "motoros2" and len(set(times)) <= count:
        raise PlannercheckError(
            f"trajectory file {str(path)!r}: has points at the same ms, to which motoros2 cuts times"
        )
    missing = [
        k
        for k in range(count)
        if k >= len(proofs) or not _is_proved(proofs[k], _piece(points, k, times[k + 1] - times[k], controller), tube)
    ]
    return PathProved(count, tuple(missing), _sentence(missing, count, len(proofs), tube))


def _is_proved(proof: ProofData, piece: Sequence[Control], tube: float) -> bool:
    motion = proof.motion
    if not isinstance(motion, Motion) or motion.end != motion.asked_end:
        return False
    own = [[Fraction(x) for x in column] for column in zip(*motion.control, strict=True)]
    widths = motion.tube or (0.0,) * len(own)
    return all(
        _difference(given, asked) <= Fraction(width) - Fraction(tube)
        for given, asked, width in zip(own, piece, widths, strict=True)
    )


def _difference(a: Control, b: Control) -> Fraction:
    """The largest difference of control points, at one degree."""
    a, b = (_raised(control, max(len(a), len(b))) for control in (a, b))
    return max(abs(x - y) for x, y in zip(a, b, strict=True))


def _raised(control: Control, count: int) -> Control:
    """The same polynomial by as many control points."""
    while len(control) < count:
        n = len(control)
        inner = [(k * control[k - 1] + (n - k) * control[k]) / n for k in range(1, n)]
        control = [control[0], *inner, control[-1]]
    return control


def _instants(times: Sequence[float], controller: str) -> list[Fraction]:
    """The times of points, s: whole nanoseconds, as a message has them, if the doubles are the nearest to such.

    MotoROS2 cuts them to ms (MotionControl.c).
    """
    stamps = [round(Fraction(time) * 10**9) for time in times]
    if controller == "motoros2":
        return [Fraction(stamp // 10**6, 1000) for stamp in stamps]
    is_message = all(stamp / 10**9 == time and stamp < _MOST for stamp, time in zip(stamps, times, strict=True))
    return [Fraction(stamp, 10**9) for stamp in stamps] if is_message else [Fraction(time) for time in times]


def _piece(points: Any, k: int, step: Fraction, controller: str) -> list[Control]:
    """Control points by column of the way from a point to the next, which takes `step` s."""
    p, v, a = (_exact(rows[k]) for rows in (points.positions, points.velocities, points.accelerations))
    q, w, b = (_exact(rows[k + 1]) for rows in (points.positions, points.velocities, points.accelerations))
    has_velocities, has_accelerations = bool(v and w), bool(a and b)
    if controller == "linear" or not (has_velocities or has_accelerations):
        return [list(column) for column in zip(p, q, strict=True)]
    if not has_velocities:
        raise PlannercheckError(f"points {k} and {k + 1} have accelerations without velocities: a controller runs to 0")
    if controller == "motoros2" or not has_accelerations:
        return [[x, x + y * step / 3, z - u * step / 3, z] for x, y, u, z in zip(p, v, w, q, strict=True)]
    fifth, twentieth = step / 5, step * step / 20
    return [
        [x, x + y * fifth, x + 2 * y * fifth + c * twentieth, z - 2 * u * fifth + d * twentieth, z - u * fifth, z]
        for x, y, c, d, u, z in zip(p, v, a, b, w, q, strict=True)
    ]


def _exact(row: Any) -> Control:
    """The numbers of a point; none if it has NaN, as rows have that a message leaves out."""
    return [] if row[0] != row[0] else [Fraction(x) for x in row.tolist()]


def _sentence(missing: Sequence[int], count: int, proofs: int, tube: float) -> str | None:
    if missing:
        within = f" within {tube:g} rad and m" if tube else ""
        return f"{len(missing)} of the trajectory's {count} pieces are not proved{within}, piece {missing[0]} first"
    if proofs > count:
        return f"the trajectory has {count} pieces, and there are {proofs} proofs"
    return None
