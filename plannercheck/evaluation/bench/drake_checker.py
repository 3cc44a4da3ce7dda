"""drake's SceneGraphCollisionChecker over a checker's bodies.

In: a checker of hulls and simple shapes. Out: a judge of states. Pinocchio's joints become drake's, one body each; the
checker's hulls, spheres and boxes become convex shapes on them. Bodies of which the checker tests no pair are filtered.
"""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import distinct
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.bench.other_libraries import Judge, joint_of
from plannercheck.evaluation.bench.solid_checkers import has_solids
from plannercheck.motions.checker import Checker


def drake(checker: Checker) -> Judge:
    """Judges states by drake; errors as of `drake_model`."""
    made = drake_model(checker)

    def judge(q: Floats) -> NDArray[np.bool_]:
        return np.array([made.CheckConfigCollisionFree(row) for row in checker.robot.expand(q)], dtype=bool)

    return judge


def drake_model(checker: Checker) -> Any:
    """Drake's SceneGraphCollisionChecker.

    Raises:
        PlannercheckError: If drake is not installed, or a body or a joint has no counterpart here.
    """
    planning = _module("planning")
    if has_solids(checker) or any(polytope is None for polytope in checker.polytopes):
        raise PlannercheckError("drake is compared on hulls alone")
    builder = planning.RobotDiagramBuilder()
    plant = builder.plant()
    bodies = _add_joints(plant, checker.robot.model)
    _add_shapes(plant, bodies, checker)
    plant.Finalize()
    robot = plant.GetModelInstanceByName("robot")
    made = planning.SceneGraphCollisionChecker(
        model=builder.Build(), robot_model_instances=[robot], edge_step_size=0.05, implicit_context_parallelism=False
    )
    _filter(made, bodies, checker)
    return made


def _add_joints(plant: Any, model: Any) -> list[Any]:
    """Drake's body of each of Pinocchio's joints, the world first."""
    import pinocchio as pin

    tree, placed = _module("multibody.tree"), _module("math").RigidTransform
    instance = plant.AddModelInstance("robot")
    bodies, data = [plant.world_body()], model.createData()
    for k in range(1, model.njoints):
        joint, name = model.joints[k], model.names[k]
        if joint.nq != 1:
            raise PlannercheckError(f"joint {name!r} takes {joint.nq} numbers: drake is compared on joints of one")
        placement = placed(model.jointPlacements[k].homogeneous)
        before = bodies[model.parents[k]].body_frame()
        parent = plant.AddFrame(tree.FixedOffsetFrame(f"{name} on its parent", before, placement))
        body = plant.AddRigidBody(f"after {name}", instance, tree.SpatialInertia.SolidSphereWithMass(1.0, 0.1))
        pin.forwardKinematics(model, data, pin.neutral(model), np.eye(model.nv)[joint.idx_v])
        slide, turn = data.v[k].linear, data.v[k].angular
        made = tree.RevoluteJoint if np.any(turn) else tree.PrismaticJoint
        plant.AddJoint(made(name, parent, body.body_frame(), turn if np.any(turn) else slide))
        bodies.append(body)
    return bodies


def _add_shapes(plant: Any, bodies: list[Any], checker: Checker) -> None:
    geometry, placed = _module("geometry"), _module("math").RigidTransform
    for k in distinct(checker.pairs).tolist():
        polytope, body = checker.polytopes[k], checker.bodies[k]
        assert polytope is not None
        joint, placement = joint_of(checker, body)
        points, pose = np.asarray(polytope.vertices), placed(placement.homogeneous)
        if len(points) == 1:
            shape, pose = geometry.Sphere(polytope.inflation_radius), pose @ placed(points[0])
        elif polytope.inflation_radius:
            raise PlannercheckError(f"drake has no inflated hull, as {body.name!r} is one")
        else:
            shape = geometry.Convex(points.T, f"{k}")
        plant.RegisterCollisionGeometry(bodies[joint], pose, shape, f"{k}", geometry.ProximityProperties())


def _filter(made: Any, bodies: list[Any], checker: Checker) -> None:
    """Leaves out pairs of bodies of which the checker tests no pair."""
    joints = [joint_of(checker, body)[0] for body in checker.bodies]
    tested = {frozenset((joints[a], joints[b])) for a, b in checker.pairs.tolist()}
    for a in range(1, len(bodies)):
        for b in range(a):
            if made.IsPartOfRobot(bodies[a]) and frozenset((a, b)) not in tested:
                made.SetCollisionFilteredBetween(bodies[a], bodies[b], True)


def _module(name: str) -> Any:
    try:
        return importlib.import_module(f"pydrake.{name}")
    except ImportError as error:
        raise PlannercheckError(f"drake is not installed: pip install drake ({error})") from None
