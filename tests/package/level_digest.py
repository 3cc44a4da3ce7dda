"""Hashes of what must not depend on the instruction set: `PLANNERCHECK_LEVEL=v2 python tests/package/level_digest.py`.

Out: one line of JSON with a hash each of serialised bodies, verdicts and stages on stress pairs, link poses, and
verdicts on robot states (in batches, and one by one, which other code judges), motions, planar motions.
"""

import hashlib
import itertools
import json

import numpy as np

import plannercheck as pc
from plannercheck.bodies.tuning import METHODS, pair_options
from plannercheck.common.core import core
from plannercheck.evaluation.stress.random_cases import Draw, draws

DRAWS, STATES = 60, 2000
ROBOTS = ("panda", "ur5", "talos")


def stress_draws() -> list[Draw]:
    return list(itertools.islice(draws(2026), DRAWS))


def digest(parts: list[bytes]) -> str:
    return hashlib.sha256(b"".join(parts)).hexdigest()


def of_bodies(drawn: list[Draw]) -> str:
    return digest([body.polytope.core.serialise() for d in drawn for body in (d.p, d.r)])


def of_pairs(drawn: list[Draw]) -> str:
    parts = []
    for d in drawn:
        for method in METHODS:
            found = core.intersect_batch(
                d.p.polytope.core, d.poses_p, d.r.polytope.core, d.poses_r, pair_options(method)
            )
            parts += [found[0].tobytes(), found[1].tobytes()]
    return digest(parts)


def of_poses() -> str:
    robots = [pc.Robot.load(name) for name in ROBOTS]
    return digest([robot.link_poses(robot.random_configurations(STATES, 1)).tobytes() for robot in robots])


def of_states() -> str:
    robot = pc.Robot.load("panda")
    checker = pc.Checker(robot, pc.Scene.load("bookshelf"))
    q = robot.random_configurations(STATES, 2)
    first, pairs = checker.first_colliding_pair(q), checker.colliding_pairs(q)
    return digest([first.tobytes(), np.packbits(pairs).tobytes()])


def of_single_states() -> str:
    """Verdicts of configurations that are asked for one by one."""
    verdicts = []
    for name, scene in zip(ROBOTS, ("bookshelf", "kitchen", None), strict=True):
        checker = pc.Checker(pc.Robot.load(name), pc.Scene.load(scene) if scene else None)
        verdicts += [checker.is_valid(q) for q in checker.robot.random_configurations(STATES, 4)]
    return digest([bytes(verdicts)])


def of_motions() -> str:
    """Verdicts of motions together and one by one, and where those end that are explained."""
    checker = pc.Checker(pc.Robot.load("panda"), pc.Scene.load("bookshelf"))
    q = checker.robot.random_configurations(STATES, 5)
    q = q[checker.check_states(q)]
    starts, ends = q[:-1], 0.8 * q[:-1] + 0.2 * q[1:]
    parts = [checker.check_motions(starts, ends).tobytes()]
    for a, b in zip(starts[:100], ends, strict=False):
        found = checker.explain_motion(a, b)
        parts += [bytes([checker.check_motion(a, b)]), repr((found.free, found.free_until)).encode()]
    return digest(parts)


def of_planar_motions() -> str:
    """Verdicts, where motions end, and what proves them, straight and on curves."""
    checker = pc.planar.Checker(pc.planar.Robot.load("truck_trailer"), pc.planar.Scene.load("parking"))
    q = checker.robot.random_configurations(400, 3)
    parts = [checker.check_motions(q[::2], q[1::2]).tobytes()]
    for a, b in zip(q[:20:2], q[1:20:2], strict=True):
        for how in ({}, {"curve": "reeds_shepp", "turning_radius": 6.0}):
            found = checker.explain_motion(a, b, proofs=True, **how)
            parts.append(repr((found.free, found.free_until, found.near_at)).encode())
            parts += [proof.normal.tobytes() + np.float64(proof.gap).tobytes() for proof in found.proofs]
    return digest(parts)


if __name__ == "__main__":
    given = stress_draws()
    print(
        json.dumps(
            {
                "bodies": of_bodies(given),
                "pairs": of_pairs(given),
                "poses": of_poses(),
                "states": of_states(),
                "single states": of_single_states(),
                "motions": of_motions(),
                "planar motions": of_planar_motions(),
            }
        )
    )
