"""Trajectories judged: each piece is a curve, proved free at every instant, with a tube around it.

In: a checker, trajectories, a tube. Out: which pieces are free; for one trajectory the time up to which it is free, the
pair that stops it, and the clearance. Pieces of one degree, of all trajectories, are judged together.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from itertools import accumulate
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.checking.distances import Distances
from plannercheck.checking.protocols import AnyChecker
from plannercheck.common.array_types import Bools, Floats, Ints64
from plannercheck.common.arrays import named_numbers
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.motion_paths import MotionPath
from plannercheck.common.shown_times import shown_span
from plannercheck.motions.certifier import MotionCertifier
from plannercheck.motions.certifier_answers import ImpreciseError
from plannercheck.motions.explanation import explained_motion
from plannercheck.motions.motion_ends import Curves
from plannercheck.motions.trajectory_verdict import Stop, TrajectoryVerdict
from plannercheck.proofs.proof import Proof
from plannercheck.robots.configurations import LARGEST_VALUE
from plannercheck.robots.robot import Robot
from plannercheck.trajectories.curve import ROUNDED_UP, Curve
from plannercheck.trajectories.joint_columns import check_order
from plannercheck.trajectories.limits import Excess
from plannercheck.trajectories.trajectory import Trajectory

# The clearance is looked at so many instants a piece, and at most so many in all.
_LOOKS_A_PIECE, _MOST_LOOKS = 10, 500

# The largest proved tube and clearance are found to this part of themselves; the smallest and the largest tube that are
# tried, rad and m.
_FINE = 2.0**-7
_SMALLEST_TUBE, _LARGEST_TUBE = 1e-6, 8.0


class TrajectoryChecker(AnyChecker, Protocol):
    """The parts of a `Checker` by which trajectories are judged."""

    @property
    def robot(self) -> Robot:
        """The robot."""

    def certifier_of(self, path: MotionPath) -> MotionCertifier:
        """Proves motions along a path free."""

    @property
    def paddings(self) -> Floats:
        """(bodies,) each body's part of the padding, m."""

    def clearances(self, q: ArrayLike, lower_bound: bool = False) -> Floats:
        """The least distance of all pairs (n,) at configurations (n, nq)."""

    def distances(self, q: ArrayLike, limit: float, nearest: int | None = None, gradients: bool = True) -> Distances:
        """The pairs within a limit, m, at configurations (n, nq)."""


