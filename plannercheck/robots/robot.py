"""A robot: links with collision bodies, a planning group, and forward kinematics.

In: a URDF with its meshes, optionally an SRDF, or a description from robots/. Out: `Robot`, immutable, which has its
group's joints and limits, poses its links, and lists the pairs of its bodies that are tested. `loading` reads the
files, `forward_kinematics` poses the links.
"""

from __future__ import annotations

import contextlib
import copy
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from plannercheck.bodies.convex_decomposition import Decomposition
from plannercheck.bodies.mesh_files import MeshUnits
from plannercheck.bodies.objects import SceneObject
from plannercheck.bodies.shapes import DEFAULT_EXCESS
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.arrays import Configuration, read_only
from plannercheck.common.checked_yaml import error_context
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.progress import reported
from plannercheck.common.public_names import set_module
from plannercheck.robots.carried_objects import carried_pairs, check_objects, listed_objects
from plannercheck.robots.cells import (
    Placed,
    cell_parts,
    check_is_cell,
    check_joined,
    columns_by_name,
    described_cell,
    joined,
    member_parts,
    members_of,
)
from plannercheck.robots.configurations import ConfigurationMap
from plannercheck.robots.description import ALL, RobotDescription, description_of
from plannercheck.robots.description_files import write_cell
from plannercheck.robots.link_geometry import Geometry
from plannercheck.robots.link_points import LinkPoints, checked_points
from plannercheck.robots.link_tree import LinkTree
from plannercheck.robots.loading import Reference, RobotParts, posed, robot_parts, urdf_description
from plannercheck.robots.objects_in_frames import placed
from plannercheck.robots.planning_groups import explicit_group, joint_list
from plannercheck.robots.posed_robot import PosedRobot
from plannercheck.robots.reference_configuration import all_values, checked_values, with_given
from plannercheck.robots.robot_table import robot_html
from plannercheck.robots.urdf import Mimic


@dataclass(frozen=True, eq=False)
class CellPart:
    """A robot of a cell, and its columns.

    Attributes:
        name: Its name in the cell.
        robot: The robot alone, with its base at the origin: its configurations are the columns, and joints that the
            cell holds are held at the same values. It carries what it carried before the cell was made.
        pose: (4, 4) of its base in the cell, m; read-only.
        joint_names: Its joints in the cell's group, as the cell names them.
        columns: (k,) their columns in a configuration of the cell.
    """

    name: str
    robot: Robot
    pose: Floats
    joint_names: tuple[str, ...]
    columns: Ints64

    def checked(self, q: ArrayLike) -> Floats:
        """Its configurations (k,) or (n, k); of a robot without a group also one number for each joint."""
        with error_context(f"robot {self.name!r}"):
            rows = self.robot.joint_values.configurations(q)
        return rows[0] if np.ndim(q) == 1 else rows


