"""Reads robot descriptions: robots/<name>.yaml.

In: a name or a path. Out: `RobotDescription`, all that `Robot` is built from, with paths resolved. Keys:

    name: panda                # default: the file's name
    urdf: panda.urdf           # from this file's folder, or else from example-robot-data's share folder
    srdf: panda.srdf           # optional, found likewise; it then decides the self pairs
    package_dirs: [meshes]     # optional, where package:// paths start, besides that share folder
    xacro_args: {side: left}   # optional, for a URDF that is a .xacro
    floating: false            # optional, whether the root link is free
    group: arm                 # an SRDF group, or {name: arm, joints: [joint1, ...]}; default: all joints
    reference: {joint1: 0.5}   # optional, values of joints in rad or m; others are neutral
    held: {finger: 0.04}       # optional, the same for joints outside the group
    geometry: hull             # optional, what meshes are: hull, pieces, solid, triangles, or {link3: solid, ...}
    mesh_units: metre          # optional, metre reads mesh files as MoveIt does, file converts as their formats say
    convex_decomposition:      # optional, makes links of convex pieces by CoACD (pip install 'plannercheck[coacd]')
      links: [link3, link4]    # optional, default: all whose hulls are more than 5 % larger than their meshes
      threshold: 0.05          # optional, concavity that a piece may have; small ones make many pieces
      most_pieces: 16          # optional, of one mesh
      slack: 0.001             # optional, m: pieces grow by about this to hold the mesh
      time_limit: 600          # optional, s: a mesh that CoACD does not split within it keeps its hull
    disabled_pairs:            # optional, links that are not tested against each other, and why
      - reason: adjacent
        pairs: [[link1, link2], ...]

or, of a cell, several robots as one:

    robots:                    # by name; a robot also takes the keys above but name and urdf
      left: {load: panda}      # a name or a file, as for `Robot.load`; one robot may have no pose
      right: {load: other.yaml, pose: {position: [0, 1, 0], rpy: [0, 0, 3.14]}}   # as in scenes
    group: all                 # optional: a robot's name, or as above

and of the keys above name, srdf, package_dirs, group, reference, held, geometry, mesh_units and disabled_pairs, whose
names of links and joints begin with the robot's: left/joint1.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any

from plannercheck.bodies.convex_decomposition import Decomposition
from plannercheck.bodies.mesh_files import MeshUnits, checked_units
from plannercheck.bodies.written_poses import POSE_KEYS, pose_of_node
from plannercheck.common.array_types import Floats
from plannercheck.common.checked_yaml import (
    Node,
    check_keys,
    error_context,
    mapping,
    number,
    parse_yaml,
    read_bytes,
    required,
    sequence,
    text,
)
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.common.file_kinds import kind_of
from plannercheck.common.package_data import (
    example_robot_data,
    is_file,
    is_folder,
    is_planar_file,
    shipped_folder,
    why_no_file,
)
from plannercheck.robots.link_geometry import Geometry, checked_geometry
from plannercheck.robots.robot_descriptions import files_by_name
from plannercheck.robots.srdf import DisabledPair, Srdf, read_srdf
from plannercheck.robots.urdf_file import UrdfFile

# The group of all joints of a cell.
ALL = "all"

# What a URDF's name ends with.
URDF_SUFFIXES = (".urdf", ".xml", ".xacro", ".mjcf", ".sdf")

# Keys of one robot that a cell does not have, and those that a robot of a cell does not have.
_OF_ONE = ("urdf", "xacro_args", "floating", "convex_decomposition")
_OF_ALL = ("name", "srdf", "package_dirs", "group", "reference", "held", "geometry", "mesh_units", "disabled_pairs")
_KEYS = (*_OF_ONE, *_OF_ALL)
_MEMBER_KEYS = ("load", "pose", *(key for key in _KEYS if key not in ("name", "urdf", "disabled_pairs")))


@dataclass(frozen=True, eq=False)
class PlacedDescription:
    """A robot of a cell.

    Attributes:
        description: The robot's.
        pose: (4, 4) of its base in the cell, m; None if the file gives none.
    """

    description: RobotDescription
    pose: Floats | None


@dataclass(frozen=True)
class RobotDescription:
    """The content of a robot's YAML file, with paths resolved.

    Attributes:
        name: The robot's name.
        urdf: Path of its URDF.
        srdf: Path of its SRDF, if any.
        package_dirs: Where package:// paths start.
        floating: Whether the root link is free.
        group: Name of the planning group; None for the whole robot.
        joints: The group's joints in order; None to take them from the SRDF.
        values: Joint values of the reference state and of held joints, by name, rad or m.
        own_values: Those of the robot's own file, where `values` are what a cell's file says besides.
        held: The joints that `held` names, which no group may have.
        disabled_pairs: Pairs of links that are not tested.
        decomposition: How to split concave links into convex pieces; None for hulls.
        geometry: What the meshes of all links, or of links by name, are taken as; None for hulls, or pieces as
            `decomposition` says.
        mesh_units: How mesh files are read; None for MoveIt's way, with a warning where the format says otherwise.
        xacro_args: Values of the arguments of a URDF that is a xacro, by name.
        source: The YAML file; None if there is none.
        robots: Of a cell, its robots by name; the cell's `urdf` is its YAML file.
    """

    name: str
    urdf: Path
    srdf: Path | None = None
    package_dirs: tuple[Path, ...] = ()
    floating: bool = False
    group: str | None = None
    joints: tuple[str, ...] | None = None
    values: Mapping[str, Any] = field(default_factory=dict)
    own_values: Mapping[str, Any] = field(default_factory=dict)
    held: tuple[str, ...] = ()
    disabled_pairs: tuple[DisabledPair, ...] = ()
    decomposition: Decomposition | None = None
    geometry: Geometry | None = None
    mesh_units: MeshUnits | None = None
    xacro_args: Mapping[str, str] = field(default_factory=dict)
    source: Path | None = None
    robots: Mapping[str, PlacedDescription] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not isinstance(self.decomposition, Decomposition | None):
            raise PlannercheckError(f"decomposition must be a pc.Decomposition, not {self.decomposition!r:.80}")
        object.__setattr__(self, "geometry", checked_geometry(self.geometry))
        object.__setattr__(self, "mesh_units", checked_units(self.mesh_units))

    @property
    def is_shipped(self) -> bool:
        """Whether it comes with the package."""
        return self.source is not None and self.source.parent == shipped_folder("robots")

    @cached_property
    def file(self) -> UrdfFile:
        """The URDF, read once."""
        return UrdfFile.read(self.urdf, self.xacro_args, self.package_dirs)

    @cached_property
    def semantics(self) -> Srdf | None:
        """The SRDF, parsed once; None if there is none."""
        return None if self.srdf is None else Srdf(self.srdf, read_srdf(self.srdf))

    def of_robot(self, name: str) -> RobotDescription:
        """The description of a cell's robot, with what the cell says of all robots."""
        own, changes = self.robots[name].description, dict[str, Any]()
        if self.package_dirs:
            changes["package_dirs"] = tuple(dict.fromkeys((*self.package_dirs, *own.package_dirs)))
        if self.mesh_units is not None:
            changes["mesh_units"] = self.mesh_units
        if self.geometry is not None:
            changes |= {"geometry": _of_links(self.geometry, f"{name}/"), "decomposition": None}
        if self.decomposition is not None:
            links = self.decomposition.links
            own_links = None if links is None else tuple(_of_links(dict.fromkeys(links, "hull"), f"{name}/"))
            if own_links is None or own_links:
                changes["decomposition"] = replace(self.decomposition, links=own_links)
        return replace(own, **changes) if changes else own


