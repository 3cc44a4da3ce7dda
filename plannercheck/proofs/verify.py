"""The verifier of motions in space: confirms a proof in ball arithmetic, trusting nothing in it.

In: a `Proof`. Out: a `Verification`. It has no function in common with what makes proofs, and none with the checker:
the proof has to be well-formed (`well_formed.py`), its entries have to tile [0, 1] for every pair, and every entry has
to hold (`entries.py`) where the proof's own table of joints puts the links (`chains.py`, `joint_motions.py`).
"""

from __future__ import annotations

import time
from typing import Any

from plannercheck.common.optional_imports import extra_module
from plannercheck.proofs.faults import UnprovedError
from plannercheck.proofs.proof import Model, Proof, Verification

# Of ball arithmetic: one machine word, 11 bits more than a double.
_BITS = 64


def verified(proof: Proof) -> Verification:
    """Confirms a proof.

    Args:
        proof: In space.

    Returns:
        Whether it is proved, or what stops it.

    Raises:
        PlannercheckError: If python-flint is not installed.
    """
    flint = extra_module("flint", "proofs", "proofs of motions")
    began, confirmed, fault = time.perf_counter(), 0, None
    bits, flint.ctx.prec = flint.ctx.prec, _BITS
    try:
        from plannercheck.proofs.entries import EntryChecker
        from plannercheck.proofs.well_formed import check_tiling, check_well_formed

        check_well_formed(proof)
        check_tiling(proof)
        checker = EntryChecker(proof)
        for k, entry in enumerate(proof.entries):
            if not checker.holds(entry):
                raise UnprovedError(f"entry {k} does not hold: {checker.described(entry)}")
            confirmed += 1
    except UnprovedError as found:
        fault = str(found)
    except (ArithmeticError, ValueError) as found:  # numbers within the limits whose products are not
        fault = f"entry {confirmed} has numbers that can't be computed with: {found}"
    finally:
        flint.ctx.prec = bits
    return Verification(fault is None, fault, confirmed, time.perf_counter() - began)


def model_confirmed(proof: Proof, robot: Any, scene: str | None) -> Verification:
    """Whether a proof's model is that of files.

    Args:
        proof: In space.
        robot: A shipped robot's name, a YAML or a URDF file, or its description.
        scene: A shipped scene's name or a file; None for the empty one.

    Returns:
        Whether it is, or the first difference.

    Raises:
        PlannercheckError: If a file can't be read.
    """
    from plannercheck.motions.proof_confirmation import confirm_model  # needs all of the package
    from plannercheck.proofs.well_formed import check_well_formed

    began, fault = time.perf_counter(), None
    try:
        check_well_formed(proof)
        assert isinstance(proof.model, Model)
        confirm_model(proof.model, robot, scene)
    except UnprovedError as found:
        fault = str(found)
    return Verification(fault is None, fault, 0, time.perf_counter() - began)
