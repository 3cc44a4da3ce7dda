"""`Proof`: a proof of a motion that verifies, saves and loads itself.

In: a result of `explain_motion` or `certify_motions`, or a file. Out: the same data (`data.py`), a `Verification`
(`verify.py`), or a file (`files.py`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike

from plannercheck.common.checked_yaml import error_context
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.model_comparisons import joint_reader
from plannercheck.proofs.data import ProofData, Verification
from plannercheck.proofs.executed_messages import trajectory_proved
from plannercheck.proofs.files import from_document, read_document, save_proofs
from plannercheck.proofs.paths import path_proved
from plannercheck.proofs.verify import model_confirmed, verified


class Proof(ProofData):
    """A motion and the proof that it is free; see `ProofData` for its attributes."""

    def verify(
        self,
        robot: str | None = None,
        scene: str | None = None,
        path: str | Path | ArrayLike | None = None,
        *,
        meshes: str = "hull",
        geometry: str | Mapping[str, str] | None = None,
        mesh_units: str | None = None,
    ) -> Verification:
        """Confirms the claim in ball arithmetic, without the compiled core and the code that made the proof.

        Args:
            robot: If given, the model has to be that of this robot: the name of a shipped one, a YAML or a URDF file.
            scene: With `robot`: a shipped scene's name, or a file; None for the empty one.
            path: If given, the proof has to prove all of this path: a file, or configurations (k, columns); with
                `robot` they may have one number a joint. A file of several proofs is compared with a path by
                `plannercheck.proofs.verify_path`.
            meshes: What meshes of the scene are, as for `Scene.load`.
            geometry: What meshes of the robot are, as for `Robot.load`; None for what its YAML says.
            mesh_units: How mesh files are read, as for `Robot.load` and `Scene.load`.

        Returns:
            The verification; a proof with malformed numbers is not proved.

        Raises:
            PlannercheckError: If python-flint is not installed, a file can't be read, or a scene is given without a
                robot.
        """
        if robot is None and (scene, meshes, geometry, mesh_units) != (None, "hull", None, None):
            raise PlannercheckError(
                "scene=, meshes=, geometry= and mesh_units= are compared with robot=: give the robot, too"
            )
        if scene is None and meshes != "hull":
            raise PlannercheckError("meshes= says what meshes of the scene are: give the scene, too")
        found = verified(self)
        if found and robot is not None:
            model = model_confirmed(self, robot, scene, meshes, geometry, mesh_units)
            found = replace(model, entries=found.entries, seconds=found.seconds + model.seconds)
        if found and path is not None:
            missing = path_proved([self], path, robot=robot).fault
            found = replace(found, proved=missing is None, fault=missing)
        return found

    def save(self, path: str | Path) -> None:
        """Writes the proof; the file appears whole or not at all.

        Args:
            path: Ends in .json or .npz.

        Raises:
            PlannercheckError: If the file can't be written.
        """
        save_proofs([self], path)

    def __repr__(self) -> str:
        counts = f"{len(self.model.pairs)} pairs, {len(self.entries)} entries"
        return f"Proof({self.robot!r} in {self.scene!r}, {counts}, margin {self.margin:.4g} m)"

    @classmethod
    def load(cls, path: str | Path) -> Proof:
        """Reads a file of one proof.

        Args:
            path: Path of a file that `save` wrote.

        Returns:
            The proof with the same bits; it is not verified.

        Raises:
            PlannercheckError: If the file is no proof, is cut off, of another version, or of several motions.
        """
        proofs = load_proofs(path)
        if len(proofs) > 1:
            raise PlannercheckError(
                f"proof file {str(path)!r} holds {len(proofs)} motions: plannercheck.proofs.load_proofs reads them all"
            )
        return proofs[0]


def load_proofs(path: str | Path) -> tuple[Proof, ...]:
    """Reads the proofs of a file, without verifying them.

    Args:
        path: Path of a file that `save_proofs` or `Proof.save` wrote.

    Returns:
        One a motion, at least one.

    Raises:
        PlannercheckError: If the file is no proof, is cut off, or of another version.
    """
    with error_context(f"proof file {str(path)!r}"):
        return proofs_from_document(read_document(path))


def proofs_from_document(content: Any) -> tuple[Proof, ...]:
    """The proofs of a document (`files.py`); errors as of `load_proofs`."""
    return tuple(Proof(*(getattr(data, field.name) for field in fields(data))) for data in from_document(content))


def verify_path(proofs: Sequence[Proof], path: str | Path | ArrayLike, robot: str | None = None) -> Verification:
    """Confirms proofs, and that they prove every motion of a path, in order, end to end.

    Args:
        proofs: Of one file, at least one.
        path: A path file, or configurations (k, columns).
        robot: For paths of one number a joint, where joints follow others or turn without end: the robot, as for
            `Proof.verify`. It is not compared with the proofs.

    Returns:
        The verification; `fault` is that of the first proof that fails, or names what is missing of the path.

    Raises:
        PlannercheckError: If python-flint is not installed, or the file can't be read.
    """
    return _with_all(proofs, lambda: path_proved(proofs, path, robot=robot).fault)


def verify_trajectory(
    proofs: Sequence[Proof],
    path: str | Path,
    controller: str = "jtc",
    tube: float | Sequence[float] = 0.0,
    start: Sequence[float] | None = None,
    start_time: float = 0.0,
    robot_columns: int | None = None,
    robot: str | None = None,
) -> Verification:
    """Confirms proofs, and that they prove a trajectory as a controller runs it, piece by piece.

    Args:
        proofs: Of one file, at least one.
        path: A file that `pc.Trajectory.load` reads.
        controller: "jtc" (joint_trajectory_controller of ros2_control), "jtc-upsampled", "ur", "motoros2", or "linear".
        tube: How far each number may be off the curve at any instant, rad and m: one number, or one a column.
        start: (columns,) where the robot stands, at rest, rad and m: the first proof is then of the way from there to
            the first point, unless this point is at 0 s. None: the first point.
        start_time: The scene's clock where the trajectory begins, s; without effect where nothing moves.
        robot_columns: How many columns are the robot's (`Robot.nq`), the first ones; needed where something moves. The
            others are as the proofs have them: `Proof.verify(robot=, scene=)` compares them.
        robot: The robot, as for `Proof.verify`, for messages with joints that follow others. It is not compared with
            the proofs.

    Returns:
        The verification, as of `verify_path`.

    Raises:
        PlannercheckError: If python-flint is not installed, or the file can't be read or is run by no controller.
    """
    joints = None if robot is None else joint_reader()(robot)
    given = path, controller, tube, start, None, start_time, robot_columns, joints
    return _with_all(proofs, lambda: trajectory_proved(proofs, *given).fault)


def _with_all(proofs: Sequence[Proof], missing: Callable[[], str | None]) -> Verification:
    """The verification of several proofs, and of what they are asked to prove together."""
    found = [proof.verify() for proof in proofs]
    fault = next((each.fault for each in found if not each), None) or missing()
    return Verification(fault is None, fault, sum(each.entries for each in found), sum(each.seconds for each in found))
