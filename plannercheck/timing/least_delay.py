"""`pc.least_delay`: how long robots have to wait until nothing collides, with a bound from below.

In: a checker of a cell, trajectories of robots that go first and of robots that wait. Out: a `LeastDelay`: a delay that
is proved free, and a bound below which every delay is refuted.

Intervals of delays are judged from the least on, and halved until they are settled or short. An interval from a to b is
free if the trajectory of the cell at its middle is, with a tube around the waiting robots as wide as they move in
(b - a) / 2, piece by piece: their largest speed in the window of time that the piece sees. It is refuted by an instant
at which two bodies overlap at the middle, and still do wherever the interval's delays can have moved them. Either the
instant is one of the clock, and the waiting robots have moved; or, unless the scene moves, it goes along with the
waiting robots, and the others have.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.html_tables import html_table
from plannercheck.common.public_names import set_module
from plannercheck.common.shown_times import shown_seconds
from plannercheck.motions.certifier import DEFAULT_TOLERANCE
from plannercheck.motions.checker import Checker
from plannercheck.motions.trajectory_checks import TrajectoryChecks
from plannercheck.motions.trajectory_verdict import TrajectoryVerdict
from plannercheck.timing.conflicts import Tubes, cell_of, on_scene_clock, tube_row
from plannercheck.timing.overlaps import Overlaps
from plannercheck.trajectories.curve import Curve
from plannercheck.trajectories.one_clock import Run, check_runs, checked_starts, on_one_clock, speeds, start_time
from plannercheck.trajectories.trajectory import Trajectory

Settled = Literal["free", "refuted", "open"]

# Collisions are sought at so many instants; of those that collide so many are measured, and so many tried.
_LOOKS, _MEASURED, _TRIED = 256, 24, 8

# On so many pieces that are refused, the instant of the refusal is looked at as well, and so many before and after it,
# each at half the distance.
_NEAR_PIECES, _CLOSE = 4, 10

# Speeds are looked at in so many parts of a piece.
_PARTS = 16

# Configurations are this much beyond the control points at most, by rounding, rad and m.
_AROUND = 1e-6

# Knots on the clock are off by less than this, s, by which windows of time are longer.
_OFF = 2e-9


@dataclass(frozen=True)
class Delays:
    """Delays that are settled together.

    Attributes:
        start: From this delay, s.
        end: To this one.
        settled: "free": every delay is proved free; "refuted": every delay collides; "open": neither is proved.
        instant: If refuted: when the pair overlaps at the middle delay, s on the clock.
        pair: If refuted: the links, or link and obstacle, that overlap.
    """

    start: float
    end: float
    settled: Settled
    instant: float | None = None
    pair: tuple[str, str] | None = None


@set_module("plannercheck")
@dataclass(frozen=True, repr=False)
class LeastDelay:
    """How long robots wait.

    Attributes:
        delay: Proved free at this very delay, s; None if none up to the largest is.
        lower: Every delay from 0 s up to it is refuted, s.
        waiting: The robots that wait together.
        trajectory: The cell's at the delay; None without one.
        verdict: The trajectory's.
        intervals: All delays that were judged, in ascending order; not those beyond the first free ones.
    """

    delay: float | None
    lower: float
    waiting: tuple[str, ...]
    trajectory: Trajectory | None = field(repr=False)
    verdict: TrajectoryVerdict | None = field(repr=False)
    intervals: tuple[Delays, ...] = field(repr=False)

    @property
    def loss(self) -> float | None:
        """How much longer the delay is than the true least one, at most, s; None without a delay."""
        return None if self.delay is None else self.delay - self.lower

    @property
    def refuted(self) -> bool:
        """Whether every delay that was asked for is refuted."""
        return all(each.settled == "refuted" for each in self.intervals) and bool(self.intervals)

    def __repr__(self) -> str:
        return f"LeastDelay({self._sentence()})"

    def _sentence(self) -> str:
        names = ", ".join(self.waiting)
        if self.delay is not None:
            least = f"at most {self.loss:.3g} s more than the least" if self.delay else "no delay"
            return f"{names} after {shown_seconds(self.delay)} s, proved free; {least}"
        end, lower = shown_seconds(self.intervals[-1].end), shown_seconds(self.lower)
        if self.refuted:
            return f"none for {names}: every delay from 0 to {end} s is refuted"
        return f"none for {names} up to {end} s is proved free; every delay below {lower} s is refuted"

    def _repr_html_(self) -> str:
        rows = [
            (
                shown_seconds(e.start),
                shown_seconds(e.end),
                e.settled,
                "" if e.instant is None else shown_seconds(e.instant),
                "" if e.pair is None else " – ".join(e.pair),
            )
            for e in self.intervals
        ]
        return html_table(repr(self), ("from s", "to s", "delays are", "instant s", "pair"), rows)


@set_module("plannercheck")
def least_delay(
    checker: Checker,
    first: Mapping[str, Run],
    waiting: Mapping[str, Run],
    at_most: float = 10.0,
    resolution: float = 1e-3,
    starts: Mapping[str, float] | None = None,
    tube: Tubes = 0.0,
    tolerance: float = DEFAULT_TOLERANCE,
) -> LeastDelay:
    """The least delay after which robots may start, so that nothing collides.

    A robot that waits stands at its first point, where it may be in the way as well. Everything is judged from 0 s
    until the last robot has ended.

    Args:
        checker: The checker of a cell (`pc.Robot.together`).
        first: By robot, what runs as it is: trajectories, or the configuration (k,) at which a robot stands.
        waiting: By robot, the trajectories that wait, all by the same delay.
        at_most: The largest delay that is looked for, s.
        resolution: Delays are told apart to this, s.
        starts: When each trajectory starts without the delay, s; 0 if not named.
        tube: As for `first_conflict`; what is proved free is so with it, what is refuted without.
        tolerance: As for `check_trajectory`.

    Returns:
        The delay, and the bound from below.

    Raises:
        PlannercheckError: If a robot is in both, is unknown or missing, or `at_most` or `resolution` is not above 0 s.
    """
    cell = cell_of(checker)
    for given, what in ((first, "first"), (waiting, "waiting")):
        if not isinstance(given, Mapping):
            raise PlannercheckError(f"{what} holds trajectories by robot, {{'left': trajectory}}, not {given!r:.80}")
    both = [name for name in waiting if name in first]
    if both:
        raise PlannercheckError(f"{', '.join(both)} can't both go first and wait: give each robot one trajectory")
    runs = {**first, **waiting}
    check_runs(cell, runs)
    stand = [name for name, run in waiting.items() if not isinstance(run, Trajectory)]
    if stand or not waiting:
        raise PlannercheckError(f"what waits has a trajectory: {', '.join(stand) or 'nothing waits'}")
    turning = [name for name in waiting if _turns(runs[name])]
    if turning:
        raise PlannercheckError(
            f"unit vectors of {', '.join(turning)} turn, around which there is no tube: let a robot wait whose joints"
            " take one number each"
        )
    for value, what in ((at_most, "at_most"), (resolution, "resolution")):
        if start_time(value, what) == 0.0:
            raise PlannercheckError(f"{what} must be more than 0 s")
    begins = checked_starts(cell, runs, starts)
    judge = _Judge(checker, runs, tuple(waiting), begins, float(at_most), tube_row(cell, tube), tolerance)
    return _searched(judge, float(resolution))


def _turns(run: Run) -> bool:
    """Whether a trajectory turns unit vectors."""
    curve = run.curve if isinstance(run, Trajectory) else None
    return curve is not None and any(speeds(curve)[1][:, a:b].any() for a, b in curve.units)


class _Own(NamedTuple):
    """A robot's trajectory without the delay.

    Attributes:
        columns: Columns of the cell.
        knots: On the clock, s.
        speeds: (pieces, k) largest on each piece, rad/s and m/s.
    """

    columns: Ints64
    knots: Floats
    speeds: Floats

    def within(self, begins: Floats, ends: Floats) -> Floats:
        """(n, k) the largest speeds in windows of time (n,)."""
        sees = (self.knots[:-1] < ends[:, None] + _OFF) & (self.knots[1:] > begins[:, None] - _OFF)
        return np.asarray(np.where(sees[:, :, None], self.speeds, 0.0).max(axis=1))


@dataclass(frozen=True)
class _Judge:
    """Judges delays.

    Attributes:
        checker: The checker of the cell.
        runs: What each robot does.
        waiting: The robots that wait.
        starts: Without the delay.
        at_most: The largest delay, s.
        tube: For proofs, rad and m.
        tolerance: Likewise, m.
    """

    checker: Checker
    runs: Mapping[str, Run]
    waiting: tuple[str, ...]
    starts: Mapping[str, float]
    at_most: float
    tube: ArrayLike
    tolerance: float

    @cached_property
    def inner(self) -> Checker:
        """The checker whose configurations have the columns of what moves in the scene, after the robots'."""
        return on_scene_clock(self.checker, self.trajectory(0.0))[0]

    @cached_property
    def checks(self) -> TrajectoryChecks:
        """Proves trajectories with these columns."""
        return TrajectoryChecks(self.inner, self.tube, self.tolerance)

    @cached_property
    def owns(self) -> dict[str, _Own]:
        """The robots that move."""
        parts = self.checker.robot.parts
        return {
            name: _Own(parts[name].columns, places + self.starts.get(name, 0.0), fastest)
            for name, run in self.runs.items()
            if isinstance(run, Trajectory)
            for places, fastest in [speeds(run.curve, _PARTS)]
        }

    @cached_property
    def overlaps(self) -> Overlaps:
        """Proves overlaps at configurations of any delay."""
        points = np.concatenate(self.on_scene_clock(self.at_most).curve.pieces)
        return Overlaps(self.inner, points.min(axis=0) - _AROUND, points.max(axis=0) + _AROUND)

    def trajectory(self, delay: float, knots: ArrayLike = ()) -> Trajectory:
        """The cell's at a delay."""
        starts = {**self.starts, **{name: self.starts.get(name, 0.0) + delay for name in self.waiting}}
        return on_one_clock(self.checker.robot, self.runs, starts, knots)

    def on_scene_clock(self, delay: float, knots: ArrayLike = ()) -> Trajectory:
        """The same with the columns of what moves in the scene."""
        return on_scene_clock(self.checker, self.trajectory(delay, knots))[1]

    def changes(self, begins: Floats, ends: Floats, half: float, of_waiting: bool) -> Floats:
        """(n, nq) how far numbers of the waiting robots, or of the others, move in `half` s in windows of time (n,)."""
        out = np.zeros((len(begins), self.inner.robot.nq))
        for name, own in self.owns.items():
            if (name in self.waiting) == of_waiting:
                out[:, own.columns] = own.within(begins, ends) * (half * (1 + 2.0**-40))
        return out

    def end(self, delay: float) -> float:
        """When the last robot has ended, s on the clock."""
        return max(float(own.knots[-1]) + (delay if name in self.waiting else 0.0) for name, own in self.owns.items())

    def is_free(self, delay: float) -> bool:
        """Whether one delay is proved free."""
        return bool(self.checks.free_pieces(self.on_scene_clock(delay)).all())

    def settled(self, start: float, end: float) -> Delays:
        """Delays from start to end as far as they are settled."""
        middle, half = (start + end) / 2, (end - start) / 2 * (1 + 2.0**-40) + 2.0**-50 * end
        knots = np.concatenate([self.owns[name].knots for name in self.waiting])
        trajectory = self.on_scene_clock(middle, np.append(knots + middle, knots.max() + end))
        free = self.checks.free_pieces(trajectory)
        if not free.all():
            found = self._refuted(trajectory, np.flatnonzero(~free).tolist(), middle, half)
            return Delays(start, end, "open") if found is None else Delays(start, end, "refuted", *found)
        breaks = trajectory.curve.breaks
        wider = self.changes(breaks[:-1] - middle - half, breaks[1:] - middle + half, half, of_waiting=True)
        try:
            all_free = bool(self.checks.free_pieces(trajectory, wider).all())
        except PlannercheckError:  # the tube is so wide that rounding is, too
            all_free = False
        return Delays(start, end, "free" if all_free else "open")

    def _refuted(
        self, trajectory: Trajectory, pieces: list[int], delay: float, half: float
    ) -> tuple[float, tuple[str, str]] | None:
        """The instant and pair that overlap at all delays within `half` of one, if any is found."""
        curve = trajectory.curve
        near = np.array(self.checks.near_instants(trajectory, pieces[:_NEAR_PIECES]))
        close = curve.breaks[-1] / _LOOKS * 2.0 ** -np.arange(_CLOSE)
        around = near[:, None] + np.concatenate([-close, [0.0], close])
        looks = np.concatenate([np.linspace(0.0, curve.breaks[-1], _LOOKS), around.ravel()])
        looks = looks[(looks >= 0.0) & (looks <= self.end(delay - half))]  # what moves may come to robots that ended
        times = looks[~self.inner.check_states(trajectory.position(looks))]
        times = times[:: -(-len(times) // _MEASURED) or 1]
        if not len(times):
            return None
        states = trajectory.position(times)
        later = self.changes(times - delay - half, times - delay + half, half, of_waiting=True)
        earlier = self.changes(times - half, times + half, half, of_waiting=False)
        earlier[(times < half) | (self.inner is not self.checker)] = np.inf  # before the clock, or the scene moves
        fastest = np.minimum(later.max(axis=1), earlier.max(axis=1))
        deepest = np.argsort(self.inner.clearances(states) / (fastest + _OFF), kind="stable")[:_TRIED]
        for k in deepest.tolist():
            changes = [self._with_rounding(each[k], curve) for each in (later, earlier) if np.isfinite(each[k]).all()]
            found = self.overlaps.shared(states[k], changes)
            if found is not None:
                return float(times[k]), self.inner.pair_names(found.pair)
        return None

    def _with_rounding(self, change: Floats, curve: Curve) -> Floats:
        """A change of configurations with the curve's error; that of unit vectors is in the overlaps' own rounding."""
        error = curve.error.copy()
        for first, past in curve.units:
            error[first:past] = 0.0
        return np.asarray(change + error)


def _searched(judge: _Judge, resolution: float) -> LeastDelay:
    if judge.is_free(0.0):
        return _result(judge, 0.0, ())
    left, judged, delay = [(0.0, judge.at_most)], list[Delays](), None
    while left and delay is None:
        start, end = left.pop()
        found, middle = judge.settled(start, end), (start + end) / 2
        if found.settled == "free":
            delay = _first_free(judge, start, middle)
        elif found.settled == "open" and end - start > resolution:
            left += [(middle, end), (start, middle)]
            continue
        elif found.settled == "open" and judge.is_free(middle):  # settled() judges finer pieces than the result has
            delay = middle
        judged.append(found)
    return _result(judge, delay, tuple(judged))


def _first_free(judge: _Judge, start: float, middle: float) -> float | None:
    """A delay that is proved free without its interval's tube: the start, or one that is nearer to the middle, if any.

    Pieces that come within the tolerance may pass only where they are cut as for the interval.
    """
    tried = [start, *(start + (middle - start) * 2.0**-k for k in range(_TRIED, -1, -1))]
    return next((delay for delay in tried if judge.is_free(delay)), None)


def _result(judge: _Judge, delay: float | None, judged: tuple[Delays, ...]) -> LeastDelay:
    lower = 0.0
    for each in judged:
        if each.settled != "refuted":
            break
        lower = each.end
    trajectory = None if delay is None else judge.trajectory(delay)
    verdict = None
    if trajectory is not None:
        verdict = judge.checker.explain_trajectory(trajectory, judge.tube, judge.tolerance)
    return LeastDelay(delay, lower, judge.waiting, trajectory, verdict, judged)
