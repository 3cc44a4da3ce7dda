"""Motions that are proved free: the checker's bodies and pairs for the compiled certifier (cpp/motion_certifier.hpp).

In: a robot, bodies, pairs. Out: `MotionCertifier`, which judges the straight segments between configurations, every
joint on its own way: revolute and prismatic joints linearly, continuous ones the short way round, quaternions by slerp,
floating and planar bases along one screw (Pinocchio's interpolation).

What is proved is proved for exact kinematics, and holds for the poses that are computed: the certificates' gaps exceed
what rounding moves (`Robot.kinematic_error`, and the core's own bound).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from plannercheck.certificates import Separation
from plannercheck.core import core
from plannercheck.errors import PlannercheckError
from plannercheck.hull import Polytope
from plannercheck.motion_chains import motion_chains
from plannercheck.pair import certify
from plannercheck.robot import Robot
from plannercheck.shapes import Body

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Ints = NDArray[np.int32]

# A motion whose clearance falls below this may be refused, m: no robot follows a path so closely.
DEFAULT_TOLERANCE = 1e-4

# Two bodies that never move against each other and are further apart than this, m, are so at every configuration:
# far above the rounding of kinematics.
_LASTING_GAP = 1e-9

# Beyond the limits by this much, rad and m, the bound of kinematic rounding is computed once for all.
_MARGIN = 10.0

# MotionAnswer in cpp/motion_certifier.hpp.
_FREE, _REFUSED, _IMPRECISE = 0, 1, 2


class Proof(NamedTuple):
    """What proves a pair apart on an interval.

    Attributes:
        pair: Row of the checker's pairs.
        start: Parameter.
        end: Parameter.
        frame: Index of the link in whose frame the direction is, -1 for the world.
        flipped: Whether the direction points from the pair's first body to its second, else the other way.
        direction: (3,) unit vector up to rounding.
        gap: Along it both bodies are at least this far apart at both ends, m.
        bulge: Their points leave their chords by at most this, which is less than the gap, m.
    """

    pair: int
    start: float
    end: float
    frame: int
    flipped: bool
    direction: Floats
    gap: float
    bulge: float


class Passage(NamedTuple):
    """How far a motion is free.

    Attributes:
        free: Whether all of it is.
        free_until: It is proved free up to this parameter.
        near: If not free: the parameter at which the pair is within the tolerance.
        pair: If not free: row of the checker's pairs; else -1.
        proofs: If wanted, what proves it free up to `free_until`.
    """

    free: bool
    free_until: float
    near: float
    pair: int
    proofs: tuple[Proof, ...] = ()


class MotionCertifier:
    """Judges motions of one robot among given pairs of bodies. Immutable, so threads may share it."""

    def __init__(
        self,
        robot: Robot,
        bodies: Sequence[Body],
        pairs: NDArray[np.int32],
        polytopes: Sequence[Polytope | None],
        body_poses: Floats,
        excess: float,
    ) -> None:
        """Digests chains of joints.

        Args:
            robot: The robot.
            bodies: The robot's, then the scene's.
            pairs: (k, 2) indices into bodies.
            polytopes: The prepared body of each; None where no pair needs it.
            body_poses: (bodies, 4, 4) at the reference configuration.
            excess: Of curved shapes.

        Raises:
            PlannercheckError: If Pinocchio itself has to pose the robot.
        """
        if robot.kinematics is None or robot.joint_table is None:
            raise PlannercheckError(
                f"motions of {robot.name!r} can't be certified, since Pinocchio itself has to pose it: choose sampled "
                "motions by resolution=, in m"
            )
        self._robot = robot
        links = [_link_of(robot, body) for body in bodies]
        table, polytopes = _ordered(pairs, links), list(polytopes)
        self._flipped = table[:, 0] != pairs[:, 0]
        moving = np.array([links[a] >= 0 for a, _ in table.tolist()], dtype=bool)
        self._rows = np.flatnonzero(moving)
        self._touching = [
            int(k) for k in np.flatnonzero(~moving) if not _lastingly_apart(table[k], polytopes, body_poses)
        ]
        chains = motion_chains(
            robot.model,
            robot.configuration_map,
            robot.joint_table,
            robot.frames,
            bodies,
            links,
            table[moving].astype(np.int64),
            excess,
        )
        self._chained = chains.pairs
        live = [k for k, polytope in enumerate(polytopes) if polytope is not None]
        position = np.full(len(bodies), -1, dtype=np.int32)
        position[live] = np.arange(len(live))
        rows, *arrays = chains.arrays()
        rows[:, :2] = position[rows[:, :2].astype(np.int64)]
        standing = [k for k in live if links[k] < 0]
        placements = np.array([body.pose for body in bodies], dtype=np.float64).reshape(-1, 4, 4)
        placements[standing] = body_poses[standing]
        self._core = core.MotionCertifier(
            [polytope.core for polytope in polytopes if polytope is not None],
            np.array([links[k] for k in live], dtype=np.int32),
            np.ascontiguousarray(placements[live]),
            rows,
            *arrays,
            robot.nq,
            len(robot.link_names),
            chains.defect,
            chains.leverage,
        )
        low, high = robot.configuration_map.sampled_range()
        self._low, self._high = low - _MARGIN, high + _MARGIN
        self._error = robot.kinematic_error_within(self._low, self._high)

    def check(self, q0: Floats, q1: Floats, tolerance: float, threads: int) -> Bools:
        """Whether each motion (n, nq) to (n, nq) is free.

        Args:
            q0: Starts, validated.
            q1: Ends; numbers that are no quaternions or the like are gone through linearly.
            tolerance: m.
            threads: How many to use.

        Returns:
            (n,) True means proved free, False that some pair comes within the tolerance.
        """
        check_tolerance(tolerance)
        error = self._kinematic_error(q0, q1)
        answers = np.asarray(self._core.check(self._robot.kinematics, q0, q1, tolerance, error, threads))
        if (answers == _IMPRECISE).any():
            raise imprecise(int(np.argmax(answers == _IMPRECISE)), tolerance)
        return np.asarray((answers == _FREE) & (not self._touching))

    def is_free(self, q0: list[float], q1: list[float], tolerance: float) -> bool:
        """`check` of one motion between configurations given as lists: what planners call.

        Args:
            q0: nq numbers; those of quaternions and the like must be of length 1.
            q1: nq numbers.
            tolerance: m.

        Returns:
            True means proved free.
        """
        check_tolerance(tolerance)
        if self._touching:
            return False
        answer: int = self._core.check_one(
            self._robot.kinematics, q0, q1, self._low, self._high, tolerance, self._error
        )
        if answer <= _REFUSED:
            return answer == _FREE
        starts, ends = self._robot.check_configurations(q0), self._robot.check_configurations(q1)
        return bool(self.check(starts, ends, tolerance, 1)[0])

    def passage(self, q0: Floats, q1: Floats, tolerance: float, proofs: bool = False) -> Passage:
        """How far one motion (nq,) to (nq,) is free, looked at from its start.

        Args:
            q0: Start, validated.
            q1: End.
            tolerance: m.
            proofs: Whether to give those of all pairs that can move against each other.

        Returns:
            The passage.
        """
        check_tolerance(tolerance)
        if self._touching:
            return Passage(False, 0.0, 0.0, self._touching[0])
        error = self._kinematic_error(q0[None], q1[None])
        answer, until, near, row, *found = self._core.explain(self._robot.kinematics, q0, q1, tolerance, error, proofs)
        if answer == _IMPRECISE:
            raise imprecise(0, tolerance)
        listed = tuple(proof for proof in self._proofs(*found) if proof.start < until)
        if answer == _FREE:
            return Passage(True, 1.0, -1.0, -1, listed)
        return Passage(False, until, near, int(self._rows[row]), listed)

    def _proofs(self, pairs: Ints, intervals: Floats, directions: Floats, gaps: Floats) -> list[Proof]:
        rows = zip(pairs.tolist(), intervals.tolist(), directions, gaps.tolist(), strict=True)
        return [
            Proof(
                int(self._rows[k]),
                start,
                end,
                self._chained[k].frame,
                bool(self._flipped[self._rows[k]]),
                direction,
                gap,
                bulge,
            )
            for k, (start, end), direction, (gap, bulge) in rows
        ]

    def states(self, q0: Floats, q1: Floats, parameters: Floats) -> Floats:
        """(k, nq) of one motion (nq,) to (nq,) at parameters (k,) in [0, 1]."""
        return np.asarray(self._core.states(q0, q1, parameters))

    def statistics(self) -> dict[str, Any]:
        """Counters of all calls so far."""
        return dict(self._core.statistics())

    def _kinematic_error(self, q0: Floats, q1: Floats) -> float:
        """The bound for all configurations on these motions, m."""
        if ((q0 >= self._low) & (q0 <= self._high) & (q1 >= self._low) & (q1 <= self._high)).all():
            return self._error
        low = np.minimum(self._low, np.minimum(q0, q1).min(axis=0))
        high = np.maximum(self._high, np.maximum(q0, q1).max(axis=0))
        return self._robot.kinematic_error_within(low, high)


def _link_of(robot: Robot, body: Body) -> int:
    """Index of a body's link; -1 if it stands still whatever the joints do."""
    if body.link is None:
        return -1
    link = robot.link_index(body.link)
    return -1 if robot.kinematics is None or robot.kinematics.link_is_constant(link) else link


