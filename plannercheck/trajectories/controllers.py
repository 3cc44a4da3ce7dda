"""What controllers run between the points of a trajectory.

In: `Points`, the controller's name, where the robot stands. Out: a `Curve`.

The rules are in the controllers' code, by name:

- "jtc": joint_trajectory_controller of ros2_controllers, `Trajectory::interpolate_between_points`. A segment is linear
  if an end has no velocities, a cubic Hermite polynomial if both ends have velocities, and a quintic polynomial if both
  ends have accelerations as well. A segment with accelerations but without velocities at both ends would be run at 0
  rad on every joint: it is refused.
- "jtc-upsampled": the same controller with upsampling of messages without velocities: one cubic spline with continuous
  accelerations, at rest at both ends (`is_positions_only`, `fill_cubic_spline_velocities`).
- "ur": the UR driver's passthrough controller (external_control.urscript, `cubicSplineRun`, `quinticSplineRun`): cubic
  or quintic as above; positions alone are cubic, at rest at each point. A first point at 0 s is passed at rest, and the
  way to a later one begins at rest. A last velocity that is not 0 is scaled down to 0 along the same path.
- "motoros2": MotoROS2 (MotionControl.c): cubic by positions and velocities; accelerations are ignored, times cut to ms.
  It begins at the first point, whatever its time, and refuses a trajectory if the robot stands elsewhere.
- "linear": straight at constant speed, whatever else the points have.

Before the first point, a controller runs from where the robot stands. "jtc" (`set_point_before_trajectory_msg`) sets
velocities and accelerations of this state to 0 if the first point has them and the state has none, and subtracts whole
turns of continuous joints only there (`wraparound_joint`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, TypeAlias

import numpy as np

from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.arrays import OwnsArrays
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.trajectories.curve import Curve, check_size
from plannercheck.trajectories.rounding import hermite_error, turned_error, upsampled_error
from plannercheck.trajectories.stamps import durations, nanoseconds

Controller: TypeAlias = Literal["jtc", "jtc-upsampled", "ur", "motoros2", "linear"]
CONTROLLERS: tuple[Controller, ...] = ("jtc", "jtc-upsampled", "ur", "motoros2", "linear")

# Largest last velocities that controllers accept, rad/s or m/s; joint_trajectory_controller has the epsilon of floats.
REST: dict[str, float] = {"jtc": 2.0**-23, "jtc-upsampled": 2.0**-23, "motoros2": 1e-3}

# How near half a turn the way to the first point has to be for it to be a tie, rad (`wraparound_joint`).
_TIE = 1e-9


@dataclass(frozen=True, eq=False)
class Points(OwnsArrays):
    """The points of a trajectory.

    Attributes:
        times: (n,) s from the start.
        positions: (n, nq) rad and m.
        velocities: (n, nq) rad/s and m/s; rows of points without velocities are NaN.
        accelerations: (n, nq) rad/s² and m/s²; likewise.
        joint_names: Names of the columns; empty if they are not known.
        held: Values, by name, of joints outside the planning group that the message has, and that stand still.
    """

    times: Floats
    positions: Floats
    velocities: Floats
    accelerations: Floats
    joint_names: tuple[str, ...] = ()
    held: Mapping[str, float] = field(default_factory=dict)

    def named(self, column: int) -> str:
        """A column in words."""
        return f"joint {self.joint_names[column]!r}" if self.joint_names else f"column {column}"

    @property
    def has_velocities(self) -> Bools:
        """(n,) which points have them."""
        return np.asarray(~np.isnan(self.velocities).any(axis=1))

    @property
    def has_accelerations(self) -> Bools:
        """(n,) which points have them."""
        return np.asarray(~np.isnan(self.accelerations).any(axis=1))


def curve_of(points: Points, controller: Controller, start: Points | None, continuous: Sequence[int]) -> Curve:
    """The curve that a controller runs.

    Args:
        points: At least one point, at times that grow, from 0 s on.
        controller: Its name.
        start: One point, where the robot stands at 0 s; None where the first point stands for it.
        continuous: Columns of the joints that turn without end.

    Raises:
        PlannercheckError: If the controller refuses the points, or would run something else than anyone means.
    """
    if controller not in CONTROLLERS:
        raise unknown_name("controller", controller, CONTROLLERS)
    message = _as_run(points, controller)
    _check(message, controller)
    turning = continuous if controller.startswith("jtc") and start is not None else ()
    run = message if start is None else _approached(message, start, turning, controller)
    if len(run.times) < 2:
        raise PlannercheckError("a trajectory of one point needs start= (--start), where the robot comes from")
    steps = durations(run.times).tolist()
    ends = [_conditions(run, k) for k in range(len(steps))]
    pieces = tuple(_control_points(*each, h) for each, h in zip(ends, steps, strict=True))
    check_size(run.times, pieces)
    evaluated = controller != "ur"
    error = np.max([hermite_error(*each, h, evaluated) for each, h in zip(ends, steps, strict=True)], axis=0)
    if _is_upsampled(points, controller):
        error += upsampled_error(message.times, durations(message.times), message.positions, message.velocities)
    if start is not None:
        error[list(turning)] += turned_error(start.positions[0], message.positions[0])[list(turning)]
    return Curve(run.times, pieces, error)


def _as_run(points: Points, controller: Controller) -> Points:
    """The points with the derivatives that the controller puts in or leaves out."""
    none = np.full_like(points.positions, np.nan)
    has = points.has_velocities
    if controller == "linear":
        return replace(points, velocities=none, accelerations=none)
    if controller == "motoros2":
        if not has.all():
            raise PlannercheckError(f"point {int(np.argmin(has))} has no velocities: motoros2 refuses it")
        return replace(points, times=_whole_milliseconds(points.times), accelerations=none)
    if controller == "ur":
        return _as_ur_runs(points)
    if _is_upsampled(points, controller):
        return replace(points, velocities=_spline_velocities(durations(points.times), points.positions))
    return points


def _is_upsampled(points: Points, controller: Controller) -> bool:
    bare = not (points.has_velocities.any() or points.has_accelerations.any())
    return controller == "jtc-upsampled" and bare and len(points.times) > 1


def _whole_milliseconds(times: Floats) -> Floats:
    """Times cut to ms; points at the same ms have no interpolation between them."""
    cut = np.floor(nanoseconds(times)[0] / 1e6) / 1e3
    if not (np.diff(cut) > 0).all():
        k = int(np.argmin(np.diff(cut) > 0))
        raise PlannercheckError(f"points {k} and {k + 1} are at the same ms: motoros2 cuts times to ms")
    return cut


def _as_ur_runs(points: Points) -> Points:
    v, a = points.has_velocities, points.has_accelerations
    for has, what in ((v, "velocities"), (a, "accelerations")):
        if has.any() and not has.all():
            raise PlannercheckError(
                f"point {int(np.argmin(has))} has no {what}, but others have: the UR driver refuses it"
            )
    if a.any() and not v.any():
        raise PlannercheckError("its points have accelerations without velocities: the UR driver refuses it")
    velocities, accelerations = np.nan_to_num(points.velocities), points.accelerations.copy()
    if points.times[0] == 0.0:
        velocities[0] = 0.0
        accelerations[0] *= 0.0
    return replace(points, velocities=velocities, accelerations=accelerations)


def _check(points: Points, controller: Controller) -> None:
    """Raises for what a controller refuses, or runs in a way that nobody means."""
    last = np.nan_to_num(np.abs(points.velocities[-1]))
    if last.max(initial=0.0) > REST.get(controller, np.inf):
        joint = int(last.argmax())
        raise PlannercheckError(
            f"the last point has velocity {points.velocities[-1, joint]:.3g} in {points.named(joint)}:"
            f" {controller} refuses a trajectory that does not end at rest; set the last velocities to 0"
        )
    v, a = points.has_velocities, points.has_accelerations
    wrong = a[:-1] & a[1:] & ~(v[:-1] & v[1:])
    if wrong.any():
        raise PlannercheckError(
            f"points {int(np.argmax(wrong))} and {int(np.argmax(wrong)) + 1} have accelerations without velocities:"
            " joint_trajectory_controller would command 0 on every joint between them; give velocities as well,"
            " or leave accelerations out"
        )


def _approached(points: Points, start: Points, continuous: Sequence[int], controller: Controller) -> Points:
    """The points with the one before them, where the robot stands."""
    first = points.positions[0]
    from_there = start.positions[0].copy()
    for joint in continuous:
        way = np.remainder(first[joint] - from_there[joint] + np.pi, 2 * np.pi) - np.pi
        if abs(abs(way) - np.pi) < _TIE:
            way = abs(way) if first[joint] > from_there[joint] else -abs(way)
        from_there[joint] = first[joint] - way
    if points.times[0] == 0.0 or controller == "motoros2":
        if not np.array_equal(from_there, first):
            joint = int(np.abs(from_there - first).argmax())
            off = f"differs from start by {abs(from_there - first)[joint]:.3g} in {points.named(joint)}"
            if controller == "motoros2":
                raise PlannercheckError(f"the first point {off}: motoros2 refuses it; let the first point be start")
            raise PlannercheckError(
                f"the first point is at 0 s and {off}: the robot would jump; give the first point a later time"
            )
        return points
    zero = np.zeros_like(first)
    velocities = start.velocities[0] if start.has_velocities[0] and controller != "ur" else zero
    accelerations = start.accelerations[0] if start.has_accelerations[0] else zero
    before = (np.zeros(1), from_there[None], velocities[None], accelerations[None])
    after = (points.times, points.positions, points.velocities, points.accelerations)
    times, positions, velocities, accelerations = (np.concatenate(pair) for pair in zip(before, after, strict=True))
    return Points(times, positions, velocities, accelerations, points.joint_names)


def _conditions(points: Points, k: int) -> tuple[Floats, Floats | None, Floats | None]:
    """What both ends of the segment from point k have: positions, velocities and accelerations, (2, nq) each."""
    q, v, a = (each[k : k + 2] for each in (points.positions, points.velocities, points.accelerations))
    if np.isnan(v).any():
        return q, None, None
    return q, v, None if np.isnan(a).any() else a


def _control_points(ends: Floats, velocities: Floats | None, accelerations: Floats | None, h: float) -> Floats:
    """Control points of a segment of duration h."""
    p, q = ends
    if velocities is None:
        return ends
    v, w = velocities
    if accelerations is None:
        return np.stack([p, p + v * (h / 3), q - w * (h / 3), q])
    a, b = accelerations
    fifth, twentieth = h / 5, h * h / 20
    return np.stack(
        [p, p + v * fifth, p + 2 * v * fifth + a * twentieth, q - 2 * w * fifth + b * twentieth, q - w * fifth, q]
    )


def _spline_velocities(steps: Floats, positions: Floats) -> Floats:
    """Velocities (n, nq) of the spline with continuous accelerations that is at rest at both ends, by elimination.

    The row of an inner point is scaled so that its neighbours' shares add up to 1: alpha, 2, beta.
    """
    slopes = np.diff(positions, axis=0) / steps[:, None]
    alpha = steps[1:] / (steps[:-1] + steps[1:])
    beta = steps[:-1] / (steps[:-1] + steps[1:])
    velocities, shares = np.zeros_like(positions), np.zeros(len(positions))
    for k in range(1, len(steps)):
        pivot = 2 - alpha[k - 1] * shares[k - 1]
        shares[k] = beta[k - 1] / pivot
        right = 3 * (alpha[k - 1] * slopes[k - 1] + beta[k - 1] * slopes[k])
        velocities[k] = (right - alpha[k - 1] * velocities[k - 1]) / pivot
    for k in range(len(steps) - 1, 0, -1):
        velocities[k] -= shares[k] * velocities[k + 1]
    return velocities
