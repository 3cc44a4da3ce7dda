"""Frames of a moving camera, one after the other: a line of progress after each, then what each step takes.

In: how many frames and points. Out: rows of steps, printed as a table.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

from plannercheck.cli.common import table_of
from plannercheck.evaluation.sensing import moving_camera
from plannercheck.evaluation.sensing.moving_camera import Frame, StepRow
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene

_COLUMNS: dict[str, Callable[[StepRow], object]] = {
    "step": lambda row: row.step,
    "median ms": lambda row: f"{row.median:.1f}",
    "95 % ms": lambda row: f"{row.late:.1f}",
    "most ms": lambda row: f"{row.most:.1f}",
}


def follow(robot: Robot, scene: Scene, frames: int, points: int, seed: int = 0) -> list[StepRow]:
    """Goes through frames of so many points, of a scene with a start and a goal for the robot, and prints."""
    found: list[Frame] = []
    for frame in moving_camera.frames(robot, scene, frames, points, seed):
        found.append(frame)
        print(f"\r{_progress(frame, len(found), frames):<110}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    rows = moving_camera.step_rows(found)
    print(table_of(rows, _COLUMNS))
    whole = rows[-1]
    print(
        f"{whole.kept:,.0f} points a frame are not the robot's own; {moving_camera.STATES:,} states and a search each"
    )
    print(f"in time for {moving_camera.RATE} frames a second: {whole.in_time:.0%}; with a path: {whole.planned:.0%}")
    return rows


def _progress(frame: Frame, number: int, count: int) -> str:
    steps = ", ".join(f"{n} {1e3 * s:.1f}" for n, s in zip(moving_camera.STEPS, frame.seconds, strict=True))
    path = f"path of {frame.states} states" if frame.states else "no path"
    return f"frame {number} of {count}: {steps} = {1e3 * frame.total:.1f} ms, {path}"
