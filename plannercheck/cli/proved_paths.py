"""`plannercheck validate --path --certify`: a path's motions proved, and the proofs written for anyone to check.

In: a checker, a path that it finds free. Out: a file of proofs, one for each motion, all confirmed by the verifier; or
the reason why there is no file.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from plannercheck.checking.protocols import AnyChecker
from plannercheck.cli.common import check_folder
from plannercheck.common.errors import PlannercheckError
from plannercheck.common.motion_paths import MotionPath
from plannercheck.proofs import Proof, save_proofs
from plannercheck.validation.paths import how_moved

# What is added to the name of a path's file, its suffix replaced.
_SUFFIX = ".proof.json"


@runtime_checkable
class ProvingChecker(Protocol):
    """A checker that proves motions."""

    def certify_motions(
        self, q0: ArrayLike, q1: ArrayLike, tolerance: float = ..., **how: Any
    ) -> tuple[Proof | None, ...]:
        """A proof a motion, None where it is not free."""


@dataclass(frozen=True)
class PathProof:
    """The result of proving a path.

    Attributes:
        file: Path of the proof, or the path that it would have.
        motions: Number of motions that are proved.
        entries: In all proofs.
        fault: What stopped it; None if the file is written.
    """

    file: Path
    motions: int
    entries: int
    fault: str | None

    @property
    def written(self) -> bool:
        """Whether there is a file, with every motion confirmed."""
        return self.fault is None

    @property
    def as_json(self) -> dict[str, Any]:
        """As JSON has it."""
        file = str(self.file) if self.written else None
        return {"proof": file, "proof_fault": self.fault, "proof_entries": self.entries}

    @property
    def sentence(self) -> str:
        """For the terminal."""
        if self.fault is not None:
            return f"not certified, nothing written: {self.fault}"
        return f"certified: {self.entries} entries confirmed in ball arithmetic, written to {self.file}"


def proof_file(path: Path, given: Path | None) -> Path:
    """Where the proof of a path is written."""
    return given if given is not None else path.with_suffix(_SUFFIX)


def check_proof_file(file: Path, inputs: Iterable[Path]) -> None:
    """Raises, before long work, if a proof can't be written there or would replace an input."""
    check_folder(file)
    if file.suffix not in (".json", ".npz"):
        raise PlannercheckError(f"--proof must end in .json or .npz, not {str(file)!r}")
    if file.exists() and any(path.exists() and file.samefile(path) for path in inputs):
        raise PlannercheckError(f"the proof would replace the path {str(file)!r}: choose another file by --proof")


def write_proof(
    checker: AnyChecker, path: NDArray[np.float64], tolerance: float, file: Path, motion_path: MotionPath = "screw"
) -> PathProof:
    """Proves the motions of a path (k, nq) and writes the proofs, if the verifier confirms them all."""
    starts, ends = (path[:-1], path[1:]) if len(path) > 1 else (path, path)
    if not isinstance(checker, ProvingChecker):
        raise PlannercheckError(f"there are no proofs of motions of {checker.robot.name!r}: leave --certify out")
    found = checker.certify_motions(starts, ends, tolerance=tolerance, **how_moved(checker, motion_path))
    return write_proofs(found, file, "motion")


def write_proofs(found: Iterable[Proof | None] | None, file: Path, thing: str) -> PathProof:
    """Writes the proofs of a path's motions, or of a trajectory's pieces, if the verifier confirms them all."""
    proofs: list[Proof] = []
    entries = 0
    for k, proof in enumerate((None,) if found is None else found):
        if proof is None:
            return PathProof(file, k, entries, f"{thing} {k} is free, but only so far as pairs that can't meet count")
        confirmed = proof.verify()
        if not confirmed:
            return PathProof(file, k, entries, f"{thing} {k}: {confirmed.fault}")
        proofs.append(proof)
        entries += confirmed.entries
    save_proofs(proofs, file)
    return PathProof(file, len(proofs), entries, None)
