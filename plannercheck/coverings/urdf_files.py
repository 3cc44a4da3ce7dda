"""Sphere models as URDFs, as foam writes and VAMP reads them: the collision elements of links are the primitives.

In: a URDF, or a robot's URDF and primitives by link. Out: `Primitives` by link, or the text of the URDF with them in
place of its collision elements. Spheres, capsules (see robots/geometry_elements.py) and boxes are primitives.
"""

from __future__ import annotations

import copy
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pinocchio as pin

from plannercheck.bodies.shapes import Box, Capsule, Sphere
from plannercheck.common.array_types import Floats
from plannercheck.common.checked_yaml import error_context
from plannercheck.common.errors import PlannercheckError, unknown_name
from plannercheck.coverings.primitives import Primitives
from plannercheck.robots.geometry_elements import GeometryElement, geometry_elements
from plannercheck.robots.urdf_checks import numbers
from plannercheck.robots.urdf_file import UrdfFile

SUFFIXES = (".urdf",)


def read(path: Path, link_names: Sequence[str]) -> dict[str, Primitives]:
    """Reads a model; arguments and errors as of `curobo_files.read`."""
    root = UrdfFile.read(path).root
    origins = [element.find("origin") for link in root.iterfind("link") for element in link.iterfind("collision")]
    found: dict[str, Primitives] = {}
    for (link, shape), origin in zip(geometry_elements(root, "collision"), origins, strict=True):
        if link not in link_names:
            raise unknown_name("link", link, link_names)
        with error_context(f"link {link!r}"):
            found[link] = found.get(link, Primitives.of()) + _primitive(shape, _pose(origin))
    return found


def _pose(origin: ElementTree.Element | None) -> Floats:
    pose = np.eye(4)
    if origin is not None:
        if origin.get("quat_xyzw") is not None:
            raise PlannercheckError("a sphere model has its origins as xyz and rpy, not as quat_xyzw")
        pose[:3, 3] = numbers(origin.get("xyz", "0 0 0"), 3, "xyz of <origin>")
        pose[:3, :3] = pin.rpy.rpyToMatrix(np.array(numbers(origin.get("rpy", "0 0 0"), 3, "rpy of <origin>")))
    return pose


def _primitive(shape: GeometryElement, pose: Floats) -> Primitives:
    if isinstance(shape, Sphere):
        return Primitives.of(spheres=[(pose[:3, 3].tolist(), shape.radius)])
    if isinstance(shape, Capsule):
        low, high = (pose[:3, 3] + pose[:3, 2] * z for z in (-shape.length / 2, shape.length / 2))
        return Primitives.of(capsules=[(low.tolist(), high.tolist(), shape.radius)])
    if isinstance(shape, Box):
        return Primitives.of(boxes=[(pose, shape.size)])
    kind = type(shape).__name__.removesuffix("Reference").lower()
    raise PlannercheckError(f"has a {kind}, but a model has spheres, capsules and boxes: is it the robot's own URDF?")


def model_text(covers: Mapping[str, Primitives], source: UrdfFile) -> str:
    """A robot's URDF with primitives, by link, in place of all collision elements."""
    root = copy.deepcopy(source.root)
    for link in root.iterfind("link"):
        for element in link.findall("collision"):
            link.remove(element)
        cover = covers.get(link.get("name", ""), Primitives.of())
        for (a, b), radius in zip(cover.ends, cover.radii.tolist(), strict=True):
            _append_rounded(link, a, b, radius)
        for frame, half in zip(cover.frames, cover.halves, strict=True):
            _append(link, frame, "box", size=_words(2 * half))
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"


def _append_rounded(link: ElementTree.Element, a: Floats, b: Floats, radius: float) -> None:
    pose = np.eye(4)
    pose[:3, 3] = (a + b) / 2 if (a != b).any() else a
    length = float(np.linalg.norm(b - a))
    if not length:
        _append(link, pose, "sphere", radius=repr(radius))
        return
    pose[:3, :3] = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), (b - a) / length).matrix()
    _append(link, pose, "capsule", radius=repr(radius), length=repr(length))


def _append(link: ElementTree.Element, pose: Floats, tag: str, **sizes: str) -> None:
    element = ElementTree.SubElement(link, "collision")
    rpy = pin.rpy.matrixToRpy(pose[:3, :3])
    ElementTree.SubElement(element, "origin", xyz=_words(pose[:3, 3]), rpy=_words(rpy))
    ElementTree.SubElement(ElementTree.SubElement(element, "geometry"), tag, sizes)


def _words(values: Floats) -> str:
    return " ".join(repr(value + 0.0) for value in values.tolist())
