"""The meshes of Collada geometries: their points and polygons.

In: a <geometry> element. Out: points and triangles. Lines are no surface and are left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np

from plannercheck.bodies.mesh_objects import check_indices, fan_triangles, strip_triangles
from plannercheck.bodies.polygons import triangles_of_polygons
from plannercheck.bodies.text_numbers import floats_of, integers_of
from plannercheck.common.array_types import Floats, Ints64
from plannercheck.common.errors import PlannercheckError, shortened

_LINES = ("lines", "linestrips")
_SURFACES = ("triangles", "polylist", "polygons", "trifans", "tristrips")
_AXES = ["X", "Y", "Z"]
_LEAST = 3  # corners of a polygon


@dataclass(frozen=True, eq=False)
class Geometry:
    """Points (n, 3) in the file's unit, and triangles (m, 3) of them."""

    points: Floats
    triangles: Ints64


def tag(element: Element) -> str:
    """An element's name without its namespace."""
    return element.tag.rpartition("}")[2] if isinstance(element.tag, str) else ""


def children(element: Element, name: str) -> list[Element]:
    """The elements of one name directly below another."""
    return [each for each in element if tag(each) == name]


def id_of(element: Element) -> str:
    """An element's id, or ""."""
    return element.get("id", "")


def geometry_of(geometry: Element) -> Geometry:
    """The mesh of a <geometry>.

    Raises:
        PlannercheckError: If it is none, or its numbers are not those that it announces.
    """
    try:
        meshes = children(geometry, "mesh")
        if len(meshes) != 1:
            kinds = ", ".join(f"<{tag(each)}>" for each in geometry) or "nothing"
            raise PlannercheckError(f"must have one <mesh>, but has {kinds}")
        return _mesh(meshes[0])
    except PlannercheckError as error:
        raise PlannercheckError(f"geometry {shortened(id_of(geometry))!r} {error}") from None


def _mesh(mesh: Element) -> Geometry:
    places: dict[str, Floats] = {}
    points, triangles, count = [], [], 0
    for each in mesh:
        kind = tag(each)
        if kind not in _SURFACES:
            if kind not in ("source", "vertices", "extra", *_LINES):
                raise PlannercheckError(f"has <{shortened(kind)}>, which is not read")
            continue
        offset, stride, vertices = _vertex_input(each)
        if vertices not in places:
            places[vertices] = _points(mesh, vertices)
        found = _triangles(each, kind, offset, stride, places[vertices])
        points.append(places[vertices])
        triangles.append(found + count)
        count += len(points[-1])
    if not triangles:
        return Geometry(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))
    return Geometry(np.concatenate(points), np.concatenate(triangles))


def _number(element: Element, name: str, default: str | None = None) -> int:
    """An attribute that is a whole number, at least 0."""
    text = element.get(name, default)
    if text is None or not text.strip().isascii() or not text.strip().isdigit() or len(text) > 18:
        raise PlannercheckError(f"has <{tag(element)}> whose {name!r} must be a whole number, not {text!r:.60}")
    return int(text)


def _vertex_input(primitive: Element) -> tuple[int, int, str]:
    """Where a corner's vertex stands among its indices, how many these are, and the id of the vertices."""
    inputs = children(primitive, "input")
    vertices = [each for each in inputs if each.get("semantic") == "VERTEX"]
    if len(vertices) != 1:
        raise PlannercheckError(f"has <{tag(primitive)}> with {len(vertices)} inputs VERTEX: there must be one")
    offsets = [_number(each, "offset") for each in inputs]
    return _number(vertices[0], "offset"), max(offsets) + 1, vertices[0].get("source", "")


def _points(mesh: Element, name: str) -> Floats:
    """The places (n, 3) of <vertices>."""
    vertices = _source(mesh, name, "vertices")
    inputs = [each for each in children(vertices, "input") if each.get("semantic") == "POSITION"]
    if len(inputs) != 1:
        raise PlannercheckError(f"has <vertices> with {len(inputs)} inputs POSITION: there must be one")
    source = _source(mesh, inputs[0].get("source", ""), "source")
    arrays = children(source, "float_array")
    accessors = [each for part in children(source, "technique_common") for each in children(part, "accessor")]
    if len(arrays) != 1 or len(accessors) != 1:
        raise PlannercheckError(f"source {id_of(source)!r:.60} must have one <float_array> and one <accessor>")
    if accessors[0].get("source") != f"#{id_of(arrays[0])}":
        raise PlannercheckError(f"source {id_of(source)!r:.60} has an <accessor> of another array")
    numbers = floats_of((arrays[0].text or "").encode())
    if numbers is None or len(arrays[0]):
        raise PlannercheckError(f"source {id_of(source)!r:.60} has a place that is no finite number")
    if len(numbers) != _number(arrays[0], "count"):
        raise PlannercheckError(
            f"source {id_of(source)!r:.60} has {len(numbers)} numbers, but says {arrays[0].get('count')}"
        )
    return _accessed(accessors[0], numbers)


