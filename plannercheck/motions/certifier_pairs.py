"""Pairs of bodies with the joints between them, compiled: what the core certifies motions with.

In: a robot, its bodies, some of a checker's pairs. Out: `ChainedPairs`, the core's certifier of just these pairs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from plannercheck.bodies.certificates import Separation
from plannercheck.bodies.intersection import certify_posed
from plannercheck.bodies.polytope import Polytope
from plannercheck.bodies.shapes import Body
from plannercheck.checking.compiled_pairs import CompiledPairs, mounted
from plannercheck.common.core import core
from plannercheck.motions.joint_chains import motion_chains
from plannercheck.robots.robot import Robot

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]

# Two bodies that never move against each other and are further apart than this, m, are so at every configuration:
# far above the rounding of kinematics.
_LASTING_GAP = 1e-9


class ChainedPairs:
    """The core's certifier of some pairs.

    Attributes:
        core: The compiled certifier, of the pairs that move against each other.
        rows: (k,) which of the checker's pairs these are.
        flipped: (k,) whether their bodies are taken the other way round.
        frames: (k,) the link in whose frame each is seen, -1 for the world.
        touching: Rows of the checker's pairs that never move against each other, and are in contact.
    """

    def __init__(
        self, robot: Robot, bodies: Sequence[Body], pairs: Ints, part: CompiledPairs, excess: float, hints: bool
    ) -> None:
        """Digests chains of joints.

        Args:
            robot: The robot, posed by the compiled kernel.
            bodies: The robot's, then the scene's.
            pairs: (n, 2) indices into bodies: all of the checker's.
            part: Which of them to take.
            excess: Of curved shapes.
            hints: Whether planes of earlier motions are tried.
        """
        assert robot.joint_table is not None
        mounts, placements = mounted(robot, bodies, robot.kinematics)
        links: list[int] = mounts.tolist()
        table = _ordered(pairs[part.rows], links)
        moving = np.array([links[a] >= 0 for a, _ in table.tolist()], dtype=bool)
        polytopes = part.polytopes
        self.rows = part.rows[moving]
        self.flipped = (table[:, 0] != pairs[part.rows, 0])[moving]
        resting = np.flatnonzero(~moving).tolist()
        self.touching = [int(part.rows[k]) for k in resting if not _lastingly_apart(table[k], polytopes, placements)]
        chains = motion_chains(
            robot.model,
            robot.configuration_map,
            robot.joint_table,
            robot.frames,
            bodies,
            links,
            table[moving].astype(np.int64),
            excess,
        )
        self.frames = [pair.frame for pair in chains.pairs]
        live = sorted(polytopes)
        position = np.full(len(bodies), -1, dtype=np.int32)
        position[live] = np.arange(len(live))
        rows, *arrays = chains.arrays()
        rows[:, :2] = position[rows[:, :2].astype(np.int64)]
        self.core = core.MotionCertifier(
            [polytopes[k].core for k in live],
            np.array([links[k] for k in live], dtype=np.int32),
            np.ascontiguousarray(placements[live]),
            rows,
            *arrays,
            robot.nq,
            len(robot.link_names),
            chains.defect,
            chains.leverage,
            chains.depth,
            *chains.spread,
            hints,
        )


def _ordered(pairs: NDArray[np.int32], links: Sequence[int]) -> NDArray[np.int32]:
    """Pairs with a body that moves first, if there is one."""
    table = pairs.copy()
    swapped = np.array([links[a] < 0 <= links[b] for a, b in pairs.tolist()], dtype=bool)
    table[swapped] = table[swapped][:, ::-1]
    return table


def _lastingly_apart(pair: NDArray[np.int32], polytopes: Mapping[int, Polytope], poses: Floats) -> bool:
    a, b = pair.tolist()
    certificate = certify_posed(polytopes[a], polytopes[b], poses[a], poses[b])
    return isinstance(certificate, Separation) and certificate.gap > _LASTING_GAP
