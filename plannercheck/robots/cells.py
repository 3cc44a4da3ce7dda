"""Several robots as one: a cell, in which each robot stands at its own pose.

In: the parts of robots by name, each with the pose of its base. Out: the parts of one `Robot`, whose joints, links,
bodies and held values are those of the robots, named "left/panda_joint1". Every robot keeps its own pairs, and each
body is tested against all bodies of the other robots, unless both are fixed to the world or an SRDF leaves a link out
by default.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import TypeAlias

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from plannercheck.bodies.objects import SceneObject
from plannercheck.bodies.shapes import GeometryObject, checked_pose
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.arrays import read_only
from plannercheck.common.checked_yaml import error_context
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.robots.description import ALL, RobotDescription
from plannercheck.robots.joint_values import own_joints
from plannercheck.robots.loading import Member, RobotParts, check_held, group_of
from plannercheck.robots.planning_groups import explicit_group
from plannercheck.robots.posed_robot import PosedRobot
from plannercheck.robots.reference_configuration import given_values, with_given
from plannercheck.robots.self_pairs import without_links
from plannercheck.robots.srdf import DisabledPair, default_links, warn_about_ignored_elements
from plannercheck.robots.urdf import Mimic, link_tree

# A robot of a cell, at the origin, or with the pose (4, 4) of its base in m.
Placed: TypeAlias = PosedRobot | tuple[PosedRobot, ArrayLike | None]


def members_of(robots: Mapping[str, Placed]) -> dict[str, Member]:
    """The robots of a cell by name, checked.

    If one robot has a planning group, all others get one of all their joints, since a configuration of the cell has
    one kind of columns: one a joint, or Pinocchio's.

    Raises:
        PlannercheckError: For a faulty name, something that is no robot, a pose that is not rigid, or several robots
            without a pose.
    """
    if not isinstance(robots, Mapping) or not robots:
        raise PlannercheckError("Robot.together takes robots by name: {'left': robot, 'right': (robot, pose)}")
    members, at_origin = {}, []
    for name, given in robots.items():
        check_name(name)
        robot, pose = given if isinstance(given, tuple) and len(given) == 2 else (given, None)
        if not isinstance(robot, PosedRobot):
            raise PlannercheckError(f"robot {name!r} of a cell must be a Robot or (Robot, pose), not {given!r:.80}")
        members[name] = Member(robot.parts_of_files(), checked_pose(pose, f"robot {name!r}"))
        at_origin += [name] if pose is None else []
    check_places(at_origin)
    return _alike(members)


def described_cell(description: RobotDescription, load: Callable[[RobotDescription], RobotParts]) -> RobotParts:
    """The parts of a cell that a file describes; equal robots are read once."""
    _check_of_cell(description)
    known: list[tuple[RobotDescription, RobotParts]] = []
    members, at_origin = {}, []
    for name, placed in description.robots.items():
        check_name(name)
        own = description.of_robot(name)
        parts = next((parts for other, parts in known if other == own), None)
        if parts is None:
            with error_context(f"robot {name!r}"):
                parts = load(own)
            known.append((own, parts))
        members[name] = Member(parts, checked_pose(placed.pose, f"robot {name!r}"))
        at_origin += [name] if placed.pose is None else []
    check_places(at_origin)
    return _as_described(cell_parts(_alike(members), description.name), description)


def _check_of_cell(description: RobotDescription) -> None:
    """Raises for what can only be said of one robot, and for links of no robot of the cell."""
    given = {"floating": description.floating, "xacro_args": description.xacro_args}
    for key in (key for key, value in given.items() if value):
        raise PlannercheckError(f"{key} is said of one robot, not of a cell: give it to a robot in the cell's file")
    links = () if isinstance(description.geometry, str) else tuple(description.geometry or ())
    for link in (*links, *(description.decomposition.links or () if description.decomposition else ())):
        if link.partition("/")[0] not in description.robots or "/" not in link:
            raise unknown_name(
                "robot of the cell before the link's name", link, [f"{name}/..." for name in description.robots]
            )


def _as_described(cell: RobotParts, description: RobotDescription) -> RobotParts:
    """A cell with the group, the held values and the disabled pairs of its file."""
    srdf = description.semantics
    if srdf is not None:
        warn_about_ignored_elements(srdf, cell.tree)
    disabled = description.disabled_pairs
    group, joints = _described_group(cell, description)
    values = given_values(cell.model, description.values)
    check_held(description, joints)
    return replace(
        cell,
        description=description,
        values=with_given(cell.values, values, cell.mimics),
        pairs=without_links(cell.pairs, cell.bodies, srdf, cell.tree, disabled),
        disabled_pairs=(*cell.disabled_pairs, *disabled),
        default_links=(*cell.default_links, *(() if srdf is None else default_links(srdf.root))),
        group=group,
        joints=joints,
    )


def _described_group(cell: RobotParts, description: RobotDescription) -> tuple[str | None, tuple[str, ...] | None]:
    """Name and joints of the group that a cell's file asks for: all joints, a robot's, or as for one robot."""
    group = description.group
    if group is None:
        return cell.group, cell.joints
    if description.joints is not None or group not in (ALL, *cell.members):
        return group, group_of(description, cell.model, cell.tree, cell.mimics)
    every = cell.joints or own_joints(cell.model, cell.mimics)
    own = tuple(joint for joint in every if group == ALL or joint.startswith(f"{group}/"))
    return group, explicit_group(cell.model, own, cell.mimics)


def check_name(name: object) -> None:
    """Raises unless this may be the name of a robot in a cell."""
    if not isinstance(name, str) or not name.isprintable() or not name or set(name) & set("/, ") or name == ALL:
        raise PlannercheckError(
            f"a robot's name in a cell is a text without slashes, commas and blanks, and not {ALL!r}: {name!r:.80}"
        )


def check_places(at_origin: list[str]) -> None:
    """Raises if several robots of a cell, by name, have no pose."""
    if len(at_origin) > 1:
        raise PlannercheckError(
            f"robots {', '.join(map(repr, at_origin))} of a cell have no pose: give the pose of each base in the "
            "world, of all robots but one, which then stands at the origin"
        )


def cell_parts(members: Mapping[str, Member], name: str = "") -> RobotParts:
    """The parts of the robot that all members are together, called by a name, or after all of them."""
    model = pin.Model()
    model.name = name or "+".join(each.parts.name for each in members.values())
    for key, member in members.items():
        append(model, member.parts.model, partial("{}/{}".format, key), pin.SE3(member.pose))
    each_parts = {name: member.parts for name, member in members.items()}
    bodies = tuple(
        replace(body, name=f"{name}/{body.name}", link=f"{name}/{body.link}")
        for name, parts in each_parts.items()
        for body in parts.bodies
    )
    listed = tuple(f"{name}/{joint}" for name, parts in each_parts.items() for joint in parts.joints or ())
    idle = _named(each_parts, lambda parts: parts.default_links)
    return RobotParts(
        name=model.name,
        model=model,
        tree=link_tree(model),
        bodies=bodies,
        pairs=_pairs(model, bodies, each_parts, idle),
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
        group=ALL if listed else None,
        joints=listed or None,
        carried=tuple(_carried(item, name) for name, parts in each_parts.items() for item in parts.carried),
        pieces={f"{name}/{body}": each for name, parts in each_parts.items() for body, each in parts.pieces.items()},
        open_links=_named(each_parts, lambda parts: parts.open_links),
        default_links=idle,
        members=members,
    )


def member_parts(cell: RobotParts, name: str, joints: tuple[str, ...]) -> RobotParts:
    """A robot of a cell alone, with the cell's held values and, of the cell's group, its joints.

    Joints are the robot's in the cell's group, as the cell names them; with none, it keeps its own group.
    """
    parts, first = cell.members[name].parts, len(name) + 1
    values = {joint[first:]: value for joint, value in cell.values.items() if joint.startswith(f"{name}/")}
    own = tuple(joint[first:] for joint in joints)
    if cell.joints is None or not own or own == parts.joints:
        return replace(parts, values=values)
    return replace(parts, values=values, group=cell.group, joints=own)


def columns_by_name(
    members: Mapping[str, Member], joints: tuple[str, ...], starts: tuple[int, ...], width: int
) -> dict[str, tuple[tuple[str, ...], Ints64]]:
    """For each robot of a cell its joints in the cell's group, and their columns (k,) in a configuration.

    `starts` has the first column of each joint, `width` is how many columns there are.
    """
    ends, found = (*starts[1:], width), {}
    for name in members:
        own = [k for k, joint in enumerate(joints) if joint.startswith(f"{name}/")]
        columns = [np.arange(starts[k], ends[k]) for k in own]
        listed = read_only(np.concatenate([np.zeros(0, dtype=np.int64), *columns]))
        found[name] = tuple(joints[k] for k in own), listed
    return found


def check_is_cell(members: Mapping[str, Member]) -> None:
    """Raises unless a robot is made of several by name."""
    if not members:
        raise PlannercheckError("this is a single robot, and join, split and save are of a cell: see Robot.together")


def check_joined(names: Mapping[str, object], moving: list[str]) -> None:
    """Raises unless exactly the robots that a cell's group moves are given."""
    if not isinstance(names, Mapping):
        raise PlannercheckError(f"join takes configurations by robot, {{'left': q, …}}, not {names!r:.80}")
    for name in names:
        if name not in moving:
            raise unknown_name("robot of the cell's group", name, moving)
    missing = [name for name in moving if name not in names]
    if missing:
        raise PlannercheckError(f"join needs a configuration of each robot of the group; missing: {', '.join(missing)}")


