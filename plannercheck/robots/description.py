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
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from plannercheck.bodies.convex_decomposition import Decomposition
from plannercheck.bodies.mesh_files import MeshUnits, checked_units
from plannercheck.common.checked_yaml import (
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
from plannercheck.common.package_data import example_robot_data, is_file, is_folder, is_planar_file, shipped_folder
from plannercheck.robots.link_geometry import Geometry, checked_geometry
from plannercheck.robots.robot_descriptions import files_by_name
from plannercheck.robots.srdf import DisabledPair, Srdf, read_srdf
from plannercheck.robots.urdf_file import UrdfFile

# What a URDF's name ends with.
URDF_SUFFIXES = (".urdf", ".xml", ".xacro", ".mjcf", ".sdf")

_KEYS = (
    "name",
    "urdf",
    "srdf",
    "package_dirs",
    "xacro_args",
    "floating",
    "group",
    "reference",
    "held",
    "geometry",
    "mesh_units",
    "convex_decomposition",
    "disabled_pairs",
)


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
        disabled_pairs: Pairs of links that are not tested.
        decomposition: How to split concave links into convex pieces; None for hulls.
        geometry: What the meshes of all links, or of links by name, are taken as; None for hulls, or pieces as
            `decomposition` says.
        mesh_units: How mesh files are read; None for MoveIt's way, with a warning where the format says otherwise.
        xacro_args: Values of the arguments of a URDF that is a xacro, by name.
        source: The YAML file; None if there is none.
    """

    name: str
    urdf: Path
    srdf: Path | None = None
    package_dirs: tuple[Path, ...] = ()
    floating: bool = False
    group: str | None = None
    joints: tuple[str, ...] | None = None
    values: Mapping[str, Any] = field(default_factory=dict)
    disabled_pairs: tuple[DisabledPair, ...] = ()
    decomposition: Decomposition | None = None
    geometry: Geometry | None = None
    mesh_units: MeshUnits | None = None
    xacro_args: Mapping[str, str] = field(default_factory=dict)
    source: Path | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "geometry", checked_geometry(self.geometry))
        object.__setattr__(self, "mesh_units", checked_units(self.mesh_units))

    @cached_property
    def file(self) -> UrdfFile:
        """The URDF, read once."""
        return UrdfFile.read(self.urdf, self.xacro_args, self.package_dirs)

    @cached_property
    def semantics(self) -> Srdf | None:
        """The SRDF, parsed once; None if there is none."""
        return None if self.srdf is None else Srdf(self.srdf, read_srdf(self.srdf))


def shipped_robots() -> list[str]:
    """Names of the robots in space that come with plannercheck; planar ones have functions of their own."""
    return sorted(path.stem for path in shipped_folder("robots").glob("*.yaml") if not is_planar_file(path))


def find_description(name_or_path: str | Path) -> Path:
    """The YAML file of a shipped robot's name, or the path itself."""
    path = Path(name_or_path)
    if path.suffix in (".yaml", ".yml", *URDF_SUFFIXES):
        if not is_file(path):
            raise PlannercheckError(f"robot file {path} does not exist")
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


def description_of(name_or_path: str | Path | RobotDescription) -> RobotDescription:
    """The description in a robot's YAML, or one of a URDF alone; a description is returned as it is."""
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
        return read_description(path)


def read_description(path: Path) -> RobotDescription:
    """Reads a robot's YAML file.

    Args:
        path: The file.

    Returns:
        The description.
    """
    content = parse_yaml(read_bytes(path))
    if "objects" in content:
        raise PlannercheckError("is a scene, not a robot")
    check_keys(content, _KEYS)
    folders = (example_robot_data(), path.parent)
    group, joints = _group(content.get("group"))
    return RobotDescription(
        name=text(content.get("name", path.stem), "name"),
        urdf=_resolve(text(required(content, "urdf"), "urdf"), folders),
        srdf=_resolve(text(content["srdf"], "srdf"), folders) if content.get("srdf") else None,
        package_dirs=(*_package_dirs(content, path.parent), example_robot_data()),
        floating=_switch(content.get("floating", False)),
        group=group,
        joints=joints,
        values={**mapping(content.get("reference"), "reference"), **mapping(content.get("held"), "held")},
        disabled_pairs=_disabled_pairs(content.get("disabled_pairs")),
        decomposition=_decomposition(content.get("convex_decomposition")),
        geometry=content.get("geometry"),
        mesh_units=content.get("mesh_units"),
        source=path,
        xacro_args={key: str(value) for key, value in mapping(content.get("xacro_args"), "xacro_args").items()},
    )


def _decomposition(value: Any) -> Decomposition | None:
    if value is None or value is False:
        return None
    with error_context("convex_decomposition"):
        options = {} if value is True else mapping(value, "it")
        check_keys(options, ("links", "threshold", "most_pieces", "slack", "seed", "time_limit"))
        links = [text(link, "links") for link in sequence(options.get("links"), "links")] or None
        sizes = {key: number(options[key], key) for key in ("threshold", "slack", "time_limit") if key in options}
        counts = {key: int(number(options[key], key)) for key in ("most_pieces", "seed") if key in options}
        return Decomposition(None if links is None else tuple(links), **sizes, **counts)  # type: ignore[arg-type]


def _resolve(name: str, folders: tuple[Path, Path]) -> Path:
    """A file beside the YAML, else in example-robot-data; errors name the first."""
    shared, beside = (folder / name for folder in folders)
    return shared if is_file(shared) and not is_file(beside) else beside


def _package_dirs(content: dict[str, Any], folder: Path) -> list[Path]:
    names = sequence(content.get("package_dirs"), "package_dirs")
    return [folder / text(name, "package_dirs") for name in names]


def _switch(value: Any) -> bool:
    if not isinstance(value, bool):
        raise PlannercheckError(f"'floating' must be true or false, not {value!r:.60}")
    return value


def _group(value: Any) -> tuple[str | None, tuple[str, ...] | None]:
    """The group's name, and its joints unless the SRDF gives them."""
    if value is None or isinstance(value, str):
        return value, None
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
