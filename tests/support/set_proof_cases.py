"""Sets of parts of every kind before a Panda, a motion that keeps clear of them, and proofs that are changed."""

from dataclasses import replace

import numpy as np

import plannercheck as pc
from plannercheck.proofs.well_formed import hashes_of

START = np.array([0, -0.785, 0, -2.356, 0, 1.571, 0.785])
END = START + np.array([0.3, 0.1, 0, 0.1, 0, 0, 0])


def shell(count, seed=4):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(count, 3))
    return 1.2 * points / np.linalg.norm(points, axis=1)[:, None] + [0, 0, 0.4]


def hollow():
    full = np.zeros((20, 20, 16), dtype=bool)
    full[[0, -1]] = full[:, [0, -1]] = full[:, :, [-1]] = True
    return full


def valley():
    heights = np.full((20, 20), -0.5)
    heights[0] = heights[:, -1] = 1.5
    heights[3, 4] = np.nan
    return heights


SETS = {
    "balls": lambda: pc.PointCloud(shell(300), np.random.default_rng(1).uniform(0.005, 0.03, 300)),
    "one radius": lambda: pc.PointCloud(shell(200), 0.01),
    "boxes": lambda: pc.VoxelGrid(hollow(), 0.1, (-1, -1, 0.2)),
    "leaves": lambda: pc.Octree.from_cells(np.unique(np.floor(shell(200) / 0.06).astype(int), axis=0), 0.06),
    "prisms": lambda: pc.HeightField(valley(), 0.1, -1, (-1, -1)),
}


def tilted():
    pose = np.eye(4)
    pose[:3, :3] = [[np.cos(0.02), 0, np.sin(0.02)], [0, 1, 0], [-np.sin(0.02), 0, np.cos(0.02)]]
    pose[:3, 3] = 0.02, 0.01, 0.03
    return pose


def scene_of(shape):
    scene = pc.Scene("sensed")
    scene.add("camera", shape, tilted())
    return scene


def replaced(proof, **changes):
    fields = ("kind", "robot", "scene", "hashes", "model", "motion", "margin", "entries")
    return type(proof)(*(changes.get(name, getattr(proof, name)) for name in fields))


def with_set(proof, **changes):
    """A proof whose set is another one, with hashes that fit."""
    bodies = tuple(replace(body, **changes) if body.parts else body for body in proof.model.bodies)
    model = replace(proof.model, bodies=bodies)
    return replaced(proof, model=model, hashes=hashes_of(model))


def set_of(proof):
    return next(body for body in proof.model.bodies if body.parts)


def with_bodies(proof, bodies):
    model = replace(proof.model, bodies=tuple(bodies))
    return replaced(proof, model=model, hashes=hashes_of(model))


def refused(proof, words):
    found = proof.verify()
    assert not found
    assert words in found.fault, found.fault
