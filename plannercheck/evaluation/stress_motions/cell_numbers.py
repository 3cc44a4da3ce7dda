"""Trajectories of a cell as rows of `Motions`: q0 holds what each robot does, and when; q1 holds the tube.

In: such a row. Out: the runs of the robots: each with its own curve and its own start, or standing; and all on one
clock.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.robots.robot import Robot
from plannercheck.trajectories.curve import Curve
from plannercheck.trajectories.one_clock import on_one_clock
from plannercheck.trajectories.trajectory import Trajectory

# Rows of which the runs are kept: the judges ask for them again and again.
_KEPT = 256


class Run(NamedTuple):
    """What a robot does.

    Attributes:
        start: When its curve's own 0 s is on the clock, s.
        does: Its curve, or the configuration (k,) at which it stands.
    """

    start: float
    does: Curve | Floats

    @property
    def end(self) -> float:
        """When it ends on the clock, s."""
        return self.start + float(self.does.breaks[-1]) if isinstance(self.does, Curve) else 0.0

    def at(self, times: Floats) -> Floats:
        """Configurations (n, k) at times (n,) of the clock, by its own curve."""
        if not isinstance(self.does, Curve):
            return np.repeat(self.does[None], len(times), axis=0)
        return self.does.at(np.clip(times - self.start, self.does.breaks[0], self.does.breaks[-1]))


def row_of(start_time: float, runs: Sequence[Run]) -> Floats:
    """The numbers of a row: when it starts on the scene's clock, s, and the runs."""
    out: list[Floats] = [np.array([start_time])]
    for start, does in runs:
        if isinstance(does, Curve):
            out += [np.array([start, len(does.breaks), *does.counts.tolist()]), does.breaks, does.error]
            out += [piece.ravel() for piece in does.pieces]
        else:
            out += [np.zeros(2), does]
    return np.concatenate(out)


def runs_of(cell: Robot, row: Floats) -> tuple[float, dict[str, Run]]:
    """When it starts on the scene's clock, s, and the run of each robot that the cell moves."""
    return _read(cell, row.tobytes())


@lru_cache(maxsize=_KEPT)
def _read(cell: Robot, numbers: bytes) -> tuple[float, dict[str, Run]]:
    row, runs, at = np.frombuffer(numbers), {}, 1

    def take(count: int) -> Floats:
        nonlocal at
        at += count
        return row[at - count : at]

    for name, part in cell.parts.items():
        width = len(part.columns)
        if not width:
            continue
        start, knots = take(2).tolist()
        if not knots:
            runs[name] = Run(start, take(width))
            continue
        counts = take(int(knots) - 1).astype(int).tolist()
        breaks, error = take(int(knots)), take(width)
        pieces = tuple(take(count * width).reshape(-1, width) for count in counts)
        runs[name] = Run(start, Curve(breaks, pieces, error, part.robot.configuration_map.units))
    return float(row[0]), runs


def reordered(cell: Robot, row: Floats, names: Sequence[str]) -> Floats:
    """The row of the same runs for a cell whose robots come in another order."""
    start_time, runs = runs_of(cell, row)
    return row_of(start_time, [runs[name] for name in names if name in runs])


def duration(runs: Mapping[str, Run]) -> float:
    """From 0 s to the end of the longest run, s."""
    return max(run.end for run in runs.values())


@lru_cache(maxsize=_KEPT)
def merged(cell: Robot, numbers: bytes) -> Trajectory:
    """The trajectory of a row's bytes on one clock."""
    _, runs = _read(cell, numbers)
    starts = {name: run.start for name, run in runs.items() if isinstance(run.does, Curve)}
    given = {name: Trajectory.of_curve(does) if isinstance(does, Curve) else does for name, (_, does) in runs.items()}
    return on_one_clock(cell, given, starts)
