"""The robot of a command: --robot, and the options for a URDF without a YAML.

In: parsed options. Out: a robot's description, or the robot. Options take precedence over a YAML.
"""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any, get_args

from plannercheck.bodies.mesh_files import MeshUnits
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.package_data import is_folder
from plannercheck.planar.robot_files import is_planar
from plannercheck.robots.description import ALL, RobotDescription, description_of
from plannercheck.robots.robot import Robot
from plannercheck.robots.srdf import group_names

# What --robot takes.
ROBOT_HELP = (
    "a shipped robot's name, a file (a robot's or a cell's YAML, a URDF, a .xacro, an MJCF .xml) or a name of the "
    "robot_descriptions package"
)


def add_urdf_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds what says of a URDF what a robot's YAML would."""
    group = parser.add_argument_group("robots without a YAML")
    group.add_argument("--srdf", type=Path, metavar="FILE", help="for self pairs, groups and states; acm writes one")
    group.add_argument("--group", metavar="NAME", help="planning group of the SRDF, or joints: joint1,joint2,...")
    group.add_argument(
        "--package-dirs",
        action="append",
        type=Path,
        metavar="FOLDER",
        help="where package:// addresses of robot and scene start; may be given several times",
    )
    group.add_argument(
        "--xacro-arg",
        action="append",
        metavar="NAME:=VALUE",
        help="an argument of a robot that is a .xacro; may be given several times",
    )
    group.add_argument("--floating", action="store_true", help="the root link is free to move")
    parser.add_argument(
        "--geometry",
        metavar="KIND",
        help="what meshes of links are: hull (default), pieces, solid, or triangles, which leaves open meshes open; "
        "or by link: LINK=solid,LINK=pieces",
    )
    parser.add_argument(
        "--mesh-units",
        choices=get_args(MeshUnits),
        help="how mesh files of robot and scene are read: metre takes their numbers as MoveIt does, file converts them "
        "as their format says; default: metre for robots, file for scenes",
    )


def given_options(options: argparse.Namespace) -> list[str]:
    """Which of these options are given."""
    names = ("srdf", "group", "package_dirs", "xacro_arg", "floating", "geometry", "mesh_units")
    return [f"--{name.replace('_', '-')}" for name in names if getattr(options, name, None)]


def described(options: argparse.Namespace) -> RobotDescription:
    """What the files and options say about the robot."""
    given = given_options(options)
    if given and is_planar(options.robot, "robots"):
        raise PlannercheckError(f"{' and '.join(given)}: planar robots have no URDF")
    description = description_of(options.robot)
    changes: dict[str, Any] = {}
    if options.srdf is not None:
        changes["srdf"] = options.srdf
    if options.floating:
        changes["floating"] = True
    missing = [folder for folder in options.package_dirs or () if not is_folder(folder)]
    if missing:
        raise PlannercheckError(f"--package-dirs: there is no folder {str(missing[0])!r}")
    if options.package_dirs:
        changes["package_dirs"] = (*options.package_dirs, *description.package_dirs)
    if options.xacro_arg:
        changes["xacro_args"] = {**description.xacro_args, **dict(map(_argument, options.xacro_arg))}
    if getattr(options, "geometry", None):
        changes["geometry"] = _geometry(options.geometry)
    if getattr(options, "mesh_units", None):
        changes["mesh_units"] = options.mesh_units
    description = dataclasses.replace(description, **changes) if changes else description
    if not options.group:
        return description
    return dataclasses.replace(description, held=(), **_group(options.group, description))  # the group may move these


def _geometry(text: str) -> str | dict[str, str]:
    """A kind, or kinds by links as LINK=KIND,LINK=KIND."""
    if "=" not in text:
        return text
    return {link.strip(): kind.strip() for link, _, kind in (part.rpartition("=") for part in text.split(","))}


def _argument(text: str) -> tuple[str, str]:
    name, sign, value = text.partition(":=")
    if not sign or not name:
        raise PlannercheckError(f"--xacro-arg must be NAME:=VALUE, not {text!r}")
    return name, value


def _group(text: str, description: RobotDescription) -> Mapping[str, Any]:
    """The SRDF's group of that name, or a robot of a cell, else these joints."""
    if description.semantics is not None and text in group_names(description.semantics.root):
        return {"group": text, "joints": None}
    if text in description.robots or (description.robots and text == ALL):
        return {"group": text, "joints": None}
    joints = tuple(name.strip() for name in text.split(",") if name.strip())
    if len(joints) == 1 and description.semantics is not None and "," not in text and not _is_joint(text, description):
        return {"group": text, "joints": None}  # the error lists the SRDF's groups
    return {"group": "group", "joints": joints}


def _is_joint(name: str, description: RobotDescription) -> bool:
    """Whether the URDF has a joint of that name."""
    return not description.robots and any(
        joint.get("name") == name for joint in description.file.root.iterfind("joint")
    )


def robot_of(options: argparse.Namespace) -> Robot:
    """The robot."""
    return Robot.from_description(described(options)) if given_options(options) else Robot.load(options.robot)
