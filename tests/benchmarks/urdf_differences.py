"""Reads every URDF below folders with plannercheck and with yourdfpy, and says where the two differ.

In: folders. Out: a line for each file that differs, a table by kind with an explanation, and the exit code 1 if a
difference has none. Compared are links, moving joints with their axes and limits, poses of all links at a random
configuration, and of each <collision> its place, its kind, its sizes, and the file and scale of a mesh.

    pip install yourdfpy
    python tests/benchmarks/urdf_differences.py FOLDER …
"""

import argparse
import sys
import warnings
from collections import Counter
from pathlib import Path

import numpy as np
import yourdfpy

import plannercheck as pc
from plannercheck.robots.configurations import NO_LIMIT
from plannercheck.robots.geometry_elements import MeshReference, geometry_elements
from plannercheck.robots.urdf_file import UrdfFile

REFUSED = "plannercheck refuses the file, with the element that is wrong"
EXPLAINED = {
    "refused": REFUSED,
    "not read by yourdfpy": "yourdfpy raises an exception; Pinocchio reads the file as plannercheck does",
    "mimic": "without a group, configurations are Pinocchio's, in which mimic joints move on their own",
}
NEAR = 1e-9


def differences(path: Path, packages: list[Path]) -> list[str]:
    """The kinds of differences of one file."""
    try:
        robot = pc.Robot.from_urdf(path, package_dirs=packages)
    except pc.PlannercheckError:
        return ["refused"]
    try:
        other = yourdfpy.URDF.load(
            str(path), build_scene_graph=True, load_meshes=False, build_collision_scene_graph=False
        )
    except Exception:  # of several unrelated types
        return ["not read by yourdfpy"]
    found = [] if set(other.link_map) == set(robot.link_names) else ["links"]
    moving = [joint for joint in other.robot.joints if joint.type != "fixed"]
    found += [] if {joint.name for joint in moving} == set(robot.joint_names) else ["joints"]
    if not found:
        found = _of_limits(robot, moving) + _of_poses(robot, other) + _of_shapes(path, robot, other)
    return found


def _of_limits(robot: pc.Robot, moving: list[yourdfpy.Joint]) -> list[str]:
    column = dict(zip(robot.joint_names, robot.configuration_map.starts, strict=True))
    for joint in moving:
        if joint.type not in ("revolute", "prismatic"):
            continue
        ours = robot.lower[column[joint.name]], robot.upper[column[joint.name]]
        given = () if joint.limit is None else (joint.limit.lower or 0.0, joint.limit.upper or 0.0)
        if ours != tuple(x if abs(x) <= NO_LIMIT else np.copysign(np.inf, x) for x in given):
            return ["limits"]
    return []


def _of_poses(robot: pc.Robot, other: yourdfpy.URDF) -> list[str]:
    if any(joint.type in ("planar", "floating") for joint in other.robot.joints):
        return []  # yourdfpy holds them still
    values = np.random.default_rng(0).uniform(-1, 1, len(robot.joint_names))
    q, named = [], {}
    for name, value in zip(robot.joint_names, values.tolist(), strict=True):
        q += [np.cos(value), np.sin(value)] if other.joint_map[name].type == "continuous" else [value]
        named[name] = value
    followers = [joint for joint in other.robot.joints if joint.mimic is not None]
    if followers:
        return ["mimic"]
    other.update_cfg(named)
    poses = robot.link_poses(np.array(q))
    theirs = np.array([other.get_transform(name, other.base_link) for name in robot.link_names])
    return ["poses"] if len(theirs) and np.abs(poses - theirs).max() > NEAR else []


def _of_shapes(path: Path, robot: pc.Robot, other: yourdfpy.URDF) -> list[str]:
    of_link: dict[str, list[pc.Part]] = {}
    for body in robot.bodies:
        of_link.setdefault(str(body.link), []).append(body)
    ours: dict[str, list[object]] = {}
    for link, element in geometry_elements(UrdfFile.read(path).root, "collision"):
        ours.setdefault(link, []).append(element)
    for name, link in other.link_map.items():
        bodies, shapes = of_link.get(name, []), ours.get(name, [])
        if len(link.collisions) != len(bodies):
            return ["number of shapes"]
        for given, body, shape in zip(link.collisions, bodies, shapes, strict=True):
            place = np.eye(4) if given.origin is None else given.origin
            if np.abs(place - body.pose).max() > NEAR:
                return ["places of shapes"]
            if not _same(given.geometry, shape):
                return ["shapes"]
    return []


def _same(theirs: yourdfpy.Geometry, ours: object) -> bool:
    if theirs.box is not None:
        return isinstance(ours, pc.Box) and np.allclose(theirs.box.size, ours.size, rtol=0, atol=0)
    if theirs.sphere is not None:
        return isinstance(ours, pc.Sphere) and theirs.sphere.radius == ours.radius
    if theirs.cylinder is not None:
        known = isinstance(ours, pc.Cylinder | pc.Capsule)  # as <collision_checking> says
        return known and (theirs.cylinder.radius, theirs.cylinder.length) == (ours.radius, ours.length)
    scale = 1.0 if theirs.mesh is None or theirs.mesh.scale is None else theirs.mesh.scale
    return isinstance(ours, MeshReference) and np.array_equal(np.broadcast_to(scale, 3), ours.scale)


def main(folders: list[Path]) -> int:
    """Compares all files."""
    warnings.simplefilter("ignore")
    kinds, count = Counter[str](), 0
    for folder in folders:
        for path in sorted(folder.rglob("*.urdf")):
            count += 1
            for kind in differences(path, [folder]):
                kinds[kind] += 1
                if kind not in EXPLAINED or kind == "refused":
                    print(f"{kind}: {path}")
    print(f"{count} files")
    for kind, number in kinds.most_common():
        print(f"{number:5} {kind}: {EXPLAINED.get(kind, 'UNEXPLAINED')}")
    return int(any(kind not in EXPLAINED for kind in kinds))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+", type=Path)
    sys.exit(main(parser.parse_args().folders))
