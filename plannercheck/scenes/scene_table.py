"""A scene as notebooks show it: a table of its objects.

In: a scene. Out: HTML, in which names are always plain text.
"""

from __future__ import annotations

from plannercheck.bodies.ellipsoids import Ellipsoid
from plannercheck.bodies.half_spaces import HalfSpace
from plannercheck.bodies.objects import SceneObject
from plannercheck.bodies.part_sets import PartSet
from plannercheck.bodies.shapes import Box, Hull, Shape, Sphere
from plannercheck.bodies.solids import Solid
from plannercheck.common.html_tables import html_table
from plannercheck.scenes.contents import SceneContents

_HEADER = ("object", "shapes", "position, m", "in the frame of")


def scene_html(scene: SceneContents) -> str:
    """The table, under the scene's own words for itself."""
    items = (*scene.objects, *scene.attached)
    return html_table(repr(scene), _HEADER, [_cells(item) for item in items])


def _cells(item: SceneObject) -> tuple[str, str, str, str]:
    frame = item.link or "the world"
    if item.pose_frame is not None:  # its pose is in another frame until a checker has placed it
        frame = item.pose_frame.frame or "the world"
    position = ", ".join(f"{value:.4g}" for value in item.pose[:3, 3]) if item.moving is None else repr(item.moving)
    return item.name, ", ".join(_words(part.shape) for part in item.parts), position, frame


def _words(shape: Shape) -> str:
    match shape:
        case Box():
            return f"box {' × '.join(f'{edge:.4g}' for edge in shape.size)}"
        case Sphere():
            return f"sphere of radius {shape.radius:.4g}"
        case Ellipsoid():
            return f"ellipsoid of radii {', '.join(f'{radius:.4g}' for radius in shape.radii)}"
        case HalfSpace():
            return f"half-space of normal {', '.join(f'{x:.4g}' for x in shape.normal)}, offset {shape.offset:.4g}"
        case Hull():
            return f"hull of {len(shape.vertices)} points"
        case Solid():
            return f"solid of {len(shape.triangles)} triangles"
        case PartSet():
            return f"{type(shape).__name__} of {shape.count} parts"
    return f"{type(shape).__name__.lower()} of radius {shape.radius:.4g}, length {shape.length:.4g}"
