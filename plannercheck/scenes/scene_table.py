"""A scene as notebooks show it: a table of its objects.

In: a scene. Out: HTML, in which names are always plain text.
"""

from __future__ import annotations

import html
from collections.abc import Sequence

from plannercheck.bodies.objects import SceneObject
from plannercheck.bodies.shapes import Box, Hull, Shape, Sphere
from plannercheck.scenes.contents import SceneContents

# Rows beyond this number are only counted.
_MOST_ROWS = 40

_HEADER = ("object", "shapes", "position, m", "in the frame of")


def scene_html(scene: SceneContents) -> str:
    """The table, under the scene's own words for itself."""
    items = (*scene.objects, *scene.attached)
    rows = [_row(_cells(item)) for item in items[:_MOST_ROWS]]
    if len(items) > _MOST_ROWS:
        rows.append(_row([f"… and {len(items) - _MOST_ROWS} more"]))
    return f"<p>{html.escape(repr(scene))}</p><table>{_row(_HEADER, 'th')}{''.join(rows)}</table>"


def _row(cells: Sequence[str], tag: str = "td") -> str:
    return f"<tr>{''.join(f'<{tag}>{html.escape(cell)}</{tag}>' for cell in cells)}</tr>"


def _cells(item: SceneObject) -> tuple[str, str, str, str]:
    frame = item.link or "the world"
    if item.anchor is not None:  # its pose is in another frame until a checker has placed it
        frame = item.anchor.frame or "the world"
    position = ", ".join(f"{value:.4g}" for value in item.pose[:3, 3])
    return item.name, ", ".join(_words(part.shape) for part in item.parts), position, frame


def _words(shape: Shape) -> str:
    match shape:
        case Box():
            return f"box {' × '.join(f'{edge:.4g}' for edge in shape.size)}"
        case Sphere():
            return f"sphere of radius {shape.radius:.4g}"
        case Hull():
            return f"hull of {len(shape.vertices)} points"
    return f"{type(shape).__name__.lower()} of radius {shape.radius:.4g}, length {shape.length:.4g}"
