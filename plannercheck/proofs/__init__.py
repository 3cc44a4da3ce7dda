"""Proofs of motions that anyone can check: plain data, and a verifier independent of the code that makes them.

`explain_motion(...).proof` and `certify_motions` return `Proof`s. `Proof.verify` confirms a proof in ball arithmetic
(python-flint) without the compiled core; `Proof.save` and `load_proofs` write and read it as JSON or npz. Proofs about
pairs of links, for all configurations within the limits, are `PairProofs` (`link_pairs.py`, `pair_checks.py`).
"""

from plannercheck.proofs.data import Entry, Hashes, Joint, Link, Model, Motion, PosedBody, Verification
from plannercheck.proofs.files import save_proofs
from plannercheck.proofs.link_pairs import PairProofs, load_pair_proofs, save_pair_proofs
from plannercheck.proofs.pair_checks import verify_pairs
from plannercheck.proofs.proof import Proof, load_proofs, verify_path, verify_trajectory

__all__ = [
    "Entry",
    "Hashes",
    "Joint",
    "Link",
    "Model",
    "Motion",
    "PairProofs",
    "PosedBody",
    "Proof",
    "Verification",
    "load_pair_proofs",
    "load_proofs",
    "save_pair_proofs",
    "save_proofs",
    "verify_pairs",
    "verify_path",
    "verify_trajectory",
]
