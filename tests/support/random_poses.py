"""Poses for tests of distances."""

from __future__ import annotations

import numpy as np


def pose_at(rng, distance):
    """A random rotation, this far from the origin in a random direction."""
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    pose = np.eye(4)
    pose[:3, :3] = turn * np.sign(np.linalg.det(turn))
    way = rng.normal(size=3)
    pose[:3, 3] = way / np.linalg.norm(way) * distance
    return pose
