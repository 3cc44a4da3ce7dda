"""One robot by its hulls, by its convex pieces and by its meshes, for comparing them.

In: a robot's description, whatever geometry it asks for. Out: the robot with all links alike. Open meshes are their
triangles alone, not their hulls as for geometry="solid". Of pieces, those are taken that come with plannercheck or are
cached: CoACD is not run.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import replace

from plannercheck.bodies.convex_decomposition import Decomposition, known_pieces
from plannercheck.bodies.shapes import Hull
from plannercheck.bodies.triangle_meshes import TriangleMesh, triangles_of_coal
from plannercheck.robots.collision_geometry import collision_geometry
from plannercheck.robots.decomposed_links import is_concave
from plannercheck.robots.description import RobotDescription
from plannercheck.robots.link_geometry import Geometry
from plannercheck.robots.robot import Robot


def of_hulls(description: RobotDescription) -> Robot:
    """The robot with all meshes as their hulls."""
    return _with_geometry(description, "hull")


def of_meshes(description: RobotDescription) -> Robot:
    """The robot with all meshes as solids."""
    links = [str(body.link) for body in of_hulls(description).bodies if isinstance(body.shape, Hull)]
    return _with_geometry(description, dict.fromkeys(links, "solid"))


def of_known_pieces(description: RobotDescription) -> tuple[Robot, tuple[str, ...]]:
    """The robot with concave meshes as pieces, and the links that keep their hulls, as none of them are known."""
    concave = {link: found for link, found in _meshes(description).items() if any(map(is_concave, found))}
    known = [link for link, found in concave.items() if all(map(_are_pieces_known, found))]
    robot = _with_geometry(description, dict.fromkeys(known, "pieces"))
    return robot, tuple(link for link in concave if link not in known)


def _are_pieces_known(mesh: TriangleMesh) -> bool:
    return known_pieces(mesh, Decomposition()) is not None


def _meshes(description: RobotDescription) -> Mapping[str, list[TriangleMesh]]:
    """The meshes of each link."""
    robot = of_hulls(description)
    geometry = collision_geometry(description)
    found: dict[str, list[TriangleMesh]] = {}
    for body, each in zip(robot.bodies, geometry.geometryObjects, strict=True):
        mesh = triangles_of_coal(each.geometry)
        if mesh is not None and isinstance(body.shape, Hull):
            found.setdefault(str(body.link), []).append(mesh)
    return found


def _with_geometry(description: RobotDescription, geometry: Geometry) -> Robot:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of open meshes, and what loading the robot itself has said
        return Robot.from_description(replace(description, geometry=geometry, decomposition=None))
