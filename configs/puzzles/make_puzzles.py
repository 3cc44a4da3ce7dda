"""Makes the concave puzzles of this folder: robots, scenes and meshes, always the same.

In: nothing. Out: hook and ring, key and lock, and a pipe for the Panda's hand. Each has a way out that every hull
fills: with hulls the start or the goal collides, with solids there is a path. Meshes are closed and of a few hundred
triangles.

Run it with `python configs/puzzles/make_puzzles.py` from a checkout.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TypeAlias

import numpy as np
import yaml
from numpy.typing import NDArray

import plannercheck as pc

FOLDER = Path(__file__).parent

# Points (n, 3) in m, and triangles (k, 3).
Mesh: TypeAlias = tuple[NDArray[np.float64], NDArray[np.int64]]

HOOK, KEY = "hook", "key"


def arc(radius: float, thickness: float, degrees: float, around: int, across: int) -> Mesh:
    """A bent rod in the plane of x and y, its middle at -x; of 360 degrees a ring."""
    closed = degrees == 360
    angles = np.pi + np.radians(degrees) * (np.arange(around + (not closed)) / around - 0.5)
    turns = 2 * np.pi * np.arange(across) / across
    out = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    rings = radius * out[:, None] + thickness * (
        np.cos(turns)[:, None] * out[:, None] + np.sin(turns)[:, None] * np.array([0.0, 0.0, 1.0])
    )
    points = rings.reshape(-1, 3)
    triangles = _walls(len(angles), across, closed)
    if closed:
        return points, np.array(triangles)
    ends = len(points), len(points) + 1
    for k in range(across):
        after, last = (k + 1) % across, (len(angles) - 1) * across
        triangles += [(ends[0], k, after), (ends[1], last + after, last + k)]
    return np.vstack([points, radius * out[0], radius * out[-1]]), np.array(triangles)


def _walls(rings: int, across: int, closed: bool) -> list[tuple[int, int, int]]:
    """Triangles between rings of points, each with the next."""
    out = []
    for i in range(rings if closed else rings - 1):
        for k in range(across):
            a, b = i * across + k, i * across + (k + 1) % across
            c, d = ((i + 1) % rings) * across + k, ((i + 1) % rings) * across + (k + 1) % across
            out += [(a, c, b), (b, c, d)]
    return out


def pierced(outer: NDArray[np.float64], inner: NDArray[np.float64], thickness: float) -> Mesh:
    """A plate about the plane of y and z: a polygon (n, 2) with another one (n, 2) cut out, corner by corner."""
    half, count = thickness / 2, len(outer)
    faces = [np.insert(side, 0, x, axis=1) for x in (-half, half) for side in (outer, inner)]
    walls = _walls(4, count, True)  # outer and inner at the back, then inner and outer in front
    return np.vstack([faces[0], faces[1], faces[3], faces[2]]), np.array(walls)


def box(low: Sequence[float], high: Sequence[float]) -> Mesh:
    """A box between two corners."""
    corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def joined(*parts: Mesh) -> Mesh:
    """Several closed meshes as one; where they overlap, it is inside as well."""
    firsts = np.cumsum([0, *(len(points) for points, _ in parts)])
    return (
        np.vstack([points for points, _ in parts]),
        np.vstack([triangles + first for (_, triangles), first in zip(parts, firsts, strict=False)]),
    )


def polygon(radius: float, sides: int) -> NDArray[np.float64]:
    """A regular one, (sides, 2)."""
    angles = 2 * np.pi * np.arange(sides) / sides
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def keyhole() -> NDArray[np.float64]:
    """A round hole with a slot below, (n, 2), by rays from the hole's middle."""
    rays = polygon(1.0, 48)
    radius, half_width, depth = 0.11, 0.09, 0.32
    out = radius * rays
    for k, (y, z) in enumerate(rays.tolist()):
        if z < 0:
            length = min(depth / -z, half_width / max(abs(y), 1e-9))
            out[k] = max(radius, length) * rays[k]
    return out


