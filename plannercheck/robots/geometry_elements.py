"""Reads the <geometry> of a URDF's links: what shape each collision (or visual) element is.

In: a link's element. Out: one of our shapes, or a `MeshReference`. Numbers are read as urdfdom reads them. An element
that urdfdom drops or defaults is an error: a second shape, a text that is no number, a factor 0 in a mesh's scale.
<capsule> is read in any version of URDF (urdfdom reads it from 5.1 on): its length is the length of the cylinder
between the caps, as in SDF and in Bullet.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, TypeAlias
from xml.etree.ElementTree import Element

from plannercheck.bodies.shapes import Box, Capsule, Cylinder, Shape, Sphere
from plannercheck.common.checked_yaml import error_context
from plannercheck.common.errors import PlannercheckError, shortened

ElementKind: TypeAlias = Literal["collision", "visual"]

# A number as C++ streams read it; "nan" and "inf" are no sizes.
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?\Z", re.ASCII)

SHAPES = ("box", "cylinder", "sphere", "capsule", "mesh")


@dataclass(frozen=True)
class MeshReference:
    """A mesh as a URDF names it.

    Attributes:
        filename: The address: package://NAME/..., file:/..., or a path.
        scale: Factors along x, y and z.
    """

    filename: str
    scale: tuple[float, float, float]


GeometryElement: TypeAlias = Shape | MeshReference


def geometry_elements(root: Element, kind: ElementKind) -> Iterator[tuple[str, GeometryElement]]:
    """The shapes of all elements of a kind, with the names of their links, in the order of the file.

    Raises:
        PlannercheckError: If an element has no shape, several, one that URDFs do not have, or faulty numbers.
    """
    for link in root.iterfind("link"):
        name = link.get("name", "")
        capsules = {each.get("name") for each in link.iterfind("collision_checking/capsule")}
        for number, element in enumerate(link.iterfind(kind)):
            with error_context(f"{kind} element {number} of link {shortened(name)!r}"):
                yield name, _shape(element, element.get("name") in capsules)


def _shape(element: Element, is_capsule: bool) -> GeometryElement:
    """The shape of an element; Pinocchio takes cylinders that <collision_checking> names as capsules."""
    holders = element.findall("geometry")
    shapes = [each for holder in holders for each in holder if isinstance(each.tag, str)]
    if len(holders) != 1 or len(shapes) != 1:
        found = ", ".join(f"<{shortened(each.tag)}>" for each in shapes) or "none"
        raise PlannercheckError(
            f"needs one <geometry> with one shape, not {len(holders)} with {found}: "
            "give each shape a <collision> of its own"
        )
    shape = shapes[0]
    with error_context(f"<{shortened(shape.tag)}>"):
        return _SHAPES_BY_TAG[_known_tag(shape)](shape, is_capsule)


def _known_tag(shape: Element) -> str:
    if shape.tag in _SHAPES_BY_TAG:
        return str(shape.tag)
    raise PlannercheckError(f"is no shape that URDFs have: these are {', '.join(SHAPES)}")


def _box(shape: Element, _: bool) -> Shape:
    return Box(_three(shape, "size"))


def _cylinder(shape: Element, is_capsule: bool) -> Shape:
    return (Capsule if is_capsule else Cylinder)(_number(shape, "radius"), _number(shape, "length"))


def _sphere(shape: Element, _: bool) -> Shape:
    return Sphere(_number(shape, "radius"))


def _capsule(shape: Element, _: bool) -> Shape:
    return Capsule(_number(shape, "radius"), _number(shape, "length"))


def _mesh(shape: Element, _: bool) -> MeshReference:
    filename = shape.get("filename", "")
    if not filename.strip():
        raise PlannercheckError('has no filename="..."')
    scale = (1.0, 1.0, 1.0) if shape.get("scale") is None else _three(shape, "scale")
    if not all(scale):
        raise PlannercheckError(f"scale={shape.get('scale')!r} has a factor 0, which makes the mesh flat")
    return MeshReference(filename, scale)


_SHAPES_BY_TAG = dict(zip(SHAPES, (_box, _cylinder, _sphere, _capsule, _mesh), strict=True))


def _number(shape: Element, key: str) -> float:
    return _numbers(shape, key, 1)[0]


def _three(shape: Element, key: str) -> tuple[float, float, float]:
    x, y, z = _numbers(shape, key, 3)
    return x, y, z


def _numbers(shape: Element, key: str, count: int) -> list[float]:
    text = shape.get(key)
    words = [] if text is None else text.split()
    values = [float(word) for word in words if _NUMBER.match(word)]
    if len(words) != count or len(values) != count or not all(map(math.isfinite, values)):
        wanted = "a number" if count == 1 else f"{count} numbers"
        given = "is missing" if text is None else f"is {shortened(text)!r}"
        raise PlannercheckError(f"{key} {given}, it must be {wanted}")
    return values
