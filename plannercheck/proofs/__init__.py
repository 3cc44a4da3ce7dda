"""Proofs of motions that anyone can check: plain data, and a verifier independent of the code that makes them.

`explain_motion(...).proof` and `certify_motions` return `Proof`s. `Proof.verify` confirms a proof in ball arithmetic
(python-flint) without the compiled core; `Proof.save` and `load_proofs` write and read it as JSON or npz.
"""

from plannercheck.proofs.data import Entry, Hashes, Joint, Link, Model, Motion, PosedBody, Verification
from plannercheck.proofs.files import save_proofs
from plannercheck.proofs.proof import Proof, load_proofs, verify_path, verify_trajectory

__all__ = [
    "Entry",
    "Hashes",
    "Joint",
    "Link",
    "Model",
    "Motion",
    "PosedBody",
    "Proof",
    "Verification",
    "load_proofs",
    "save_proofs",
    "verify_path",
    "verify_trajectory",
]