def _source(mesh: Element, url: str, kind: str) -> Element:
    found = [each for each in children(mesh, kind) if id_of(each) and url == f"#{id_of(each)}"]
    if len(found) != 1:
        count = f"{len(found)} <{kind}> of this id: make ids unique" if found else f"no such <{kind}>"
        raise PlannercheckError(f"names {shortened(url)!r}, but has {count}")
    return found[0]


def _accessed(accessor: Element, numbers: Floats) -> Floats:
    """The three columns X, Y, Z (n, 3) of an accessor."""
    count, stride, offset = (
        _number(accessor, name, default) for name, default in (("count", None), ("stride", "1"), ("offset", "0"))
    )
    names = [each.get("name", "") for each in children(accessor, "param")]
    # Some exporters leave out the names; the first three are meant then.
    columns = [names.index(axis) for axis in _AXES] if set(_AXES) <= set(names) else [0, 1, 2]
    if len(names) < len(_AXES) or (any(names) and not set(_AXES) <= set(names)):
        raise PlannercheckError(f"has places with params {names!r:.60}: there must be X, Y and Z")
    if max(columns) >= stride or (count and offset + count * stride > len(numbers)):
        raise PlannercheckError(f"has an <accessor> of {count} times {stride} numbers, but {len(numbers)} numbers")
    return numbers[offset : offset + count * stride].reshape(count, stride)[:, columns]


def _triangles(primitive: Element, kind: str, offset: int, stride: int, points: Floats) -> Ints64:
    lists = [_indices(each, kind, offset, stride, points) for each in children(primitive, "p")]
    if children(primitive, "ph"):
        raise PlannercheckError("has polygons with holes (<ph>), which are not read")
    said = _number(primitive, "count")
    if kind in ("triangles", "polylist") and len(lists) > 1:
        raise PlannercheckError(f"has <{kind}> with {len(lists)} lists <p>: there must be one")
    if kind == "triangles":
        corners = lists[0] if lists else np.zeros(0, dtype=np.int64)
        counts = np.full(said, _LEAST)
    elif kind == "polylist":
        corners = lists[0] if lists else np.zeros(0, dtype=np.int64)
        counts = _counts(primitive, said)
    else:
        if len(lists) != said:
            raise PlannercheckError(f"has <{kind}> that says {said} lists <p>, but has {len(lists)}")
        if any(len(each) < _LEAST for each in lists):
            raise PlannercheckError(f"has <{kind}> with fewer than three corners")
        if kind != "polygons":
            cut = strip_triangles if kind == "tristrips" else fan_triangles
            return np.concatenate([np.zeros((0, 3), dtype=np.int64), *(cut(each) for each in lists)])
        corners = np.concatenate([np.zeros(0, dtype=np.int64), *lists])
        counts = np.array([len(each) for each in lists], dtype=np.int64)
    if int(counts.sum()) != len(corners):
        raise PlannercheckError(f"has <{kind}> that says {counts.sum()} corners, but has {len(corners)}")
    return triangles_of_polygons(points, counts, corners)


def _counts(polylist: Element, said: int) -> Ints64:
    lists = children(polylist, "vcount")
    counts = integers_of(" ".join(each.text or "" for each in lists).encode())
    if counts is None or len(counts) != said or (counts < _LEAST).any():
        raise PlannercheckError(f"has <polylist> that must have {said} whole numbers from 3 on in its <vcount>")
    return counts


def _indices(p: Element, kind: str, offset: int, stride: int, points: Floats) -> Ints64:
    numbers = integers_of((p.text or "").encode())
    if numbers is None or len(p):
        raise PlannercheckError(f"has <{kind}> with an index that is no whole number")
    if len(numbers) % stride:
        raise PlannercheckError(f"has <{kind}> with {len(numbers)} indices: they must be {stride} a corner")
    indices = numbers[offset::stride]
    check_indices(indices, len(points), f"has <{kind}> that")
    return indices
