"""Compares the bodies in a proof with a URDF's <collision> elements and their meshes, read by the verifier itself.

In: a model, the URDF's text, where its meshes are. Out: sentences: what was compared, and what was not and why; or an
`UnprovedError` that names the first difference. It shares no function with `plannercheck.robots` and
`plannercheck.bodies`, so that a fault in loading can't confirm itself. Compared are, to the last bit:

- a box's corners, a sphere's centre and radius, a capsule's ends and radius: the nearest doubles to the file's numbers,
  or their halves;
- of a mesh as its hull: that each vertex is one of the file, and that no point of the file's triangles is outside of
  the vertices' hull (`hull_containment.py`);
- of a mesh as a solid: that each of the file's triangles is one of the body's, all as given or all turned over;
- of a cylinder, of which the proof has a polytope around it: that its ends are at half the length, and that no edge of
  them comes nearer to the axis than the radius.

A number of a mesh is the nearest double to the file's number, times the nearest double to that of the scale, rounded:
three roundings, so that it is within 3 units in the last place of the exact product, and the nearest double to the
file's number where the scale is 1 or a power of two. A body's pose on its link is as far from the exact <origin> as
`Placement.allowance` permits. Larger bodies than the file's are taken where the comparison with what plannercheck loads
decides.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.proofs.data import WORLD, Model, PosedBody
from plannercheck.proofs.exact_placements import decimals, enough_digits, off_placement, origin_of
from plannercheck.proofs.faults import UnprovedError
from plannercheck.proofs.hull_containment import FlatError, point_outside
from plannercheck.proofs.mesh_triangles import NotReadError, mesh_triangles

# A radius is what is left of itself and the padding, whose sum is rounded.
_RADIUS_ROUNDING = 2.0**-51


@dataclass(frozen=True)
class MeshFiles:
    """Where a URDF's meshes are, and how they are read.

    Attributes:
        urdf: The URDF's path.
        find: The file of an address; None if there is none.
        as_metres: Whether their numbers are metres, whatever their format says.
    """

    urdf: str
    find: Callable[[str], Path | None]
    as_metres: bool


@enough_digits()
def confirm_shapes(model: Model, content: str | None, files: MeshFiles, prefix: str = "") -> tuple[str, ...]:
    """Compares the bodies on links with a URDF.

    Args:
        model: The well-formed model of a proof.
        content: What to read in place of the file: what a xacro expands to.
        files: The URDF, and where its meshes are.
        prefix: What names of the robot's links begin with in a model of several robots; others are not compared.

    Returns:
        What was compared, and what was not.

    Raises:
        UnprovedError: If a body differs from its element.
    """
    root = ElementTree.parse(files.urdf).getroot() if content is None else ElementTree.fromstring(content)
    links = {f"{prefix}{link.get('name')}": link for link in root.findall("link")}
    elements = {
        f"{name}_{k}": (name, each) for name, link in links.items() for k, each in enumerate(link.findall("collision"))
    }
    on_links = [body for body in model.bodies if body.link != WORLD and _link(model, body).startswith(prefix)]
    same, not_read, unknown, most = list[str](), dict[str, list[str]](), list[str](), 0.0
    for body in on_links:
        if body.name not in elements:
            unknown.append(body.name)
            continue
        link, element = elements[body.name]
        if _link(model, body) != link:
            raise UnprovedError(f"body {body.name!r} is on link {_link(model, body)!r}, not on its own")
        most = max(most, _check_pose(body, element))
        try:
            _check_shape(body, element, files)
        except NotReadError as why:
            not_read.setdefault(str(why), []).append(body.name)
        else:
            same.append(body.name)
    unpaired = sorted(set(elements) - {body.name for body in on_links})
    return tuple(_sentences(files.urdf, same, most, not_read, unknown, unpaired))


def _link(model: Model, body: PosedBody) -> str:
    return model.links[body.link].name


def _sentences(
    urdf: str, same: list[str], most: float, not_read: dict[str, list[str]], unknown: list[str], unpaired: list[str]
) -> Iterable[str]:
    if same:
        yield (
            f"shapes of {len(same)} bodies on links, to the last bit, with {urdf!r} and its meshes, read by itself; "
            f"their poses are {f'at most {most:.2g} away from ' if most else ''}the exact ones"
        )
    for why, names in not_read.items():
        yield f"not read by the verifier itself: {_listed(names)}: {why}"
    if unknown:
        yield f"not of the URDF's own elements, so not read by the verifier itself: {_listed(unknown)}"
    if unpaired:
        yield f"in no pair, so not in the proof: {_listed(unpaired)}"


def _listed(names: list[str]) -> str:
    return ", ".join(map(repr, names[:5])) + (f" and {len(names) - 5} more" if len(names) > 5 else "")


def _check_pose(body: PosedBody, element: Element) -> float:
    """How far a pose is from the exact one."""
    exact = origin_of(element)
    off = off_placement(body.pose, exact)
    if not off <= exact.allowance:
        raise UnprovedError(
            f"body {body.name!r} is not where the URDF has it: off by {off:.3g}, where rounding explains "
            f"{exact.allowance:.3g}"
        )
    return off


def _check_shape(body: PosedBody, element: Element, files: MeshFiles) -> None:
    shapes = element.findall("geometry/*")
    if len(shapes) != 1:
        raise NotReadError(f"the element has {len(shapes)} shapes")
    shape, own = shapes[0], body.radius - body.padding
    if body.parts or body.half_space:
        raise UnprovedError(f"body {body.name!r} is no body of a URDF")
    radius = 0.0
    if shape.tag == "mesh":
        _check_mesh(body, shape, files)
    elif body.triangles:
        raise UnprovedError(f"body {body.name!r} is a solid, in the URDF a {shape.tag}")
    elif shape.tag == "box":
        half = np.array(_numbers(shape, "size", 3)) / 2
        signs = np.arange(8)[:, None] >> np.arange(3) & 1
        _check_same(body, np.where(signs, half, -half))
    elif shape.tag == "sphere":
        (radius,) = _numbers(shape, "radius", 1)
        _check_same(body, np.zeros((1, 3)))
    elif shape.tag in ("cylinder", "capsule"):
        (wide,), (length,) = _numbers(shape, "radius", 1), _numbers(shape, "length", 1)
        ends = np.array([[0, 0, -length / 2], [0, 0, length / 2]])
        if shape.tag == "capsule" or len(body.vertices) == len(
            ends
        ):  # cylinders that the URDF calls capsules elsewhere
            radius = wide
            _check_same(body, ends)
        else:
            _check_cylinder(body, wide, length)
    else:
        raise NotReadError(f"the verifier reads no <{shape.tag}>")
    if not abs(own - radius) <= _RADIUS_ROUNDING * body.radius:
        raise UnprovedError(f"body {body.name!r} has the radius {own!r} m, in the URDF {radius!r}")


def _numbers(shape: Element, key: str, count: int) -> list[float]:
    """The nearest doubles to the numbers of an attribute."""
    try:
        return [float(number) for number in decimals(shape.get(key), count, f"{key} of <{shape.tag}>")]
    except ValueError as error:
        raise NotReadError(str(error)) from None


def _rows(points: Floats) -> set[tuple[float, ...]]:
    return {tuple(row) for row in (points.reshape(-1, 3) + 0.0).tolist()}  # -0 is 0


def _check_same(body: PosedBody, points: Floats) -> None:
    if _rows(body.vertices) != _rows(points):
        raise UnprovedError(f"body {body.name!r} has other vertices than in the URDF")


def _check_cylinder(body: PosedBody, radius: float, length: float) -> None:
    """Raises an `UnprovedError` unless a prism holds a cylinder; lengths are compared squared, as fractions."""
    rows = body.vertices.tolist()
    top, bottom = (sorted((x, y) for x, y, z in rows if z == end) for end in (length / 2, -length / 2))
    if top != bottom or 2 * len(top) != len(rows) or len(top) < 3:
        raise UnprovedError(f"body {body.name!r} is no prism of the cylinder's length")
    ring = sorted(((Fraction(x), Fraction(y)) for x, y in top), key=lambda p: math.atan2(p[1], p[0]))
    for (ax, ay), (bx, by) in zip(ring, [*ring[1:], ring[0]], strict=True):
        twice = ax * by - ay * bx
        if not (twice > 0 and twice**2 >= Fraction(radius) ** 2 * ((bx - ax) ** 2 + (by - ay) ** 2)):
            raise UnprovedError(f"body {body.name!r} does not hold the cylinder of the URDF")


def _check_mesh(body: PosedBody, shape: Element, files: MeshFiles) -> None:
    address = shape.get("filename", "")
    path = files.find(address)
    if path is None:
        raise PlannercheckError(f"URDF {files.urdf!r}: mesh {address!r} of body {body.name!r} is not found")
    if path.suffix.lower() == ".dae" and not files.as_metres:
        raise NotReadError("the verifier reads Collada only with mesh_units 'metre'")
    scale = [1.0] * 3 if shape.get("scale") is None else _numbers(shape, "scale", 3)
    triangles = mesh_triangles(path) * np.array(scale)
    if body.triangles:
        _check_triangles(body, triangles, path)
    else:
        _check_hull(body, triangles, path)


def _check_hull(body: PosedBody, triangles: Floats, path: Path) -> None:
    points = np.array(sorted(_rows(triangles)))
    if not _rows(body.vertices) <= _rows(points):
        raise UnprovedError(f"body {body.name!r} has a vertex that {str(path)!r} does not have")
    try:
        outside = point_outside(body.vertices, points)
    except FlatError:
        raise NotReadError("the mesh is flat") from None
    if outside is not None:
        raise UnprovedError(f"body {body.name!r} leaves out the point {points[outside].tolist()} of {str(path)!r}")


def _check_triangles(body: PosedBody, triangles: Floats, path: Path) -> None:
    own = _turned_to_least((body.vertices + 0.0)[np.array(body.triangles)].tolist())
    given = (triangles + 0.0).tolist()
    proper = [each for each in given if len(set(map(tuple, each))) == 3]
    for one in (proper, [each[::-1] for each in proper]):
        if _turned_to_least(one) <= own:
            return
    raise UnprovedError(f"body {body.name!r} lacks triangles of {str(path)!r}")


def _turned_to_least(triangles: Any) -> set[tuple[Any, ...]]:
    """Triangles that begin with their least corner: the same one written otherwise is the same."""
    out = set()
    for each in triangles:
        a, b, c = map(tuple, each)
        out.add(min((a, b, c), (b, c, a), (c, a, b)))
    return out
