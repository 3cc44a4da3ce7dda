"""Collada files (1.4 and 1.5): the instances of geometries in the visual scene that the file names.

In: the content. Out: one object for each instance, posed by its nodes, in the file's numbers; and what the file says of
its unit and axes. Skeletons, links to other files, polygons with holes, curved surfaces and `<skew>` are refused.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from typing import TypeAlias
from xml.etree.ElementTree import Element

import numpy as np

from plannercheck.bodies.collada_geometries import Geometry, children, geometry_of, id_of, tag
from plannercheck.bodies.mesh_objects import RawObject
from plannercheck.bodies.mesh_poses import composed, facing_as_before, transformed
from plannercheck.bodies.text_numbers import floats_of
from plannercheck.common.array_types import Floats
from plannercheck.common.errors import PlannercheckError, shortened

# A file's elements by kind and id: elements of different kinds may share an id in files that are met.
Named: TypeAlias = dict[tuple[str, str], list[Element]]

# Most nodes and instances: a few instances of instances would fill any memory.
_MOST_NODES = 100_000

# Most nodes inside of each other.
_DEEPEST = 500

# Numbers of each transform.
_TRANSFORMS = {"matrix": 16, "translate": 3, "rotate": 4, "scale": 3, "lookat": 9}

# What else a node may hold, and says nothing about surfaces.
_OTHERS = ("asset", "node", "extra", "instance_camera", "instance_light", "evaluate_scene")

# From a file's axes to z up. Collada names the axes to the right, up and towards the viewer (specification 1.4.1,
# <up_axis>): Y_UP is x, y, z; X_UP is -y, x, z; Z_UP is x, z, -y.
_TURNS = {
    "Z_UP": np.eye(3),
    "Y_UP": np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]),
    "X_UP": np.array([[0.0, -1, 0], [0, 0, -1], [1, 0, 0]]),
}
_DEFAULT_AXIS = "Y_UP"


@dataclass(frozen=True)
class ColladaAxes:
    """A file's unit, in m, and the axis that is up in it."""

    unit_name: str = "meter"
    metres: float = 1.0
    up: str = _DEFAULT_AXIS

    @property
    def turn(self) -> Floats:
        """(3, 3) from the file's axes to z up."""
        return _TURNS[self.up]

    @property
    def words(self) -> str:
        """How metres with z up differ from the file; empty if they don't."""
        unit = f"its <unit> is {shortened(self.unit_name)} ({self.metres:.9g} m)" if self.metres != 1 else ""
        axis = f"its up_axis {'is ' if not unit else ''}{self.up}" if self.up != "Z_UP" else ""
        return " and ".join(part for part in (unit, axis) if part)


def objects_of_collada(content: bytes) -> tuple[list[RawObject], ColladaAxes]:
    """The instances of a file's scene, and its axes.

    Raises:
        PlannercheckError: If the file is no Collada file, or has what is not read.
    """
    root = _root(content)
    axes = _axes(root)
    known: Named = {}
    for each in filter(id_of, root.iter()):
        known.setdefault((tag(each), id_of(each)), []).append(each)
    scene = _scene(root, known)
    geometries: dict[str, Geometry] = {}
    found, count = [], 0
    for each in scene:
        if tag(each) and tag(each) not in _OTHERS:
            raise PlannercheckError(f"{_named(scene)} has <{shortened(tag(each))}>, which Collada does not have there")
    stack: list[tuple[Element, Floats, tuple[int, ...]]]
    stack = [(node, np.eye(4), (id(node),)) for node in reversed(children(scene, "node"))]
    while stack:
        node, outer, path = stack.pop()
        count += 1
        if count > _MOST_NODES or len(path) > _DEEPEST:
            raise PlannercheckError(
                f"has more than {_MOST_NODES} nodes in its scene, or {_DEEPEST} inside of each other"
            )
        pose = composed(outer, _pose(node))
        below = children(node, "node")
        for each in node:
            kind = tag(each)
            if kind == "instance_geometry":
                found += _instance(each, node, pose, known, geometries)
            elif kind == "instance_controller":
                raise PlannercheckError(f"{_named(node)} has a skeleton (<instance_controller>), which is not read")
            elif kind == "instance_node":
                below.append(_target(each, known, "node"))
            elif kind and kind not in (*_TRANSFORMS, *_OTHERS):
                raise PlannercheckError(f"{_named(node)} has <{shortened(kind)}>, which Collada does not have there")
        if any(id(each) in path for each in below):
            raise PlannercheckError(f"{_named(node)} is an instance of itself")
        stack += [(each, pose, (*path, id(each))) for each in reversed(below)]
    return found, axes


def _root(content: bytes) -> Element:
    try:
        root = ElementTree.fromstring(content)
    except (ElementTree.ParseError, ValueError, LookupError) as error:  # the latter of encodings
        raise PlannercheckError(f"is no XML: {error}") from None
    if tag(root) != "COLLADA":
        raise PlannercheckError(f"is no Collada file: its root is <{shortened(tag(root))}>, not <COLLADA>")
    return root