class TrajectoryChecks:
    """Judges trajectories for one checker, by one tube, one tolerance and how far bodies stay apart."""

    def __init__(self, checker: TrajectoryChecker, tube: ArrayLike, tolerance: float, room: float = 0.0) -> None:
        """Takes a tube, a number or a row of the robot's own width, rad and m, a tolerance, and a distance, m.

        Raises:
            PlannercheckError: If the tube is malformed, or not 0 for the numbers of unit vectors.
        """
        self._checker, self._tolerance, self._room = checker, tolerance, room
        self._certifier = checker.certifier_of("slerp")
        self._units, self._own = checker.robot.configuration_map.units, checker.robot.own_width
        self._is_bare = isinstance(tube, float) and not tube and not room
        self.tube = np.zeros(checker.robot.nq) if self._is_bare else self._checked_tube(named_numbers(tube, "tube"))

    def are_free(self, trajectories: Sequence[Trajectory], threads: int = 1) -> Bools:
        """Which of n trajectories are proved free (n,), on a number of threads."""
        if not trajectories:
            return np.empty(0, dtype=bool)
        free = self._free_pieces(trajectories, self.tube, self._room, threads)
        starts = [0, *accumulate(len(each.curve.pieces) for each in trajectories[:-1])]
        return np.logical_and.reduceat(free, starts)

    def is_free(self, trajectory: Trajectory) -> bool:
        """Whether a trajectory is proved free."""
        return bool(np.logical_and.reduce(self.free_pieces(trajectory)))

    def free_pieces(self, trajectory: Trajectory, wider: Floats | None = None) -> Bools:
        """Which pieces of a trajectory are proved free; `wider`: (pieces, nq) what each has besides the tube."""
        return self._free_pieces([trajectory], self.tube, self._room, wider=wider)

    def largest_room(self, trajectories: Sequence[Trajectory]) -> float:
        """The distance, m, that bodies are proved to keep on free trajectories, tube included; to a hundredth of it."""
        least = min((self._least_clearance(each)[1] for each in trajectories), default=np.inf)
        if not np.isfinite(least):  # no pairs
            return least

        def is_free(room: float) -> bool:
            return all(self._is_free(each, self.tube, room) for each in trajectories)

        return max(_largest(is_free, max(self._room, least * _FINE), least), self._room)

    def near_instants(self, trajectory: Trajectory, pieces: Sequence[int]) -> list[float]:
        """Where pairs came so near on pieces that are not free that these were refused, s."""
        breaks, tubes = trajectory.curve.breaks, self._tubes([trajectory.curve], self.tube, self._room)
        found = []
        for k in pieces:
            result = self._certifier.result(Curves(trajectory.curve.pieces[k][None], tubes), self._tolerance)
            if not result.free:
                found.append(float(min(breaks[k] + (breaks[k + 1] - breaks[k]) * result.near, breaks[k + 1])))
        return found

    def _free_pieces(
        self,
        trajectories: Sequence[Trajectory],
        tube: Floats,
        room: float = 0.0,
        threads: int = 1,
        wider: Floats | None = None,
    ) -> Bools:
        """Which pieces of all trajectories, one after the other, are proved free.

        `room`: how far bodies stay apart; `wider`: (pieces, nq) what the tube of each piece has besides.
        """
        for trajectory in trajectories:
            check_trajectory_of(self._checker.robot, trajectory)
        curves = [each.curve for each in trajectories]
        counts = [len(curve.pieces) for curve in curves]
        tubes = self._tubes(curves, tube, room)
        if len(curves) > 1 or wider is not None:
            tubes = tubes.repeat(counts, axis=0)
        if wider is not None:
            tubes[:, :-1] = (tubes[:, :-1] + wider) * ROUNDED_UP
        free = np.empty(sum(counts), dtype=bool)
        for rows, points in _by_count(curves):
            around = tubes if len(tubes) == 1 else tubes[rows]
            try:
                free[rows] = self._certifier.check_curves(Curves(points, around), self._tolerance, threads)
            except ImpreciseError as error:
                raise PlannercheckError(f"{_named(trajectories, int(rows[error.row]))}: {error.reason}") from None
        return free

    def tube_of(self, trajectory: Trajectory) -> Floats:
        """(nq,) the tube with the errors of a trajectory's control points."""
        return np.asarray(self._tubes([trajectory.curve], self.tube, 0.0)[0, :-1])

    def _tubes(self, curves: Sequence[Curve], tube: Floats, room: float) -> Floats:
        """(n, nq + 1) a tube around the polynomials that each curve stands for, and how far bodies stay apart, m."""
        if len(curves) == 1 and self._is_bare and tube is self.tube and not room:
            return curves[0].own_tube
        tubes = np.empty((len(curves), len(tube) + 1))
        tubes[:, -1] = room
        tubes[:, :-1] = (tube + np.array([curve.error for curve in curves])) * ROUNDED_UP
        return tubes

    def explain(
        self, trajectory: Trajectory, limits: tuple[Excess, ...], prover: Callable[[], tuple[Proof, ...] | None]
    ) -> TrajectoryVerdict:
        """How far a trajectory is free and what stops it; `limits` it breaks, and `prover` computes its proof."""
        free = self.free_pieces(trajectory)
        made = partial(
            TrajectoryVerdict,
            tube=self.tube[: self._own],
            tolerance=self._tolerance,
            limits=limits,
            largest_tube=self._largest_tube(trajectory),
        )
        at, least = self._least_clearance(trajectory)
        if free.all():
            no_tube = 0.0 * self.tube
            proved = least  # without pairs, infinity
            if np.isfinite(least):
                proved = _largest(lambda room: self._is_free(trajectory, no_tube, room), least * _FINE, least)
            end = float(trajectory.curve.breaks[-1])
            return made(True, Stop(end), clearance=proved, clearance_at=at, prover=prover)
        return made(False, self.stopped(trajectory, free), clearance=0.0, clearance_at=at)

    def stopped(self, trajectory: Trajectory, free: Bools) -> Stop:
        """What stops a trajectory of which these pieces are free, and not all.

        A piece may be refused where nothing collides on the curve itself; then later ones are looked at.
        """
        first: Stop | None = None
        for piece in np.flatnonzero(~free).tolist():
            stop = self._stopped_on(trajectory, piece)
            first = stop if first is None else replace(first, collides_at=stop.collides_at, pair=stop.pair)
            if stop.collides_at is not None:
                return first
        assert first is not None
        return first

    def _stopped_on(self, trajectory: Trajectory, piece: int) -> Stop:
        points = trajectory.curve.pieces[piece]
        start, end = (float(time) for time in trajectory.curve.breaks[piece : piece + 2])
        curve = Curves(points[None], self._tubes([trajectory.curve], self.tube, self._room))
        result = self._certifier.result(curve, self._tolerance)

        def states(s: Floats) -> Floats:
            return trajectory.position(np.minimum(start + (end - start) * s, end))

        def time(s: float) -> float:
            return min(start + (end - start) * s, end)

        found = explained_motion(self._checker, result, states, self._tolerance)
        collides_at, near_at = (None if s is None else time(s) for s in (found.collides_at, found.near_at))
        return Stop(time(found.free_until), collides_at, near_at, found.pair)

    def _is_free(self, trajectory: Trajectory, tube: Floats, room: float) -> bool:
        try:
            return bool(self._free_pieces([trajectory], tube, room).all())
        except PlannercheckError:  # rounding is too large, of the tube or of a pair that counts only with a tube
            return False

    def _largest_tube(self, trajectory: Trajectory) -> float:
        around = np.ones(len(self.tube))
        around[self._own :] = 0.0
        for first, past in self._units:
            around[first:past] = 0.0
        return _largest(lambda size: self._is_free(trajectory, around * size, 0.0), _SMALLEST_TUBE, _LARGEST_TUBE)

    def _least_clearance(self, trajectory: Trajectory) -> tuple[float, float]:
        """The instant, s, of those that are looked at, at which the clearance is least, and the clearance, m.

        Paddings are taken off for pairs that never move relative to each other, which no motion asks for.
        """
        breaks = trajectory.curve.breaks
        looks = min(_LOOKS_A_PIECE * (len(breaks) - 1), _MOST_LOOKS) + 1
        times = np.linspace(breaks[0], breaks[-1], looks)
        clearances = self._checker.clearances(trajectory.position(times))
        least = int(clearances.argmin())
        return float(times[least]), min(float(clearances[least]), self._still_clearance(trajectory, clearances[least]))

    def _still_clearance(self, trajectory: Trajectory, least: float) -> float:
        """How far pairs that never move relative to each other stay apart, m, if that is less than `least`."""
        checker = self._checker
        widest = 2 * float(checker.paddings.max(initial=0.0))
        if not 0 < least < np.inf or not widest:
            return least
        near = checker.distances(trajectory.position([trajectory.curve.breaks[0]]), least + widest, gradients=False)
        still = ~np.isin(near.pair, self._certifier.pairs_by_table()[-1].rows)
        paddings = checker.paddings[checker.pairs[near.pair[still]]].sum(axis=1)
        return float((near.distance[still] - paddings).min(initial=least))

    def _checked_tube(self, given: Floats) -> Floats:
        nq, robot = self._own, self._checker.robot
        if given.shape not in ((1,), (nq,)) or not ((given >= 0) & (given <= LARGEST_VALUE)).all():
            raise PlannercheckError(
                f"tube must be a number from 0 to {LARGEST_VALUE:g}, or a row of {nq}, rad and m, not"
                f" {given.tolist()!s:.80}"
            )
        row = np.zeros(robot.nq)
        row[:nq] = given
        for first, past in self._units:
            if row[first:past].any():
                raise PlannercheckError(
                    f"columns {first} to {past - 1} of a configuration form a unit vector, around which there is no"
                    f" tube: give tube as a row of {nq} numbers that is 0 there"
                )
        return row


