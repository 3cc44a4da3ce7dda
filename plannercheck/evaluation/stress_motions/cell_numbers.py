"""Trajectories of a cell as rows of `Motions`: q0 holds what each robot does, and when; q1 holds the tube.

In: such a row. Out: the runs of the robots: each with its own curve and its own start, or standing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.robots.robot import Robot
from plannercheck.trajectories.curve import Curve
from plannercheck.trajectories.trajectory import Trajectory


class Run(NamedTuple):
    """What a robot does.

    Attributes:
        start: When its curve's own 0 s is on the clock, s.
        breaks: (m + 1,) s of its curve; none if it stands.
        pieces: (degree + 1, k) each, the control points, rad and m; of a robot that stands one row.
        error: (k,) of the curve.
    """

    start: float
    breaks: Floats
    pieces: tuple[Floats, ...]
    error: Floats

    @property
    def end(self) -> float:
        """When it ends on the clock, s."""
        return self.start + float(self.breaks[-1]) if len(self.breaks) else 0.0

    def at(self, times: Floats, units: tuple[tuple[int, int], ...]) -> Floats:
        """Configurations (n, k) at times (n,) of the clock, by its own curve."""
        if not len(self.breaks):
            return np.repeat(self.pieces[0], len(times), axis=0)
        curve = Curve(self.breaks, self.pieces, self.error, units)
        return curve.at(np.clip(times - self.start, self.breaks[0], self.breaks[-1]))

    def given(self, units: tuple[tuple[int, int], ...]) -> Trajectory | Floats:
        """As `on_one_clock` takes it."""
        if not len(self.breaks):
            return np.asarray(self.pieces[0][0])
        return Trajectory.of_curve(Curve(self.breaks, self.pieces, self.error, units))


def row_of(start_time: float, runs: Sequence[Run]) -> Floats:
    """The numbers of a row: when it starts on the scene's clock, s, and the runs."""
    out: list[Floats] = [np.array([start_time])]
    for run in runs:
        degrees = [len(piece) - 1 for piece in run.pieces]
        out += [np.array([run.start, len(run.breaks), *degrees]), run.breaks, run.error]
        out += [piece.ravel() for piece in run.pieces]
    return np.concatenate(out)


def runs_of(cell: Robot, row: Floats) -> tuple[float, dict[str, Run]]:
    """When it starts on the scene's clock, s, and the run of each robot that the cell moves."""
    runs, at = {}, 1

    def take(count: int) -> Floats:
        nonlocal at
        at += count
        return row[at - count : at]

    for name, part in cell.parts.items():
        width = len(part.columns)
        if not width:
            continue
        start, knots = take(2).tolist()
        degrees = take(max(int(knots) - 1, 1)).astype(int).tolist()
        breaks, error = take(int(knots)), take(width)
        pieces = tuple(take((degree + 1) * width).reshape(-1, width) for degree in degrees)
        runs[name] = Run(start, breaks, pieces, error)
    return float(row[0]), runs


def reordered(cell: Robot, row: Floats, names: Sequence[str]) -> Floats:
    """The row of the same runs for a cell whose robots come in another order."""
    start_time, runs = runs_of(cell, row)
    return row_of(start_time, [runs[name] for name in names if name in runs])


def duration(runs: Mapping[str, Run]) -> float:
    """From 0 s to the end of the longest run, s."""
    return max(run.end for run in runs.values())
