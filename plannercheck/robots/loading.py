"""Loads a robot: from a description to the parts of a `Robot`.

In: a robot's description (its URDF, SRDF, group, disabled pairs), and the state at which joints are held. Out:
`RobotParts`. Pinocchio reads the URDF; each file is parsed once.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from plannercheck.bodies.convex_decomposition import Decomposition
from plannercheck.bodies.mesh_files import MeshFile, MeshUnits
from plannercheck.bodies.objects import SceneObject
from plannercheck.bodies.pieces import Pieces
from plannercheck.bodies.shapes import GeometryObject
from plannercheck.common.arrays import read_only
from plannercheck.common.errors import PlannercheckError
from plannercheck.robots.configurations import ConfigurationMap, planning_group, whole_robot
from plannercheck.robots.description import RobotDescription
from plannercheck.robots.forward_kinematics import ForwardKinematics
from plannercheck.robots.link_bodies import read_bodies, warn_of_large_hulls
from plannercheck.robots.link_geometry import Geometry, with_geometry
from plannercheck.robots.link_tree import LinkTree
from plannercheck.robots.planning_groups import explicit_group, joint_list, srdf_group, usable_mimics
from plannercheck.robots.reference_configuration import check_followers, given_values, reference_of, with_given
from plannercheck.robots.robot_memory import RobotMemory
from plannercheck.robots.self_pairs import self_pairs
from plannercheck.robots.srdf import DisabledPair, default_links, group_state, warn_about_ignored_elements
from plannercheck.robots.urdf import Mimic, link_tree, read_model
from plannercheck.robots.urdf_file import MJCF_ROOT
from plannercheck.robots.urdf_hints import warn_of_odd_numbers

if TYPE_CHECKING:
    from plannercheck.robots.mjcf import MjcfRobot

Reference: TypeAlias = Mapping[str, Any] | Sequence[float] | NDArray[np.float64] | str | None


@dataclass(frozen=True, eq=False)
class Member:
    """A robot of a cell.

    Attributes:
        parts: The robot alone. With a group if the cell has one.
        pose: (4, 4) of its base in the cell, m; read-only.
    """

    parts: RobotParts
    pose: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RobotParts:
    """The parts of a `Robot`.

    Attributes:
        name: The robot's name.
        model: Pinocchio's model.
        tree: Links and the joints between them.
        bodies: Collision bodies of the links.
        pairs: (k, 2) indices into bodies: the pairs that are tested for self-collision.
        disabled_pairs: Pairs of links that the robot's YAML leaves out, with reasons.
        mimics: The joints that follow others, by name.
        values: The values at which joints are held, by name, rad and m; one angle for a continuous joint.
        group: Name of the planning group; None for the whole robot.
        joints: The joints of the group, in order; None for the whole robot.
        carried: Objects that links carry.
        pieces: The pieces of decomposed bodies, by name of the body.
        open_links: Links that are solids of open meshes: capped, or their triangles alone.
        default_links: Links that the SRDF leaves out of tests by default (<disable_default_collisions>).
        members: The robots of a cell, by name.
        description: What it was read by; None if it is made of others in memory.
        memory: What has been computed of robots with these files.
    """

    name: str
    model: pin.Model
    tree: LinkTree
    bodies: tuple[GeometryObject, ...]
    pairs: NDArray[np.int64]
    disabled_pairs: tuple[DisabledPair, ...]
    mimics: Mapping[str, Mimic]
    values: Mapping[str, NDArray[np.float64]]
    group: str | None
    joints: tuple[str, ...] | None
    carried: tuple[SceneObject, ...] = ()
    pieces: Mapping[str, Pieces] = field(default_factory=dict)
    open_links: tuple[str, ...] = ()
    default_links: tuple[str, ...] = ()
    members: Mapping[str, Member] = field(default_factory=dict)
    description: RobotDescription | None = None
    memory: RobotMemory = field(default_factory=RobotMemory)


def urdf_description(
    urdf: str | Path,
    srdf: str | Path | None,
    package_dirs: str | Path | Sequence[str | Path],
    group: str | Sequence[str] | None,
    floating: bool,
    decomposition: Decomposition | None,
    xacro_args: Mapping[str, str] | None,
    geometry: Geometry | None = None,
    mesh_units: MeshUnits | None = None,
) -> RobotDescription:
    """The description of a robot that has no YAML; arguments as of `Robot.from_urdf`."""
    name, joints = (group, None) if group is None or isinstance(group, str) else ("group", joint_list(group))
    folders = [package_dirs] if isinstance(package_dirs, str | Path) else package_dirs
    return RobotDescription(
        name="",
        urdf=Path(urdf),
        srdf=None if srdf is None else Path(srdf),
        package_dirs=tuple(Path(folder) for folder in folders),
        floating=floating,
        group=name,
        joints=joints,
        decomposition=decomposition,
        xacro_args=dict(xacro_args or {}),
        geometry=geometry,
        mesh_units=mesh_units,
    )


def robot_parts(description: RobotDescription, reference: Reference) -> RobotParts:
    """Reads the parts of a robot, by its YAML as read, or the arguments of `Robot.from_urdf`.

    The reference is as for `Robot.from_urdf`; values in the description take precedence.
    """
    urdf = description.file
    mjcf = _mjcf_robot(description) if urdf.kind == MJCF_ROOT else None
    if mjcf is not None:
        model, mimics, links = mjcf.model, mjcf.mimics, mjcf.links
    else:
        model = read_model(urdf, description.floating)
        links = read_bodies(model, urdf, description.package_dirs, description.mesh_units)
        warn_of_odd_numbers(urdf, description.is_shipped)
        mimics = usable_mimics(model, urdf)
    bodies = links.bodies
    tree = link_tree(model)
    srdf = description.semantics
    if srdf is not None:
        warn_about_ignored_elements(srdf, tree)
    if isinstance(reference, str):
        reference = group_state(srdf, reference, description.group, model.names, tree)
    joints = group_of(description, model, tree, mimics)
    own_values = {**(mjcf.initial if mjcf else {}), **given_values(model, description.own_values)}
    values = with_given(own_values, given_values(model, description.values or reference), mimics)
    check_held(description, joints)
    disabled = description.disabled_pairs
    if mjcf is not None:
        pairs = mjcf.allowed_pairs(srdf, disabled)
    else:
        pairs = self_pairs(links.joints, bodies, srdf, tree, disabled)
    pieces: Mapping[str, Pieces] = {}
    open_links: tuple[str, ...] = ()
    if description.decomposition is not None or description.geometry is not None:
        asked = description.geometry, description.decomposition
        bodies, pairs, pieces, open_links = with_geometry(bodies, pairs, links.meshes, *asked)
    else:
        warn_of_large_hulls(urdf.path, links)
    return RobotParts(
        name=description.name or model.name or urdf.path.stem,
        model=model,
        tree=tree,
        bodies=bodies,
        pairs=pairs,
        pieces=pieces,
        open_links=open_links,
        default_links=() if srdf is None else default_links(srdf.root),
        disabled_pairs=disabled,
        mimics=mimics,
        values=values,
        group=description.group,
        joints=joints,
        description=description,
    )


def _mjcf_robot(description: RobotDescription) -> MjcfRobot:
    from plannercheck.robots.mjcf import read_mjcf_robot  # a tenth of what a URDF imports, and no URDF needs it

    return read_mjcf_robot(description.file.path, description.floating)


def collision_meshes(description: RobotDescription) -> dict[str, MeshFile]:
    """The meshes of a robot's links by name of the body, read anew, without the warnings of loading the robot."""
    if description.robots:
        of_robots = {name: collision_meshes(description.of_robot(name)) for name in description.robots}
        return {f"{name}/{body}": mesh for name, meshes in of_robots.items() for body, mesh in meshes.items()}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        file = description.file
        if file.kind == MJCF_ROOT:
            links = _mjcf_robot(description).links
        else:
            model = read_model(file, description.floating)
            links = read_bodies(model, file, description.package_dirs, description.mesh_units)
    pairs = zip(links.bodies, links.meshes, strict=True)
    return {body.name: mesh for body, mesh in pairs if mesh is not None}


