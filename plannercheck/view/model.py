"""The contents of a picture, in metres and world coordinates, for any renderer.

In: numbers. Out: frozen values: meshes with a pose for each frame, separating planes, witness points. Both back ends
(page.py, server.py) draw exactly these. `Picture` (page.py) is a `Drawing` that a notebook shows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from plannercheck.common.array_types import Bools, Floats, Ints
from plannercheck.common.errors import PlannercheckError, with_article
from plannercheck.view.drawn_parts import DrawnParts

# What a mesh is: the hull of a link, a link's mesh for collisions as it was delivered, or for the eye; an obstacle, a
# sensed one of many parts, or the floor.
Layer: TypeAlias = Literal["hull", "mesh", "visual", "obstacle", "sensed", "floor"]

# Red, green and blue from 0 to 1, and how opaque.
COLOURS: dict[Layer, tuple[float, float, float]] = {
    "hull": (0.67, 0.74, 0.80),
    "mesh": (0.55, 0.61, 0.68),
    "visual": (0.86, 0.86, 0.83),
    "obstacle": (0.85, 0.70, 0.51),
    "sensed": (0.16, 0.60, 0.55),
    "floor": (0.56, 0.62, 0.58),
}
COLLIDING = (0.84, 0.12, 0.10)
PLANE = (0.16, 0.45, 0.80)
OBSTACLE_OPACITY = 0.45
FLOOR_OPACITY = 0.6
# Opacity of hulls around meshes, so that the meshes show through.
VEIL_OPACITY = 0.35


@dataclass(frozen=True, eq=False, repr=False)
class Mesh:
    """A body, drawn.

    Attributes:
        name: Name of the body.
        owner: The link or obstacle that it belongs to.
        layer: Its layer in the picture.
        vertices: (n, 3) in the body's frame, m.
        faces: (m, 3) indices, counter-clockwise from outside.
        poses: (frames, 4, 4) in the world, or (1, 4, 4) if it does not move.
        colliding: (frames,) whether it collides with anything.
        opacity: 0 to 1.
    """

    name: str
    owner: str
    layer: Layer
    vertices: Floats
    faces: Ints
    poses: Floats
    colliding: Bools
    opacity: float = 1.0

    def pose(self, frame: int) -> Floats:
        """(4, 4) at a frame."""
        pose: Floats = self.poses[frame if len(self.poses) > 1 else 0]
        return pose

    def colour(self, frame: int) -> tuple[float, float, float]:
        """At a frame."""
        return COLLIDING if self.colliding[frame] else COLOURS[self.layer]

    def __repr__(self) -> str:
        return f"Mesh({self.name!r}, {self.layer}, {len(self.vertices)} vertices, {len(self.faces)} triangles)"


@dataclass(frozen=True, eq=False)
class Plane:
    """A separating plane, drawn as a square.

    Attributes:
        frame: Index of the frame in which it is shown.
        pair: Names of the link and the link or obstacle that it keeps apart.
        gap: They are at least this far apart, m.
        centre: (3,) on the plane, between the two, m.
        normal: (3,) unit vector from the second to the first.
        size: Edge of the square, m.
        nearest: (2, 3) the nearest points of the two, m.
    """

    frame: int
    pair: tuple[str, str]
    gap: float
    centre: Floats
    normal: Floats
    size: float
    nearest: Floats


@dataclass(frozen=True, eq=False)
class Witness:
    """A point of two colliding bodies.

    Attributes:
        frame: Index of the frame in which it is shown.
        pair: Names of the link and the link or obstacle that share it.
        point: (3,) the shared point, m.
    """

    frame: int
    pair: tuple[str, str]
    point: Floats


@dataclass(frozen=True, eq=False, repr=False)
class Drawing:
    """A robot in a scene at one or several configurations.

    Attributes:
        title: The title.
        labels: The label of each frame.
        animated: Whether frames follow each other in time; else each stands for itself.
        meshes: Meshes of the bodies.
        collisions: For each frame the colliding pairs, by names.
        planes: Planes of all frames.
        witnesses: Witnesses of all frames.
        centre: (3,) what to look at, m.
        radius: Radius of the ball to look at, m.
        parts: Bodies of very many parts.
        times: (frames,) when each frame is, s, so that they are played in real time; None: they have no times.
        clearances: (frames,) the least clearance at each, m, which is plotted over time; None likewise.
    """

    title: str
    labels: tuple[str, ...]
    animated: bool
    meshes: tuple[Mesh, ...]
    collisions: tuple[tuple[tuple[str, str], ...], ...]
    planes: tuple[Plane, ...]
    witnesses: tuple[Witness, ...]
    centre: Floats
    radius: float
    parts: tuple[DrawnParts, ...] = ()
    times: Floats | None = None
    clearances: Floats | None = None

    def frame_at(self, time: float) -> int:
        """The last frame that is not later than a time, s."""
        assert self.times is not None
        return max(int(np.searchsorted(self.times, time, side="right")) - 1, 0)

    @property
    def frames(self) -> int:
        """How many there are."""
        return len(self.labels)

    def verdict(self, frame: int) -> str:
        """A frame's verdict in words."""
        pairs = self.collisions[frame]
        return "collision: " + ", ".join(f"{a} – {b}" for a, b in pairs) if pairs else "free of collision"

    def __repr__(self) -> str:
        hit = sum(map(bool, self.collisions))
        bodies = len(self.meshes) + len(self.parts)
        return f"Picture({self.title!r}, {self.frames} frames, {hit} in collision, {bodies} bodies)"


def checked_drawing(picture: Drawing) -> Drawing:
    """The picture.

    Raises:
        PlannercheckError: If it is none.
    """
    if not isinstance(picture, Drawing):
        raise PlannercheckError(
            f"a picture is needed, not {with_article(type(picture).__name__)}: plannercheck.view.picture(checker, q) "
            "makes one"
        )
    return picture
