"""Compares the model in a proof in the plane with a robot's and a scene's files.

In: a well-formed model, a robot, a scene. Out: nothing, or an `UnprovedError` that names what differs. The files are in
plannercheck's own format, so its loader is trusted here; its kinematics and its verdicts are not.
"""

from __future__ import annotations

from plannercheck.common.errors import PlannercheckError
from plannercheck.planar.checker import Checker
from plannercheck.planar.proof_builder import planar_model
from plannercheck.planar.robot import Robot
from plannercheck.planar.scene import Scene
from plannercheck.proofs.faults import UnprovedError
from plannercheck.proofs.hashing import content_hash
from plannercheck.proofs.planar_proof import PlanarModel


def confirm_model(
    model: PlanarModel,
    robot: str,
    scene: str | None,
    meshes: str = "hull",
    geometry: object = None,
    mesh_units: object = None,
    motions: object = (),
) -> tuple[str, ...]:
    """Compares a model with files, bit for bit, except the circles around bodies, which were checked before.

    Args:
        model: The well-formed model of a proof in the plane.
        robot: Name of a shipped planar robot, or a YAML file.
        scene: Name of a shipped planar scene, or a scene file; None for the empty one.
        meshes: "hull": there are none in the plane.
        geometry: None, likewise.
        mesh_units: None, likewise.

        motions: Not looked at: no obstacle in the plane moves.

    Returns:
        What was compared with which file.

    Raises:
        UnprovedError: If they differ.
        PlannercheckError: If a file can't be read, or meshes are to be anything.
    """
    if meshes != "hull" or geometry is not None or mesh_units is not None:
        raise PlannercheckError(
            "robots and scenes in the plane have no meshes: leave out meshes=, geometry= and mesh_units="
        )
    loaded = planar_model(Checker(Robot.load(robot), Scene("empty") if scene is None else Scene.load(scene)))
    for name, given, known in zip(("links", "bodies", "configurations"), _parts(model), _parts(loaded), strict=True):
        if given != known:
            raise UnprovedError(f"the {name} of the proof are not those of the files")
    missing = {frozenset(pair) for pair in loaded.pairs} - {frozenset(pair) for pair in model.pairs}
    if missing:
        raise UnprovedError(
            f"{len(missing)} pairs of the checker's table are not in the proof: {sorted(min(missing, key=sorted))}"
        )
    where = "the empty scene" if scene is None else f"the scene {scene!r}"
    return (f"links, polygons and pairs, bit for bit, with what plannercheck loads of the robot {robot!r} and {where}",)


def _parts(model: PlanarModel) -> tuple[str, str, str]:
    """Hashes of everything that has to agree; bodies are hashed in order, since pairs are indices."""
    bodies = [(body.name, body.label, body.link, body.pose, body.vertices) for body in model.bodies]
    return content_hash(model.links), content_hash(bodies), content_hash(model.columns, model.whole_turns)