def _of_links(by_link: Geometry, prefix: str) -> Geometry:
    """What is said of the links of a cell's robot, by its own names."""
    if isinstance(by_link, str):
        return by_link
    return {link.removeprefix(prefix): kind for link, kind in by_link.items() if link.startswith(prefix)}


def shipped_robots() -> list[str]:
    """Names of the robots in space that come with plannercheck; planar ones have functions of their own."""
    return sorted(path.stem for path in shipped_folder("robots").glob("*.yaml") if not is_planar_file(path))


def find_description(name_or_path: str | Path) -> Path:
    """The YAML file of a shipped robot's name, or the path itself."""
    if not isinstance(name_or_path, str | PathLike):
        raise PlannercheckError(f"a robot is loaded by its name or from a file, not {name_or_path!r:.80}")
    path = Path(name_or_path)
    if path.suffix in (".yaml", ".yml", *URDF_SUFFIXES):
        if not is_file(path):
            raise PlannercheckError(f"robot file {path} {why_no_file(path)}")
        return path
    shipped = shipped_folder("robots") / f"{name_or_path}.yaml"
    if not is_file(shipped) and (path.suffix or (is_file(path) or is_folder(path))):
        kind = kind_of(path)
        raise PlannercheckError(
            f"robot {str(name_or_path)!r} must be a shipped robot's name, a YAML or a URDF file{kind and '; '}{kind}"
        )
    if not is_file(shipped):
        raise unknown_name("robot", str(name_or_path), shipped_robots())
    return shipped


