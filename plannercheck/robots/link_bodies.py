"""The collision bodies of a URDF's links.

In: a URDF and Pinocchio's model of it. Out: `LinkBodies`: a body for each <collision>, named, ordered and posed as
Pinocchio does, with the shape that the file gives. Pinocchio gets the URDF with balls in place of all shapes, so that
it reads no mesh: those are read here, in doubles, by `read_mesh`.
"""

from __future__ import annotations

from collections import Counter, defaultdict, deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from plannercheck.bodies.hull_excess import excess_words
from plannercheck.bodies.mesh_files import MeshFile, MeshUnits, mesh_hint, read_mesh
from plannercheck.bodies.shapes import GeometryObject, Hull, Shape
from plannercheck.common.checked_yaml import error_context
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.package_files import address_hint, folders_above, package_file, where_sought
from plannercheck.common.silence import urdf_silence
from plannercheck.common.user_warnings import warn
from plannercheck.robots.geometry_elements import ElementKind, GeometryElement, MeshReference, geometry_elements
from plannercheck.robots.urdf_file import UrdfFile


@dataclass(frozen=True, eq=False)
class LinkBodies:
    """The bodies of a robot's links.

    Attributes:
        bodies: One for each <collision>, in Pinocchio's order; meshes are their hulls.
        joints: (n,) Pinocchio's joint that moves each body.
        meshes: The mesh of each body; None for other shapes.
    """

    bodies: tuple[GeometryObject, ...]
    joints: NDArray[np.int64]
    meshes: tuple[MeshFile | None, ...]


def read_bodies(
    model: pin.Model,
    file: UrdfFile,
    package_dirs: Sequence[Path],
    units: MeshUnits | None = None,
    kind: ElementKind = "collision",
) -> LinkBodies:
    """Reads the "collision" or "visual" shapes of a URDF's links, on the joints of its model.

    `package_dirs` are where `package://` paths start; `units` as for `Robot.load`.

    Raises:
        PlannercheckError: If an element or its mesh can't be read.
    """
    with error_context(f"URDF {file.path}"):
        shapes = _shapes_by_link(file, kind)
        placed = list(_placements(model, file, kind))
        _check_complete(shapes, [link for _, _, link, _ in placed])
        meshes = _Meshes(file, package_dirs, units)
        bodies, found = [], []
        for name, pose, link, _ in placed:
            with error_context(f"link {link!r}"):
                shape, mesh = meshes.shape(shapes[link].popleft(), name)
                bodies.append(GeometryObject(name, link, pose, shape))
                found.append(mesh)
    meshes.warn()
    if kind == "collision" and not bodies:
        drawn = " (it has <visual> ones, which are only drawn)" if file.root.find("link/visual") is not None else ""
        warn(f"URDF {file.path} has no <collision> elements{drawn}: nothing will ever collide")
    joints = np.array([joint for _, _, _, joint in placed], dtype=np.int64)
    return LinkBodies(tuple(bodies), joints, tuple(found))


def _shapes_by_link(file: UrdfFile, kind: ElementKind) -> dict[str, deque[GeometryElement]]:
    """The shapes of each link's elements, in order."""
    shapes = defaultdict[str, deque[GeometryElement]](deque)
    try:
        for link, element in geometry_elements(file.root, kind):
            shapes[link].append(element)
    except PlannercheckError as error:
        raise PlannercheckError(file.hint or str(error)) from None
    return shapes


def _placements(
    model: pin.Model, file: UrdfFile, kind: ElementKind
) -> Iterator[tuple[str, NDArray[np.float64], str, int]]:
    """For each element: Pinocchio's name, its pose (4, 4) on its link, the link, and the joint that moves it."""
    pinocchio_kind = pin.COLLISION if kind == "collision" else pin.VISUAL
    with urdf_silence()():
        geometry = pin.buildGeomFromUrdfString(model, file.text_with(kind), pinocchio_kind)
    for each in geometry.geometryObjects:
        frame = model.frames[each.parentFrame]
        yield each.name, frame.placement.actInv(each.placement).homogeneous, frame.name, each.parentJoint


def _check_complete(shapes: Mapping[str, deque[GeometryElement]], placed: list[str]) -> None:
    """Raises if an element got lost: urdfdom drops elements whose origin it can't read."""
    counts = Counter(placed)
    for link, given in shapes.items():
        if counts[link] != len(given):
            raise PlannercheckError(
                f"link {link!r}: {counts[link]} of {len(given)} elements could be placed: each <origin> needs "
                "xyz and rpy of three numbers"
            )


class _Meshes:
    """The meshes of one URDF, each read once, and what there is to warn of."""

    def __init__(self, file: UrdfFile, package_dirs: Sequence[Path], units: MeshUnits | None) -> None:
        self._file, self._package_dirs, self._units = file, package_dirs, units
        self._above = folders_above(file.path)
        self._known: dict[MeshReference, MeshFile] = {}
        self._hulls: dict[MeshReference, Hull] = {}

    def shape(self, element: GeometryElement, name: str) -> tuple[Shape, MeshFile | None]:
        """The shape of an element, and its mesh if it is one."""
        if not isinstance(element, MeshReference):
            return element, None
        if element not in self._known:
            mesh = read_mesh(self._path(element), element.scale, self._units or "metre")
            with error_context(f"mesh file {str(mesh.path)!r}"):
                self._hulls[element] = Hull(mesh.points)
            self._known[element] = mesh
        return self._hulls[element], self._known[element]

    def _path(self, element: MeshReference) -> Path:
        path = package_file(element.filename, self._package_dirs, self._above)
        if path is None:
            hint, where = address_hint(element.filename), where_sought(self._package_dirs)
            raise PlannercheckError(f"mesh {element.filename} could not be found{hint}. {where}")
        return path

    def warn(self) -> None:
        """Warns of meshes that are unusually large, and of those whose format has another unit or other axes."""
        for mesh in self._known.values():
            hint = mesh_hint(mesh.points)
            if hint:
                warn(f"collision mesh {str(mesh.path)!r} {hint} (scale= in the URDF)")
        converted = [mesh for mesh in self._known.values() if mesh.conversion]
        if converted and self._units is None:
            first, more = converted[0], f" (and {len(converted) - 1} more)" if len(converted) > 1 else ""
            warn(
                f"URDF {self._file.path}: mesh {str(first.path)!r}{more} is read as MoveIt's planning scene reads it, "
                f'in metres, its axes as they stand, although {first.conversion}: mesh_units="metre" '
                '(--mesh-units metre) says that this is meant, mesh_units="file" converts as the file says'
            )


def warn_of_large_hulls(path: Path, links: LinkBodies) -> None:
    """Warns of meshes whose hulls are much larger than they are, where hulls were taken by default."""
    distinct = {id(mesh): (body, mesh) for body, mesh in zip(links.bodies, links.meshes, strict=True) if mesh}
    found = [(body.link, words) for body, mesh in distinct.values() if (words := excess_words(mesh))]
    if found:
        link, words = found[0]
        others = len(found) - 1
        more = f", and {others} more link{'s' if others > 1 else ''}" if others else ""
        warn(
            f'URDF {path}: mesh of link {link!r}: {words}{more}: geometry="solid" (--geometry solid) takes meshes as '
            'they are, "pieces" splits them, "hull" says that hulls are meant; plannercheck inspect lists all'
        )
