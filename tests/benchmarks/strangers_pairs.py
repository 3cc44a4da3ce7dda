"""Pairs of URDFs and MoveIt scenes beside Pinocchio and coal: `python tests/benchmarks/strangers_pairs.py URDF … `.

Everything on the other side is written apart: Pinocchio's own `buildGeomFromUrdf` reads the robot, coal makes the
convex hulls of its meshes, PyYAML and this file read the scene's world (boxes, spheres, cylinders, with the convention
of MoveIt's collision_object message: a shape's pose is the object's pose times the primitive's). For each robot, random
configurations; every pair of bodies that `plannercheck` tests is held against coal's distance of the same two bodies.
A disagreement counts where coal is more than --room m away from contact: curved shapes are polytopes here, and coal
is no better than 1e-6 m. The exit code is 1 if there is one.
"""

from __future__ import annotations

import argparse
import sys
import time
import warnings
from pathlib import Path
from typing import Any

import coal
import numpy as np
import pinocchio as pin
import yaml

import plannercheck as pc


def world_of(path: Path) -> dict[str, list[tuple[Any, pin.SE3]]]:
    """Objects of a MoveIt scene, by name: coal's shapes and poses in the world."""
    document = yaml.load(path.read_text(encoding="utf-8"), Loader=yaml.CSafeLoader)
    objects: dict[str, list[tuple[Any, pin.SE3]]] = {}
    for item in document["world"]["collision_objects"]:
        own = pose_of(item["pose"]) if "pose" in item else pin.SE3.Identity()
        primitives = zip(item.get("primitives", []), item.get("primitive_poses", []), strict=True)
        objects[item["id"]] = [(shape_of(shape), own * pose_of(pose)) for shape, pose in primitives]
    return objects


def shape_of(primitive: dict[str, Any]) -> Any:
    """shape_msgs/SolidPrimitive: a box's sides, a sphere's radius, a cylinder's height and radius, m."""
    size = primitive["dimensions"]
    if primitive["type"] == "box":
        return coal.Box(*size)
    if primitive["type"] == "sphere":
        return coal.Sphere(size[0])
    return coal.Cylinder(size[1], size[0])


def pose_of(pose: dict[str, Any]) -> pin.SE3:
    """geometry_msgs/Pose, as lists or as mappings."""
    position, turn = pose["position"], pose["orientation"]
    if isinstance(position, dict):
        position, turn = [position[k] for k in "xyz"], [turn[k] for k in "xyzw"]
    return pin.SE3(pin.Quaternion(np.array(turn, dtype=float)).normalized().matrix(), np.array(position, dtype=float))


def hull_of(geometry: Any) -> Any:
    """A mesh's convex hull by coal; other shapes as they are."""
    if isinstance(geometry, coal.BVHModelBase):
        geometry.buildConvexHull(True, "Qt")
        return geometry.convex
    return geometry


class Others:
    """Pinocchio and coal on one robot and scene."""

    def __init__(self, urdf: Path, packages: list[Path], scene: Path | None) -> None:
        """Reads both."""
        self.model = pin.buildModelFromUrdf(str(urdf))
        folders = [str(folder) for folder in (*packages, *urdf.resolve().parents)]
        self.geometry = pin.buildGeomFromUrdf(self.model, str(urdf), pin.GeometryType.COLLISION, folders)
        self.data, self.geometry_data = self.model.createData(), self.geometry.createData()
        self.hulls = [hull_of(item.geometry) for item in self.geometry.geometryObjects]
        self.world = {} if scene is None else world_of(scene)
        self.links: dict[str, list[int]] = {}
        for k, item in enumerate(self.geometry.geometryObjects):
            self.links.setdefault(self.model.frames[item.parentFrame].name, []).append(k)

    def pose(self, q: np.ndarray) -> None:
        """Poses the robot at Pinocchio's q."""
        pin.updateGeometryPlacements(self.model, self.data, self.geometry, self.geometry_data, q)

    def bodies(self, name: str) -> list[tuple[Any, pin.SE3]]:
        """Shapes of a link or an object, and where they are."""
        if name in self.world:
            return self.world[name]
        return [(self.hulls[k], self.geometry_data.oMg[k]) for k in self.links.get(name, [])]

    def distance(self, first: str, second: str) -> float:
        """The least distance of two links or objects, m; below 0 where they overlap."""
        found = np.inf
        request, result = coal.DistanceRequest(), coal.DistanceResult()
        for a, at in self.bodies(first):
            for b, bt in self.bodies(second):
                result.clear()
                to = [coal.Transform3s(pose.rotation, pose.translation) for pose in (at, bt)]
                found = min(found, coal.distance(a, to[0], b, to[1], request, result))
        return found


def compared(urdf: Path, packages: list[Path], scene: Path | None, states: int, room: float) -> tuple[int, int, int]:
    """Pairs compared, those near contact, and disagreements."""
    others = Others(urdf, packages, scene)
    robot = pc.Robot.from_urdf(urdf, package_dirs=packages)
    checker = pc.Checker(robot, pc.Scene() if scene is None else pc.Scene.load(scene))
    q = robot.random_configurations(states, np.random.default_rng(0))
    hit = checker.colliding_pairs(q)
    names = [checker.pair_names(k) for k in range(len(checker.pairs))]
    rows: dict[tuple[str, str], list[int]] = {}
    for k, pair in enumerate(names):
        rows.setdefault(pair, []).append(k)
    near = wrong = 0
    for full, row in zip(robot.expand(q), hit, strict=True):
        others.pose(full)
        for pair, columns in rows.items():
            theirs = others.distance(*pair)
            near += abs(theirs) <= room
            if abs(theirs) > room and bool(row[columns].any()) != (theirs < 0):
                wrong += 1
                print(f"{urdf.name}: {' and '.join(pair)}: coal {theirs:.6g} m, here {bool(row[columns].any())}")
    return len(rows) * len(q), near, wrong


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("urdfs", nargs="+", type=Path)
    parser.add_argument("--scene", type=Path, help="a MoveIt planning scene in YAML")
    parser.add_argument("--package-dirs", nargs="*", type=Path, default=[])
    parser.add_argument("--states", type=int, default=20)
    parser.add_argument("--room", type=float, default=1e-4, help="m")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    totals, began = np.zeros(3, dtype=int), time.perf_counter()
    for urdf in options.urdfs:
        try:
            found = compared(urdf, options.package_dirs, options.scene, options.states, options.room)
        except (pc.PlannercheckError, ValueError, RuntimeError) as error:
            print(f"{urdf.name}: not compared: {error!s:.200}")
            continue
        print(
            f"{urdf.name}: {found[0]} pairs, {found[1]} within {options.room} m, {found[2]} disagreements", flush=True
        )
        totals += found
    print(f"all: {totals[0]} pairs, {totals[1]} near, {totals[2]} disagreements, {time.perf_counter() - began:.0f} s")
    return int(totals[2] > 0)


if __name__ == "__main__":
    sys.exit(main())
