"""The verdict of a gate on one chunk: whether it passes; why not, and how far it is safe, if that is asked for.

In: a chunk, what the controller runs, what proves it. Out: `GateVerdict`. Reasons, the stop and the slack are computed
when first asked for, so that a loop waits for `ok` alone.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np

from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.public_names import set_module
from plannercheck.common.shown_times import shown_seconds
from plannercheck.motions.certifier_answers import ImpreciseError
from plannercheck.motions.trajectory_verdict import Stop
from plannercheck.trajectories.curve import Curve
from plannercheck.trajectories.limits import Excess
from plannercheck.trajectories.trajectory import Trajectory
from plannercheck.validation.gates.chunks import Chunk, Run, run_of
from plannercheck.validation.gates.limits import GateLimits, without_rounding
from plannercheck.validation.gates.proving import ChunkProofs
from plannercheck.validation.gates.settings import GateSettings
from plannercheck.validation.gates.stops import Stops, stops_from

ReasonKind = Literal["jump", "speed", "acceleration", "limit", "collision", "unproved"]
_KINDS: dict[str, ReasonKind] = {"position": "limit", "velocity": "speed", "acceleration": "acceleration"}

# How long the stop of a robot that rests already stands still, s: a trajectory takes some time.
_STANDS = 1e-3


@set_module("plannercheck")
@dataclass(frozen=True)
class Reason:
    """Why a chunk does not pass.

    Attributes:
        kind: "jump": the first waypoint is elsewhere than the robot can be by then; "speed", "acceleration" or "limit"
            (of positions): a joint's limit is broken; "collision": bodies share a point; "unproved": with the tube,
            bodies come nearer than the margin.
        time: The instant, s: of the largest excess, of the first collision, or where the proof fails.
        joint: The joint whose limit is broken, else None.
        value: Its number at that instant, rad and m, by s; of a jump its speed, or how far off it is.
        limit: The limit on this side.
        pair: The link and the other link or obstacle, else None.
        on_stop: Whether this is of the stop behind the chunk.
    """

    kind: ReasonKind
    time: float
    joint: str | None = None
    value: float | None = None
    limit: float | None = None
    pair: tuple[str, str] | None = None
    on_stop: bool = False

    def __str__(self) -> str:
        where = f"at {shown_seconds(self.time)} s" + (", on the stop behind the chunk" if self.on_stop else "")
        if self.joint is not None:
            return f"{self.kind} of {self.joint} {where}: {self.value:.6g}, beyond {self.limit:.6g}"
        return f"{self.kind} {where}" + ("" if self.pair is None else f": {' – '.join(self.pair)}")


class GateTools(NamedTuple):
    """What verdicts of a gate share."""

    settings: GateSettings
    limits: GateLimits
    proofs: ChunkProofs
    hashes: Any
    turning: list[int]


class _Safe(NamedTuple):
    """The longest prefix behind which a stop is proved: its pieces, and the stop among others."""

    pieces: int
    stops: Stops
    stop: int


@set_module("plannercheck")
class GateVerdict:
    """The verdict on one chunk; it is true if the chunk passes.

    Attributes:
        ok: Whether the chunk keeps all limits, and it and the stop behind it are proved free.
    """

    def __init__(self, chunk: Chunk, tools: GateTools, ok: bool | None = None, but_the_stop: bool = False) -> None:
        """Made by `Gate.judge`; `ok` if that is known already, or that all passes `but_the_stop`."""
        self._chunk, self._tools = chunk, tools
        self.ok = ok if ok is not None else self._stop_passes() if but_the_stop else self._passes()

    @cached_property
    def _run(self) -> Run:
        """What the controller runs."""
        return run_of(self._chunk, self._tools.settings.controller, self._tools.turning)

    @cached_property
    def _stops(self) -> Stops:
        """The stop behind the chunk, alone."""
        run = self._run
        return stops_from(run.points[-1:, -1], run.velocities()[-1:, -1], self._tools.settings.brake)

    def _passes(self) -> bool:
        """Whether the chunk passes, by the plain path: limits first, then proofs of all pieces."""
        if not (self._keeps_limits.all() and self._tools.limits.hold(self._stops.rests)[0]):
            return False
        return bool(self._free.all()) and self._stop_passes()

    def _stop_passes(self) -> bool:
        """Whether the stop behind the chunk is proved free."""
        return bool(self._tools.proofs.stop_pieces_free(self._run.error, self._stops).all())

    @cached_property
    def _keeps_limits(self) -> Bools:
        """(m,) which pieces keep all limits; the first only if the robot stands where it begins."""
        run = self._run
        good = self._tools.limits.kept_exactly(run, run.velocities(), self._chunk.dq)
        good[0] &= not self._jumps()
        return good

    def __bool__(self) -> bool:
        return self.ok

    def __repr__(self) -> str:
        if self.ok:
            return f"GateVerdict(ok, {shown_seconds(self._run.breaks[-1])} s and a stop)"
        until = "no stop is proved" if self.safe_until is None else f"safe until {shown_seconds(self.safe_until)} s"
        return f"GateVerdict({'; '.join([*map(str, self.reasons), until])})"

    @cached_property
    def trajectory(self) -> Trajectory:
        """The chunk as the controller runs it, from 0 s on."""
        return Trajectory.of_curve(self._run.curve())

    @cached_property
    def reasons(self) -> tuple[Reason, ...]:
        """Why the chunk does not pass, in the order of time; none if it does."""
        if self.ok:
            return ()
        found = [*self._jumps(), *self._excesses()]
        if not self._free.all():
            found.append(self._refusal(self.trajectory, self._free))
        if not found:
            found = self._reasons_of_stop()
        return tuple(sorted(found, key=lambda reason: (reason.time, reason.kind != "jump")))

    @cached_property
    def safe_until(self) -> float | None:
        """The end, s, of the longest prefix that keeps all limits and is proved free, its stop included.

        A prefix ends at a waypoint, or at 0.0, where the robot stands; None if no stop is proved from there either.
        """
        return None if self._safe is None else float(self._ends[self._safe.pieces])

    @cached_property
    def stop(self) -> Trajectory | None:
        """The stop from `safe_until` on: each joint brakes at its constant `brake` until it rests. None without one."""
        if self._safe is None:
            return None
        pieces, stops, k = self._safe
        begin = float(self._ends[pieces])
        curve = stops.curve(k, begin, self._run.error)
        if curve is None:
            q = stops.rests[k]
            curve = Curve(np.array([begin, begin + _STANDS]), (np.array([q, q]),), stops.error + self._run.error)
        return Trajectory.of_curve(curve)

    @cached_property
    def slack(self) -> float:
        """How much more than the margin is proved, tube included, on the chunk and its stop, m; 0 if it is not ok.

        To a hundredth of the distance; infinite without pairs.
        """
        if not self.ok or self.stop is None:
            return 0.0
        least = self._tools.proofs.checks.largest_room([self.trajectory, self.stop])
        return float(max(least - self._tools.settings.margin, 0.0))

    def record(self) -> str:
        """One line of JSON that `plannercheck replay` judges again: hashes, chunk, settings, verdict, version."""
        return json.dumps(self._tools.hashes.record(self._chunk, self._tools.settings, self.as_json(slack=True)))

    def as_json(self, slack: bool = False) -> dict[str, Any]:
        """The verdict as plain data, as `plannercheck gate` answers; with the slack if it is asked for."""
        reasons = [
            {name: value for name, value in vars(reason).items() if value is not None and value is not False}
            for reason in self.reasons
        ]
        found: dict[str, Any] = {"ok": self.ok, "reasons": reasons, "safe_until": self.safe_until}
        if slack:
            found["slack"] = self.slack if self.slack < np.inf else None
        if self.stop is not None:
            curve = self.stop.curve
            velocities = np.append(self.stop.velocity(curve.breaks[:-1]), np.zeros((1, curve.nq)), axis=0)
            positions = self.stop.position(curve.breaks)
            rows = {"times": curve.breaks, "positions": positions, "velocities": velocities}
            found["stop"] = {name: value.tolist() for name, value in rows.items()}
        return found

    @property
    def _ends(self) -> Floats:
        """(m + 1,) s, where prefixes end: at the start, and at the end of each piece."""
        return np.concatenate(([0.0], self._run.breaks[1:]))

    @cached_property
    def _free(self) -> Bools:
        """(m,) which pieces are proved free."""
        return self._tools.proofs.free(self._run.points, self._run.error)

    @cached_property
    def _safe(self) -> _Safe | None:
        run, chunk, tools = self._run, self._chunk, self._tools
        if self.ok:
            return _Safe(len(run.steps), self._stops, 0)
        good = self._keeps_limits & self._free
        longest = len(good) if good.all() else int(np.argmin(good))
        positions = np.concatenate((chunk.q[None], run.points[:longest, -1]))
        begins = np.concatenate((chunk.dq[None], run.velocities()[:longest, -1]))
        stops = stops_from(positions, begins, tools.settings.brake)
        stops.lasting[0, 0] = True  # so that the start is judged where the robot rests there
        free = tools.proofs.stop_pieces_free(run.error, stops).all(axis=1) & tools.limits.hold(stops.rests)
        if not free.any():
            return None
        last = int(np.flatnonzero(free)[-1])
        stops.lasting[0, 0] = stops.times[0, 1] > 0
        return _Safe(last, stops, last)

    def _jumps(self) -> list[Reason]:
        """The first waypoint is at 0 s, and the robot stands elsewhere."""
        if self._chunk.from_start:
            return []
        off, tube = self._chunk.positions[0] - self._chunk.q, self._tools.settings.tube
        names = self._tools.limits.names
        return [
            Reason("jump", 0.0, names[j], float(off[j]), float(tube[j]))
            for j in np.flatnonzero(np.abs(off) > tube).tolist()
        ]

    def _excesses(self) -> list[Reason]:
        """Limits that the chunk breaks; too much speed on the way to the first waypoint is a jump."""
        limits, run = self._tools.limits, self._run
        worst: dict[tuple[ReasonKind, str], Excess] = {}
        begin = 1 if self._chunk.from_start else 0
        found = [(_KINDS[each.kind], each) for each in limits.broken_at_corners(run, self._chunk.dq)]
        if begin:
            for each in limits.broken(run.curve(0, 1)):
                found.append(("jump" if each.kind == "velocity" else _KINDS[each.kind], each))
        if begin < len(run.steps):
            found += [(_KINDS[each.kind], each) for each in limits.broken(run.curve(begin))]
        for kind, each in found:
            known = worst.get((kind, each.joint))
            if known is None or abs(each.value - each.limit) > abs(known.value - known.limit):
                worst[kind, each.joint] = each
        return [_of_excess(kind, each) for (kind, _), each in worst.items()]

    def _reasons_of_stop(self) -> list[Reason]:
        """Why the stop behind the chunk does not pass."""
        tools, stops, run = self._tools, self._stops, self._run
        begin = float(run.breaks[-1])
        end, rest = begin + float(stops.times[0, -1]), stops.rests[0]
        found = list[Reason]()
        for j in np.flatnonzero((rest < tools.limits.lower) | (rest > tools.limits.upper)).tolist():
            limit = (tools.limits.lower if rest[j] < tools.limits.lower[j] else tools.limits.upper)[j]
            found.append(Reason("limit", end, tools.limits.names[j], float(rest[j]), float(limit), on_stop=True))
        curve = stops.curve(0, begin, run.error)
        if curve is not None:
            free = tools.proofs.stop_pieces_free(run.error, stops)[0, stops.lasting[0]]
            if not free.all():
                found.append(self._refusal(Trajectory.of_curve(curve), free, on_stop=True))
        return found or [Reason("unproved", begin)]

    def _refusal(self, trajectory: Trajectory, free: Bools, on_stop: bool = False) -> Reason:
        """Why not all pieces are free; without a pair where numbers are so large that rounding is no small part."""
        try:
            return _stopped(self._tools.proofs.checks.stopped(trajectory, free), on_stop)
        except ImpreciseError:
            return Reason("unproved", float(trajectory.curve.breaks[int(np.argmin(free))]), on_stop=on_stop)


def _stopped(stop: Stop, on_stop: bool) -> Reason:
    names = None if stop.pair is None else stop.pair.names
    if stop.collides_at is not None:
        return Reason("collision", stop.collides_at, pair=names, on_stop=on_stop)
    at = stop.free_until if stop.near_at is None else stop.near_at
    return Reason("unproved", at, pair=names, on_stop=on_stop)


def _of_excess(kind: ReasonKind, excess: Excess) -> Reason:
    given = without_rounding(excess)
    return Reason(kind, given.time, given.joint, given.value, given.limit)
