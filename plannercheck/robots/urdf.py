"""Reads a URDF through Pinocchio: the model, its collision bodies, and what Pinocchio keeps to itself.

In: paths. Out: a Pinocchio model, `Body` by `Body` in Pinocchio's geometry order, the tree of links, and
which joint mimics which. The idea: Pinocchio is the model and the truth; what it and urdfdom say about a file that
they can't read stands in our errors, too.
"""

from __future__ import annotations

import re
import warnings
import xml.etree.ElementTree as ElementTree
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from plannercheck.bodies.meshes import check_mesh, mesh_hint
from plannercheck.bodies.shapes import Body, Box, Capsule, Cone, Cylinder, Hull, Shape, Sphere
from plannercheck.common.checked_yaml import within
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.input_limits import check_xml
from plannercheck.common.package_data import is_file
from plannercheck.common.silence import urdf_silence
from plannercheck.robots.urdf_messages import native_messages
from plannercheck.robots.xacro import xacro_hint

# Names of mesh files in a URDF that are looked at before they are read.
_MESH = re.compile(rb"""filename\s*=\s*["']([^"']+\.ply)["']""", re.IGNORECASE)

# coal builds bounds with every mesh; we want its vertices alone. These are the quickest that still show them.
_BOUNDS = coal.NODE_TYPE.BV_OBB


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another one: its value is multiplier * leader + offset.

    Attributes:
        leader: Name of the joint to follow.
        multiplier: Without unit, or rad/m and the like.
        offset: In rad or m.
    """

    leader: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class LinkTree:
    """How links hang together.

    Attributes:
        names: The URDF's links in the order of Pinocchio's body frames.
        frames: Pinocchio's frame of each link.
        parents: For each link that has one, its parent link.
        joints: For each link that has one, the URDF joint to its parent, fixed ones included.
    """

    names: tuple[str, ...]
    frames: tuple[int, ...]
    parents: dict[str, str]
    joints: dict[str, str]


def read_model(urdf: Path, floating: bool = False) -> pin.Model:
    """Builds Pinocchio's model of a URDF.

    Args:
        urdf: Path of the file.
        floating: Whether the root link is free to move (joint `root_joint`).

    Returns:
        The model, mimic joints as joints of their own.
    """
    if not is_file(urdf):
        raise PlannercheckError(f"URDF {urdf} does not exist")
    check_xml(urdf, "URDF")
    try:
        with urdf_silence()():
            model = pin.buildModelFromUrdf(str(urdf), *([pin.JointModelFreeFlyer()] if floating else []))
    except (ValueError, RuntimeError, IndexError) as error:
        reason = xacro_hint(urdf) or _one_line(native_messages(urdf, floating, ()), str(error))
        raise PlannercheckError(f"URDF {urdf} does not parse: {reason}") from None
    _check_names(model, urdf)
    _check_limits(model, urdf)
    return model


def _check_names(model: pin.Model, urdf: Path) -> None:
    """Raises for names that are no UTF-8; other bytes may stand in comments."""
    try:
        _ = [*model.names, *(frame.name for frame in model.frames)]
    except UnicodeDecodeError as error:
        raise PlannercheckError(f"URDF {urdf}: the name of a link or joint is not UTF-8: {error.object!r}") from None


def _check_limits(model: pin.Model, urdf: Path) -> None:
    for name, joint in zip(model.names[1:], list(model.joints)[1:], strict=True):
        entries = slice(joint.idx_q, joint.idx_q + joint.nq)
        lower, upper = model.lowerPositionLimit[entries], model.upperPositionLimit[entries]
        if not (lower <= upper).all():
            raise PlannercheckError(
                f"URDF {urdf}: joint {name!r} has a lower limit {lower.tolist()} above its upper one {upper.tolist()}"
            )


def read_geometry(model: pin.Model, urdf: Path, package_dirs: Sequence[Path]) -> pin.GeometryModel:
    """Loads a URDF's collision geometries with their meshes.

    Args:
        model: The model of the same URDF.
        urdf: Path of the file.
        package_dirs: Folders in which `package://` paths start.

    Returns:
        Pinocchio's geometry model, without pairs.
    """
    # Also relative to the URDF, and to what lies above it: a package's folder often does.
    folders = [str(folder) for folder in (*package_dirs, *urdf.resolve().parents)]
    _check_meshes(urdf, folders)
    try:
        loader = coal.CachedMeshLoader(_BOUNDS)
        with urdf_silence()():
            geometry = pin.buildGeomFromUrdf(model, str(urdf), pin.COLLISION, package_dirs=folders, mesh_loader=loader)
    except (ValueError, RuntimeError) as error:
        reason = _one_line(native_messages(urdf, False, folders), str(error))
        raise PlannercheckError(
            f"URDF {urdf}: a collision mesh does not load: {reason}{_where_sought(reason, package_dirs)}"
        ) from None
    _check_complete(model, geometry, urdf, folders)
    _warn_if_empty(geometry, urdf)
    return geometry


def _check_meshes(urdf: Path, folders: Sequence[str]) -> None:
    """Raises for meshes that would crash who reads them, wherever they may be found."""
    for given in dict.fromkeys(_MESH.findall(urdf.read_bytes())):
        name = given.decode("utf-8", "replace")
        for found in (Path(name), *(Path(folder) / (name.partition("://")[2] or name) for folder in folders)):
            if is_file(found):
                with within(f"URDF {urdf}: collision mesh {str(found)!r}"):
                    check_mesh(found)


def _where_sought(reason: str, package_dirs: Sequence[Path]) -> str:
    """What to do about a mesh that was not found; empty if it was."""
    if "could not be found" not in reason:
        return ""
    return (
        " Searched were the folders above the URDF and package_dirs "
        f"({', '.join(map(str, package_dirs)) or 'none given'}): package://NAME/... needs the folder that contains "
        "NAME, from package_dirs= or the robot YAML's package_dirs"
    )


def _check_complete(model: pin.Model, geometry: pin.GeometryModel, urdf: Path, folders: Sequence[str]) -> None:
    """Raises if a collision element got lost: urdfdom drops those that it does not know."""
    loaded = Counter(model.frames[each.parentFrame].name for each in geometry.geometryObjects)
    for link in _root(urdf).findall("link"):
        name, wanted = link.get("name", ""), len(link.findall("collision"))
        if loaded[name] != wanted:
            if xacro_hint(urdf):
                raise PlannercheckError(f"URDF {urdf}: {xacro_hint(urdf)}")
            raise PlannercheckError(
                f"URDF {urdf}: {loaded[name]} of {wanted} collision elements of link {name!r} could be read; "
                f"a URDF may hold box, cylinder, sphere and mesh; {_one_line(native_messages(urdf, False, folders))}"
            )


def _warn_if_empty(geometry: pin.GeometryModel, urdf: Path) -> None:
    if not len(geometry.geometryObjects):
        drawn = " (it has <visual> ones, which are only drawn)" if _root(urdf).find("link/visual") is not None else ""
        warnings.warn(
            f"URDF {urdf} has no <collision> elements{drawn}: nothing will ever collide", RuntimeWarning, stacklevel=6
        )


def bodies_of(model: pin.Model, geometry: pin.GeometryModel) -> tuple[Body, ...]:
    """One body a collision geometry, in Pinocchio's order, posed on its link."""
    return tuple(_body_of(model, each) for each in geometry.geometryObjects)


