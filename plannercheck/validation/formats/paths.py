"""Paths of planners in files: our plans, tables, MoveIt's trajectories, and OMPL's printed paths.

In: a file, the joints of a planning group. Out: `PathFile`: configurations in the group's order, and the file's values
of joints outside the group.

JSON and YAML hold a plan as `Plan.save` writes it, a list of configurations (JSON), or a MoveIt trajectory
(trajectories.py). npy, npz and csv are tables as for sets of configurations. Anything else is text: OMPL's
`PathGeometric` as printed, or as a matrix. The motion from each state to the next is taken as straight: of a continuous
joint the short way round, as OMPL has it, but in a trajectory through the numbers as given, as a controller has it.
"""

from __future__ import annotations

import json
import os
import re
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.checking.protocols import AnyRobot
from plannercheck.common.array_types import Bools, Floats, Ints64
from plannercheck.common.arrays import OwnsArrays, shown_array, truth_in
from plannercheck.common.checked_yaml import check_keys, error_context, mapping, parse_yaml, read_bytes, sequence, text
from plannercheck.common.errors import PlannercheckError, shortened
from plannercheck.common.file_kinds import kind_of
from plannercheck.common.motion_paths import MotionPath, check_path
from plannercheck.common.package_data import why_no_file
from plannercheck.common.unique_keys import object_of
from plannercheck.robots.configurations import ConfigurationMap
from plannercheck.robots.description import RobotDescription, description_of
from plannercheck.robots.robot import Robot
from plannercheck.robots.urdf import Mimic
from plannercheck.trajectories.joint_columns import NamedJoints, moved_outside, without_followers
from plannercheck.validation.formats.chunks import read_chunks, read_states
from plannercheck.validation.formats.columns import WidthError
from plannercheck.validation.formats.given_turns import cut_at_turns, largest_turns
from plannercheck.validation.formats.trajectories import read_trajectory

_TABLES = (".npy", ".npz", ".csv")

# The fields of a plan, see `Plan`.
_PLAN_KEYS = (
    *("solved", "path", "length", "time", "simplification_time"),
    *("planner", "reason", "joint_names", "motion_path", "goal"),
)

# How OMPL begins a printed path, and the innermost brackets of its states.
_OMPL_HEADER = re.compile(r"Geometric path with (\d+) states")
_OMPL_NUMBERS = re.compile(r"State \[([^\[\]]*)\]")


@dataclass(frozen=True, eq=False)
class PathFile(OwnsArrays):
    """A path as read from a file.

    Attributes:
        states: (k, nq) configurations of the group, k at least 1; rad and m.
        others: Values by name of the joints outside the group, which stand still on the path.
        bent_by: Which of "velocities" and "accelerations" a trajectory gives that are not zero: a controller then runs
            splines, not the straight motions between the states.
        motion_path: How planar and floating joints move between the states, if the file says it.
        as_given: (k - 1,) on which motions a continuous joint turns through the numbers as given; the short way on
            others. None: on no motion, or cut already.
        pieces: (motions,) how many motions between states are one motion of the file, which has been cut since a
            continuous joint turns further than half a turn (given_turns.py). None: one each.
    """

    states: Floats
    others: dict[str, float]
    bent_by: tuple[str, ...] = ()
    motion_path: MotionPath | None = None
    as_given: Bools | None = None
    pieces: Ints64 | None = None


def read_path(
    path: str | Path, joint_names: Sequence[str], width: int, mimics: Mapping[str, Mimic] | None = None
) -> PathFile:
    """Reads a path, whose suffix and content tell the format, of configurations of `width` numbers.

    The names of the group's joints are for files that name joints, as are those of joints that follow others.

    Raises:
        PlannercheckError: If the file can't be read, lacks a joint, moves one outside the group, or has no states.
    """
    path = Path(path)
    _check_exists(path)
    with error_context(f"path file {str(path)!r}"):
        if path.suffix.lower() in _TABLES:
            blocks = [chunk.rows for chunk in read_chunks(path, joint_names, width)]
            found = PathFile(_table(blocks, width), {})
        elif path.suffix.lower() in (".json", ".yaml", ".yml"):
            found = _from_document(_document(path), NamedJoints("the group", tuple(joint_names), mimics), width)
        else:
            _check_text(path)
            found = PathFile(_from_text(read_bytes(path).decode("utf-8", "replace"), width), {})
        if not len(found.states):
            raise PlannercheckError("holds no states")
        if not np.isfinite(found.states).all():
            bad = int(np.flatnonzero(~np.isfinite(found.states).all(axis=1))[0])
            raise PlannercheckError(f"state {bad} is not finite: {found.states[bad].tolist()}")
        return found


