"""Distances of near pairs, with points and gradients, beside Pinocchio with coal, coal alone and drake.

In: a checker, how many states. Out: a row for each method, of free states drawn at random and along motions. Pinocchio
measures all pairs, and joints' Jacobians stand for the gradients' cost; coal measures the pairs that `distances`
leaves, at poses that are known, at its own tolerance and at one as fine as ours; drake's `CalcRobotClearance` has an
influence distance, as `limit`. What Python adds to a call of theirs is a few microseconds for Pinocchio and drake;
coal's calls are made one a pair.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.bench.drake_checker import drake_model
from plannercheck.evaluation.bench.other_libraries import coal_geometry_data, coal_geometry_model
from plannercheck.evaluation.bench.timing import Contender, TimedRow, Work, available, measured
from plannercheck.motions.checker import Checker

LIMIT = 0.1  # m

# States of a motion, and those that slow libraries measure in a round.
_ON_A_MOTION, _FEW = 100, 20

# How far off the states are from whose table `start=` begins, rad and m: a small step of an optimiser, and a large one.
_STEPS = (0.003, 0.03)

# Of coal's GJK, m: its own tolerance, and that of our bounds.
_COAL_TOLERANCES = {"coal, near pairs": 1e-6, "coal, to 1e-12 m": 1e-12}


@dataclass(frozen=True)
class DistanceRow(TimedRow):
    """What one method took.

    Attributes:
        robot: Its name.
        scene: Its name.
        states: How they were drawn.
        near: Pairs within the limit a state.
        error: How far its distances are outside of our bounds, m; None where these are not compared.
    """

    robot: str
    scene: str
    states: str
    near: float
    error: float | None


def measure(
    checker: Checker, n: int, rounds: int, seed: int, skipped: Callable[[str], None] = lambda reason: None
) -> list[DistanceRow]:
    """Times all methods by turns; arguments as of `trajectories.measure`, `n` states."""
    drawn = {"at random": free_states(checker, n, seed), "along motions": _along(checker, n, seed)}
    return [row for name, q in drawn.items() for row in _of_states(checker, q, name, rounds, skipped)]


def _of_states(
    checker: Checker, q: Floats, drawn: str, rounds: int, skipped: Callable[[str], None]
) -> list[DistanceRow]:
    steps = np.random.default_rng(0).normal(size=q.shape)
    earlier = {f"start={step:g} off": checker.distances(q + step * steps, LIMIT) for step in _STEPS}
    works: dict[str, Contender] = {
        "distances": Contender([partial(checker.distances, q, LIMIT)], len(q)),
        **{name: Contender([partial(checker.distances, q, LIMIT, start=of)], len(q)) for name, of in earlier.items()},
        "without gradients": Contender([partial(checker.distances, q, LIMIT, gradients=False)], len(q)),
        "nearest=1": Contender([partial(checker.distances, q, nearest=1)], len(q)),
    }
    some, table = q[:: max(1, len(q) // _FEW)], checker.distances(q, LIMIT)
    peers: dict[str, tuple[Callable[[Checker, Floats], Callable[[], object]], Floats]] = {
        "Pinocchio, all pairs": (_pinocchio, some),
        **{name: (partial(coal_distances, tolerance=each), q) for name, each in _COAL_TOLERANCES.items()},
        "drake": (_drake, some),
    }
    errors: dict[str, float] = {}
    for name, (make, of) in peers.items():
        work = available(name, partial(make, checker, of), skipped)
        if work is None:
            continue
        works[name] = Contender([work], len(of))
        if name in _COAL_TOLERANCES:
            found = np.asarray(work())
            errors[name] = float(np.maximum(table.lower - found, found - table.distance).max(initial=0.0))
    times = measured(works, rounds)
    near = len(table) / len(q)
    return [
        DistanceRow(*times.row(name), checker.robot.name, checker.scene.name, drawn, near, errors.get(name))
        for name in works
    ]


def free_states(checker: Checker, n: int, seed: int) -> Floats:
    """Random free configurations (n, nq)."""
    rng, found = np.random.default_rng(seed), np.empty((0, checker.robot.nq))
    while len(found) < n:
        q = checker.robot.random_configurations(4 * n, rng)
        found = np.concatenate([found, q[checker.check_states(q)]])
    return found[:n]


def _along(checker: Checker, n: int, seed: int) -> Floats:
    """States of free motions, one after the other."""
    ends = free_states(checker, 2 * n, seed + 1)
    kept = np.flatnonzero(checker.check_motions(ends[:-1], ends[1:]))[: n // _ON_A_MOTION + 1]
    if not len(kept):
        raise PlannercheckError(f"no free motion of {2 * n} was found in {checker.scene.name!r}")
    t = np.linspace(0, 1, _ON_A_MOTION)[:, None]
    return np.concatenate([(1 - t) * ends[k] + t * ends[k + 1] for k in kept.tolist()])[:n]


def _pinocchio(checker: Checker, q: Floats) -> Work:
    """All pairs by Pinocchio and coal, then the Jacobians of all joints."""
    import pinocchio as pin

    model, geometry = checker.robot.model, coal_geometry_model(checker)
    data, geometry_data = model.createData(), coal_geometry_data(geometry, 1e-6)
    rows = list(checker.robot.expand(q))

    def work() -> None:
        for row in rows:
            pin.computeDistances(model, data, geometry, geometry_data, row)
            pin.computeJointJacobians(model, data, row)

    return work


def coal_distances(
    checker: Checker, q: Floats, tolerance: float = _COAL_TOLERANCES["coal, near pairs"]
) -> Callable[[], list[float]]:
    """Coal's distance for the pairs that are near, at poses computed before; `tolerance` of its GJK, m."""
    import coal

    geometry, table, calls = coal_geometry_model(checker), checker.distances(q, LIMIT), list[tuple[Any, ...]]()
    places = {tuple(sorted((pair.first, pair.second))): pair for pair in geometry.collisionPairs}
    if len(places) != len(checker.pairs):
        raise PlannercheckError("Pinocchio's pairs are not the checker's")
    ordered = list(geometry.collisionPairs)
    poses = checker.body_poses(q)
    for state, k in zip(table.state.tolist(), table.pair.tolist(), strict=True):
        pair = ordered[k]
        args: list[Any] = []
        for place, body in zip((pair.first, pair.second), checker.pairs[k].tolist(), strict=True):
            shape = geometry.geometryObjects[place]
            pose = poses[state, body]
            args += [shape.geometry, coal.Transform3s(pose[:3, :3], pose[:3, 3])]
        calls.append(tuple(args))
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    request.enable_signed_distance, request.gjk_tolerance = True, tolerance

    def work() -> list[float]:
        found = []
        for call in calls:
            result.clear()
            found.append(coal.distance(*call, request, result))
        return found

    return work


def _drake(checker: Checker, q: Floats) -> Work:
    made, rows = drake_model(checker), list(checker.robot.expand(q))

    def work() -> None:
        for row in rows:
            made.CalcRobotClearance(row, LIMIT)

    return work
