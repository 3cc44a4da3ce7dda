"""Time a state, beside Pinocchio with coal: `python tests/benchmarks/states.py [--robot panda] [--scene bookshelf]`.

The same uniformly random configurations through plannercheck (a batch, and one by one from Python) and through
Pinocchio's `computeCollisions` with coal on the same hulls, with its dynamic AABB tree and over all pairs, stopping at
the first collision. Peer and project take turns (A B … B A) in one process; the least time of each counts.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import coal
import numpy as np
import pinocchio as pin

import plannercheck as pc
from plannercheck.robot_files import find_description, read_description
from plannercheck.shapes import Body, Box, Capsule, Cone, Cylinder, Sphere
from plannercheck.urdf import read_geometry

ROUNDS = 15


def coal_shape(body: Body) -> coal.CollisionGeometry:
    """The same shape in coal, without a polytope around it."""
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
    points = coal.StdVec_Vec3s()
    points.extend(list(body.shape.vertices_and_faces()[0]))
    return coal.ConvexBase.convexHull(points, True, "Qt")


def geometry_of(checker: pc.Checker) -> pin.GeometryModel:
    """The checker's bodies and pairs as Pinocchio's geometries: links as convex hulls, obstacles fixed to the world."""
    robot = checker.robot
    description = read_description(find_description(robot.name))
    geometry = read_geometry(robot.model, description.urdf, description.package_dirs)
    for item in geometry.geometryObjects:
        if isinstance(item.geometry, coal.BVHModelBase):
            item.geometry.buildConvexHull(True, "Qt")
            item.geometry = item.geometry.convex
    for body in checker.scene.bodies:
        geometry.addGeometryObject(pin.GeometryObject(body.name, 0, pin.SE3(np.array(body.pose)), coal_shape(body)))
    for a, b in checker.pairs.tolist():
        geometry.addCollisionPair(pin.CollisionPair(a, b))
    return geometry


def contenders(checker: pc.Checker, q: np.ndarray) -> dict[str, Callable[[], list[bool]]]:
    """Functions that judge all configurations: True means valid."""
    model, geometry = checker.robot.model, geometry_of(checker)
    full = checker.robot.expand(q)
    data, geometry_data = model.createData(), geometry.createData()
    for request in geometry_data.collisionRequests:
        request.enable_contact = False
    tree = pin.BroadPhaseManager_DynamicAABBTreeCollisionManager(model, geometry, geometry_data)
    return {
        "plannercheck, batch": lambda: checker.check_states(q).tolist(),
        "plannercheck, one by one": lambda: [checker.is_valid(row) for row in q],
        "Pinocchio + coal, AABB tree": lambda: [
            not pin.computeCollisions(model, data, tree, row, True) for row in full
        ],
        "Pinocchio + coal, all pairs": lambda: [
            not pin.computeCollisions(model, data, geometry, geometry_data, row, True) for row in full
        ],
    }


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robot", default="panda")
    parser.add_argument("--scene", default="bookshelf")
    parser.add_argument("--states", type=int, default=2000)
    options = parser.parse_args()
    checker = pc.Checker(pc.Robot.load(options.robot), pc.Scene.load(options.scene))
    q = checker.robot.random_configurations(options.states, 0)
    judges = contenders(checker, q)
    best = dict.fromkeys(judges, np.inf)
    verdicts = {}
    for turn in range(ROUNDS):
        for name in list(judges) if turn % 2 == 0 else reversed(list(judges)):
            start = time.perf_counter()
            verdicts[name] = np.array(judges[name]())
            best[name] = min(best[name], time.perf_counter() - start)
    ours = verdicts["plannercheck, batch"]
    print(f"{options.robot} in {options.scene}: {len(checker.pairs)} pairs, {len(q)} states, {ours.mean():.0%} valid")
    for name, seconds in best.items():
        ratio, other = seconds / best["plannercheck, batch"], int((verdicts[name] != ours).sum())
        print(f"{name:28s} {seconds / len(q) * 1e6:8.2f} us a state  {ratio:6.1f} x  {other} verdicts differ")


if __name__ == "__main__":
    main()
