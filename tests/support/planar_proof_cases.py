"""Free planar motions of shipped robots with their proofs, and proofs with a part exchanged.

In: a checker. Out: (q0, q1, proof) each, straight or on curves.
"""

from dataclasses import replace

import numpy as np
from ompl import base

import plannercheck as pc
from plannercheck.proofs.planar_well_formed import hashes_of

P = pc.planar
STRAIGHT = {}
SHIPPED = [("forklift", "warehouse", 1.5), ("forklift", "parking", 1.5), ("truck_trailer", "parking", 6.0)]
CURVES = {"dubins": base.DubinsStateSpace, "reeds_shepp": base.ReedsSheppStateSpace}


def kinds(radius):
    return [STRAIGHT, *({"curve": curve, "turning_radius": radius} for curve in CURVES)]


def free_motions(checker, n, seed, scale=1.0, **kind):
    """Motions that are free, and their proofs."""
    generator, found = np.random.default_rng(seed), []
    for _ in range(60):
        q = checker.robot.random_configurations(200, generator)
        q0 = q[checker.check_states(q)][: 2 * n]
        ways = generator.normal(size=q0.shape) * generator.uniform(0.05, scale, (len(q0), 1))
        if kind:  # mostly ahead, so that curves are short
            ahead = np.array([np.cos(q0[:, 2]), np.sin(q0[:, 2])]).T * generator.uniform(0.2, 6, (len(q0), 1))
            if kind["curve"] == "reeds_shepp":
                ahead *= generator.choice([-1, 1], (len(q0), 1))
            ways[:, :2] = (ways[:, :2] * 0.1 + ahead) / 2
        q1 = q0 + ways * ([2, 2, 0.7, *[0.3] * (q0.shape[1] - 3)] if checker.robot.is_free else 0.5)
        proofs = checker.certify_motions(q0, q1, **kind)
        found += [(a, b, proof) for a, b, proof in zip(q0, q1, proofs, strict=True) if proof is not None]
        if len(found) >= n:
            return found[:n]
    raise AssertionError("too few free motions")


def shipped(robot, scene):
    return P.Checker(P.Robot.load(robot), P.Scene.load(scene))


def changed(items, k, item):
    return (*items[:k], item, *items[k + 1 :])


def rehashed(proof, model):
    return replace(proof, model=model, hashes=hashes_of(model))
