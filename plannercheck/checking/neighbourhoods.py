"""Some frames of a long chain, posed against each other without the joints that all of them hang on.

In: a joint table with frames, some of the frames. Out: `Neighbourhood`, compiled kinematics of the joints from where
the frames fork outwards, so that what it takes depends on how far apart they are, not on how long the chain is.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from plannercheck.common.core import core
from plannercheck.robots.kinematics import JointTable

Floats = NDArray[np.float64]

# What a joint table has a row of for each joint, besides its parent.
_OF_JOINTS = ("kinds", "axes", "placements", "columns", "multipliers", "offsets")


class Neighbourhood(NamedTuple):
    """Some frames of `Chains`, posed against each other.

    Attributes:
        kernel: Compiled kinematics, from a frame that all of them have in common.
        place: By frame, where it is among the kernel's.
    """

    kernel: Any
    place: dict[int, int]

    def poses(self, q: Floats) -> Floats:
        """(n, frames, 4, 4) at configurations (n, nq)."""
        return np.asarray(self.kernel.link_poses(q, np.ones(len(self.place), dtype=np.uint8)))


def neighbourhood(table: JointTable, wanted: Sequence[int]) -> Neighbourhood:
    """Kinematics of some frames against each other.

    Args:
        table: Its links are the frames.
        wanted: Frames, ascending.

    Returns:
        The joints that move them against each other, and the last one that they have in common.
    """
    hung: list[int] = table.link_joints[list(wanted)].tolist()
    parents: list[int] = table.parents.tolist()
    ends = set(hung)
    while len(ends) > 1:  # parents come first, so that the last joint can't be what the others hang on
        ends.add(parents[last := max(ends)])
        ends.remove(last)
    (fork,) = ends
    known: set[int] = set()
    for joint in hung:
        while joint >= max(fork, 0) and joint not in known:
            known.add(joint)
            joint = parents[joint]
    kept = sorted(known)
    place = {joint: k for k, joint in enumerate(kept)}
    rows: dict[str, Any] = {name: np.ascontiguousarray(getattr(table, name)[kept]) for name in _OF_JOINTS}
    part = table._replace(
        **rows,
        parents=np.array([place.get(parents[joint], -1) for joint in kept], dtype=np.int32),
        link_joints=np.array([place.get(joint, -1) for joint in hung], dtype=np.int32),
        link_placements=np.ascontiguousarray(table.link_placements[list(wanted)]),
    )
    return Neighbourhood(core.Kinematics(*part), {frame: k for k, frame in enumerate(wanted)})
