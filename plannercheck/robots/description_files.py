"""Writes robot descriptions, so that one command can use the results of another.

In: a description, the joints of its group, the pairs to leave out as text. Out: the text of a robot's YAML.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml

from plannercheck.common.package_data import example_robot_data
from plannercheck.robots.description import RobotDescription


def description_text(description: RobotDescription, joints: Sequence[str] | None, pairs: str, path: Path) -> str:
    """A robot's YAML.

    Args:
        description: The robot's description; the text does not name its SRDF, since pairs and joints are written out.
        joints: The joints of the group; None for the whole robot.
        pairs: The YAML of its `disabled_pairs`.
        path: The file that will hold the text; paths become relative to its folder.

    Returns:
        The text.
    """
    folder = path.parent.resolve()  # that of the name given, by which the file is read, too
    content: dict[str, Any] = {
        "name": description.name or path.stem,
        "urdf": _named(description.urdf, folder),
    }
    folders = [each for each in description.package_dirs if each.resolve() != example_robot_data()]
    if folders:
        content["package_dirs"] = [_named(each, folder) for each in folders]
    if description.xacro_args:
        content["xacro_args"] = dict(description.xacro_args)
    if description.floating:
        content["floating"] = True
    if joints is not None:
        content["group"] = {"name": description.group or "group", "joints": list(joints)}
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
    text: str = yaml.safe_dump(content, sort_keys=False, default_flow_style=False, width=110, allow_unicode=True)
    return text + pairs


def _named(path: Path, folder: Path) -> str:
    """A path relative to a folder; a file of example-robot-data as shipped robots name it."""
    whole, shared = path.resolve(), example_robot_data()
    return str(whole.relative_to(shared)) if whole.is_relative_to(shared) else os.path.relpath(whole, folder)