def several(trajectories: Iterable[Trajectory]) -> Sequence[Trajectory]:
    """Some trajectories as a sequence; raises for one in place of several."""
    if isinstance(trajectories, Trajectory):
        raise PlannercheckError("this is one pc.Trajectory, not a list of some: check_trajectory takes one")
    if not isinstance(trajectories, Iterable):
        raise PlannercheckError(f"trajectories must be some pc.Trajectory, not {type(trajectories).__name__}")
    return tuple(trajectories)


def check_trajectory_of(robot: Robot, trajectory: Trajectory) -> None:
    """Raises unless something is a trajectory of a robot."""
    if not isinstance(trajectory, Trajectory):
        raise PlannercheckError(
            f"a trajectory must be a pc.Trajectory, not {type(trajectory).__name__}: pc.Trajectory(times, positions)"
            " makes one, pc.Trajectory.load reads one"
        )
    if trajectory.curve.nq != robot.nq:
        columns = robot.configuration_map.described_columns()
        raise PlannercheckError(f"the trajectory has {trajectory.curve.nq} columns, but {columns}")
    check_order(robot, trajectory.points)
    if trajectory.curve.units != robot.configuration_map.units:
        raise PlannercheckError(
            f"columns of {robot.name!r} form unit vectors, which turn by slerp: give trajectory.of_robot(robot)"
        )


