"""Limits that a chunk breaks: positions, speeds and accelerations, also between its waypoints.

In: a run, a robot's limits, settings. Out: which pieces keep them (fast), and which `Excess` there are (in words).

Between straight pieces the velocity jumps. Such a corner counts as the acceleration that changes the velocity within
the mean of both pieces' durations, as differences of waypoints do; at the start, from the robot's velocity within the
first piece's duration.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from plannercheck.common.array_types import Bools, Floats
from plannercheck.robots.robot import Robot
from plannercheck.trajectories.curve import Curve, differentiated
from plannercheck.trajectories.limits import KINDS, Excess, Kind, broken_limits
from plannercheck.validation.gates.chunks import Run
from plannercheck.validation.gates.settings import GateSettings

# Waypoints that are clamped to a limit exceed it, as times are whole nanoseconds: limits hold to this part of
# themselves, which is 1 ns of 1 ms.
ROUNDED = 1e-6


@dataclass(frozen=True, eq=False)
class GateLimits:
    """The limits that chunks of a robot have to keep.

    Attributes:
        names: The joints.
        lower: (nq,) rad and m.
        upper: (nq,) rad and m.
        velocity: (nq,) rad/s and m/s.
        acceleration: (nq,) rad/s² and m/s², inf where there is none.
    """

    names: tuple[str, ...]
    lower: Floats
    upper: Floats
    velocity: Floats
    acceleration: Floats

    @classmethod
    def of(cls, robot: Robot, settings: GateSettings) -> GateLimits:
        """Limits with what rounding exceeds."""
        more = 1 + ROUNDED
        return cls(robot.joint_names, robot.lower, robot.upper, settings.velocity * more, settings.acceleration * more)

    @property
    def has_accelerations(self) -> bool:
        """Whether any joint has a largest acceleration."""
        return bool((self.acceleration < np.inf).any())

    def kept(self, run: Run, velocities: Floats, dq: Floats) -> Bools:
        """(m,) which pieces surely keep all limits, by their control points; straight ones exactly.

        Velocities (m, degree, nq) are theirs, dq (nq,) is the robot's at the start.
        """
        good = np.asarray(((run.points >= self.lower) & (run.points <= self.upper)).all(axis=(1, 2)))
        good &= (np.abs(velocities) <= self.velocity).all(axis=(1, 2))
        good[0] &= (np.abs(dq) <= self.velocity).all()
        if self.has_accelerations:
            good &= (np.abs(corners(run, velocities, dq)) <= self.acceleration).all(axis=1)
            if run.degree > 1:
                bends = differentiated(velocities, run.steps[:, None, None])
                good &= (np.abs(bends) <= self.acceleration).all(axis=(1, 2))
        return good

    def kept_exactly(self, run: Run, velocities: Floats, dq: Floats) -> Bools:
        """`kept`, by the extremes of curved pieces."""
        good = self.kept(run, velocities, dq)
        if run.degree > 1:
            for k in np.flatnonzero(~good).tolist():
                at_corner = np.abs(corners(run, velocities, dq)[k]) <= self.acceleration
                at_start = k > 0 or (np.abs(dq) <= self.velocity).all()
                good[k] = at_corner.all() and at_start and not self.broken(run.curve(k, k + 1))
        return good

    def hold(self, rows: Floats) -> Bools:
        """(n,) which configurations (n, nq) are within the limits of positions."""
        return np.asarray(((rows >= self.lower) & (rows <= self.upper)).all(axis=1))

    def broken(self, curve: Curve) -> list[Excess]:
        """The limits that a curve breaks: for each joint and kind the worst."""
        bounds = (self.lower, self.upper), (-self.velocity, self.velocity), (-self.acceleration, self.acceleration)
        found = [broken_limits(curve, self.names, kind, *each) for kind, each in zip(KINDS, bounds, strict=True)]
        return [excess for some in found for excess in some]

    def broken_at_corners(self, run: Run, dq: Floats) -> list[Excess]:
        """The accelerations of corners that are too large, for each joint the worst, and speeds at the start."""
        at_corners = corners(run, run.velocities(), dq)
        found = [self._excess("velocity", j, 0.0, dq[j]) for j in np.flatnonzero(np.abs(dq) > self.velocity).tolist()]
        over = np.abs(at_corners) - self.acceleration
        for j in np.flatnonzero((over > 0).any(axis=0)).tolist():
            k = int(over[:, j].argmax())
            found.append(self._excess("acceleration", j, float(run.breaks[k]), at_corners[k, j]))
        return found

    def _excess(self, kind: Kind, joint: int, time: float, value: float) -> Excess:
        limit = (self.velocity if kind == "velocity" else self.acceleration)[joint]
        return Excess(self.names[joint], kind, time, float(value), float(np.copysign(limit, value)))


def corners(run: Run, velocities: Floats, dq: Floats) -> Floats:
    """(m, nq) accelerations at the begins of pieces; of curved pieces, which meet smoothly, at the start alone."""
    found = np.zeros((len(run.steps), len(dq)))
    found[0] = (velocities[0, 0] - dq) / run.steps[0]
    if run.degree == 1:
        found[1:] = np.diff(velocities[:, 0], axis=0) / ((run.steps[:-1] + run.steps[1:]) / 2)[:, None]
    return found


def without_rounding(excess: Excess) -> Excess:
    """An excess beyond the limit as it was given."""
    return excess if excess.kind == "position" else replace(excess, limit=excess.limit / (1 + ROUNDED))
