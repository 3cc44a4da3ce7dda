"""Shared code of commands: robot and scene options, vectors, and output.

In: parsed options. Out: robots, scenes, checkers.
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar, get_args

import numpy as np

from plannercheck import planar
from plannercheck.checking.padding import Padding
from plannercheck.checking.protocols import AnyChecker, AnyRobot, AnyScene
from plannercheck.cli.robot_options import ROBOT_HELP, add_urdf_arguments, given_options, robot_of
from plannercheck.common.array_types import Floats
from plannercheck.common.atomic_files import write_atomically
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.package_data import is_folder
from plannercheck.motions.checker import Checker
from plannercheck.planar.robot_files import is_planar
from plannercheck.robots.joint_values import own_joints as joints_of_their_own
from plannercheck.robots.robot import Robot
from plannercheck.scenes.scene import Scene
from plannercheck.scenes.scene_paths import MeshKind

T = TypeVar("T")


def add_robot_argument(parser: argparse.ArgumentParser) -> None:
    """Adds --robot and what belongs to it."""
    parser.add_argument(
        "--robot",
        required=True,
        help=f"{ROBOT_HELP}; `plannercheck robots` lists the shipped ones",
    )
    add_urdf_arguments(parser)


def add_scene_argument(parser: argparse.ArgumentParser, note: str = "default: empty") -> None:
    """Adds --scene."""
    parser.add_argument("--scene", help=f"name of a shipped scene, or a scene file, MoveIt's as well; {note}")
    parser.add_argument(
        "--scene-meshes",
        choices=get_args(MeshKind),
        default="hull",
        help="what meshes of the scene are; open ones are closed by caps (solid) or not (triangles); default: hull",
    )


def add_checker_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds --robot, --scene and what the checker is told."""
    add_robot_argument(parser)
    add_scene_argument(parser)
    add_settings(parser)


def add_settings(parser: argparse.ArgumentParser) -> None:
    """Adds what the checker is told besides robot and scene."""
    parser.add_argument("--no-self-collision", action="store_true", help="test only against the scene")
    parser.add_argument(
        "--padding",
        default="0",
        metavar="M",
        help="distance that all pairs have to keep, m, or 'scene' for the link_padding of a MoveIt scene; default: 0",
    )


def load_checker(options: argparse.Namespace, own_joints: bool = False) -> AnyChecker:
    """The checker of --robot in --scene, in space or, if the robot's file says so, in the plane.

    With `own_joints`, a robot without a group gets one of all joints that move on their own, as planning needs it.
    """
    if is_planar(options.robot, "robots"):
        return planar_checker(options)
    if options.scene is not None and is_planar(options.scene, "configs"):
        raise PlannercheckError(f"scene {options.scene!r} is planar, robot {options.robot!r} is not")
    return space_checker(options, own_joints)


def planar_checker(options: argparse.Namespace) -> planar.Checker:
    """The checker of a planar --robot in --scene."""
    if options.padding != "0":
        raise PlannercheckError("--padding is for robots in space")
    if given_options(options):
        raise PlannercheckError(f"{' and '.join(given_options(options))}: planar robots have no URDF")
    scene = planar.Scene("empty") if options.scene is None else planar.Scene.load(options.scene)
    return planar.Checker(planar.Robot.load(options.robot), scene, self_collision=not options.no_self_collision)


def space_checker(options: argparse.Namespace, own_joints: bool = False) -> Checker:
    """The checker of --robot in --scene in space; arguments as of `load_checker`."""
    robot = robot_of(options)
    if own_joints and robot.group is None and robot.nq:
        robot = robot.with_group(joints_of_their_own(robot.model, robot.mimics), "all joints")
    scene = scene_of(options)
    return Checker(robot, scene, self_collision=not options.no_self_collision, padding=padding_of(options, scene))