def _ordered(pairs: NDArray[np.int32], links: Sequence[int]) -> NDArray[np.int32]:
    """Pairs with a body that moves first, if there is one."""
    table = pairs.copy()
    swapped = np.array([links[a] < 0 <= links[b] for a, b in pairs.tolist()], dtype=bool)
    table[swapped] = table[swapped][:, ::-1]
    return table


def _lastingly_apart(pair: NDArray[np.int32], polytopes: Sequence[Polytope | None], poses: Floats) -> bool:
    p, r = (polytopes[int(k)] for k in pair)
    assert p is not None
    assert r is not None
    certificate = certify(p, r, poses[pair[0]], poses[pair[1]])
    return isinstance(certificate, Separation) and certificate.gap > _LASTING_GAP


def check_tolerance(tolerance: float) -> None:
    """Raises an error if a tolerance is no positive length."""
    if not 0 < tolerance < float("inf"):
        raise PlannercheckError(f"tolerance must be a positive length in m, not {tolerance!r}")


def imprecise(row: int, tolerance: float) -> PlannercheckError:
    """The error for a motion whose rounding exceeds a part of the tolerance."""
    return PlannercheckError(
        f"motion {row}: lengths and angles are so large that rounding is no small part of the tolerance of "
        f"{tolerance:g} m; choose a larger tolerance, or smaller numbers"
    )
