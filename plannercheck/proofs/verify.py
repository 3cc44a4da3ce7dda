"""The verifier: confirms a proof of a motion in ball arithmetic, trusting nothing in it.

In: a proof. Out: a `Verification`. It shares no function with the checker. The builder of proofs in space asks
`EntryChecker` which of its candidates hold, and takes `parts_of` and `hashes_of` from here; the one in the plane takes
`hashes_of`. Tests hold the verifier against a builder that takes nothing from here.

The proof has to be well-formed (`well_formed.py`, `planar_well_formed.py`, `planar_curves.py`), its entries have to
tile [0, 1] for every pair, in parts all pairs of triangles or parts (`covers.py`, `nesting.py`), and every entry has to
hold (`entries.py`, `half_spaces.py`, `parts.py`, `planar_entries.py`) with links posed by the proof's own table of
joints (`chains.py`, `joint_motions.py`, `planar_paths.py`). A robot's files are read in exact numbers and
compared by `exact_placements.py`, `urdf_joints.py`, `urdf_trees.py`, `urdf_shapes.py` and `mesh_triangles.py`.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

from plannercheck.common.model_comparisons import model_comparison
from plannercheck.common.optional_imports import extra_module
from plannercheck.proofs.data import Entry, ProofData, Verification
from plannercheck.proofs.faults import UnprovedError

# The precision of ball arithmetic. In space it is one machine word, 11 bits more than a double; in the plane it is
# three words, since angles of up to 1e15 rad and lengths of up to 1e15 m need more.
_BITS = {"space": 64, "plane": 192}


def verified(proof: ProofData) -> Verification:
    """Confirms a proof, in space or in the plane, or says what stops it.

    Raises:
        PlannercheckError: If python-flint is not installed.
    """
    flint = extra_module("flint", "proofs", "proofs of motions")
    began, confirmed, fault = time.perf_counter(), 0, None
    bits, flint.ctx.prec = flint.ctx.prec, _BITS[proof.kind]
    try:
        check = _space(proof) if proof.kind == "space" else _plane(proof)
        for k, entry in enumerate(proof.entries):
            check(k, entry)
            confirmed += 1
    except UnprovedError as found:
        fault = str(found)
    except (ArithmeticError, ValueError) as found:  # numbers within the limits whose products are not
        fault = f"entry {confirmed} has numbers that can't be computed with: {found}"
    finally:
        flint.ctx.prec = bits
    return Verification(fault is None, fault, confirmed, time.perf_counter() - began)


def _space(proof: ProofData) -> Callable[[int, Entry], None]:
    """What raises `UnprovedError` at an entry that does not hold."""
    from plannercheck.proofs.entries import EntryChecker  # these need python-flint
    from plannercheck.proofs.well_formed import check_tiling, check_well_formed

    check_well_formed(proof)
    check_tiling(proof)
    checker = EntryChecker(proof)
    checker.check_nesting(proof.entries)
    return checker.check


def _plane(proof: ProofData) -> Callable[[int, Entry], None]:
    from plannercheck.proofs.planar_curves import check_motion  # these need python-flint
    from plannercheck.proofs.planar_entries import PlanarEntryChecker
    from plannercheck.proofs.planar_well_formed import check_tiling, check_well_formed

    check_well_formed(proof)
    check_motion(proof)
    check_tiling(proof)
    return PlanarEntryChecker(proof).check


def model_confirmed(
    proof: ProofData,
    robot: Any,
    scene: str | None,
    meshes: str = "hull",
    geometry: Any = None,
    mesh_units: str | None = None,
    others: Sequence[ProofData] = (),
) -> Verification:
    """Whether a proof's model is that of files; entries are not checked.

    Args:
        proof: In space or in the plane.
        robot: A shipped robot's name, a YAML or a URDF file, or its description.
        scene: A shipped scene's name or a file; None for the empty one.
        meshes: What meshes of the scene are, as for `Scene.load`.
        geometry: What meshes of the robot are, as for `Robot.load`; None for what its file says.
        mesh_units: How mesh files are read, as for `Robot.load` and `Scene.load`.
        others: More proofs of the same model: where something in the scene moves, the times of all are compared.

    Returns:
        Whether it is, or the first difference.

    Raises:
        PlannercheckError: If a file can't be read.
    """
    began, fault, compared = time.perf_counter(), None, tuple[str, ...]()
    try:
        _check_well_formed(proof)
        for each in others:
            _check_well_formed(each)
        motions = tuple(each.motion for each in (proof, *others))
        compared = model_comparison(proof.kind)(proof.model, robot, scene, meshes, geometry, mesh_units, motions)
    except UnprovedError as found:
        fault = str(found)
    return Verification(fault is None, fault, 0, time.perf_counter() - began, compared)


def _check_well_formed(proof: ProofData) -> None:
    if proof.kind == "space":
        from plannercheck.proofs.well_formed import check_well_formed
    else:
        from plannercheck.proofs.planar_well_formed import check_well_formed
    check_well_formed(proof)
