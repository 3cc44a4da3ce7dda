"""Cells of gantries, each a box that slides along x and y: whether they meet is a comparison of numbers."""

from pathlib import Path

import numpy as np
from gantries import gantry_robot

import plannercheck as pc

# Half edges of the boxes, m.
HALF = 0.1


def gantries(folder: Path, names, post: tuple[float, float] | None = None) -> pc.Checker:
    """A cell of gantries at one place, and a post of the same size."""
    robot, scene = gantry_robot(folder, HALF, (9.0, 9.0)), pc.Scene("posts")
    if post is not None:
        place = np.eye(4)
        place[:2, 3] = post
        scene.add_box("post", (2 * HALF, 2 * HALF, 1.0), place)
    return pc.Checker(pc.Robot.together({name: (robot, np.eye(4)) for name in names}), scene)


def way(*points, times=None) -> pc.Trajectory:
    """Straight from point to point (2,), a second each unless times are given, s."""
    return pc.Trajectory(np.arange(len(points)) if times is None else times, points, controller="linear")


# Left is within 0.2 m of the crossing from 0.8 s to 1.2 s, and right, that waits by d, from 0.8 + d to 1.2 + d.
LEFT, RIGHT = way([-1, 0], [1, 0], times=[0, 2]), way([0, -1], [0, 1], times=[0, 2])


def at(trajectory: pc.Trajectory, times, start: float = 0.0) -> np.ndarray:
    """Where a robot is that stands before and after its own trajectory."""
    breaks = trajectory.curve.breaks
    return trajectory.position(np.clip(np.asarray(times) - start, breaks[0], breaks[-1]))


def meet(places, post=None, room: float = 0.0) -> np.ndarray:
    """Whether any two boxes, by name (n, 2), or one and the post come within some room of each other."""
    rows = [*places.values(), *([] if post is None else [np.broadcast_to(post, next(iter(places.values())).shape)])]
    found = np.zeros(len(rows[0]), dtype=bool)
    for a in range(len(rows)):
        for b in range(a):
            found |= (np.abs(rows[a] - rows[b]) <= 2 * HALF + room).all(axis=1)
    return found