def description_of(name_or_path: str | Path | RobotDescription, above: tuple[Path, ...] = ()) -> RobotDescription:
    """The description in a robot's YAML, or one of a URDF alone; a description is returned as it is.

    The cells that load it are `above`, the outermost first.
    """
    if isinstance(name_or_path, RobotDescription):
        return name_or_path
    named = None if is_file(shipped_folder("robots") / f"{name_or_path}.yaml") else files_by_name(str(name_or_path))
    if named is not None:
        return RobotDescription(
            name="",
            urdf=Path(named.urdf),
            srdf=None if named.srdf is None else Path(named.srdf),
            package_dirs=(*map(Path, named.folders), example_robot_data()),
            xacro_args=named.xacro_args,
        )
    path = find_description(name_or_path)
    if path.suffix in URDF_SUFFIXES:
        return RobotDescription(name="", urdf=path, package_dirs=(example_robot_data(),))
    with error_context(f"robot file {path}"):
        return read_description(path, above)


def read_description(path: Path, above: tuple[Path, ...] = ()) -> RobotDescription:
    """Reads a robot's YAML file, or a cell's; the cells that load it are `above`, the outermost first."""
    content = parse_yaml(read_bytes(path), as_written="xacro_args")
    if "objects" in content:
        raise PlannercheckError("is a scene, not a robot")
    if "robots" in content:
        return _read_cell(path, content, above)
    check_keys(content, _KEYS)
    fields = _fields(content, path.parent)
    return RobotDescription(
        name=text(content.get("name", path.stem), "name"),
        urdf=_resolve(text(required(content, "urdf"), "urdf"), path.parent),
        source=path,
        **{**fields, "package_dirs": (*fields.get("package_dirs", ()), example_robot_data())},
    )


def _read_cell(path: Path, content: Node, above: tuple[Path, ...]) -> RobotDescription:
    check_keys(content, ("robots", *_OF_ALL))
    above = (*above, path.resolve())
    robots = {}
    for name, node in mapping(content["robots"], "'robots'").items():
        with error_context(f"robot {name!r}"):
            robots[name] = _member(mapping(node, "it"), path.parent, above)
    if not robots:
        raise PlannercheckError("'robots' must name at least one robot, as in robots: {left: {load: panda}}")
    name = text(content.get("name", path.stem), "name")
    return RobotDescription(name=name, urdf=path, source=path, robots=robots, **_fields(content, path.parent))


def _member(node: Node, folder: Path, above: tuple[Path, ...]) -> PlacedDescription:
    """A robot of a cell: what its own file says, and what the cell's file says besides."""
    check_keys(node, _MEMBER_KEYS)
    named = text(required(node, "load"), "load")
    file = folder / named
    is_named_file = is_file(file) or file.suffix in (".yaml", ".yml", *URDF_SUFFIXES)
    if is_named_file and file.resolve() in above:
        chain = " > ".join(each.name for each in (*above[above.index(file.resolve()) :], file))
        raise PlannercheckError(f"load: {named} loads itself ({chain}): load the file of one robot")
    own = description_of(file if is_named_file else named, above)
    fields = _fields(node, folder)
    fields["package_dirs"] = (*fields.get("package_dirs", ()), *own.package_dirs)
    if fields.get("values"):
        fields["own_values"] = own.values
    else:
        fields["values"] = own.values
    fields["held"] = (*(() if "group" in node else own.held), *fields.get("held", ()))
    given = mapping(node.get("pose"), "pose") if node.get("pose") is not None else None
    if given is None:
        return PlacedDescription(replace(own, **fields), None)
    with error_context("pose"):
        check_keys(given, POSE_KEYS)
        return PlacedDescription(replace(own, **fields), pose_of_node(given))


