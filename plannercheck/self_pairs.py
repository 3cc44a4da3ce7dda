"""Which of a robot's bodies are tested against each other.

In: Pinocchio's geometry model, an SRDF, the tree of links, disabled pairs. Out: index pairs into the robot's
bodies. With an SRDF they are exactly those that Pinocchio keeps: all pairs on different joints less the
disabled. Without one, adjacent links are left out too. Pairs that a robot's YAML disables are left out in
either case.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from plannercheck.errors import PlannercheckError, unknown_name
from plannercheck.robot_files import DisabledPair
from plannercheck.shapes import Body
from plannercheck.srdf import disabled_link_names, read_srdf
from plannercheck.urdf import LinkTree


def self_pairs(
    model: pin.Model,
    geometry: pin.GeometryModel,
    bodies: tuple[Body, ...],
    srdf: Path | None,
    tree: LinkTree,
    disabled: Iterable[DisabledPair],
) -> NDArray[np.int64]:
    """Index pairs (k, 2) into the robot's bodies, in Pinocchio's order."""
    geometry.addAllCollisionPairs()
    before = len(geometry.collisionPairs)
    if srdf is not None:
        try:
            pin.removeCollisionPairs(model, geometry, str(srdf), False)
        except RuntimeError as error:
            raise PlannercheckError(f"SRDF {srdf}: its disabled collisions can't be read: {error}") from None
        if len(geometry.collisionPairs) == before:
            warnings.warn(
                f"SRDF {srdf} disables no pair of links{_of_another(srdf, tree)}: adjacent ones, which usually touch, "
                "are tested as well",
                RuntimeWarning,
                stacklevel=5,
            )
    left_out = _disabled_links(disabled, tree)
    if srdf is None:
        left_out |= {frozenset(pair) for pair in tree.parents.items()}
    pairs = [(pair.first, pair.second) for pair in geometry.collisionPairs]
    kept = [(a, b) for a, b in pairs if frozenset((bodies[a].link, bodies[b].link)) not in left_out]
    return np.array(kept, dtype=np.int64).reshape(-1, 2)


def _of_another(srdf: Path, tree: LinkTree) -> str:
    """Words if an SRDF speaks of other links than the robot has."""
    unknown = [name for name in disabled_link_names(read_srdf(srdf)) if name not in tree.names]
    return f" of this robot, but of {', '.join(unknown[:3])}, which it has not" if unknown else ""


def _disabled_links(disabled: Iterable[DisabledPair], tree: LinkTree) -> set[frozenset[str | None]]:
    pairs: set[frozenset[str | None]] = set()
    for pair in disabled:
        for link in (pair.link_a, pair.link_b):
            if link not in tree.names:
                raise unknown_name("link in disabled_pairs", link, tree.names)
        pairs.add(frozenset((pair.link_a, pair.link_b)))
    return pairs