def read_robot_path(path: str | Path, robot: AnyRobot) -> PathFile:
    """Reads a robot's path, see `read_path`; that of a robot without a group may have one number a joint."""
    fewer = robot.joint_values.maps if isinstance(robot, Robot) else ()
    if fewer and Path(path).suffix.lower() in _TABLES:
        _check_exists(Path(path))
        with error_context(f"path file {str(path)!r}"):
            states = _table([chunk.rows for chunk in read_states(path, robot)], robot.nq)
            if not len(states):
                raise PlannercheckError("holds no states")
            return PathFile(states, {})
    errors: list[WidthError] = []
    for names, width, spread in ((robot.joint_names, robot.nq, None), *((m.joint_names, m.width, m) for m in fewer)):
        try:
            found = read_path(path, names, width, robot.mimics if isinstance(robot, Robot) else None)
        except WidthError as error:
            errors.append(error)
            continue
        if spread is None and found.states.shape[1] != width and fewer:
            continue  # its joints are named, and each takes a number
        with error_context(f"path file {str(path)!r}"):
            return _turned(found, robot, spread, Path(path))
    raise errors[0]


def read_proved_path(
    path: str | Path | ArrayLike, joint_names: Sequence[str], width: int, robot: str | RobotDescription | None
) -> PathFile:
    """Reads a path that a proof may be of.

    Args:
        path: The file; with a robot also configurations (k, n), one number a joint.
        joint_names: Joint names of the proof.
        width: Numbers of its configurations.
        robot: The proof's robot, by which joints follow others and continuous joints are cosines and sines; None if it
            is not known.

    Returns:
        The path in the proof's configurations.
    """
    loaded = None if robot is None else Robot.from_description(description_of(robot))
    if not isinstance(path, str | os.PathLike):
        assert loaded is not None
        return PathFile(loaded.joint_values.configurations(path), {})
    if loaded is not None and loaded.joint_values.maps:
        return read_robot_path(Path(path), loaded)
    try:
        return read_path(Path(path), joint_names, width, None if loaded is None else loaded.mimics)
    except WidthError as error:
        hint = "" if loaded else "; if it gives one number a joint, name the robot, too (--robot, robot=)"
        raise type(error)(f"{error}{hint}") from None


def _turned(found: PathFile, robot: AnyRobot, spread: ConfigurationMap | None, path: Path) -> PathFile:
    """The path in the robot's configurations, cut where continuous joints turn further than half a turn as given."""
    states, pieces = found.states, None
    if len(states) > 1 and (spread is not None or states.shape[1] == robot.nq):
        turns = largest_turns(robot, states, spread)
        if found.as_given is not None:
            states, pieces = cut_at_turns(states, turns, found.as_given)
        elif path.suffix.lower() in _TABLES and (turns > np.pi).any():
            k = int(np.argmax(turns > np.pi))
            warnings.warn(
                f"path file {str(path)!r}: a continuous joint turns by {turns[k]:.3g} rad from state {k} to {k + 1}; a "
                "table is judged by the short way round, as OMPL runs it; a trajectory message is judged through the "
                "numbers as given, as a controller runs it",
                stacklevel=2,
            )
    states = states if spread is None else spread.expand(states)
    return replace(found, states=states, as_given=None, pieces=pieces)


def _check_exists(path: Path) -> None:
    """Raises if there is nothing at a path; pipes pass."""
    if not os.path.exists(path):  # noqa: PTH110  # Path.exists raises where one may not look
        raise PlannercheckError(f"path file {str(path)!r} {why_no_file(path)}")


def _check_text(path: Path) -> None:
    """Raises for a file that is known to be something else than OMPL's text."""
    kind = kind_of(path)
    if kind:
        raise PlannercheckError(f"is no path: {kind}")


