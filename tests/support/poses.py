"""Poses (4, 4) at places and with turns, given or random."""

import numpy as np


def at(*position, turn=None):
    """At a position (3,), whose last numbers may be left out, with a rotation (3, 3), or without one."""
    pose = np.eye(4)
    pose[: len(position), 3] = position
    if turn is not None:
        pose[:3, :3] = turn
    return pose


def random_turn(rng):
    """A rotation (3, 3)."""
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return turn * np.sign(np.linalg.det(turn))


def random_pose(rng, spread=1.0):
    """A random rotation, normally distributed about the origin."""
    turn = random_turn(rng)
    return at(*spread * rng.normal(size=3), turn=turn)


def pose_within(rng, reach):
    """A random rotation, anywhere in a cube of this half edge."""
    turn = random_turn(rng)
    return at(*rng.uniform(-reach, reach, 3), turn=turn)


def pose_at(rng, distance):
    """A random rotation, this far from the origin in a random direction."""
    turn = random_turn(rng)
    way = rng.normal(size=3)
    return at(*way / np.linalg.norm(way) * distance, turn=turn)
