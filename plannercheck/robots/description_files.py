"""Writes robot descriptions, so that one command can use the results of another.

In: a description, the joints of its group, the pairs to leave out as text; or a cell. Out: the text of a robot's YAML.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from plannercheck.bodies.written_poses import node_of_pose
from plannercheck.common.array_types import Floats
from plannercheck.common.atomic_files import write_atomically
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.package_data import example_robot_data
from plannercheck.common.written_yaml import yaml_of
from plannercheck.robots.configurations import followed
from plannercheck.robots.description import ALL, RobotDescription, description_of
from plannercheck.robots.loading import RobotParts


def description_text(description: RobotDescription, joints: Sequence[str] | None, pairs: str, path: Path) -> str:
    """A robot's YAML.

    Args:
        description: The robot's description; the text does not name its SRDF, since pairs and joints are written out.
            The robots of a cell keep their own files, SRDFs and pairs.
        joints: The joints of the group; None for the whole robot.
        pairs: The YAML of its `disabled_pairs`.
        path: The file that will hold the text; paths become relative to its folder.

    Returns:
        The text.
    """
    folder = path.parent.resolve()  # that of the name given, by which the file is read, too
    group = description.group or "group"
    content = {
        "name": description.name or path.stem,
        **_source(description, folder),
        **_content(replace(description, srdf=None, group=None, joints=None, disabled_pairs=()), folder),
        **({} if joints is None else {"group": {"name": group, "joints": list(joints)}}),
    }
    return _text(content) + pairs


def write_cell(cell: RobotParts, path: Path) -> None:
    """Writes a cell's YAML; paths in it become relative to its folder.

    Raises:
        PlannercheckError: If a robot is from no file or carries objects, or if the file can't be written.
    """
    if path.suffix not in (".yaml", ".yml"):
        raise PlannercheckError(f"a cell is written as YAML: {path.name!r} must end in .yaml or .yml")
    if cell.carried:
        raise PlannercheckError(
            f"cell {cell.name!r} carries {cell.carried[0].name!r}, and a robot's file holds no objects: attach it in a "
            "scene (Scene.attach), and save the cell without it"
        )
    folder = path.parent.resolve()
    robots = {}
    for name, member in cell.members.items():
        if member.parts.description is None:
            raise PlannercheckError(
                f"robot {name!r} of cell {cell.name!r} was made in memory, so that no file can name it: save it, load "
                "that file, and make the cell of what was loaded"
            )
        pose = node_of_pose(member.pose)
        now = replace(
            member.parts.description,
            values=_plain(member.parts.values),
            group=member.parts.group,
            joints=member.parts.joints,
        )
        robots[name] = {**_entry(now, folder), "pose": pose or {"position": [0.0] * 3}}
    own = cell.description or RobotDescription(cell.name, path)
    known = {
        f"{name}/{joint}": value for name, each in cell.members.items() for joint, value in each.parts.values.items()
    }
    joints = {name: each.parts.joints or () for name, each in cell.members.items()}
    changed = [joint for joint, value in cell.values.items() if not np.array_equal(value, known.get(joint, []))]
    # What follows a changed joint is written as well: a follower that a file does not give moves with its leader.
    values = {
        joint: value for joint, value in cell.values.items() if followed(joint, cell.mimics, changed)[0] in changed
    }
    of_group = [f"{name}/{joint}" for name in cell.members if cell.group in (ALL, name) for joint in joints[name]]
    is_named = cell.joints == tuple(of_group)
    own = replace(own, values=_plain(values), group=cell.group, joints=None if is_named else cell.joints)
    listed = _text({"name": cell.name, "robots": robots, **_content(own, folder)})
    write_atomically(path, lambda aside: aside.write_text(listed, encoding="utf-8"))


def _entry(description: RobotDescription, folder: Path) -> dict[str, Any]:
    """A robot of a cell: its file, and what differs from what that says."""
    file = description.source or description.urdf
    content, known = _content(description, folder), _content(description_of(file), folder)
    differing = {key: value for key, value in content.items() if known.get(key) != value and key != "disabled_pairs"}
    return {"load": file.stem if description.is_shipped else os.path.relpath(file.resolve(), folder), **differing}


def _source(description: RobotDescription, folder: Path) -> dict[str, Any]:
    """Where a robot is read from: its URDF, or a cell's robots."""
    if not description.robots:
        return {"urdf": _named(description.urdf, folder)}
    robots = {}
    for name, placed in description.robots.items():
        pose = {} if placed.pose is None else {"pose": node_of_pose(placed.pose) or {"position": [0.0] * 3}}
        robots[name] = {**_entry(placed.description, folder), **pose}
    return {"robots": robots}


def _plain(values: Mapping[str, Floats]) -> dict[str, Any]:
    """Values of joints as YAML has them."""
    return {joint: value.tolist() if len(value) > 1 else float(value[0]) for joint, value in values.items()}


def _content(description: RobotDescription, folder: Path) -> dict[str, Any]:
    """All keys but those of where the robot is read from."""
    content: dict[str, Any] = {}
    if description.srdf is not None:
        content["srdf"] = _named(description.srdf, folder)
    folders = [each for each in description.package_dirs if each.resolve() != example_robot_data()]
    if folders:
        content["package_dirs"] = [_named(each, folder) for each in folders]
    if description.xacro_args:
        content["xacro_args"] = dict(description.xacro_args)
    if description.floating:
        content["floating"] = True
    if description.joints is not None:
        content["group"] = {"name": description.group or "group", "joints": list(description.joints)}
    elif description.group is not None:
        content["group"] = description.group
    if description.values:
        content["reference"] = dict(description.values)
    if description.geometry is not None:
        given = description.geometry
        content["geometry"] = given if isinstance(given, str) else dict(given)
    if description.mesh_units is not None:
        content["mesh_units"] = description.mesh_units
    if description.decomposition is not None:
        options = {key: value for key, value in vars(description.decomposition).items() if value is not None}
        content["convex_decomposition"] = {
            key: list(value) if isinstance(value, tuple) else value for key, value in options.items()
        }
    if description.disabled_pairs:
        content["disabled_pairs"] = [
            {"reason": pair.reason, "pairs": [[pair.link_a, pair.link_b]]} for pair in description.disabled_pairs
        ]
    return content


def _text(content: Mapping[str, Any]) -> str:
    """YAML whose innermost lists are one line each, and whose keys are one below the other."""
    flow = None if any(isinstance(value, dict | list) for value in content.values()) else False
    return yaml_of(dict(content), flow)


def _named(path: Path, folder: Path) -> str:
    """A path relative to a folder; a file of example-robot-data as shipped robots name it."""
    whole, shared = path.resolve(), example_robot_data()
    return str(whole.relative_to(shared)) if whole.is_relative_to(shared) else os.path.relpath(whole, folder)
