"""What compares the model in a proof with a robot's and a scene's files, by the kind of proof.

In: a comparison for each kind, from the package's face, above all folders. Out: the comparison, for
`plannercheck.proofs.verify`. Loading the files takes all of the package, while proofs stand on `common` alone.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

# Of a proof's model, a robot, a scene (None for the empty one), what meshes of the scene are, what those of the robot
# are, and how mesh files are read (None for what the files say); raises at the first difference.
Comparison: TypeAlias = Callable[[Any, Any, str | None, Any, Any, Any], None]

_comparisons: dict[str, Comparison] = {}


def set_model_comparison(kind: str, comparison: Comparison) -> None:
    """Sets what compares the models of proofs of a kind, "space" or "plane"."""
    _comparisons[kind] = comparison


def model_comparison(kind: str) -> Comparison:
    """What compares the models of proofs of a kind, "space" or "plane"."""
    return _comparisons[kind]
