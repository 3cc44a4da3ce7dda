"""Obstacles of an MJCF file, for `Scene.from_mjcf`.

In: a file and an empty scene. Out: the scene with the geoms that can collide and are no part of a robot (the world's,
and those of bodies that no joint moves), each an object of the geom's name; floors are half-spaces and height fields.
Geoms of the file's robot that MuJoCo does not test against an obstacle may touch it.
"""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np

from plannercheck.bodies.mjcf_files import MESH, read_mjcf
from plannercheck.bodies.mjcf_pairs import obstacle_geoms, robot_geoms, tested_pairs
from plannercheck.bodies.mjcf_shapes import check_flexes, mesh_of_geom, shape_of_geom
from plannercheck.scenes.contents import SceneContents
from plannercheck.scenes.scene_meshes import shape_of_triangles
from plannercheck.scenes.scene_paths import MeshKind


def read_mjcf_scene(scene: SceneContents, path: Path, meshes: MeshKind = "hull") -> None:
    """Fills a scene with the obstacles of an MJCF file, and names it after the model, or after the file."""
    file = read_mjcf(path)
    check_flexes(file)
    obstacles, names = obstacle_geoms(file), file.names["geom"]
    for geom in obstacles.tolist():
        shape = shape_of_geom(file, geom)
        if meshes == "solid" and file.geom_type[geom] == MESH:
            shape = shape_of_triangles(*mesh_of_geom(file, geom), meshes)
        scene.add(names[geom], shape, file.world_pose(int(file.geom_bodyid[geom])) @ file.geom_pose(geom))
    tested = {(a, b) for a, b in tested_pairs(file).tolist()}
    for geom in robot_geoms(file).tolist():
        link = file.names["body"][file.geom_bodyid[geom]]
        untested = (k for k in obstacles.tolist() if (min(geom, k), max(geom, k)) not in tested)
        scene.allowed.geometries |= {(link, names[geom], names[k]) for k in untested}
    scene.name = scene.name or file.name or path.stem
    moved = [file.names["body"][k] for k in np.flatnonzero((file.body_mocapid >= 0) & ~file.is_of_robot)]
    if moved:
        warnings.warn(
            f"MJCF {path}: mocap bodies stand where they begin: {', '.join(moved)}", RuntimeWarning, stacklevel=4
        )
    if not len(obstacles):
        warnings.warn(f"MJCF {path} has no obstacles that collide: the scene is empty", RuntimeWarning, stacklevel=4)
