"""Several robots as one: a cell, in which each robot stands at its own pose.

In: robots by name, each with the pose of its base. Out: the parts of one `Robot`, whose joints, links, bodies and held
values are those of the robots, named "left/panda_joint1"; and `CellPart`, which says which columns of a configuration
are whose. Every robot keeps its own pairs, and each body is tested against all bodies of the other robots, unless both
are fixed to the world or an SRDF leaves a link out by default.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from plannercheck.bodies.objects import SceneObject
from plannercheck.bodies.shapes import GeometryObject, checked_pose
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.bodies.sizes import array_of
from plannercheck.common.arrays import read_only
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.robots.joint_values import own_joints
from plannercheck.robots.loading import RobotParts
from plannercheck.robots.srdf import DisabledPair
from plannercheck.robots.urdf import Mimic, link_tree

if TYPE_CHECKING:
    from plannercheck.robots.robot import Robot

# A robot of a cell, at the origin, or with the pose (4, 4) of its base in m.
Placed: TypeAlias = "Robot | tuple[Robot, ArrayLike | None]"


@dataclass(frozen=True, eq=False)
class Member:
    """A robot of a cell.

    Attributes:
        robot: The robot alone. With a group if the cell has one.
        pose: (4, 4) of its base in the world, m; read-only.
    """

    robot: Robot
    pose: Floats


@dataclass(frozen=True, eq=False)
class CellPart:
    """A robot of a cell, and its columns.

    Attributes:
        name: Its name in the cell.
        robot: The robot alone, whose configurations are the columns; its base is at the origin.
        pose: (4, 4) of its base in the cell, m; read-only.
        joint_names: Its joints in the cell's group, as the cell names them.
        columns: (k,) their columns in a configuration of the cell.
    """

    name: str
    robot: Robot
    pose: Floats
    joint_names: tuple[str, ...]
    columns: Ints64


def members_of(robots: Mapping[str, Placed]) -> dict[str, Member]:
    """The robots of a cell by name, checked: two or more robots, names without a slash, rigid poses.

    If one robot has a planning group, all others get one of all their joints, since the columns of a cell are those of
    one kind of configuration.
    """
    from plannercheck.robots.robot import Robot

    if not isinstance(robots, Mapping) or not robots:
        raise PlannercheckError("Robot.together takes robots by name, e.g. {'left': robot, 'right': (robot, pose)}")
    members = {}
    for name, given in robots.items():
        if not isinstance(name, str) or not name or "/" in name or name == "all":
            raise PlannercheckError(f"a robot's name in a cell is a text without '/', and not 'all': {name!r}")
        robot, pose = given if isinstance(given, tuple) and len(given) == 2 else (given, None)
        if not isinstance(robot, Robot):
            raise PlannercheckError(f"robot {name!r} of a cell must be a Robot or (Robot, pose), not {given!r:.80}")
        members[name] = Member(robot, checked_pose(pose, f"robot {name!r}"))
    if any(each.robot.group is not None for each in members.values()):
        members = {name: replace(each, robot=_with_group(each.robot)) for name, each in members.items()}
    return members


def cell_parts(members: Mapping[str, Member]) -> RobotParts:
    """The parts of the robot that all members are together."""
    model = pin.Model()
    model.name = "+".join(each.robot.name for each in members.values())
    for name, member in members.items():
        append(model, member.robot.model, partial("{}/{}".format, name), pin.SE3(member.pose))
    each_parts = {name: member.robot.parts_of_files for name, member in members.items()}
    bodies = tuple(
        replace(body, name=f"{name}/{body.name}", link=f"{name}/{body.link}")
        for name, parts in each_parts.items()
        for body in parts.bodies
    )
    groups = [parts.joints for parts in each_parts.values()]
    listed = [f"{name}/{joint}" for name, parts in each_parts.items() for joint in parts.joints or ()]
    default_links = _named(each_parts, lambda parts: parts.default_links)
    return RobotParts(
        name=model.name,
        model=model,
        tree=link_tree(model),
        bodies=bodies,
        pairs=_pairs(model, bodies, each_parts, default_links),
        disabled_pairs=tuple(
            DisabledPair(f"{name}/{pair.link_a}", f"{name}/{pair.link_b}", pair.reason)
            for name, parts in each_parts.items()
            for pair in parts.disabled_pairs
        ),
        mimics={
            f"{name}/{joint}": Mimic(f"{name}/{mimic.leader}", mimic.multiplier, mimic.offset)
            for name, parts in each_parts.items()
            for joint, mimic in parts.mimics.items()
        },
        values={f"{name}/{joint}": v for name, parts in each_parts.items() for joint, v in parts.values.items()},
        group=None if groups[0] is None else "all",
        joints=None if groups[0] is None else tuple(listed),
        carried=tuple(_carried(item, name) for name, parts in each_parts.items() for item in parts.carried),
        pieces={f"{name}/{body}": each for name, parts in each_parts.items() for body, each in parts.pieces.items()},
        open_links=_named(each_parts, lambda parts: parts.open_links),
        default_links=default_links,
        members=members,
    )


def parts_by_name(members: Mapping[str, Member], names: tuple[str, ...], starts: tuple[int, ...], width: int) -> dict[str, CellPart]:
    """What each member is in a cell whose group has joints of these names, at these first columns."""
    ends = (*starts[1:], width)
    found = {}
    for name, member in members.items():
        own = [k for k, joint in enumerate(names) if joint.startswith(f"{name}/")]
        columns = [np.arange(starts[k], ends[k]) for k in own]
        listed = read_only(np.concatenate([np.zeros(0, dtype=np.int64), *columns]))
        found[name] = CellPart(name, member.robot, member.pose, tuple(names[k] for k in own), listed)
    return found


def joined(parts: Mapping[str, CellPart], configurations: Mapping[str, ArrayLike], width: int) -> Floats:
    """Configurations (width,) or (n, width) of a cell from those of its robots, (k,) or (n, k), by name."""
    moving = [name for name, part in parts.items() if len(part.columns)]
    if not moving:
        raise PlannercheckError("join and split are of a cell, see Robot.together; this is a single robot")
    for name in configurations:
        if name not in moving:
            raise unknown_name("robot of the cell's group", name, moving)
    missing = [name for name in moving if name not in configurations]
    if missing:
        raise PlannercheckError(f"join needs a configuration of each robot of the group; missing: {', '.join(missing)}")
    given = {name: _rows(parts[name], configurations[name]) for name in moving}
    counts = {len(rows) for rows in given.values() if rows.ndim == 2}
    if len(counts) > 1:
        raise PlannercheckError(f"join takes as many configurations of each robot, not {sorted(counts)}")
    q = np.empty((*counts, width))
    for name, rows in given.items():
        q[..., parts[name].columns] = rows
    return q


def _rows(part: CellPart, q: ArrayLike) -> Floats:
    """Numbers (k,) or (n, k) of a part; of a robot without a group also one for each joint."""
    what = f"configuration of robot {part.name!r}"
    rows = array_of(q, what)
    if rows.ndim in (1, 2) and len(part.columns) == part.robot.nq:
        converted = part.robot.joint_values.configurations(rows)
        return converted[0] if rows.ndim == 1 else converted
    if rows.ndim not in (1, 2) or rows.shape[-1] != len(part.columns):
        raise PlannercheckError(f"{what} must have shape ({len(part.columns)},) or (n, {len(part.columns)}), not {rows.shape}")
    return rows


def _with_group(robot: Robot) -> Robot:
    if robot.group is not None:
        return robot
    return robot.with_group(own_joints(robot.model, robot.mimics), "all")


def append(model: pin.Model, part: pin.Model, named: Callable[[str], str], pose: pin.SE3) -> None:
    """Appends a robot's joints and frames to a model, in their order and renamed, with the robot's base at a pose."""
    shift, frames = model.njoints - 1, {0: 0}
    for k in range(1, part.njoints):
        parent, joint = int(part.parents[k]), part.joints[k]
        q, v = slice(joint.idx_q, joint.idx_q + joint.nq), slice(joint.idx_v, joint.idx_v + joint.nv)
        model.addJoint(
            parent + shift if parent else 0,
            joint,
            part.jointPlacements[k] if parent else pose * part.jointPlacements[k],
            named(part.names[k]),
            part.effortLimit[v],
            part.velocityLimit[v],
            part.lowerPositionLimit[q],
            part.upperPositionLimit[q],
        )
    for k, frame in enumerate(part.frames):
        if k == 0:
            continue
        joint = int(frame.parentJoint)
        placement = frame.placement if joint else pose * frame.placement
        copied = pin.Frame(named(frame.name), joint + shift if joint else 0, frames[frame.parentFrame], placement, frame.type)
        frames[k] = model.addFrame(copied)


def _pairs(
    model: pin.Model, bodies: tuple[GeometryObject, ...], each: Mapping[str, RobotParts], left_out: tuple[str, ...]
) -> Ints64:
    """(k, 2) pairs that are tested: each robot's own, and all between two robots, in the order of the bodies."""
    counts = [len(parts.bodies) for parts in each.values()]
    firsts = np.cumsum([0, *counts[:-1]])
    own = [parts.pairs + first for parts, first in zip(each.values(), firsts.tolist(), strict=True)]
    owner = np.repeat(np.arange(len(counts)), counts)
    fixed = np.array([model.frames[model.getBodyId(str(body.link))].parentJoint == 0 for body in bodies], dtype=bool)
    idle = np.array([body.link in left_out for body in bodies], dtype=bool)
    a, b = np.triu_indices(len(bodies), 1)
    between = (owner[a] != owner[b]) & ~(fixed[a] & fixed[b]) & ~(idle[a] | idle[b])
    pairs = np.concatenate([*own, np.stack([a[between], b[between]], axis=1)])
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def _named(each: Mapping[str, RobotParts], names: Any) -> tuple[str, ...]:
    return tuple(f"{name}/{link}" for name, parts in each.items() for link in names(parts))


def _carried(item: SceneObject, name: str) -> SceneObject:
    """A carried object as the cell names it."""
    touched = tuple(f"{name}/{each}" for each in item.touch_links)
    return replace(item, name=f"{name}/{item.name}", link=f"{name}/{item.link}", touch_links=touched)
