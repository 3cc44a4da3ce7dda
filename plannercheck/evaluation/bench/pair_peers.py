"""Other libraries as judges of pairs of posed bodies: coal in two ways, python-fcl, MuJoCo.

In: two bodies. Out: functions that take poses and make a `Judge`. Objects and poses are ready; only the test of each
pair is timed. No library may use a pair's last answer: in rounds of the same pairs, that would be the answer.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import numpy as np

from plannercheck.bodies.coal_bodies import coal_hull
from plannercheck.bodies.fcl_bodies import fcl_hull, load_fcl
from plannercheck.bodies.polytope import Polytope
from plannercheck.common.array_types import Bools, Floats
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.bench.coal_loop import COLD_VARIANTS, CoalLoop, PosedBodies, fastest_loop

Posed = tuple[Floats, Floats]
Bodies = tuple[Polytope, Polytope]

COAL, COAL_AT_BEST = "coal, C++ loop", "coal at its best"
# How far apart bodies are at most for MuJoCo to measure it, m: it stops where they are farther.
_MUJOCO_RANGE = 1e-6


@dataclass(frozen=True)
class Judge:
    """Pairs at given poses, ready to be judged by one method.

    Attributes:
        work: What is timed.
        verdicts: Reads, from what `work` returned, which pairs share a point.
        note: How it was asked, where that differs from run to run.
    """

    work: Callable[[], Any]
    verdicts: Callable[[Any], Bools]
    note: str = ""

    def __call__(self) -> Bools:
        """The verdicts."""
        return self.verdicts(self.work())


JudgeMaker = Callable[[Posed], Judge]


def coal_in_pinocchio(bodies: Bodies) -> JudgeMaker:
    """Pairs of posed bodies in a geometry model without a robot, judged by Pinocchio's own loop."""
    import coal
    import pinocchio as pin

    shapes = [coal_hull(body, "a round body") for body in bodies]

    def posed_judge(posed: Posed) -> Judge:
        model, geometry = pin.Model(), pin.GeometryModel()
        for k, poses in enumerate(zip(*posed, strict=True)):
            pair = [
                geometry.addGeometryObject(pin.GeometryObject(f"{k} {i}", 0, pin.SE3(pose), shape))
                for i, (pose, shape) in enumerate(zip(poses, shapes, strict=True))
            ]
            geometry.addCollisionPair(pin.CollisionPair(*pair))
        data, geometry_data = model.createData(), geometry.createData()
        for request in geometry_data.collisionRequests:
            request.enable_contact = False
            request.gjk_initial_guess = coal.GJKInitialGuess.DefaultGuess
            _start_cold(request)
        pin.updateGeometryPlacements(model, data, geometry, geometry_data, pin.neutral(model))

        return Judge(
            lambda: pin.computeCollisions(geometry, geometry_data, False),
            lambda found: np.array([result.isCollision() for result in geometry_data.collisionResults], dtype=bool),
        )

    return posed_judge


def _start_cold(request: Any) -> None:
    """Pinocchio keeps each pair's last answer as its next guess: in rounds of the same pairs, that is the answer."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # coal keeps the old switch, and Pinocchio sets it
        request.enable_cached_gjk_guess = False


def coal_at_best(bodies: Bodies) -> JudgeMaker:
    """The loop of coal_loop.cpp, which asks for no more than a separating plane; of meshes for no contact."""
    both = np.array([True, True])
    pair = PosedBodies(bodies, (None, None), both, np.array([[0, 1]]), ("a body", "another body"))
    make = cache(partial(CoalLoop, pair, np.tile(np.eye(4), (2, 1, 1))))
    make("OBBRSS")
    of_meshes = all(body.solid is not None for body in bodies)
    variants = [each for each in COLD_VARIANTS if not (of_meshes and (each.gjk or each.guess))]

    def posed_judge(posed: Posed) -> Judge:
        poses = np.stack(posed, axis=1)
        loop, variant = fastest_loop(make, lambda loop, first: loop.posed(poses[:first]), variants)
        states = loop.posed(poses)
        meshes = f", meshes in {loop.mesh_boxes}" if loop.has_meshes else ""
        return Judge(lambda: loop.check(states, variant), lambda found: ~found, f"{variant}{meshes}")

    return posed_judge


def fcl_ready(bodies: Bodies) -> JudgeMaker:
    """FCL's objects at their poses, asked from Python."""
    fcl = load_fcl()
    shapes = [fcl_hull(body.vertices, body.faces) for body in bodies]
    request = fcl.CollisionRequest(num_max_contacts=1, enable_contact=False)

    def posed_judge(posed: Posed) -> Judge:
        pairs = [
            [fcl.CollisionObject(s, fcl.Transform(m[:3, :3], m[:3, 3])) for s, m in zip(shapes, poses, strict=True)]
            for poses in zip(*posed, strict=True)
        ]
        return Judge(
            lambda: [fcl.collide(p, r, request, fcl.CollisionResult()) > 0 for p, r in pairs],
            lambda found: np.array(found, dtype=bool),
            "from Python, objects ready",
        )

    return posed_judge


def mujoco_ready(bodies: Bodies) -> JudgeMaker:
    """MuJoCo's `mj_geomDistance` between two geoms of one model, asked from Python; vertices are floats there."""
    try:
        import mujoco
    except ImportError as error:
        raise PlannercheckError("comparing with MuJoCo needs its package: pip install mujoco") from error

    def posed_judge(posed: Posed) -> Judge:
        model = mujoco_model(mujoco, bodies, posed)
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        distance, pairs = mujoco.mj_geomDistance, [(2 * k, 2 * k + 1) for k in range(len(posed[0]))]
        return Judge(
            lambda: [distance(model, data, p, r, _MUJOCO_RANGE, None) for p, r in pairs],
            lambda found: np.array(found) <= 0,
            "from Python, geoms ready, in floats; depths of overlaps are found as well",
        )

    return posed_judge


def mujoco_model(mujoco: Any, bodies: Bodies, posed: Posed) -> Any:
    """A model with both bodies of each pair as geoms of the world."""
    spec = mujoco.MjSpec()
    for k, body in enumerate(bodies):
        mesh = spec.add_mesh(name=f"body {k}")
        mesh.uservert = body.vertices.ravel()
        mesh.userface = np.asarray(body.faces, dtype=np.int32).ravel()
    for poses in zip(*posed, strict=True):
        for k, pose in enumerate(poses):
            turn = np.zeros(4)
            mujoco.mju_mat2Quat(turn, np.ascontiguousarray(pose[:3, :3]).ravel())
            kind = mujoco.mjtGeom.mjGEOM_MESH
            spec.worldbody.add_geom(type=kind, meshname=f"body {k}", pos=pose[:3, 3], quat=turn)
    return spec.compile()


# By name, in the order of a table.
PEERS: Sequence[tuple[str, Callable[[Bodies], JudgeMaker]]] = (
    (COAL, coal_in_pinocchio),
    (COAL_AT_BEST, coal_at_best),
    ("python-fcl", fcl_ready),
    ("MuJoCo, mj_geomDistance", mujoco_ready),
)
