"""`pc.time_path`: a plan as a trajectory that is proved as the controller will run it.

In: a checker, a plan's waypoints, limits. Out: a `Trajectory`: points with positions, velocities and accelerations,
between which joint_trajectory_controller runs quintic polynomials; these are proved, tube included.

Legs are proved first, because a blend can become a stop only between proved legs. Blends are halved until each is
proved. The rounded path is timed, and the controller's curve through the points is proved as a whole. If this proof
fails, points are set closer, so that the curve is nearer to the path; at the finest step, the failing blends are
halved, down to stops.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.checking.named_configurations import given_configurations
from plannercheck.common.angles import nearest_turns
from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.public_names import set_module
from plannercheck.motions.certifier import DEFAULT_TOLERANCE
from plannercheck.motions.checker import Checker
from plannercheck.robots.robot import Robot
from plannercheck.timing.rounded_path import Legs, sections
from plannercheck.timing.timed_section import HALVINGS, TimedSection, joined, timed
from plannercheck.trajectories import joint_limits
from plannercheck.trajectories.curve import Curve
from plannercheck.trajectories.joint_columns import check_plain_joints
from plannercheck.trajectories.joint_limits import JointLimits
from plannercheck.trajectories.timing import Timing
from plannercheck.trajectories.trajectory import Trajectory

# A blend is halved so often; then the trajectory stops at the corner.
_BLEND_HALVINGS = 6

# Plans have motions that are proved although they come nearer than the tolerance. Where a part of such a motion is
# refused, this part of the tolerance is taken.
_FINER = 0.01


@set_module("plannercheck")
class UnprovedPathError(PlannercheckError):
    """A path that can't be timed, since a part of it is not proved free: the message names the part."""


@dataclass(frozen=True)
class _Judge:
    """What is to be proved."""

    checker: Checker
    tube: ArrayLike
    tolerance: float

    def free(self, trajectories: Sequence[Trajectory]) -> Bools:
        """(n,) which trajectories are proved."""
        return self.checker.check_trajectories(trajectories, tube=self.tube, tolerance=self.tolerance)

    def stopping(self, leg: Floats) -> tuple[str, str] | None:
        """The pair that stops the proof of a leg (2, nq); None if the leg is proved."""
        verdict = self.checker.explain_trajectory(_polynomial(leg), self.tube, self.tolerance)
        return verdict.pair.names if verdict.pair is not None else None

    def free_pieces(self, pieces: Iterable[Floats]) -> Bools:
        """(n,) which polynomials are proved, by their control points (degree + 1, nq)."""
        return self.free([_polynomial(each) for each in pieces])


def _polynomial(points: Floats) -> Trajectory:
    return Trajectory.of_curve(Curve(np.array([0.0, 1.0]), (points,), np.zeros(points.shape[1])))


