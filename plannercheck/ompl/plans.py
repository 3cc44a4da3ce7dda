"""Plans: the results of a planner, in memory and in files.

In: a path of configurations and how it was found. Out: `Plan`, and files: JSON (the whole plan), or npy and csv (the
path alone, readable by `plannercheck validate`).
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import OwnsArrays, named_numbers
from plannercheck.common.atomic_files import write_atomically
from plannercheck.common.checked_yaml import BROKEN_FILE, error_context, read_bytes
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.escaping import csv_cell
from plannercheck.common.html_tables import html_table
from plannercheck.common.motion_paths import MotionPath, check_path
from plannercheck.common.unique_keys import object_of


@dataclass(frozen=True, eq=False, repr=False)
class Plan(OwnsArrays):
    """The result of a planner between two configurations.

    Attributes:
        solved: Whether the path leads from the start to the goal.
        path: (k, nq) configurations, joined by straight motions (on which free bodies go by slerp); (0, nq) if there is
            none. rad and m.
        length: The path's Euclidean length in joint space, rad (and m, for prismatic joints).
        time: Time of the search, s.
        simplification_time: Time of shortening the path afterwards, s.
        planner: The planner's name.
        reason: Why there is no path; empty if solved.
        joint_names: Names of the path's columns; of its joints, in their order, where some take several columns.
        goal: Which goal was reached, counted from 0 as they were given or yielded; None if there is no path.
        motion_path: How planar and floating joints move between configurations, as of `Checker.check_motion`.
    """

    solved: bool
    path: Floats
    length: float
    time: float
    simplification_time: float
    planner: str
    reason: str = ""
    joint_names: tuple[str, ...] = field(default=())
    motion_path: MotionPath = "screw"
    goal: int | None = None

    def save(self, path: str | Path) -> None:
        """Writes the plan as .json, or the path alone as .npy or .csv; the suffix chooses the format."""
        path = Path(path)
        check_suffix(path)
        write_atomically(path, lambda aside: _WRITERS[path.suffix](self, aside))

    @classmethod
    def load(cls, path: str | Path) -> Plan:
        """Reads a plan from JSON, with the same numbers."""
        with error_context(f"plan file {str(path)!r}"):
            content = read_bytes(Path(path))
        try:
            values = json.loads(content.decode("utf-8"), object_pairs_hook=object_of)
            _check_kinds(values)
            with error_context(f"plan file {str(path)!r}"):
                rows = named_numbers(values["path"], "path")
            joints = len(values["joint_names"])
            width = max(joints, rows.shape[1]) if rows.ndim == 2 else joints
            values["path"] = rows.reshape(-1, width)
            values["joint_names"] = tuple(values["joint_names"])
            check_path(values.get("motion_path", "screw"))
            return cls(**values)
        except BROKEN_FILE as error:
            raise PlannercheckError(f"file {str(path)!r} is no plan in JSON: {error!s:.200}") from None

    def __repr__(self) -> str:
        found = f"{len(self.path)} states, length {self.length:.4g}" if self.solved else f"no path: {self.reason}"
        return f"Plan({found}, {self.planner}, {self.time:.3g} s)"

    def _repr_html_(self) -> str:
        header = self.joint_names if len(self.joint_names) == self.path.shape[1] else range(self.path.shape[1])
        rows = [(k, *(f"{value:.4f}" for value in row)) for k, row in enumerate(self.path.tolist())]
        return html_table(repr(self), ("state", *map(str, header)), rows)


# What a plan's JSON has beside its numbers: types that stand for themselves, truth values for no number.
_KINDS: dict[str, tuple[type, ...]] = {
    "solved": (bool,),
    "length": (float, int),
    "time": (float, int),
    "simplification_time": (float, int),
    "planner": (str,),
    "reason": (str,),
    "goal": (int, type(None)),
}


def _check_kinds(values: dict[str, Any]) -> None:
    for key, kinds in _KINDS.items():
        if key in values and type(values[key]) not in kinds:
            wanted = " or ".join("null" if kind is type(None) else kind.__name__ for kind in kinds)
            raise ValueError(f"{key!r} must be {wanted}, not {values[key]!r:.60}")
    names = values["joint_names"]
    if type(names) is not list or not all(type(name) is str for name in names):
        raise ValueError(f"'joint_names' must be a list of texts, not {names!r:.60}")


def check_suffix(path: Path) -> None:
    """Raises unless the suffix is that of a format in which plans are written."""
    if path.suffix not in _WRITERS:
        raise unknown_name("format of a plan", path.suffix, _WRITERS)


def joint_length(path: Floats, differences: Callable[[Floats, Floats], Floats]) -> float:
    """The length of a path (k, nq): the sum of the Euclidean lengths of its steps, by joint-by-joint differences."""
    if len(path) < 2:
        return 0.0
    steps = differences(path[:-1], path[1:])
    return float(np.add.reduce(np.sqrt(np.add.reduce(steps * steps, axis=1))))  # as np.linalg.norm, with less around it


def _write_json(plan: Plan, path: Path) -> None:
    values: dict[str, Any] = {
        **asdict(plan),
        "path": plan.path.tolist(),
        "joint_names": list(plan.joint_names),
    }
    path.write_text(json.dumps(values, indent=1) + "\n", encoding="utf-8")


def _write_npy(plan: Plan, path: Path) -> None:
    with path.open("wb") as file:
        np.save(file, plan.path)


def _write_csv(plan: Plan, path: Path) -> None:
    has_names = len(plan.joint_names) == plan.path.shape[1]  # else some joints take several columns
    names = [",".join(map(csv_cell, plan.joint_names))] if has_names else []
    lines = [*names, *(",".join(map(repr, row)) for row in plan.path.tolist())]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


_WRITERS: dict[str, Callable[[Plan, Path], None]] = {
    ".json": _write_json,
    ".npy": _write_npy,
    ".csv": _write_csv,
}
