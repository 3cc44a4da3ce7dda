"""Reads a URDF through Pinocchio: the model, its collision bodies, the tree of links, and mimic joints.

In: a URDF (`urdf_file`) and folders of packages. Out: a Pinocchio model, one `GeometryObject` for each collision
geometry in Pinocchio's order, the tree of links, and the mimic joints. Pinocchio's model is the reference. Our errors
repeat what Pinocchio and urdfdom say about a file that they can't read.
"""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from plannercheck.bodies.given_shapes import sized_shape_of_coal
from plannercheck.bodies.mesh_files import check_mesh, mesh_hint
from plannercheck.bodies.shapes import GeometryObject, Hull, Shape
from plannercheck.common.checked_yaml import error_context
from plannercheck.common.errors import PlannercheckError, with_article
from plannercheck.common.package_data import is_file
from plannercheck.common.package_files import folders_above, package_file, where_sought
from plannercheck.common.silence import urdf_silence
from plannercheck.robots import mjcf
from plannercheck.robots.link_tree import LinkTree
from plannercheck.robots.urdf_file import MJCF_ROOT, SDF_ROOT, UrdfFile
from plannercheck.robots.urdf_hints import foreign_elements, wrong_order_of_imports

# coal builds bounds with every mesh; we want its vertices alone. These are the quickest that still show them.
_BOUNDS = coal.NODE_TYPE.BV_OBB


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another one: its value is multiplier * leader + offset.

    Attributes:
        leader: Name of the joint to follow.
        multiplier: Without unit, or in rad/m or m/rad.
        offset: In rad or m.
    """

    leader: str
    multiplier: float
    offset: float


def read_model(urdf: Path | UrdfFile, floating: bool = False) -> pin.Model:
    """Builds Pinocchio's model of a URDF.

    Args:
        urdf: The file, or its path.
        floating: Whether the root link is free to move (joint `root_joint`).

    Returns:
        The model, mimic joints as joints of their own.
    """
    file = _file(urdf)
    if file.kind == MJCF_ROOT:
        return mjcf.mjcf_model(file.path, file.root, floating)
    if file.kind == SDF_ROOT:
        raise PlannercheckError(
            f"robot {file.path} is an SDF file, which is not read: convert it into a URDF, for example by `ros2 run "
            "sdformat_tools sdf2urdf` (github.com/gezp/sdformat_tools)"
        )
    root = [pin.JointModelFreeFlyer()] if floating else []
    try:
        with urdf_silence()():
            if file.mended is None:
                model = pin.buildModelFromUrdf(str(file.path), *root)
            else:
                model = pin.buildModelFromXML(file.mended, *root)
    except (ValueError, RuntimeError, IndexError) as error:
        reason = file.hint or file.no_xml or foreign_elements(file.root) or wrong_order_of_imports()
        reason = reason or _one_line(file.messages(floating, ())) or _one_line(str(error))
        raise PlannercheckError(f"URDF {file.path} does not parse: {reason}") from None
    _check_names(model, file.path)
    _check_limits(model, file.path)
    return model


def _file(urdf: Path | UrdfFile) -> UrdfFile:
    return UrdfFile.read(urdf) if isinstance(urdf, Path) else urdf


def _check_names(model: pin.Model, urdf: Path) -> None:
    """Raises for names that are no UTF-8; comments may hold any bytes."""
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


def read_geometry(model: pin.Model, urdf: Path | UrdfFile, package_dirs: Sequence[Path]) -> pin.GeometryModel:
    """Loads a URDF's collision geometries with their meshes.

    Args:
        model: The model of the same URDF.
        urdf: The file, or its path.
        package_dirs: Folders in which `package://` paths start.

    Returns:
        Pinocchio's geometry model, without pairs.
    """
    file = _file(urdf)
    if file.kind == MJCF_ROOT:
        return mjcf.mjcf_geometry(model, file.path, file.root)
    # Also relative to the URDF, and to what lies above it: a package's folder often does.
    above = folders_above(file.path)
    folders = [str(folder) for folder in (*package_dirs, *above)]
    file = file.with_meshes(_meshes_elsewhere(file, package_dirs, above))
    try:
        geometry = built_geometry(model, file, pin.COLLISION, folders)
    except (ValueError, RuntimeError) as error:
        reason = _one_line(file.messages(False, folders), str(error).rpartition("message: ")[2])
        sought = f" {where_sought(package_dirs)}" if "could not be found" in reason else ""
        raise PlannercheckError(f"URDF {file.path}: a collision mesh does not load: {reason}{sought}") from None
    _check_complete(model, geometry, file, folders)
    _warn_if_empty(geometry, file)
    return geometry


def built_geometry(
    model: pin.Model, file: UrdfFile, kind: pin.GeometryType, folders: Sequence[str]
) -> pin.GeometryModel:
    """Pinocchio's geometries of one kind; raises ValueError or RuntimeError where it does."""
    loader = coal.CachedMeshLoader(_BOUNDS)
    with urdf_silence()():
        if file.mended is None:
            return pin.buildGeomFromUrdf(model, str(file.path), kind, None, folders, loader)
        return pin.buildGeomFromUrdfString(model, file.mended, kind, None, folders, loader)