@set_module("plannercheck")
def time_path(
    checker: Checker,
    path: Any,
    velocity: ArrayLike | str | Path | None,
    acceleration: ArrayLike | str | Path,
    blend: float = 0.1,
    tube: ArrayLike = 0.0,
    tolerance: float = DEFAULT_TOLERANCE,
) -> Trajectory:
    """Times a plan, so that it is proved as joint_trajectory_controller will run it.

    Args:
        checker: Proves it. Its robot's joints take one number each.
        path: (k, nq) waypoints, rad and m, or a solved `Plan`. Continuous joints go the short way round, as in plans.
        velocity: (nq,) largest speeds or one number, rad/s and m/s; a joint_limits.yaml of MoveIt; or None for the
            URDF's.
        acceleration: (nq,) largest accelerations or one number, rad/s² and m/s²; or a joint_limits.yaml.
        blend: How far from a corner its blend may pass at most, rad and m (MoveIt's path_tolerance). 0: stop at each.
        tube: How far joints may be off the trajectory in the proof, (nq,) or one number, rad and m.
        tolerance: What comes nearer to a collision than this may be refused, m. Where a path is refused, a hundredth is
            tried, too.

    Returns:
        The trajectory, from rest to rest. The limits hold between its points as well. Its attribute `timing` tells
        what the blends save and how many had to be cut.

    Raises:
        PlannercheckError: If an argument is malformed, a joint that moves has no acceleration limit, or some segment of
            the path is not proved.
    """
    if not isinstance(checker, Checker):
        raise PlannercheckError(f"checker must be a pc.Checker, not {checker!r:.80}")
    robot = checker.robot
    waypoints = _waypoints(robot, path)
    legs = Legs.through(waypoints)
    if len(legs.points) < 2:
        raise PlannercheckError(f"the path of {len(waypoints)} configurations stays where it is: there is no motion")
    if not isinstance(blend, Real) or isinstance(blend, bool) or not blend >= 0:
        raise PlannercheckError(f"blend must be at least 0, not {blend!r:.40}")
    limits = _limits(robot, velocity, acceleration, np.ptp(legs.points, axis=0) > 0)
    wanted = legs.blends(blend)
    judge = _Judge(checker, tube, tolerance)
    try:
        trajectory, sizes = _proved(judge, legs, limits, wanted)
    except UnprovedPathError:
        judge = replace(judge, tolerance=tolerance * _FINER)
        trajectory, sizes = _proved(judge, legs, limits, wanted)
    stopping = joined(_all_timed(legs, limits, np.zeros_like(wanted))[0], robot.joint_names)
    if stopping.duration < trajectory.duration and judge.free([stopping])[0]:
        trajectory, sizes = stopping, np.zeros_like(wanted)
    trajectory.timing = Timing(
        saved=stopping.duration - trajectory.duration,
        corners=len(wanted) - 2,
        stops=int((sizes[1:-1] == 0).sum()),
        cut=int((sizes < wanted).sum()),
        tolerance=judge.tolerance,
    )
    return trajectory


def _waypoints(robot: Robot, path: Any) -> Floats:
    """(k, nq) the path's configurations, each within half a turn of the one before."""
    check_plain_joints(robot)
    if getattr(path, "solved", True) is False:
        raise PlannercheckError(f"the plan has no path: {path.reason}")
    rows = given_configurations(robot, getattr(path, "path", path)).copy()
    if not len(rows):
        raise PlannercheckError("the path has no configurations: there is no motion")
    turning = np.flatnonzero(robot.configuration_map.turning_columns())
    for k in range(1, len(rows)):
        rows[k, turning] = nearest_turns(rows[k - 1, turning], rows[k, turning])
    return rows


def _limits(
    robot: Robot, velocity: ArrayLike | str | Path | None, acceleration: ArrayLike | str | Path, moves: Bools
) -> JointLimits:
    """The limits of a robot's joints; joints that rest have limits of 1."""
    speeds = joint_limits.largest_speeds(robot, velocity)
    bends = joint_limits.largest_accelerations(robot, acceleration)
    unlimited = moves & ~np.isfinite(bends)
    if unlimited.any():
        name = robot.joint_names[int(np.argmax(unlimited))]
        raise PlannercheckError(f"joint {name!r} moves and has no acceleration limit: a plan can't be timed without")
    return JointLimits(np.where(moves, speeds, 1.0), np.where(moves, bends, 1.0))


def _check_legs(judge: _Judge, legs: Legs) -> None:
    free = judge.free_pieces(legs.points[k : k + 2] for k in range(len(legs.lengths)))
    if not free.all():
        raise _refused(judge, legs, int(np.argmin(free)))


