"""One robot by its hulls, by its convex pieces and by its meshes, for comparing them.

In: a robot's description, whatever geometry it asks for. Out: the robot with all links alike. Pieces are taken only if
they come with plannercheck or are cached: CoACD is not run.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import replace

from plannercheck.bodies.convex_decomposition import Decomposition, known_pieces
from plannercheck.bodies.triangle_meshes import TriangleMesh
from plannercheck.robots.decomposed_links import is_concave
from plannercheck.robots.description import RobotDescription
from plannercheck.robots.link_geometry import Geometry
from plannercheck.robots.loading import collision_meshes
from plannercheck.robots.robot import Robot


def of_hulls(description: RobotDescription) -> Robot:
    """The robot with all meshes as their hulls."""
    return _with_geometry(description, "hull")


def of_meshes(description: RobotDescription) -> Robot:
    """The robot with all meshes as solids, open ones closed by caps."""
    return _with_geometry(description, "solid")


def of_triangles(description: RobotDescription) -> Robot:
    """The robot with all meshes as solids, open ones as their triangles alone."""
    return _with_geometry(description, "triangles")


def of_known_pieces(description: RobotDescription) -> tuple[Robot, tuple[str, ...]]:
    """The robot with concave meshes as pieces, and the links that keep their hulls, as none of them are known."""
    concave = {link: found for link, found in _meshes(description).items() if any(map(is_concave, found))}
    known = [link for link, found in concave.items() if all(map(_are_pieces_known, found))]
    robot = _with_geometry(description, dict.fromkeys(known, "pieces"))
    return robot, tuple(link for link in concave if link not in known)


def _are_pieces_known(mesh: TriangleMesh) -> bool:
    return known_pieces(mesh, Decomposition()) is not None


def _meshes(description: RobotDescription) -> Mapping[str, list[TriangleMesh]]:
    links = {body.name: str(body.link) for body in of_hulls(description).bodies}
    found: dict[str, list[TriangleMesh]] = {}
    for name, mesh in collision_meshes(description).items():
        found.setdefault(links[name], []).append(TriangleMesh.of(mesh.points, mesh.triangles))
    return found


def _with_geometry(description: RobotDescription, geometry: Geometry) -> Robot:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of open meshes, and what loading the robot itself has said
        return Robot.from_description(replace(description, geometry=geometry, decomposition=None))