def _fields(content: Node, folder: Path) -> dict[str, Any]:
    """The fields of a description that keys give; paths start in a folder."""
    fields: dict[str, Any] = {}
    if content.get("srdf"):
        fields["srdf"] = _resolve(text(content["srdf"], "srdf"), folder)
    if "package_dirs" in content:
        names = sequence(content["package_dirs"], "package_dirs")
        fields["package_dirs"] = tuple(folder / text(name, "package_dirs") for name in names)
    if "xacro_args" in content:
        fields["xacro_args"] = mapping(content["xacro_args"], "xacro_args")
        for key, value in fields["xacro_args"].items():
            if not isinstance(value, str):
                raise PlannercheckError(f"xacro_args: {key!r} must be a text (of nothing: ''), not {value!r:.60}")
    if "floating" in content:
        fields["floating"] = _switch(content["floating"])
    if "group" in content:
        fields["group"], fields["joints"] = _group(content["group"])
    if "reference" in content or "held" in content:
        reference, held = (mapping(content.get(key), key) for key in ("reference", "held"))
        if both := [joint for joint in held if joint in reference]:
            raise PlannercheckError(f"joint {both[0]!r} is in reference and in held: leave one out")
        fields["values"], fields["held"] = {**reference, **held}, tuple(held)
    if "disabled_pairs" in content:
        fields["disabled_pairs"] = _disabled_pairs(content["disabled_pairs"])
    if "convex_decomposition" in content:
        fields["decomposition"] = _decomposition(content["convex_decomposition"])
    return fields | {key: content[key] for key in ("geometry", "mesh_units") if key in content}


def _decomposition(value: Any) -> Decomposition | None:
    if value is None or value is False:
        return None
    with error_context("convex_decomposition"):
        options = {} if value is True else mapping(value, "it")
        check_keys(options, ("links", "threshold", "most_pieces", "slack", "seed", "time_limit"))
        links = [text(link, "links") for link in sequence(options.get("links"), "links")] or None
        sizes = {key: number(options[key], key) for key in ("threshold", "slack", "time_limit") if key in options}
        counts = {key: _whole(options[key], key) for key in ("most_pieces", "seed") if key in options}
        return Decomposition(None if links is None else tuple(links), **sizes, **counts)  # type: ignore[arg-type]


def _whole(value: Any, key: str) -> int:
    given = number(value, key)
    if given % 1:
        raise PlannercheckError(f"{key!r} must be a whole number, not {value!r:.60}")
    return int(given)


def _resolve(name: str, folder: Path) -> Path:
    """A file beside the YAML, else in example-robot-data; errors name the first."""
    shared, beside = example_robot_data() / name, folder / name
    return shared if is_file(shared) and not is_file(beside) else beside


def _switch(value: Any) -> bool:
    if not isinstance(value, bool):
        raise PlannercheckError(f"'floating' must be true or false, not {value!r:.60}")
    return value


def _group(value: Any) -> tuple[str | None, tuple[str, ...] | None]:
    """The group's name, and its joints unless the SRDF gives them."""
    if not isinstance(value, dict | list):
        return None if value is None else text(value, "group"), None
    with error_context("group"):
        group = mapping(value, "an SRDF group's name or {name: ..., joints: [...]}: it")
        check_keys(group, ("name", "joints"))
        joints = sequence(required(group, "joints"), "joints")
        return text(group.get("name", "group"), "name"), tuple(text(joint, "joints") for joint in joints)


def _disabled_pairs(value: Any) -> tuple[DisabledPair, ...]:
    disabled: list[DisabledPair] = []
    for index, item in enumerate(sequence(value, "disabled_pairs")):
        with error_context(f"disabled_pairs, item {index + 1}"):
            block = mapping(item, "it")
            check_keys(block, ("reason", "pairs"))
            reason = text(required(block, "reason"), "reason")
            disabled += [_disabled_pair(pair, reason) for pair in sequence(required(block, "pairs"), "pairs")]
    return tuple(disabled)


def _disabled_pair(value: Any, reason: str) -> DisabledPair:
    links = [text(link, "pairs") for link in sequence(value, "a pair")]
    if len(links) != 2:
        raise PlannercheckError(f"a pair must be two links, not {links}")
    return DisabledPair(links[0], links[1], reason)
