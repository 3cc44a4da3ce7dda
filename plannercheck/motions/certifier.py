"""Motions that are proved free: the checker's bodies and pairs for the compiled certifier (motion_certifier.hpp).

In: a robot, bodies, pairs. Out: `MotionCertifier`, which judges the straight segments between configurations, every
joint on its own way: revolute and prismatic joints linearly, continuous ones the short way round, quaternions by slerp,
floating and planar bases along one screw (Pinocchio's interpolation).

What is proved is proved for exact kinematics, and holds for the poses that are computed: the certificates' gaps exceed
what rounding moves (`Robot.kinematic_error`, and the core's own bound).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.shapes import Body
from plannercheck.checking.compiled_pairs import CompiledPairs, added
from plannercheck.common.core import core
from plannercheck.common.errors import PlannercheckError
from plannercheck.motions.certifier_pairs import ChainedPairs
from plannercheck.robots.robot import Robot

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Ints = NDArray[np.int32]

# A motion whose clearance falls below this may be refused, m: no robot follows a path so closely.
DEFAULT_TOLERANCE = 1e-4

# Beyond the limits by this much, rad and m, the bound of kinematic rounding is computed once for all.
_MARGIN = 10.0

# Continuous joints are within it up to here, rad.
NEAR_TURNS = math.pi + _MARGIN

# Parts of the tolerance with which pairs are proved that can't meet within the limits, but may be nearer than it: they
# are further apart than `reach.MARGIN`, a hundredth of the default.
_FINER = (1.0, 1e-2, 1e-4)

# MotionAnswer in cpp/motions/motion_certifier.hpp.
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
        proofs: If wanted, what proves it free, all pairs, up to `proved_until`.
        proved_until: That is `free_until`, or less if a pair that can't meet within the limits is nearer all the time
            than rounding allows to prove.
    """

    free: bool
    free_until: float
    near: float
    pair: int
    proofs: tuple[Proof, ...] = ()
    proved_until: float = 0.0