def check_held(description: RobotDescription, joints: tuple[str, ...] | None) -> None:
    """Raises if a joint that the description holds is one of the group's; None for the whole robot."""
    for joint in description.held:
        if joints is None or joint in joints:
            raise PlannercheckError(
                f"held joint {joint!r} is in the planning group, which moves it: list a group without it, or give its "
                "value in reference"
            )


def group_of(
    description: RobotDescription, model: pin.Model, tree: LinkTree, mimics: Mapping[str, Mimic]
) -> tuple[str, ...] | None:
    """The joints of the planning group, in order; None for the whole robot."""
    if description.joints is not None:
        return explicit_group(model, description.joints, mimics)
    if description.group is None:
        return None
    root = None if description.semantics is None else description.semantics.root
    return srdf_group(model, root, description.group, tree, mimics)


def posed(
    parts: RobotParts, values: Mapping[str, NDArray[np.float64]]
) -> tuple[ConfigurationMap, NDArray[np.float64], ForwardKinematics]:
    """Configuration map, reference (nq,) and kinematics of a robot's group; all other joints held at `values`."""
    model, group = parts.model, parts.joints
    if group is not None:
        check_followers(group, parts.values, values, parts.mimics)
    sources = whole_robot(model) if group is None else planning_group(model, group, values, parts.mimics)
    reference = read_only(reference_of(model, group, values))
    return sources, reference, ForwardKinematics(model, sources, parts.tree.frames, parts.name)
