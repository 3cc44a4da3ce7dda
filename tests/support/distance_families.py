"""Pairs of bodies for signed distances, by family, and poses that suit them."""

from collections.abc import Callable

import numpy as np
from clearance import random_poses
from signed_distance_oracle import OracleBody

from plannercheck.bodies.polytope import Polytope
from plannercheck.evaluation.stress.body_families import family
from plannercheck.evaluation.stress.contact_poses import Solid, contact_poses


class Body:
    """A body of the library, and of the oracle."""

    def __init__(self, vertices, inflation_radius=0.0):
        vertices = np.asarray(vertices, dtype=np.float64)
        self.ours = Polytope(vertices, inflation_radius=inflation_radius)
        self.vertices = self.ours.vertices
        self.oracle = OracleBody(self.vertices, inflation_radius)
        self.size = float(np.linalg.norm(self.vertices - self.vertices.mean(axis=0), axis=1).max()) + inflation_radius


def small(rng):
    """A body of at most 60 vertices."""
    name = rng.choice(["box", "round", "cloud", "prism"])
    return family(str(name), int(rng.integers(4, 31)) * 2, int(rng.integers(1 << 30)))


def at_random(rng):
    return Body(small(rng)), Body(small(rng)), (0.1, 0.9)


def needles(rng):
    bodies = [
        family(str(rng.choice(["needle", "flat"])), int(rng.integers(6, 30)), int(rng.integers(1 << 30))) for _ in "ab"
    ]
    return Body(bodies[0]), Body(bodies[1]), (0.0, 0.6)


def flat(rng):
    def polygon():
        n = int(rng.integers(1, 7))
        return np.concatenate([rng.uniform(-0.5, 0.5, (n, 2)), np.zeros((n, 1))], axis=1)

    return Body(polygon()), Body(polygon() if rng.random() < 0.5 else small(rng)), (0.0, 0.5)


def nested(rng):
    return Body(0.1 * small(rng)), Body(small(rng)), (0.0, 0.1)


def equal(rng):
    vertices = small(rng)
    return Body(vertices), Body(vertices), (0.0, 1e-3)


def round_ones(rng):
    bodies = [Body(rng.normal(size=(int(rng.integers(1, 4)), 3)) * 0.3, float(rng.uniform(0.01, 0.5))) for _ in "ab"]
    return *bodies, (0.0, 1.0)


def far(rng):
    return Body(small(rng)), Body(small(rng)), (5.0, 100.0)


def touching(rng):
    return Body(small(rng)), Body(small(rng)), None


FAMILIES: dict[str, Callable] = {
    "random": at_random,
    "needles": needles,
    "flat": flat,
    "nested": nested,
    "equal": equal,
    "touching": touching,
    "spheres and capsules": round_ones,
    "far": far,
}


def poses_of(name, pair, reach, rng, n):
    """Poses of a family: turned at random, some not turned at all; or at gaps around 0."""
    if reach is None:
        solids = [Solid("", b.vertices, np.asarray(b.ours.faces, dtype=np.int64)) for b in pair]
        gaps = rng.choice([0.0, 1e-15, -1e-15, 1e-12, -1e-12, 1e-8, -1e-8, 1e-4, -1e-4], n)
        return contact_poses(*solids, gaps, rng)
    poses = [random_poses(rng, n, 1.0), random_poses(rng, n, float(rng.uniform(0, 1)))]
    poses[0][:, :3, 3] *= rng.uniform(*reach, n)[:, None]
    poses[0][:, :3, 3] += poses[1][:, :3, 3]
    plain = rng.random(n) < (0.5 if name in ("flat", "equal") else 0.05)  # faces and edges that are parallel
    for one in poses:
        one[plain, :3, :3] = np.eye(3)
    if name in ("flat", "equal"):
        poses[0][plain] = np.where(rng.random((int(plain.sum()), 1, 1)) < 0.5, poses[1][plain], poses[0][plain])
    return poses