def _document(path: Path) -> Any:
    content = read_bytes(path)
    if path.suffix.lower() != ".json":
        return parse_yaml(content)
    try:
        return json.loads(content, object_pairs_hook=object_of)
    except ValueError as error:
        raise PlannercheckError(f"is no JSON: {kind_of(path) or error}") from None
    except RecursionError:
        raise PlannercheckError("is JSON that is nested too deep") from None


def _from_document(document: Any, joints: NamedJoints, width: int) -> PathFile:
    if isinstance(document, list):
        return PathFile(_table(document, width), {})
    if not isinstance(document, dict):
        raise PlannercheckError("must hold a plan, a trajectory or a list of configurations")
    document = mapping(document, "it")
    if "path" in document:
        return replace(_of_plan(document, joints, width), motion_path=_motion_path(document))
    trajectory = read_trajectory(document)
    if trajectory is None:
        raise PlannercheckError("holds no 'path', no 'joint_trajectory' and no 'points'")
    found = _ordered(trajectory.joint_names, trajectory.positions, joints)
    held = {name: value for name, value in trajectory.held.items() if name not in joints.joint_names}
    return PathFile(found.states, {**held, **found.others}, trajectory.bent_by, None, trajectory.as_given)


def _of_plan(plan: dict[str, Any], joints: NamedJoints, width: int) -> PathFile:
    check_keys(plan, _PLAN_KEYS)
    names = [text(name, "joint_names") for name in sequence(plan.get("joint_names"), "'joint_names'")]
    rows = sequence(plan["path"], "'path'")
    if not names or (names == list(joints.joint_names) and len(names) < width):  # joints of several numbers
        return PathFile(_table(rows, width), {})
    return _ordered(names, _table(rows, len(names)), joints)


def _motion_path(plan: dict[str, Any]) -> MotionPath | None:
    if "motion_path" not in plan:
        return None
    found = cast("MotionPath", plan["motion_path"])
    check_path(found)
    return found


def _ordered(names: list[str], rows: Floats, joints: NamedJoints) -> PathFile:
    """The group's columns in its order; other joints have to follow them or to stand still."""
    joint_names = joints.joint_names
    if len(set(names)) != len(names):
        raise PlannercheckError(f"names a joint twice: {', '.join(names)}")
    missing = [joint for joint in joint_names if joint not in names]
    if missing:
        raise WidthError(f"has no joint {missing[0]!r}; it has {', '.join(map(shortened, names))}")
    kept = without_followers(names, {"positions": rows}, joints)
    others = {names[k]: rows[:, k] for k in kept if names[k] not in joint_names}
    moving = [name for name, values in others.items() if len(values) and (values != values[0]).any()]
    if moving:
        raise moved_outside(moving, joints)
    columns = [names.index(joint) for joint in joint_names]
    return PathFile(
        np.ascontiguousarray(rows[:, columns]),
        {name: float(values[0]) for name, values in others.items() if len(values)},
    )


def _from_text(content: str, width: int) -> Floats:
    header = _OMPL_HEADER.search(content)
    if header is None:
        lines = [line.split() for line in content.replace(",", " ").splitlines() if line.strip()]
        return _table(lines, width)
    values = [number for inner in _OMPL_NUMBERS.findall(content) for number in inner.split()]
    count = len(values) // width
    if len(values) != count * width or (header[1].lstrip("0") or "0") != str(count):
        told = shortened(header[1])
        raise WidthError(f"OMPL's {told} states hold {len(values)} numbers, not {width} each")
    return _table([values[k * width : (k + 1) * width] for k in range(count)], width)


def _real(value: Any) -> float:
    if isinstance(value, str) and "_" in value:  # Python reads 1_000
        raise ValueError
    return float(value)


def _table(rows: Sequence[Any], width: int) -> Floats:
    """(k, width) of rows, or of blocks of rows."""
    if truth_in(rows):
        raise PlannercheckError(f"is no table of numbers but has {shown_array(rows)}")
    try:
        table = np.array([[_real(x) for x in row] for block in rows for row in np.atleast_2d(np.asarray(block))])
    except (TypeError, ValueError, OverflowError):  # the last of whole numbers beyond all doubles
        raise PlannercheckError("is no table of numbers") from None
    if table.size and (table.ndim != 2 or table.shape[1] != width):
        raise WidthError(f"its states have {table.shape[-1]} numbers, not {width}")
    return table.reshape(-1 if width else len(table), width)
