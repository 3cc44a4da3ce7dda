"""The meshes of a checker's bodies, for `plannercheck inspect`: what hulls, caps and pieces make of them.

In: a checker, the robot's description. Out: the meshes by name of the body, and lines on open, hollow and split ones.
"""

from __future__ import annotations

from collections.abc import Mapping

from plannercheck.bodies.hull_excess import excess_words
from plannercheck.bodies.mesh_files import MeshFile
from plannercheck.bodies.part_sets import PartSet
from plannercheck.bodies.shapes import Hull
from plannercheck.bodies.solids import Solid, open_meshes
from plannercheck.bodies.triangle_meshes import TriangleMesh
from plannercheck.motions.checker import Checker
from plannercheck.robots.description import RobotDescription
from plannercheck.robots.loading import collision_meshes
from plannercheck.scenes.scene_meshes import source_mesh


def mesh_files(checker: Checker, description: RobotDescription) -> dict[str, MeshFile]:
    """The meshes of a robot, and of the scene's objects from files, by name of the body."""
    found = collision_meshes(description)
    for item in (*checker.scene.objects, *checker.scene.attached):
        for part, body in zip(item.parts, item.bodies, strict=True):
            if part.source is not None and not isinstance(part.shape, PartSet):
                found[body.name] = source_mesh(*part.source)
    return found


def triangle_meshes(files: Mapping[str, MeshFile]) -> dict[str, TriangleMesh]:
    """The same as triangles."""
    return {name: TriangleMesh.of(mesh.points, mesh.triangles) for name, mesh in files.items()}


def show_meshes(checker: Checker, files: Mapping[str, MeshFile]) -> None:
    """Says what hulls add to meshes, and what was decomposed."""
    shapes = {body.name: body.shape for body in checker.bodies}
    hulls = {
        name: excess_words(files[name]) for name, shape in shapes.items() if isinstance(shape, Hull) and name in files
    }
    large = [f"{name}: {words}" for name, words in hulls.items() if words]
    if large:
        print("\nhulls that hold much more than their meshes:\n  " + "\n  ".join(large))
    is_open = [name for name, mesh in triangle_meshes(files).items() if mesh.volume is None and name in shapes]
    if is_open:
        print(f"\nopen meshes, whose volume means nothing (not watertight): {', '.join(is_open)}")
    words = open_meshes({name: shape for name, shape in shapes.items() if isinstance(shape, Solid)})
    if words:
        print(words)
    for name, pieces in checker.robot.pieces.items():
        volume = pieces.mesh_volume
        times = (
            ""
            if not volume
            else f", {pieces.volume / volume:.2f} times the mesh (its hull {pieces.hull_volume / volume:.2f})"
        )
        print(
            f"{name}: {len(pieces.points)} convex pieces{times}; they hold all its triangles, and stick out of "
            f"it by at most {1e3 * pieces.protrusion:.3g} mm"
        )