class MotionCertifier:
    """Judges motions of one robot among given pairs of bodies. Immutable, so threads may share it.

    Motions within the limits are judged without the pairs that can't meet there, as configurations are.
    """

    def __init__(
        self,
        robot: Robot,
        bodies: Sequence[Body],
        pairs: Ints,
        live: CompiledPairs,
        whole: Callable[[], CompiledPairs],
        limits: tuple[Floats, Floats] | None,
        excess: float,
        hints: bool,
    ) -> None:
        """Digests chains of joints.

        Args:
            robot: The robot.
            bodies: The robot's, then the scene's.
            pairs: (k, 2) indices into bodies.
            live: Those that can meet within the limits.
            whole: All of them.
            limits: Between which `live` are enough; None for anywhere.
            excess: Of curved shapes.
            hints: Whether planes of earlier motions are tried; verdicts do not depend on it.

        Raises:
            PlannercheckError: If Pinocchio itself has to pose the robot.
        """
        if robot.kinematics is None or robot.joint_table is None:
            raise PlannercheckError(
                f"motions of {robot.name!r} can't be certified, since Pinocchio itself has to pose it: choose sampled "
                "motions by resolution=, in m"
            )
        self._robot = robot
        self._live = ChainedPairs(robot, bodies, pairs, live, excess, hints)
        self._compile_whole: Callable[[], ChainedPairs] = lambda: ChainedPairs(
            robot, bodies, pairs, whole(), excess, hints
        )
        self._limits = limits
        low, high = robot.configuration_map.sampled_range()
        self._low, self._high = low - _MARGIN, high + _MARGIN
        self._error = robot.kinematic_error_within(self._low, self._high)
        self._far_errors: dict[bytes, float] = {}
        self._turns = bool(robot.configuration_map.turning_columns().any())
        self._range = self._low, self._high
        if limits is not None:
            self._range = np.maximum(limits[0], self._low), np.minimum(limits[1], self._high)

    @cached_property
    def _whole(self) -> ChainedPairs:
        return self._live if self._limits is None else self._compile_whole()

    def check(self, q0: Floats, q1: Floats, tolerance: float, threads: int, given: Floats | None = None) -> Bools:
        """Whether each motion (n, nq) to (n, nq) is free.

        Args:
            q0: Starts, validated.
            q1: Ends; numbers that are no quaternions or the like are gone through linearly.
            tolerance: m.
            threads: How many to use.
            given: (n, nq) the ends before whole turns were taken off, if any were: they are posed with more rounding.

        Returns:
            (n,) True means proved free, False that some pair comes within the tolerance.
        """
        check_tolerance(tolerance)
        within = self._within_limits(q0, q1)
        by_error = self._errors(q0, q1, q1 if given is None else given)
        free = np.empty(len(q0), dtype=bool)
        for rows, whole in ((np.flatnonzero(within), False), (np.flatnonzero(~within), True)):
            if len(rows):
                part = self._whole if whole else self._live
                for error, chosen in by_error(rows):
                    free[chosen] = self._judged(part, q0, q1, chosen, tolerance, error, threads)
        return free

    def _judged(
        self,
        part: ChainedPairs,
        q0: Floats,
        q1: Floats,
        rows: NDArray[np.int64],
        tolerance: float,
        error: float,
        threads: int,
    ) -> Bools:
        """Some rows by some pairs; `error` is the bound of their kinematics' rounding."""
        if part.touching:  # at every state, so that nothing else matters
            return np.zeros(len(rows), dtype=bool)
        starts, ends = (q0, q1) if len(rows) == len(q0) else (q0[rows], q1[rows])
        answers = np.asarray(part.core.check(self._robot.kinematics, starts, ends, tolerance, error, threads))
        if (answers == _IMPRECISE).any():
            raise imprecise(int(rows[np.argmax(answers == _IMPRECISE)]), tolerance)
        return np.asarray(answers == _FREE)

    def _within_limits(self, q0: Floats, q1: Floats) -> Bools:
        """(n,) whether both ends are, so that all states between them are, up to rounding."""
        if self._limits is None:
            return np.ones(len(q0), dtype=bool)
        low, high = self._limits
        return np.asarray(((q0 >= low) & (q0 <= high) & (q1 >= low) & (q1 <= high)).all(axis=1))

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
        if self._live.touching:
            return False
        kinematics = self._robot.kinematics
        answer: int = self._live.core.check_one(kinematics, q0, q1, *self._range, tolerance, self._error)
        return answer == _FREE if answer <= _REFUSED else self._is_free_anywhere(q0, q1, tolerance)

    def _is_free_anywhere(self, q0: list[float], q1: list[float], tolerance: float) -> bool:
        starts, ends = self._robot.check_configurations([q0]), self._robot.check_configurations([q1])
        return bool(self.check(starts, ends, tolerance, 1)[0])

    def motion_validity(self, tolerance: float) -> Callable[[Any, Any], bool]:
        """`is_free` as a compiled function of two states of an OMPL RealVectorStateSpace of nq numbers."""
        check_tolerance(tolerance)
        if self._live.touching:
            return lambda s1, s2: False
        kinematics, low, high = self._robot.kinematics, *self._range
        judge: Callable[[Any, Any], bool] = core.motion_validity(
            self._live.core, kinematics, low, high, tolerance, self._error, partial(self._elsewhere, tolerance)
        )
        return judge

    def _elsewhere(self, tolerance: float, q0: list[float], q1: list[float]) -> bool:
        return self._is_free_anywhere(q0, q1, tolerance)

    def passage(
        self, q0: Floats, q1: Floats, tolerance: float, proofs: bool = False, given: Floats | None = None
    ) -> Passage:
        """How far one motion (nq,) to (nq,) is free, looked at from its start.

        Args:
            q0: Start, validated.
            q1: End.
            tolerance: m.
            proofs: Whether to give those of all pairs that can move against each other.
            given: (nq,) the end before whole turns were taken off.

        Returns:
            The passage.
        """
        check_tolerance(tolerance)
        within = self._within_limits(q0[None], q1[None])[0]
        part = self._live if within else self._whole
        if part.touching:
            return Passage(False, 0.0, 0.0, part.touching[0])
        error = self._kinematic_error(q0, q1, q1 if given is None else given)
        answer, until, near, row = part.core.explain(self._robot.kinematics, q0, q1, tolerance, error, False)[:4]
        if answer == _IMPRECISE:
            raise imprecise(0, tolerance)
        free = answer == _FREE
        found = Passage(True, 1.0, -1.0, -1) if free else Passage(False, until, near, int(part.rows[row]))
        if not proofs:
            return found
        reached, listed = self._listed(q0, q1, tolerance, error, found.free_until)
        return found._replace(proofs=tuple(p for p in listed if p.start < found.free_until), proved_until=reached)

    def _listed(
        self, q0: Floats, q1: Floats, tolerance: float, error: float, until: float
    ) -> tuple[float, list[Proof]]:
        """Proofs of all pairs up to a parameter, and up to where they reach.

        Pairs that can't meet within the limits may be within the tolerance all the same: then a finer one is taken, as
        long as rounding is a small part of it.
        """
        reached, listed = 0.0, list[Proof]()
        for finer in _FINER:
            answer, end, _, _, *found = self._whole.core.explain(
                self._robot.kinematics, q0, q1, finer * tolerance, error, True
            )
            if answer == _IMPRECISE:
                break
            reached, listed = (1.0 if answer == _FREE else end), _proofs(self._whole, *found)
            if reached >= until:
                break
        return min(reached, until), listed

    def states(self, q0: Floats, q1: Floats, parameters: Floats) -> Floats:
        """(k, nq) of one motion (nq,) to (nq,) at parameters (k,) in [0, 1]."""
        return np.asarray(self._live.core.states(q0, q1, parameters))

    def statistics(self) -> dict[str, Any]:
        """Counters of all calls so far."""
        counted = dict(self._live.core.statistics())
        return (
            counted
            if "_whole" not in vars(self) or self._whole is self._live
            else added(counted, self._whole.core.statistics())
        )

    def _kinematic_error(self, q0: Floats, q1: Floats, given: Floats) -> float:
        """What computed poses may be off by on one motion (nq,) to (nq,), whose end was given as `given`, m."""
        ((error, _),) = self._errors(q0[None], q1[None], given[None])(np.zeros(1, np.int64))
        return error

    def _errors(
        self, q0: Floats, q1: Floats, given: Floats
    ) -> Callable[[NDArray[np.int64]], list[tuple[float, NDArray[np.int64]]]]:
        """What puts rows of motions by the bound, m, that holds for both ends, as judged and as given, and between.

        A row's bound depends on nothing but the row: that of the range around the limits if the row is within it; else
        of one that reaches to the next powers of 2 in the columns in which it is not.
        """
        low, high = self._low, self._high
        near = (q0 >= low) & (q0 <= high) & (given >= low) & (given <= high)
        if self._turns:  # else these are the given ends
            near &= (q1 >= low) & (q1 <= high)
        if near.all():
            return lambda rows: [(self._error, rows)]
        furthest = np.max([np.abs(q0), np.abs(q1), np.abs(given)], axis=0)
        powers = np.where(near, -1.0, np.ceil(np.log2(np.maximum(furthest, 1.0))))
        return lambda rows: self._by_powers(powers[rows], rows)

    def _by_powers(self, powers: Floats, rows: NDArray[np.int64]) -> list[tuple[float, NDArray[np.int64]]]:
        kinds, kind_of = np.unique(powers, axis=0, return_inverse=True)
        return [(self._far_error(kind), rows[kind_of.ravel() == k]) for k, kind in enumerate(kinds)]

    def _far_error(self, powers: Floats) -> float:
        """The bound where columns (nq,) reach to powers of 2, -1 for those within the range."""
        if (powers < 0).all():
            return self._error
        key = powers.tobytes()
        if key not in self._far_errors:
            reach = np.where(powers < 0, 0.0, 2.0**powers)
            low, high = np.minimum(self._low, -reach), np.maximum(self._high, reach)
            self._far_errors[key] = self._robot.kinematic_error_within(low, high)
        return self._far_errors[key]


def _proofs(part: ChainedPairs, pairs: Ints, intervals: Floats, directions: Floats, gaps: Floats) -> list[Proof]:
    rows = zip(pairs.tolist(), intervals.tolist(), directions, gaps.tolist(), strict=True)
    return [
        Proof(int(part.rows[k]), start, end, part.frames[k], bool(part.flipped[k]), direction, gap, bulge)
        for k, (start, end), direction, (gap, bulge) in rows
    ]


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
