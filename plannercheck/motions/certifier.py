"""Proves motions free: a checker's bodies and pairs for the compiled certifier (cpp/motions/motion_certifier.hpp).

In: a robot, bodies, pairs. Out: `MotionCertifier`, which judges the straight segments between configurations, and
curves. Every joint moves by itself: revolute and prismatic joints linearly or by polynomials, continuous ones the short
way round on segments, quaternions by slerp, floating and planar bases along one screw (Pinocchio's interpolation), or
straight and turning by slerp (OMPL's in SE(3) and SE(2)).

Proofs are about exact kinematics and hold for computed poses as well, since the certificates' gaps exceed the rounding
of poses (`Robot.kinematic_error`, and the core's own bound).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property, partial
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.shapes import GeometryObject
from plannercheck.bodies.tuning import Tuning
from plannercheck.checking.compiled_tables import CompiledTables
from plannercheck.common.angles import nearest_turn
from plannercheck.common.array_types import Bools, Floats, Ints
from plannercheck.common.arrays import Configuration
from plannercheck.common.core import core
from plannercheck.common.counters import sum_counters
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.motion_paths import MotionPath
from plannercheck.motions.certifier_answers import (
    FREE,
    IMPRECISE,
    REFUSED,
    MotionResult,
    Proof,
    check_tolerance,
    motion_result_of,
    proofs_of,
    verdicts,
)
from plannercheck.motions.certifier_pairs import ChainedPairs
from plannercheck.motions.motion_ends import Curves, Motions
from plannercheck.motions.rounding_bounds import RoundingBounds
from plannercheck.robots.robot import Robot

# Judges one motion between two rows; None if Python has to judge it.
JudgeMotion = Callable[[Configuration, Configuration, float], bool | None]

# A motion whose clearance falls below this may be refused, m: no robot follows a path that closely.
DEFAULT_TOLERANCE = 1e-4

# Pairs that can't meet within the limits may still be nearer than the tolerance; they are proved with these parts of
# it. Their distance exceeds `unreachable_pairs.MARGIN`, a hundredth of the default tolerance.
_FINER = (1.0, 1e-2, 1e-4)

# The core's answer about a chunk of waypoints that it leaves open.
_UNKNOWN_CHUNK = 3


class MotionCertifier:
    """Judges motions of one robot among given pairs of bodies. Immutable, so threads may share it.

    As for configurations, motions within the limits are judged without the pairs that can't meet there.
    """

    def __init__(
        self,
        robot: Robot,
        bodies: Sequence[GeometryObject],
        pairs: Ints,
        tables: CompiledTables,
        excess: float,
        tuning: Tuning,
        path: MotionPath = "screw",
    ) -> None:
        """Prepares the chains of joints.

        Args:
            robot: The robot.
            bodies: The robot's bodies, then the scene's.
            pairs: (k, 2) indices into bodies.
            tables: These pairs, compiled: those that can meet within the limits, and all of them.
            excess: How far polytopes of curved shapes stick out, as a part of the radius.
            tuning: What saves work.
            path: How planar and floating joints move.

        Raises:
            PlannercheckError: If Pinocchio itself poses the robot.
        """
        if robot.kinematics is None or robot.joint_table is None:
            raise PlannercheckError(
                f"motions of {robot.name!r} can't be certified, since Pinocchio itself has to pose it: choose sampled "
                "motions by resolution=, in m"
            )
        self._robot, self._kernel, self._limits = robot, robot.kinematics, tables.limits
        mounts = tables.mounts(self._kernel)
        self._pairs_within_limits = ChainedPairs(
            robot, bodies, pairs, tables.within_limits, mounts, excess, tuning, path
        )
        self._compile_all_pairs: Callable[[], ChainedPairs] = lambda: ChainedPairs(
            robot, bodies, pairs, tables.all, mounts, excess, tuning, path
        )
        self._errors = errors = robot.remembered("rounding bounds", lambda: RoundingBounds(robot))
        self._range = errors.low, errors.high
        if self._limits is not None:
            self._range = np.maximum(self._limits[0], errors.low), np.minimum(self._limits[1], errors.high)

    @cached_property
    def _all_pairs(self) -> ChainedPairs:
        return self._pairs_within_limits if self._limits is None else self._compile_all_pairs()

    def pairs_by_table(self) -> tuple[ChainedPairs, ...]:
        """The pairs that judge motions within the limits, and those beyond if these are others."""
        within = self._pairs_within_limits
        return (within,) if self._all_pairs is within else (within, self._all_pairs)

    def levers(self) -> Floats:
        """(nq,) how far a number moves the bodies of a pair against each other, roughly, in m/rad and m/m."""
        return self._all_pairs.levers()

    def rounding(self) -> RoundingBounds:
        """The bounds of the kinematics' rounding."""
        return self._errors

    def check_curves(self, curves: Curves, tolerance: float, threads: int) -> Bools:
        """`check` of curves; those in the usual range are judged without Python in between.

        Pairs that can't meet within the limits may come nearer to each other than they have to stay apart.
        """
        part, (low, high) = self._pairs_within_limits, self._range
        if curves.need_all_pairs:
            part, (low, high) = self._all_pairs, (self._errors.low, self._errors.high)
        check_tolerance(tolerance)
        if not part.touching:
            known = core.curve_validity(
                part.core, self._kernel, low, high, self._errors.usual, *curves, tolerance, threads
            )
            if known is not None:
                return np.asarray(known).view(bool)
        return self.check(curves, tolerance, threads)

    def chunk_judge(self, limits: Floats, tube: Floats, tolerance: float, ask: Any = None) -> Callable[..., int]:
        """The core's `chunk_judge`, which takes chunks of waypoints with a stop behind them.

        Args:
            limits: (5, nq) rows of positions from and to, speeds, accelerations, and decelerations in a stop.
            tube: (nq + 1,) of all motions, then how far bodies stay apart, m.
            tolerance: m.
            ask: For tests: whether a motion (2, nq) with a tube (nq + 1,) is free, in place of the core.
        """
        check_tolerance(tolerance)
        part, errors = self._all_pairs, self._errors
        if part.touching:
            return lambda *_: _UNKNOWN_CHUNK
        kinematics = self._kernel, errors.low, errors.high, errors.usual
        return cast(Callable[..., int], core.chunk_judge(part.core, *kinematics, limits, tube, tolerance, ask))

    def check(self, motions: Motions | Curves, tolerance: float, threads: int) -> Bools:
        """Whether each of n validated motions is free: (n,), False if a pair comes within the tolerance, m."""
        check_tolerance(tolerance)
        ranges = motions.ranges()
        if isinstance(motions, Motions) and (motions.given is motions.ends or self._errors.are_usual(*ranges)):
            known = self.judge_sets(motions.starts, motions.ends, tolerance, threads)
            if known is not None:
                return known.view(bool)
        points, tubes = motions.points, motions.tubes
        free = np.empty(len(points), dtype=bool)
        by_error = self._errors.of_ranges(*ranges)
        for part, some in self._parts_of(motions, *ranges):
            for error, rows in by_error(some):
                if part.touching:  # these pairs touch at every state, so no motion is free
                    free[rows] = False
                    continue
                taken = _rows(points, rows), _rows(tubes, rows)
                low, high = self._errors.low, self._errors.high
                answers = np.asarray(part.core.check(self._kernel, low, high, error, *taken, tolerance, threads))
                free[rows] = verdicts(answers, tolerance, rows, isinstance(motions, Curves))
        return free

    def _parts_of(
        self, motions: Motions | Curves, least: Floats, largest: Floats
    ) -> list[tuple[ChainedPairs, NDArray[np.int64]]]:
        """Pairs, and the rows of the motions that they judge: within the limits all the way, and the others.

        The motions' ranges are given. Pairs that can't meet within the limits may come nearer to each other than they
        have to stay apart.
        """
        rows, limits = np.arange(len(least)), self._limits
        if motions.need_all_pairs:
            return [(self._all_pairs, rows)]
        within = None if limits is None else ((least >= limits[0]) & (largest <= limits[1])).all(axis=1)
        if within is None or within.all():
            return [(self._pairs_within_limits, rows)]
        beyond = [(self._all_pairs, rows[~within])]
        return [(self._pairs_within_limits, rows[within]), *beyond] if within.any() else beyond

    @cached_property
    def judge_rows(self) -> JudgeMotion:
        """A compiled judge of one motion between rows (nq,); None for motions that Python has to judge."""
        judge: JudgeMotion
        judge = self._compiled_judge(core.motion_row_validity, self._pairs_within_limits, *self._range)
        return judge

    @cached_property
    def judge_rows_beyond(self) -> JudgeMotion:
        """`judge_rows` for motions that leave the limits, by all pairs; None if the limits rule out no pair."""
        judge: JudgeMotion = _never_known
        if self._limits is not None:
            judge = self._compiled_judge(core.motion_row_validity, self._all_pairs, self._errors.low, self._errors.high)
        return judge

    @cached_property
    def judge_sets(self) -> Callable[[Any, Any, float, int], NDArray[np.uint8] | None]:
        """`judge_rows` for sets of motions, between arrays (n, nq), on a number of threads: (n,) 1 for free."""
        judge: Callable[[Any, Any, float, int], NDArray[np.uint8] | None]
        judge = self._compiled_judge(core.motion_set_validity, self._pairs_within_limits, *self._range)
        return judge

    def _compiled_judge(self, of_certifier: Callable[..., Any], part: ChainedPairs, low: Floats, high: Floats) -> Any:
        if part.touching or len(self._robot.joint_names) != self._robot.nq:
            return _never_known
        return of_certifier(part.core, self._kernel, low, high, self._errors.usual, list(self._errors.turning))

    def motion_validity(
        self,
        tolerance: float,
        counts: Any = None,
        states: Any = None,
        angles: Sequence[int] = (),
        failure: Any = None,
    ) -> Callable[[Any, Any], bool]:
        """`check` of one motion as a compiled function of two states of an OMPL space of nq numbers.

        Args:
            tolerance: m.
            counts: The core's MotionCounts, which counts the answers.
            states: As for `StateChecker.state_validity`.
            angles: Columns of angles that whole turns do not change; they take the short way, as in OMPL's SO2.
            failure: As for `StateChecker.state_validity`.

        Returns:
            The function; True means proved free.
        """
        check_tolerance(tolerance)
        counts = core.MotionCounts() if counts is None else counts
        if self._pairs_within_limits.touching:
            return partial(_refused, counts)
        judge = core.motion_validity(
            self._pairs_within_limits.core,
            self._kernel,
            *self._range,
            tolerance,
            self._errors.usual,
            partial(self._elsewhere, tolerance, tuple(angles)),
            counts,
            states,
            list(angles),
            failure,
        )
        return cast(Callable[[Any, Any], bool], judge)

    def _elsewhere(self, tolerance: float, angles: tuple[int, ...], q0: list[float], q1: list[float]) -> bool:
        for k in angles:
            q1[k] = nearest_turn(q0[k], q1[k])
        starts, ends = np.array([q0]), np.array([q1])
        known = self.judge_sets(starts, ends, tolerance, 1)
        if known is not None:
            return bool(known[0])
        ends = self._robot.check_configurations(ends)
        return bool(self.check(Motions(self._robot.check_configurations(starts), ends, ends), tolerance, 1)[0])

    def motion_result(
        self, q0: Floats, q1: Floats, tolerance: float, proofs: bool = False, given: Floats | None = None
    ) -> MotionResult:
        """How far one motion (nq,) to (nq,) is free by a tolerance, m, from its start on, which is validated.

        With `proofs`, those of all pairs that can move relative to each other are returned. `given` (nq,) is the end
        before whole turns were taken off.
        """
        end = q1[None]
        return self.result(Motions(q0[None], end, end if given is None else given[None]), tolerance, proofs)

    def result(self, motion: Motions | Curves, tolerance: float, proofs: bool = False) -> MotionResult:
        """How far one motion or curve, of a set of one, is free; arguments as for `motion_result`."""
        check_tolerance(tolerance)
        ranges = motion.ranges()
        ((part, row),) = self._parts_of(motion, *ranges)
        if part.touching:
            return MotionResult(False, 0.0, 0.0, part.touching[0])
        ((error, _),) = self._errors.of_ranges(*ranges)(row)
        answer, until, near, pair = part.core.explain(
            self._kernel, motion.points, motion.tubes, tolerance, error, False
        )[:4]
        found = motion_result_of(answer, until, near, int(part.rows[pair]) if answer == REFUSED else -1, tolerance)
        if not proofs:
            return found
        reached, listed = self._listed(motion, tolerance, error, found.free_until)
        return found._replace(proofs=tuple(p for p in listed if p.start < found.free_until), proved_until=reached)

    def _listed(
        self, motion: Motions | Curves, tolerance: float, error: float, until: float
    ) -> tuple[float, list[Proof]]:
        """Proofs of all pairs up to a parameter, and up to where they reach.

        Pairs that can't meet within the limits may still come within the tolerance. Then a smaller tolerance is used,
        as long as rounding is a small part of it.
        """
        reached, listed = 0.0, list[Proof]()
        for finer in _FINER:
            answer, end, _, _, *found = self._all_pairs.core.explain(
                self._kernel, motion.points, motion.tubes, finer * tolerance, error, True
            )
            if answer == IMPRECISE:
                break
            reached, listed = (1.0 if answer == FREE else end), _proofs(self._all_pairs, found)
            if reached >= until:
                break
        return min(reached, until), listed

    def states(self, q0: Floats, q1: Floats, parameters: Floats) -> Floats:
        """(k, nq) of one motion (nq,) to (nq,) at parameters (k,) in [0, 1]."""
        return self.states_on(np.stack([q0, q1]), parameters)

    def states_on(self, points: Floats, parameters: Floats) -> Floats:
        """(k, nq) of one curve, control points (degree + 1, nq), at parameters (k,) in [0, 1]."""
        return np.asarray(self._pairs_within_limits.core.states(points[None], parameters))

    def statistics(self) -> dict[str, Any]:
        """Counters of all calls so far."""
        parts = [self._pairs_within_limits]
        if "_all_pairs" in vars(self) and self._all_pairs is not self._pairs_within_limits:
            parts.append(self._all_pairs)
        return sum_counters(part.core.statistics() for part in parts)


def _rows(array: Floats, rows: NDArray[np.int64]) -> Floats:
    """Some or all rows of an array; an empty array stays empty."""
    return array if len(rows) >= len(array) else array[rows]


def _never_known(_start: Configuration, _end: Configuration, _tolerance: float, _threads: int = 1) -> None:
    """A judge without verdicts, for robots whose motions Python has to judge."""


def _refused(counts: Any, _start: Any, _end: Any) -> bool:
    counts.add(False)
    return False


def _proofs(part: ChainedPairs, arrays: Sequence[Any]) -> list[Proof]:
    """Proofs by the checker's rows, from the core's arrays."""
    found = proofs_of(part.frames, *arrays)
    return [each._replace(pair=int(part.rows[each.pair]), flipped=bool(part.flipped[each.pair])) for each in found]