def _by_count(curves: Sequence[Curve]) -> Iterable[tuple[Ints64, Floats]]:
    """The pieces of all curves by their count of control points: their numbers, curve after curve, and their points."""
    if len(curves) == 1:
        return curves[0].by_count.values()
    found: dict[int, list[tuple[Ints64, Floats]]] = {}
    starts = accumulate((len(curve.pieces) for curve in curves), initial=0)
    for start, curve in zip(starts, curves, strict=False):
        for count, (pieces, points) in curve.by_count.items():
            found.setdefault(count, []).append((start + pieces, points))
    return [
        (np.concatenate(rows), np.concatenate(points))
        for rows, points in (zip(*f, strict=True) for f in found.values())
    ]


def _named(trajectories: Sequence[Trajectory], piece: int) -> str:
    """A piece of trajectories in words, by its number among those of all."""
    for k, trajectory in enumerate(trajectories):
        if piece < len(trajectory.curve.pieces):
            of = f"trajectory {k}, " if len(trajectories) > 1 else ""
            return of + named_piece(trajectory, piece)
        piece -= len(trajectory.curve.pieces)
    raise IndexError(piece)


def named_piece(trajectory: Trajectory, piece: int) -> str:
    """A piece in words, with the time it takes."""
    start, end = trajectory.curve.breaks[piece : piece + 2].tolist()
    return f"piece {piece} of the trajectory, {shown_span(start, end)}"


def _largest(is_free: Callable[[float], bool], smallest: float, largest: float) -> float:
    """The largest size at which something is free, to a part of itself, from a smallest to a largest one; or 0."""
    if not largest > smallest > 0 or not is_free(smallest):
        return 0.0
    low = smallest
    while low < largest and is_free(min(2 * low, largest)):
        low = min(2 * low, largest)
    high = min(2 * low, largest)
    while high - low > _FINE * low:
        middle = (low + high) / 2
        low, high = (middle, high) if is_free(middle) else (low, middle)
    return low