def _refused(judge: _Judge, legs: Legs, k: int) -> UnprovedPathError:
    where = f"the path's segment from configuration {legs.given[k]} to {legs.given[k + 1]}"
    tube = f" with a tube of {judge.tube!s:.80}" if np.any(judge.tube) else ""
    pair = judge.stopping(legs.points[k : k + 2])
    between = f" between {pair[0]} and {pair[1]}" if pair else ""
    remedy = "a smaller tube, or a plan with padding" if tube else "a plan whose every motion is proved"
    return UnprovedPathError(f"{where} is not proved free{between}{tube}: needs {remedy}")


def _proved_blends(judge: _Judge, legs: Legs, wanted: Floats) -> Floats:
    """(k,) lengths of blends that are proved; 0 where none is."""
    sizes = wanted.copy()
    unproved = np.flatnonzero(sizes)
    while len(unproved):
        free = judge.free_pieces(legs.blend(corner, sizes[corner]) for corner in unproved.tolist())
        unproved = unproved[~free]
        sizes[unproved] = _halved(sizes[unproved], wanted[unproved])
        unproved = unproved[sizes[unproved] > 0]
    return sizes


def _halved(sizes: Floats, wanted: Floats) -> Floats:
    return np.where(sizes > wanted * 0.5**_BLEND_HALVINGS, sizes / 2, 0.0)


def _proved(judge: _Judge, legs: Legs, limits: JointLimits, wanted: Floats) -> tuple[Trajectory, Floats]:
    """The trajectory that is proved, and its blends (k,), at most those wanted."""
    _check_legs(judge, legs)
    sizes = _proved_blends(judge, legs, wanted)
    halvings = 0
    while True:
        parts, sizes = _all_timed(legs, limits, sizes, halvings)
        trajectory = joined(parts, judge.checker.robot.joint_names)
        if judge.free([trajectory])[0]:
            return trajectory, sizes
        if halvings < HALVINGS:
            halvings += 1
            continue
        corners, refused_legs = _failing(judge, parts, trajectory)
        corners = corners or [end for leg in refused_legs for end in (leg, leg + 1) if sizes[end] > 0]
        if not corners:
            raise _refused(judge, legs, min(refused_legs, default=0))
        sizes = sizes.copy()
        sizes[corners] = _halved(sizes[corners], wanted[corners])


def _all_timed(legs: Legs, limits: JointLimits, sizes: Floats, halvings: int = 0) -> tuple[list[TimedSection], Floats]:
    """The sections with their points, and the blends (k,): none where TOPP-RA finds no law through them."""
    sizes = sizes.copy()
    while True:
        parts, lawless = list[TimedSection](), list[int]()
        for section in sections(legs, sizes):
            found = timed(section, limits, halvings)
            if found is not None:
                parts.append(found)
                continue
            if len(section.legs) == 1:
                first, last = legs.given[section.legs[0]], legs.given[section.legs[0] + 1]
                raise PlannercheckError(f"TOPP-RA finds no time law from configuration {first} of the path to {last}")
            lawless += [corner for corner in section.corners if corner is not None]
        if not lawless:
            return parts, sizes
        sizes[lawless] = 0.0


def _failing(judge: _Judge, parts: Sequence[TimedSection], trajectory: Trajectory) -> tuple[list[int], list[int]]:
    """Corners whose blends, and legs whose rests, are not proved as the controller runs them."""
    curve, start = trajectory.curve, 0
    owners: list[tuple[int | None, int]] = []
    curves: list[Trajectory] = []
    for part in parts:
        for piece, owner in enumerate(zip(part.section.corners, part.section.legs, strict=True)):
            here = start + np.flatnonzero(part.pieces == piece)
            if len(here):
                owners.append(owner)
                ends = curve.breaks[here[0] : here[-1] + 2]
                curves.append(Trajectory.of_curve(Curve(ends, curve.pieces[here[0] : here[-1] + 1], curve.error)))
        start += len(part.pieces)
    refused = [owner for owner, free in zip(owners, judge.free(curves).tolist(), strict=True) if not free]
    corners = [corner for corner, _ in refused if corner is not None]
    return corners, [leg for corner, leg in refused if corner is None]
