"""A checker of a cell, asked about trajectories of its robots on one clock, while bodies move.

In: the recipe of a cell. Out: `CellSubject`. A state is a configuration with a time of the scene's clock at its end.
States come from the robots' own curves, so that a wrong merge is found.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path

import numpy as np

from plannercheck.bodies.tuning import DEFAULT_TUNING, Tuning
from plannercheck.common.array_types import Bools, Floats
from plannercheck.evaluation.stress_motions.cell_numbers import duration, merged, runs_of
from plannercheck.evaluation.stress_motions.recipes import CellRecipe, cell_checker
from plannercheck.evaluation.stress_motions.subjects import Subject
from plannercheck.evaluation.stress_motions.tube_reach import TubeReach
from plannercheck.motions.certifier_answers import MotionResult
from plannercheck.motions.checker import Checker
from plannercheck.motions.motion_ends import Curves
from plannercheck.motions.trajectory_checks import TrajectoryChecks
from plannercheck.motions.trajectory_verdict import TrajectoryVerdict
from plannercheck.proofs import Proof, load_proofs, save_proofs
from plannercheck.robots.robot import Robot
from plannercheck.trajectories.trajectory import Trajectory

# What bodies move in the time by which an instant of the clock is rounded, m.
_INSTANT = 1e-9


class CellSubject(Subject):
    """A checker of a cell; rows are those of `cell_numbers`."""

    checker: Checker

    def __init__(self, recipe: CellRecipe, cell: Robot | None = None, tuning: Tuning = DEFAULT_TUNING) -> None:
        """Builds a new checker; `cell` if it was built already."""
        super().__init__(cell_checker(recipe, cell, tuning), {})
        self.padding = float(recipe["padding"])
        self._clocked: dict[bytes, tuple[Checker, Trajectory]] = {}

    # ----- verdicts

    def check(self, q0: Floats, q1: Floats, tolerance: float, threads: int = 1) -> Bools:
        """See `Subject`; all have the same tube."""
        made = [self.merged(row) for row in q0]
        return np.asarray(self.checker.check_trajectories(made, q1[0], tolerance, threads, start_time=q0[:, 0]))

    def check_one(self, q0: Floats, q1: Floats, tolerance: float) -> bool:
        """See `Subject`."""
        return bool(self.checker.check_trajectory(self.merged(q0), q1, tolerance, start_time=float(q0[0])))

    def explain(self, q0: Floats, q1: Floats, tolerance: float) -> TrajectoryVerdict:
        """See `Subject`; instants are parameters from 0 to 1."""
        made, start = self.merged(q0), float(q0[0])
        found: TrajectoryVerdict = self.checker.explain_trajectory(made, q1, tolerance, start_time=start)
        begin = 0.0 if self.checker._moving is None else start
        until, collides, near = (
            None if t is None else (t - begin) / made.duration
            for t in (found.free_until, found.collides_at, found.near_at)
        )
        assert until is not None
        return replace(found, stop=replace(found.stop, free_until=until, collides_at=collides, near_at=near))

    def certify(self, q0: Floats, q1: Floats, tolerance: float) -> tuple[Sequence[Proof] | None, ...]:
        """See `Subject`; proofs are saved and loaded."""
        found: list[Sequence[Proof] | None] = []
        for row, tube in zip(q0, q1, strict=True):
            made = self.checker.certify_trajectory(self.merged(row), tube, tolerance, start_time=float(row[0]))
            if made is not None:
                with tempfile.TemporaryDirectory() as folder:
                    save_proofs(made, Path(folder) / "cell.proof.npz")
                    made = load_proofs(Path(folder) / "cell.proof.npz")
            found.append(made)
        return tuple(found)

    def motion_result(self, q0: Floats, q1: Floats, tolerance: float, proofs: bool = False) -> MotionResult:
        """See `Subject`: of the first piece that is refused; of all, if none is, the least that is proved."""
        checker, judged = self._on_clock(q0)
        checks, curve = TrajectoryChecks(checker, q1, tolerance), judged.curve
        around = np.append(checks.tube_of(judged), 0.0)[None]
        begin, length = float(curve.breaks[0]), judged.duration
        certifier, results = checker.certifier_of("slerp"), []
        for piece, first, last in zip(curve.pieces, curve.breaks[:-1].tolist(), curve.breaks[1:].tolist(), strict=True):
            result = certifier.result(Curves(piece[None], around), tolerance, proofs)
            results.append(result._replace(near=(first - begin + result.near * (last - first)) / length))
        refused = [result for result in results if not result.free]
        return refused[0] if refused else min(results, key=lambda result: result.proved_until)

    # ----- states

    def check_states(self, q: Floats) -> Bools:
        """See `Subject`."""
        return np.asarray(self.checker.check_states(q[:, :-1], times=q[:, -1]))

    def clearances(self, q: Floats) -> Floats:
        """See `Subject`."""
        return np.asarray(self.checker.clearances(q[:, :-1], times=q[:, -1]))

    def placed(self, q: Floats) -> Floats:
        """See `Subject`."""
        return np.asarray(self.robot.link_poses(q[:, :-1]))

    def nearest(self, states: Floats, others: Floats, q1: Floats) -> Floats:
        """See `Subject`."""
        tube = np.concatenate([q1, np.zeros((*q1.shape[:-1], 1))], axis=-1)
        return np.clip(others, states - tube, states + tube)

    def ends(self, q0: Floats, q1: Floats) -> tuple[Floats, Floats]:
        """See `Subject`."""
        first, last = zip(*(self.states(*row, np.array([0.0, 1.0])) for row in zip(q0, q1, strict=True)), strict=True)
        return np.array(first), np.array(last)

    def states(self, q0: Floats, q1: Floats, parameters: Floats) -> Floats:
        """See `Subject`."""
        start_time, runs = runs_of(self.robot, q0)
        times = parameters * duration(runs)
        found = np.empty((len(times), self.robot.nq + 1))
        for name, run in runs.items():
            found[:, self.robot.parts[name].columns] = run.at(times)
        found[:, -1] = start_time + times
        return found

    def slack(self, q0: Floats, q1: Floats) -> float:
        """See `Subject`: of all pairs, the largest sum of lever arms by the tube."""
        if not q1.any():
            return 0.0
        checker, judged = self._on_clock(q0)
        return self._shift(judged, np.append(q1, np.zeros(checker.robot.nq - len(q1))))

    def rounding(self, q0: Floats) -> float:
        """See `Subject`: lever arms by the curve's own error, and what an instant that is rounded once more adds."""
        _, judged = self._on_clock(q0)
        return _INSTANT + self._shift(judged, judged.curve.error)

    def _shift(self, judged: Trajectory, tube: Floats) -> float:
        """How far a tube moves any body against another at most, m."""
        return self._reach.largest_shift(np.abs(np.concatenate(judged.curve.pieces)).max(axis=0), tube)

    def _motion(self, q0: Floats, q1: Floats) -> tuple[Floats, ...]:
        return q0, q1

    # ----- trajectories

    def merged(self, row: Floats) -> Trajectory:
        """The trajectory of a row on one clock."""
        return merged(self.robot, row.tobytes())

    def _on_clock(self, row: Floats) -> tuple[Checker, Trajectory]:
        """The checker that judges a row, and its trajectory with the numbers of what moves."""
        key = row.tobytes()
        if key not in self._clocked:
            checker, (judged,) = self.checker._on_clock([self.merged(row)], float(row[0]))
            self._clocked[key] = checker, judged
        return self._clocked[key]

    @cached_property
    def _reach(self) -> TubeReach:
        moving = self.checker._moving
        return TubeReach(self.checker if moving is None else moving.checker)
