"""Trajectories as tables: csv with a column a quantity, npz with an array a quantity.

In: a file, a robot. Out: `Points` in the order of the robot's joints.

A csv begins with the names of its columns: the time in s, then `joint` or `joint.position` for each joint, and where
there are any, `joint.velocity` and `joint.acceleration`; `/topic/joint/position` is read likewise, as PlotJuggler names
columns. Cells of velocities and accelerations may be empty.

An npz has times (n,), positions (n, nq), and where there are any, velocities, accelerations and joint_names; without
names, columns are in the robot's order.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.checked_yaml import BROKEN_FILE, error_context, read_bytes
from plannercheck.common.errors import PlannercheckError, shortened, unknown_name
from plannercheck.trajectories.controllers import Points
from plannercheck.trajectories.joint_columns import Joints, columns_of

_TIMES = ("time", "t", "time_from_start", "__time", "timestamp")
_QUANTITIES = ("position", "velocity", "acceleration")
_PLURALS = {"positions": "position", "velocities": "velocity", "accelerations": "acceleration"}

# s: a time from the start is less, one of a clock more.
_CLOCK = 1e8

_ARRAYS = ("times", "positions", "velocities", "accelerations", "joint_names")


def read_csv(path: Path, robot: Joints) -> Points:
    """Reads a csv."""
    try:
        rows = [row for row in csv.reader(read_bytes(path).decode("utf-8-sig").splitlines(), strict=True) if row]
    except (UnicodeDecodeError, csv.Error) as error:
        raise PlannercheckError(f"is no csv: {error}") from None
    if len(rows) < 2:
        raise PlannercheckError("must have a line of names and a line for each point")
    header = [name.strip() for name in rows[0]]
    time, columns = _columns(header, robot)
    for k, row in enumerate(rows[1:]):
        if len(row) != len(header):
            raise PlannercheckError(f"point {k} has {len(row)} cells, and the header {len(header)}")
    positions = _values(rows[1:], header, columns["position"], may_lack=False)
    times = _values(rows[1:], header, [time], may_lack=False)[:, 0]
    if times[0] >= _CLOCK:
        raise PlannercheckError(f"its times are those of a clock ({times[0]:.3f} s): subtract the first from all")
    none = np.full_like(positions, np.nan)
    v, a = (
        _values(rows[1:], header, columns[name], may_lack=True) if columns[name] else none for name in _QUANTITIES[1:]
    )
    return Points(times, positions, v, a, robot.joint_names)


def _columns(header: Sequence[str], robot: Joints) -> tuple[int, dict[str, list[int]]]:
    """The column of the time, and those of each quantity in the robot's order; none where a csv lacks it."""
    times = [k for k, name in enumerate(header) if name.lower() in _TIMES and name not in robot.joint_names]
    if len(times) != 1:
        raise PlannercheckError(
            f"must have one column of the time in s, called {_TIMES[0]!r}, not {len(times)}; commas part its columns,"
            f" which are {shortened(', '.join(header))}"
        )
    names: dict[str, list[str]] = {quantity: [] for quantity in _QUANTITIES}
    places: dict[str, list[int]] = {quantity: [] for quantity in _QUANTITIES}
    for k, name in enumerate(header):
        if k != times[0]:
            joint, quantity = _parted(name, robot)
            names[quantity].append(joint)
            places[quantity].append(k)
    for quantity in _QUANTITIES:
        if names[quantity] or quantity == "position":
            with error_context(quantity):
                places[quantity] = [places[quantity][k] for k in columns_of(names[quantity], robot)]
    return times[0], places


def _parted(name: str, robot: Joints) -> tuple[str, str]:
    """Joint and quantity of a column."""
    if name in robot.joint_names:
        return name, "position"
    for mark in ("/", "."):
        joint, _, quantity = name.rpartition(mark)
        quantity = _PLURALS.get(quantity, quantity)
        if quantity in _QUANTITIES:
            return joint if joint in robot.joint_names else joint.rpartition("/")[2], quantity
    known = ", ".join(f"{robot.joint_names[0]}.{quantity}" for quantity in _QUANTITIES)
    raise PlannercheckError(
        f"has a column {shortened(name)!r}, which is no joint of {robot.name} ({', '.join(robot.joint_names)}) and not"
        f" named as {known}"
    )


def _values(rows: Sequence[Sequence[str]], header: Sequence[str], columns: list[int], may_lack: bool) -> Floats:
    """(n, columns) numbers; NaN for empty cells, where those may be."""
    found = np.full((len(rows), len(columns)), np.nan)
    for k, row in enumerate(rows):
        for j, column in enumerate(columns):
            cell = row[column].strip()
            if cell or not may_lack:
                found[k, j] = _number(cell, k, header[column])
    return found


def _number(cell: str, point: int, name: str) -> float:
    try:
        value = math.nan if "_" in cell else float(cell)  # Python reads 1_000
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise PlannercheckError(f"point {point}, column {shortened(name)!r}: {shortened(cell)!r} is no finite number")
    return value


def read_npz(path: Path, robot: Joints) -> Points:
    """Reads an npz."""
    try:
        with np.load(path, allow_pickle=False) as arrays:
            found = {name: arrays[name] for name in arrays.files}
    except BROKEN_FILE as error:
        raise PlannercheckError(f"is no npz that can be read: {error!s:.200}") from None
    for name in found:
        if name not in _ARRAYS:
            raise unknown_name("array", name, _ARRAYS)
    for name in _ARRAYS[:2]:
        if name not in found:
            raise PlannercheckError(f"has no array {name!r}; it has {', '.join(found) or 'none'}")
    positions = _numbers(found, "positions")
    names = [str(name) for name in np.atleast_1d(found.get("joint_names", np.array(robot.joint_names))).tolist()]
    order = columns_of(names, robot)
    if positions.ndim != 2 or positions.shape[1] != len(names):
        raise PlannercheckError(f"'positions' must be (n, {len(names)}), a column a joint, not {positions.shape}")
    none = np.full_like(positions, np.nan)
    rows = [_numbers(found, name) if name in found else none for name in _ARRAYS[2:4]]
    for name, row in zip(_ARRAYS[2:4], rows, strict=True):
        if row.shape != positions.shape:
            raise PlannercheckError(f"{name!r} must be {positions.shape} as the positions, not {row.shape}")
    v, a = (row[:, order] for row in rows)
    return Points(_numbers(found, "times"), positions[:, order], v, a, robot.joint_names)


def _numbers(arrays: dict[str, np.ndarray], name: str) -> Floats:
    if arrays[name].dtype.kind not in "fiu":
        raise PlannercheckError(f"{name!r} must hold numbers, not {arrays[name].dtype}")
    return np.asarray(arrays[name], dtype=np.float64)
