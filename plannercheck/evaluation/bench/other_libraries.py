"""Other libraries as judges of the same states: Pinocchio with coal, and python-fcl.

In: a checker. Out: functions that judge rows of configurations, True meaning valid, over the checker's pairs, stopping
at a state's first collision. coal and FCL get the same hulls that the checker tests (and spheres, capsules, cylinders
and cones as such), with contacts switched off. Solids are meshes for coal, also those that are their hulls, as
Pinocchio loads them: surfaces, so that a body within a body does not collide. FCL is not asked about solids. Pinocchio
poses the robot for coal. For FCL the checker's batch kernel poses it, and boxes along the world's axes, in numpy, leave
out pairs that are far apart.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.coal_bodies import coal_hull, coal_mesh
from plannercheck.bodies.fcl_bodies import FclBodies
from plannercheck.bodies.part_sets import PartSet
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import Box, Capsule, Cone, Cylinder, GeometryObject, Sphere
from plannercheck.bodies.solids import Solid
from plannercheck.common.array_types import Floats
from plannercheck.common.arrays import distinct
from plannercheck.common.errors import PlannercheckError
from plannercheck.evaluation.bench.sensed_peers import coal_map, fcl_map
from plannercheck.evaluation.bench.solid_checkers import has_solids
from plannercheck.motions.checker import Checker

Judge = Callable[[Floats], NDArray[np.bool_]]

# coal's tolerance for GJK in m: its own default and the smallest it takes, and a coarse one.
COAL_TOLERANCES = (1e-6, 1e-3)


class CoalQuery:
    """Whether a state collides, by Pinocchio's `computeCollisions`, which stops at the first collision.

    Attributes:
        ask: The query, of all numbers of Pinocchio's model, and True.
    """

    def __init__(self, checker: Checker, tolerance: float = COAL_TOLERANCES[0], with_tree: bool = True) -> None:
        """Asks Pinocchio's dynamic AABB tree over all bodies, or pair by pair; `tolerance` is coal's, m."""
        import pinocchio as pin

        model, self._geometry = checker.robot.model, coal_geometry_model(checker)  # the tree keeps neither alive
        data, self._geometry_data = model.createData(), coal_geometry_data(self._geometry, tolerance)
        asked: tuple[Any, ...] = (self._geometry, self._geometry_data)
        if with_tree:
            asked = (pin.BroadPhaseManager_DynamicAABBTreeCollisionManager(model, *asked),)
        self.ask: Callable[[Floats, bool], bool] = partial(pin.computeCollisions, model, data, *asked)


def coal(checker: Checker, tolerance: float = COAL_TOLERANCES[0], with_tree: bool = True) -> Judge:
    """Pinocchio and coal, state by state; arguments as of `CoalQuery`."""
    query = CoalQuery(checker, tolerance, with_tree)

    def judge(q: Floats) -> NDArray[np.bool_]:
        ask = query.ask
        return np.array([not ask(row, True) for row in checker.robot.expand(q)], dtype=bool)

    return judge


def fcl(checker: Checker) -> Judge:
    """python-fcl pair by pair, on those whose boxes meet."""
    if has_solids(checker):
        raise PlannercheckError("python-fcl is compared on hulls alone")
    bodies = FclBodies(
        [None if p is None else (p.vertices, p.faces) for p in checker.polytopes],
        [0.0 if p is None else p.inflation_radius for p in checker.polytopes],
        {k: fcl_map(body.shape) for k, body in enumerate(checker.bodies) if isinstance(body.shape, PartSet)},
    )
    unknown = [checker.bodies[k].name for k in distinct(checker.pairs).tolist() if not bodies.known[k]]
    if unknown:
        raise PlannercheckError(f"python-fcl has no shape for {', '.join(unknown)}")

    def judge(q: Floats) -> NDArray[np.bool_]:
        poses = checker.body_poses(q)
        near = bodies.boxes_meet(poses, checker.pairs)
        rows = zip(poses, near, strict=True)
        return np.array([not _any_collides(bodies, pose, checker.pairs[row]) for pose, row in rows], dtype=bool)

    return judge


def _any_collides(bodies: FclBodies, poses: Floats, pairs: NDArray[Any]) -> bool:
    for body in distinct(pairs).tolist():
        bodies.place(body, poses[body])
    return any(bodies.collides(p, r) for p, r in pairs.tolist())


def coal_geometry_data(geometry: Any, tolerance: float) -> Any:
    """Data for collision queries without contacts at one of `COAL_TOLERANCES`, m."""
    data = geometry.createData()
    for request in data.collisionRequests:
        request.enable_contact = False
        request.gjk_tolerance = tolerance
    return data


def coal_geometry_model(checker: Checker) -> Any:
    """The checker's bodies and pairs as Pinocchio's geometries, on their links' joints or in the world."""
    import pinocchio as pin

    geometry = pin.GeometryModel()
    place: dict[int, int] = {}
    shapes: dict[int, Any] = {}
    for k in distinct(checker.pairs).tolist():
        body, polytope = checker.bodies[k], checker.polytopes[k]
        assert polytope is not None
        if id(polytope) not in shapes:  # equal shapes are one, as in the checker
            is_map = isinstance(body.shape, PartSet)
            shapes[id(polytope)] = coal_map(body.shape) if is_map else (coal_shape(body, polytope), np.eye(4))
        joint, placement = joint_of(checker, body)
        shape, own = shapes[id(polytope)]
        item = pin.GeometryObject(f"{k} {body.name}", joint, placement * pin.SE3(own), shape)
        place[k] = geometry.addGeometryObject(item)
    for a, b in checker.pairs.tolist():
        geometry.addCollisionPair(pin.CollisionPair(place[a], place[b]))
    return geometry


def joint_of(checker: Checker, body: GeometryObject) -> tuple[int, Any]:
    """The joint that a body hangs on, 0 for the world, and its placement there."""
    import pinocchio as pin

    placement = pin.SE3(np.array(body.pose))
    if body.link is None:
        return 0, placement
    model = checker.robot.model
    frame = model.frames[model.getBodyId(body.link)]
    return frame.parentJoint, frame.placement * placement


def coal_shape(body: GeometryObject, polytope: Polytope) -> Any:
    """The same shape in coal, without a polytope around a curved one."""
    import coal

    match body.shape:
        case Box(size=size):
            return coal.Box(*size)
        case Sphere(radius=radius):
            return coal.Sphere(radius)
        case Cylinder(radius=radius, length=length):
            return coal.Cylinder(radius, length)
        case Cone(radius=radius, length=length):
            return coal.Cone(radius, length)
        case Capsule(radius=radius, length=length):
            return coal.Capsule(radius, length)
        case Solid(used=(points, triangles)):
            return coal_mesh(points, triangles)
    return coal_hull(polytope, body.name)