def _axes(root: Element) -> ColladaAxes:
    """The unit and up_axis of the whole file; parts with other ones are refused."""
    unit, up = _of_asset(root, ColladaAxes())
    axes = ColladaAxes(*unit, up)
    for element in root.iter():
        if element is not root and _of_asset(element, axes) != (unit, up):
            raise PlannercheckError(f"{_named(element)} has another <unit> or <up_axis> than the file: not read")
    return axes


def _of_asset(element: Element, outer: ColladaAxes) -> tuple[tuple[str, float], str]:
    unit, up = (outer.unit_name, outer.metres), outer.up
    for asset in children(element, "asset"):
        for each in children(asset, "unit"):
            metres = floats_of(each.get("meter", "1").encode())
            if metres is None or len(metres) != 1 or not metres[0] > 0:
                raise PlannercheckError(f"<unit> must have a positive number 'meter', not {each.get('meter')!r:.60}")
            unit = (each.get("name", "meter"), float(metres[0]))
        for each in children(asset, "up_axis"):
            up = (each.text or "").strip()
            if up not in _TURNS:
                raise PlannercheckError(f"<up_axis> must be X_UP, Y_UP or Z_UP, not {shortened(up)!r}")
    return unit, up


def _scene(root: Element, known: Named) -> Element:
    instances = [each for scene in children(root, "scene") for each in children(scene, "instance_visual_scene")]
    if len(instances) != 1:
        raise PlannercheckError(f"must have one <instance_visual_scene> in its <scene>, not {len(instances)}")
    return _target(instances[0], known, "visual_scene")


def _target(instance: Element, known: Named, kind: str) -> Element:
    """The element that an instance names."""
    url = instance.get("url", "")
    if not url.startswith("#"):
        raise PlannercheckError(f"<{tag(instance)}> names {shortened(url)!r}: only parts of the file are read (#...)")
    targets = known.get((kind, url[1:]), [])
    if len(targets) != 1:
        count = f"{len(targets)} <{kind}> of this id: make ids unique" if targets else f"no such <{kind}>"
        raise PlannercheckError(f"<{tag(instance)}> names {shortened(url)!r}, but the file has {count}")
    return targets[0]


def _instance(
    each: Element, node: Element, pose: Floats, known: Named, geometries: dict[str, Geometry]
) -> list[RawObject]:
    """The object of one instance; none for a geometry of lines alone."""
    target = _target(each, known, "geometry")
    key = id_of(target)
    if key not in geometries:
        geometries[key] = geometry_of(target)
    geometry = geometries[key]
    name = node.get("name") or id_of(node) or target.get("name") or key
    if not len(geometry.triangles):
        return []
    points = transformed(pose, geometry.points)
    return [RawObject.of(name, points, facing_as_before(pose, geometry.triangles))]


def _pose(node: Element) -> Floats:
    """The node's transforms (4, 4), the first one outermost."""
    pose = np.eye(4)
    for each in node:
        kind = tag(each)
        if kind == "skew":
            raise PlannercheckError(f"{_named(node)} has a <skew>, which is not read: <matrix> says the same")
        if kind not in _TRANSFORMS:
            continue
        numbers = floats_of((each.text or "").encode())
        if numbers is None or len(numbers) != _TRANSFORMS[kind] or len(each):
            raise PlannercheckError(f"{_named(node)}: <{kind}> must have {_TRANSFORMS[kind]} finite numbers")
        pose = composed(pose, _transform(kind, numbers, node))
    return pose


def _transform(kind: str, numbers: Floats, node: Element) -> Floats:
    pose = np.eye(4)
    if kind == "matrix":
        pose = numbers.reshape(4, 4)
        if pose[3].tolist() != [0, 0, 0, 1]:
            raise PlannercheckError(f"{_named(node)}: the last row of <matrix> must be 0 0 0 1")
    elif kind == "translate":
        pose[:3, 3] = numbers
    elif kind == "scale":
        pose[:3, :3] = np.diag(numbers)
    elif kind == "rotate":
        pose[:3, :3] = _rotation(numbers, node)
    else:
        place, target, up = numbers.reshape(3, 3)
        back = _unit(place - target, node)
        right = _unit(np.cross(up, back), node)
        pose[:3] = np.column_stack([right, np.cross(back, right), back, place])
    return pose


def _rotation(numbers: Floats, node: Element) -> Floats:
    """About an axis by an angle in degrees; exact for quarter turns about the axes."""
    if not numbers[3] % 360:
        return np.eye(3)  # some exporters write a turn by 0 about no axis
    x, y, z = axis = _unit(numbers[:3], node)
    quarters = numbers[3] / 90
    if quarters == round(quarters):
        cosine, sine = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][round(quarters) % 4]
    else:
        cosine, sine = float(np.cos(np.radians(numbers[3]))), float(np.sin(np.radians(numbers[3])))
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.asarray(cosine * np.eye(3) + sine * cross + (1 - cosine) * np.outer(axis, axis))


def _unit(vector: Floats, node: Element) -> Floats:
    length = float(np.linalg.norm(vector))
    if not (0 < length < np.inf):
        raise PlannercheckError(f"{_named(node)} has a transform about an axis without a direction")
    return vector / length


def _named(element: Element) -> str:
    return f"<{tag(element)} id={shortened(id_of(element) or element.get('name', ''))!r}>"
