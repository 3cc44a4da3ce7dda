"""A picture as one HTML file with data and renderer inlined; it loads nothing else.

In: a `Drawing`. Out: the file; and `Picture`, a drawing that is its own page in a notebook. Numbers are packed as
little-endian 32-bit values in base64; viewer.html draws them with WebGL 2. Drawn coordinates are rounded to single
precision; verdicts are not.
"""

from __future__ import annotations

import base64
import html
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.atomic_files import write_atomically
from plannercheck.common.escaping import json_in_script
from plannercheck.view.drawn_parts import DrawnParts
from plannercheck.view.model import COLLIDING, COLOURS, PLANE, Drawing, Mesh, checked_drawing

_TEMPLATE, *_SCRIPTS = (
    Path(__file__).with_name(name) for name in ("viewer.html", "viewer_parts.js", "viewer_layer.js", "viewer_plot.js")
)
_TITLE, _DATA, _PARTS = "<!--TITLE-->", "/*DATA*/", "/*PARTS*/"


# The height of a page in a notebook, pixels.
_HEIGHT = 520


@dataclass(frozen=True, eq=False, repr=False)
class Picture(Drawing):
    """A `Drawing` that a notebook shows as `write_page` writes it."""

    def _repr_html_(self) -> str:
        page = html.escape(page_of(self))
        # The frame may run its own script, and has no access to the notebook.
        return (
            f'<iframe sandbox="allow-scripts" style="width:100%;height:{_HEIGHT}px;border:0" srcdoc="{page}"></iframe>'
        )


def write_page(picture: Drawing, path: str | Path) -> None:
    """Writes a picture as one HTML file; aside first, then renamed.

    Raises:
        PlannercheckError: If it is no picture, or the file can't be written.
    """
    text = page_of(checked_drawing(picture))
    write_atomically(Path(path), lambda aside: aside.write_text(text, encoding="utf-8"))


def page_of(picture: Drawing) -> str:
    """The HTML of a picture."""
    script = "".join(each.read_text(encoding="utf-8") for each in _SCRIPTS)
    parts = {_TITLE: html.escape(picture.title), _DATA: json_in_script(data_of(picture)), _PARTS: script}
    template = _TEMPLATE.read_text(encoding="utf-8")
    # One pass, so that inserted texts are not searched again.
    return re.sub("|".join(map(re.escape, parts)), lambda match: parts[match[0]], template)


def data_of(picture: Drawing) -> dict[str, Any]:
    """What viewer.html reads."""
    return {
        "title": picture.title,
        "labels": list(picture.labels),
        "animated": picture.animated,
        "times": None if picture.times is None else picture.times.tolist(),
        "clearances": None if picture.clearances is None else picture.clearances.tolist(),
        "verdicts": [picture.verdict(frame) for frame in range(picture.frames)],
        "valid": [not pairs for pairs in picture.collisions],
        "colours": {layer: list(colour) for layer, colour in COLOURS.items()},
        "red": list(COLLIDING),
        "blue": list(PLANE),
        "centre": picture.centre.tolist(),
        "radius": picture.radius,
        "meshes": [_mesh(mesh) for mesh in picture.meshes],
        "parts": [_parts(each, picture) for each in picture.parts],
        "planes": [
            {
                "frame": plane.frame,
                "text": f"{' – '.join(plane.pair)}: at least {plane.gap:.4g} m apart",
                "centre": plane.centre.tolist(),
                "normal": plane.normal.tolist(),
                "size": plane.size,
                "nearest": plane.nearest.ravel().tolist(),
            }
            for plane in picture.planes
        ],
        "witnesses": [{"frame": each.frame, "point": each.point.tolist()} for each in picture.witnesses],
    }


def _mesh(mesh: Mesh) -> dict[str, Any]:
    return {
        "name": mesh.owner if mesh.owner == mesh.name else f"{mesh.owner} ({mesh.name})",
        "layer": mesh.layer,
        "colour": list(COLOURS[mesh.layer]),
        "opacity": mesh.opacity,
        "vertices": _packed(mesh.vertices, "<f4"),
        "faces": _packed(mesh.faces, "<u4"),
        # Column by column, without the last row: 12 numbers a frame.
        "poses": _packed(mesh.poses[:, :3].transpose(0, 2, 1), "<f4"),
        "colliding": np.flatnonzero(mesh.colliding).tolist(),
    }


def _parts(each: DrawnParts, picture: Drawing) -> dict[str, Any]:
    return {
        "name": each.title,
        "layer": each.layer,
        "kind": each.kind,
        "groups": [_packed(group, "<u2") for group in each.groups],
        "corner": each.corner.tolist(),
        "step": each.step,
        "ranges": each.ranges(picture.centre).tolist(),
        "poses": _packed(each.poses[:, :3].transpose(0, 2, 1), "<f4"),
    }


def _packed(array: NDArray[Any], kind: str) -> str:
    return base64.b64encode(np.ascontiguousarray(array, dtype=kind).tobytes()).decode("ascii")