def check_at_rest(scene: AnyScene, where: str) -> None:
    """Raises if something in a scene moves; `where` says in words what is judged there."""
    names = [item.name for item in getattr(scene, "moving", ())]
    if names:
        raise PlannercheckError(
            f"{', '.join(map(repr, names))} of scene {scene.name!r} {'moves' if len(names) == 1 else 'move'}, and"
            f" {where} without a time: validate --path --controller --start-time judges trajectories there, and"
            " validate --time configurations, without --certify and --reference"
        )


def scene_of(options: argparse.Namespace) -> Scene:
    """What --scene says, in space."""
    if options.scene is None:
        return Scene("empty")
    meshes: MeshKind = options.scene_meshes
    units = getattr(options, "mesh_units", None)
    return Scene.load(options.scene, options.package_dirs or (), meshes=meshes, mesh_units=units)


def padding_of(options: argparse.Namespace, scene: Scene) -> Padding:
    """What --padding says."""
    if options.padding == "scene":
        return scene.link_padding
    try:
        return float(options.padding)
    except ValueError:
        raise PlannercheckError(f"--padding must be a length in m or 'scene', not {options.padding!r}") from None


def vector(text: str, name: str) -> Floats:
    """Numbers separated by commas or spaces."""
    try:
        return np.array([float(part) for part in text.replace(",", " ").split()])
    except ValueError:
        raise PlannercheckError(f"{name} must be numbers separated by commas, not {text!r}") from None


def limits_of(text: str, name: str) -> Floats | Path:
    """Limits of joints: numbers, or the path of a joint_limits.yaml."""
    path = Path(text)
    return path if path.suffix in (".yaml", ".yml") else numbers_of(text, name)


def numbers_of(text: str, name: str) -> Floats:
    """(nq,) numbers, or () one."""
    numbers = vector(text, name)
    return numbers[0] if len(numbers) == 1 else numbers


def joint_vector(text: str, name: str, robot: AnyRobot) -> Floats:
    """One configuration; of a robot without a group, one number for each joint will do."""
    values = vector(text, name)
    maps = robot.joint_values.maps if isinstance(robot, Robot) else ()
    fits = any(each.width == len(values) for each in maps)
    return robot.joint_values.configurations(values)[0] if fits and isinstance(robot, Robot) else values


def check_folder(path: Path | None) -> None:
    """Says before long work that an output file can't be written for want of its folder."""
    if path is None:
        return
    folder = Path(os.path.realpath(path) if path.is_symlink() else path).parent
    if not is_folder(folder):
        raise PlannercheckError(f"file {str(path)!r} can't be written: there is no folder {str(folder)!r}")


def save_json(path: Path, value: Any) -> None:
    """Writes a value as JSON."""
    write_atomically(path, lambda aside: aside.write_text(json.dumps(value, indent=1) + "\n", encoding="utf-8"))


def table(header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Aligned columns: numbers to the right, texts to the left."""
    cells = [[str(cell) for cell in row] for row in rows]
    right = [all(_is_number(row[k]) for row in cells) for k in range(len(header))]
    widths = [max(len(row[k]) for row in [list(header), *cells]) for k in range(len(header))]
    lines = []
    for row in [list(header), *cells]:
        padded = (c.rjust(w) if r else c.ljust(w) for c, w, r in zip(row, widths, right, strict=True))
        lines.append("  ".join(padded).rstrip())
    return "\n".join(lines)


def table_of(rows: Iterable[T], columns: Mapping[str, Callable[[T], object]]) -> str:
    """The same of records: what a cell of each column says of one."""
    return table(list(columns), [[cell(row) for cell in columns.values()] for row in rows])


def _is_number(cell: str) -> bool:
    """Whether a cell holds a number, also in per cent, or nothing."""
    return cell == "-" or cell.removesuffix(" %").lstrip("-").replace(".", "", 1).isdigit()


def percentage(part: int, whole: int) -> str:
    """A part in per cent."""
    return f"{100 * part / whole:.1f} %" if whole else "-"