def _meshes_elsewhere(file: UrdfFile, package_dirs: Sequence[Path], above: Sequence[Path]) -> dict[str, Path]:
    """The collision meshes that Pinocchio would not find by itself, by the names that the file gives them.

    Raises:
        PlannercheckError: For a file that is no mesh, or one that would crash its reader.
    """
    found: dict[str, Path] = {}
    for link in file.root.iterfind("link"):
        for mesh in link.iterfind("collision/geometry/mesh"):
            name = mesh.get("filename", "")
            plain = name.partition("://")[2] or name
            known = [each for folder in (Path(), *package_dirs, *above) if is_file(each := folder / plain)]
            path = None if known or not name else package_file(name, package_dirs, above)
            if path is not None:
                found[name] = path
            for each in known or ([] if path is None else [path]):
                with error_context(f"URDF {file.path}: link {link.get('name', '')!r}: collision mesh {str(each)!r}"):
                    check_mesh(each)
    return found


def _check_complete(model: pin.Model, geometry: pin.GeometryModel, file: UrdfFile, folders: Sequence[str]) -> None:
    """Raises if a collision element got lost: urdfdom drops elements that it does not support."""
    loaded = Counter(model.frames[each.parentFrame].name for each in geometry.geometryObjects)
    for link in file.root.findall("link"):
        name, wanted = link.get("name", ""), len(link.findall("collision"))
        if loaded[name] != wanted:
            if file.hint:
                raise PlannercheckError(f"URDF {file.path}: {file.hint}")
            raise PlannercheckError(
                f"URDF {file.path}: {loaded[name]} of {wanted} collision elements of link {name!r} could be read; "
                f"a URDF may hold box, cylinder, sphere and mesh; {_one_line(file.messages(False, folders))}"
            )


def _warn_if_empty(geometry: pin.GeometryModel, file: UrdfFile) -> None:
    if not len(geometry.geometryObjects):
        drawn = " (it has <visual> ones, which are only drawn)" if file.root.find("link/visual") is not None else ""
        warnings.warn(
            f"URDF {file.path} has no <collision> elements{drawn}: nothing will ever collide",
            RuntimeWarning,
            stacklevel=6,
        )


def bodies_of(model: pin.Model, geometry: pin.GeometryModel) -> tuple[GeometryObject, ...]:
    """One body for each collision geometry, in Pinocchio's order, posed on its link."""
    return tuple(_body_of(model, each) for each in geometry.geometryObjects)


def link_tree(model: pin.Model) -> LinkTree:
    """Links and the URDF joints between them, from Pinocchio's frames."""
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


def mimic_joints(urdf: Path | UrdfFile) -> dict[str, Mimic]:
    """The joints that a URDF lets follow others, by name; an MJCF file has none."""
    mimics: dict[str, Mimic] = {}
    for joint in _file(urdf).root.iter("joint"):
        tag = joint.find("mimic")
        if tag is not None:
            multiplier, offset = float(tag.get("multiplier", 1)), float(tag.get("offset", 0))
            mimics[joint.get("name", "")] = Mimic(tag.get("joint", ""), multiplier, offset)
    return mimics


def _body_of(model: pin.Model, geometry: pin.GeometryObject) -> GeometryObject:
    frame = model.frames[geometry.parentFrame]
    pose = frame.placement.actInv(geometry.placement).homogeneous
    with error_context(f"link {frame.name!r}"):
        return GeometryObject(geometry.name, frame.name, pose, _shape_of(geometry))


def _shape_of(geometry: pin.GeometryObject) -> Shape:
    """Our shape for one of coal's; a mesh comes with its scale applied."""
    return sized_shape_of_coal(geometry.geometry) or _hull_of(geometry)


def _hull_of(geometry: pin.GeometryObject) -> Hull:
    points = _points_of(geometry.geometry)
    if points is None:
        kind = type(geometry.geometry).__name__
        raise PlannercheckError(
            f"collision geometry {geometry.name!r} is {with_article(kind)}; "
            "known are boxes, spheres, ellipsoids, cylinders, capsules, cones and meshes"
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
    # One vertex alone comes as (3,).
    return np.array(shape.vertices(), dtype=np.float64).reshape(-1, 3) if hasattr(shape, "vertices") else None


def _one_line(*messages: str) -> str:
    """Messages without breaks."""
    return "; ".join(" ".join(message.split()) for message in messages if message.strip())
