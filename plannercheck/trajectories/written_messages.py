"""Trajectories written as JointTrajectory messages.

In: `Points` with the joints' names. Out: a .yaml or .json file, which `Trajectory.load` reads back to the same doubles.

A message stamps its points by whole nanoseconds, so other times are refused: the trajectory that is written has to be
the one that was proved.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from plannercheck.common.atomic_files import write_atomically
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.written_yaml import yaml_of
from plannercheck.trajectories.controllers import Points
from plannercheck.trajectories.stamps import nanoseconds

SUFFIXES = (".yaml", ".yml", ".json")

# s, of a Duration's 32 bits.
_MOST_SECONDS = 2**31


def write_message(points: Points, path: Path) -> None:
    """Writes points as a message; the suffix chooses the format."""
    check_suffix(path)
    if not points.joint_names:
        raise PlannercheckError("a message names its joints: make the trajectory with joint_names=")
    message = message_of(points)
    text = json.dumps(message, indent=1) if path.suffix.lower() == ".json" else yaml_of(message, width=120)
    write_atomically(path, lambda aside: aside.write_text(text + "\n" * (text[-1] != "\n"), encoding="utf-8"))


def check_suffix(path: Path) -> None:
    """Raises unless the suffix is that of a format in which trajectories are written."""
    if path.suffix.lower() not in SUFFIXES:
        raise PlannercheckError(f"a trajectory is written as {', '.join(SUFFIXES)}, not {path.name!r}")


def message_of(points: Points) -> dict[str, Any]:
    """The message as plain data."""
    items = []
    for k, stamp in enumerate(_stamps(points)):
        item: dict[str, Any] = {"positions": points.positions[k].tolist()}
        if points.has_velocities[k]:
            item["velocities"] = points.velocities[k].tolist()
        if points.has_accelerations[k]:
            item["accelerations"] = points.accelerations[k].tolist()
        sec, nanosec = divmod(stamp, 10**9)
        items.append({**item, "time_from_start": {"sec": sec, "nanosec": nanosec}})
    return {"joint_names": list(points.joint_names), "points": items}


def _stamps(points: Points) -> list[int]:
    """The points' times as whole nanoseconds; raises if one is not the double nearest to such a time."""
    stamps, exact = nanoseconds(points.times)
    wrong = ~exact | (points.times >= _MOST_SECONDS)
    if wrong.any():
        k = int(np.argmax(wrong))
        raise PlannercheckError(
            f"point {k} is at {points.times[k]} s, but a message has whole nanoseconds below {_MOST_SECONDS} s: make"
            " the trajectory with times np.rint(times * 1e9) / 1e9"
        )
    return [int(stamp) for stamp in stamps.tolist()]