@set_module("plannercheck")
class Robot(PosedRobot):
    """A robot, posed by configurations of its planning group.

    Build one with `Robot.load` or `Robot.from_urdf`. Configurations are in Pinocchio's order, or, with a
    planning group, in the group's order; all other joints are held.

    Attributes:
        name: The robot's name.
        group: Name of the planning group; None for the whole robot.
        joint_names: Joints of the group, a column each; without a group, as many as Pinocchio has numbers for them.
        link_names: The URDF's links in the order of Pinocchio's body frames.
        bodies: Collision bodies in the order of Pinocchio's geometries, then those of carried objects.
        self_pairs: (k, 2) indices into bodies: the pairs that are tested for self-collision.
        carried: Objects that links carry.
        pieces: The pieces of decomposed bodies, by name of the body.
        disabled_pairs: Pairs of links that the robot's YAML leaves out, with reasons.
        open_links: Links that are solids of open meshes: capped, or their triangles alone.
        reference: (nq,) the group's reference configuration, rad and m.
        model: Pinocchio's model.
    """

    def __init__(self, parts: RobotParts) -> None:
        self._parts = parts
        self.name, self.model, self.group = parts.name, parts.model, parts.group
        self.disabled_pairs, self.pieces, self.open_links = parts.disabled_pairs, parts.pieces, parts.open_links
        values = parts.memory.recall(
            ("values", _as_key(parts.values)), lambda: all_values(parts.model, parts.values, parts.mimics)
        )
        self._map, self.reference, self._forward = parts.memory.recall(
            ("posed", parts.joints, _as_key(values)), partial(posed, parts, values)
        )
        self._carry(parts.carried)

    @classmethod
    def load(
        cls,
        name_or_path: str | Path,
        decomposition: Decomposition | None = None,
        *,
        geometry: Geometry | None = None,
        mesh_units: MeshUnits | None = None,
    ) -> Robot:
        """Loads a robot.

        Args:
            name_or_path: A name from robots/ such as "panda", one of the package robot_descriptions such as
                "panda_description", or the path of a YAML description, also of a cell, of a URDF or of a .xacro.
            decomposition: How to split concave links into convex pieces, with CoACD; None follows the YAML.
            geometry: What meshes are taken as: "hull"; convex "pieces"; "solid", whose open meshes are closed by caps;
                "triangles", where open meshes are their triangles alone; or a mapping of links to these; None
                follows the YAML, which has hulls by default. One warning names the open meshes, and the sizes of
                their caps.
            mesh_units: How mesh files are read: "metre" takes their numbers as MoveIt's planning scene does, "file"
                converts them to metres, z up, as their format says. None follows the YAML, which has "metre" by
                default, with a warning where the two differ.

        Returns:
            The robot.
        """
        description = description_of(name_or_path)
        if mesh_units is not None:
            description = replace(description, mesh_units=mesh_units)
        if decomposition is not None:
            description = replace(description, decomposition=decomposition)
        if geometry is not None:
            description = replace(description, geometry=geometry)
        source = description.source
        with contextlib.nullcontext() if source is None else error_context(f"robot file {source}"):
            return cls.from_description(description)

    @classmethod
    def from_urdf(
        cls,
        urdf: str | Path,
        srdf: str | Path | None = None,
        package_dirs: str | Path | Sequence[str | Path] = (),
        group: str | Sequence[str] | None = None,
        reference: Reference = None,
        *,
        floating: bool = False,
        decomposition: Decomposition | None = None,
        geometry: Geometry | None = None,
        mesh_units: MeshUnits | None = None,
        xacro_args: Mapping[str, str] | None = None,
    ) -> Robot:
        """Builds a robot from a URDF.

        Args:
            urdf: Path of the URDF, or of a .xacro that is expanded.
            srdf: Path of an SRDF, for self pairs, groups and states.
            package_dirs: Folders in which the URDF's package:// paths start.
            group: An SRDF group or joint names in order; None for Pinocchio's own q.
            reference: The state at which joints outside the group are held: values by joint name (others
                neutral), an array in Pinocchio's order, or the name of an SRDF group state. Default: within
                its limits, the nearest to Pinocchio's neutral configuration. rad and m.
            floating: Whether the root link is free to move.
            decomposition: How to split concave links into convex pieces, with CoACD; None takes their hulls.
            geometry: What meshes are taken as, as for `load`.
            mesh_units: How mesh files are read, as for `load`.
            xacro_args: Values of the arguments of a URDF that is a .xacro, by name.

        Returns:
            The robot.
        """
        description = urdf_description(
            urdf, srdf, package_dirs, group, floating, decomposition, xacro_args, geometry, mesh_units
        )
        return cls.from_description(description, reference)

    @classmethod
    def from_description(cls, description: RobotDescription, reference: Reference = None) -> Robot:
        """Builds a robot from a description; `reference` as for `from_urdf`, where the description of one has none."""
        if description.robots:
            return cls(described_cell(description, lambda each: cls.from_description(each).parts_of_files()))
        with reported(f"loading robot {description.name or description.urdf.stem}"):
            return cls(robot_parts(description, reference))

    @classmethod
    def together(cls, robots: Mapping[str, Placed], group: str | None = None) -> Robot:
        """Several robots as one robot: a cell.

        Names of joints, links, bodies and carried objects get the robot's name before them, "left/panda_joint1". A
        configuration is those of the robots side by side, in their order. Each robot keeps its own pairs, and all pairs
        of bodies of two robots are tested, unless both are fixed to the world.

        Args:
            robots: By name, a robot and the pose (4, 4) of its base in m; one robot may have no pose and stands at the
                origin.
            group: The robot whose joints are the planning group, while the others are held; None or "all" for all.

        Returns:
            The cell. If one of the robots has a planning group, a robot without one gets a group of all its joints.

        Raises:
            PlannercheckError: For a faulty name, something that is no robot, a pose that is not rigid, or several
                robots without a pose.
        """
        cell = cls(cell_parts(members_of(robots)))
        if group is None or group == ALL:
            return cell
        if not isinstance(group, str) or group not in cell.parts:
            raise unknown_name("group of the cell", group, (ALL, *cell.parts))
        return cell.with_group(cell.parts[group].joint_names, group)

    @cached_property
    def parts(self) -> Mapping[str, CellPart]:
        """The robots of a cell, by name; none if this is a single robot."""
        members = self._parts.members
        columns = columns_by_name(members, self._map.joint_names, self._map.starts, self._map.width)
        return {
            name: CellPart(name, Robot(member_parts(self._parts, name, joints)), members[name].pose, joints, own)
            for name, (joints, own) in columns.items()
        }

    def join(self, configurations: Mapping[str, ArrayLike]) -> Floats:
        """The configuration of a cell from those of its robots.

        Args:
            configurations: (k,) or (n, k) of each robot that the group moves, by name, k as its `parts[name].columns`.
                One of several robots may have one configuration (k,) that all rows share.

        Returns:
            (nq,) or (n, nq).
        """
        check_is_cell(self._parts.members)
        columns = {name: part.columns for name, part in self.parts.items() if len(part.columns)}
        check_joined(configurations, list(columns))
        rows = {name: self.parts[name].checked(configurations[name]) for name in columns}
        return joined(rows, columns, self.nq)

    def split(self, q: ArrayLike) -> dict[str, Floats]:
        """The configurations (k,) or (n, k) of a cell's robots, by name, from the cell's (nq,) or (n, nq)."""
        check_is_cell(self._parts.members)
        rows = self.check_configurations(q)
        found = {name: rows[:, part.columns] for name, part in self.parts.items()}
        return {name: each[0] for name, each in found.items()} if np.ndim(q) == 1 else found

    @property
    def nq(self) -> int:
        """Numbers in a configuration."""
        return self._map.width

    @property
    def own_width(self) -> int:
        """Numbers in a configuration without those of what moves in a scene (carriers.py)."""
        return self.nq

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints of the group, in order."""
        return self._map.joint_names

    @property
    def lower(self) -> Floats:
        """(nq,) lower limits in rad or m; -inf for continuous joints of a group."""
        return self._map.lower.copy()

    @property
    def upper(self) -> Floats:
        """(nq,) upper limits in rad or m; inf for continuous joints of a group."""
        return self._map.upper.copy()

    def check_configurations(self, q: ArrayLike) -> Floats:
        """Validates configurations: numbers, width, finite values, unit quaternions. Limits are not checked.

        Args:
            q: (nq,) or (n, nq).

        Returns:
            (n, nq) float64 in C order, n = 1 for a single one.
        """
        return self._map.checked(q)

    def expand(self, q: ArrayLike) -> Floats:
        """Fills in the held joints.

        Args:
            q: (nq,) or (n, nq) configurations of the group. Of a robot without a group also one number for each joint,
                a continuous joint as one angle.

        Returns:
            (full nq,) or (n, full nq), Pinocchio's configurations.
        """
        full = self._map.expand(self.joint_values.configurations(q))
        return full[0] if np.ndim(q) == 1 else full

    @property
    def configuration_map(self) -> ConfigurationMap:
        """Where the numbers in Pinocchio's q come from."""
        return self._map

    @property
    def default_links(self) -> tuple[str, ...]:
        """Links that the SRDF tests against nothing by default: not against obstacles, and few other links."""
        return self._parts.default_links

    @property
    def link_tree(self) -> LinkTree:
        """The links and the joints between them."""
        return self._parts.tree

    @property
    def mimics(self) -> Mapping[str, Mimic]:
        """The joints that follow others, by name."""
        return self._parts.mimics

    @property
    def frames(self) -> Sequence[int]:
        """Pinocchio's frames of the links, in the order of link_names."""
        return self._parts.tree.frames

    def holding(self, values: Mapping[str, float | Sequence[float]]) -> Robot:
        """The same robot with joints held at other values (or, for joints of the group, with another reference).

        Args:
            values: Values by joint name, rad or m, also beyond limits. Followers not given move with their leaders;
                those of joints in the group always do, so that another value is an error.

        Returns:
            A new robot with the same bodies and group.
        """
        given = checked_values(self.model, values)
        return self._changed(values=with_given(self._parts.values, given, self._parts.mimics))

    def with_group(self, joints: Sequence[str], name: str = "group") -> Robot:
        """The same robot with another planning group; the joints outside it stay at the reference.

        Args:
            joints: Names in order.
            name: The group's name.

        Returns:
            A new robot with the same bodies.
        """
        listed, parts = joint_list(joints), self._parts
        checked = parts.memory.recall(("group", listed), lambda: explicit_group(self.model, listed, parts.mimics))
        return self._changed(group=name, joints=checked)

    def carrying(self, objects: Iterable[SceneObject]) -> Robot:
        """The same robot with other carried objects.

        Args:
            objects: Attached objects, see `Scene.attach`; none for the robot alone.

        Returns:
            A robot that shares everything else with this one.
        """
        other = copy.copy(self)
        other._parts = replace(self._parts, carried=placed(self, listed_objects(objects)))
        other._carry(other._parts.carried)
        return other

    def remove_own_points(self, points: ArrayLike, q: Configuration, margin: float = 0.0) -> Floats:
        """The points of a cloud that are not the robot's own: those further than a margin from all of its bodies.

        Args:
            points: (n, 3) in the world, m.
            q: (nq,) the configuration at which they were seen, rad and m, or each joint's value by its name.
            margin: m.

        Returns:
            (k, 3) in their order: the points whose distance from every link, and from what it carries, exceeds the
            margin, exactly.

        Raises:
            PlannercheckError: If points are not finite or have another shape, or if the margin is negative.
        """
        rows = checked_points(points)
        poses = self.link_poses(q).reshape(-1, len(self.link_names), 4, 4)
        if len(poses) != 1:
            raise PlannercheckError(f"points are seen at one configuration ({self.nq},), not at {len(poses)}")
        return rows.compress(~self.link_points().near(poses[0], rows, margin), axis=0)

    def link_points(self, excess: float = DEFAULT_EXCESS) -> LinkPoints:
        """The bodies of all links, prepared for tests with points; `excess` as for `Checker`."""
        links = [self.link_index(str(body.link)) for body in self.bodies]
        return self.remembered(("points", excess), lambda: LinkPoints(self.bodies, links, excess))

    def save(self, path: str | Path) -> None:
        """Writes a cell as YAML, which `load` reads: where each robot's file is, and its pose, to the same doubles.

        Args:
            path: Ends in .yaml or .yml.

        Raises:
            PlannercheckError: If this is a single robot, if a robot is from no file or carries objects, or if the file
                can't be written.
        """
        check_is_cell(self._parts.members)
        write_cell(self._parts, Path(path))

    def _carry(self, objects: tuple[SceneObject, ...]) -> None:
        own, pairs = self._parts.bodies, self._parts.pairs
        self.carried = objects
        if not objects:
            self.bodies, self.self_pairs = own, read_only(pairs.copy())
            return
        check_objects(objects, self.link_names, own)
        self.bodies = (*own, *(body for item in objects for body in item.bodies))
        more = np.array(carried_pairs(objects, own), dtype=np.int64).reshape(-1, 2)
        self.self_pairs = read_only(np.concatenate([pairs, more]))

    def __repr__(self) -> str:
        group = f"group {self.group!r}, " if self.group else ""
        return f"Robot({self.name!r}, {group}nq={self.nq}, {len(self.bodies)} bodies)"

    def _repr_html_(self) -> str:
        return robot_html(repr(self), self.joint_names, self._map.starts, self.lower, self.upper)

    def __reduce__(self) -> tuple[Any, ...]:
        return Robot, (self._parts,)

    def _changed(self, **changes: Any) -> Robot:
        return Robot(replace(self._parts, **changes))


def _as_key(values: Mapping[str, Floats]) -> tuple[tuple[str, bytes], ...]:
    """Values of joints by name, as a key of `RobotMemory`."""
    return tuple((name, value.tobytes()) for name, value in values.items())
