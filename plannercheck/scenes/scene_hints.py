"""Hints for scenes that are probably mistakes: sizes in millimetres.

In: a scene. Out: a sentence with the likely mistake and its remedy, or an empty string. Verdicts do not depend on it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.half_spaces import HalfSpace
from plannercheck.bodies.shapes import Box, inflated_hull
from plannercheck.scenes.contents import SceneContents

# A scene that spans this much, and in which no object is thinner than that, is in millimetres: a wide floor is thin. m.
_LARGE, _THIN = 100.0, 1.0


def scale_hint(scene: SceneContents) -> str:
    """A sentence about the objects' sizes; empty if they are usual."""
    if any(
        isinstance(part.shape, Box) and min(part.shape.size) < _THIN for item in scene.objects for part in item.parts
    ):
        return ""  # decided without hulls
    extents: dict[str, list[NDArray[np.float64]]] = {}
    for item in scene.objects:
        for part in item.parts:
            if isinstance(part.shape, HalfSpace):
                continue  # of no size
            points, _, inflation_radius = inflated_hull(part.shape)
            extents.setdefault(item.name, []).append(np.ptp(points, axis=0) + 2 * inflation_radius)
    if not extents:
        return ""
    largest = {name: float(np.max(sizes)) for name, sizes in extents.items()}
    thinnest = min(float(np.min(sizes)) for sizes in extents.values())
    name = max(largest, key=lambda each: largest[each])
    if largest[name] <= _LARGE or thinnest < _THIN:
        return ""
    return (
        f"{name!r} is {largest[name]:.4g} m large and nothing is thinner than {thinnest:.4g} m: sizes and positions "
        "are in m, if these are in millimetres, multiply them by 0.001"
    )