def joined(rows: Mapping[str, Floats], columns: Mapping[str, Ints64], width: int) -> Floats:
    """Configurations (width,) or (n, width) of a cell from those of its robots, (k,) or (n, k), by name."""
    counts = {len(each) for each in rows.values() if each.ndim == 2}
    if len(counts) > 1:
        raise PlannercheckError(f"join takes as many configurations of each robot, not {sorted(counts)}")
    q = np.empty((*counts, width))
    for name, each in rows.items():
        q[..., columns[name]] = each
    return q


def _alike(members: dict[str, Member]) -> dict[str, Member]:
    """The robots, all with a group if one of them has one."""
    if all(each.parts.joints is None for each in members.values()):
        return members
    return {name: replace(each, parts=_with_group(each.parts)) for name, each in members.items()}


def _with_group(parts: RobotParts) -> RobotParts:
    """A robot with a group: its own, or one of all joints that follow no other; none if no joint moves."""
    joints = own_joints(parts.model, parts.mimics)
    return replace(parts, group=ALL, joints=joints) if parts.joints is None and joints else parts


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
        above = joint + shift if joint else 0
        copied = pin.Frame(named(frame.name), above, frames[frame.parentFrame], placement, frame.type)
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


def _named(each: Mapping[str, RobotParts], names: Callable[[RobotParts], tuple[str, ...]]) -> tuple[str, ...]:
    return tuple(f"{name}/{link}" for name, parts in each.items() for link in names(parts))


def _carried(item: SceneObject, name: str) -> SceneObject:
    touched = tuple(f"{name}/{each}" for each in item.touch_links)
    return replace(item, name=f"{name}/{item.name}", link=f"{name}/{item.link}", touch_links=touched)