def link_tree(model: pin.Model) -> LinkTree:
    """Links and the URDF joints between them, as Pinocchio's frames tell."""
    frames = list(model.frames)
    ids = tuple(i for i, frame in enumerate(frames) if frame.type == pin.FrameType.BODY)
    parents: dict[str, str] = {}
    joints: dict[str, str] = {}
    for frame in (frames[i] for i in ids):
        joint = frames[frame.parentFrame]
        above = frames[joint.parentFrame]
        if above.type == pin.FrameType.BODY and joint.type != pin.FrameType.BODY:
            parents[frame.name] = above.name
        joints[frame.name] = joint.name
    return LinkTree(tuple(frames[i].name for i in ids), ids, parents, joints)


def mimic_joints(urdf: Path) -> dict[str, Mimic]:
    """The joints that a URDF lets follow others, by name."""
    mimics = {}
    for joint in _root(urdf).iter("joint"):
        tag = joint.find("mimic")
        if tag is not None:
            multiplier, offset = float(tag.get("multiplier", 1)), float(tag.get("offset", 0))
            mimics[joint.get("name", "")] = Mimic(tag.get("joint", ""), multiplier, offset)
    return mimics


def _body_of(model: pin.Model, geometry: pin.GeometryObject) -> Body:
    frame = model.frames[geometry.parentFrame]
    pose = frame.placement.actInv(geometry.placement).homogeneous
    return Body(geometry.name, frame.name, pose, _shape_of(geometry))


def _shape_of(geometry: pin.GeometryObject) -> Shape:
    """Our shape for one of coal's; a mesh comes with its scale applied."""
    shape: Any = geometry.geometry
    match shape:
        case coal.Box():
            x, y, z = (2.0 * np.asarray(shape.halfSide)).tolist()
            return Box((x, y, z))
        case coal.Sphere():
            return Sphere(shape.radius)
        case coal.Cylinder():
            return Cylinder(shape.radius, 2.0 * shape.halfLength)
        case coal.Capsule():
            return Capsule(shape.radius, 2.0 * shape.halfLength)
        case coal.Cone():
            return Cone(shape.radius, 2.0 * shape.halfLength)
    return _hull_of(geometry)


def _hull_of(geometry: pin.GeometryObject) -> Hull:
    points = _points_of(geometry.geometry)
    if points is None:
        kind = type(geometry.geometry).__name__
        raise PlannercheckError(
            f"collision geometry {geometry.name!r} is a {kind}; "
            "known are boxes, spheres, cylinders, capsules, cones and meshes"
        )
    try:
        hull = Hull(points)
    except PlannercheckError as error:
        raise PlannercheckError(f"collision geometry {geometry.name!r} ({geometry.meshPath}): {error}") from None
    hint = mesh_hint(points)
    if hint:
        warnings.warn(f"collision mesh {geometry.meshPath!r} {hint} (scale= in the URDF)", RuntimeWarning, stacklevel=7)
    return hull


def _points_of(shape: Any) -> NDArray[np.float64] | None:
    """Vertices (n, 3) in m of coal's meshes and convex polytopes, else None."""
    if isinstance(shape, coal.ConvexBase):
        return np.asarray(shape.points(), dtype=np.float64)
    return np.array(shape.vertices(), dtype=np.float64) if hasattr(shape, "vertices") else None


def _root(urdf: Path) -> ElementTree.Element:
    """The XML's root; urdfdom reads some files that are no XML."""
    try:
        return ElementTree.parse(urdf).getroot()
    except (ElementTree.ParseError, LookupError, ValueError) as error:  # the last two for encodings
        raise PlannercheckError(f"URDF {urdf} is not well-formed XML: {error}") from None


def _one_line(*messages: str) -> str:
    return "; ".join(" ".join(message.split()) for message in messages if message.strip())