def square(half: float) -> NDArray[np.float64]:
    """A square, (48, 2), by the same rays."""
    rays = polygon(1.0, 48)
    return half * rays / np.abs(rays).max(axis=1, keepdims=True)


def key_mesh() -> Mesh:
    """Along x: a shaft, a bit that points down, and a ring as its bow."""
    points, triangles = arc(0.12, 0.03, 360, 16, 8)
    bow = points[:, [0, 2, 1]] + [0.5, 0, 0], triangles[:, ::-1]
    shaft = box((-0.3, -0.03, -0.03), (0.4, 0.03, 0.03))
    bit = box((-0.27, -0.025, -0.2), (-0.22, 0.025, 0.0))
    return joined(shaft, bit, bow)


def save(name: str, mesh: Mesh) -> None:
    """Writes a binary STL."""
    points, triangles = mesh
    rows = np.zeros(len(triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("unused", "<u2")])
    rows["corners"] = points[triangles]
    (FOLDER / f"{name}.stl").write_bytes(bytes(80) + np.uint32(len(triangles)).tobytes() + rows.tobytes())


def save_body(name: str, mesh: Mesh, what: str) -> None:
    """Writes a robot of one free link."""
    save(name, mesh)
    link = f'<link name="{name}"><collision><geometry><mesh filename="package://puzzles/{name}.stl"/></geometry></collision>'
    (FOLDER / f"{name}.urdf").write_text(f'<robot name="{name}">{link}</link></robot>\n')
    text = f"# {what}\nname: {name}\nurdf: {name}.urdf\npackage_dirs: [..]\nfloating: true\ngeometry: solid\n"
    (FOLDER / f"{name}.yaml").write_text(text)


def save_scene(name: str, what: str, mesh: Mesh, pose: NDArray[np.float64], robot: str, **ends: list[float]) -> None:
    """Writes a scene of one mesh, which is a solid if scenes are read with their meshes as solids."""
    save(name, mesh)
    thing = {
        "name": name,
        "mesh": {"file": f"{name}.stl"},
        "matrix": [[round(x, 9) for x in row] for row in pose.tolist()],
    }
    text = yaml.safe_dump(
        {"name": name, "objects": [thing], "states": {robot: ends}}, sort_keys=False, default_flow_style=None
    )
    (FOLDER / f"{name}.yaml").write_text(f"# {what}\n{text}")


def main() -> None:
    """Writes all files."""
    half = float(np.sqrt(0.5))
    save_body(HOOK, arc(0.2, 0.03, 280, 24, 8), "An open ring that flies freely.")
    save_scene(
        "ring",
        "A ring, and a hook that hangs in it: it has to be turned out.",
        arc(0.3, 0.05, 360, 24, 8),
        np.eye(4),
        HOOK,
        start=[-0.3, 0.0, 0.0, half, 0.0, 0.0, half],
        goal=[0.0, 0.0, 0.8, 0.0, 0.0, 0.0, 1.0],
    )
    save_body(KEY, key_mesh(), "A key that flies freely.")
    save_scene(
        "lock",
        "A plate with a keyhole, and a key whose bit is behind it, turned: it has to be turned back and drawn out.",
        pierced(square(0.5), keyhole(), 0.06),
        np.eye(4),
        KEY,
        start=[0.1, 0.0, 0.0, 0.5, 0.0, 0.0, float(np.sqrt(0.75))],
        goal=[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
    )
    panda, goal = pc.Robot.load("panda"), [0.0, 0.5, 0.0, -1.6, 0.0, 2.1, 0.785398]
    hand = panda.link_poses(goal)[panda.link_index("panda_hand")]
    along = np.array([[0, 0, -1, 0], [0, 1, 0, 0], [1, 0, 0, 0.1], [0, 0, 0, 1.0]])  # x of the pipe is z of the hand
    save_scene(
        "pipe",
        "A pipe that the Panda's hand has to get into.",
        pierced(polygon(0.19, 24), polygon(0.16, 24), 0.24),
        hand @ along,
        "panda",
        start=[1.2, -0.785398, 0.0, -2.356194, 0.0, 1.570796, 0.785398],
        goal=goal,
    )


if __name__ == "__main__":
    main()
